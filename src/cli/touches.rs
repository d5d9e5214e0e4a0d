//! Making touches: what commands that babble share.

use std::path::Path;

use super::Failure;
use crate::babbling::{
    Babbler, BabblingError, BabblingOptions, BoutsDone, Effort, Made, MotionName, PolicyName,
};
use crate::creature::Body;
use crate::record::RecordError;
use crate::senses::Touch;
use crate::skin::Skin;

/// A number of touches from the command line.
pub fn touch_count(text: &str) -> Result<usize, String> {
    match text.parse::<usize>() {
        Ok(0) => Err("there is nothing to learn from 0 touches: give at least 1".into()),
        Ok(n) if n <= 100_000_000 => Ok(n),
        _ => Err("give a whole number from 1 to 100000000".into()),
    }
}

/// The threads asked for, or one per core.
pub fn threads(jobs: Option<u16>) -> usize {
    jobs.map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from)
}

/// Prepares a body for babbling; errors name the file of its `model`.
pub fn babbler<'a>(
    model: &Path,
    body: &'a Body,
    skin: &'a Skin,
    motion: MotionName,
) -> Result<Babbler<'a>, Failure> {
    let babbler = Babbler::new(body, skin).map_err(|error| failure(model, error))?;
    babbler.moved(motion).map_err(|error| failure(model, BabblingError::Engine(error)))
}

/// Babbles and hands on every touch, from where the bouts in `from` end; errors name the file of the `model`.
///
/// Policies other than random have no bouts, and begin at the beginning.
pub fn make_touches(
    model: &Path,
    babbler: &Babbler,
    policy: PolicyName,
    from: BoutsDone,
    options: &BabblingOptions,
    mut receive: impl FnMut(Made) -> Result<(), RecordError>,
) -> Result<Effort, Failure> {
    let effort = match policy {
        PolicyName::Random => babbler.babble_on(from, options, receive),
        _ => babbler.babble_by(policy, options, |touch| receive(Made::Touch(touch))),
    };
    effort.map_err(|error| failure(model, error))
}

/// The touches alone, from the first on.
pub fn all_touches(
    model: &Path,
    babbler: &Babbler,
    policy: PolicyName,
    options: &BabblingOptions,
    mut receive: impl FnMut(&Touch),
) -> Result<Effort, Failure> {
    make_touches(model, babbler, policy, BoutsDone::default(), options, |made| {
        if let Made::Touch(touch) = made {
            receive(touch);
        }
        Ok(())
    })
}

fn failure(model: &Path, error: BabblingError<RecordError>) -> Failure {
    match error {
        BabblingError::Receiver(error) => Failure::from(error),
        other => Failure(format!("{}: {other}", model.display())),
    }
}
