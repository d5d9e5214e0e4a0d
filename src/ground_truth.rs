//! Where the joints really are, in the learner's own convention. Only the evaluation may see it.

use crate::creature::Body;
use crate::mujoco;
use crate::schema::BodySchema;

/// The true schema of a creature, read from MuJoCo's poses at the reference posture.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundTruth {
    /// True positions and axes, in the frames of [`BodySchema`].
    pub schema: BodySchema,
}

impl GroundTruth {
    /// Reads the truth of a body.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn new(body: &Body) -> mujoco::Result<GroundTruth> {
        Ok(GroundTruth { schema: body.kinematics()? })
    }
}
