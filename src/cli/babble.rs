//! `bodyschema babble`: the main job. A session begins, or goes on.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::json;

use super::folders::{Force, session_folder, written_session};
use super::learn::KNOWN_HELP;
use super::learned::learn_and_print;
use super::live::{LiveOptions, Place, rest, serve};
use super::open::{MAX, ModelArguments, embodied, is_there};
use super::progress::Bars;
use super::{Failure, Outcome, output};
use crate::creature::JointSelection;
use crate::session::{
    BabblingSession, Embodied, FolderLock, Observer, Provenance, SESSION_FILE, Session, SessionRequest,
    SessionSetup,
};
use crate::view::live::BabblingView;
use crate::view::report::REPORT_FILE;

/// Explore a body by self-touch, learn its schema, and compare it with the model.
///
/// The creature moves, at first with few joints, and stops at each self-contact. From the receptor pairs and joint
/// angles alone it learns where its joints are and how they turn, and explores what it does not know yet. The model's
/// own kinematics serve only to measure the result. Everything is written to a session folder.
#[derive(clap::Args)]
#[command(after_help = format!("Examples:
  bodyschema babble                                                          # Max, mjcf/max/max.xml
  bodyschema babble mjcf/hexapod/hexapod.xml
  bodyschema babble mjcf/max/max.xml --touches 500 --input contact --json
  bodyschema babble mjcf/max/max.xml --joints all --touches 5000 --jobs 4    # takes minutes
  bodyschema babble mjcf/max/max.xml --touches 300 --motion dynamic          # takes minutes
  bodyschema babble mjcf/max/max.xml --learner hersch --json
  bodyschema babble mjcf/max/max.xml --touches 500 --live                    # watch it in a browser
  bodyschema babble --resume sessions/max-1
  bodyschema babble mjcf/max/max.xml --touches 60 --known known.json\n\n{KNOWN_HELP}"))]
pub struct BabbleArguments {
    #[command(flatten)]
    asked: SessionArguments,
    /// The session's folder [default: the first free of sessions/CREATURE-1, -2, …]
    #[arg(long, short, value_name = "DIR", help_heading = "Output")]
    out: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Resume an interrupted session with the options in its session.json; its touches are the same as without the
    /// interruption. Can be combined with --jobs, --json and --live
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    resume: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long, help_heading = "Output")]
    json: bool,
    #[command(flatten)]
    live: LiveOptions,
}

/// The options of a session, stored in its file.
#[derive(clap::Args, Clone, Serialize, Deserialize)]
pub struct SessionArguments {
    /// The creature's MJCF or URDF file; if it has no touch sensors, some are added in memory
    #[arg(default_value = MAX, value_name = "MODEL")]
    model: PathBuf,
    /// The joints that move: a joint set named in the model (torso), all, or names separated by commas [default: torso
    /// where the model names it, else all]
    #[arg(long, help_heading = "Babbling")]
    joints: Option<JointSelection>,
    #[command(flatten)]
    #[serde(flatten)]
    request: SessionRequest,
    #[command(flatten)]
    #[serde(flatten)]
    open: ModelArguments,
}

impl SessionArguments {
    /// The options of a session; `folder` is for error messages.
    fn of_session(session: &Session, folder: &Path) -> Result<SessionArguments, Failure> {
        let place = folder.join(SESSION_FILE).display().to_string();
        if session.recording.is_some() || session.options.touches == 0 {
            return Err(Failure(format!(
                "{place}: not a babbling session; give a folder written by `bodyschema babble`"
            )));
        }
        serde_json::from_value(session.options.asked.clone()).map_err(|what| {
            Failure(format!(
                "{place}: its options cannot be used ({what}): it was written by another version of bodyschema or \
                 edited; babble again"
            ))
        })
    }

    /// What is asked with all that is chosen by default and by what else is asked, as a session keeps it: versions to come may
    /// choose otherwise.
    fn provenance(&self, setup: &SessionSetup) -> Provenance {
        let request = self.request.with_choices(setup);
        let asked = serde_json::to_value(SessionArguments { request, ..self.clone() });
        // A session of files whose names are not in UTF-8 cannot be resumed.
        Provenance { command: output::command_line(), asked: asked.unwrap_or_default() }
    }
}

