//! The single measures and their summaries.

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::babbling::random_posture;
use crate::creature::{Creature, DofKind};
use crate::ground_truth::GroundTruth;
use crate::kinematics::{Chain, limb_frames};
use crate::schema::BodySchema;
use crate::senses::Touch;
use crate::skin::Skin;

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

/// One held-out error.
#[derive(Clone, Debug)]
pub struct HeldOutError {
    /// The limb of the skin point, and the limb in whose frame it is expressed.
    pub limbs: [usize; 2],
    /// The joints between them.
    pub joints: Vec<usize>,
    /// Distance between where the schema and where the truth puts the point, millimetres.
    pub millimetres: f64,
}

/// At [`HELD_OUT_POSTURES`] random postures, a random skin point of a random limb in the frame of another
/// random limb, learned against true.
pub fn held_out(
    creature: &Creature,
    skin: &Skin,
    truth: &GroundTruth,
    schema: &BodySchema,
) -> Vec<HeldOutError> {
    let mut rng = ChaCha8Rng::seed_from_u64(HELD_OUT_SEED);
    let mut on_limb = vec![Vec::new(); creature.limbs().len()];
    for (r, receptor) in skin.receptors.iter().enumerate() {
        on_limb[receptor.limb].push(r);
    }
    let limbs: Vec<usize> = (0..on_limb.len()).filter(|&limb| !on_limb[limb].is_empty()).collect();
    if limbs.len() < 2 {
        return Vec::new();
    }
    let mut errors = Vec::with_capacity(HELD_OUT_POSTURES);
    for _ in 0..HELD_OUT_POSTURES {
        let posture = random_posture(creature, &mut rng);
        let from = rng.random_range(0..limbs.len());
        let to = (from + rng.random_range(1..limbs.len())) % limbs.len();
        let (a, b) = (limbs[from], limbs[to]);
        let receptor = &skin.receptors[on_limb[a][rng.random_range(0..on_limb[a].len())]];
        let [u, v] = receptor.half_extents.map(|half| half * rng.random_range(-1.0..1.0));
        let p_a = receptor.position + receptor.tangent * u + receptor.bitangent() * v;
        let land = |schema: &BodySchema| {
            let frames = limb_frames(creature, schema, &posture);
            frames[b].inverse_point(&frames[a].point(&p_a))
        };
        let millimetres = 1e3 * (land(schema) - land(&truth.schema)).norm();
        let joints = Chain::between(creature, a, b).joints().collect();
        errors.push(HeldOutError { limbs: [a, b], joints, millimetres });
    }
    errors
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

/// The errors of the axes of all joints that are not undetermined.
pub fn axis_errors(
    creature: &Creature,
    truth: &GroundTruth,
    schema: &BodySchema,
    undetermined: &[usize],
) -> Vec<AxisErrors> {
    let mut errors = Vec::new();
    for (j, joint) in creature.joints().iter().enumerate() {
        if undetermined.contains(&j) {
            continue;
        }
        for (k, dof) in joint.dof_indices().zip(&joint.dofs).filter(|(_, dof)| dof.kind != DofKind::Ball) {
            let (learned, right) = (&schema.axes[k], &truth.schema.axes[k]);
            let offset = schema.positions[j] - truth.schema.positions[j];
            let degrees = learned.cross(right).norm().atan2(learned.dot(right)).to_degrees();
            let line = (dof.kind == DofKind::Hinge).then(|| 1e3 * line_distance(&offset, learned, right));
            errors.push(AxisErrors { dof: k, degrees, line_millimetres: line });
        }
    }
    errors
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
pub fn touch_misses(creature: &Creature, skin: &Skin, schema: &BodySchema, touches: &[Touch]) -> Summary {
    let miss = |touch: &Touch| {
        let frames = limb_frames(creature, schema, &touch.posture);
        let [a, b] = touch.ends.map(|end| frames[skin.receptors[end.receptor].limb].point(&end.contact));
        1e3 * (a - b).norm()
    };
    Summary::of(touches.iter().map(miss))
}
