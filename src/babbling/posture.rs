//! Postures: random ones, and the one that bouts start from.

use nalgebra::{Unit, UnitQuaternion, Vector3};
use rand::{Rng, RngExt};

use crate::creature::{Creature, DofKind};
use crate::kinematics::ball;

/// A posture drawn uniformly from the joints' ranges.
pub fn random_posture(creature: &Creature, rng: &mut impl Rng) -> Vec<f64> {
    let mut posture = Vec::with_capacity(creature.coordinates());
    for dof in creature.dofs() {
        let [low, high] = dof.range;
        match dof.kind {
            DofKind::Hinge | DofKind::Slide => posture.push(low + (high - low) * rng.random::<f64>()),
            DofKind::Ball => {
                let axis = loop {
                    let v = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
                    let squared: f64 = v.norm_squared();
                    if squared > 1e-4 && squared < 1.0 {
                        break Unit::new_normalize(v);
                    }
                };
                let q = UnitQuaternion::from_axis_angle(&axis, high * rng.random::<f64>());
                posture.extend([q.w, q.i, q.j, q.k]);
            }
        }
    }
    creature.couple(&mut posture);
    posture
}

/// The posture that every bout starts from: the reference posture, or as near to it as ranges allow.
pub fn start_posture(creature: &Creature) -> Vec<f64> {
    let mut posture = creature.reference_posture();
    for (q, dof) in creature.dofs_in_posture().filter(|(_, dof)| dof.kind != DofKind::Ball) {
        posture[q] = posture[q].clamp(dof.range[0], dof.range[1]);
    }
    creature.couple(&mut posture);
    posture
}

/// The target as far as every ball can go straight towards it: two rotations within a ball's range may
/// have none of the rotations between them within it, and there the ball goes up to its limit.
pub(super) fn reachable(creature: &Creature, start: &[f64], target: &[f64]) -> Vec<f64> {
    let mut reached = target.to_vec();
    for (q, dof) in creature.dofs_in_posture().filter(|(_, dof)| dof.kind == DofKind::Ball) {
        let (from, to) = (ball(&start[q..]), ball(&target[q..]));
        if let Some((axis, angle)) = (to * from.inverse()).axis_angle() {
            let share = within(&from, &axis, angle, dof.range[1]);
            if share < 1.0 {
                let limit = UnitQuaternion::from_axis_angle(&axis, share * angle) * from;
                reached[q..q + 4].copy_from_slice(&[limit.w, limit.i, limit.j, limit.k]);
            }
        }
    }
    reached
}

/// The share of a turn about `axis` by `angle` that stays within rotations by at most `most`.
fn within(from: &UnitQuaternion<f64>, axis: &Unit<Vector3<f64>>, angle: f64, most: f64) -> f64 {
    if most >= std::f64::consts::PI {
        return 1.0;
    }
    // The cosine of half the whole angle runs as w cos(τ/2) − (axis · v) sin(τ/2) over the turn τ.
    let (w, v) = if from.w < 0.0 { (-from.w, -from.imag()) } else { (from.w, from.imag()) };
    let along = axis.dot(&v);
    let height = w.hypot(along);
    let least = (0.5 * most).cos();
    if height <= least {
        return 0.0;
    }
    let turn = 2.0 * ((least / height).acos() - along.atan2(w));
    (turn / angle).clamp(0.0, 1.0)
}

/// The posture a share of the way from one to another; balls turn about one axis.
pub(crate) fn between(creature: &Creature, from: &[f64], to: &[f64], share: f64) -> Vec<f64> {
    let mut posture: Vec<f64> = from.iter().zip(to).map(|(a, b)| a + share * (b - a)).collect();
    for (q, _) in creature.dofs_in_posture().filter(|(_, dof)| dof.kind == DofKind::Ball) {
        let (a, b) = (ball(&from[q..]), ball(&to[q..]));
        let turned = UnitQuaternion::from_scaled_axis((b * a.inverse()).scaled_axis() * share) * a;
        posture[q..q + 4].copy_from_slice(&[turned.w, turned.i, turned.j, turned.k]);
    }
    posture
}

/// How a coordinate drawn uniformly between −1 and 1 is spread towards its ends: the power of its amount.
const WIDE: f64 = 0.4;

/// A random posture that favours the ends of the ranges: what turns far tells most of its axis, and limbs
/// that are bent far meet more often. Balls are drawn as in [`random_posture`].
pub fn wide_posture(creature: &Creature, rng: &mut impl Rng) -> Vec<f64> {
    let mut posture = random_posture(creature, rng);
    for joint in creature.joints() {
        let mut q = joint.first_coordinate();
        for dof in &joint.dofs {
            let [low, high] = dof.range;
            if dof.kind != DofKind::Ball && high > low {
                let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
                let share = (posture[q] - middle) / half;
                posture[q] = (middle + half * share.signum() * share.abs().powf(WIDE)).clamp(low, high);
            }
            q += dof.kind.coordinates();
        }
    }
    creature.couple(&mut posture);
    posture
}
