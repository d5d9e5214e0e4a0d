//! Babbling and learning in memory: `Agent::from_mjcf(path)?.babble(500)?.learn()?`.

use std::path::Path;

use super::embodied::kept;
use super::{Embodied, LearningOptions, ModelSource, SessionRequest, SessionSetup};
use crate::agent::Agent;
use crate::babbling::{BabblingOptions, Policy};
use crate::deadline::worked;
use crate::error::{Error, Result};
use crate::evaluation::{Evaluation, evaluate_learned};
use crate::learning::growth::Growth;
use crate::learning::{Learned, Learner};
use crate::peripersonal::OwnBody;
use crate::senses::{Input, RecordedTouch, Touch};
use crate::simulation::MotionName;

impl Agent {
    /// Reads a model and the creature in it, which can babble.
    ///
    /// # Errors
    /// Where the file is not one that the engine takes, there is no creature in it that can learn, or no skin can be
    /// grown on it.
    pub fn from_mjcf(model: impl AsRef<Path>) -> Result<Embodied, Error> {
        Embodied::open(ModelSource::new(model.as_ref()), &())
    }
}

/// A creature that has babbled.
pub struct Babbled {
    embodied: Embodied,
    touches: Vec<RecordedTouch>,
    seed: u64,
    learning: LearningOptions,
    /// What was learned along the way.
    grown: Option<Growth>,
    /// How much was [`worked`] when it was done.
    worked: u64,
}

/// A creature that has learned its body, with the account of what it knows.
pub struct LearnedBody {
    embodied: Embodied,
    touches: Vec<RecordedTouch>,
    learned: Learned,
}

impl Embodied {
    /// Babbles until it has touched itself so many times, or, with `None`, as long as `bodyschema babble` does; always the
    /// same touches.
    ///
    /// # Errors
    /// If nothing of it can touch anything, or the engine fails.
    pub fn babble(self, touches: impl Into<Option<usize>>) -> Result<Babbled> {
        self.babble_as(&SessionRequest { touches: touches.into(), ..SessionRequest::default() })
    }

    /// Babbles as it is asked.
    ///
    /// # Errors
    /// As [`Embodied::babble`] and [`SessionRequest::setup`].
    pub fn babble_as(self, request: &SessionRequest) -> Result<Babbled> {
        let SessionSetup { babbling, policy, motion, deadline, learning, .. } = request.chosen(&self)?;
        let babbler = self.babbler(motion)?.until(deadline).learning_from(learning.input());
        let (touches, grown) = self.touches(&babbler, policy, &babbling)?;
        drop(babbler);
        Ok(Babbled { embodied: self, touches, seed: babbling.seed, learning, grown, worked: worked() })
    }

    /// Babbles by a policy of one's own.
    ///
    /// # Errors
    /// See [`Embodied::babble`].
    pub fn babble_with(self, policy: &mut dyn Policy, options: &BabblingOptions) -> Result<Babbled, Error> {
        let mut touches = Vec::with_capacity(options.touches);
        let babbler = self.babbler(MotionName::default())?;
        let made = babbler.babble_with(policy, options, kept(&mut touches));
        made.map_err(Error::of_model(self.model()))?;
        drop(babbler);
        let learning = LearningOptions::default();
        Ok(Babbled { embodied: self, touches, seed: options.seed, learning, grown: None, worked: worked() })
    }
}

impl Babbled {
    /// The touches.
    pub fn touches(&self) -> &[RecordedTouch] {
        &self.touches
    }

    /// The creature that made them.
    pub fn embodied(&self) -> &Embodied {
        &self.embodied
    }

    /// Learns where the joints are and how they turn, from the touches alone.
    ///
    /// # Errors
    /// If there is no touch to learn from.
    pub fn learn(self) -> Result<LearnedBody> {
        let (agent, options) = (self.embodied.agent(), &self.learning);
        let disturbances = options.disturbances.disturbances();
        let felt = disturbances.felt(agent, &self.touches, options.input(), self.seed);
        // What was learned along the way was learned of a body without the disturbances.
        let grown = self.grown.as_ref().filter(|_| disturbances.is_none());
        let mut learner = options.learner_from(&felt.agent, grown, self.seed);
        learner.end_at(options.deadline.resumed(self.worked));
        let learned = learn_from(&felt.agent, learner.as_mut(), &felt.touches)?;
        Ok(LearnedBody { embodied: self.embodied, touches: self.touches, learned })
    }

    /// Learns by a learner of one's own, which is made for the agent, from what a kind of skin reports of the touches.
    ///
    /// # Errors
    /// Where there is no touch to learn from.
    pub fn learn_with<'a, L: Learner + 'a>(
        &'a self,
        input: Input,
        make: impl FnOnce(&'a Agent) -> L,
    ) -> Result<(Learned, Evaluation), Error> {
        let mut learner = make(self.embodied.agent());
        let felt: Vec<Touch> = self.touches.iter().map(|touch| touch.felt(input)).collect();
        let learned = learn_from(self.embodied.agent(), &mut learner, &felt)?;
        let evaluation = evaluate_learned(self.embodied.agent(), self.embodied.truth(), &learned);
        Ok((learned, evaluation))
    }
}

fn learn_from(agent: &Agent, learner: &mut dyn Learner, touches: &[Touch]) -> Result<Learned, Error> {
    if touches.is_empty() {
        return Err(Error::no_touch());
    }
    touches.iter().for_each(|touch| learner.touch(touch));
    Ok(learner.learn().with_made(agent, touches))
}

impl LearnedBody {
    /// What was learned, and how far it can be trusted.
    pub fn learned(&self) -> &Learned {
        &self.learned
    }

    /// The touches that it was learned from.
    pub fn touches(&self) -> &[RecordedTouch] {
        &self.touches
    }

    /// The creature.
    pub fn embodied(&self) -> &Embodied {
        &self.embodied
    }

    /// What it knows of itself when it acts.
    pub fn own_body(&self) -> OwnBody {
        OwnBody::of(self.embodied.agent(), &self.learned, self.touches.iter().map(|touch| &touch.posture))
    }

    /// Its errors: only here does the truth come in.
    pub fn evaluation(&self) -> Evaluation {
        evaluate_learned(self.embodied.agent(), self.embodied.truth(), &self.learned)
    }
}
