//! What of a body can touch what: its geoms with bounds about them, and the pairs of limbs whose geoms can meet.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Isometry3, Point3, Vector3};

use crate::creature::{Body, DofKind};
use crate::geometry::{Ball, Capsule, Frame, Shape, clusters};
use crate::kinematics::Chain;
use crate::schema::BodySchema;
use crate::skin::{Surface, surface_of_geom};

/// A limb's geoms are split into clusters of at most about this radius, metres.
const LARGEST_CLUSTER: f64 = 0.18;
/// A geom this far inside another of its limb is never reached, metres: far more than limbs are in each other where a
/// motion stops.
const BURIED: f64 = 1e-4;

/// A geom and a capsule about it.
#[derive(Clone, Debug)]
pub(super) struct BoundedGeom {
    geom: usize,
    /// In the limb's frame.
    pub capsule: Capsule,
    /// Radius of the ball about the whole capsule, metres.
    pub reach: f64,
    /// Whether the geom is its capsule.
    pub exact: bool,
    /// The geom itself; none where nothing is known of its shape.
    pub solid: Option<Surface>,
    /// How thick it is at least, metres; infinite where nothing is known of its shape.
    thickness: f64,
}

impl BoundedGeom {
    /// Whether the geom is inside another of the same limb, all around: what meets it meets the other before.
    fn is_buried_in(&self, other: &BoundedGeom) -> bool {
        let (Some(inner), Some(outer)) = (&self.solid, &other.solid) else { return false };
        // A convex shape holds all that is between points that it holds.
        let deep = self.capsule.radius + BURIED;
        let holds_capsule = || self.capsule.ends.iter().all(|end| outer.holds(end, deep));
        let pose = inner.pose();
        let holds = |corner: Vector3<f64>| outer.holds(&pose.point(&corner), BURIED);
        match inner.shape.hull() {
            Some(hull) => hull.vertices().iter().copied().all(holds),
            None if self.exact => holds_capsule(),
            None => holds_capsule() || corners(&inner.shape.half_bounds()).into_iter().all(holds),
        }
    }
}

/// Geoms of one limb that lie together.
#[derive(Clone, Debug)]
pub(super) struct LimbCluster {
    pub limb: usize,
    /// The geoms, as indices into the bounds.
    pub members: Vec<u32>,
    /// A ball about them in the limb's frame.
    pub ball: Ball,
}

/// One joint on one side of a pair, as seen from the limb at the end of that side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lever {
    pub joint: usize,
    /// The farthest that any point of the limb's geoms can be from the joint, metres.
    pub reach: f64,
}

/// Two clusters that can touch.
#[derive(Clone, Debug)]
pub(super) struct ClusterPair {
    pub clusters: [usize; 2],
    pub limbs: [usize; 2],
    pub ancestor: usize,
    /// Per side, the joints from the ancestor outwards.
    pub levers: [Vec<Lever>; 2],
    /// The geom pairs, as indices into the bounds.
    pub geoms: Vec<[u32; 2]>,
    /// The number of the first of them among those of all pairs.
    pub first_geoms: usize,
}

/// Two geoms that are about to meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encounter {
    /// The geoms.
    pub geoms: [usize; 2],
    /// Whether their gap is exact, or only a lower bound.
    pub exact: bool,
    /// Half the thickness of the thinner one, metres: no motion of this length leads through.
    pub(super) short: f64,
    pub(super) pair: usize,
    pub(super) bounds: [u32; 2],
}

/// All that can touch on a body.
#[derive(Clone, Debug)]
pub(super) struct TouchablePairs {
    pub bounds: Vec<BoundedGeom>,
    pub clusters: Vec<LimbCluster>,
    pub pairs: Vec<ClusterPair>,
    /// Per pair of geoms that can touch, the lesser index first, their encounter.
    encounters: BTreeMap<[usize; 2], Encounter>,
}

