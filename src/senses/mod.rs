//! The senses: contacts read as touches of the skin, and what may be wrong with them.

mod contact_reader;
mod disturbance;
mod touch;

pub use contact_reader::{ContactReader, Reading};
pub use disturbance::{Disturbances, Felt};
pub use touch::{Touch, TouchEnd};
