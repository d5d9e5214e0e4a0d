//! Postures: random ones, and the one that bouts start from.

use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};
use rand::{Rng, RngExt};

use crate::creature::{Creature, DofKind};

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
    posture
}

/// The posture that every bout starts from: the reference posture, or as near to it as ranges allow.
pub fn start_posture(creature: &Creature) -> Vec<f64> {
    let mut posture = creature.reference_posture();
    let mut q = 0;
    for dof in creature.dofs() {
        if dof.kind != DofKind::Ball {
            posture[q] = posture[q].clamp(dof.range[0], dof.range[1]);
        }
        q += dof.kind.coordinates();
    }
    posture
}

/// A ball joint's rotation from its coordinates w x y z.
pub(super) fn ball(q: &[f64]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3]))
}
