//! What was here is in [`session`](crate::session) and [`study`](crate::study).

pub(crate) use crate::session::words;
pub use crate::session::*;
