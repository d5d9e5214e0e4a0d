//! Possible contacts of a body: its geoms with bounding volumes, and the pairs of limbs whose geoms can touch.

use std::collections::BTreeSet;
use std::ops::Range;

use nalgebra::{Point3, Vector3};

use super::sorted;
use crate::creature::{Body, Creature, DofKind};
use crate::geometry::{Ball, Capsule, Frame, Shape, clusters as clustered};
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
    /// The geom itself; `None` if nothing is known of its shape.
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
    /// The joints that move it, from the root outwards.
    pub levers: Vec<Lever>,
}

/// One joint that moves a limb's geoms, as seen from these.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lever {
    pub joint: usize,
    /// The farthest that any point of the limb's geoms can be from the joint, metres.
    pub reach: f64,
}

/// Two clusters that can touch. Of a body of a thousand limbs there are half a million.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClusterPair {
    pub clusters: [u32; 2],
    pub limbs: [u32; 2],
    pub ancestor: u32,
    /// Per side, which joints of its cluster are not beyond the ancestor: those from here on.
    inner: [u32; 2],
    /// The geom pairs among those of all pairs.
    geoms: [u32; 2],
}

impl ClusterPair {
    /// The two limbs.
    pub fn limbs(&self) -> [usize; 2] {
        self.limbs.map(|limb| limb as usize)
    }

    /// The two clusters.
    pub fn clusters(&self) -> [usize; 2] {
        self.clusters.map(|cluster| cluster as usize)
    }

    /// Where its geom pairs are among those of all pairs.
    pub fn geoms(&self) -> Range<usize> {
        self.geoms[0] as usize..self.geoms[1] as usize
    }
}

/// Two geoms that are about to meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encounter {
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
    /// The geom pairs of all pairs, one pair's after the other's, as indices into the bounds.
    pub geoms: Vec<[u32; 2]>,
    /// Per cluster, where the pairs begin of which it is the first; they are in the order of their second.
    first_pair: Vec<u32>,
    /// Per pair of geoms that can touch, in the order of the model's geoms, the lesser first: these, and their place among `geoms`.
    found: Vec<([usize; 2], u32)>,
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
        let slide_reach: Vec<f64> = creature
            .joints()
            .iter()
            .map(|joint| {
                let slides = joint.dofs.iter().filter(|dof| dof.kind == DofKind::Slide);
                slides.map(|dof| dof.range[0].abs().max(dof.range[1].abs())).sum()
            })
            .collect();
        let mut clusters: Vec<LimbCluster> = Vec::new();
        for (limb, members) in by_limb.into_iter().enumerate() {
            clusters.extend(clustered(members, &capsules, LARGEST_CLUSTER).into_iter().map(|found| {
                let levers = levers(schema, &slide_reach, creature, limb, &found.ball);
                LimbCluster { limb, members: found.members, ball: found.ball, levers }
            }));
        }
        let mut pairs: Vec<ClusterPair> = Vec::new();
        let mut geoms: Vec<[u32; 2]> = Vec::new();
        let mut first_pair = Vec::with_capacity(clusters.len() + 1);
        for (i, first) in clusters.iter().enumerate() {
            first_pair.push(pairs.len() as u32);
            for (j, second) in clusters.iter().enumerate().skip(i + 1) {
                if creature.neighbouring(first.limb, second.limb) {
                    continue;
                }
                let collide = |pair: &[u32; 2]| {
                    let [g, h] = pair.map(|k| bounds[k as usize].geom);
                    body.model.collides(g, h) && !left_out.contains(&sorted([g, h]))
                };
                let all = first.members.iter().flat_map(|&g| second.members.iter().map(move |&h| [g, h]));
                let met_before = |&[g, h]: &[u32; 2]| {
                    buried[g as usize].iter().any(|&outer| collide(&[outer, h]))
                        || buried[h as usize].iter().any(|&outer| collide(&[g, outer]))
                };
                let before = geoms.len();
                geoms.extend(all.filter(|pair| collide(pair) && !met_before(pair)));
                if geoms.len() == before {
                    continue;
                }
                let chain = Chain::between(creature, first.limb, second.limb);
                let inner =
                    [(0, first), (1, second)].map(|(side, of)| of.levers.len() - chain.sides[side].len());
                pairs.push(ClusterPair {
                    clusters: [i as u32, j as u32],
                    limbs: [first.limb as u32, second.limb as u32],
                    ancestor: chain.ancestor as u32,
                    inner: inner.map(|count| count as u32),
                    geoms: [before as u32, geoms.len() as u32],
                });
            }
        }
        first_pair.push(pairs.len() as u32);
        let of_model =
            |place: usize| (sorted(geoms[place].map(|bound| bounds[bound as usize].geom)), place as u32);
        let mut found: Vec<_> = (0..geoms.len()).map(of_model).collect();
        found.sort_unstable();
        TouchablePairs { bounds, clusters, pairs, geoms, first_pair, found }
    }

    /// The joints that move one side of a pair against its ancestor, from there outwards.
    pub fn levers(&self, pair: &ClusterPair, side: usize) -> &[Lever] {
        &self.clusters[pair.clusters[side] as usize].levers[pair.inner[side] as usize..]
    }

    /// The pair of two clusters, the lesser number first; `None` if they cannot touch.
    pub fn pair_of(&self, [first, second]: [usize; 2]) -> Option<usize> {
        let (begin, end) = (self.first_pair[first] as usize, self.first_pair[first + 1] as usize);
        let of_first = &self.pairs[begin..end];
        Some(begin + of_first.binary_search_by_key(&(second as u32), |pair| pair.clusters[1]).ok()?)
    }

    /// The encounter of two geoms, in either order; `None` if they cannot touch, or are joined.
    pub fn encounter(&self, geoms: [usize; 2]) -> Option<Encounter> {
        let at = self.found.binary_search_by_key(&sorted(geoms), |(geoms, _)| *geoms).ok()?;
        let place = self.found[at].1;
        let pair = self.pairs.partition_point(|pair| pair.geoms[1] <= place);
        Some(self.encounter_of(pair, self.geoms[place as usize]))
    }

    /// The encounter of two bounds of a pair.
    pub fn encounter_of(&self, pair: usize, ends: [u32; 2]) -> Encounter {
        let exact = ends.iter().all(|&i| self.bounds[i as usize].exact);
        let thickness = ends.map(|i| self.bounds[i as usize].thickness);
        Encounter { exact, short: 0.5 * thickness[0].min(thickness[1]), pair, bounds: ends }
    }
}

/// Per joint from the root to a limb, how far what is in a ball on it can be from the joint.
fn levers(
    schema: &BodySchema,
    slide_reach: &[f64],
    creature: &Creature,
    limb: usize,
    ball: &Ball,
) -> Vec<Lever> {
    let mut reach = ball.centre.norm() + ball.radius;
    let mut levers: Vec<Lever> = Vec::new();
    for &joint in Chain::between(creature, 0, limb).sides[1].iter().rev() {
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
    let pose = body.geom_in_limb(&geom);
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
        touchable.found.iter().map(|(geoms, _)| *geoms).collect()
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
