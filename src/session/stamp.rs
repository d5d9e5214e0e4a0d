//! The first words of every file of a session: its format and the format's version.

use crate::error::{Error, json_reason};
use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::files;

/// A format of a file and the version of it that this program writes and reads.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stamp {
    /// The format's name, as the file states it.
    pub format: &'static str,
    /// The newest version known.
    pub version: u64,
}

/// A file's content behind its stamp.
#[derive(Serialize)]
pub(super) struct Stamped<'a, T> {
    format: &'static str,
    version: u64,
    #[serde(flatten)]
    content: &'a T,
}

/// As much of a file as every format has.
#[derive(Deserialize)]
#[serde(expecting = "an object")]
struct StatedFormat {
    format: Option<String>,
    version: Option<u64>,
}

impl Stamp {
    /// Puts the stamp before a content.
    pub fn on<T>(self, content: &T) -> Stamped<'_, T> {
        Stamped { format: self.format, version: self.version, content }
    }

    /// Writes a content behind the stamp to a file, whole or not at all.
    pub fn write(self, path: &Path, content: &impl Serialize) -> Result<(), Error> {
        files::write_json(path, &self.on(content))
    }

    /// Reads the content of a file behind the stamp; `what` it should be is named in errors.
    pub fn read<T: DeserializeOwned>(self, path: &Path, what: &str) -> Result<T, Error> {
        self.content(path, what, &files::read(path)?)
    }

    /// The content behind the stamp in the `json` of a file.
    pub fn content<T: DeserializeOwned>(self, path: &Path, what: &str, json: &[u8]) -> Result<T, Error> {
        self.check(path, None, json)?;
        serde_json::from_slice(json).map_err(|error| Error::json(path, what, &error))
    }

    /// Checks that `json` carries the stamp; an error names `line`, or else the parser's line.
    pub fn check(self, path: &Path, line: Option<usize>, json: &[u8]) -> Result<(), Error> {
        let Stamp { format, version } = self;
        let mend = format!("give a file that begins with \"format\":\"{format}\",\"version\":{version}");
        let found: StatedFormat = serde_json::from_slice(json).map_err(|error| {
            let line = line.or(Some(error.line()).filter(|&line| line > 0));
            let message = format!("it states no format that can be read ({}): {mend}", json_reason(&error));
            Error::content(path, line, message)
        })?;
        let refuse = |message: String| Err(Error::content(path, line, message));
        match (found.format, found.version) {
            (None, _) => refuse(format!("it states no format: {mend}")),
            (Some(other), _) if other != format => {
                refuse(format!("its format is \"{other}\", not \"{format}\": {mend}"))
            }
            (_, Some(newer)) if newer > version => refuse(format!(
                "it was written by a newer version of bodyschema (version {newer} of the format, known \
                 is {version}): update bodyschema"
            )),
            (_, Some(known)) if known == version => Ok(()),
            _ => refuse(format!("it states no version of its format that exists: {mend}")),
        }
    }
}
