//! The single measures and their summaries.

use nalgebra::Vector3;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::agent::Agent;
use crate::creature::{Creature, DofKind, Posture};
use crate::geometry::Frame;
use crate::ground_truth::GroundTruth;
use crate::kinematics::{Chain, ChainSide, limb_frames};
use crate::schema::BodySchema;
use crate::senses::RecordedTouch;

/// Postures at which the held-out error is taken.
pub const HELD_OUT_POSTURES: usize = 2000;
/// Seed of the held-out postures: the same for every session, and no session's own.
const HELD_OUT_SEED: u64 = 0x5eed_0f7e_57ed;

/// A distribution of errors in a few numbers; all NaN (null in JSON) when there is none.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Arithmetic mean.
    pub mean: f64,
    /// Middle value.
    pub median: f64,
    /// The value that 95 % do not exceed.
    pub p95: f64,
    /// Greatest value.
    pub max: f64,
}

impl Summary {
    /// Summarises values.
    pub fn of(values: impl Iterator<Item = f64>) -> Summary {
        let mut sorted: Vec<f64> = values.collect();
        sorted.sort_by(f64::total_cmp);
        if sorted.is_empty() {
            return Summary { mean: f64::NAN, median: f64::NAN, p95: f64::NAN, max: f64::NAN };
        }
        let quantile = |q: f64| {
            let at = q * (sorted.len() - 1) as f64;
            let (low, share) = (at.floor() as usize, at.fract());
            let high = (low + 1).min(sorted.len() - 1);
            sorted[low] * (1.0 - share) + sorted[high] * share
        };
        Summary {
            mean: sorted.iter().sum::<f64>() / sorted.len() as f64,
            median: quantile(0.5),
            p95: quantile(0.95),
            max: quantile(1.0),
        }
    }
}

/// One place at which the held-out error is taken.
#[derive(Clone, Debug)]
pub struct HeldOutPoint {
    /// Posture coordinates, in the creature's order.
    pub posture: Posture,
    /// The limb of the skin point, and the limb in whose frame it is expressed.
    pub limbs: [usize; 2],
    /// The skin point in its own limb's frame, metres.
    pub p_a: Vector3<f64>,
}

/// At [`HELD_OUT_POSTURES`] random postures, a random skin point of a limb, to be expressed in the frame of another: all pairs
/// of limbs in turn, in a random order. Always the same of one creature and skin.
pub fn held_out_points(agent: &Agent) -> Vec<HeldOutPoint> {
    let mut rng = ChaCha8Rng::seed_from_u64(HELD_OUT_SEED);
    let (skin, limbs) = (agent.skin(), agent.limbs_with_skin());
    let mut on_limb = vec![Vec::new(); agent.creature().limbs().len()];
    skin.receptors.iter().enumerate().for_each(|(number, receptor)| on_limb[receptor.limb].push(number));
    let beyond = |(n, &a): (usize, &usize)| limbs[n + 1..].iter().map(move |&b| [a, b]).collect::<Vec<_>>();
    let mut pairs: Vec<[usize; 2]> = limbs.iter().enumerate().flat_map(beyond).collect();
    pairs.shuffle(&mut rng);
    let mut points = Vec::with_capacity(HELD_OUT_POSTURES);
    for pair in pairs.into_iter().cycle().take(HELD_OUT_POSTURES) {
        let posture = Posture::random(agent.creature(), &mut rng);
        let [a, b] = if rng.random() { pair } else { [pair[1], pair[0]] };
        let receptor = &skin.receptors[on_limb[a][rng.random_range(0..on_limb[a].len())]];
        let [u, v] = receptor.half_extents.map(|half| half * rng.random_range(-1.0..1.0));
        let p_a = receptor.position + receptor.tangent * u + receptor.bitangent() * v;
        points.push(HeldOutPoint { posture, limbs: [a, b], p_a });
    }
    points
}

impl HeldOutPoint {
    /// `p_BA`: where a schema puts the point in the second limb's frame, metres.
    pub fn land(&self, creature: &Creature, schema: &BodySchema) -> Vector3<f64> {
        let frames = limb_frames(creature, schema, &self.posture);
        frames[self.limbs[1]].inverse_point(&frames[self.limbs[0]].point(&self.p_a))
    }
}

/// The errors at held-out points: the distances between where a schema and where the truth puts them, millimetres.
pub fn held_out(
    creature: &Creature,
    truth: &GroundTruth,
    schema: &BodySchema,
    points: &[HeldOutPoint],
) -> Vec<f64> {
    let off = |point: &HeldOutPoint| point.land(creature, schema) - point.land(creature, &truth.schema);
    points.iter().map(|point| 1e3 * off(point).norm()).collect()
}

