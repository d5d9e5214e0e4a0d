//! A session: a creature babbles, and all of it goes into a folder, from which an interrupted session goes on.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::embodied::Embodied;
use super::learning_options::LearningOptions;
use super::observer::{Observer, Phase};
use super::shares::{MadeShares, ShareRecord, bouts_of, time_spent};
use crate::babbling::{Babbler, BabblingOptions, BoutsDone, Made, PolicyName};
use crate::deadline::{Deadline, apart, count};
use crate::error::Error;
use crate::learning::growth::Growth;
use crate::senses::RecordedTouch;
use crate::session::{
    BabblingEffort, BabblingProgress, BoutLine, BoutLog, FolderLock, SESSION_FILE, Session, SessionOptions,
    TOUCHES_FILE, TouchWriter, model_hash, read_bouts, read_touches,
};
use crate::share::Share;
use crate::simulation::{Effort, MotionName};
use crate::skin::Skin;

/// How often it is written down how far babbling has come.
const KEPT_EVERY: Duration = Duration::from_secs(1);

/// How a session goes.
#[derive(Clone)]
pub struct SessionSetup {
    /// Touches to make, the seed of all random numbers, and threads.
    pub babbling: BabblingOptions,
    /// How motions are chosen.
    pub policy: PolicyName,
    /// How the body is moved.
    pub motion: MotionName,
    /// After which no touches are made any more.
    pub deadline: Deadline,
    /// The share of the session that is made; `None` for all of it.
    pub share: Option<Share>,
    /// How to learn.
    pub learning: LearningOptions,
}

/// What asked for a session, as it is kept in it; empty where that was no command line.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Provenance {
    /// The command line, word by word.
    pub command: Vec<String>,
    /// What it was asked, as [`SessionOptions::asked`].
    pub asked: serde_json::Value,
}

