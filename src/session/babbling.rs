//! A session: a creature babbles, and all of it goes into a folder, from which an interrupted session goes on.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::{
    BabblingEffort, BabblingProgress, Embodied, FolderLock, Observer, Phase, SESSION_FILE, Session,
    SessionOptions, SessionSetup, TOUCHES_FILE, TouchWriter, model_hash, read_touches,
};
use crate::babbling::{BoutsDone, Made, PolicyName};
use crate::deadline::{apart, count};
use crate::error::Error;
use crate::learning::growth::Growth;
use crate::senses::RecordedTouch;
use crate::simulation::{Effort, MotionName};
use crate::skin::Skin;

/// How often it is written down how far babbling has come.
const KEPT_EVERY: Duration = Duration::from_secs(1);

/// What asked for a session, as it is kept in it; empty where that was no command line.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Provenance {
    /// The command line, word by word.
    pub command: Vec<String>,
    /// What it was asked, as [`SessionOptions::asked`].
    pub asked: serde_json::Value,
}

/// A session of which touches are to be made or all are.
pub struct BabblingSession<'a> {
    embodied: &'a Embodied,
    setup: &'a SessionSetup,
    folder: PathBuf,
    session: Session,
    /// The log, ready for the touch after those of `done`; `None` if all touches are made.
    log: Option<TouchWriter<'a>>,
    /// Whether it was begun here, with an empty log.
    begun: bool,
    before: Before,
}

/// What need not be made again of a session that is resumed.
#[derive(Default)]
struct Before {
    /// Whole bouts.
    done: BoutsDone,
    /// The time that they took.
    spent: Duration,
    /// Their touches.
    touches: Vec<RecordedTouch>,
}

/// A session of which all touches are made.
#[derive(Clone, Debug)]
pub struct BabbledSession {
    /// The session, with what babbling cost.
    pub session: Session,
    /// Its touches.
    pub touches: Vec<RecordedTouch>,
    /// What was learned from them on the way; `None` if nothing was, or it is not known any more.
    pub grown: Option<Growth>,
}

