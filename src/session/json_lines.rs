//! The lines of a log after its header, each JSON of its own.

use std::io::BufRead;
use std::path::Path;

use serde::de::DeserializeOwned;

use super::record_error::{ContentFault, json_reason};
use super::{Action, RecordError};

/// How a log ends that was not ended; all of it is left out.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LogEnd {
    /// The last line's number where it is incomplete, as a killed process leaves it.
    pub incomplete: Option<usize>,
    /// Zero bytes after it, as a file system leaves them where the power failed.
    pub zeros: usize,
}

/// Hands on what each line of `file` holds from the second on, up to its end. `what` names what a line holds.
///
/// # Errors
/// [`RecordError::Io`] where the file cannot be read, [`RecordError::Format`], with the line, where one holds something
/// else or `take` refuses it.
pub(super) fn read_lines<T: DeserializeOwned>(
    path: &Path,
    file: &mut impl BufRead,
    what: &str,
    mut take: impl FnMut(T) -> Result<(), ContentFault>,
) -> Result<LogEnd, RecordError> {
    let io = || RecordError::io(path, Action::Read);
    let refuse = |line: usize, fault: ContentFault| Err(RecordError::format(path, Some(line), fault));
    let (mut json, mut end) = (Vec::new(), LogEnd::default());
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
            Ok(found) => {
                if let Err(fault) = take(found) {
                    return refuse(line, fault);
                }
            }
            Err(error) if last && incomplete(&json, &error) => {
                end.incomplete = Some(line);
                break;
            }
            Err(error) => {
                let reason = json_reason(&error);
                return refuse(
                    line,
                    format!("it is no {what} ({reason}): mend the line or delete it").into(),
                );
            }
        }
        if last {
            break;
        }
    }
    Ok(end)
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
