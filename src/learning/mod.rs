//! Learning a body schema from touches.
//!
//! A learner takes touches and gives a schema. It knows the creature (its tree, degrees of freedom and
//! ranges) and its skin (where each receptor is on its own limb), and nothing of where the joints are.

mod account;
pub mod annealing;
mod certainty;
mod curvature;
mod growing;
pub mod growth;
mod hersch;
mod in_unit;
pub mod initial_guess;
pub mod learners;
pub mod least_squares;
mod length_unit;
pub mod noise;
pub mod observability;
pub mod observation;
pub mod online;
pub mod open_gaps;
mod parameters;
mod placement;
pub mod prediction;
mod prior;
pub mod scrutiny;
mod second_order;
pub mod surface_gap;
pub mod touch_set;
mod twins;

pub use account::{Account, LimbLine, Openness, PLACED, Witnesses};
pub use certainty::{Basis, Certainty};
pub use growth::Grower;
pub use hersch::{Hersch, STEP};
pub use in_unit::LearnerInUnit;
pub use length_unit::LengthUnit;
pub use observation::{LimbFrames, SkinKnowledge};
pub use online::{BodyChange, Expectation, Online, Tool, What};
pub use parameters::{AxisModel, Parameters};
pub use placement::Z95;
pub use prior::{KnownJoint, LEAST_DEVIATION, Prior, PriorKnowledge};
pub use second_order::SecondOrder;

use std::borrow::Cow;

use crate::agent::Agent;
use crate::creature::Creature;
use crate::deadline::Deadline;
use crate::schema::{BodySchema, SchemaStd};
pub use crate::senses::Input;
use crate::senses::Touch;

/// A learner: touches in, schema out.
pub trait Learner {
    /// Takes one touch.
    fn touch(&mut self, touch: &Touch);
    /// The schema that all touches so far give.
    fn learn(&mut self) -> Learned;
    /// Makes no more starts after a deadline, so that [`Learner::learn`] comes to its end with what is known by then.
    fn end_at(&mut self, _deadline: Deadline) {}
    /// What was expected of the last touch before it was learned from; none where the learner expects nothing.
    fn expectation(&self) -> Option<Expectation> {
        None
    }
    /// The schema as it stands after the last touch; none where there is none without [`Learner::learn`].
    fn schema(&self) -> Option<Cow<'_, BodySchema>> {
        None
    }
    /// What was believed on the way, after so many touches each, where the learner keeps it.
    fn way(&self) -> Vec<(usize, BodySchema)> {
        Vec::new()
    }
}

/// What a learner came to, and how far it can be trusted.
#[derive(Clone, Debug)]
pub struct Learned {
    /// The schema.
    pub schema: BodySchema,
    /// With what it was learned.
    pub basis: Basis,
    /// Whether it stands up to touches it was not fitted to.
    pub verdict: Verdict,
    /// Random initial guesses used.
    pub initial_guesses: usize,
    /// Root mean square residual on touches it was not fitted to, in the deviations that the input allows.
    pub fresh_rms: f64,
    /// What is known of the body, and what may be said; none where the learner cannot tell.
    pub account: Option<Account>,
    /// Standard deviation of what the learner compares, as the touches themselves show it, metres.
    pub deviation: Option<f64>,
    /// How the body changed while it was learned, as far as the learner understood.
    pub changes: Vec<BodyChange>,
}

/// The learner's own judgement.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// The schema explains touches that it was not fitted to.
    Converged,
    /// It does not; why, and what to try.
    Failed(String),
    /// The learner has no judgement; why.
    Unjudged(String),
}

impl Learned {
    /// A schema of which the learner cannot tell how far off it is.
    fn unaccounted(schema: BodySchema, basis: Basis, verdict: Verdict, initial_guesses: usize) -> Learned {
        Learned {
            schema,
            basis,
            verdict,
            initial_guesses,
            fresh_rms: f64::NAN,
            account: None,
            deviation: None,
            changes: Vec::new(),
        }
    }

    /// How many joints and limbs nothing is claimed of; where nothing is claimed at all, more than there are.
    pub(crate) fn open_members(&self) -> usize {
        if self.verdict.converged() {
            self.undetermined().len() + self.undetermined_limbs().len()
        } else {
            usize::MAX
        }
    }

    /// The one of two that leaves less open, after the initial guesses of both.
    pub(crate) fn or_better(self, other: Learned) -> Learned {
        let initial_guesses = self.initial_guesses + other.initial_guesses;
        let best = if other.open_members() < self.open_members() { other } else { self };
        Learned { initial_guesses, ..best }
    }

    /// How sure the schema is: as sure as the touches make it where it stands up to fresh ones, unknown elsewhere.
    pub fn certainty(&self) -> Certainty {
        self.reliable_account()
            .map_or(Certainty::Unknown, |account| Certainty::Estimated(Box::new(account.clone())))
    }

    /// The same beside all touches that were made, those included that the learner left out.
    pub(crate) fn with_made(self, agent: &Agent, touches: &[Touch]) -> Learned {
        Learned { account: self.account.map(|account| account.with_made(agent, touches)), ..self }
    }

    /// The account that may be relied on: that of a schema that predicts held-out touches. What touches determine at
    /// a wrong schema bounds nothing.
    pub fn reliable_account(&self) -> Option<&Account> {
        self.account.as_ref().filter(|_| self.verdict.converged())
    }

    /// Standard deviations of the positions and axes; `None` without a reliable account.
    pub fn schema_std(&self, creature: &Creature) -> Option<SchemaStd> {
        self.reliable_account().map(|account| account.observability.schema_std(creature))
    }

    /// The joints that the touches do not determine; all of them without a reliable account.
    pub fn undetermined(&self) -> Vec<usize> {
        match self.reliable_account() {
            Some(account) => account.undetermined().to_vec(),
            None => (0..self.schema.positions.len()).collect(),
        }
    }

    /// The limbs that are not located though no joint between them and located ones is undetermined; none without a
    /// reliable account, for then all joints are.
    pub fn undetermined_limbs(&self) -> Vec<usize> {
        self.reliable_account().map_or(Vec::new(), |account| account.undetermined_limbs().to_vec())
    }
}

impl Verdict {
    /// Why the schema may not be relied on; `None` where it may.
    pub fn reason(&self) -> Option<&str> {
        match self {
            Verdict::Converged => None,
            Verdict::Failed(why) | Verdict::Unjudged(why) => Some(why),
        }
    }

    /// Whether the schema may be relied on.
    pub fn converged(&self) -> bool {
        *self == Verdict::Converged
    }
}
