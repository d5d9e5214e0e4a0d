//! A policy in the unit of length that suits its body.

use rand_chacha::ChaCha8Rng;

use super::Policy;
use crate::agent::Agent;
use crate::creature::Posture;
use crate::deadline::Deadline;
use crate::learning::growth::Growth;
use crate::learning::{Input, LengthUnit};
use crate::senses::Touch;
use crate::simulation::Ending;

/// A policy that learns in the unit that suits its body (see [`LengthUnit`]), of motions and touches in metres. What it has
/// learned is in that unit, as learners of this body have it.
pub struct PolicyInUnit<P> {
    agent: Agent,
    metres: f64,
    policy: P,
}

impl<P: Policy> PolicyInUnit<P> {
    /// The policy that `make` makes for an agent in the unit that suits its body.
    pub fn of(agent: &Agent, make: impl FnOnce(&Agent) -> P) -> PolicyInUnit<P> {
        let unit = LengthUnit::of(agent);
        PolicyInUnit { agent: agent.clone(), metres: unit.metres(), policy: make(&unit.agent(agent)) }
    }

    fn in_unit(&self, posture: &[f64]) -> Posture {
        Posture::from(posture).scaled(self.agent.creature(), 1.0 / self.metres)
    }
}

impl<P: Policy> Policy for PolicyInUnit<P> {
    fn next_target(&mut self, posture: &[f64], rng: &mut ChaCha8Rng) -> Posture {
        let posture = self.in_unit(posture);
        self.policy.next_target(&posture, rng).scaled(self.agent.creature(), self.metres)
    }

    fn starts_over(&mut self) -> bool {
        self.policy.starts_over()
    }

    fn is_done(&self) -> bool {
        self.policy.is_done()
    }

    fn learns_from(&mut self, input: Input) {
        self.policy.learns_from(input);
    }

    fn end_at(&mut self, deadline: Deadline) {
        self.policy.end_at(deadline);
    }

    fn grown(&self) -> Option<&Growth> {
        self.policy.grown()
    }

    fn touched(&mut self, touch: &Touch) {
        self.policy.touched(&touch.scaled(self.agent.creature(), 1.0 / self.metres));
    }

    fn missed(&mut self, ending: &Ending, posture: &[f64]) {
        let posture = self.in_unit(posture);
        self.policy.missed(ending, &posture);
    }
}
