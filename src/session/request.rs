//! The options of a session, and the defaults for a creature.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use super::babbling::SessionSetup;
use super::embodied::Embodied;
use super::learning_options::LearningOptions;
use crate::babbling::{BabblingOptions, PolicyName, threads};
use crate::deadline::Deadline;
use crate::error::{Error, Result};
use crate::learning::growth::Growth;
use crate::learning::learners::{LearnerKind, PartByPart};
use crate::senses::joint_sensors;
use crate::share::Share;
use crate::simulation::MotionName;

/// Touches that are made where no number is asked for.
const TOUCHES: usize = 1000;
/// The same by stages, which end by themselves: at most.
const MOST_TOUCHES: usize = 4000;
/// Work that a session takes at most where no number of touches is asked for, in seconds of a core that does nothing else:
/// nobody is to wait much longer for a word.
const WORK: f64 = 50.0;
/// The share of it after which no touches are made.
pub(crate) const BABBLING_SHARE: f64 = 0.65;
/// The share of it after which nothing more is tried to explain them: the last fit and the measures take the rest.
pub(crate) const LEARNING_SHARE: f64 = 0.85;

/// What is asked of a session. What is left open is chosen as `bodyschema babble` chooses it.
#[derive(Clone)]
pub struct SessionRequest {
    /// Touches to make; left open 1000, by stages as many as determine the body, up to 4000.
    pub touches: Option<usize>,
    /// Seconds on the clock, from `began` on, after which the session ends with what is known by then.
    pub seconds: Option<f64>,
    /// Work after which it does so, in seconds of one core; left open 50, or without limit where `touches`, `seconds`, a share
    /// or physics are asked for.
    pub work: Option<f64>,
    /// When it began.
    pub began: Instant,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Threads; left open one per core. They change nothing but the time.
    pub jobs: Option<u16>,
    /// How motions are chosen; left open by stages where these suit the creature and what else is asked, else at random.
    pub policy: Option<PolicyName>,
    /// How the body is moved.
    pub motion: MotionName,
    /// The learner; left open growth of touches that were made by stages, else Levenberg-Marquardt.
    pub learner: Option<&'static dyn LearnerKind>,
    /// How to learn, apart from the learner and the deadline.
    pub learning: LearningOptions,
    /// A file with what is known of joints: a `schema.json`, whole or with some of them.
    pub known: Option<PathBuf>,
    /// The share of the session to babble; the other shares are made by other processes.
    pub share: Option<Share>,
}

impl Default for SessionRequest {
    fn default() -> SessionRequest {
        SessionRequest {
            touches: None,
            seconds: None,
            work: None,
            began: Instant::now(),
            seed: 1,
            jobs: None,
            policy: None,
            motion: MotionName::default(),
            learner: None,
            learning: LearningOptions::default(),
            known: None,
            share: None,
        }
    }
}

impl SessionRequest {
    /// So many touches at random.
    pub fn at_random(touches: usize, seed: u64) -> SessionRequest {
        let policy = Some(PolicyName::Random);
        SessionRequest { touches: Some(touches), seed, policy, ..SessionRequest::default() }
    }

    /// Work that the session may take; `None` if it may take as much as it likes.
    pub(crate) fn work(&self) -> Option<f64> {
        let patient = self.touches.is_some()
            || self.seconds.is_some()
            || self.share.is_some()
            || self.motion == MotionName::Dynamic;
        self.work.or((!patient).then_some(WORK))
    }

    /// All that is chosen for a creature; work is counted from here on.
    ///
    /// # Errors
    /// If the creature cannot babble, the file of known joints cannot be read, or what is asked excludes itself.
    pub fn setup(&self, embodied: &Embodied) -> Result<SessionSetup> {
        let setup = self.chosen(embodied)?;
        // Whether the creature can babble at all is found out before any folder is made.
        embodied.babbler(self.motion)?;
        Ok(setup)
    }

    /// The same for a creature of which it is found out elsewhere whether it can babble.
    pub(super) fn chosen(&self, embodied: &Embodied) -> Result<SessionSetup> {
        let deadline = |share: f64| match (self.work(), self.seconds) {
            (Some(work), _) => Deadline::after_work_of(share * work),
            (None, Some(seconds)) => Duration::try_from_secs_f64(share * seconds)
                .map_or(Deadline::Asked, |time| Deadline::after(self.began, time)),
            (None, None) => Deadline::Asked,
        };
        let creature = embodied.creature();
        // Noise of a model's own joint sensors is noise as any.
        let exact = joint_sensors(embodied.body()).iter().flatten().all(|sensor| sensor.noise == 0.0);
        let grows = exact && self.known.is_none() && self.learning.grows();
        let asked = self.learner.is_none_or(|learner| learner.name() == PartByPart.name());
        let stages = grows && asked && self.share.is_none() && self.motion == MotionName::Kinematic;
        let stages = stages && Growth::suits(creature);
        let policy = self.policy.unwrap_or(if stages { PolicyName::Stages } else { PolicyName::Random });
        if let Some(share) = self.share.filter(|_| policy != PolicyName::Random) {
            return Err(Error::usage(format!(
                "--policy {policy} learns from all earlier touches, which share {share} does not have: leave out \
                 --shard, or use --policy random"
            )));
        }
        let learner = LearningOptions::default_learner(Some(policy).filter(|_| grows));
        let learner = self.learner.unwrap_or(learner);
        let learning =
            LearningOptions { learner, deadline: deadline(LEARNING_SHARE), ..self.learning.clone() };
        let learning = learning.knowing(self.known.as_deref(), creature)?;
        let most = if policy == PolicyName::Stages { MOST_TOUCHES } else { TOUCHES };
        let touches = self.touches.unwrap_or(most);
        let babbling = BabblingOptions { touches, seed: self.seed, jobs: threads(self.jobs) };
        Ok(SessionSetup {
            babbling,
            policy,
            motion: self.motion,
            deadline: deadline(BABBLING_SHARE),
            share: self.share,
            learning,
        })
    }
}
