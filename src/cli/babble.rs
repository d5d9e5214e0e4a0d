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

/// Babble, touch, learn the body schema, and measure it.
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
}

pub fn run(args: &BabbleArguments) -> Outcome {
    let job = |asked: SessionArguments| Job::new(asked, args.asked.request.jobs, args.json, &args.live);
    match &args.resume {
        Some(folder) => {
            let lock = written_session(folder)?;
            let asked = SessionArguments::of_session(&Session::read(folder)?, folder)?;
            job(asked)?.go_on(lock)
        }
        None => {
            let job = job(args.asked.clone())?;
            let lock = session_folder(args.out.as_deref(), job.embodied.creature().name(), args.force)?;
            job.begin(lock)
        }
    }
}

/// A session that is asked for, with all that is made ready before the first touch.
struct Job {
    asked: SessionArguments,
    embodied: Embodied,
    setup: SessionSetup,
    /// Where a page is to be served, if one is.
    place: Option<Place>,
    json: bool,
}

impl Job {
    fn new(
        mut asked: SessionArguments,
        jobs: Option<u16>,
        json: bool,
        live: &LiveOptions,
    ) -> Result<Job, Failure> {
        is_there(&asked.model, "babble")?;
        let embodied = embodied(asked.open.source(&asked.model, asked.joints.clone().unwrap_or_default()))?;
        asked.request.jobs = jobs;
        let setup = asked.request.setup(&embodied)?;
        // Whether it can be watched is told before any folder is made.
        Ok(Job { asked, embodied, setup, place: live.place()?, json })
    }

    /// What is asked with all that is chosen by default and by what else is asked, as a session keeps it: versions to come may
    /// choose otherwise.
    fn provenance(&self) -> Provenance {
        let request = self.asked.request.with_choices(&self.setup);
        let asked = serde_json::to_value(SessionArguments { request, ..self.asked.clone() });
        // A session of files whose names are not in UTF-8 cannot be resumed.
        Provenance { command: output::command_line(), asked: asked.unwrap_or_default() }
    }

    /// Begins a session, and learns from its touches.
    fn begin(mut self, lock: FolderLock) -> Outcome {
        let place = self.place.take();
        let session = BabblingSession::begin(&self.embodied, &self.setup, &lock, self.provenance())?;
        self.complete(session, lock, place)
    }

    /// Does what is missing in a session's folder: touches, learning, the report.
    fn go_on(mut self, lock: FolderLock) -> Outcome {
        let (folder, page) = (lock.folder().to_path_buf(), self.place.take());
        let place = folder.display();
        let session = Session::read(&folder)?;
        let session = BabblingSession::resume(&self.embodied, &self.setup, &lock, session)?;
        let (made, all) = (session.made(), self.setup.babbling.touches);
        if session.is_babbled() && folder.join(REPORT_FILE).exists() {
            tell!("{place} is complete: nothing left to do");
            if self.json {
                output::json(&json!({"session": folder, "touches": made, "complete": true}))?;
            }
            return Ok(());
        }
        if session.zeros() > 0 {
            let zeros = session.zeros();
            tell!(
                "{place}: its log ended in {zeros} zero bytes, as after a power failure; they were removed"
            );
        }
        match session.is_babbled() {
            true => tell!("{place}: all {made} touches are present; learning from them"),
            false => tell!("{place}: resuming after touch {made} of {all}"),
        }
        self.complete(session, lock, page)
    }

    /// Makes touches while somebody may look on, learns from all of them, and prints the result.
    fn complete(&self, session: BabblingSession, lock: FolderLock, page: Option<Place>) -> Outcome {
        let (touches, made) = (self.setup.babbling.touches, session.made());
        let page = page.map(|place| {
            let view = BabblingView::new(self.embodied.agent(), self.embodied.truth(), touches, made);
            let view = Arc::new(view);
            Ok::<_, Failure>((serve(place, view.clone())?, view))
        });
        let page = page.transpose()?;
        let bars = Bars::default();
        let pages = page.iter().map(|(_, view)| &**view as &dyn Observer);
        let observers: Vec<&dyn Observer> = std::iter::once(&bars as &dyn Observer).chain(pages).collect();
        let babbled = session.babble(&observers)?;
        let truth = Some(self.embodied.truth());
        if let Some(limit) = babbled.session.effort.and_then(|effort| effort.ended_by) {
            tell!("babbling ended {limit}, after {} touches", babbled.touches.len());
        }
        let result = learn_and_print(&lock, &babbled, &self.setup.learning, truth, &observers, self.json)?;
        // Who goes on looking keeps nobody from the folder.
        let report = lock.place().join(REPORT_FILE);
        drop(lock);
        if let Some((server, view)) = page {
            view.done(&result.record.verdict, &result.learned.schema, report);
            rest(&server);
        }
        Ok(())
    }
}
