//! What the study `bodies` is asked, which makes its creatures itself.

use std::path::Path;

use super::StudyArguments;
use crate::cli::Failure;
use crate::experiment::study::bodies::{BodiesOptions, STUDY};

/// Its options; refused where some are given that it does not have.
pub fn options(args: &StudyArguments) -> Result<BodiesOptions, Failure> {
    let given = [
        (args.model != [Path::new(crate::cli::open::MAX)], "the model"),
        (args.joints.is_some(), "--joints"),
        (args.open.root.is_some(), "--root"),
        (args.session.is_some(), "--session"),
        (args.jobs.is_some_and(|jobs| jobs != 1), "--jobs"),
    ];
    if let Some((_, what)) = given.into_iter().find(|(given, _)| *given) {
        return Err(Failure(format!(
            "study {} makes its creatures by its seeds, each on one thread: leave out {what}",
            STUDY.name
        )));
    }
    let standard = BodiesOptions::default();
    Ok(BodiesOptions {
        touches: args.touches.unwrap_or(standard.touches),
        seconds: args.seconds.unwrap_or(standard.seconds),
        ways: if args.ways.is_empty() { standard.ways } else { args.ways.clone() },
    })
}
