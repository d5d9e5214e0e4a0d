//! What moves a body until it touches itself, made ready once for all threads.

use super::dynamic::Physics;
use super::{
    ConservativeAdvancement, DynamicMover, MotionName, MotionUntilTouch, Mover, SelfContact, SimulationError,
};
use crate::agent::Agent;
use crate::creature::{Body, Posture};
use crate::mujoco;
use crate::senses::ContactReader;

/// Makes movers of a body, one per thread. Geoms that overlap by construction are left out for good.
pub struct Movers<'a> {
    body: &'a Body,
    agent: &'a Agent,
    reader: ContactReader,
    clearance: ConservativeAdvancement,
    start: Posture,
    /// What simulations share; none where motions are without forces.
    physics: Option<Physics>,
}

impl<'a> Movers<'a> {
    /// Movers of a body whose motions are of a kind.
    ///
    /// # Errors
    /// [`SimulationError::NoReceptors`] where there is no skin, [`SimulationError::NoPairs`] where no two limbs can meet,
    /// and where the engine fails.
    pub fn new(body: &'a Body, agent: &'a Agent, motion: MotionName) -> Result<Movers<'a>, SimulationError> {
        if agent.skin().receptors.is_empty() {
            return Err(SimulationError::NoReceptors);
        }
        let SelfContact { left_out, start, .. } = SelfContact::new(body)?;
        let reader = ContactReader::new(body, agent.skin());
        let clearance = ConservativeAdvancement::new(body, &left_out)?;
        if clearance.is_empty() {
            let joints: Vec<&str> = body.creature.joints().iter().map(|joint| joint.name.as_str()).collect();
            return Err(SimulationError::NoPairs { joints: joints.join(", ") });
        }
        let physics = match motion {
            MotionName::Kinematic => None,
            MotionName::Dynamic => Some(Physics::new(body)?),
        };
        Ok(Movers { body, agent, reader, clearance, start, physics })
    }

    /// What the agent whose body moves is given.
    pub fn agent(&self) -> &'a Agent {
        self.agent
    }

    /// The posture that bouts start from.
    pub fn start(&self) -> &[f64] {
        &self.start
    }

    /// Whether motions are by forces.
    pub fn is_dynamic(&self) -> bool {
        self.physics.is_some()
    }

    /// A mover without forces in the start posture.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn kinematic(&self) -> mujoco::Result<Mover<'_>> {
        Mover::new(self.body, self.agent.skin(), &self.reader, self.clearance.clone(), self.start.clone())
    }

    /// A mover with forces in the start posture; none unless motions are [`MotionName::Dynamic`].
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn dynamic(&self) -> mujoco::Result<Option<DynamicMover<'_>>> {
        let mover = |physics: &Physics| {
            let clearance = self.clearance.clone();
            DynamicMover::new(self.body, self.agent.skin(), &self.reader, clearance, physics, &self.start)
        };
        self.physics.as_ref().map(mover).transpose()
    }

    /// A mover of the kind asked for in the start posture.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn mover(&self) -> mujoco::Result<Box<dyn MotionUntilTouch + '_>> {
        Ok(match self.dynamic()? {
            Some(mover) => Box::new(mover),
            None => Box::new(self.kinematic()?),
        })
    }
}
