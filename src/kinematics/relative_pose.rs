//! A limb's pose in the frame of another limb, and its Jacobian.

use nalgebra::Vector3;

use super::chain::Chain;
use super::forward::{DofTransform, carry_through, joint_transforms};
use crate::creature::Creature;
use crate::geometry::Frame;
use crate::schema::BodySchema;

/// The pose of one limb in the frame of another at any posture.
#[derive(Clone, Debug)]
pub struct RelativePose<'a> {
    creature: &'a Creature,
    schema: &'a BodySchema,
    chain: Chain,
    /// Per axis of the schema, the first column of its degree of freedom in a Jacobian.
    columns: Vec<usize>,
}

impl<'a> RelativePose<'a> {
    /// The pose of limb `of` in the frame of limb `wrt`.
    pub fn new(creature: &'a Creature, schema: &'a BodySchema, of: usize, wrt: usize) -> RelativePose<'a> {
        let next = |column: &mut usize, dofs: usize| Some(std::mem::replace(column, *column + dofs));
        let columns = creature.dofs().map(|dof| dof.kind.dof()).scan(0, next).collect();
        RelativePose { creature, schema, chain: Chain::between(creature, of, wrt), columns }
    }

    /// The pose at a posture: `p_wrt = X p_of`, metres.
    pub fn pose(&self, posture: &[f64]) -> Frame {
        let [of, wrt] = [0, 1].map(|side| self.frame(side, posture, |_, _, _| {}));
        if self.chain.sides[1].is_empty() { of } else { wrt.inverse() * of }
    }

    /// The Jacobian at a posture, row by row into `jacobian`: six rows (velocity of the limb's origin, angular velocity, both
    /// in the frame of `wrt`) by one column per degree of freedom; of a ball three, for turns about the axes of the frame
    /// before it.
    pub fn jacobian(&self, posture: &[f64], jacobian: &mut [f64]) {
        let width = jacobian.len() / 6;
        jacobian.fill(0.0);
        // Per column its angular velocity, and the velocity of what is at the origin of the common ancestor.
        let mut twists: Vec<(usize, f64, Vector3<f64>, Vector3<f64>)> = Vec::with_capacity(32);
        let frames = [0, 1].map(|side| {
            let sign = if side == 0 { 1.0 } else { -1.0 };
            self.frame(side, posture, |dof, transform, before| {
                let (axis, column) = (&self.schema.axes[dof], self.columns[dof]);
                let mut turns = |column: usize, omega: Vector3<f64>| {
                    twists.push((column, sign, omega, before.origin.cross(&omega)));
                };
                match transform {
                    DofTransform::Hinge { .. } => turns(column, before.direction(axis)),
                    DofTransform::Ball { .. } => {
                        (0..3).for_each(|k| turns(column + k, before.rotation.column(k).into_owned()));
                    }
                    DofTransform::Slide { .. } => {
                        twists.push((column, sign, Vector3::zeros(), before.direction(axis)));
                    }
                }
            })
        });
        let turn = frames[1].rotation.transpose();
        for (column, sign, omega, velocity) in twists {
            let velocity = turn * (velocity + omega.cross(&frames[0].origin)) * sign;
            let omega = turn * omega * sign;
            for row in 0..3 {
                jacobian[row * width + column] = velocity[row];
                jacobian[(3 + row) * width + column] = omega[row];
            }
        }
    }

    /// The frame at the end of a side of the chain in the common ancestor's.
    fn frame(
        &self,
        side: usize,
        posture: &[f64],
        mut visit: impl FnMut(usize, &DofTransform, &Frame),
    ) -> Frame {
        let mut frame = Frame::identity();
        for &joint in &self.chain.sides[side] {
            let dofs = joint_transforms(&self.creature.joints()[joint], posture);
            carry_through(self.schema, joint, dofs, &mut frame, &mut visit);
        }
        frame
    }
}
