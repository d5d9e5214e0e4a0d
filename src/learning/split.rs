//! A body in which every degree of freedom has a position of its own.
//!
//! Letting the axes of one joint part from each other removes most local minima of the first solve. What
//! it finds is folded back: the inner positions move into the joint's.

use nalgebra::Vector3;

use crate::creature::{AuraLimb, Creature, Joint};
use crate::schema::BodySchema;

/// A creature and its counterpart with one degree of freedom per joint.
pub struct SplitCreature {
    /// The counterpart; its postures are the creature's.
    pub creature: Creature,
    /// Per joint of the counterpart, the creature's joint it is part of.
    pub joint_of: Vec<usize>,
    /// Per limb of the creature, the limb of the counterpart that is it.
    pub limb_of: Vec<usize>,
}

impl SplitCreature {
    /// Splits every joint.
    pub fn new(creature: &Creature) -> SplitCreature {
        let mut limbs = vec![creature.limbs()[0].clone()];
        let mut joints: Vec<Joint> = Vec::new();
        let (mut joint_of, mut limb_of) = (Vec::new(), vec![0]);
        for (j, joint) in creature.joints().iter().enumerate() {
            let mut parent = limb_of[joint.parent];
            for dof in &joint.dofs {
                joints.push(Joint::new(dof.name.clone(), parent, vec![dof.clone()]));
                limbs.push(dof.name.clone());
                joint_of.push(j);
                parent = joints.len();
            }
            limb_of.push(parent);
        }
        let auras: Vec<AuraLimb> = Vec::new();
        let creature = Creature::new(creature.name().to_string(), limbs, joints, auras)
            .expect("a split joint keeps the order of the tree");
        SplitCreature { creature, joint_of, limb_of }
    }

    /// The same body with its joints split: each joint's position goes to its first part.
    pub fn unfold(&self, schema: &BodySchema) -> BodySchema {
        let mut unfolded = BodySchema::zero(&self.creature);
        unfolded.axes.clone_from(&schema.axes);
        let mut last = None;
        for (part, &joint) in self.joint_of.iter().enumerate() {
            if last != Some(joint) {
                unfolded.positions[part] = schema.positions[joint];
            }
            last = Some(joint);
        }
        unfolded
    }

    /// Folds a split schema: a joint's position is the sum of its parts' positions.
    pub fn fold(&self, split: &BodySchema) -> BodySchema {
        let joints = self.limb_of.len() - 1;
        let mut positions = vec![Vector3::zeros(); joints];
        for (part, &joint) in self.joint_of.iter().enumerate() {
            positions[joint] += split.positions[part];
        }
        BodySchema { positions, axes: split.axes.clone() }
    }
}
