//! `bodyschema learn`: learn again from a session's touches.

use std::path::PathBuf;

use super::learn_options::{
    KNOWN_HELP, LearnOptions, learn_session, print_table, session_truth, to_json, warn_truncated,
};
use super::{Outcome, output};
use crate::record::{Session, TOUCHES_FILE, read_touches};

/// Learn again from the touches of a session.
///
/// The log alone is enough: the creature and its skin are in it. Where the model is still at hand, the result
/// is measured against it. The session's schema, table and learned model are replaced.
#[derive(clap::Args)]
#[command(after_help = format!("Examples:
  bodyschema learn sessions/max-1
  bodyschema learn sessions/max-1 --learner hersch
  bodyschema learn sessions/max-1 --touches 300 --json
  bodyschema learn sessions/max-1 --frames limb --input contact
  bodyschema learn sessions/max-1 --touches 60 --known known.json\n\n{KNOWN_HELP}"))]
pub struct Args {
    /// The session's folder
    session: PathBuf,
    /// Use only the first touches of the log
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..))]
    touches: Option<u64>,
    /// Draw the onsets from another seed than the session's
    #[arg(long)]
    seed: Option<u64>,
    #[command(flatten)]
    learn: LearnOptions,
    /// The model to measure against, where it is not at the path in the session
    #[arg(long)]
    model: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Outcome {
    let mut session = Session::read(&args.session)?;
    let log = read_touches(&args.session.join(TOUCHES_FILE), &session.creature, &session.skin)?;
    warn_truncated(&log, &args.session);
    let most = args.touches.map_or(usize::MAX, |n| usize::try_from(n).unwrap_or(usize::MAX));
    let touches = &log.touches[..log.touches.len().min(most)];
    let learn = args.learn.checked(&session.creature)?;
    session.seed = args.seed.unwrap_or(session.seed);
    let truth = match session_truth(&session, args.model.as_deref()) {
        Ok(truth) => Some(truth),
        Err(error) if args.model.is_some() => return Err(error),
        Err(super::Failure(sentence)) => {
            eprintln!("bodyschema: not measured: {sentence}");
            None
        }
    };
    let result = learn_session(&args.session, &session, touches, &learn, truth.as_ref())?;
    if args.json {
        return output::json(&to_json(&args.session, &session, touches, &learn, &result));
    }
    print_table(&args.session, &session, touches, &learn, &result);
    Ok(())
}
