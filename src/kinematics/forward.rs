//! Forward kinematics: the poses and velocities of the limbs in a posture, from a schema.
//!
//! [`carry_through`] is what a joint does, the equation of a body schema:
//!
//! ```text
//! p_P = l_P + R(a_1, θ_1) … R(a_k, θ_k) (Q p_L + c)
//! ```
//!
//! where the limb's pose `(Q, c)` on its joint is the identity unless limbs have frames of their own. Whoever walks
//! along joints does so by it.

use std::borrow::Borrow;
use std::ops::Sub;

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::rotation::rotation;
use crate::creature::{Creature, DofKind, Joint, ball};
use crate::geometry::{Frame, product};
use crate::schema::BodySchema;

/// What one degree of freedom does at one value, with what does not depend on its axis worked out.
#[derive(Clone, Copy, Debug)]
pub(crate) enum DofTransform {
    /// A turn about the axis by an angle θ: sin θ and 1 − cos θ.
    Hinge { sine: f64, versine: f64 },
    /// A shift along the axis, metres.
    Slide { distance: f64 },
    /// A turn about any axis.
    Ball { rotation: Matrix3<f64> },
}

impl DofTransform {
    /// At the coordinates of a posture that begin with the degree of freedom's own.
    #[inline]
    pub fn at(kind: DofKind, q: &[f64]) -> DofTransform {
        match kind {
            DofKind::Hinge => DofTransform::hinge(q[0]),
            DofKind::Slide => DofTransform::Slide { distance: q[0] },
            DofKind::Ball => DofTransform::Ball { rotation: ball(q).to_rotation_matrix().into_inner() },
        }
    }

    /// A hinge at an angle, radians.
    #[inline]
    pub fn hinge(angle: f64) -> DofTransform {
        let (sine, cosine) = angle.sin_cos();
        DofTransform::Hinge { sine, versine: 1.0 - cosine }
    }

    /// The same, turned on by the next of some angles about its axis, or by three about those of the parent's side, radians.
    pub fn turned_on(&self, angles: &mut impl Iterator<Item = f64>) -> DofTransform {
        let mut next = || angles.next().unwrap_or(0.0);
        match *self {
            DofTransform::Hinge { sine, versine } => {
                let (cosine, (by_sine, by_cosine)) = (1.0 - versine, next().sin_cos());
                let turned = [sine * by_cosine + cosine * by_sine, cosine * by_cosine - sine * by_sine];
                DofTransform::Hinge { sine: turned[0], versine: 1.0 - turned[1] }
            }
            DofTransform::Slide { .. } => *self,
            DofTransform::Ball { rotation } => {
                let by = Rotation3::new(Vector3::from_fn(|_, _| next()));
                DofTransform::Ball { rotation: by.matrix() * rotation }
            }
        }
    }

    /// Carries a frame on the parent's side of the degree of freedom to its other side.
    #[inline(always)]
    pub fn carry(&self, axis: &Vector3<f64>, frame: &mut Frame) {
        match self {
            DofTransform::Slide { distance } => frame.origin += frame.direction(axis) * *distance,
            _ => frame.rotation = self.turned(axis, frame.rotation),
        }
    }

    /// Its rotation's part in the same: a rotation on the parent's side, carried to the other.
    // A tenth of learning's time is spent here: a call would cost as much again.
    #[inline(always)]
    pub fn turned(&self, axis: &Vector3<f64>, before: Matrix3<f64>) -> Matrix3<f64> {
        match self {
            DofTransform::Hinge { sine, versine } => product(&before, &rotation(axis, *sine, *versine)),
            DofTransform::Slide { .. } => before,
            DofTransform::Ball { rotation } => product(&before, rotation),
        }
    }
}

/// Carries the frame of a joint's parent limb, `X_CP`, to that of the limb that it carries, `X_CL`. `dofs` are the
/// joint's degrees of freedom in their order; `visit` sees each with the frame just before it.
#[inline]
pub(crate) fn carry_through(
    schema: &BodySchema,
    joint: usize,
    dofs: impl IntoIterator<Item = (usize, impl Borrow<DofTransform>)>,
    frame: &mut Frame,
    visit: impl FnMut(usize, &DofTransform, &Frame),
) {
    carry_past(schema, joint, dofs, frame, visit);
    if let Some(pose) = schema.limb_poses.get(joint) {
        *frame = *frame * *pose;
    }
}

