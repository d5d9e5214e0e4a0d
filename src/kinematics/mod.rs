//! Rotations, chains through the tree, and their Jacobians.
//!
//! Everything here is a pure function of a [`BodySchema`](crate::schema::BodySchema) and a posture; it
//! serves the agent (with what it has learned) and the evaluation (with the truth) alike.

mod chain;
mod forward;
mod freedom;
mod inverse;
mod place_chain;
mod quadratic;
mod relative_poses;
mod rotation;

pub use chain::{Chain, ChainSide, PoseJacobian, SideJacobian, ways_apart};
pub(crate) use forward::{DofTransform, carry_through, joint_transforms, limb_motions_into};
pub use forward::{LimbMotion, Twist, limb_frames};
pub use freedom::{Feature, FreeMotions, Freedoms};
pub use inverse::{InverseKinematics, REACHED, Reach};
pub use place_chain::{Place, PlaceChain, Workspace};
pub use quadratic::{Condition, QuadraticProgram};
pub use relative_poses::{PosedLimbs, RelativePoses};
pub use rotation::{axis_derivative, rotation, skew};
