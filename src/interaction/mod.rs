//! The creature among other things: scenes with probes that touch it, and what it feels of them.

mod caress;
mod event;
mod script;
mod stimulation;
mod world;

pub use caress::stroke_for;
pub use event::{aura_event_json, event_json};
pub use script::Script;
pub use stimulation::{Stimulation, Strokes};
pub use world::{PROBE_RADIUS, ProbePath, World, WorldError};
