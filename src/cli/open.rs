//! Opening a model for a command.

use std::path::Path;
use std::sync::Arc;

use super::Failure;
use crate::creature::{Body, JointSelection};
use crate::mujoco::Model;

/// Reads a model and the creature in it.
pub fn open_body(path: &Path, joints: &JointSelection) -> Result<Body, Failure> {
    let model = Arc::new(Model::from_path(path)?);
    Body::new(model, joints).map_err(|error| match error {
        // Engine errors name the file themselves.
        crate::creature::BodyError::Engine(error) => Failure::from(error),
        other => Failure(format!("{}: {other}", path.display())),
    })
}
