//! The trials of a study as files in a folder, written by one or several interruptible processes.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::run::{MOST_TRIALS, TrialRecord};
use super::{Asked, Findings, StudyOptions, StudyRun};
use crate::error::Error;
use crate::session::{STUDY_SHARE_FILE, ShareRecord, difference, files};
use crate::share::Share;

/// Where trials are, in the folder of a share.
const TRIALS_FOLDER: &str = "trials";

/// What a share of a study was asked for: the content of [`STUDY_SHARE_FILE`] in its folder. Beside it each trial has a file
/// of its own, `trials/SEED.json`, which is written whole or not at all.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct StudyShare {
    /// Which share it is, as in `3/16`.
    pub share: String,
    /// The command line that made it, word by word.
    pub command: Vec<String>,
    /// What all shares of one study have in common.
    pub asked: Asked,
}

impl ShareRecord for StudyShare {
    const FILE: &'static str = STUDY_SHARE_FILE;
    const OF: &'static str = "study";

    fn read(folder: &Path) -> Result<StudyShare, Error> {
        let file = folder.join(STUDY_SHARE_FILE);
        let share: StudyShare = read(&file, "the share of a study of this version")?;
        let StudyOptions { trials, seed, .. } = share.asked.options;
        if trials > MOST_TRIALS || seed.checked_add(trials).is_none() {
            let why = "no study has this many trials: remove it and make its share again";
            return Err(Error::unfit(&file, why));
        }
        Ok(share)
    }

    fn share(&self) -> Option<&str> {
        Some(&self.share)
    }

    fn command(&self) -> &[String] {
        &self.command
    }

    fn is_whole(&self, folder: &Path) -> bool {
        self.missing(folder).is_empty()
    }

    fn difference(&self, other: &StudyShare) -> Option<String> {
        difference(&json!(self.asked), &json!(other.asked))
    }
}

impl StudyShare {
    /// Reads the record of a folder.
    ///
    /// # Errors
    /// If it cannot be read, or is something else.
    pub fn read(folder: &Path) -> Result<StudyShare, Error> {
        ShareRecord::read(folder)
    }

    /// Makes the trials of this share that are missing in its folder, which is the caller's alone, on all threads; tells the caller
    /// of each.
    ///
    /// # Errors
    /// If the folder holds another study's, something cannot be written, or cannot be measured at all.
    pub fn make(&self, run: &StudyRun, folder: &Path, made: impl Fn() + Sync) -> Result<(), Error> {
        if StudyShare::is_in(folder) {
            StudyShare::read(folder)?.check(folder, self)?;
        } else {
            files::write_json(&folder.join(STUDY_SHARE_FILE), self)?;
        }
        self.missing(folder).into_par_iter().try_for_each(|seed| {
            files::write_json(&trial_file(folder, seed), &run.trial(seed)?)?;
            made();
            Ok(())
        })
    }

    /// The seeds of this share's trials.
    pub fn seeds(&self) -> Vec<u64> {
        let share: Share = self.share.parse().unwrap_or(Share::WHOLE);
        let seeds = self.asked.seeds();
        (0..share.of_first(seeds.end - seeds.start)).map(|own| seeds.start + share.piece(own)).collect()
    }

    /// The seeds of those of its trials that are not in a folder.
    pub fn missing(&self, folder: &Path) -> Vec<u64> {
        self.seeds().into_iter().filter(|&seed| !trial_file(folder, seed).exists()).collect()
    }
}

impl Findings {
    /// What the trials of shares come to that are all made, each in its folder.
    ///
    /// # Errors
    /// If there is no share, a file cannot be read, or holds no trial.
    pub(crate) fn of_shares(shares: &[(Share, PathBuf, StudyShare)]) -> Result<Findings, Error> {
        let (.., first) = shares.first().ok_or_else(|| Error::usage("it contains no share of the study"))?;
        let files = |(_, folder, share): &(Share, PathBuf, StudyShare)| {
            let file = |seed| (seed, trial_file(folder, seed));
            share.seeds().into_iter().map(file).collect::<Vec<_>>()
        };
        let files: BTreeMap<u64, PathBuf> = shares.iter().flat_map(files).collect();
        let trial = |file: &PathBuf| read::<TrialRecord>(file, "a trial of a study");
        Findings::of(first.asked.clone(), files.values().map(trial).collect::<Result<_, _>>()?)
    }
}

fn trial_file(folder: &Path, seed: u64) -> PathBuf {
    folder.join(TRIALS_FOLDER).join(format!("{seed}.json"))
}

fn read<T: DeserializeOwned>(path: &Path, what: &str) -> Result<T, Error> {
    let text = files::read(path)?;
    serde_json::from_slice(&text).map_err(|error| {
        Error::unfit(path, format!("not {what} ({error}): remove it and make its share again"))
    })
}
