//! Targets drawn uniformly from the joints' ranges: the babbling of the paper.

use rand_chacha::ChaCha8Rng;

use super::Policy;
use crate::creature::{Creature, Posture};
use crate::senses::Touch;

/// The policy `random`: it heeds neither its posture nor its touches.
pub struct Random<'a> {
    creature: &'a Creature,
}

impl<'a> Random<'a> {
    /// The policy of a creature.
    pub fn new(creature: &'a Creature) -> Random<'a> {
        Random { creature }
    }
}

impl Policy for Random<'_> {
    fn next_target(&mut self, _: &[f64], rng: &mut ChaCha8Rng) -> Posture {
        Posture::random(self.creature, rng)
    }

    fn touched(&mut self, _: &Touch) {}
}
