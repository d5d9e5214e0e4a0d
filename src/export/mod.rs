//! A learned body in the formats of others: MJCF and URDF.

mod mjcf;
mod urdf;

pub use mjcf::to_mjcf;
pub use urdf::{Urdf, to_urdf};
