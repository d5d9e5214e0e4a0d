//! Calibration: a robot whose maker says where its joints are, put right by its own touches.
//!
//! ```text
//! robot (links, quantities by name, what is known of each) + touches ─ problem ─ estimate ─ fit
//! fit ─ told (deviations, what cannot be told apart) ─ held_out, objections (what speaks against it) ─ causes (what would explain)
//! robot + touches that could be made ─ plan (those that tell most)
//! ```
//!
//! Where [`learning`](crate::learning) begins from nothing, this begins from nominal values, and knows more kinds of what may
//! be wrong: see [`robot`].

mod account;
mod causes;
mod estimate;
mod held_out;
mod noise;
mod objections;
mod pairing;
mod plan;
mod problem;
mod repeats;
pub mod robot;
mod signs;
mod told;
mod touch;
mod unknowns;

pub use account::Calibration;
pub use estimate::Fit;
pub use held_out::{FEWEST_HELD_OUT, Judgement, Misses, folds, judge, split};
pub use noise::{Noise, Seen};
pub use objections::{Objection, Question, objections};
pub use plan::{Plan, Planned, plan};
pub use problem::{Estimator, EstimatorOptions};
pub use repeats::{SAME_POINT, SAME_POSTURE, add_places, drop_alike, drop_repeats, put_on_places};
pub use told::{Told, Untold};
pub use touch::{End, Feature, Residuals, Touch};
pub use unknowns::Unknowns;
