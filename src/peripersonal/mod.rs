//! The space around the body, by nothing but the learned schema: where things felt are, which postures touch them,
//! and how far away they are.
//!
//! "Each time the agent perceives tactile stimuli on a certain body part, coming from objects within his reaching
//! space, the learned body representation can be used to determine the position of the objects" (IVA 2009, section 1).
//! Nothing here names the engine or the truth: the same code acts on a schema that was learned and, in a study that
//! compares, on the true one.
//!
//! ```text
//! schema + skin + touches ─ own_body ─┬─ collision    how far surfaces are from each other and from what was felt
//!                                     ├─ velocity     joint velocities that do one thing and keep clear of others
//!                                     ├─ felt_surface where on a receptor something touches, and how it is curved
//!                                     ├─ path         paths through postures that keep clear
//!                                     ├─ posture_program   postures that are best and keep all they are to keep
//!                                     ├─ reaching     postures and paths that touch a place, or how far it is out of reach
//!                                     ├─ palm         which side of a hand is hollow; postures with a limb placed and turned
//!                                     └─ reachable    the voxels that a hand can get to: flood, lattice
//! ```
//!
//! Frames: space is told in the root limb's frame `R`, which stays where it is while the creature acts; a map of what is
//! reachable in the chest's frame `C` in the rest posture.

mod collision;
mod felt_shape;
mod felt_surface;
mod flood;
mod lattice;
mod obstacle;
mod own_body;
mod palm;
mod path;
mod posture_program;
mod reachable;
mod reaching;
mod searched;
mod stick;
#[cfg(test)]
mod tests;
mod velocity;

pub use collision::{CollisionChecker, LimbPieces, Nearness};
pub use felt_shape::{FeltLength, FeltShape, FeltSize, PlacedSkin, ShapeEstimate};
pub use felt_surface::{FeltPose, FeltSurface};
pub use lattice::Lattice;
pub use obstacle::{Obstacle, TablePlane};
pub use own_body::{Doubt, OwnBody};
pub use palm::{LimbGoal, LimbPosture, Palm, limb_posture, palm_turn};
pub use path::{PosturePath, distance, find_path, straight};
pub use posture_program::{KEPT, PosedPlace, PostureProgram, farthest_postures};
pub use reachable::{COARSE, FINE, Level, Reach, ReachableMap, voxel_side};
pub use reaching::{OutOfReach, ReachPlan, ReachTarget, Reaching};
pub use searched::{CELL, Cell, SearchedMap, SkinPoints};
pub use stick::STICK_TIP;
pub use velocity::{Barrier, PlaceVelocity, SteppedPosture, VelocityProgram};
