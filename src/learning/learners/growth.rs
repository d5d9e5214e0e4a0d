//! `growth`: part by part from what is known.

use super::{LearnerGivens, LearnerKind, LearnerUses};
use crate::agent::Agent;
use crate::learning::growth::Growth;
use crate::learning::{Grower, Learner};

/// Part by part from what is known: for touches made while few joints move.
#[derive(Clone, Copy, Debug)]
pub struct PartByPart;

impl LearnerKind for PartByPart {
    fn name(&self) -> &'static str {
        "growth"
    }

    fn about(&self) -> &'static str {
        "All at once, or part by part in wide bodies"
    }

    fn uses(&self) -> LearnerUses {
        LearnerUses { surfaces: true, surfaces_alone: true, ..LearnerUses::default() }
    }

    fn learner(&self, agent: &Agent, given: &LearnerGivens, seed: u64) -> Box<dyn Learner> {
        let grown = given.grown.clone().unwrap_or_else(|| Growth::new(agent, seed));
        Box::new(Grower::from(agent, grown, seed).with_input(given.input))
    }
}
