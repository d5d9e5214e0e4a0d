//! Calibration: a robot whose maker says where its joints are, put right by its own touches.
//!
//! ```text
//! robot (links, quantities by name, what is known of each) + touches ─ problem ─ estimate ─ fit
//! fit ─ told (deviations, what cannot be told apart) ─ judgement (held-out touches, objections) ─ causes (what would explain)
//! robot + touches that could be made ─ plan (those that tell most)
//! ```
//!
//! Where [`learning`](crate::learning) begins from nothing, this begins from nominal values, and knows more kinds of what may
//! be wrong: see [`robot`].

mod account;
mod causes;
mod estimate;
mod judgement;
pub mod made;
mod noise;
mod pairing;
mod places;
mod plan;
mod problem;
mod repeats;
pub mod robot;
mod signs;
pub mod simulated;
mod told;
mod touch;
mod unknowns;

pub use account::Calibration;
pub use estimate::{Estimator, EstimatorOptions, FalseTouches, Fit, JointNoise, SeenTouch, SignStarts};
pub use judgement::{
    FEWEST_HELD_OUT, Judgement, Misses, Objection, Question, folds, judge, objections, split,
};
pub use noise::{Noise, NoiseSource, Seen};
pub use places::{add_places, put_on_places};
pub use plan::{Plan, Planned, plan};
pub use repeats::{SAME_POINT, SAME_POSTURE, drop_alike, drop_repeats};
pub use told::{Told, Untold};
pub use touch::{End, Feature, Residuals, Touch};
pub use unknowns::Unknowns;
