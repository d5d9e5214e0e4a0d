//! What can go wrong in a simulation.

use crate::agent::AgentError;
use crate::creature::BodyError;
use crate::mujoco;
use crate::skin::GrowError;

/// Why nothing is simulated.
#[derive(Debug, thiserror::Error)]
pub enum SimulationError {
    /// The engine failed, or refused the model.
    #[error(transparent)]
    Engine(#[from] mujoco::Error),
    /// There is no creature in the model.
    #[error(transparent)]
    Body(#[from] BodyError),
    /// It has no skin, and none could be grown.
    #[error(transparent)]
    Skin(#[from] GrowError),
    /// It has no receptors, so that it cannot touch itself.
    #[error("the model has no touch sensors: grow a skin with `bodyschema skin MODEL --out NEW`")]
    NoReceptors,
    /// No two of its limbs can meet.
    #[error(
        "no two of its limbs can touch: all that bear surface carry one another or overlap for good \
         (`bodyschema inspect` has the table), so no touch can determine {joints}; give limbs that reach each other"
    )]
    NoPairs {
        /// All joints, by name.
        joints: String,
    },
    /// Its skin does not fit it.
    #[error(transparent)]
    Agent(#[from] AgentError),
}