pub fn run(args: &BabbleArguments) -> Outcome {
    let resumed = args.resume.as_ref().map(|folder| {
        let lock = written_session(folder)?;
        let session = Session::read(folder)?;
        Ok::<_, Failure>((SessionArguments::of_session(&session, folder)?, lock, session))
    });
    let (mut asked, resumed) = match resumed.transpose()? {
        Some((asked, lock, session)) => (asked, Some((lock, session))),
        None => (args.asked.clone(), None),
    };
    is_there(&asked.model, "babble")?;
    let embodied = embodied(asked.open.source(&asked.model, asked.joints.clone().unwrap_or_default()))?;
    asked.request.jobs = args.asked.request.jobs;
    let setup = asked.request.setup(&embodied)?;
    // Whether it can be watched is told before any folder is made.
    let page = args.live.place()?;
    let (lock, session) = match resumed {
        Some((lock, session)) => {
            let session = BabblingSession::resume(&embodied, &setup, &lock, session)?;
            if is_complete(&session, &lock, args.json, setup.babbling.touches)? {
                return Ok(());
            }
            (lock, session)
        }
        None => {
            let lock = session_folder(args.out.as_deref(), embodied.creature().name(), args.force)?;
            let session = BabblingSession::begin(&embodied, &setup, &lock, asked.provenance(&setup))?;
            (lock, session)
        }
    };
    complete(session, lock, (&embodied, &setup), page, args.json)
}

/// Reports how many of `all` touches a resumed session has; returns whether nothing is left to do in its folder.
fn is_complete(
    session: &BabblingSession,
    lock: &FolderLock,
    as_json: bool,
    all: usize,
) -> Result<bool, Failure> {
    let (folder, made, zeros) = (lock.folder(), session.made(), session.zeros());
    let place = folder.display();
    if session.is_babbled() && folder.join(REPORT_FILE).exists() {
        tell!("{place} is complete: nothing left to do");
        if as_json {
            output::json(&json!({"session": folder, "touches": made, "complete": true}))?;
        }
        return Ok(true);
    }
    if zeros > 0 {
        tell!("{place}: its log ended in {zeros} zero bytes, as after a power failure; they were removed");
    }
    match session.is_babbled() {
        true => tell!("{place}: all {made} touches are present; learning from them"),
        false => tell!("{place}: resuming after touch {made} of {all}"),
    }
    Ok(false)
}

/// Makes touches while somebody may look on, learns from all of them, and prints the result.
fn complete(
    session: BabblingSession,
    lock: FolderLock,
    (embodied, setup): (&Embodied, &SessionSetup),
    page: Option<Place>,
    as_json: bool,
) -> Outcome {
    let (agent, truth) = (embodied.agent(), embodied.truth());
    let page = page.map(|place| {
        let view = Arc::new(BabblingView::new(agent, truth, setup.babbling.touches, session.made()));
        Ok::<_, Failure>((serve(place, view.clone())?, view))
    });
    let page = page.transpose()?;
    let bars = Bars::default();
    let pages = page.iter().map(|(_, view)| &**view as &dyn Observer);
    let observers: Vec<&dyn Observer> = std::iter::once(&bars as &dyn Observer).chain(pages).collect();
    let babbled = session.babble(&observers)?;
    if let Some(limit) = babbled.session.effort.and_then(|effort| effort.ended_by) {
        tell!("babbling ended {limit}, after {} touches", babbled.touches.len());
    }
    let result = learn_and_print(&lock, &babbled, &setup.learning, Some(truth), &observers, as_json)?;
    // Who goes on looking keeps nobody from the folder.
    let report = lock.place().join(REPORT_FILE);
    drop(lock);
    if let Some((server, view)) = page {
        view.done(&result.record.verdict, &result.learned.schema, report);
        rest(&server);
    }
    Ok(())
}
