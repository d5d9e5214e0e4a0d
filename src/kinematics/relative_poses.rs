//! Limbs' poses in the frame of another limb, and their Jacobians.

use nalgebra::Vector3;

use super::chain::Chain;
use super::forward::{DofTransform, Twist, carry_through, joint_transforms};
use crate::creature::Creature;
use crate::geometry::Frame;
use crate::schema::BodySchema;

/// The poses of some limbs in the frame of another at any posture: what they share is computed once for all.
#[derive(Clone, Debug)]
pub struct RelativePoses<'a> {
    creature: &'a Creature,
    schema: &'a BodySchema,
    wrt: usize,
    limbs: Vec<MovedLimb>,
    /// The joints that carry any of them, parents first.
    joints: Vec<usize>,
    /// Per axis of the schema, the first column of its degree of freedom in a Jacobian.
    columns: Vec<usize>,
}

/// A limb, with the columns of what moves it relative to another one, and whether that carries it or the other one: 1 or −1.
#[derive(Clone, Debug)]
struct MovedLimb {
    limb: usize,
    columns: Vec<(usize, f64)>,
}

/// What a posture comes to in the root's frame; to be used again for the next one.
#[derive(Clone, Debug)]
pub struct PosedLimbs {
    /// Per limb its pose.
    frames: Vec<Frame>,
    /// Per column how what it moves moves.
    twists: Vec<Twist>,
}

impl<'a> RelativePoses<'a> {
    /// The poses of `limbs` in the frame of limb `wrt`.
    pub fn new(
        creature: &'a Creature,
        schema: &'a BodySchema,
        limbs: &[usize],
        wrt: usize,
    ) -> RelativePoses<'a> {
        let next = |column: &mut usize, dofs: usize| Some(std::mem::replace(column, *column + dofs));
        let mut columns: Vec<usize> = creature.dofs().map(|dof| dof.kind.dof()).scan(0, next).collect();
        columns.push(creature.dof());
        let to_root = |limb: usize| Chain::between(creature, 0, limb).sides[1].clone();
        let mut joints: Vec<usize> = limbs.iter().chain([&wrt]).flat_map(|&limb| to_root(limb)).collect();
        joints.sort_unstable();
        joints.dedup();
        let moved = |&limb: &usize| {
            let [of, by] = Chain::between(creature, limb, wrt).sides;
            let signs =
                of.into_iter().map(|joint| (joint, 1.0)).chain(by.into_iter().map(|joint| (joint, -1.0)));
            let of_joint = |(joint, sign): (usize, f64)| {
                let axes = creature.joints()[joint].dof_indices();
                (columns[axes.start]..columns[axes.end]).map(move |column| (column, sign))
            };
            MovedLimb { limb, columns: signs.flat_map(of_joint).collect() }
        };
        let limbs = limbs.iter().map(moved).collect();
        RelativePoses { creature, schema, wrt, limbs, joints, columns }
    }

    /// Room for what a posture comes to.
    pub fn room(&self) -> PosedLimbs {
        PosedLimbs {
            frames: vec![Frame::identity(); self.creature.limbs().len()],
            twists: vec![Twist::default(); self.creature.dof()],
        }
    }

    /// Puts the limbs into a posture.
    pub fn put(&self, posture: &[f64], posed: &mut PosedLimbs) {
        let PosedLimbs { frames, twists } = posed;
        for &j in &self.joints {
            let joint = &self.creature.joints()[j];
            let mut frame = frames[joint.parent];
            let visit = |dof: usize, transform: &DofTransform, before: &Frame| {
                let (axis, column) = (&self.schema.axes[dof], self.columns[dof]);
                let turning = |omega: Vector3<f64>| Twist::turning(omega, &before.origin);
                match transform {
                    DofTransform::Hinge { .. } => twists[column] = turning(before.direction(axis)),
                    DofTransform::Slide { .. } => twists[column] = Twist::shifting(before.direction(axis)),
                    DofTransform::Ball { .. } => {
                        (0..3).for_each(|k| twists[column + k] = turning(before.rotation.column(k).into()));
                    }
                }
            };
            carry_through(self.schema, j, joint_transforms(joint, posture), &mut frame, visit);
            frames[j + 1] = frame;
        }
    }

    /// The pose of the `k`-th limb: `p_wrt = X p_limb`, metres.
    pub fn pose(&self, k: usize, posed: &PosedLimbs) -> Frame {
        let frame = posed.frames[self.limbs[k].limb];
        if self.wrt == 0 { frame } else { posed.frames[self.wrt].inverse() * frame }
    }

    /// The Jacobian of the `k`-th limb's pose, row by row into zeros: six rows (velocity of the limb's origin, angular velocity,
    /// both in the frame of `wrt`) by one column per degree of freedom; of a ball three, for turns about the axes of the frame
    /// before it.
    pub fn jacobian(&self, k: usize, posed: &PosedLimbs, jacobian: &mut [f64]) {
        let (width, MovedLimb { limb, columns }) = (self.creature.dof(), &self.limbs[k]);
        let (wrt, origin) = (posed.frames[self.wrt].inverse(), posed.frames[*limb].origin);
        for &(column, sign) in columns {
            let twist = &posed.twists[column];
            let turned = |v: &Vector3<f64>| if self.wrt == 0 { *v } else { wrt.direction(v) * sign };
            let (velocity, omega) = (turned(&twist.at(&origin)), turned(&twist.angular));
            for row in 0..3 {
                jacobian[row * width + column] = velocity[row];
                jacobian[(3 + row) * width + column] = omega[row];
            }
        }
    }
}
