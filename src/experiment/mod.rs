//! Experiments: babble, learn, evaluate and record in one go, and studies that repeat a measurement over seeds.
//!
//! An [`Observer`] looks on while one runs; [`bodies`] makes creatures to study from seeds.

pub mod bodies;
mod disturbance_levels;
mod embodied;
mod error;
mod in_memory;
mod learned_session;
mod learning_account;
mod learning_options;
mod observer;
mod own_body;
mod recording;
mod session;
mod session_body;
mod shares;
pub mod study;
pub(crate) mod touches;
pub(crate) mod words;

pub use disturbance_levels::DisturbanceLevels;
pub use embodied::{Embodied, ModelSource, skin_for};
pub use error::{CreatureFault, ExperimentError};
pub use in_memory::{Babbled, LearnedBody};
pub use learned_session::{LearnedSession, learn_session};
pub use learning_options::{KnownFile, LearningOptions};
pub use observer::{LearningStep, Observer, Phase};
pub use own_body::{hands, learned_body, own_body};
pub use recording::{RecordedSession, RecordingSource};
pub use session::{BabbledSession, BabblingSession, Provenance, ResumedSession, SessionSetup};
pub use session_body::{same_tree, session_body, session_truth};
pub use shares::{BabbledShares, BabblingShare, Unready};
