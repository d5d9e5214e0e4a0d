//! The creature among other things: scenes with probes that touch it, and what it feels of them.

mod stimulation;
mod world;

pub use stimulation::{Stimulation, Strokes};
pub use world::{PROBE_RADIUS, ProbePath, World, WorldError};
