//! Balance: which way is up.

use crate::error::Result;
use nalgebra::Vector3;

use super::sense::{Sense, SensedStep};

/// The sense of balance, in the root limb.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balance {
    /// Against gravity, a unit vector in the root's frame.
    pub up: Vector3<f64>,
}

impl Default for Balance {
    /// Upright.
    fn default() -> Balance {
        Balance { up: Vector3::z() }
    }
}

impl Sense for Balance {
    fn place(&mut self, step: &SensedStep) -> Result<()> {
        if let Some(root) = step.body.limb_pose(step.data, 0) {
            self.up = root.inverse_transform_vector(&Vector3::z());
        }
        Ok(())
    }
}
