//! `bodyschema view`: sessions and models in a browser.

use std::io::IsTerminal;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::learned::read_log;
use super::open::{MAX, ModelArguments, embodied, known_truth};
use super::{Failure, Outcome, live};
use crate::creature::JointSelection;
use crate::session::{LearningRecord, ReadLock, SCHEMA_FILE, SESSION_FILE, Session, read_schema};
use crate::view::live::{LookedAt, LookingView};

/// Where sessions are, unless they are named.
const SESSIONS: &str = "sessions";
/// Most of those that are listed, the newest first.
const MOST: usize = 20;

/// Explore sessions and models in a browser: touch by touch, in any posture, side by side.
///
/// A page served on this machine shows a session's learned body, over the true one in grey if the model is available. A
/// slider steps through the touches and lights up their receptors; others set the joints to any posture; a click on a
/// limb shows how well it is located and where it can reach. Two sessions are shown side by side; with more, the page
/// lets you choose. Without arguments, the newest session in the folder sessions is shown. The page is served until
/// Enter or Ctrl-C or, without a terminal (in a script or a service), until the process ends.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema view
  bodyschema view sessions/max-1
  bodyschema view sessions/max-1 mjcf/max/max.xml --no-open
  bodyschema view mjcf/hexapod/hexapod.xml")]
pub struct ViewArguments {
    /// Session folders, and MJCF or URDF files
    #[arg(value_name = "MODEL|SESSION")]
    what: Vec<PathBuf>,
    /// For sessions: the model, if it is not at the path recorded in them
    #[arg(long)]
    model: Option<PathBuf>,
    /// Address of the page: this machine only unless another is given [default: 127.0.0.1:8042, or a free port]
    #[arg(long, value_name = "ADDRESS", value_parser = live::address, help_heading = "Output")]
    live: Option<SocketAddr>,
    /// Print the address without opening a browser; without a terminal none is opened either
    #[arg(long, help_heading = "Output")]
    no_open: bool,
    #[command(flatten)]
    options: ModelArguments,
}

pub fn run(args: &ViewArguments) -> Outcome {
    // An address that cannot be had is told of before anything is read.
    let place = live::Place::new(args.live, !args.no_open && std::io::stdin().is_terminal())?;
    let what = if args.what.is_empty() { newest()? } else { args.what.clone() };
    let all = what.iter().map(|one| looked_at(one, args)).collect::<Result<Vec<LookedAt>, Failure>>()?;
    live::look(LookingView::new(all), place)
}

/// The newest sessions of the usual folder.
fn newest() -> Result<Vec<PathBuf>, Failure> {
    let mut sessions: Vec<(SystemTime, PathBuf)> = std::fs::read_dir(SESSIONS)
        .into_iter()
        .flatten()
        .filter_map(|entry| {
            let path = entry.ok()?.path();
            // What is not learned yet has no body to look at.
            let made = std::fs::metadata(path.join(SCHEMA_FILE)).ok()?.modified().ok()?;
            path.join(SESSION_FILE).exists().then_some((made, path))
        })
        .collect();
    sessions.sort_by(|a, b| b.cmp(a));
    sessions.truncate(MOST);
    if sessions.is_empty() {
        return Err(Failure(format!(
            "{SESSIONS}: it contains no learned session: make one with `bodyschema babble {MAX}`, or give a \
             session or a model"
        )));
    }
    // One of many is looked at, unless another is chosen.
    Ok(sessions.into_iter().map(|(_, path)| path).collect())
}

fn looked_at(what: &Path, args: &ViewArguments) -> Result<LookedAt, Failure> {
    let name = what.display().to_string();
    if !what.join(SESSION_FILE).exists() && !what.is_dir() {
        let embodied = embodied(args.options.source(what, JointSelection::All))?;
        let truth = embodied.truth();
        return Ok(LookedAt {
            name,
            agent: embodied.agent().clone(),
            schema: truth.schema.clone(),
            truth: None,
            appearance: Some(truth.appearance.clone()),
            record: None,
            touches: Vec::new(),
        });
    }
    let _reading = ReadLock::take(what)?;
    let session = Session::read(what)?;
    let creature = session.agent.creature();
    let schema = read_schema(&what.join(SCHEMA_FILE), creature)?;
    let touches = read_log(what, &session.agent)?;
    let record = Some(LearningRecord::read(what, creature)?);
    let truth = known_truth(&session, args.model.as_deref())?;
    Ok(LookedAt {
        name,
        schema,
        appearance: truth.as_ref().map(|truth| truth.appearance.clone()),
        truth: truth.map(|truth| truth.schema),
        record,
        touches,
        agent: session.agent,
    })
}
