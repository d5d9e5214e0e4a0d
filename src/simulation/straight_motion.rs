//! A motion straight from one posture to another: every coordinate changes at a constant rate.

use nalgebra::{Matrix3, Vector3};

use crate::creature::{Creature, DofKind, Joint, Posture, ball};
use crate::kinematics::{DofTransform, LimbMotion, limb_motions_into, rotation};
use crate::schema::BodySchema;

/// How one degree of freedom moves from start to target, in radians or metres per unit of the motion.
#[derive(Clone, Copy, Debug)]
enum DofPath {
    Hinge { start: f64, rate: f64 },
    Slide { start: f64, rate: f64 },
    Ball { start: Matrix3<f64>, axis: Vector3<f64>, rate: f64 },
}

/// A motion of a creature whose joints are where a schema has them; it begins at 0 and ends at 1.
#[derive(Clone, Debug)]
pub(super) struct StraightMotion {
    creature: Creature,
    schema: BodySchema,
    /// How strongly neighbouring degrees of freedom of one joint turn about the same axis: per degree of
    /// freedom, |a_k · a_(k+1)|.
    alike: Vec<f64>,
    start: Posture,
    target: Posture,
    paths: Vec<DofPath>,
    /// Per degree of freedom, what it does where limbs were placed last.
    transforms: Vec<DofTransform>,
}

impl StraightMotion {
    /// As yet without a start and a target.
    pub fn new(creature: Creature, schema: BodySchema) -> StraightMotion {
        let mut alike = vec![1.0; creature.dof_elements()];
        for joint in creature.joints() {
            for k in joint.dof_indices().skip(1) {
                let both = [k - 1, k].map(|k| creature.dofs().nth(k).map(|dof| dof.kind));
                if both == [Some(DofKind::Hinge); 2] {
                    alike[k - 1] = schema.axes[k - 1].dot(&schema.axes[k]).abs();
                }
            }
        }
        let [start, target] = [0; 2].map(|_| Posture::reference(&creature));
        StraightMotion { creature, schema, alike, start, target, paths: Vec::new(), transforms: Vec::new() }
    }

    /// Sets out from `start` to `target`.
    pub fn begin(&mut self, start: &[f64], target: &[f64]) {
        (self.start, self.target) = (Posture::from(start), Posture::from(target));
        self.paths.clear();
        for at in self.creature.elements() {
            let q = at.coordinate();
            self.paths.push(match at.kind {
                DofKind::Hinge => DofPath::Hinge { start: start[q], rate: target[q] - start[q] },
                DofKind::Slide => DofPath::Slide { start: start[q], rate: target[q] - start[q] },
                DofKind::Ball => {
                    let (from, to) = (ball(at.of(start)), ball(at.of(target)));
                    let (axis, rate) = (to * from.inverse())
                        .axis_angle()
                        .map_or((Vector3::x(), 0.0), |(axis, angle)| (axis.into_inner(), angle));
                    DofPath::Ball { start: from.to_rotation_matrix().into_inner(), axis, rate }
                }
            });
        }
    }

    /// Per joint, how fast it turns (radians) and shifts (metres per unit) at the most.
    pub fn joint_speeds(&self) -> Vec<(f64, f64)> {
        self.creature.joints().iter().map(|joint| self.joint_speed(joint)).collect()
    }

    fn joint_speed(&self, joint: &Joint) -> (f64, f64) {
        let (mut squared, mut shift) = (0.0, 0.0);
        let turning = |k: usize| match self.paths[k] {
            DofPath::Hinge { rate, .. } | DofPath::Ball { rate, .. } => rate.abs(),
            DofPath::Slide { .. } => 0.0,
        };
        for k in joint.dof_indices() {
            squared += turning(k) * turning(k);
            for later in k + 1..joint.dof_indices().end {
                // Consecutive axes keep their angle; others may come to lie along each other.
                let alike = if later == k + 1 { self.alike[k] } else { 1.0 };
                squared += 2.0 * alike * turning(k) * turning(later);
            }
            if let DofPath::Slide { rate, .. } = self.paths[k] {
                shift += rate.abs();
            }
        }
        (squared.sqrt(), shift)
    }