/// A session, or a share of one, of which touches are to be made or all are.
pub struct BabblingSession<'a> {
    embodied: &'a Embodied,
    setup: &'a SessionSetup,
    folder: PathBuf,
    session: Session,
    /// The log, ready for the touch after those of `done`; `None` if all touches are made.
    log: Option<TouchWriter<'a>>,
    /// Whether it was begun here, with an empty log.
    begun: bool,
    /// Of a share, the bouts and what each cost.
    bouts: Option<BoutLog>,
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
        let session = new_session(embodied, setup, provenance)?;
        session.write(folder)?;
        let log = Some(TouchWriter::create(folder, embodied.agent())?);
        let bouts = setup.share.map(|_| BoutLog::go_on(folder, &[])).transpose()?;
        let (folder, before) = (folder.to_path_buf(), Before::default());
        Ok(BabblingSession { embodied, setup, folder, session, log, begun: true, bouts, before })
    }

    /// Begins the share of the setup in its folder, or goes on with what is there of it.
    pub(crate) fn take_up(
        embodied: &'a Embodied,
        setup: &'a SessionSetup,
        lock: &FolderLock,
        provenance: Provenance,
    ) -> Result<BabblingSession<'a>, Error> {
        let folder = lock.folder();
        if !folder.join(SESSION_FILE).exists() {
            return BabblingSession::begin(embodied, setup, lock, provenance);
        }
        let session = Session::read(folder)?;
        session.check(folder, &new_session(embodied, setup, provenance)?)?;
        BabblingSession::resume(embodied, setup, lock, session)
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
            let (log, begun, bouts, folder) = (None, false, None, place);
            return Ok(BabblingSession { embodied, setup, folder, session, log, begun, bouts, before });
        }
        // The bouts that are done: those of a share one by one, those of a session at random in all.
        let mut lines = Vec::new();
        if let Some(share) = setup.share {
            lines = read_bouts(folder, share)?;
            for line in &lines {
                before.done.bouts += 1;
                before.done.touches += line.touches;
                before.done.effort += line.effort;
            }
        } else if let Some(progress) = BabblingProgress::read(folder)
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
            lines.clear();
        } else if touches > 0 {
            before.touches = read_touches(&log_file, agent)?.touches;
            before.touches.truncate(touches);
        }
        let bouts = setup.share.map(|_| BoutLog::go_on(folder, &lines)).transpose()?;
        let (log, begun, folder) = (Some(log), false, place);
        Ok(BabblingSession { embodied, setup, folder, session, log, begun, bouts, before })
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

    /// Babbles what is missing, and writes every touch into the log as soon as it is made. A share counts as made, though it
    /// has no touch, where so many bouts bring none that one process would give up.
    ///
    /// # Errors
    /// If the engine fails, nothing can be touched, or a file cannot be written; a session that was interrupted so can be
    /// resumed.
    pub fn babble(self, observer: &dyn Observer) -> Result<BabbledSession, Error> {
        let SessionSetup { babbling, policy, share, .. } = self.setup;
        let model = self.embodied.model();
        self.make(observer, |babbler, done, receive| {
            let made = match share {
                Some(share) => {
                    babbler.babble_share(*share, done, babbling, receive).map(|done| (done.effort, None))
                }
                None => babbler.babble(*policy, done, babbling, receive),
            };
            made.map_err(Error::of_model(model))
        })
    }

    /// Puts shares of the session together: the log becomes what one process would have written. What is missing for that
    /// at the end, as where bouts brought few touches, is babbled.
    pub(crate) fn put_together(
        self,
        shares: &MadeShares<Session>,
        observer: &dyn Observer,
    ) -> Result<BabbledSession, Error> {
        let (model, options) = (self.embodied.model(), &self.setup.babbling);
        let agent = self.embodied.agent();
        // Where this was interrupted before, their time is counted already.
        let spent = if self.before.touches.is_empty() { time_spent(shares) } else { self.before.spent };
        BabblingSession { before: Before { spent, ..self.before }, ..self }.make(
            observer,
            |babbler, done, receive| {
                let effort = babbler.put_together(done, options, bouts_of(shares, agent)?, receive);
                Ok((effort.map_err(Error::of_model(model))?, None))
            },
        )
    }

    /// Writes touches into the log as they are made, in whatever way; nothing is done where all are.
    fn make(
        self,
        observer: &dyn Observer,
        make: impl FnOnce(
            &Babbler,
            BoutsDone,
            &mut dyn FnMut(Made) -> Result<(), Error>,
        ) -> Result<(Effort, Option<Growth>), Error>,
    ) -> Result<BabbledSession, Error> {
        let BabblingSession { embodied, setup, folder, mut session, log, begun, mut bouts, before } = self;
        let Before { done, spent, touches: mut made } = before;
        let Some(mut log) = log else { return Ok(BabbledSession { session, touches: made, grown: None }) };
        let babbler =
            embodied.babbler(setup.motion)?.until(setup.deadline).learning_from(setup.learning.input());
        observer.phase(Phase::Babbling {
            made: made.len(),
            touches: match setup.share {
                Some(share) => setup.babbling.touches.div_ceil(share.of() as usize).max(made.len()),
                None => setup.babbling.touches,
            },
            grows: setup.policy == PolicyName::Stages,
            deadline: setup.deadline,
        });
        let began = Instant::now();
        let (mut kept, mut before) = (began, made.len());
        let cost = |of_motions: Effort| {
            let babbling_s = (spent + began.elapsed()).as_secs_f64();
            BabblingEffort { of_motions, babbling_s, ..BabblingEffort::default() }
        };
        let (babbled, tally) = apart(|| {
            make(&babbler, done, &mut |news| {
                match news {
                    Made::Touch(touch) => {
                        log.write(touch)?;
                        observer.touched(touch);
                        made.push(touch.clone());
                    }
                    Made::Bout(done, effort) => match setup.share.zip(bouts.as_mut()) {
                        Some((share, log)) => {
                            let bout = share.piece(done.bouts - 1);
                            log.write(&BoutLine { bout, touches: done.touches - before, effort })?;
                            before = done.touches;
                        }
                        // Bouts can be shorter than it takes to write this down.
                        None if kept.elapsed() >= KEPT_EVERY => {
                            let BoutsDone { bouts, touches, effort } = done;
                            BabblingProgress { bouts, touches, effort: cost(effort) }.write(&folder)?;
                            kept = Instant::now();
                        }
                        None => {}
                    },
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
        let (effort, grown) = babbled?;
        observer.phase(Phase::Done);
        let touches =
            Some(made.len()).filter(|&made| made != setup.babbling.touches || setup.share.is_some());
        let ended_by = tally.ended.then(|| setup.deadline.limit());
        session.effort = Some(BabblingEffort { touches, ended_by, ..cost(effort) });
        log.finish()?;
        bouts.map_or(Ok(()), BoutLog::finish)?;
        session.write(&folder)?;
        BabblingProgress::remove(&folder);
        Ok(BabbledSession { session, touches: made, grown })
    }
}

fn new_session(embodied: &Embodied, setup: &SessionSetup, provenance: Provenance) -> Result<Session, Error> {
    let (source, learning) = (embodied.source(), &setup.learning);
    Ok(Session {
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
            motion: Some(setup.motion)
                .filter(|motion| *motion != MotionName::default())
                .map(|m| m.to_string()),
            share: setup.share.map(|share| share.to_string()),
            asked: provenance.asked,
        },
        agent: embodied.agent().clone(),
        ..Session::made_here()
    })
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
