//! The options of a session, and the defaults for a creature.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::embodied::Embodied;
use super::learning_options::LearningOptions;
use crate::babbling::{BabblingOptions, PolicyName, threads};
use crate::deadline::Deadline;
use crate::error::Result;
#[cfg(feature = "cli")]
use crate::given_number::{count, positive};
use crate::learning::growth::Growth;
use crate::learning::learners::{LearnerKind, PartByPart};
use crate::senses::joint_sensors;
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
    /// How to learn.
    pub learning: LearningOptions,
}

/// What is asked of a session. What is left open is chosen as `bodyschema babble` chooses it.
#[derive(Clone, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::Args), command(next_help_heading = "Babbling"))]
pub struct SessionRequest {
    /// Number of touches; the policy stages stops early once everything that can be touched is known [default: 1000; up
    /// to 4000 for stages]
    #[cfg_attr(feature = "cli", arg(long, value_parser = count))]
    pub touches: Option<usize>,
    /// Stop after this many seconds and keep what has been learned; how much depends on the computer's load [default: none]
    #[cfg_attr(feature = "cli", arg(long, value_parser = positive, conflicts_with = "work"))]
    pub seconds: Option<f64>,
    /// Stop after this much work, in units of about one second on one core, the same on any computer [default: 50; none with
    /// --seconds, --touches or --motion dynamic]
    #[cfg_attr(feature = "cli", arg(long, value_parser = positive))]
    pub work: Option<f64>,
    /// Seed of all random numbers: the same seed gives the same touches
    #[cfg_attr(feature = "cli", arg(long, default_value_t = 1))]
    pub seed: u64,
    /// How motions are chosen; every policy but random learns a schema along the way to choose by, on one thread [default:
    /// random with disturbances, dynamic motion, --known, --skin centres or a learner other than growth; else stages]
    #[cfg_attr(feature = "cli", arg(long, value_enum))]
    pub policy: Option<PolicyName>,
    /// How the body is moved: straight from posture to posture, or by servos in a simulation with gravity
    #[cfg_attr(feature = "cli", arg(long, value_enum, default_value_t))]
    pub motion: MotionName,
    /// Number of threads; affects only the running time [default: one per core]
    #[cfg_attr(feature = "cli", arg(long, value_parser = clap::value_parser!(u16).range(1..=1024)))]
    #[serde(skip)]
    pub jobs: Option<u16>,
    /// How to learn.
    #[cfg_attr(feature = "cli", command(flatten))]
    #[serde(flatten)]
    pub learning: LearningOptions,
}

impl Default for SessionRequest {
    fn default() -> SessionRequest {
        SessionRequest {
            touches: None,
            seconds: None,
            work: None,
            seed: 1,
            jobs: None,
            policy: None,
            motion: MotionName::default(),
            learning: LearningOptions::default(),
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
        let patient = self.touches.is_some() || self.seconds.is_some() || self.motion == MotionName::Dynamic;
        self.work.or((!patient).then_some(WORK))
    }

    /// The same request with all that was chosen for it, so that other versions choose alike.
    pub(crate) fn with_choices(&self, setup: &SessionSetup) -> SessionRequest {
        SessionRequest {
            touches: Some(setup.babbling.touches),
            work: self.work(),
            policy: Some(setup.policy),
            learning: setup.learning.clone(),
            ..self.clone()
        }
    }

    /// All that is chosen for a creature; seconds and work are counted from here on.
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
        let began = Instant::now();
        let deadline = |share: f64| match (self.work(), self.seconds) {
            (Some(work), _) => Deadline::after_work_of(share * work),
            (None, Some(seconds)) => Duration::try_from_secs_f64(share * seconds)
                .map_or(Deadline::Asked, |time| Deadline::after(began, time)),
            (None, None) => Deadline::Asked,
        };
        let creature = embodied.creature();
        // Noise of a model's own joint sensors is noise as any.
        let exact = joint_sensors(embodied.body()).iter().flatten().all(|sensor| sensor.noise == 0.0);
        let asked = self.learning.learner.is_none_or(|learner| learner.name() == PartByPart.name());
        let stages = exact && self.learning.grows() && asked && self.motion == MotionName::Kinematic;
        let stages = stages && Growth::suits(creature);
        let policy = self.policy.unwrap_or(if stages { PolicyName::Stages } else { PolicyName::Random });
        let learning = LearningOptions { deadline: deadline(LEARNING_SHARE), ..self.learning.clone() };
        let learning = learning.chosen(Some(policy).filter(|_| exact), creature)?;
        let most = if policy == PolicyName::Stages { MOST_TOUCHES } else { TOUCHES };
        let touches = self.touches.unwrap_or(most);
        let babbling = BabblingOptions { touches, seed: self.seed, jobs: threads(self.jobs) };
        Ok(SessionSetup {
            babbling,
            policy,
            motion: self.motion,
            deadline: deadline(BABBLING_SHARE),
            learning,
        })
    }
}
