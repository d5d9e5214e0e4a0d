//! Folders that results go to: never one that holds some already.

use std::path::{Path, PathBuf};

use super::{Failure, output};
use crate::record::SESSION_FILE;

/// The folder of a session: the one named, else the first free of sessions/CREATURE-1, -2, ….
pub fn session_folder(out: Option<&Path>, creature: &str) -> Result<PathBuf, Failure> {
    let name: String = creature.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).take(40).collect();
    free_folder(out, "session", SESSION_FILE, |k| Path::new("sessions").join(format!("{name}-{k}")))
}

/// The folder named, unless there is a file in it already, else the first that is free of numbered ones.
pub fn free_folder(
    out: Option<&Path>,
    what: &str,
    file: &str,
    numbered: impl Fn(u32) -> PathBuf,
) -> Result<PathBuf, Failure> {
    let folder = match out {
        Some(folder) if folder.join(file).exists() => {
            return Err(Failure(format!(
                "{} holds a {what} already: give another folder with --out, or remove it",
                folder.display()
            )));
        }
        Some(folder) => folder.to_path_buf(),
        None => (1..).map(numbered).find(|folder| !folder.exists()).expect("some number is free"),
    };
    output::make_folder(&folder)?;
    Ok(folder)
}