impl<'a> BabblingSession<'a> {
    /// Begins a session in a folder, which is its writer's alone; keep the lock until all is done.
    ///
    /// # Errors
    /// Where a file cannot be read or written, or there is a session or a log in the folder already.
    pub fn begin(
        embodied: &'a Embodied,
        setup: &'a SessionSetup,
        lock: &FolderLock,
        provenance: Provenance,
    ) -> Result<BabblingSession<'a>, Error> {
        let folder = lock.folder();
        for file in [SESSION_FILE, TOUCHES_FILE] {
            if folder.join(file).exists() {
                let reason = "it already exists: give another folder with --out, or move it away";
                return Err(Error::unfit(&folder.join(file), reason));
            }
        }
        let (source, learning) = (embodied.source(), &setup.learning);
        let forces = Some(setup.motion).filter(|motion| *motion != MotionName::default());
        let session = Session {
            engine: embodied.body().model.version().to_string(),
            model: source.model.display().to_string(),
            model_hash: model_hash(&source.model)?,
            command: provenance.command,
            seed: setup.babbling.seed,
            options: SessionOptions {
                touches: setup.babbling.touches,
                joints: source.joints.to_string(),
                root: source.root.clone(),
                input: Some(learning.input().to_string()),
                learner: Some(learning.kind().name().to_string()),
                known: learning.known.as_ref().map(|known| known.display().to_string()),
                policy: Some(setup.policy.to_string()),
                motion: forces.map(|motion| motion.to_string()),
                asked: provenance.asked,
            },
            agent: embodied.agent().clone(),
            ..Session::made_here()
        };
        session.write(folder)?;
        let log = Some(TouchWriter::create(folder, embodied.agent())?);
        let (folder, before) = (folder.to_path_buf(), Before::default());
        Ok(BabblingSession { embodied, setup, folder, session, log, begun: true, before })
    }

    /// Goes on with an interrupted session in its folder, with the setup that it was begun with: its touches become
    /// what they would have been.
    pub(crate) fn resume(
        embodied: &'a Embodied,
        setup: &'a SessionSetup,
        lock: &FolderLock,
        session: Session,
    ) -> Result<BabblingSession<'a>, Error> {
        let folder = lock.folder();
        check_same(&session, embodied, folder)?;
        let (agent, log_file) = (embodied.agent(), folder.join(TOUCHES_FILE));
        let (mut before, place) = (Before::default(), folder.to_path_buf());
        if let Some(effort) = &session.effort {
            let wanted = effort.touches.unwrap_or(setup.babbling.touches);
            before.touches = read_touches(&log_file, agent)?.touches;
            let found = before.touches.len();
            if found != wanted {
                let reason = format!(
                    "it has {found} of {wanted} touches although babbling was complete: lines were added or lost; \
                     babble again with --out"
                );
                return Err(Error::unfit(&log_file, reason));
            }
            let (log, begun, folder) = (None, false, place);
            return Ok(BabblingSession { embodied, setup, folder, session, log, begun, before });
        }
        if let Some(progress) = BabblingProgress::read(folder)
            && let Ok(spent) = Duration::try_from_secs_f64(progress.effort.babbling_s)
            && setup.policy == PolicyName::Random
        {
            (before.done, before.spent) = (progress.done(), spent);
        }
        let mut log = TouchWriter::resume(folder, agent)?;
        let touches = before.done.touches;
        if log.skip(touches)? < touches {
            // The disk lost some: all are made once more.
            drop(log);
            log = TouchWriter::resume(folder, agent)?;
            before = Before::default();
        } else if touches > 0 {
            before.touches = read_touches(&log_file, agent)?.touches;
            before.touches.truncate(touches);
        }
        let (log, begun, folder) = (Some(log), false, place);
        Ok(BabblingSession { embodied, setup, folder, session, log, begun, before })
    }

    /// Whether all touches are made.
    pub(crate) fn is_babbled(&self) -> bool {
        self.log.is_none()
    }

    /// How many zero bytes were at the end of the log, as a file system leaves them where the power failed; they are dropped.
    pub(crate) fn zeros(&self) -> usize {
        self.log.as_ref().map_or(0, TouchWriter::zeros)
    }

    /// How many touches are there already.
    pub(crate) fn made(&self) -> usize {
        self.before.touches.len()
    }

    /// Babbles what is missing, and writes every touch into the log as soon as it is made; nothing is done where all are.
    ///
    /// # Errors
    /// If the engine fails, nothing can be touched, or a file cannot be written; a session that was interrupted so can be
    /// resumed.
    pub fn babble(self, observer: &dyn Observer) -> Result<BabbledSession, Error> {
        let BabblingSession { embodied, setup, folder, mut session, log, begun, before } = self;
        let Before { done, spent, touches: mut made } = before;
        let Some(mut log) = log else { return Ok(BabbledSession { session, touches: made, grown: None }) };
        let babbler =
            embodied.babbler(setup.motion)?.until(setup.deadline).learning_from(setup.learning.input());
        observer.phase(Phase::Babbling {
            made: made.len(),
            touches: setup.babbling.touches,
            grows: setup.policy == PolicyName::Stages,
            deadline: setup.deadline,
        });
        let began = Instant::now();
        let mut kept = began;
        let cost = |of_motions: Effort| {
            let babbling_s = (spent + began.elapsed()).as_secs_f64();
            BabblingEffort { of_motions, babbling_s, ..BabblingEffort::default() }
        };
        let (babbled, tally) = apart(|| {
            babbler.babble(setup.policy, done, &setup.babbling, |news| {
                match news {
                    Made::Touch(touch) => {
                        log.write(touch)?;
                        observer.touched(touch);
                        made.push(touch.clone());
                    }
                    // Bouts can be shorter than it takes to write this down.
                    Made::Bout(done) if kept.elapsed() >= KEPT_EVERY => {
                        let BoutsDone { bouts, touches, effort } = done;
                        BabblingProgress { bouts, touches, effort: cost(effort) }.write(&folder)?;
                        kept = Instant::now();
                    }
                    Made::Bout(_) => {}
                    Made::Grown(growth) => observer.grew(growth),
                }
                Ok(())
            })
        });
        count(tally);
        if babbled.is_err() && begun && made.is_empty() {
            // There is nothing to go on with.
            [TOUCHES_FILE, SESSION_FILE].iter().for_each(|file| drop(fs::remove_file(folder.join(file))));
        }
        let (effort, grown) = babbled.map_err(Error::of_model(embodied.model()))?;
        observer.phase(Phase::Done);
        let touches = Some(made.len()).filter(|&made| made != setup.babbling.touches);
        let ended_by = tally.ended.then(|| setup.deadline.limit());
        session.effort = Some(BabblingEffort { touches, ended_by, ..cost(effort) });
        log.finish()?;
        session.write(&folder)?;
        BabblingProgress::remove(&folder);
        Ok(BabbledSession { session, touches: made, grown })
    }
}

/// Whether the session's creature and engine are still the same, without which touches would be others.
fn check_same(session: &Session, embodied: &Embodied, folder: &Path) -> Result<(), Error> {
    let version = embodied.body().model.version().to_string();
    if session.engine != version {
        return Err(Error::unfit(
            &folder.join(SESSION_FILE),
            format!(
                "it was begun with MuJoCo {}, but this is {version}: resume with that version, or babble again",
                session.engine
            ),
        ));
    }
    let model = Path::new(&session.model);
    if session.model_hash != model_hash(model)?
        || session.agent.creature() != embodied.creature()
        || written(session.agent.skin()) != written(embodied.agent().skin())
    {
        return Err(Error::unfit(
            model,
            format!(
                "it has changed since the session in {} was begun: restore it, or babble again",
                folder.display()
            ),
        ));
    }
    Ok(())
}

/// A skin as it is written: what no file holds of it is no difference.
fn written(skin: &Skin) -> Option<serde_json::Value> {
    serde_json::to_value(skin).ok()
}
