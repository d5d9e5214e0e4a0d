//! All that an agent has of a simulation.

use super::Stage;
use crate::agent::Agent;
use crate::creature::Posture;
use crate::error::Result;
use crate::senses::{Proprioception, Sense, SkinContact};

/// What a creature has of the stage that it is on: it moves, feels, holds and lets go. Where things are, or its own limbs,
/// it cannot ask:
///
/// ```compile_fail,E0599
/// fn peek(handle: &bodyschema::simulation::AgentHandle) {
///     handle.thing_pose(1);
/// }
/// ```
///
/// ```compile_fail,E0616
/// fn peek(handle: &bodyschema::simulation::AgentHandle) {
///     handle.stage.root_pose();
/// }
/// ```
pub struct AgentHandle {
    pub(super) stage: Stage,
}

impl AgentHandle {
    /// What it is given about itself.
    pub fn agent(&self) -> &Agent {
        self.stage.agent()
    }

    /// The posture that it feels itself in.
    pub fn posture(&self) -> Posture {
        self.sense(|posture: &mut Proprioception| posture.felt().clone())
    }

    /// Asks one of its senses, by its type.
    ///
    /// # Panics
    /// If it is neither among [`SENSES`](crate::senses::SENSES) nor among those that the stage was set up with.
    pub fn sense<S: Sense, T>(&self, ask: impl FnOnce(&mut S) -> T) -> T {
        self.stage.sense(ask)
    }

    /// The length of a step, seconds.
    pub fn timestep(&self) -> f64 {
        self.stage.timestep()
    }

    /// The time that has passed, seconds.
    pub fn time(&self) -> f64 {
        self.stage.time()
    }

    /// Goes on by one step, at whose end it is in a posture: what touches its skin now, as its touch sensor has it.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn step(&mut self, towards: &[f64]) -> Result<Vec<SkinContact>> {
        self.stage.step_towards(towards).map(|(_, present)| present)
    }

    /// Holds what the limb of a receptor touches by a weld, until it is let go; whether there was something that can be held.
    pub fn hold(&mut self, receptor: usize) -> bool {
        self.stage.core.borrow_mut().hold(receptor)
    }

    /// Lets go of all that it took hold of.
    pub fn let_go(&mut self) {
        self.stage.core.borrow_mut().let_go();
    }

    /// Holds out the hand of a receptor for a stick, which a partner puts there if there is one: the number that other skin
    /// feels it as; `None` if no stick came.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn take_stick(&mut self, receptor: usize) -> Result<Option<usize>> {
        self.stage.core.borrow_mut().give_any_stick(receptor)
    }

    /// Gives back the stick that it was given.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn give_stick_back(&mut self) -> Result<()> {
        self.stage.core.borrow_mut().take_sticks_back()
    }
}
