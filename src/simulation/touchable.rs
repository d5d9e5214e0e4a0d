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
}

/// Two geoms that are about to meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encounter {
    /// The geoms.
    pub geoms: [usize; 2],
    /// Whether their gap is exact, or only a lower bound.
    pub exact: bool,
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
        for g in 0..body.model.ngeom() {
            let Some(limb) = body.limb_of_geom(g) else { continue };
            let Some(bound) = bounded(body, g) else { continue };
            by_limb[limb].push(bounds.len() as u32);
            bounds.push(bound);
        }
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
        let mut pairs = Vec::new();
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
                let geoms: Vec<[u32; 2]> = all.filter(collide).collect();
                if geoms.is_empty() {
                    continue;
                }
                let chain = Chain::between(creature, first.limb, second.limb);
                let levers = [(0, first), (1, second)]
                    .map(|(side, cluster)| levers(schema, &slide_reach, &chain.sides[side], &cluster.ball));
                pairs.push(ClusterPair {
                    clusters: [i, j],
                    limbs: [first.limb, second.limb],
                    ancestor: chain.ancestor,
                    levers,
                    geoms,
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
        Encounter { geoms, exact, pair, bounds: ends }
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
    Some(BoundedGeom {
        geom: g,
        capsule: Capsule { ends: capsule.ends.map(place), radius: capsule.radius },
        reach: capsule.bounding_ball().radius,
        exact: shape.as_capsule(&Frame::identity()).is_some(),
        solid: surface_of_geom(body, g).filter(|surface| surface.shape.is_solid()),
    })
}
