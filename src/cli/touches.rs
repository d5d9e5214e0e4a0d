//! Making touches: what commands that babble share.

use std::path::Path;

use super::Failure;
use crate::babbling::{Babbler, BabblingError, BabblingOptions, Effort, MotionName, PolicyName};
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

/// Babbles and hands on every touch; errors name the file of the `model`.
pub fn make_touches(
    model: &Path,
    babbler: &Babbler,
    policy: PolicyName,
    options: &BabblingOptions,
    receive: impl FnMut(&Touch) -> Result<(), RecordError>,
) -> Result<Effort, Failure> {
    babbler.babble_by(policy, options, receive).map_err(|error| failure(model, error))
}

fn failure(model: &Path, error: BabblingError<RecordError>) -> Failure {
    match error {
        BabblingError::Receiver(error) => Failure::from(error),
        other => Failure(format!("{}: {other}", model.display())),
    }
}
