//! Why a model has no creature.

use super::CreatureError;
use crate::mujoco;

/// Why a model has no creature that can learn.
#[derive(Debug, thiserror::Error)]
pub enum BodyError {
    /// The engine failed.
    #[error(transparent)]
    Engine(#[from] mujoco::Error),
    /// Nothing can move.
    #[error("the model has no hinge, slide or ball joint: give a creature that can move")]
    NoJoints,
    /// The model or what is asked of it is unsuitable: the fault and the fix.
    #[error("{0}")]
    Unsuitable(String),
    /// The tree could not be put together.
    #[error("the model's tree cannot be read: {0}")]
    Tree(#[from] CreatureError),
}
