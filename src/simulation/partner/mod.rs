//! Stimuli by a partner: taps, strokes and scripted touches with probes.
//!
//! They are made from where the skin really is, for they are done to the creature, not by it.

mod caress;
mod script;
mod stimulation;

pub use caress::stroke_for;
pub use script::Script;
pub use stimulation::{Stimulation, Strokes};
