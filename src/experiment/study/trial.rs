//! Trials: what a study is made of, one of them from one seed.
//!
//! A trial depends on its seed alone, not on those before it nor on who makes it: so processes share them, and what they
//! found is put together later. What a trial leaves is text in Rusty Object Notation, which keeps every number to the
//! last bit, those that are not finite too; findings are always drawn from that text, whoever wrote it.

use std::time::Instant;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::{Findings, FoundTables, StudyRow, Subject, WallTime};
use crate::experiment::ExperimentError;

/// What one seed came to, in a study; it holds all that the findings need.
pub trait Trial: Serialize + DeserializeOwned {
    /// What trials share that one process makes: it is made once, and no trial changes it.
    type Setting;
    /// A row of all measurements.
    type Measurement: StudyRow;
    /// A row of the summary.
    type Summary: StudyRow;

    /// What trials share; it is the same in every process.
    ///
    /// # Errors
    /// Where the study cannot be made of this subject.
    fn set_up(subject: &Subject) -> Result<Self::Setting, ExperimentError>;

    /// The trial of a seed. One that does not succeed is a finding; only what cannot be measured fails.
    ///
    /// # Errors
    /// Where something cannot be measured at all.
    fn run(subject: &Subject, setting: &Self::Setting, seed: u64) -> Result<Self, ExperimentError>;

    /// What all trials say, in the order of their seeds.
    fn findings(subject: &Subject, trials: &[Self]) -> Findings<Self::Measurement, Self::Summary>;
}

/// Takes what a trial left, with the seed that it is of.
pub type ReceiveTrial<'a> = dyn FnMut(u64, String) -> Result<(), ExperimentError> + 'a;

/// What trials found, and how long all of them took.
pub type Concluded = Result<(FoundTables, WallTime), ExperimentError>;

/// A study's trials, of whatever kind.
pub struct Trials {
    run: fn(&Subject, &[u64], &mut ReceiveTrial) -> Result<(), ExperimentError>,
    conclude: fn(&Subject, &[String]) -> Concluded,
}

/// What a trial leaves, and how long it took where it was made.
#[derive(Serialize, Deserialize)]
struct Recorded<T> {
    seconds: WallTime,
    trial: T,
}

impl Trials {
    /// Trials of a kind.
    pub const fn of<T: Trial>() -> Trials {
        Trials { run: run::<T>, conclude: conclude::<T> }
    }

    /// Makes the trials of some seeds, one after the other, and hands on what each left as soon as it is done.
    ///
    /// # Errors
    /// Where something cannot be measured at all, or the receiver fails.
    pub fn run(
        &self,
        subject: &Subject,
        seeds: &[u64],
        receive: &mut ReceiveTrial,
    ) -> Result<(), ExperimentError> {
        (self.run)(subject, seeds, receive)
    }

    /// What trials say that left these texts, in the order of their seeds, and how long all of them took.
    ///
    /// # Errors
    /// [`ExperimentError::Refused`] where a text is not of this study's trials.
    pub fn conclude(&self, subject: &Subject, left: &[String]) -> Concluded {
        (self.conclude)(subject, left)
    }
}

/// Makes all trials of a subject, and says what they found.
///
/// # Errors
/// Where something cannot be measured at all.
pub fn measure<T: Trial>(subject: &Subject) -> Result<Findings<T::Measurement, T::Summary>, ExperimentError> {
    let setting = T::set_up(subject)?;
    let trials = subject.seeds.iter().map(|&seed| T::run(subject, &setting, seed));
    Ok(T::findings(subject, &trials.collect::<Result<Vec<T>, _>>()?))
}

fn run<T: Trial>(
    subject: &Subject,
    seeds: &[u64],
    receive: &mut ReceiveTrial,
) -> Result<(), ExperimentError> {
    if seeds.is_empty() {
        return Ok(());
    }
    let setting = T::set_up(subject)?;
    record(seeds, receive, |seed| T::run(subject, &setting, seed))
}

fn conclude<T: Trial>(subject: &Subject, left: &[String]) -> Concluded {
    let (trials, seconds) = read::<T>(left)?;
    Ok((T::findings(subject, &trials).into(), seconds))
}

/// Makes trials of seeds, and hands on what each left as soon as it is done.
///
/// # Errors
/// Where a trial or the receiver fails.
pub fn record<T: Serialize>(
    seeds: &[u64],
    receive: &mut ReceiveTrial,
    mut trial: impl FnMut(u64) -> Result<T, ExperimentError>,
) -> Result<(), ExperimentError> {
    for &seed in seeds {
        let began = Instant::now();
        let trial = trial(seed)?;
        let recorded = Recorded { seconds: WallTime(began.elapsed().as_secs_f64()), trial };
        let text = ron::to_string(&recorded).map_err(|error| ExperimentError::refused(error.to_string()))?;
        receive(seed, text)?;
    }
    Ok(())
}

/// Trials by what they left, and how long all of them took.
///
/// # Errors
/// [`ExperimentError::Refused`] where a text is not of such a trial.
pub fn read<T: DeserializeOwned>(left: &[String]) -> Result<(Vec<T>, WallTime), ExperimentError> {
    let (mut trials, mut all) = (Vec::with_capacity(left.len()), 0.0);
    for text in left {
        let recorded: Recorded<T> = ron::from_str(text)
            .map_err(|error| ExperimentError::refused(format!("it is no trial of this study ({error})")))?;
        all += recorded.seconds.0;
        trials.push(recorded.trial);
    }
    Ok((trials, WallTime(all)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Serialize, Deserialize)]
    struct Numbers {
        values: Vec<f64>,
        seed: u64,
        none: Option<String>,
    }

    #[test]
    fn what_a_trial_leaves_is_read_again_to_the_last_bit() {
        let values = vec![
            0.1 + 0.2,
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            -0.0,
            5e-324,
            f64::MAX,
            1e21,
            1.0 / 3.0,
        ];
        let text = ron::to_string(&Numbers { values: values.clone(), seed: u64::MAX, none: None }).unwrap();
        let read: Numbers = ron::from_str(&text).unwrap();
        assert_eq!((read.seed, read.none), (u64::MAX, None));
        for (value, read) in values.iter().zip(&read.values) {
            assert!(
                value.to_bits() == read.to_bits() || value.is_nan() && read.is_nan(),
                "{value} is read as {read}"
            );
        }
    }
}
