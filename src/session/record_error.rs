//! What can go wrong with a session on disk; each message is one sentence with its mend.

use std::io;
use std::path::{Path, PathBuf};

use crate::given_file::shortened;
use crate::model_files::Refused;

/// What was being done to a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Reading it.
    Read,
    /// Making or writing it.
    Write,
}

impl std::fmt::Display for Action {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(match self {
            Action::Read => "read",
            Action::Write => "write",
        })
    }
}

/// A file of a session that cannot be read or written, or that is not what it should be.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The operating system refused.
    #[error("cannot {action} {}: {}: {}", path.display(), reason(source), mend(*action, source.kind()))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was being done to it.
        action: Action,
        /// The system's own reason.
        source: io::Error,
    },
    /// Another process writes the folder, or reads it and does not finish.
    #[error("{}: {what}", folder.display())]
    Busy {
        /// The folder.
        folder: PathBuf,
        /// Which process does what, and the fix.
        what: String,
    },
    /// The content is not what the file should hold.
    #[error("{}{}: {message}", path.display(), line.map(|line| format!(", line {line}")).unwrap_or_default())]
    Format {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1; none where the message names the place itself.
        line: Option<usize>,
        /// What is wrong and what to do about it.
        message: String,
    },
}

/// What is wrong with the content of a file, and the mend: the message of a [`RecordError::Format`] before it is known
/// of which file and line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub(super) struct ContentFault(String);

impl From<Refused> for RecordError {
    fn from(Refused { path, line, message }: Refused) -> RecordError {
        RecordError::format(&path, line, message)
    }
}

impl From<String> for ContentFault {
    fn from(sentence: String) -> ContentFault {
        ContentFault(sentence)
    }
}

impl From<&str> for ContentFault {
    fn from(sentence: &str) -> ContentFault {
        ContentFault(sentence.to_string())
    }
}

impl From<ContentFault> for String {
    fn from(fault: ContentFault) -> String {
        fault.0
    }
}

impl RecordError {
    /// Makes an error of what the system said about `path`.
    pub(crate) fn io(path: &Path, action: Action) -> impl FnOnce(io::Error) -> RecordError {
        move |source| RecordError::Io { path: path.to_path_buf(), action, source }
    }

    /// An error about the content of `path`.
    pub(crate) fn format(path: &Path, line: Option<usize>, message: impl Into<String>) -> RecordError {
        RecordError::Format { path: path.to_path_buf(), line, message: shortened(message.into()) }
    }

    /// An error about JSON that fills the file `path`, which should hold `content`.
    pub(crate) fn json(path: &Path, content: &str, error: &serde_json::Error) -> RecordError {
        let line = Some(error.line()).filter(|&line| line > 0);
        let message = format!(
            "it is no {content} ({}): mend it, or give one that bodyschema wrote",
            json_reason(error)
        );
        RecordError::format(path, line, message)
    }
}

/// What the system said, without its code and as part of a sentence.
fn reason(source: &io::Error) -> String {
    let text = source.to_string();
    let text = text.split(" (os error").next().unwrap_or_default();
    let mut letters = text.chars();
    letters.next().map(|first| first.to_lowercase().chain(letters).collect()).unwrap_or_default()
}

fn mend(action: Action, kind: io::ErrorKind) -> &'static str {
    use io::ErrorKind::*;
    match (action, kind) {
        (Action::Read, NotFound) => "give the path of a file that exists",
        (Action::Read, PermissionDenied) => "give a file you may read",
        (Action::Read, _) => "give another file",
        (Action::Write, PermissionDenied | ReadOnlyFilesystem) => "give a folder you may write to with --out",
        (Action::Write, StorageFull | QuotaExceeded) => {
            "make room there, or give a folder on another disk with --out"
        }
        (Action::Write, _) => "give another folder with --out",
    }
}

/// What a JSON parser said, with the column but without the line, which is named otherwise.
pub(crate) fn json_reason(error: &serde_json::Error) -> String {
    if error.is_eof() {
        return "it ends in the middle".into();
    }
    let text = error.to_string();
    match text.rfind(" at line ") {
        Some(end) if error.column() > 0 => format!("{} in column {}", &text[..end], error.column()),
        Some(end) => text[..end].to_string(),
        None => text,
    }
}
