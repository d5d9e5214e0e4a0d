//! `bodyschema babble`: the main job. A session begins, goes on, is made share by share, or is put together of shares.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::json;

use super::folders::{Force, session_folder, take_share, written_session};
use super::learn::KNOWN_HELP;
use super::learned::learn_and_print;
use super::live::{LiveOptions, Place, rest, serve};
use super::open::{MAX, ModelArguments, embodied, is_there};
use super::progress::Bars;
use super::{Failure, Outcome, output};
use crate::creature::JointSelection;
use crate::session::{
    BabblingSession, Embodied, FolderLock, MadeShares, Observer, Provenance, SESSION_FILE, Session,
    SessionRequest, SessionSetup,
};
use crate::share::Share;
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
  bodyschema babble mjcf/max/max.xml --touches 100000 --shard 3/16 --out sessions/big  # takes minutes
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
    /// Babble only this share of the session, such as 3/16. Other processes, on this machine or others, make the rest,
    /// and `bodyschema study merge DIR` merges all shares into what a single process would have written. Babbles at
    /// random; the same command resumes an interrupted share
    #[arg(
        long,
        value_name = "SHARE",
        requires = "out",
        conflicts_with_all = ["resume", "seconds", "work", "force"],
        help_heading = "Output"
    )]
    shard: Option<Share>,
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
    pub fn of_session(session: &Session, folder: &Path) -> Result<SessionArguments, Failure> {
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
    let job =
        |asked: SessionArguments| Job::new(asked, args.asked.request.jobs, args.shard, args.json, &args.live);
    match (&args.resume, args.shard, &args.out) {
        (Some(folder), ..) => {
            let lock = written_session(folder)?;
            let asked = SessionArguments::of_session(&Session::read(folder)?, folder)?;
            job(asked)?.go_on(lock, None)
        }
        (None, Some(share), Some(folder)) => make_share(&job(args.asked.clone())?, share, folder),
        _ => {
            let job = job(args.asked.clone())?;
            let lock = session_folder(args.out.as_deref(), job.embodied.creature().name(), args.force)?;
            job.begin(lock, None)
        }
    }
}

/// A session that is asked for, with all that is made ready before the first touch.
pub struct Job {
    asked: SessionArguments,
    embodied: Embodied,
    setup: SessionSetup,
    /// Where a page is to be served, if one is.
    place: Option<Place>,
    json: bool,
}

impl Job {
    pub fn new(
        mut asked: SessionArguments,
        jobs: Option<u16>,
        share: Option<Share>,
        json: bool,
        live: &LiveOptions,
    ) -> Result<Job, Failure> {
        is_there(&asked.model, "babble")?;
        let embodied = embodied(asked.open.source(&asked.model, asked.joints.clone().unwrap_or_default()))?;
        (asked.request.jobs, asked.request.share) = (jobs, share);
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

    /// Begins a session, whose touches are those of `shares` if there are any, and learns from them.
    pub fn begin(mut self, lock: FolderLock, shares: Option<&MadeShares<Session>>) -> Outcome {
        let place = self.place.take();
        let session = BabblingSession::begin(&self.embodied, &self.setup, &lock, self.provenance())?;
        self.complete(session, lock, place, shares)
    }

    /// Does what is missing in a session's folder: touches, of `shares` if there are any, learning, the report.
    pub fn go_on(mut self, lock: FolderLock, shares: Option<&MadeShares<Session>>) -> Outcome {
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
        self.complete(session, lock, page, shares)
    }

    /// Makes touches while somebody may look on, learns from all of them, and prints the result.
    fn complete(
        &self,
        session: BabblingSession,
        lock: FolderLock,
        page: Option<Place>,
        shares: Option<&MadeShares<Session>>,
    ) -> Outcome {
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
        let babbled = match shares {
            Some(shares) => session.put_together(shares, &observers)?,
            None => session.babble(&observers)?,
        };
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

/// Makes one share of a session in its place below a folder, or what is missing of it; `bodyschema study merge` puts it
/// together with the others.
fn make_share(job: &Job, share: Share, folder: &Path) -> Outcome {
    let lock = take_share(folder, share, SESSION_FILE)?;
    let place = lock.folder();
    let session = BabblingSession::take_up(&job.embodied, &job.setup, &lock, job.provenance())?;
    match session.made() {
        _ if session.is_babbled() => tell!("{} is complete: nothing left to do", place.display()),
        0 => {}
        made => tell!("{}: resuming after touch {made}", place.display()),
    }
    let session = session.babble(&Bars::default())?.session;
    let effort = session.effort;
    let touches = effort.and_then(|effort| effort.touches).unwrap_or_default();
    if let Some(effort) = effort.filter(|effort| effort.touches == Some(0)) {
        tell!("no touch in {} motions of this share", effort.of_motions.motions);
    }
    if job.json {
        return output::json(&json!({
            "share": share.to_string(),
            "touches": touches,
            "motions": effort.map(|effort| effort.of_motions.motions),
            "babbling_s": effort.map(|effort| effort.babbling_s),
            "folder": place,
        }));
    }
    say!("share {share}: {touches} touches, in {}", place.display());
    say!("once all {} shares are made: `bodyschema study merge {}`", share.of(), folder.display());
    Ok(())
}
