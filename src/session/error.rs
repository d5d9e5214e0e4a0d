//! What can go wrong with an experiment; each message is one sentence with its mend.

use std::path::{Path, PathBuf};

use crate::agent::AgentError;
use crate::babbling::BabblingError;
use crate::creature::BodyError;
use crate::mujoco;
use crate::peripersonal::Unmappable;
use crate::session::RecordError;
use crate::simulation::SimulationError;
use crate::skin::GrowError;

/// Why an experiment came to no end.
#[derive(Debug, thiserror::Error)]
pub enum ExperimentError {
    /// The engine failed; its errors name the file themselves.
    #[error(transparent)]
    Engine(#[from] mujoco::Error),
    /// A file of a session cannot be read or written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// Where a hand can get to cannot be mapped.
    #[error(transparent)]
    Space(#[from] Unmappable),
    /// Something is wrong with the creature of a model.
    #[error("{}: {reason}", model.display())]
    Creature {
        /// The model's file.
        model: PathBuf,
        /// What, and the mend.
        reason: CreatureFault,
    },
    /// Something in a file or folder does not fit what is asked of it.
    #[error("{}: {reason}", file.display())]
    Unfit {
        /// The file or folder.
        file: PathBuf,
        /// What, and the mend.
        reason: String,
    },
    /// A skin is not the creature's.
    #[error(transparent)]
    Agent(#[from] AgentError),
    /// What is asked cannot be done.
    #[error("{0}")]
    Refused(String),
}

/// What is wrong with a creature.
#[derive(Debug, thiserror::Error)]
pub enum CreatureFault {
    /// There is none that can learn.
    #[error(transparent)]
    Body(BodyError),
    /// No skin can be grown on it.
    #[error(transparent)]
    Skin(GrowError),
    /// It cannot babble.
    #[error(transparent)]
    Babbling(BabblingError<RecordError>),
    /// It cannot be simulated.
    #[error(transparent)]
    Simulation(SimulationError),
}

impl ExperimentError {
    /// An error about a file or folder.
    pub fn unfit(file: &Path, reason: impl Into<String>) -> ExperimentError {
        ExperimentError::Unfit { file: file.to_path_buf(), reason: reason.into() }
    }

    /// An error about what is asked.
    pub fn refused(sentence: impl Into<String>) -> ExperimentError {
        ExperimentError::Refused(sentence.into())
    }

    /// What was wrong with the body in a model.
    pub(crate) fn body(model: &Path) -> impl Fn(BodyError) -> ExperimentError {
        move |error| match error {
            BodyError::Engine(error) => ExperimentError::Engine(error),
            other => {
                ExperimentError::Creature { model: model.to_path_buf(), reason: CreatureFault::Body(other) }
            }
        }
    }

    /// What was wrong with babbling in a model.
    pub(crate) fn babbling(model: &Path) -> impl Fn(BabblingError<RecordError>) -> ExperimentError {
        move |error| match error {
            BabblingError::Receiver(error) => ExperimentError::Record(error),
            other => ExperimentError::Creature {
                model: model.to_path_buf(),
                reason: CreatureFault::Babbling(other),
            },
        }
    }

    /// What was wrong with the skin of a model's creature.
    pub(crate) fn skin(model: &Path) -> impl Fn(GrowError) -> ExperimentError {
        move |error| ExperimentError::Creature {
            model: model.to_path_buf(),
            reason: CreatureFault::Skin(error),
        }
    }

    /// Why a model's creature cannot be simulated.
    pub(crate) fn simulation(model: &Path) -> impl Fn(SimulationError) -> ExperimentError {
        move |error| ExperimentError::Creature {
            model: model.to_path_buf(),
            reason: CreatureFault::Simulation(error),
        }
    }
}
