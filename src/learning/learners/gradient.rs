//! `gradient`: Hersch's rule repaired.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::{LearnerGivens, LearnerKind};
use crate::agent::Agent;
use crate::learning::initial_guess::random_guess;
use crate::learning::{Learner, RelaxedGradient};

/// Hersch's rule repaired: its gradient over all touches, relaxed.
#[derive(Clone, Copy, Debug)]
pub struct RepairedHersch;

impl LearnerKind for RepairedHersch {
    fn name(&self) -> &'static str {
        "gradient"
    }

    fn about(&self) -> &'static str {
        "Hersch's rule repaired"
    }

    fn learner(&self, agent: &Agent, given: &LearnerGivens, seed: u64) -> Box<dyn Learner> {
        let initial_guess = random_guess(agent.creature(), &mut ChaCha8Rng::seed_from_u64(seed));
        Box::new(RelaxedGradient::new(agent, given.input, initial_guess, seed))
    }
}
