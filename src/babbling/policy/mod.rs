//! How the next motion is chosen: at random, or by what was touched so far.
//!
//! A policy knows what the agent knows: the joints' ranges, the skin in its limbs' own frames, and the
//! touches. Where the limbs are it believes by a schema that it learns as it goes.

mod experience;
mod explorer;
mod foresight;
mod in_unit;
mod information;
mod informative;
mod random;
mod stages;
mod steered;
mod wide;
mod working_schema;

use rand_chacha::ChaCha8Rng;

pub use foresight::{Foreseen, Foresight};
pub use in_unit::PolicyInUnit;
pub use informative::Informative;
pub use random::Random;
pub use stages::Stages;
pub use steered::Steered;
pub use working_schema::WorkingSchema;

use crate::agent::Agent;
use crate::creature::Posture;
use crate::deadline::Deadline;
use crate::learning::growth::Growth;
use crate::learning::{Input, RoughFit};
use crate::named::named;
use crate::senses::Touch;
use crate::simulation::Ending;

/// How the next motion is chosen.
pub trait Policy {
    /// The posture to move towards from `posture`. The motion stops at the first contact, whatever it is.
    fn next_target(&mut self, posture: &[f64], rng: &mut ChaCha8Rng) -> Posture;

    /// Whether the next motion is to begin where the body starts, rather than where the last one ended.
    fn starts_over(&mut self) -> bool {
        false
    }

    /// Whether nothing is left that more touches would tell.
    fn is_done(&self) -> bool {
        false
    }

    /// Takes in what touches are to be learned from: what their ends report.
    fn learns_from(&mut self, _input: Input) {}

    /// Lets nothing more be learned on the way after a deadline.
    fn end_at(&mut self, _deadline: Deadline) {}

    /// What was learned on the way by a policy that learns all that can be learned; none by others.
    fn grown(&self) -> Option<&Growth> {
        None
    }

    /// Takes in the touch that the motion ended in.
    fn touched(&mut self, touch: &Touch);

    /// Takes in that the motion brought no touch, how it ended, and in which posture.
    fn missed(&mut self, _ending: &Ending, _posture: &[f64]) {}
}

/// Names the policies: a line each, with what it is and how it is made for an agent, the seed of what it learns on the
/// way, and the default first.
macro_rules! policies {
    ($($(#[$about:meta])* $policy:ident, $name:literal => $make:expr;)+) => {
        /// The policies by name.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        #[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
        pub enum PolicyName {
            $($(#[$about])* $policy),+
        }

        named!(PolicyName, "policy", { $($policy => $name),+ });

        impl PolicyName {
            /// The policy of an agent; what it learns by on the way starts from `seed`.
            pub fn policy<'a>(self, agent: &'a Agent, seed: u64) -> Box<dyn Policy + 'a> {
                match self {
                    $(PolicyName::$policy => {
                        let make: for<'b> fn(&'b Agent, u64) -> Box<dyn Policy + 'b> = $make;
                        make(agent, seed)
                    })+
                }
            }
        }
    };
}

// To add a policy, write a file beside this one and a line here.
policies! {
    /// Uniformly random postures.
    #[default]
    Random, "random" => |agent, _| Box::new(Random::new(agent.creature()));
    /// Few joints at first, and more as they are known, until all is.
    Stages, "stages" => |agent, seed| Box::new(PolicyInUnit::of(agent, |agent| Stages::new(agent, seed)));
    /// Towards limbs whose joints need touches, with few motions.
    Steered, "steered" => |agent, seed| Box::new(Steered::new(agent, working_schema(agent, seed)));
    /// Towards the touches that would tell most, whatever the motions.
    Informative, "informative" => |agent, seed| Box::new(Informative::new(agent, working_schema(agent, seed)));
}

/// The schema that a policy learns as it goes, from scratch.
fn working_schema(agent: &Agent, seed: u64) -> WorkingSchema<'_> {
    WorkingSchema::new(Box::new(RoughFit::new(agent, seed)))
}
