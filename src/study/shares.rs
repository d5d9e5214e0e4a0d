//! The trials of a study as files in a folder, written by one or several interruptible processes.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::{fmt, fs};

use rayon::prelude::*;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::run::{MOST_TRIALS, TrialRecord};
use super::{Asked, Findings, StudyOptions, StudyRun};
use crate::error::Error;
use crate::session::{SHARES_FOLDER, STUDY_SHARE_FILE, files};

/// Where trials are, in the folder of a share.
const TRIALS_FOLDER: &str = "trials";

/// The most shares that work is cut into.
const MOST_SHARES: u64 = 100_000;

/// What is wrong with a share's name.
fn no_share() -> Error {
    Error::usage(format!(
        "give a share and their number, such as 3/16: from 1/16 to 16/16, at most {MOST_SHARES} shares"
    ))
}

/// One of so many equal shares of work that comes in numbered pieces: every so-manieth piece, so that all shares take
/// about as long, however much there is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Share {
    /// How many there are.
    pub(crate) of: u64,
    /// Its number, from 1 on.
    pub(crate) number: u64,
}

impl Share {
    /// All of it.
    pub const WHOLE: Share = Share { of: 1, number: 1 };

    /// The share of a number, from 1 on; `None` if it is not one of so many.
    pub fn new(number: u64, of: u64) -> Option<Share> {
        ((1..=of).contains(&number) && of <= MOST_SHARES).then_some(Share { of, number })
    }

    /// All shares of work that is cut into so many.
    pub fn all(of: u64) -> impl Iterator<Item = Share> {
        (1..=of).map(move |number| Share { of, number })
    }

    /// Those of numbered pieces of work that belong to it.
    pub fn own(self, pieces: Range<u64>) -> impl Iterator<Item = u64> {
        pieces.skip(self.number as usize - 1).step_by(self.of as usize)
    }
}

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Share {
    type Err = Error;

    fn from_str(text: &str) -> Result<Share, Error> {
        let (number, of) = text.split_once('/').ok_or_else(no_share)?;
        let whole = |text: &str| text.parse::<u64>().map_err(|_| no_share());
        Share::new(whole(number)?, whole(of)?).ok_or_else(no_share)
    }
}

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

impl StudyShare {
    /// Whether a folder holds one.
    pub(crate) fn is_in(folder: &Path) -> bool {
        folder.join(STUDY_SHARE_FILE).exists()
    }

    /// Reads the record of a folder.
    ///
    /// # Errors
    /// If it cannot be read, or is something else.
    pub fn read(folder: &Path) -> Result<StudyShare, Error> {
        let file = folder.join(STUDY_SHARE_FILE);
        let share: StudyShare = read(&file, "the share of a study of this version")?;
        let StudyOptions { trials, seed, .. } = share.asked.options;
        if trials > MOST_TRIALS || seed.checked_add(trials).is_none() {
            let why = "no study has this many trials: remove it and make its share again";
            return Err(Error::unfit(&file, why));
        }
        Ok(share)
    }

    /// What differs from what another share was asked for, in words, though both are to be of the same study; `None` if nothing does.
    fn difference(&self, other: &StudyShare) -> Option<String> {
        difference(&json!(self.asked), &json!(other.asked))
    }

    /// Makes the trials of this share that are missing in its folder, which is the caller's alone, on all threads; tells the caller
    /// of each.
    ///
    /// # Errors
    /// If the folder holds another study's, something cannot be written, or cannot be measured at all.
    pub fn make(&self, run: &StudyRun, folder: &Path, made: impl Fn() + Sync) -> Result<(), Error> {
        if StudyShare::is_in(folder) {
            let begun = StudyShare::read(folder)?;
            let why = match begun.difference(self) {
                _ if begun.share != self.share => Some("it belongs to another share".to_string()),
                other => other.map(|difference| format!("it belongs to another study ({difference})")),
            };
            if let Some(why) = why {
                let why = format!("{why}: give another folder with --out");
                return Err(Error::unfit(&folder.join(STUDY_SHARE_FILE), why));
            }
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
        share.own(self.asked.seeds()).collect()
    }

    /// The seeds of those of its trials that are not in a folder.
    pub fn missing(&self, folder: &Path) -> Vec<u64> {
        self.seeds().into_iter().filter(|&seed| !trial_file(folder, seed).exists()).collect()
    }
}

/// The folder of a share in that of its study: `shares/03-of-16`.
pub(crate) fn share_folder(study: &Path, share: Share) -> PathBuf {
    let width = share.of.to_string().len();
    study.join(SHARES_FOLDER).join(format!("{:0width$}-of-{}", share.number, share.of))
}

/// The number of shares into which the study in a folder is divided.
fn count_of_shares(study: &Path) -> Result<u64, Error> {
    let place = study.join(SHARES_FOLDER);
    if !place.is_dir() {
        let message = "it contains no shares: make them with `bodyschema study … --shard 1/3 --out DIR`, and give that DIR";
        return Err(Error::content(study, None, message));
    }
    let mut counts = BTreeSet::new();
    for entry in fs::read_dir(&place).map_err(Error::unreadable(&place))? {
        let path = entry.map_err(Error::unreadable(&place))?.path();
        let share = path.file_name().and_then(|name| name.to_str()).and_then(named);
        counts.extend(share.filter(|share| share_folder(study, *share) == path).map(|share| share.of));
    }
    let mut counts = counts.into_iter();
    match [counts.next(), counts.next()] {
        [None, _] => Err(Error::content(&place, None, "it contains no share: make one with --shard")),
        [Some(count), None] => Ok(count),
        [Some(one), Some(other)] => {
            let message = format!("it contains shares of {one} and of {other}: remove one kind");
            Err(Error::content(&place, None, message))
        }
    }
}

/// The share that a folder is named after.
fn named(name: &str) -> Option<Share> {
    let (number, of) = name.split_once("-of-")?;
    Share::new(number.parse().ok()?, of.parse().ok()?)
}

/// Shares that have to be made before all can be put together.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Unready {
    /// These shares in their order, and whether each was begun: interrupted, or being made.
    pub shares: Vec<(Share, bool)>,
    /// How one that was begun was asked for, word by word; empty if that was not kept.
    pub command: Vec<String>,
}

