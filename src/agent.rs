//! An agent: what a creature is given of itself before it has felt anything.

use std::collections::HashSet;
use std::sync::Arc;

use crate::creature::{Body, Creature};
use crate::plausible;
use crate::skin::{Receptor, Skin, skin_of};

/// A creature and its skin, which fit each other: everything that an agent is given, and nothing of where its
/// joints are. Cheap to clone.
#[derive(Clone, Debug, PartialEq)]
pub struct Agent {
    creature: Arc<Creature>,
    skin: Arc<Skin>,
}

/// Why a skin is not a creature's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AgentError {
    /// Two receptors have the same id.
    #[error("receptor \"{id}\" occurs twice: give each an id of its own")]
    SameId {
        /// The id.
        id: String,
    },
    /// A receptor is on a limb that the creature does not have.
    #[error("receptor \"{id}\" is on a limb that does not exist: give it one of the creature's limbs")]
    ReceptorLimb {
        /// The receptor.
        id: String,
    },
    /// A receptor is on a surface that the skin does not have.
    #[error("receptor \"{id}\" is on a surface that does not exist: give it one of the skin's surfaces")]
    ReceptorSurface {
        /// The receptor.
        id: String,
    },
    /// A number of a receptor is infinite or none.
    #[error("receptor \"{id}\" has a number that is not finite: give a finite one")]
    NotFinite {
        /// The receptor.
        id: String,
    },
    /// A receptor cannot be as it is said to be.
    #[error("receptor \"{id}\" {fault}")]
    Receptor {
        /// The receptor.
        id: String,
        /// What is wrong with it, and the mend.
        fault: String,
    },
    /// A surface cannot be as it is said to be.
    #[error("surface {surface} (from 0) of the skin {fault}")]
    Surface {
        /// The surface, an index into [`Skin::surfaces`].
        surface: usize,
        /// What is wrong with it, and the mend.
        fault: String,
    },
    /// A surface is on a limb that the creature does not have.
    #[error(
        "surface {surface} (from 0) of the skin is on a limb that does not exist: give it one of the creature's \
         limbs"
    )]
    SurfaceLimb {
        /// The surface, an index into [`Skin::surfaces`].
        surface: usize,
    },
}

impl Agent {
    /// A creature with a skin.
    ///
    /// # Errors
    /// Where a receptor or a surface of the skin is on a limb that the creature does not have, and where a
    /// receptor lacks a surface that it refers to, an id of its own, or a finite number; where one of them has a place, a size
    /// or a direction that cannot be.
    pub fn new(creature: impl Into<Arc<Creature>>, skin: impl Into<Arc<Skin>>) -> Result<Agent, AgentError> {
        let (creature, skin) = (creature.into(), skin.into());
        check(&creature, &skin)?;
        Ok(Agent { creature, skin })
    }

    /// The agent in a body: its creature, with the skin that the model's touch sensors are.
    ///
    /// # Errors
    /// Where two touch sensors have the same name.
    pub fn of(body: &Body) -> Result<Agent, AgentError> {
        Agent::new(body.creature.clone(), skin_of(body))
    }

    /// The same creature with another skin.
    ///
    /// # Errors
    /// As [`Agent::new`].
    pub fn with_skin(&self, skin: impl Into<Arc<Skin>>) -> Result<Agent, AgentError> {
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
        let felt = |limb: &usize| self.skin().receptors.iter().any(|receptor| receptor.limb == *limb);
        (0..self.creature().limbs().len()).filter(felt).collect()
    }
}

/// What is wrong with a receptor that no receptor can have, and the mend.
fn receptor_fault(receptor: &Receptor) -> Option<String> {
    let across = receptor.normal.dot(&receptor.tangent).abs() > plausible::UNIT;
    plausible::place_fault(&receptor.position)
        .or_else(|| plausible::extent_fault(&receptor.half_extents))
        .or_else(|| plausible::direction_fault(&receptor.normal))
        .or_else(|| plausible::direction_fault(&receptor.tangent))
        .or_else(|| {
            across
                .then(|| "has a tangent that is not across its normal: give one at right angles to it".into())
        })
}

fn check(creature: &Creature, skin: &Skin) -> Result<(), AgentError> {
    let limbs = creature.limbs().len();
    let mut ids = HashSet::new();
    for receptor in &skin.receptors {
        let id = || receptor.id.clone();
        if !ids.insert(&receptor.id) {
            return Err(AgentError::SameId { id: id() });
        }
        if receptor.limb >= limbs {
            return Err(AgentError::ReceptorLimb { id: id() });
        }
        if receptor.surface.is_some_and(|surface| surface >= skin.surfaces.len()) {
            return Err(AgentError::ReceptorSurface { id: id() });
        }
        if let Some(surface) =
            receptor.surface.filter(|surface| skin.surfaces[*surface].limb != receptor.limb)
        {
            let fault =
                format!("is on another limb than its surface {surface} (from 0): mend one of the two");
            return Err(AgentError::Receptor { id: id(), fault });
        }
        let vectors = [&receptor.position, &receptor.normal, &receptor.tangent];
        let mut numbers = vectors.into_iter().flatten().chain(&receptor.half_extents);
        if !numbers.all(|number| number.is_finite()) {
            return Err(AgentError::NotFinite { id: id() });
        }
        if let Some(fault) = receptor_fault(receptor) {
            return Err(AgentError::Receptor { id: id(), fault });
        }
    }
    for (number, surface) in skin.surfaces.iter().enumerate() {
        let fault = plausible::pose_fault(&surface.pose()).or_else(|| plausible::shape_fault(&surface.shape));
        if let Some(fault) = fault {
            return Err(AgentError::Surface { surface: number, fault });
        }
    }
    match skin.surfaces.iter().position(|surface| surface.limb >= limbs) {
        Some(surface) => Err(AgentError::SurfaceLimb { surface }),
        None => Ok(()),
    }
}
