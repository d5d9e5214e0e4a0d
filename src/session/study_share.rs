//! A share of a study on disk: what was asked, and a file per trial.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::stamp::Stamp;
use super::{Action, RecordError, STUDY_SHARE_FILE, files, write_whole};

const STAMP: Stamp = Stamp { format: "bodyschema share of a study", version: 1 };
/// Where its trials are, in its folder.
const TRIALS_FOLDER: &str = "trials";

/// What a share of a study was asked for.
///
/// In its folder each trial that is made has a file of its own, `trials/SEED.ron`, which is written whole or not at all: so a
/// share that was interrupted goes on with the trials that are missing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct StudyShare {
    /// Which share it is, as in `3/16`.
    pub share: String,
    /// The command line that made it, word by word.
    pub command: Vec<String>,
    /// All options in effect, by their names on the command line.
    pub arguments: BTreeMap<String, Vec<String>>,
    /// What all shares of one study have in common: the study, the program, the engine, the models' contents.
    pub common: Value,
}

impl StudyShare {
    /// Writes [`STUDY_SHARE_FILE`] into a folder, whole or not at all, and makes room for trials.
    ///
    /// # Errors
    /// [`RecordError::Io`] where the folder or the file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), RecordError> {
        files::make_folder(&folder.join(TRIALS_FOLDER))?;
        STAMP.write(&folder.join(STUDY_SHARE_FILE), self)
    }

    /// Reads [`STUDY_SHARE_FILE`] of a folder.
    ///
    /// # Errors
    /// [`RecordError::Io`] where it cannot be read, [`RecordError::Format`] where it is something else.
    pub fn read(folder: &Path) -> Result<StudyShare, RecordError> {
        STAMP.read(&folder.join(STUDY_SHARE_FILE), "share of a study")
    }
}

/// The file of the trial of a seed, in a share's folder.
pub fn trial_file(folder: &Path, seed: u64) -> PathBuf {
    folder.join(TRIALS_FOLDER).join(format!("{seed}.ron"))
}

/// Writes what a trial left, whole or not at all.
///
/// # Errors
/// [`RecordError::Io`] where it cannot be written.
pub fn write_trial(folder: &Path, seed: u64, text: &str) -> Result<(), RecordError> {
    let path = trial_file(folder, seed);
    write_whole(&path, format!("{text}\n").as_bytes()).map_err(RecordError::io(&path, Action::Write))
}

/// Reads what a trial left.
///
/// # Errors
/// [`RecordError::Io`] where it cannot be read.
pub fn read_trial(folder: &Path, seed: u64) -> Result<String, RecordError> {
    let path = trial_file(folder, seed);
    fs::read_to_string(&path).map_err(RecordError::io(&path, Action::Read))
}
