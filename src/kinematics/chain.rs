//! The chain of transforms between two limbs, and where a point lands along it.
//!
//! A chain from limb A to limb B climbs to their common ancestor C and descends from there (IVA 2009,
//! figures 3 and 5). All that a touch tells is symmetric in the two, so both points are carried up to C,
//! where `p_CA = X_CA p_A` and `p_CB = X_CB p_B` must meet. Nothing is inverted: the chain stays valid,
//! and its derivative polynomial, when the axes are relaxed from unit length.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use super::forward::{DofTransform, carry_past, carry_through, joint_transforms};
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
        let (ancestor, limbs) = ways_apart(|limb| creature.joints()[limb - 1].parent, [a, b]);
        Chain { ancestor, sides: limbs.map(|way| way.into_iter().map(|limb| limb - 1).collect()) }
    }

    /// All joints of the chain, both sides.
    pub fn joints(&self) -> impl Iterator<Item = usize> + Clone + '_ {
        self.sides.iter().flatten().copied()
    }
}

/// The common ancestor of two nodes of a tree in which nodes come after their parents, and the ways from there to either,
/// ancestor's side first and without it.
pub fn ways_apart(parent: impl Fn(usize) -> usize, mut nodes: [usize; 2]) -> (usize, [Vec<usize>; 2]) {
    let mut ways = [Vec::new(), Vec::new()];
    while nodes[0] != nodes[1] {
        // The larger number cannot be an ancestor of the smaller.
        let side = usize::from(nodes[1] > nodes[0]);
        ways[side].push(nodes[side]);
        nodes[side] = parent(nodes[side]);
    }
    ways.iter_mut().for_each(|way| way.reverse());
    (nodes[0], ways)
}

/// One side of a chain at one posture: joints from the ancestor outwards, each a position and its
/// degrees of freedom. Learners keep a touch in several sets: its copies share this.
#[derive(Clone, Debug, Default)]
pub struct ChainSide {
    pieces: Arc<[ChainPiece]>,
    /// Degree of freedom, and what it does.
    steps: Arc<[(usize, DofTransform)]>,
}

/// A piece of a side.
#[derive(Clone, Debug)]
enum ChainPiece {
    /// A joint, with so many of the steps.
    Joint { joint: usize, steps: usize },
    /// Joints that are held, multiplied out: `X_PL` from before the first to behind the last.
    Held(Frame),
}

impl ChainSide {
    /// Prepares the side `joints` (ancestor first) at `posture`.
    pub fn new(creature: &Creature, joints: &[usize], posture: &[f64]) -> ChainSide {
        let joints = joints.iter().map(|&j| (j, &creature.joints()[j]));
        let pieces = joints.clone().map(|(j, joint)| ChainPiece::Joint { joint: j, steps: joint.dofs.len() });
        let pieces = pieces.collect();
        let mut steps = Vec::new();
        joints.for_each(|(_, joint)| steps.extend(joint_transforms(joint, posture)));
        ChainSide { pieces, steps: steps.into() }
    }

    /// The same side where some joints stay as a schema has them: they are multiplied out, and tell of themselves no more.
    pub fn with_held(&self, schema: &BodySchema, is_held: impl Fn(usize) -> bool) -> ChainSide {
        let (mut pieces, mut kept) = (Vec::new(), Vec::new());
        let mut rest = self.steps.as_ref();
        for piece in self.pieces.iter() {
            let (steps, after) = rest.split_at(piece.steps());
            rest = after;
            match (piece, pieces.last_mut()) {
                (ChainPiece::Joint { joint, .. }, _) if !is_held(*joint) => {
                    kept.extend_from_slice(steps);
                    pieces.push(piece.clone());
                }
                (_, Some(ChainPiece::Held(frame))) => piece.carry(schema, steps, frame, |_, _, _| {}),
                _ => {
                    let mut frame = Frame::identity();
                    piece.carry(schema, steps, &mut frame, |_, _, _| {});
                    pieces.push(ChainPiece::Held(frame));
                }
            }
        }
        ChainSide { pieces: pieces.into(), steps: kept.into() }
    }

