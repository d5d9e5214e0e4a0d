//! Shares of a study: making one, and putting all together.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::asked::AskedStudy;
use super::{StudyArguments, conclusion};
use crate::cli::arguments::{Arguments, taken_up};
use crate::cli::folders::{Force, free_folder};
use crate::cli::progress::Bars;
use crate::cli::shard::take_share;
use crate::cli::{Failure, Outcome, output};
use crate::experiment::{ExperimentError, Observer, Phase, Unready};
use crate::record::{
    FolderLock, STUDY_FILE, STUDY_SHARE_FILE, Shares, StudyShare, read_trial, trial_file, write_trial,
};
use crate::share::Share;

/// Makes the trials of a share that are missing, a file each.
pub fn make(asked: &AskedStudy, share: Share, folder: &Path, given: Arguments, bars: &Bars) -> Outcome {
    let lock = take_share(folder, share, STUDY_FILE)?;
    let place = lock.folder();
    let new = StudyShare {
        share: share.to_string(),
        command: output::command_line(),
        arguments: given,
        common: asked.about()?,
    };
    if place.join(STUDY_SHARE_FILE).exists() {
        let there = StudyShare::read(place)?;
        if there.common != new.common {
            return Err(Failure(format!(
                "{}: it is the share of another study than the one asked for ({}): give another folder with --out",
                place.join(STUDY_SHARE_FILE).display(),
                difference(&there.common, &new.common)
            )));
        }
    } else {
        new.write(place)?;
    }
    let own = own_seeds(share, &asked.seeds);
    let missing: Vec<u64> = own.iter().copied().filter(|&seed| !trial_file(place, seed).exists()).collect();
    if missing.is_empty() {
        tell!("{} is complete: nothing is left to do", place.display());
    } else if missing.len() < own.len() {
        tell!(
            "{}: {} of {} trials are there; going on",
            place.display(),
            own.len() - missing.len(),
            own.len()
        );
    }
    asked.run(&missing, &mut |seed, trial| Ok(write_trial(place, seed, &trial)?))?;
    bars.phase(Phase::Done);
    if asked.args.json {
        return output::json(&json!({"share": share.to_string(), "trials": own.len(), "folder": place}));
    }
    let trials = if own.len() == 1 { "trial" } else { "trials" };
    say!("share {share}: {} {trials}, in {}", own.len(), place.display());
    say!("next, when all {} shares are made: `bodyschema merge {}`", share.of(), folder.display());
    Ok(())
}

/// The seeds of a share's trials.
fn own_seeds(share: Share, seeds: &[u64]) -> Vec<u64> {
    (0..share.of_first(seeds.len() as u64)).map(|own| seeds[share.piece(own) as usize]).collect()
}

/// Whether the shares that were begun are of a study.
pub fn are_of_study(shares: &Shares) -> bool {
    shares.begun().any(|(_, folder)| folder.join(STUDY_SHARE_FILE).exists())
}

/// All shares of a study.
pub struct StudyShares {
    /// What was asked.
    args: StudyArguments,
    first: StudyShare,
    /// Where the trial of each seed is.
    trials: BTreeMap<u64, PathBuf>,
}

