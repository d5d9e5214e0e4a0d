//! An agent: a creature's prior knowledge of its own body, before the first touch.

use std::collections::HashSet;
use std::sync::Arc;

use serde::ser::{Serialize, SerializeStruct, Serializer};

use crate::creature::{Body, Creature};
use crate::error::Error;
use crate::plausible;
use crate::skin::{Receptor, Skin, skin_of};

/// A creature and its skin, which fit each other: everything that an agent is given, and nothing of where its
/// joints are. Cheap to clone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Agent {
    creature: Arc<Creature>,
    skin: Arc<Skin>,
}

impl Serialize for Agent {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut parts = serializer.serialize_struct("Agent", 2)?;
        parts.serialize_field("creature", self.creature())?;
        parts.serialize_field("skin", self.skin())?;
        parts.end()
    }
}

impl Agent {
    /// A creature with a skin.
    ///
    /// # Errors
    /// Where a receptor or a surface of the skin is on a limb that the creature does not have, and where a
    /// receptor lacks a surface that it refers to, an id of its own, or a finite number; where one of them has a place, a size
    /// or a direction that cannot be.
    pub fn new(creature: impl Into<Arc<Creature>>, skin: impl Into<Arc<Skin>>) -> Result<Agent, Error> {
        let (creature, skin) = (creature.into(), skin.into());
        check(&creature, &skin)?;
        Ok(Agent { creature, skin })
    }

    /// The agent in a body: its creature, with the skin that the model's touch sensors are.
    ///
    /// # Errors
    /// Where two touch sensors have the same name.
    pub fn of(body: &Body) -> Result<Agent, Error> {
        Agent::new(body.creature.clone(), skin_of(body))
    }

    /// The same creature with another skin.
    ///
    /// # Errors
    /// As [`Agent::new`].
    pub fn with_skin(&self, skin: impl Into<Arc<Skin>>) -> Result<Agent, Error> {
        Agent::new(self.creature.clone(), skin)
    }

    /// The same agent with all lengths so many times as long.
    pub(crate) fn scaled(&self, by: f64) -> Agent {
        Agent { creature: Arc::new(self.creature.scaled(by)), skin: Arc::new(self.skin.scaled(by)) }
    }

    /// The tree of joints, and the limbs.
    pub fn creature(&self) -> &Creature {
        &self.creature
    }

    /// Receptors and surfaces of the limbs.
    pub fn skin(&self) -> &Skin {
        &self.skin
    }

    /// The limbs that have skin, in the creature's order.
    pub fn limbs_with_skin(&self) -> Vec<usize> {
        (0..self.creature().limbs().len())
            .filter(|&limb| self.skin().receptors_on(limb).next().is_some())
            .collect()
    }
}

/// The first fault of a receptor of a skin, and the fix.
fn receptor_fault(receptor: &Receptor, limbs: usize, skin: &Skin) -> Option<String> {
    let surface = receptor.surface.map(|surface| (surface, skin.surfaces.get(surface)));
    let vectors = [&receptor.position, &receptor.normal, &receptor.tangent];
    let mut numbers = vectors.into_iter().flatten().chain(&receptor.half_extents);
    if receptor.limb >= limbs {
        Some("is on a limb that does not exist: give it one of the creature's limbs".into())
    } else if let Some((_, None)) = surface {
        Some("is on a surface that does not exist: give it one of the skin's surfaces".into())
    } else if let Some((surface, Some(found))) = surface
        && found.limb != receptor.limb
    {
        Some(format!("is on another limb than its surface {surface} (from 0): mend one of the two"))
    } else if !numbers.all(|number| number.is_finite()) {
        Some("has a number that is not finite: give a finite one".into())
    } else {
        let across = receptor.normal.dot(&receptor.tangent).abs() > plausible::UNIT;
        let across =
            across.then_some("has a tangent that is not across its normal: give one at right angles to it");
        plausible::place_fault(&receptor.position)
            .or_else(|| plausible::extent_fault(&receptor.half_extents))
            .or_else(|| plausible::direction_fault(&receptor.normal))
            .or_else(|| plausible::direction_fault(&receptor.tangent))
            .or(across.map(str::to_string))
    }
}

fn check(creature: &Creature, skin: &Skin) -> Result<(), Error> {
    let limbs = creature.limbs().len();
    let mut ids = HashSet::new();
    for receptor in &skin.receptors {
        let twice = !ids.insert(&receptor.id);
        let twice = twice.then(|| "occurs twice: give each an id of its own".to_string());
        if let Some(fault) = twice.or_else(|| receptor_fault(receptor, limbs, skin)) {
            return Err(Error::usage(format!("receptor \"{}\" {fault}", receptor.id)));
        }
    }
    for (number, surface) in skin.surfaces.iter().enumerate() {
        let nowhere = (surface.limb >= limbs)
            .then(|| "is on a limb that does not exist: give it one of the creature's limbs".to_string());
        let fault = plausible::pose_fault(&surface.pose()).or_else(|| plausible::shape_fault(&surface.shape));
        if let Some(fault) = fault.or(nowhere) {
            return Err(Error::usage(format!("surface {number} (from 0) of the skin {fault}")));
        }
    }
    Ok(())
}
