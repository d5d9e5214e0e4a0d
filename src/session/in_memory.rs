//! Babbling and learning in memory: `Agent::from_mjcf(path)?.babble(500)?.learn()?`.

use std::path::Path;

use super::embodied::{Embodied, ModelSource};
use super::learning_options::LearningOptions;
use super::touches::all_touches;
use crate::agent::Agent;
use crate::babbling::{BabblingOptions, Made, Policy, PolicyName};
use crate::error::Error;
use crate::evaluation::{Evaluation, evaluate_learned};
use crate::learning::{Learned, Learner};
use crate::peripersonal::OwnBody;
use crate::senses::{Input, RecordedTouch, Touch};
use crate::simulation::MotionName;

/// The seed where none is chosen.
const SEED: u64 = 1;

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
}

/// A creature that has learned its body, with the account of what it knows.
pub struct LearnedBody {
    embodied: Embodied,
    touches: Vec<RecordedTouch>,
    learned: Learned,
}

impl Embodied {
    /// Babbles at random, on all cores, until it has touched itself so many times; always the same touches.
    ///
    /// # Errors
    /// Where nothing of it can touch anything, and where the engine fails.
    pub fn babble(self, touches: usize) -> Result<Babbled, Error> {
        let jobs = std::thread::available_parallelism().map_or(1, usize::from);
        self.babble_by(
            PolicyName::Random,
            MotionName::default(),
            &BabblingOptions { touches, seed: SEED, jobs },
        )
    }

    /// Babbles by a policy and a kind of motion.
    ///
    /// # Errors
    /// See [`Embodied::babble`].
    pub fn babble_by(
        self,
        policy: PolicyName,
        motion: MotionName,
        options: &BabblingOptions,
    ) -> Result<Babbled, Error> {
        let babbler = self.babbler(motion)?;
        let (touches, _) = all_touches(self.model(), &babbler, policy, options)?;
        drop(babbler);
        Ok(Babbled { embodied: self, touches, seed: options.seed })
    }

    /// Babbles by a policy of one's own.
    ///
    /// # Errors
    /// See [`Embodied::babble`].
    pub fn babble_with(self, policy: &mut dyn Policy, options: &BabblingOptions) -> Result<Babbled, Error> {
        let mut touches = Vec::with_capacity(options.touches);
        let babbler = self.babbler(MotionName::default())?;
        let receive = |made: Made| -> Result<(), Error> {
            if let Made::Touch(touch) = made {
                touches.push(touch.clone());
            }
            Ok(())
        };
        babbler.babble_with(policy, options, receive).map_err(Error::of_model(self.model()))?;
        drop(babbler);
        Ok(Babbled { embodied: self, touches, seed: options.seed })
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
    /// Where there is no touch to learn from.
    pub fn learn(self) -> Result<LearnedBody, Error> {
        self.learn_by(&LearningOptions::default())
    }

    /// Learns otherwise than by default.
    ///
    /// # Errors
    /// Where there is no touch to learn from, or the options are not for this creature.
    pub fn learn_by(self, options: &LearningOptions) -> Result<LearnedBody, Error> {
        options.check(self.embodied.creature())?;
        let learned = {
            let agent = self.embodied.agent();
            let felt =
                options.disturbances.disturbances().felt(agent, &self.touches, options.input(), self.seed);
            let mut learner = options.learner(&felt.agent, self.seed);
            learn_from(&felt.agent, learner.as_mut(), &felt.touches)?
        };
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