/// The same as far as behind its degrees of freedom: the limb's pose on the joint is still to come.
#[inline]
pub(super) fn carry_past(
    schema: &BodySchema,
    joint: usize,
    dofs: impl IntoIterator<Item = (usize, impl Borrow<DofTransform>)>,
    frame: &mut Frame,
    mut visit: impl FnMut(usize, &DofTransform, &Frame),
) {
    frame.origin += frame.direction(&schema.positions[joint]);
    for (dof, transform) in dofs {
        let transform = transform.borrow();
        visit(dof, transform, frame);
        transform.carry(&schema.axes[dof], frame);
    }
}

/// A joint's degrees of freedom at a posture.
pub(crate) fn joint_transforms<'a>(
    joint: &'a Joint,
    posture: &'a [f64],
) -> impl Iterator<Item = (usize, DofTransform)> + 'a {
    joint.elements().map(|element| (element.axis(), DofTransform::at(element.kind, element.of(posture))))
}

/// `X_RL` of every limb in the root limb's frame, at `posture`.
pub fn limb_frames(creature: &Creature, schema: &BodySchema, posture: &[f64]) -> Vec<Frame> {
    let mut frames = Vec::with_capacity(creature.limbs().len());
    frames.push(Frame::identity());
    for (j, joint) in creature.joints().iter().enumerate() {
        let mut frame = frames[joint.parent];
        carry_through(schema, j, joint_transforms(joint, posture), &mut frame, |_, _, _| {});
        frames.push(frame);
    }
    frames
}

/// How a rigid body moves with time, or with one parameter: the velocity of a point `p` of it is `linear + angular × p`, all in
/// one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// Angular velocity, radians per unit.
    pub angular: Vector3<f64>,
    /// Velocity of the point of the body that is at the frame's origin, metres per unit.
    pub linear: Vector3<f64>,
}

impl Twist {
    /// Of what turns about an axis through a point.
    #[inline]
    pub fn turning(angular: Vector3<f64>, about: &Vector3<f64>) -> Twist {
        Twist { angular, linear: about.cross(&angular) }
    }

    /// Of what shifts without turning.
    #[inline]
    pub fn shifting(linear: Vector3<f64>) -> Twist {
        Twist { angular: Vector3::zeros(), linear }
    }

    /// The same so many times as fast.
    pub fn scaled(&self, by: f64) -> Twist {
        Twist { angular: self.angular * by, linear: self.linear * by }
    }

    /// The velocity of a point.
    #[inline]
    pub fn at(&self, p: &Vector3<f64>) -> Vector3<f64> {
        self.linear + self.angular.cross(p)
    }
}

impl Sub for Twist {
    type Output = Twist;

    #[inline]
    fn sub(self, other: Twist) -> Twist {
        Twist { angular: self.angular - other.angular, linear: self.linear - other.linear }
    }
}

/// A limb's pose `X_RL` and its motion in the root limb's frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct LimbMotion {
    /// `X_RL`.
    pub frame: Frame,
    /// Per unit of time.
    pub twist: Twist,
}

/// Poses and motions of all limbs, given per degree of freedom what it does, and the axis and rate of its change in the
/// frame before it: radians or metres per unit of time.
pub(crate) fn limb_motions_into(
    creature: &Creature,
    schema: &BodySchema,
    transforms: &[DofTransform],
    rate: impl Fn(usize) -> (Vector3<f64>, f64),
    motions: &mut Vec<LimbMotion>,
) {
    motions.clear();
    // The root rests.
    motions.push(LimbMotion::default());
    for (j, joint) in creature.joints().iter().enumerate() {
        let LimbMotion { mut frame, mut twist } = motions[joint.parent];
        let dofs = joint.dof_indices().map(|k| (k, &transforms[k]));
        carry_through(schema, j, dofs, &mut frame, |k, transform, before| {
            let (axis, rate) = rate(k);
            match transform {
                DofTransform::Slide { .. } => twist.linear += before.direction(&axis) * rate,
                DofTransform::Hinge { .. } | DofTransform::Ball { .. } => {
                    let turning = before.direction(&(axis * rate));
                    twist.angular += turning;
                    twist.linear -= turning.cross(&before.origin);
                }
            }
        });
        motions.push(LimbMotion { frame, twist });
    }
}
