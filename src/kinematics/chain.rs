//! The chain of transforms between two limbs, and where a point lands along it.
//!
//! A chain from limb A to limb B climbs to their common ancestor C and descends from there (IVA 2009,
//! figures 3 and 5). All that a touch tells is symmetric in the two, so both points are carried up to C,
//! where `p_CA = X_CA p_A` and `p_CB = X_CB p_B` must meet. Nothing is inverted: the chain stays valid,
//! and its derivative polynomial, when the axes are relaxed from unit length.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use super::forward::{DofTransform, carry_through, joint_transforms};
use super::rotation::axis_derivative;
use crate::creature::Creature;
use crate::geometry::Frame;
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

/// One side of a chain at one posture: joints from the ancestor outwards, each a position and its
/// degrees of freedom. Learners keep a touch in several sets: its copies share this.
#[derive(Clone, Debug, Default)]
pub struct ChainSide {
    /// Joint and the number of its steps.
    joints: Arc<[(usize, usize)]>,
    /// Degree of freedom, and what it does.
    steps: Arc<[(usize, DofTransform)]>,
}

impl ChainSide {
    /// Prepares the side `joints` (ancestor first) at `posture`.
    pub fn new(creature: &Creature, joints: &[usize], posture: &[f64]) -> ChainSide {
        let joints = joints.iter().map(|&j| (j, &creature.joints()[j]));
        let counts = joints.clone().map(|(j, joint)| (j, joint.dofs.len())).collect();
        let mut steps = Vec::new();
        joints.for_each(|(_, joint)| steps.extend(joint_transforms(joint, posture)));
        ChainSide { joints: counts, steps: steps.into() }
    }

    /// The same side in a posture in which each joint is as on another of some sides like it, `of` says which of them by the
    /// joint's place: a posture that may never have been.
    pub fn mixed<'a>(&self, of: impl Fn(usize) -> &'a ChainSide) -> ChainSide {
        let mut steps = Vec::with_capacity(self.steps.len());
        let mut first = 0;
        for (place, (_, count)) in self.joints.iter().enumerate() {
            steps.extend_from_slice(&of(place).steps[first..first + count]);
            first += count;
        }
        ChainSide { joints: self.joints.clone(), steps: steps.into() }
    }

    /// `X_CL`: the pose of the limb at the end of the side in its ancestor.
    pub fn frame(&self, schema: &BodySchema) -> Frame {
        self.walk(schema, |_, _, _| {})
    }

    /// The same, past every degree of freedom with the frame just before it.
    #[inline]
    fn walk(&self, schema: &BodySchema, mut visit: impl FnMut(usize, &DofTransform, &Frame)) -> Frame {
        let mut frame = Frame::identity();
        let mut steps = self.steps.iter().map(|(dof, transform)| (*dof, transform));
        for &(joint, count) in self.joints.iter() {
            carry_through(schema, joint, steps.by_ref().take(count), &mut frame, &mut visit);
        }
        frame
    }

    /// `∂p_C/∂q` of a limb's point `p_l` by every hinge's angle, and by turns of every ball about three axes, in metres a radian,
    /// added to `derivatives` with the degree of freedom. Axes are of unit length.
    pub fn angle_derivatives(
        &self,
        schema: &BodySchema,
        p_l: &Vector3<f64>,
        derivatives: &mut Vec<(usize, Vector3<f64>)>,
    ) {
        let p_c = self.frame(schema).point(p_l);
        // The point as seen from each step on, in C: its offset from the joint, turned about the axis there.
        self.walk(schema, |dof, transform, frame| {
            let arm = p_c - frame.origin;
            match transform {
                DofTransform::Hinge { .. } => {
                    derivatives.push((dof, frame.direction(&schema.axes[dof]).cross(&arm)));
                }
                DofTransform::Ball { .. } => {
                    let about = |axis: Vector3<f64>| (dof, axis.cross(&arm));
                    derivatives.extend(frame.rotation.column_iter().map(|axis| about(axis.into_owned())));
                }
                DofTransform::Slide { .. } => {}
            }
        });
    }

    /// The same side with each of its hinges turned on by the next of some angles, each ball about three axes by the next three:
    /// those of [`angle_derivatives`](ChainSide::angle_derivatives), radians.
    pub fn turned(&self, angles: &mut impl Iterator<Item = f64>) -> ChainSide {
        let turned = |(dof, transform): &(usize, DofTransform)| (*dof, transform.turned_on(angles));
        ChainSide { joints: self.joints.clone(), steps: self.steps.iter().map(turned).collect() }
    }

    /// `p_C = X_CL p_L` and its derivatives by every position, axis and limb's pose of the side, into `jacobian`.
    pub fn point_jacobian(&self, schema: &BodySchema, p_l: &Vector3<f64>, jacobian: &mut SideJacobian) {
        jacobian.joints.clear();
        jacobian.dofs.clear();
        jacobian.poses.clear();
        // Outwards: the linear map from each step to C.
        let mut steps = self.steps.iter();
        let mut map = Matrix3::identity();
        for &(joint, count) in self.joints.iter() {
            jacobian.joints.push((joint, map));
            for (dof, transform) in steps.by_ref().take(count) {
                jacobian.dofs.push((*dof, map));
                map = transform.turned(&schema.axes[*dof], map);
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
                let (dof, transform) = &self.steps[k];
                let axis = &schema.axes[*dof];
                let derivative = &mut jacobian.dofs[k].1;
                match transform {
                    DofTransform::Hinge { sine, versine } => {
                        *derivative *= axis_derivative(axis, *sine, *versine, &p);
                        let cross = axis.cross(&p);
                        p += cross * *sine + axis.cross(&cross) * *versine;
                    }
                    DofTransform::Slide { distance } => {
                        *derivative *= *distance;
                        p += axis * *distance;
                    }
                    DofTransform::Ball { rotation } => {
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
