//! Rotations, chains through the tree, and their Jacobians.
//!
//! Everything here is a pure function of a [`BodySchema`](crate::schema::BodySchema) and a posture; it
//! serves the agent (with what it has learned) and the evaluation (with the truth) alike.

mod chain;
mod inverse;
mod rotation;
mod segments;

pub(crate) use chain::ball;
pub use chain::{Chain, ChainSide, Frame, PoseJacobian, SideJacobian, limb_frames};
pub(crate) use inverse::turn_ball;
pub use inverse::{Facing, InverseKinematics, Place, REACHED, Reach};
pub use rotation::{axis_derivative, rotation, skew, tangent_basis};
pub use segments::closest_points;
