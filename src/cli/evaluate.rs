//! `bodyschema evaluate`: measure a session's schema.

use std::path::PathBuf;

use serde_json::json;

use super::learned::{print_evaluation, print_knowledge, warn_truncated};
use super::open::session_truth;
use super::{Outcome, output, progress};
use crate::evaluation::{Evaluation, evaluate_claims, touch_misses};
use crate::record::{
    LearningRecord, ReadLock, SCHEMA_FILE, Session, TOUCHES_FILE, read_schema, read_touches,
};

/// Measure a session's schema against the model it was babbled on.
///
/// At random postures that were not babbled: where the skin of every limb lands relative to every other limb,
/// learned against true; the angles between learned and true axes and the distances between their lines; and the
/// contact residual of the touches. The verdict is that of learning: the truth does not change what may be claimed.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema evaluate sessions/max-1
  bodyschema evaluate sessions/max-1 --model mjcf/max/max.xml --json")]
pub struct EvaluateArguments {
    /// The session's folder
    session: PathBuf,
    /// The model, where it is not at the path in the session
    #[arg(long)]
    model: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long, help_heading = "Output")]
    json: bool,
}

pub fn run(args: &EvaluateArguments) -> Outcome {
    let _reading = ReadLock::take(&args.session)?;
    let session = Session::read(&args.session)?;
    let log = read_touches(&args.session.join(TOUCHES_FILE), &session.agent)?;
    warn_truncated(&log, &args.session);
    let schema = read_schema(&args.session.join(SCHEMA_FILE), session.agent.creature())?;
    if session.model.is_empty() && args.model.is_none() {
        let folder = args.session.display();
        return Err(format!("{folder} is of a recording, which has no model to measure against: name one with --model, or use `bodyschema observe {folder}`").into());
    }
    let truth = session_truth(&session, args.model.as_deref())?;
    let spinner = progress::spinner("measuring");
    let record = LearningRecord::read_or_unknown(&args.session, session.agent.creature())?;
    let evaluation = evaluate_claims(&session.agent, &truth, &schema, record.reliable_account());
    let misses = touch_misses(&session.agent, &schema, &log.touches);
    spinner.finish_and_clear();
    if args.json {
        let measured = json!({
            "session": args.session,
            "creature": session.agent.creature().name(),
            "touches": log.touches.len(),
            "heldout_mm": evaluation.heldout_mm,
            "determined_mm": evaluation.determined_mm,
            "bound_mm": record.bound,
            "hand_mm": evaluation.hand_mm,
            "axis_deg": evaluation.axis_deg,
            "axis_line_mm": evaluation.axis_line_mm,
            "touch_mm": misses,
        });
        return output::json(&output::joined(measured, record.knowledge_json()));
    }
    say!("{}: schema of {}", args.session.display(), session.agent.creature().name());
    print_knowledge(&record);
    say!("");
    print_evaluation(&Evaluation { bound_mm: record.bound, ..evaluation });
    say!("");
    output::row("contact residual of all touches", "mm", &misses);
    Ok(())
}
