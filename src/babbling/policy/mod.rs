//! How the next motion is chosen: at random, or by what was touched so far.
//!
//! A policy knows what the agent knows: the joints' ranges, the skin in its limbs' own frames, and the
//! touches. Where the limbs are it believes by a schema that it learns as it goes.

mod experience;
mod explorer;
mod information;
mod informative;
mod random;
mod steered;
mod working_schema;

use rand_chacha::ChaCha8Rng;

pub use informative::Informative;
pub use random::Random;
pub use steered::Steered;
pub use working_schema::WorkingSchema;

use crate::babbling::Ending;
use crate::creature::Creature;
use crate::learning::RoughFit;
use crate::senses::Touch;
use crate::skin::Skin;

/// How the next motion is chosen.
pub trait Policy {
    /// The posture to move towards from `posture`. The motion stops at the first contact, whatever it is.
    fn next_target(&mut self, posture: &[f64], rng: &mut ChaCha8Rng) -> Vec<f64>;

    /// Takes in the touch that the motion ended in.
    fn touched(&mut self, touch: &Touch);

    /// Takes in that the motion brought no touch, how it ended, and in which posture.
    fn missed(&mut self, _ending: &Ending, _posture: &[f64]) {}
}

/// The policies by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum PolicyName {
    /// Uniformly random postures.
    #[default]
    Random,
    /// Towards limbs whose joints need touches, with few motions.
    Steered,
    /// Towards the touches that would tell most, whatever the motions.
    Informative,
}

impl std::fmt::Display for PolicyName {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            PolicyName::Random => "random",
            PolicyName::Steered => "steered",
            PolicyName::Informative => "informative",
        })
    }
}

impl PolicyName {
    /// The policy of a creature with a skin; what it learns by on the way starts from `seed`.
    pub fn policy<'a>(self, creature: &'a Creature, skin: &'a Skin, seed: u64) -> Box<dyn Policy + 'a> {
        let working = || WorkingSchema::new(Box::new(RoughFit::new(creature, skin, seed)));
        match self {
            PolicyName::Random => Box::new(Random::new(creature)),
            PolicyName::Steered => Box::new(Steered::new(creature, skin, working())),
            PolicyName::Informative => Box::new(Informative::new(creature, skin, working())),
        }
    }
}
