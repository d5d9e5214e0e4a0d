//! The one error of the library.

use std::path::{Path, PathBuf};
use std::{fmt, io};

/// Characters of a sentence at the most.
const LONGEST_SENTENCE: usize = 2000;

/// Why something could not be done, in one sentence: the file and line if it is about one, the fault, and the fix.
///
/// ```
/// use bodyschema::Agent;
///
/// let error = Agent::from_mjcf("no/such.xml").err().ok_or("there is no such file")?;
/// assert!(error.is_model() && !error.is_usage());
/// assert!(error.to_string().starts_with("no/such.xml: no such file"));
/// # Ok::<(), &str>(())
/// ```
#[derive(Debug)]
pub struct Error(Box<Fault>);

#[derive(Debug)]
struct Fault {
    kind: Kind,
    /// The file and the line, from 1, that the message is about.
    place: Option<(PathBuf, Option<usize>)>,
    message: String,
    /// What the operating system said.
    source: Option<io::Error>,
}

/// What is at fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A file or folder other than a model.
    File,
    /// Another process that has the folder.
    Busy,
    /// A model, or the creature in it.
    Model,
    /// A model in which nothing moves.
    NoJoints,
    /// A creature that cannot touch itself.
    NoContact,
    /// The engine, in a call.
    Engine,
    /// What is asked.
    Usage,
    /// A session from which nothing has been learned yet.
    NotLearned,
}

/// What comes of what can fail.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// Whether it is about a file or folder: it cannot be read or written, another process has it, or its
    /// content is not what it should be.
    pub fn is_file(&self) -> bool {
        matches!(self.0.kind, Kind::File | Kind::Busy)
    }

    /// Whether the file or folder that it is about is not there.
    pub fn is_missing(&self) -> bool {
        self.system()
            .is_some_and(|kind| [io::ErrorKind::NotFound, io::ErrorKind::NotADirectory].contains(&kind))
            || self.0.place.as_ref().is_some_and(|(path, line)| line.is_none() && !path.exists())
    }

    /// Whether another process has the folder: the same call may succeed later.
    pub fn is_busy(&self) -> bool {
        self.0.kind == Kind::Busy
    }

    /// Whether it is about a model or the creature in it: MuJoCo does not take the file, nothing in it can learn, or
    /// nothing of it can touch itself.
    pub fn is_model(&self) -> bool {
        matches!(self.0.kind, Kind::Model | Kind::NoJoints | Kind::NoContact)
    }

    /// Whether the creature is sound but cannot touch itself.
    pub fn is_no_contact(&self) -> bool {
        self.0.kind == Kind::NoContact
    }

    /// Whether MuJoCo failed while it computed, or cannot draw.
    pub fn is_engine(&self) -> bool {
        self.0.kind == Kind::Engine
    }

    /// Whether what was asked cannot be done, though all files are in order: an unknown name, options that exclude
    /// each other, a value out of range.
    pub fn is_usage(&self) -> bool {
        self.0.kind == Kind::Usage
    }

    /// Whether there is nothing learned yet, or no touch to learn from: babble or learn first.
    pub fn is_not_learned(&self) -> bool {
        self.0.kind == Kind::NotLearned
    }

    /// Whether nothing in the model moves.
    pub(crate) fn is_no_joints(&self) -> bool {
        self.0.kind == Kind::NoJoints
    }

    /// What kind of failure the operating system reported, if it was one of its.
    pub(crate) fn system(&self) -> Option<io::ErrorKind> {
        self.0.source.as_ref().map(io::Error::kind)
    }

    /// An error of a kind, which names no file.
    pub(crate) fn new(kind: Kind, sentence: impl Into<String>) -> Error {
        Error(Box::new(Fault { kind, place: None, message: shortened(sentence.into()), source: None }))
    }

    /// An error about what is asked.
    pub(crate) fn usage(sentence: impl Into<String>) -> Error {
        Error::new(Kind::Usage, sentence)
    }

    /// The error for learning without a touch.
    pub(crate) fn no_touch() -> Error {
        Error::new(Kind::NotLearned, "no touches to learn from: babble first")
    }

    /// An error about the creature of a model; [`Error::of_model`] adds the file.
    pub(crate) fn model(sentence: impl Into<String>) -> Error {
        Error::new(Kind::Model, sentence)
    }

    /// An error about the content of a file, and the line that it is about.
    pub(crate) fn content(path: &Path, line: Option<usize>, message: impl Into<String>) -> Error {
        Error::new(Kind::File, message).at(path, line)
    }

    /// An error about a file or folder that does not fit what is asked of it.
    pub(crate) fn unfit(path: &Path, reason: impl Into<String>) -> Error {
        Error::content(path, None, reason)
    }

    /// An error about JSON that fills the file `path`, which should hold `content`.
    pub(crate) fn json(path: &Path, content: &str, error: &serde_json::Error) -> Error {
        let line = Some(error.line()).filter(|&line| line > 0);
        let reason = json_reason(error);
        let message =
            format!("it is not a valid {content} ({reason}): correct it, or give one that bodyschema wrote");
        Error::content(path, line, message)
    }

    /// Makes an error of what the system says of reading a file.
    pub(crate) fn unreadable(path: &Path) -> impl FnOnce(io::Error) -> Error {
        move |source| {
            let fix = match source.kind() {
                io::ErrorKind::NotFound => "give the path of a file that exists",
                io::ErrorKind::PermissionDenied => "give a file you may read",
                _ => "give another file",
            };
            refused("read", path, fix, source)
        }
    }

    /// Makes an error of what the system says of making or writing a file.
    pub(crate) fn unwritable(path: &Path) -> impl FnOnce(io::Error) -> Error {
        move |source| {
            use io::ErrorKind::{PermissionDenied, QuotaExceeded, ReadOnlyFilesystem, StorageFull};
            let fix = match source.kind() {
                PermissionDenied | ReadOnlyFilesystem => "give a folder you may write to with --out",
                StorageFull | QuotaExceeded => "free some space, or give a folder on another disk with --out",
                _ => "give another folder with --out",
            };
            refused("write", path, fix, source)
        }
    }

    /// The same at a place, unless it names one already.
    pub(crate) fn at(mut self, path: &Path, line: Option<usize>) -> Error {
        self.0.place.get_or_insert_with(|| (path.to_path_buf(), line));
        self
    }

    /// Adds the model's file to errors about the creature or the engine that name no file.
    pub(crate) fn of_model(model: &Path) -> impl Fn(Error) -> Error {
        move |error| {
            let is_its = error.is_model() || error.is_engine();
            if is_its { error.at(model, None) } else { error }
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some((path, line)) = &self.0.place {
            write!(
                f,
                "{}{}: ",
                path.display(),
                line.map(|line| format!(", line {line}")).unwrap_or_default()
            )?;
        }
        f.write_str(&self.0.message)
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.0.source.as_ref().map(|source| source as _)
    }
}

