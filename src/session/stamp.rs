//! The first words of every file of a session, its format and the format's version; and logs, which have a header with them and
//! then a line of JSON each.

use std::io::{BufRead, BufReader};
use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::files;
use crate::error::{Error, json_reason};
use crate::given_file;

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
            let message = format!("it states no readable format ({}): {mend}", json_reason(&error));
            Error::content(path, line, message)
        })?;
        let refuse = |message: String| Err(Error::content(path, line, message));
        match (found.format, found.version) {
            (None, _) => refuse(format!("it states no format: {mend}")),
            (Some(other), _) if other != format => {
                refuse(format!("its format is \"{other}\", not \"{format}\": {mend}"))
            }
            (_, Some(newer)) if newer > version => refuse(format!(
                "it was written by a newer version of bodyschema (format version {newer}, supported {version}): \
                 update bodyschema"
            )),
            (_, Some(known)) if known == version => Ok(()),
            _ => refuse(format!("it states an unknown version of its format: {mend}")),
        }
    }
}

/// How a log ends that was not ended; all of it is left out.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LogEnd {
    /// The last line's number if it is incomplete, as a killed process leaves it.
    pub incomplete: Option<usize>,
    /// Zero bytes after it, as a file system leaves them after a power failure.
    pub zeros: usize,
}

/// Reads a log of lines that each hold a `what`: checks its header, and returns what `entry` makes of each further line.
pub(super) fn read_log<H: DeserializeOwned, L: DeserializeOwned, T>(
    path: &Path,
    (stamp, what): (Stamp, &str),
    check: impl FnOnce(H) -> Result<(), String>,
    mut entry: impl FnMut(L) -> Result<T, String>,
) -> Result<(Vec<T>, LogEnd), Error> {
    let io = || Error::unreadable(path);
    let refuse = |line: usize| move |fault: String| Error::content(path, Some(line), fault);
    let mut file = BufReader::new(given_file::open(path).map_err(io())?);
    let (mut json, mut entries, mut end) = (Vec::new(), Vec::new(), LogEnd::default());
    file.read_until(b'\n', &mut json).map_err(io())?;
    check(read_header(path, stamp, 1, &json)?).map_err(refuse(1))?;
    for line in 2.. {
        json.clear();
        file.read_until(b'\n', &mut json).map_err(io())?;
        let last = file.fill_buf().map_err(io())?.is_empty();
        if last {
            end.zeros = drop_zeros(&mut json);
        }
        if last && json.trim_ascii().is_empty() {
            break;
        }
        match serde_json::from_slice(&json) {
            Ok(found) => entries.push(entry(found).map_err(refuse(line))?),
            Err(error) if last && incomplete(&json, &error) => end.incomplete = Some(line),
            Err(error) => {
                let reason = json_reason(&error);
                let fault = format!("not a valid {what} ({reason}): correct the line or delete it");
                return Err(refuse(line)(fault));
            }
        }
        if last {
            break;
        }
    }
    Ok((entries, end))
}

/// The header of a log, on a line of it.
pub(super) fn read_header<H: DeserializeOwned>(
    path: &Path,
    stamp: Stamp,
    line: usize,
    json: &[u8],
) -> Result<H, Error> {
    let refuse = |message: String| Error::content(path, Some(line), message);
    if json.iter().all(|byte| *byte == 0 || byte.is_ascii_whitespace()) {
        return Err(refuse("it has no header: give a complete log, or record again".into()));
    }
    stamp.check(path, Some(line), json)?;
    serde_json::from_slice(json).map_err(|error| {
        let reason = json_reason(&error);
        refuse(format!("not a log header ({reason}): correct the line or record again"))
    })
}

/// Drops the zero bytes at the end of a log's last line; how many there were.
pub(super) fn drop_zeros(line: &mut Vec<u8>) -> usize {
    let length = line.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
    let zeros = line.len() - length;
    line.truncate(length);
    zeros
}

/// Whether a last line that is not understood is the beginning of one.
pub(super) fn incomplete(json: &[u8], error: &serde_json::Error) -> bool {
    error.is_eof() || (error.is_syntax() && !json.ends_with(b"\n"))
}
