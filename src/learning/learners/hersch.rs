//! `hersch`: Hersch's rule as the paper prints it.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::{LearnerGivens, LearnerKind, doubling};
use crate::agent::Agent;
use crate::learning::initial_guess::random_guess;
use crate::learning::{Hersch, Learner};

/// Hersch's rule from one random initial guess.
#[derive(Clone, Copy, Debug)]
pub struct HerschsRule;

impl LearnerKind for HerschsRule {
    fn name(&self) -> &'static str {
        "hersch"
    }

    fn about(&self) -> &'static str {
        "Hersch's rule as the paper prints it"
    }

    fn learner(&self, agent: &Agent, given: &LearnerGivens, seed: u64) -> Box<dyn Learner> {
        let initial_guess = random_guess(agent.creature(), &mut ChaCha8Rng::seed_from_u64(seed));
        Box::new(Hersch::new(agent, given.input, initial_guess))
    }

    fn learns_each_touch(&self, _: &LearnerGivens) -> bool {
        true
    }

    fn checkpoints(&self, _: &LearnerGivens, touches: usize) -> Vec<usize> {
        doubling(10, touches)
    }
}
