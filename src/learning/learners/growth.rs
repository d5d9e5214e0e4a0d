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
        "Part by part from what is known"
    }

    fn uses(&self) -> LearnerUses {
        LearnerUses { surfaces: true, surfaces_alone: true, ..LearnerUses::default() }
    }

    fn learner(&self, agent: &Agent, given: &LearnerGivens, seed: u64) -> Box<dyn Learner> {
        Box::new(Grower::new(agent, seed).with_input(given.input))
    }

    fn goes_on(
        &self,
        agent: &Agent,
        given: &LearnerGivens,
        grown: &Growth,
        seed: u64,
    ) -> Option<Box<dyn Learner>> {
        Some(Box::new(Grower::from(agent, grown.clone(), seed).with_input(given.input)))
    }
}
