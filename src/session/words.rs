//! Words that several experiments use.

pub(crate) use crate::named::listed;