impl TouchablePairs {
    /// The geoms that can touch by where a schema has the joints: those that the engine would let collide, on limbs that
    /// are not neighbours, but for the pairs `left_out`, the lesser index first.
    pub fn new(body: &Body, schema: &BodySchema, left_out: &BTreeSet<[usize; 2]>) -> TouchablePairs {
        let creature = &body.creature;
        let mut by_limb: Vec<Vec<u32>> = vec![Vec::new(); creature.limbs().len()];
        let mut bounds = Vec::new();
        for g in (0..body.model.ngeom()).filter(|&g| body.feels(g)) {
            let Some(limb) = body.limb_of_geom(g) else { continue };
            let Some(bound) = bounded(body, g) else { continue };
            by_limb[limb].push(bounds.len() as u32);
            bounds.push(bound);
        }
        let buried = buried(&bounds, &by_limb);
        let capsules: Vec<Capsule> = bounds.iter().map(|bound| bound.capsule).collect();
        let of_limb = |(limb, members): (usize, Vec<u32>)| {
            let found = clusters(members, &capsules, LARGEST_CLUSTER);
            found.into_iter().map(move |found| LimbCluster { limb, members: found.members, ball: found.ball })
        };
        let clusters: Vec<LimbCluster> = by_limb.into_iter().enumerate().flat_map(of_limb).collect();
        let slide_reach: Vec<f64> = creature
            .joints()
            .iter()
            .map(|joint| {
                let slides = joint.dofs.iter().filter(|dof| dof.kind == DofKind::Slide);
                slides.map(|dof| dof.range[0].abs().max(dof.range[1].abs())).sum()
            })
            .collect();
        let mut pairs: Vec<ClusterPair> = Vec::new();
        for (i, first) in clusters.iter().enumerate() {
            for (j, second) in clusters.iter().enumerate().skip(i + 1) {
                if creature.neighbouring(first.limb, second.limb) {
                    continue;
                }
                let collide = |pair: &[u32; 2]| {
                    let [g, h] = pair.map(|k| bounds[k as usize].geom);
                    body.model.collides(g, h) && !left_out.contains(&[g.min(h), g.max(h)])
                };
                let all = first.members.iter().flat_map(|&g| second.members.iter().map(move |&h| [g, h]));
                let met_before = |&[g, h]: &[u32; 2]| {
                    buried[g as usize].iter().any(|&outer| collide(&[outer, h]))
                        || buried[h as usize].iter().any(|&outer| collide(&[g, outer]))
                };
                let geoms: Vec<[u32; 2]> = all.filter(|pair| collide(pair) && !met_before(pair)).collect();
                if geoms.is_empty() {
                    continue;
                }
                let chain = Chain::between(creature, first.limb, second.limb);
                let levers = [(0, first), (1, second)]
                    .map(|(side, cluster)| levers(schema, &slide_reach, &chain.sides[side], &cluster.ball));
                let first_geoms = pairs.last().map_or(0, |pair| pair.first_geoms + pair.geoms.len());
                pairs.push(ClusterPair {
                    clusters: [i, j],
                    limbs: [first.limb, second.limb],
                    ancestor: chain.ancestor,
                    levers,
                    geoms,
                    first_geoms,
                });
            }
        }
        let mut found = TouchablePairs { bounds, clusters, pairs, encounters: BTreeMap::new() };
        for (pair, touching) in found.pairs.iter().enumerate() {
            for &ends in &touching.geoms {
                let met = found.encounter_of(pair, ends);
                let [a, b] = met.geoms;
                found.encounters.insert([a.min(b), a.max(b)], met);
            }
        }
        found
    }

    /// The encounter of two geoms, in either order; none where they cannot touch, or are joined.
    pub fn encounter(&self, [a, b]: [usize; 2]) -> Option<Encounter> {
        self.encounters.get(&[a.min(b), a.max(b)]).copied()
    }

    /// The encounter of two bounds of a pair.
    pub fn encounter_of(&self, pair: usize, ends: [u32; 2]) -> Encounter {
        let exact = ends.iter().all(|&i| self.bounds[i as usize].exact);
        let geoms = ends.map(|i| self.bounds[i as usize].geom);
        let thickness = ends.map(|i| self.bounds[i as usize].thickness);
        Encounter { geoms, exact, short: 0.5 * thickness[0].min(thickness[1]), pair, bounds: ends }
    }
}

/// Per joint of one side, ancestor first, how far the limb's geoms can be from it.
fn levers(schema: &BodySchema, slide_reach: &[f64], joints: &[usize], ball: &Ball) -> Vec<Lever> {
    let mut reach = ball.centre.norm() + ball.radius;
    let mut levers: Vec<Lever> = Vec::new();
    for &joint in joints.iter().rev() {
        reach += slide_reach[joint];
        levers.push(Lever { joint, reach });
        reach += schema.positions[joint].norm();
    }
    levers.reverse();
    levers
}

/// The corners of a box about the origin, by half its sides.
fn corners(half: &Vector3<f64>) -> [Vector3<f64>; 8] {
    std::array::from_fn(|k| {
        Vector3::from_fn(|axis, _| if k >> axis & 1 == 0 { half[axis] } else { -half[axis] })
    })
}