    /// The posture at `t`.
    pub fn posture(&self, t: f64) -> Posture {
        Posture::between(&self.creature, &self.start, &self.target, t)
    }

    /// Poses and motions of all limbs at `t`, in the root's frame.
    pub fn place_limbs(&mut self, t: f64, limbs: &mut Vec<LimbMotion>) {
        // All sines first: unlike poses, they need not wait for each other.
        self.transforms.clear();
        self.transforms.extend(self.paths.iter().map(|path| match path {
            DofPath::Hinge { start, rate } => DofTransform::hinge(start + t * rate),
            DofPath::Slide { start, rate } => DofTransform::Slide { distance: start + t * rate },
            DofPath::Ball { start, axis, rate } => {
                let (sine, cosine) = (t * rate).sin_cos();
                DofTransform::Ball { rotation: rotation(axis, sine, 1.0 - cosine) * start }
            }
        }));
        let rate = |k: usize| match &self.paths[k] {
            DofPath::Hinge { rate, .. } | DofPath::Slide { rate, .. } => (self.schema.axes[k], *rate),
            DofPath::Ball { axis, rate, .. } => (*axis, *rate),
        };
        limb_motions_into(&self.creature, &self.schema, &self.transforms, rate, limbs);
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;

    use super::*;
    use crate::creature::Dof;
    use crate::kinematics::limb_frames;

    /// A chain of limbs on a hinge, a slide with a hinge, and a ball.
    fn chain() -> (Creature, BodySchema) {
        let range = |kind| if kind == DofKind::Ball { [0.0, 1.0] } else { [-1.0, 1.0] };
        let dof = |name: &str, kind| Dof { name: name.into(), kind, range: range(kind), follows: None };
        let joints = vec![
            Joint::new("hinge", 0, vec![dof("yaw", DofKind::Hinge)]),
            Joint::new("rail", 1, vec![dof("shift", DofKind::Slide), dof("turn", DofKind::Hinge)]),
            Joint::new("ball", 2, vec![dof("any", DofKind::Ball)]),
        ];
        let limbs = ["root", "arm", "cart", "hand"].map(String::from).to_vec();
        let creature = Creature::new("chain".into(), limbs, joints, Vec::new()).unwrap();
        let mut schema = BodySchema::zero(&creature);
        for (k, position) in schema.positions.iter_mut().enumerate() {
            *position = Vector3::new(0.3, 0.1 * k as f64, -0.2);
        }
        let axes = [[0.0, 0.6, 0.8], [1.0, 0.0, 0.0], [0.48, -0.36, 0.8], [0.0, 0.0, 0.0]];
        schema.axes = axes.map(Vector3::from).to_vec();
        (creature, schema)
    }

    #[test]
    fn limbs_are_where_the_posture_has_them_and_move_as_fast_as_they_change_their_place() {
        let (creature, schema) = chain();
        let [start, target] = [0.4, -0.8].map(|angle| {
            let q = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -angle, 0.9));
            vec![angle, 0.5 * angle, -angle, q.w, q.i, q.j, q.k]
        });
        let mut motion = StraightMotion::new(creature.clone(), schema.clone());
        motion.begin(&start, &target);
        const STEP: f64 = 1e-5;
        let mut limbs = Vec::new();
        for t in [0.0, 0.3, 1.0] {
            motion.place_limbs(t, &mut limbs);
            let [before, now, after] =
                [t - STEP, t, t + STEP].map(|t| limb_frames(&creature, &schema, &motion.posture(t)));
            for (limb, found) in limbs.iter().enumerate() {
                for p_l in [Vector3::zeros(), Vector3::new(0.1, -0.2, 0.3)] {
                    let p = found.frame.point(&p_l);
                    assert!((p - now[limb].point(&p_l)).norm() < 1e-14);
                    let velocity = (after[limb].point(&p_l) - before[limb].point(&p_l)) / (2.0 * STEP);
                    let told = found.twist.at(&p);
                    assert!((told - velocity).norm() < 1e-8, "limb {limb} at {t}: {told} for {velocity}");
                }
            }
        }
        assert!(motion.posture(1.0).iter().zip(&target).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}
