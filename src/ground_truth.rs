//! The true joint positions, in the learner's convention. Only simulation and evaluation may use them.

use crate::creature::{Appearance, Body, DofKind};
use crate::error::Result;
use crate::schema::BodySchema;

/// The true schema of a creature, read from MuJoCo's poses at the reference posture.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundTruth {
    /// True positions and axes, in the frames of [`BodySchema`].
    pub schema: BodySchema,
    /// What the body looks like, which nothing is learned from.
    pub appearance: Appearance,
}

impl GroundTruth {
    /// Reads the truth of a body.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn new(body: &Body) -> Result<GroundTruth> {
        let data = body.reference_data()?;
        let frames = body.reference_frames(&data);
        let mut schema = BodySchema::zero(&body.creature);
        for (j, (joint, segment)) in body.creature.joints().iter().zip(&body.segments).enumerate() {
            let parent = &frames[joint.parent];
            let anchor = frames[j + 1].translation.vector;
            schema.positions[j] = parent.inverse_transform_point(&anchor.into()).coords;
            for ((k, dof), &mujoco_joint) in joint.dof_indices().zip(&joint.dofs).zip(&segment.joints) {
                if dof.kind != DofKind::Ball {
                    let axis = data.joint_axis(mujoco_joint);
                    schema.axes[k] = parent.inverse_transform_vector(&axis);
                }
            }
        }
        Ok(GroundTruth { schema, appearance: Appearance::of(body) })
    }
}
