//! The chain of transforms between two limbs, and where a point lands along it.
//!
//! A chain from limb A to limb B climbs to their common ancestor C and descends from there (IVA 2009,
//! figures 3 and 5). All that a touch tells is symmetric in the two, so both points are carried up to C,
//! where `p_CA = X_CA p_A` and `p_CB = X_CB p_B` must meet. Nothing is inverted: the chain stays valid,
//! and its derivative polynomial, when the axes are relaxed from unit length.
//!
//! What every joint does is in [`ChainSide::frame`], the equation of a body schema:
//!
//! ```text
//! p_P = l_P + R(a_1, θ_1) … R(a_k, θ_k) (Q p_L + c)
//! ```
//!
//! where the limb's pose `(Q, c)` on its joint is the identity unless limbs have frames of their own.

use std::ops::Mul;

use nalgebra::{Isometry3, Matrix3, Quaternion, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::rotation::{axis_derivative, rotation};
use crate::creature::{Creature, DofKind};
use crate::schema::BodySchema;

/// The joints between two limbs and their common ancestor.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// The common ancestor limb C.
    pub ancestor: usize,
    /// Per end, the joints from C out to the limb.
    pub sides: [Vec<usize>; 2],
}

impl Chain {
    /// The chain between limbs `a` and `b`.
    pub fn between(creature: &Creature, a: usize, b: usize) -> Chain {
        let (mut x, mut y) = (a, b);
        let mut sides = [Vec::new(), Vec::new()];
        while x != y {
            // A limb comes after its parent, so the larger index cannot be an ancestor of the smaller.
            if x > y {
                sides[0].push(x - 1);
                x = creature.joints()[x - 1].parent;
            } else {
                sides[1].push(y - 1);
                y = creature.joints()[y - 1].parent;
            }
        }
        sides.iter_mut().for_each(|side| side.reverse());
        Chain { ancestor: x, sides }
    }

    /// All joints of the chain, both sides.
    pub fn joints(&self) -> impl Iterator<Item = usize> + Clone + '_ {
        self.sides.iter().flatten().copied()
    }
}

/// One degree of freedom at one posture, with what does not depend on the schema worked out.
#[derive(Clone, Debug)]
enum Motion {
    Hinge { sine: f64, versine: f64 },
    Slide { distance: f64 },
    Ball { rotation: Matrix3<f64> },
}

#[derive(Clone, Debug)]
struct Step {
    dof: usize,
    motion: Motion,
}

/// One side of a chain at one posture: joints from the ancestor outwards, each a position and its
/// degrees of freedom.
#[derive(Clone, Debug, Default)]
pub struct ChainSide {
    /// Joint and the number of its steps.
    joints: Vec<(usize, usize)>,
    steps: Vec<Step>,
}

impl ChainSide {
    /// Prepares the side `joints` (ancestor first) at `posture`.
    pub fn new(creature: &Creature, joints: &[usize], posture: &[f64]) -> ChainSide {
        let mut side = ChainSide::default();
        for &j in joints {
            let joint = &creature.joints()[j];
            side.joints.push((j, joint.dofs.len()));
            let mut coordinate = joint.first_coordinate();
            for (k, dof) in joint.dofs.iter().enumerate() {
                let q = &posture[coordinate..coordinate + dof.kind.coordinates()];
                let motion = match dof.kind {
                    DofKind::Hinge => Motion::Hinge { sine: q[0].sin(), versine: 1.0 - q[0].cos() },
                    DofKind::Slide => Motion::Slide { distance: q[0] },
                    DofKind::Ball => Motion::Ball { rotation: ball(q).to_rotation_matrix().into_inner() },
                };
                side.steps.push(Step { dof: joint.first_dof() + k, motion });
                coordinate += dof.kind.coordinates();
            }
        }
        side
    }

