//! Motions towards pairs of limbs whose joints need touches: most of them end in one.

use rand_chacha::ChaCha8Rng;

use super::Policy;
use super::explorer::Explorer;
use super::working_schema::WorkingSchema;
use crate::agent::Agent;
use crate::creature::Posture;
use crate::senses::Touch;
use crate::simulation::Ending;

/// Pairs drawn before a motion goes unaimed.
const DRAWS: usize = 12;

/// The policy `steered`.
pub struct Steered<'a> {
    explorer: Explorer<'a>,
}

impl<'a> Steered<'a> {
    /// The policy of a creature with a skin, aiming by a working schema.
    pub fn new(agent: &'a Agent, working: WorkingSchema<'a>) -> Steered<'a> {
        Steered { explorer: Explorer::new(agent, working) }
    }
}

impl Policy for Steered<'_> {
    fn next_target(&mut self, posture: &[f64], rng: &mut ChaCha8Rng) -> Posture {
        if self.explorer.aims(posture, rng)
            && let Some(aim) = (0..DRAWS).find_map(|_| self.explorer.draw(posture, 1.0, rng))
        {
            return self.explorer.take(aim);
        }
        self.explorer.revisit(rng)
    }

    fn touched(&mut self, touch: &Touch) {
        self.explorer.touched(touch);
    }

    fn missed(&mut self, ending: &Ending, _: &[f64]) {
        self.explorer.missed(*ending != Ending::Again);
    }
}
