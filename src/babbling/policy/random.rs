//! Targets drawn uniformly from the joints' ranges: the babbling of the paper.

use rand_chacha::ChaCha8Rng;

use super::Policy;
use crate::creature::{Creature, Posture};
use crate::senses::Touch;

/// The policy `random`: independent of posture and touches.
pub struct Random {
    creature: Creature,
}

impl Random {
    /// The policy of a creature.
    pub fn new(creature: &Creature) -> Random {
        Random { creature: creature.clone() }
    }
}

impl Policy for Random {
    fn next_target(&mut self, _: &[f64], rng: &mut ChaCha8Rng) -> Posture {
        Posture::random(&self.creature, rng)
    }

    fn touched(&mut self, _: &Touch) {}
}
