//! `bodyschema report`: a session as one page to read.

use std::path::PathBuf;

use super::Outcome;
use super::folders::written_session;
use super::learned::warn_truncated;
use super::open::known_truth;
use crate::record::{Session, TOUCHES_FILE, read_touches};
use crate::view::report::{REPORT_FILE, write_report};

/// Write a session's report anew: one page that opens in any browser, without a network.
///
/// It shows the learned body over the true one in three dimensions and on the way from the initial guess, the receptors by
/// how often they were touched, who touched whom, the learning curve beside its bound, the error of every joint, the
/// residuals, how sure the learner is and of what it is not, and where the hands can get to, once `bodyschema
/// space` has worked that out. `babble` and `learn` write it by themselves.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema report sessions/max-1
  bodyschema space sessions/max-1
  bodyschema report sessions/max-1
  bodyschema report sessions/max-1 --model mjcf/max/max.xml")]
pub struct ReportArguments {
    /// The session's folder
    session: PathBuf,
    /// The model to measure against, where it is not at the path in the session
    #[arg(long)]
    model: Option<PathBuf>,
}

pub fn run(args: &ReportArguments) -> Outcome {
    let folder = &args.session;
    let _lock = written_session(folder)?;
    let session = Session::read(folder)?;
    let log = read_touches(&folder.join(TOUCHES_FILE), &session.agent)?;
    warn_truncated(&log, folder);
    let truth = known_truth(&session, args.model.as_deref())?;
    write_report(folder, &session, &log.touches, truth.as_ref())?;
    say!("{}", folder.join(REPORT_FILE).display());
    Ok(())
}