    /// The same side in a posture in which each joint is as on another of some sides like it, `of` says which of them by the
    /// joint's place: a posture that may never have been.
    pub fn mixed<'a>(&self, of: impl Fn(usize) -> &'a ChainSide) -> ChainSide {
        let mut steps = Vec::with_capacity(self.steps.len());
        for (place, piece) in self.pieces.iter().enumerate() {
            steps.extend_from_slice(&of(place).steps[steps.len()..][..piece.steps()]);
        }
        ChainSide { pieces: self.pieces.clone(), steps: steps.into() }
    }

    /// `X_CL`: the pose of the limb at the end of the side in its ancestor.
    pub fn frame(&self, schema: &BodySchema) -> Frame {
        self.walk(schema, |_, _, _| {})
    }

    /// The same, past every degree of freedom with the frame just before it.
    #[inline]
    fn walk(&self, schema: &BodySchema, mut visit: impl FnMut(usize, &DofTransform, &Frame)) -> Frame {
        let mut frame = Frame::identity();
        let mut rest = self.steps.as_ref();
        for piece in self.pieces.iter() {
            let (steps, after) = rest.split_at(piece.steps());
            rest = after;
            piece.carry(schema, steps, &mut frame, &mut visit);
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
        ChainSide { pieces: self.pieces.clone(), steps: self.steps.iter().map(turned).collect() }
    }

    /// `p_C = X_CL p_L` and its derivatives by every position, axis and limb's pose of the side, into `jacobian`.
    pub fn point_jacobian(&self, schema: &BodySchema, p_l: &Vector3<f64>, jacobian: &mut SideJacobian) {
        self.outwards(schema, jacobian);
        self.inwards(schema, p_l, jacobian);
    }

    /// The first half of [`point_jacobian`](ChainSide::point_jacobian), which no point enters: the linear map from each step to C,
    /// and `X_CL`.
    pub fn outwards(&self, schema: &BodySchema, jacobian: &mut SideJacobian) {
        jacobian.joints.clear();
        jacobian.dofs.clear();
        jacobian.poses.clear();
        let mut frame = Frame::identity();
        let mut steps = self.steps.iter().map(|(dof, transform)| (*dof, transform));
        for piece in self.pieces.iter() {
            match *piece {
                ChainPiece::Held(held) => frame = frame * held,
                ChainPiece::Joint { joint, steps: count } => {
                    jacobian.joints.push((joint, frame.rotation));
                    carry_past(schema, joint, steps.by_ref().take(count), &mut frame, |dof, _, before| {
                        jacobian.dofs.push((dof, before.rotation));
                    });
                    if let Some(pose) = schema.limb_poses.get(joint) {
                        let map = frame.rotation;
                        jacobian.poses.push(PoseJacobian { joint, map, point: Vector3::zeros() });
                        frame = frame * *pose;
                    }
                }
            }
        }
        jacobian.frame = frame;
    }

    /// The second half: the point as each step meets it, from the limb to C.
    pub fn inwards(&self, schema: &BodySchema, p_l: &Vector3<f64>, jacobian: &mut SideJacobian) {
        let mut p = *p_l;
        let mut k = self.steps.len();
        let mut poses = jacobian.poses.iter_mut().rev();
        for piece in self.pieces.iter().rev() {
            let (joint, count) = match *piece {
                ChainPiece::Joint { joint, steps } => (joint, steps),
                ChainPiece::Held(held) => {
                    p = held.point(&p);
                    continue;
                }
            };
            if let Some(pose) = schema.limb_poses.get(joint) {
                poses.next().expect("one for each joint").point = p;
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

impl ChainPiece {
    /// How many of the side's steps are its own.
    fn steps(&self) -> usize {
        match self {
            ChainPiece::Joint { steps, .. } => *steps,
            ChainPiece::Held(_) => 0,
        }
    }

    /// Carries a frame from before it to behind it, past its steps.
    #[inline]
    fn carry(
        &self,
        schema: &BodySchema,
        steps: &[(usize, DofTransform)],
        frame: &mut Frame,
        visit: impl FnMut(usize, &DofTransform, &Frame),
    ) {
        match self {
            ChainPiece::Held(held) => *frame = *frame * *held,
            ChainPiece::Joint { joint, .. } => {
                let steps = steps.iter().map(|(dof, transform)| (*dof, transform));
                carry_through(schema, *joint, steps, frame, visit);
            }
        }
    }
}

/// What [`ChainSide::point_jacobian`] finds; kept by the caller so that its buffers are used again.
#[derive(Clone, Debug, Default)]
pub struct SideJacobian {
    /// `p_C`.
    pub position: Vector3<f64>,
    /// `X_CL`.
    pub frame: Frame,
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