/// What the system refuses to do with a file.
fn refused(action: &str, path: &Path, fix: &str, source: io::Error) -> Error {
    // Without the system's code, and as part of a sentence.
    let text = source.to_string();
    let mut letters = text.split(" (os error").next().unwrap_or_default().chars();
    let reason: String =
        letters.next().map_or(String::new(), |first| first.to_lowercase().chain(letters).collect());
    let mut error = Error::new(Kind::File, format!("cannot {action} {}: {reason}: {fix}", path.display()));
    error.0.source = Some(source);
    error
}

/// What a JSON parser said, with the column but without the line, which is named otherwise.
pub(crate) fn json_reason(error: &serde_json::Error) -> String {
    if error.is_eof() {
        return "it ends in the middle".into();
    }
    let text = error.to_string();
    let reason = text.rfind(" at line ").map_or(text.as_str(), |end| &text[..end]);
    // To a reader of the file, a type of this program is an object.
    let reason = match reason.split_once("expected struct ") {
        Some((before, _)) => format!("{before}expected an object"),
        None => reason.to_string(),
    };
    if error.column() > 0 { format!("{reason} in column {}", error.column()) } else { reason }
}

/// A sentence without the middle of what is too long to be read, such as a word of a file that was none.
pub(crate) fn shortened(sentence: String) -> String {
    let length = sentence.chars().count();
    if length <= LONGEST_SENTENCE {
        return sentence;
    }
    let begin: String = sentence.chars().take(LONGEST_SENTENCE / 2).collect();
    let end: String = sentence.chars().skip(length - LONGEST_SENTENCE / 2).collect();
    format!("{begin} … {end}")
}
