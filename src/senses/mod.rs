//! The senses: contacts read as touches of the skin.

mod contact_reader;
mod touch;

pub use contact_reader::{ContactReader, Reading};
pub use touch::{Touch, TouchEnd};