impl StudyShares {
    /// Looks for them; tells which are not made.
    pub fn find(shares: &Shares) -> Result<Result<StudyShares, Unready>, Failure> {
        let mut unready = Unready { missing: shares.missing(), ..Unready::default() };
        let mut begun: Vec<(Share, &Path, StudyShare)> = Vec::new();
        for (share, place) in shares.begun() {
            if !place.join(STUDY_SHARE_FILE).exists() {
                unready.missing.push(share);
                continue;
            }
            let there = StudyShare::read(place)?;
            let file = place.join(STUDY_SHARE_FILE);
            if there.share != share.to_string() {
                return Err(Failure(format!(
                    "{}: it is not of share {share}: move it where it belongs, or make that share again",
                    file.display()
                )));
            }
            if let Some((_, other, first)) = begun.first().filter(|(.., first)| first.common != there.common)
            {
                return Err(Failure(format!(
                    "{}: it is not of the study that {} is of ({}): make one of them again",
                    file.display(),
                    other.display(),
                    difference(&first.common, &there.common)
                )));
            }
            begun.push((share, place, there));
        }
        let Some((_, place, first)) = begun.first() else {
            return Ok(Err(unready));
        };
        let args = args_of(first, place)?;
        let seeds = args.seeds()?;
        let mut trials = BTreeMap::new();
        for (share, place, _) in &begun {
            let own = own_seeds(*share, &seeds);
            let made = own.iter().map(|&seed| (seed, place.to_path_buf()));
            let made: Vec<_> = made.filter(|(seed, place)| trial_file(place, *seed).exists()).collect();
            if made.len() < own.len() {
                unready.unfinished.push(*share);
            }
            trials.extend(made);
        }
        unready.command.clone_from(&first.command);
        let first = first.clone();
        let whole = unready.all().is_empty();
        Ok(if whole { Ok(StudyShares { args, first, trials }) } else { Err(unready) })
    }

    /// Writes and prints what all trials found, as one process would.
    pub fn put_together(mut self, folder: &Path, as_json: bool) -> Outcome {
        if folder.join(STUDY_FILE).exists() {
            // Of one who was killed when all was done nothing is left.
            drop(FolderLock::take(folder)?);
            tell!("{} is complete: nothing is left to do", folder.display());
            return Ok(());
        }
        self.args.json = as_json;
        let args = &self.args;
        let bars = Bars::default();
        let asked = AskedStudy::new(args, &bars)?;
        let now = asked.about()?;
        if now != self.first.common {
            return Err(Failure(format!(
                "{}: its shares are not of what would be studied here ({}): put it back as it was, or make them again",
                folder.display(),
                difference(&self.first.common, &now)
            )));
        }
        let lock = free_folder(Some(folder), Force::default(), "study", &conclusion::FILES, |_| {
            folder.to_path_buf()
        })?;
        let mut left = Vec::with_capacity(self.trials.len());
        for (seed, place) in &self.trials {
            left.push(read_trial(place, *seed)?);
        }
        let concluded = asked.conclude(&left);
        let (findings, seconds) = concluded.map_err(|error| self.blame(&asked, &left, error))?;
        conclusion::save_and_print(&asked, &lock, &findings, seconds)
    }

    /// Which trial it is that is none.
    fn blame(&self, asked: &AskedStudy, left: &[String], error: ExperimentError) -> Failure {
        for ((seed, place), text) in self.trials.iter().zip(left) {
            if let Err(error) = asked.conclude(std::slice::from_ref(text)) {
                let file = trial_file(place, *seed);
                return Failure(format!("{}: {error}: remove it and make its share again", file.display()));
            }
        }
        error.into()
    }
}

/// What differs between what two shares are of, in words.
fn difference(one: &Value, other: &Value) -> String {
    fn differing(one: &Value, other: &Value) -> Option<String> {
        let fields = one.as_object()?.iter();
        let field =
            fields.filter(|(name, _)| *name != "options").find(|(name, value)| other[*name] != **value);
        field.map(|(name, value)| format!("one's {name} is {value}, the other's {}", other[name.as_str()]))
    }
    differing(&one["options"], &other["options"])
        .or_else(|| differing(one, other))
        .unwrap_or_else(|| "it was asked otherwise".to_string())
}

/// The options that a share was made with.
fn args_of(share: &StudyShare, folder: &Path) -> Result<StudyArguments, Failure> {
    taken_up("study", &share.arguments).map_err(|what| {
        Failure(format!(
            "{}: its options cannot be used ({what}): it is of another version of bodyschema, or was changed; make \
             the shares again",
            folder.join(STUDY_SHARE_FILE).display()
        ))
    })
}
