//! Senses that a stage runs at every step, whatever they sense.
//!
//! To add one, write a file with a [`Sense`], and name it in [`SENSES`]: a creature on a stage has it by its type, from
//! [`AgentHandle::sense`](crate::simulation::AgentHandle::sense).

use std::any::Any;

use super::balance::Balance;
use super::skin_contact::SkinContact;
use crate::agent::Agent;
use crate::creature::Body;
use crate::mujoco::Data;

/// Makes a sense of an agent.
pub type NewSense = fn(&Agent) -> Box<dyn Sense>;

/// The senses of every creature on a stage.
pub const SENSES: &[NewSense] = &[|_| Box::new(Balance::default())];

/// What there is to be sensed in a step. A sense tells no more of it than a body could feel.
#[derive(Clone, Copy)]
pub struct SensedStep<'a> {
    /// Simulated time at its end, seconds.
    pub time: f64,
    /// The agent that senses.
    pub agent: &'a Agent,
    /// Its body in the model.
    pub body: &'a Body,
    /// What the engine computed: poses, and after contacts their forces.
    pub data: &'a Data,
    /// What touches the skin.
    pub contacts: &'a [SkinContact],
}

/// A sense: what it told last is kept in it.
pub trait Sense: Any {
    /// Senses what there is after a step, and before the first.
    fn step(&mut self, step: &SensedStep);
}
