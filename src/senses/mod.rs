//! The senses: contacts read as touches of the skin, posture, what is near; and disturbances of them.
//!
//! "Something was felt" has these levels, each made of the one before:
//! - [`Reading`]: what one contact of the engine is, two places of skin, or bare, or foreign.
//! - [`SkinContact`]: which receptors fire in one step ([`SkinSpot`]) and by whom ([`Toucher`]).
//! - [`TouchEvent`]: that something begins to touch, and afterwards the [`Sensation`] that it was, limb by limb.
//! - [`Firing`]: of all that, only which receptor fired and when.
//! - [`Touch`]: a self-touch that a motion ended in, with the posture and its two [`TouchEnd`]s: what is learned from.
//!   A [`RecordedTouch`] has beside it the [`ExactContact`], for files and measures.
//!
//! Touch, posture, proximity and balance are a [`Sense`] each, listed in [`SENSES`].

pub mod aura;
mod balance;
mod contact_reader;
mod disturbance;
mod firing;
mod followed_touch;
mod learned_map;
mod mapped_skin;
mod proprioception;
mod recorded_touch;
mod sensation;
mod sense;
mod skin_contact;
mod touch;
pub mod touch_sensor;

pub use aura::{Approach, Aura, AuraEvent};
pub use balance::Balance;
pub use contact_reader::{ContactReader, FAINT, Reading};
pub use disturbance::{Disturbances, DisturbedSenses};
pub use firing::{Firing, FiringRecorder};
pub use learned_map::{LearnedMap, learn_map};
pub use proprioception::{JointSensor, Proprioception, joint_sensors, posture_in_words};
pub use recorded_touch::{ExactContact, Met, RecordedTouch};
pub use sensation::{LimbSensation, Sensation, SensationSide, TouchEvent, TouchKind};
pub use sense::{NewSense, SENSES, Sense, SensedStep, SensingBody};
pub use skin_contact::{SkinContact, SkinSpot, Toucher};
pub use touch::{FeltPoint, Input, Moment, Touch, TouchEnd, limb_pairs};
pub use touch_sensor::TouchSensor;
