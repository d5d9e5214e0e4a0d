//! Learning.
mod growing; mod least_squares; mod observation; mod onset; mod parameters; mod split; mod touch_set;
pub use parameters::{AxisModel, Parameters};
