//! How the next motion is chosen: at random, or from the touches so far.
//!
//! A policy knows what the agent knows: the joints' ranges, the skin in its limbs' own frames, and the
//! touches. `stages` learns the schema during babbling, and so knows where the limbs are.

mod foresight;
mod random;
mod stages;

use rand_chacha::ChaCha8Rng;

pub use foresight::{Foreseen, Foresight};
pub use random::Random;
pub use stages::Stages;

use crate::agent::Agent;
use crate::creature::Posture;
use crate::deadline::Deadline;
use crate::learning::growth::Growth;
use crate::named::named;
use crate::senses::{Input, Touch};
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

    /// What was learned along the way by a policy that learns all that can be learned; none by others.
    fn grown(&self) -> Option<&Growth> {
        None
    }

    /// Takes in the touch that the motion ended in.
    fn touched(&mut self, touch: &Touch);

    /// Takes in that the motion brought no touch, how it ended, and in which posture.
    fn missed(&mut self, _ending: &Ending, _posture: &[f64]) {}
}

/// How a policy that learns its schema during babbling begins.
#[derive(Clone, Copy, Debug)]
pub struct PolicyStart {
    /// Seed of its random initial guesses.
    pub seed: u64,
    /// What a skin reports of each touch.
    pub input: Input,
    /// When it stops learning.
    pub deadline: Deadline,
}

/// Declares the policies, the default first: a line each, with its name and how it is made for an agent.
macro_rules! policies {
    ($($(#[$about:meta])* $policy:ident, $name:literal => $make:expr;)+) => {
        named! {
            "policy",
            /// The policies by name.
            #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
            #[serde(rename_all = "snake_case")]
            #[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
            pub enum PolicyName {
                $($(#[$about])* $policy = $name),+
            }
        }

        impl PolicyName {
            /// The policy for an agent.
            pub fn policy(self, agent: &Agent, start: PolicyStart) -> Box<dyn Policy> {
                match self {
                    $(PolicyName::$policy => {
                        let make: fn(&Agent, PolicyStart) -> Box<dyn Policy> = $make;
                        make(agent, start)
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
    /// Where the predicted touch is most informative; in wide bodies few joints at first.
    Stages, "stages" => |agent, start| Box::new(Stages::new(agent, start));
}
