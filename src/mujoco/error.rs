//! What can go wrong between the crate and MuJoCo; each message is one sentence with its fix.

use std::path::PathBuf;

use crate::error::Kind;

/// A failure of the engine, of a model's file, or of what was handed to the engine.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A model could not be read: no such file, malformed XML, numbers with which the engine crashes or never returns,
    /// or content that it refuses.
    #[error("{}{}: {message}", path.display(), line.map(|line| format!(", line {line}")).unwrap_or_default())]
    Read {
        /// The file, which may be one that the model includes, or
        /// [`Model::STRING_NAME`](super::Model::STRING_NAME) for a model from a string.
        path: PathBuf,
        /// The line of the element, counted from 1; `None` if it is about the whole file.
        line: Option<usize>,
        /// What was wrong, where, and what to do about it.
        message: String,
    },
    /// The library loaded at run time is not the one whose headers the crate was built with.
    #[error(
        "the crate was built with the headers of MuJoCo {} but runs with the library of MuJoCo {}: \
         rebuild it (`cargo clean -p bodyschema`, then build) or run it with that library",
        version_text(*header), version_text(*library)
    )]
    Version {
        /// `mjVERSION_HEADER` at build time.
        header: i32,
        /// `mj_version()` at run time.
        library: i32,
    },
    /// The engine raised an error inside a call; the data it worked on were reset.
    #[error(
        "MuJoCo stopped in {call} with \"{message}\": give the model more memory, or correct what the message names"
    )]
    Engine {
        /// The C function that was called.
        call: &'static str,
        /// The engine's own words.
        message: String,
    },
    /// The engine warned inside a call: its result is incomplete and was not handed on.
    #[error("MuJoCo warned in {call} with \"{message}\": the result would be incomplete")]
    Warning {
        /// The C function that was called.
        call: &'static str,
        /// The engine's own words.
        message: String,
    },
    /// Nothing can be drawn.
    #[error("no OpenGL available ({reason}): install Debian's packages libegl1 and libgl1-mesa-dri")]
    OpenGl {
        /// What was tried, and what it lacked.
        reason: String,
    },
    /// A number that the engine would take in silence and compute nonsense from.
    #[error("{what}[{index}] is not a number below 1e10: give a finite one")]
    NotFinite {
        /// The vector, as MuJoCo names it.
        what: &'static str,
        /// The offending element.
        index: usize,
    },
    /// A slice does not have the length that the model prescribes.
    #[error("{what} has {found} numbers but the model needs {expected}: give exactly {expected}")]
    Size {
        /// The vector, as MuJoCo names it.
        what: &'static str,
        /// The model's length.
        expected: usize,
        /// The length given.
        found: usize,
    },
}

impl From<Error> for crate::error::Error {
    fn from(error: Error) -> crate::error::Error {
        match error {
            Error::Read { path, line, message } => crate::error::Error::model(message).at(&path, line),
            error => crate::error::Error::new(Kind::Engine, error.to_string()),
        }
    }
}

/// A result of the MuJoCo layer.
pub type Result<T> = std::result::Result<T, Error>;

/// A version number as people write it: 222 and 2002002 are both "2.2.2".
pub(super) fn version_text(number: i32) -> String {
    let base = if number < 1000 { 10 } else { 1000 };
    format!("{}.{}.{}", number / (base * base), number / base % base, number % base)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_read_as_people_write_them() {
        assert_eq!(version_text(222), "2.2.2");
        assert_eq!(version_text(3_017_000), "3.17.0");
    }
}