/// The folder of a share of a study, and its record.
pub(crate) type MadeShare = (PathBuf, StudyShare);

/// All shares of a study in a folder with their records and folders, if all are made; else which are not.
pub(crate) fn made_shares(study: &Path) -> Result<Result<Vec<MadeShare>, Unready>, Error> {
    let mut unready = Unready::default();
    let mut made: Vec<MadeShare> = Vec::new();
    for share in Share::all(count_of_shares(study)?) {
        let folder = share_folder(study, share);
        // One that was killed at once has no record yet.
        if !StudyShare::is_in(&folder) {
            unready.shares.push((share, false));
            continue;
        }
        let record = StudyShare::read(&folder)?;
        let unfit = |why: String| Err(Error::unfit(&folder.join(STUDY_SHARE_FILE), why));
        if record.share != share.to_string() {
            return unfit(format!(
                "it does not belong to share {share}: move it where it belongs, or make that share again"
            ));
        }
        match made.first() {
            None => unready.command = record.command.clone(),
            Some((other, first)) => {
                if let Some(difference) = first.difference(&record) {
                    return unfit(format!(
                        "it belongs to another study than {} ({difference}): make one of them again",
                        other.display()
                    ));
                }
            }
        }
        if !record.missing(&folder).is_empty() {
            unready.shares.push((share, true));
        }
        made.push((folder, record));
    }
    Ok(if unready.shares.is_empty() { Ok(made) } else { Err(unready) })
}

/// The first that differs of what two JSON objects say, in words; `None` if nothing does.
fn difference(one: &Value, other: &Value) -> Option<String> {
    one.as_object()?.iter().find_map(|(name, value)| match &other[name] {
        same if same == value => None,
        inner if value.is_object() && inner.is_object() => difference(value, inner),
        another => Some(format!("{name} is {value} in one, {another} in the other")),
    })
}

impl Findings {
    /// What the trials of shares come to that are all made, each in its folder.
    ///
    /// # Errors
    /// If there is no share, a file cannot be read, or holds no trial.
    pub(crate) fn of_shares(shares: &[MadeShare]) -> Result<Findings, Error> {
        let (_, first) = shares.first().ok_or_else(|| Error::usage("it contains no share of the study"))?;
        let files = |(folder, share): &MadeShare| {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_found_where_they_are_made() {
        let place = tempfile::tempdir().unwrap();
        let refused = |place: &Path| count_of_shares(place).unwrap_err().to_string();
        assert!(refused(place.path()).contains("--shard"));
        for number in [3, 16, 1] {
            fs::create_dir_all(share_folder(place.path(), Share::new(number, 16).unwrap())).unwrap();
        }
        fs::create_dir(place.path().join("shares/notes")).unwrap();
        assert_eq!(count_of_shares(place.path()).unwrap(), 16);
        let begun = |share: &Share| share_folder(place.path(), *share).is_dir();
        let begun: Vec<String> = Share::all(16).filter(begun).map(|share| share.to_string()).collect();
        assert_eq!(begun, ["1/16", "3/16", "16/16"]);
        // Without a record in its folder a share is still to be made.
        let unready = made_shares(place.path()).unwrap().unwrap_err();
        assert_eq!(unready.shares.len(), 16);
        assert!(unready.shares.iter().all(|(_, begun)| !begun));
        assert!(place.path().join("shares/03-of-16").is_dir());
        fs::create_dir(place.path().join("shares/1-of-2")).unwrap();
        assert!(refused(place.path()).contains("of 2 and of 16"));
    }

    #[test]
    fn shares_have_every_piece_once() {
        for of in [1, 3, 16] {
            for pieces in [0, 1, 7, 48, 100] {
                let mut had: Vec<u64> = Vec::new();
                for share in Share::all(of) {
                    had.extend(share.own(0..pieces));
                }
                had.sort_unstable();
                assert_eq!(had, (0..pieces).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn a_share_is_read_as_it_is_written_and_no_other_is() {
        assert_eq!("3/16".parse::<Share>().unwrap().to_string(), "3/16");
        for wrong in [
            "",
            "3",
            "/",
            "0/3",
            "4/3",
            "1/0",
            "-1/3",
            "1/3/5",
            "1 / 3",
            "1/100001",
            "99999999999999999999/1",
        ] {
            assert!(wrong.parse::<Share>().is_err(), "{wrong}");
        }
    }
}
