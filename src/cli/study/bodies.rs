//! What the study `bodies` is asked, which makes its creatures itself.

use std::path::Path;

use super::StudyArguments;
use crate::cli::Failure;
use crate::experiment::study::bodies::BodiesOptions;

/// Refuses options of a creature for a study that makes what it is of.
pub fn refuse_creature(args: &StudyArguments) -> Result<(), Failure> {
    let given = [
        (args.model != [Path::new(crate::cli::open::MAX)], "the model"),
        (args.joints.is_some(), "--joints"),
        (args.open.root.is_some(), "--root"),
        (args.session.is_some(), "--session"),
        (args.jobs.is_some_and(|jobs| jobs != 1), "--jobs"),
    ];
    match given.into_iter().find(|(given, _)| *given) {
        Some((_, what)) => Err(Failure(format!(
            "study {} makes its bodies by its seeds, each on one thread: leave out {what}",
            args.name.name
        ))),
        None => Ok(()),
    }
}

/// Its options; refused where some are given that it does not have.
pub fn options(args: &StudyArguments) -> Result<BodiesOptions, Failure> {
    refuse_creature(args)?;
    let standard = BodiesOptions::default();
    Ok(BodiesOptions {
        touches: args.touches.unwrap_or(standard.touches),
        seconds: args.seconds.unwrap_or(standard.seconds),
        ways: if args.ways.is_empty() { standard.ways } else { args.ways.clone() },
    })
}