/// Per geom, those of its limb that it is buried in.
fn buried(bounds: &[BoundedGeom], by_limb: &[Vec<u32>]) -> Vec<Vec<u32>> {
    let mut buried = vec![Vec::new(); bounds.len()];
    for members in by_limb {
        for &inner in members {
            let bound = |k: u32| &bounds[k as usize];
            let is_outer = |&outer: &u32| {
                let smaller = bound(inner).reach < bound(outer).reach;
                outer != inner && smaller && bound(inner).is_buried_in(bound(outer))
            };
            buried[inner as usize] = members.iter().copied().filter(is_outer).collect();
        }
    }
    buried
}

/// A geom with the capsule about it in the frame of its limb; none for what has no bounds.
fn bounded(body: &Body, g: usize) -> Option<BoundedGeom> {
    let shape = Shape::of_geom(&body.model, g)?;
    // Of a mesh without a hull the vertices are known.
    let capsule = shape.bounding_capsule().unwrap_or_else(|| {
        let vertices = body.model.mesh_vertices(g);
        Capsule::about_box(&vertices.iter().fold(Vector3::zeros(), |half, v| half.sup(&v.abs())))
    });
    let geom = body.model.geom(g);
    let pose = body.pose_in_limb[geom.body] * Isometry3::from_parts(geom.pos.into(), geom.quat);
    let place = |end| (pose * Point3::from(end)).coords;
    let solid = surface_of_geom(body, g).filter(|surface| surface.shape.is_solid());
    Some(BoundedGeom {
        geom: g,
        capsule: Capsule { ends: capsule.ends.map(place), radius: capsule.radius },
        reach: capsule.bounding_ball().radius,
        exact: shape.as_capsule(&Frame::identity()).is_some(),
        thickness: solid.as_ref().map_or(f64::INFINITY, |solid| 2.0 * solid.shape.inradius()),
        solid,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::creature::JointSelection;
    use crate::ground_truth::GroundTruth;
    use crate::mujoco::Model;

    /// A box on a trunk and a hand on an arm of two hinges, with more geoms in the hand.
    fn touchable(more: &str, left_out: &BTreeSet<[usize; 2]>) -> TouchablePairs {
        let xml = format!(
            r#"<mujoco>
  <compiler autolimits="true"/>
  <asset><mesh name="grain" vertex="0 0 0 .02 0 0 0 .02 0 0 0 .02"/></asset>
  <worldbody><body name="trunk"><geom type="box" size=".1 .1 .1"/>
    <body name="arm" pos=".3 0 0"><joint axis="0 0 1" range="-90 90"/><geom size=".02"/>
      <body name="hand" pos=".3 0 0"><joint axis="0 1 0" range="-90 90"/>
        <geom type="box" size=".05 .06 .07"/>{more}
      </body>
    </body>
  </body></worldbody>
</mujoco>"#
        );
        let model = Model::from_xml(&xml).unwrap();
        let body = Body::new(std::sync::Arc::new(model), &JointSelection::All).unwrap();
        TouchablePairs::new(&body, &GroundTruth::new(&body).unwrap().schema, left_out)
    }

    fn geom_pairs(touchable: &TouchablePairs) -> Vec<[usize; 2]> {
        touchable.encounters.keys().copied().collect()
    }

    #[test]
    fn what_is_buried_in_another_geom_of_its_limb_meets_nothing() {
        // The trunk's box is geom 0, the hand's geom 2, what comes after it the others.
        let open = BTreeSet::new();
        assert_eq!(geom_pairs(&touchable("", &open)), [[0, 2]]);
        for inside in [
            r#"<geom size=".0498"/>"#,
            r#"<geom type="box" size=".0498 .0598 .0698"/>"#,
            r#"<geom type="ellipsoid" size=".04 .04 .06"/>"#,
            r#"<geom type="cylinder" size=".03 .06"/>"#,
            r#"<geom type="capsule" size=".03 .03"/>"#,
            r#"<geom type="mesh" mesh="grain"/>"#,
        ] {
            assert_eq!(geom_pairs(&touchable(inside, &open)), [[0, 2]], "{inside}");
            // Where the outer one overlaps by construction, the inner one is all there is to touch.
            let left_out = BTreeSet::from([[0, 2]]);
            assert_eq!(geom_pairs(&touchable(inside, &left_out)), [[0, 3]], "{inside}");
        }
        for outside in [
            r#"<geom size=".051"/>"#,
            r#"<geom type="box" size=".0498 .0598 .0701"/>"#,
            r#"<geom type="capsule" size=".03 .06"/>"#,
            r#"<geom type="mesh" mesh="grain" pos=".045 0 0"/>"#,
        ] {
            assert_eq!(geom_pairs(&touchable(outside, &open)), [[0, 2], [0, 3]], "{outside}");
        }
    }
}
