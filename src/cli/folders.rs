//! Folders that results go to: never one that holds some already, and never one that another process writes.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::{Failure, output};
use crate::record::{
    FIRINGS_FILE, FolderLock, LEARNED_FILE, LEARNED_RECORD_FILE, LEARNING_FILE, PROGRESS_FILE, RecordError,
    SCHEMA_FILE, SENSATIONS_FILE, SESSION_FILE, SPACE_FILE, Session, TOUCHES_FILE,
};

/// Files that a session writes, any of which would be lost if one began where it is.
const OF_SESSIONS: [&str; 10] = [
    SESSION_FILE,
    TOUCHES_FILE,
    PROGRESS_FILE,
    FIRINGS_FILE,
    SENSATIONS_FILE,
    SCHEMA_FILE,
    LEARNED_FILE,
    LEARNING_FILE,
    LEARNED_RECORD_FILE,
    SPACE_FILE,
];

/// The folder of a new session: the one named, else the first free of sessions/CREATURE-1, -2, ….
pub fn session_folder(out: Option<&Path>, creature: &str) -> Result<FolderLock, Failure> {
    let name: String = creature.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).take(40).collect();
    free_folder(out, "session", &OF_SESSIONS, |k| Path::new("sessions").join(format!("{name}-{k}")))
}

/// The folder of a session that is there and that a command writes into.
pub fn written_session(folder: &Path) -> Result<FolderLock, Failure> {
    // A folder of something else, or none, is told of as such, and nothing is left in it.
    if !folder.join(SESSION_FILE).exists() {
        Session::read(folder)?;
    }
    Ok(FolderLock::take(folder)?)
}

/// The folder named, unless one of some files is in it already, else the first that is free of numbered ones, which is
/// made. It is the caller's alone.
pub fn free_folder(
    out: Option<&Path>,
    what: &str,
    files: &[&str],
    numbered: impl Fn(u32) -> PathBuf,
) -> Result<FolderLock, Failure> {
    if let Some(folder) = out {
        output::make_folder(folder)?;
        let lock = FolderLock::take(folder)?;
        return match held(folder, files) {
            Some(file) => Err(Failure(format!(
                "{} holds a {what} already ({file}): give another folder with --out, or remove it",
                folder.display()
            ))),
            None => Ok(lock),
        };
    }
    for folder in (1..).map(numbered) {
        if let Some(above) = folder.parent() {
            output::make_folder(above)?;
        }
        // Of several processes one makes it, …
        match fs::create_dir(&folder) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => continue,
            Err(error) => return Err(output::no_folder(&folder, &error)),
            Ok(()) => {}
        }
        // … and that one has it, unless another was told to write just there.
        match FolderLock::take(&folder) {
            Ok(lock) if held(&folder, files).is_none() => return Ok(lock),
            Ok(_) | Err(RecordError::Busy { .. }) => {}
            Err(error) => return Err(error.into()),
        }
    }
    Err("all numbers of folders are taken: give one with --out".into())
}

/// The first of some files that is in a folder.
fn held<'a>(folder: &Path, files: &[&'a str]) -> Option<&'a str> {
    files.iter().copied().find(|file| fs::symlink_metadata(folder.join(file)).is_ok())
}