/// How far one axis was learned wrong.
#[derive(Clone, Copy, Debug)]
pub struct AxisErrors {
    /// The axis, by its index.
    pub dof: usize,
    /// Angle between learned and true axis, degrees.
    pub degrees: f64,
    /// Distance between the learned and the true axis line, millimetres; none for a slide.
    pub line_millimetres: Option<f64>,
}

/// The errors of the axes of all joints that are not undetermined. Axes on limbs whose own frames are not known
/// are compared in that of a limb below.
pub fn axis_errors(
    creature: &Creature,
    truth: &GroundTruth,
    schema: &BodySchema,
    undetermined: &[usize],
    undetermined_limbs: &[usize],
) -> Vec<AxisErrors> {
    let mut errors = Vec::new();
    for (j, joint) in creature.joints().iter().enumerate() {
        if undetermined.contains(&j) {
            continue;
        }
        let [from_learned, from_true] =
            shared_frame(creature, schema, truth, joint.parent, undetermined_limbs);
        for (k, dof) in joint.dof_indices().zip(&joint.dofs).filter(|(_, dof)| dof.kind != DofKind::Ball) {
            let learned = &(from_learned.rotation * schema.axes[k]);
            let right = &(from_true.rotation * truth.schema.axes[k]);
            let offset =
                from_learned.point(&schema.positions[j]) - from_true.point(&truth.schema.positions[j]);
            let degrees = learned.cross(right).norm().atan2(learned.dot(right)).to_degrees();
            let line = (dof.kind == DofKind::Hinge).then(|| 1e3 * line_distance(&offset, learned, right));
            errors.push(AxisErrors { dof: k, degrees, line_millimetres: line });
        }
    }
    errors
}

/// The pose of a limb's frame, learned and true, in a frame that is the same in both: the limb's own, where that
/// is known. Where no touch told it, it is gauge freedom, and the next limb's below it, in the reference
/// posture, takes its place.
fn shared_frame(
    creature: &Creature,
    schema: &BodySchema,
    truth: &GroundTruth,
    limb: usize,
    undetermined_limbs: &[usize],
) -> [Frame; 2] {
    let posture = creature.reference_posture();
    let mut frames = [Frame::identity(); 2];
    let mut at = limb;
    while let Some(joint) = creature.joint_of(at)
        && (!schema.places(creature, at) || undetermined_limbs.contains(&at))
    {
        let side = ChainSide::new(creature, &[joint], &posture);
        frames = [side.frame(schema) * frames[0], side.frame(&truth.schema) * frames[1]];
        at = creature.joints()[joint].parent;
    }
    frames
}

/// Distance between two lines whose points differ by `offset`.
fn line_distance(offset: &Vector3<f64>, a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    let normal = a.cross(b);
    // Nearly parallel lines: the distance of a point of one from the other.
    match normal.try_normalize(1e-6) {
        Some(normal) => offset.dot(&normal).abs().max((offset - b * offset.dot(b)).norm().min(offset.norm())),
        None => (offset - b * offset.dot(b)).norm(),
    }
}

/// How far apart a schema puts the exact contact points of touches, millimetres.
pub fn touch_misses(agent: &Agent, schema: &BodySchema, touches: &[RecordedTouch]) -> Summary {
    let miss = |touch: &RecordedTouch| {
        let frames = limb_frames(agent.creature(), schema, &touch.posture);
        let (limbs, points) = (touch.limbs(agent.skin()), touch.exact_contact().points);
        let [a, b] = [0, 1].map(|k| frames[limbs[k]].point(&points[k]));
        1e3 * (a - b).norm()
    };
    Summary::of(touches.iter().map(miss))
}

/// How many touches each joint lies across, and how many are of each limb's skin.
pub fn touches_across(agent: &Agent, touches: &[RecordedTouch]) -> [Vec<usize>; 2] {
    let creature = agent.creature();
    let (mut of_joints, mut of_limbs) = (vec![0; creature.joints().len()], vec![0; creature.limbs().len()]);
    for [a, b] in touches.iter().map(|touch| touch.limbs(agent.skin())) {
        Chain::between(creature, a, b).joints().for_each(|joint| of_joints[joint] += 1);
        [a, b].into_iter().for_each(|limb| of_limbs[limb] += 1);
    }
    [of_joints, of_limbs]
}
