//! What moves a body until it touches itself, made ready once for all threads.

use super::dynamic::Physics;
use super::{ConservativeAdvancement, DynamicMover, MotionName, MotionUntilTouch, Mover, SelfContact};
use crate::agent::Agent;
use crate::creature::{Body, Posture};
use crate::error::{Error, Kind, Result};
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
    /// If there is no skin, or no two limbs can meet,
    /// and where the engine fails.
    pub fn new(body: &'a Body, agent: &'a Agent, motion: MotionName) -> Result<Movers<'a>, Error> {
        if agent.skin().receptors.is_empty() {
            let sentence =
                "the model has no touch sensors: grow a skin with `bodyschema skin MODEL --out NEW`";
            return Err(Error::model(sentence));
        }
        let SelfContact { left_out, start, .. } = SelfContact::new(body)?;
        let reader = ContactReader::new(body, agent.skin());
        let clearance = ConservativeAdvancement::new(body, &left_out)?;
        if clearance.is_empty() {
            let joints: Vec<&str> = body.creature.joints().iter().map(|joint| joint.name.as_str()).collect();
            let joints = joints.join(", ");
            return Err(Error::new(
                Kind::NoContact,
                format!(
                    "no two of its limbs can touch: all that bear surface carry one another or overlap for good \
                     (`bodyschema inspect` has the table), so no touch can determine {joints}; give limbs that reach each other"
                ),
            ));
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
    pub fn kinematic(&self) -> Result<Mover<'_>> {
        Mover::new(self.body, self.agent.skin(), &self.reader, self.clearance.clone(), self.start.clone())
    }

    /// A mover with forces in the start posture; none unless motions are [`MotionName::Dynamic`].
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn dynamic(&self) -> Result<Option<DynamicMover<'_>>> {
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
    pub fn mover(&self) -> Result<Box<dyn MotionUntilTouch + '_>> {
        Ok(match self.dynamic()? {
            Some(mover) => Box::new(mover),
            None => Box::new(self.kinematic()?),
        })
    }
}
