//! The senses: contacts read as touches of the skin, what may be wrong with them, and other frames to tell
//! them in.

pub mod aura;
mod contact_reader;
mod disturbance;
mod firing;
mod learned_map;
mod own_frames;
mod touch;
pub mod touch_sensor;

pub use aura::{Approach, Aura, AuraEvent, LOOK_PERIOD};
pub use contact_reader::{ContactReader, Reading};
pub use disturbance::{Disturbances, Felt};
pub use firing::{Firing, FiringRecorder};
pub use learned_map::{LearnedMap, learn_map};
pub use own_frames::OwnFrames;
pub use touch::{Moment, Touch, TouchEnd};
pub use touch_sensor::{Kind, Sensation, SkinContact, TouchEvent, TouchSensor, skin_contacts};