    /// `X_CL`: the pose of the limb at the end of the side in its ancestor.
    pub fn frame(&self, schema: &BodySchema) -> Frame {
        let mut frame = Frame::identity();
        let mut steps = self.steps.iter();
        for &(joint, count) in &self.joints {
            frame.origin += frame.rotation * schema.positions[joint];
            for step in steps.by_ref().take(count) {
                let axis = &schema.axes[step.dof];
                match &step.motion {
                    Motion::Hinge { sine, versine } => frame.rotation *= rotation(axis, *sine, *versine),
                    Motion::Slide { distance } => frame.origin += frame.rotation * axis * *distance,
                    Motion::Ball { rotation } => frame.rotation *= rotation,
                }
            }
            if let Some(pose) = schema.limb_poses.get(joint) {
                frame = frame * *pose;
            }
        }
        frame
    }

    /// `∂p_C/∂q` of a limb's point `p_l` by every hinge's angle, in metres a radian, added to `derivatives` with
    /// its degree of freedom. Axes are of unit length.
    pub fn angle_derivatives(
        &self,
        schema: &BodySchema,
        p_l: &Vector3<f64>,
        derivatives: &mut Vec<(usize, Vector3<f64>)>,
    ) {
        let p_c = self.frame(schema).point(p_l);
        // The point as seen from each step on, in C: its offset from the joint, turned about the axis there.
        let mut frame = Frame::identity();
        let mut steps = self.steps.iter();
        for &(joint, count) in &self.joints {
            frame.origin += frame.rotation * schema.positions[joint];
            for step in steps.by_ref().take(count) {
                let axis = &schema.axes[step.dof];
                match &step.motion {
                    Motion::Hinge { sine, versine } => {
                        let axis_c = frame.rotation * axis;
                        derivatives.push((step.dof, axis_c.cross(&(p_c - frame.origin))));
                        frame.rotation *= rotation(axis, *sine, *versine);
                    }
                    Motion::Slide { distance } => frame.origin += frame.rotation * axis * *distance,
                    Motion::Ball { rotation } => frame.rotation *= rotation,
                }
            }
            if let Some(pose) = schema.limb_poses.get(joint) {
                frame = frame * *pose;
            }
        }
    }

    /// `p_C = X_CL p_L` and its derivatives by every position, axis and limb's pose of the side, into `jacobian`.
    pub fn point_jacobian(&self, schema: &BodySchema, p_l: &Vector3<f64>, jacobian: &mut SideJacobian) {
        jacobian.joints.clear();
        jacobian.dofs.clear();
        jacobian.poses.clear();
        // Outwards: the linear map from each step to C.
        let mut steps = self.steps.iter();
        let mut map = Matrix3::identity();
        for &(joint, count) in &self.joints {
            jacobian.joints.push((joint, map));
            for step in steps.by_ref().take(count) {
                jacobian.dofs.push((step.dof, map));
                match &step.motion {
                    Motion::Hinge { sine, versine } => {
                        map *= rotation(&schema.axes[step.dof], *sine, *versine);
                    }
                    Motion::Slide { .. } => {}
                    Motion::Ball { rotation } => map *= rotation,
                }
            }
            if let Some(pose) = schema.limb_poses.get(joint) {
                jacobian.poses.push(PoseJacobian { joint, map, point: Vector3::zeros() });
                map *= pose.rotation;
            }
        }
        jacobian.rotation = map;
        // Inwards: the point as each step meets it.
        let mut p = *p_l;
        let mut k = self.steps.len();
        for (number, &(joint, count)) in self.joints.iter().enumerate().rev() {
            if let Some(pose) = schema.limb_poses.get(joint) {
                jacobian.poses[number].point = p;
                p = pose.point(&p);
            }
            for _ in 0..count {
                k -= 1;
                let axis = &schema.axes[self.steps[k].dof];
                let derivative = &mut jacobian.dofs[k].1;
                match &self.steps[k].motion {
                    Motion::Hinge { sine, versine } => {
                        *derivative *= axis_derivative(axis, *sine, *versine, &p);
                        let cross = axis.cross(&p);
                        p += cross * *sine + axis.cross(&cross) * *versine;
                    }
                    Motion::Slide { distance } => {
                        *derivative *= *distance;
                        p += axis * *distance;
                    }
                    Motion::Ball { rotation } => {
                        derivative.fill(0.0);
                        p = rotation * p;
                    }
                }
            }
            p += schema.positions[joint];
        }
        jacobian.position = p;
    }
}

