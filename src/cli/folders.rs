//! Folders that results go to: never one that holds some already, and never one that another process writes.

use std::fs;
use std::path::{Path, PathBuf};

use super::Failure;
use crate::session::{
    FIRINGS_FILE, FolderLock, LEARNED_FILE, LEARNED_RECORD_FILE, LEARNING_FILE, PROGRESS_FILE, SCHEMA_FILE,
    SENSATIONS_FILE, SESSION_FILE, SPACE_FILE, Session, TOUCHES_FILE,
};
use crate::view::report::REPORT_FILE;

/// Files that a session writes, any of which would be lost if one began where it is.
const OF_SESSIONS: [&str; 11] = [
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
    REPORT_FILE,
];

/// Whether results that are there already may be replaced.
#[derive(clap::Args, Clone, Copy, Debug, Default)]
pub struct Force {
    /// Replace existing results in the folder; they are kept until the new ones are complete
    #[arg(long, requires = "out", help_heading = "Output")]
    pub force: bool,
}

/// The folder of a new session: the one named, else the first free of sessions/CREATURE-1, -2, ….
pub fn session_folder(out: Option<&Path>, creature: &str, force: Force) -> Result<FolderLock, Failure> {
    let name: String = creature.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).take(40).collect();
    let numbered = |k| Path::new("sessions").join(format!("{name}-{k}"));
    out.map_or_else(
        || first_free(numbered, &OF_SESSIONS),
        |out| new_folder(out, force, "session", &OF_SESSIONS),
    )
}

/// The folder of a session that is there and that a command writes into.
pub fn written_session(folder: &Path) -> Result<FolderLock, Failure> {
    // A folder of something else, or none, is told of as such, and nothing is left in it.
    if !folder.join(SESSION_FILE).exists() {
        Session::read(folder)?;
    }
    Ok(FolderLock::take(folder)?)
}

/// A folder for new results, unless it holds one of their files that may not be replaced. It is the caller's alone, who writes into
/// [`FolderLock::folder`] and calls [`FolderLock::commit`] in the end.
pub fn new_folder(folder: &Path, force: Force, what: &str, files: &[&str]) -> Result<FolderLock, Failure> {
    let mut lock = FolderLock::make(folder)?;
    let Some(file) = held(folder, files) else { return Ok(lock) };
    if !force.force {
        return Err(Failure(format!(
            "{} already contains a {what} ({file}): give another folder with --out, or replace it with --force",
            folder.display()
        )));
    }
    // Only files can be replaced all at once.
    let is_other = |name: &&&str| fs::symlink_metadata(folder.join(name)).is_ok_and(|about| !about.is_file());
    if let Some(name) = files.iter().find(is_other) {
        return Err(Failure::at(&folder.join(name), "not a file; move it away first"));
    }
    lock.replace(files)?;
    Ok(lock)
}

/// The first of numbered folders that holds none of some files; otherwise as [`new_folder`].
pub fn first_free(numbered: impl Fn(u32) -> PathBuf, files: &[&str]) -> Result<FolderLock, Failure> {
    for folder in (1..).map(numbered) {
        // Of several processes one makes it, and that one has it, unless another was told to write just there.
        match FolderLock::make_new(&folder) {
            Ok(Some(lock)) if held(&folder, files).is_none() => return Ok(lock),
            Ok(_) => {}
            Err(error) if error.is_busy() => {}
            Err(error) => return Err(error.into()),
        }
    }
    Err("all folder numbers are taken: give a folder with --out".into())
}

/// The first of some files that is in a folder.
fn held<'a>(folder: &Path, files: &[&'a str]) -> Option<&'a str> {
    files.iter().copied().find(|file| fs::symlink_metadata(folder.join(file)).is_ok())
}
