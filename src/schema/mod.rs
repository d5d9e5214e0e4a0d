//! The body schema: the learned joint positions and axes.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::creature::{Creature, DofKind, Joint};
use crate::geometry::Frame;

/// Joint positions and axes of a creature, in the order of its joints and degrees of freedom.
///
/// A point fixed to the limb that joint i carries lies, on the parent limb P, at
/// `p_P = l_P + R(a_1, θ_1) … R(a_k, θ_k) (Q p_L + c)` (a slide adds `a s` in place of its rotation).
///
/// The limb's pose `(Q, c)` on its joint is the identity where limbs' frames are those of their joints: with
/// their origins there and, in the reference posture, parallel to their parents'. Limbs may have frames of
/// their own in place of these, as a robot's have; then their poses are learned as well.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodySchema {
    /// Per joint `l_P`: its position in the parent limb's frame, metres.
    pub positions: Vec<Vector3<f64>>,
    /// Per degree of freedom `a_P`: its unit axis, in the limb's frame before the degree of freedom
    /// turns, which in the reference posture is parallel to the parent's. Zero for a ball, which has none.
    pub axes: Vec<Vector3<f64>>,
    /// Per joint `(Q, c)`: the pose of its limb's own frame in the frame of the joint, metres. Empty where
    /// limbs' frames are those of their joints.
    #[serde(default)]
    pub limb_poses: Vec<Frame>,
}

/// How sure a schema is: standard deviations of its positions and axes, in the same order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SchemaStd {
    /// Per joint, of each coordinate of `l_P`, metres; `None` if nothing determines it, zero where it was known exactly.
    pub positions: Vec<[Option<f64>; 3]>,
    /// Per degree of freedom, of each of the two coordinates of `a_P` across its direction, radians; `None`
    /// if nothing determines it and for a ball.
    pub axes: Vec<Option<f64>>,
}

impl BodySchema {
    /// A schema of the creature's shape with zero positions and zero axes.
    pub fn zero(creature: &Creature) -> BodySchema {
        BodySchema {
            positions: vec![Vector3::zeros(); creature.joints().len()],
            axes: vec![Vector3::zeros(); creature.dof_elements()],
            limb_poses: Vec::new(),
        }
    }

    /// The same body with all lengths so many times as long.
    pub(crate) fn scaled(&self, by: f64) -> BodySchema {
        let pose = |pose: &Frame| Frame { rotation: pose.rotation, origin: by * pose.origin };
        BodySchema {
            positions: self.positions.iter().map(|position| by * position).collect(),
            axes: self.axes.clone(),
            limb_poses: self.limb_poses.iter().map(pose).collect(),
        }
    }

    /// The same body with every limb in a frame of its own, as yet that of its joint.
    pub fn with_limb_poses(mut self) -> BodySchema {
        self.limb_poses.resize(self.positions.len(), Frame::identity());
        self
    }

    /// Scales every axis to unit length; an axis of length zero becomes z.
    pub fn normalize_axes(&mut self, creature: &Creature) {
        for (axis, dof) in self.axes.iter_mut().zip(creature.dofs()) {
            if dof.kind != DofKind::Ball {
                *axis = axis.try_normalize(1e-12).unwrap_or(Vector3::z());
            }
        }
    }

    /// Makes the rotation of every limb's pose one: the nearest to the matrix that it is, by the sum of
    /// squares (Kabsch 1976).
    pub fn normalize_limb_poses(&mut self) {
        self.limb_poses.iter_mut().for_each(|pose| pose.rotation = nearest_rotation(&pose.rotation));
    }

    /// Whether it is known where a limb's own frame is: of all limbs, unless limbs have frames of their own and
    /// this one was left in its joint's. The root's is where all begins.
    pub fn places(&self, creature: &Creature, limb: usize) -> bool {
        let pose = creature.joint_of(limb).and_then(|joint| self.limb_poses.get(joint));
        pose.is_none_or(|pose| *pose != Frame::identity())
    }

    /// Describes the body with limb `limb` in another frame of its own, whose pose in the present one is
    /// `pose`: the body stays as it is. [`BodySchema::limb_poses`] must be there.
    pub fn reframe(&mut self, creature: &Creature, limb: usize, pose: &Frame) {
        if let Some(joint) = creature.joint_of(limb) {
            self.limb_poses[joint] = self.limb_poses[joint] * *pose;
        }
        let turn = pose.rotation.transpose();
        for (j, joint) in creature.joints().iter().enumerate().filter(|(_, joint)| joint.parent == limb) {
            self.positions[j] = pose.inverse_point(&self.positions[j]);
            self.axes[joint.dof_indices()].iter_mut().for_each(|axis| *axis = turn * *axis);
            let carried = &mut self.limb_poses[j];
            *carried = Frame { rotation: turn, origin: Vector3::zeros() } * *carried;
        }
    }

    /// Of all descriptions of one body in the same frames of limbs, takes the one in which no limb's origin
    /// `c` is shifted along what its joint cannot feel: the axis of a single hinge, and every direction
    /// where there is no hinge. The joint's position is shifted in its place.
    pub fn settle_positions(&mut self, creature: &Creature) {
        for ((joint, pose), position) in
            creature.joints().iter().zip(&mut self.limb_poses).zip(&mut self.positions)
        {
            let unfelt = unfelt_shifts(creature, joint, &self.axes) * pose.origin;
            *position += unfelt;
            pose.origin -= unfelt;
        }
    }

    /// Whether the schema has as many positions and axes as the creature, all of them finite.
    pub fn fits(&self, creature: &Creature) -> bool {
        self.positions.len() == creature.joints().len()
            && self.axes.len() == creature.dof_elements()
            && (self.limb_poses.is_empty() || self.limb_poses.len() == creature.joints().len())
            && self.positions.iter().chain(&self.axes).all(|v| v.iter().all(|x| x.is_finite()))
            && self
                .limb_poses
                .iter()
                .all(|pose| pose.rotation.iter().chain(&pose.origin).all(|x| x.is_finite()))
    }
}

/// The projection onto the shifts `t` with `R(a, θ) t = t` for all angles of a joint: a joint that is shifted
/// by one, with its limb shifted back, is the same.
pub fn unfelt_shifts(creature: &Creature, joint: &Joint, axes: &[Vector3<f64>]) -> Matrix3<f64> {
    let mut turning =
        joint.dof_indices().zip(&joint.dofs).filter(|(_, dof)| dof.kind != DofKind::Slide).map(|(k, _)| k);
    debug_assert!(axes.len() == creature.dof_elements());
    match (turning.next(), turning.next()) {
        (None, _) => Matrix3::identity(),
        (Some(hinge), None) if axes[hinge].norm() > 0.0 => axes[hinge] * axes[hinge].transpose(),
        _ => Matrix3::zeros(),
    }
}

/// The rotation nearest to a matrix by the sum of squares.
pub fn nearest_rotation(matrix: &Matrix3<f64>) -> Matrix3<f64> {
    if !matrix.iter().all(|x| x.is_finite()) {
        return Matrix3::identity();
    }
    let found = matrix.svd(true, true);
    let (Some(u), Some(v_t)) = (found.u, found.v_t) else { return Matrix3::identity() };
    let mut sides = Matrix3::identity();
    // The direction that the matrix says least of decides which hand it is.
    let weakest = found.singular_values.imin();
    sides[(weakest, weakest)] = (u * v_t).determinant().signum();
    u * sides * v_t
}
