//! Studies that repeat a measurement over seeds; [`bodies`] makes creatures to study from seeds. What else was here is in
//! [`session`](crate::session).

pub mod bodies;
pub mod study;

pub use crate::session::*;
pub(crate) use crate::session::{touches, words};