/// What [`ChainSide::point_jacobian`] finds; kept by the caller so that its buffers are used again.
#[derive(Clone, Debug, Default)]
pub struct SideJacobian {
    /// `p_C`.
    pub position: Vector3<f64>,
    /// `R_CL`.
    pub rotation: Matrix3<f64>,
    /// Per joint, `∂p_C/∂l_P` (which is `R_CP`).
    pub joints: Vec<(usize, Matrix3<f64>)>,
    /// Per degree of freedom, `∂p_C/∂a_P` for an axis that is free in R³.
    pub dofs: Vec<(usize, Matrix3<f64>)>,
    /// Per joint, what tells `∂p_C` by its limb's pose; empty where limbs' frames are those of their joints.
    pub poses: Vec<PoseJacobian>,
}

/// How a point on the ancestor moves with the pose `(Q, c)` of a limb on its joint:
/// `∂p_C = map (∂Q point + ∂c)`.
#[derive(Clone, Copy, Debug)]
pub struct PoseJacobian {
    /// The joint.
    pub joint: usize,
    /// `∂p_C/∂c`: from the joint's side of the pose to C.
    pub map: Matrix3<f64>,
    /// The point in the limb's own frame, metres.
    pub point: Vector3<f64>,
}

/// A pose `X_AB`: where frame B is in frame A.
///
/// The rotation is a plain matrix, not an orthonormal type: with relaxed axes it need not be one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Rotation `R_AB`.
    pub rotation: Matrix3<f64>,
    /// Origin `p_AB_A` in metres.
    pub origin: Vector3<f64>,
}

impl Frame {
    /// The pose of a frame in itself.
    pub fn identity() -> Frame {
        Frame { rotation: Matrix3::identity(), origin: Vector3::zeros() }
    }

    /// `p_A = X_AB p_B`.
    pub fn point(&self, p_b: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * p_b + self.origin
    }

    /// `p_B = X_AB⁻¹ p_A`, for an orthonormal rotation.
    pub fn inverse_point(&self, p_a: &Vector3<f64>) -> Vector3<f64> {
        self.rotation.tr_mul(&(p_a - self.origin))
    }

    /// `X_BA`, for an orthonormal rotation.
    pub fn inverse(&self) -> Frame {
        Frame { rotation: self.rotation.transpose(), origin: -self.rotation.tr_mul(&self.origin) }
    }
}

impl From<Isometry3<f64>> for Frame {
    fn from(pose: Isometry3<f64>) -> Frame {
        Frame { rotation: pose.rotation.to_rotation_matrix().into_inner(), origin: pose.translation.vector }
    }
}

/// `X_AC = X_AB X_BC`.
impl Mul for Frame {
    type Output = Frame;

    fn mul(self, inner: Frame) -> Frame {
        Frame { rotation: self.rotation * inner.rotation, origin: self.point(&inner.origin) }
    }
}

/// `X_RL` of every limb in the root limb's frame, at `posture`.
pub fn limb_frames(creature: &Creature, schema: &BodySchema, posture: &[f64]) -> Vec<Frame> {
    let mut frames = vec![Frame::identity(); creature.limbs().len()];
    for (j, joint) in creature.joints().iter().enumerate() {
        frames[j + 1] = frames[joint.parent] * ChainSide::new(creature, &[j], posture).frame(schema);
    }
    frames
}

/// A ball joint's rotation from its posture coordinates w x y z.
pub(crate) fn ball(q: &[f64]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3]))
}
