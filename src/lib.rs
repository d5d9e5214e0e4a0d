#![deny(unsafe_code)]
mod mjcf_xml;
pub mod mujoco;
pub mod creature;
pub mod ground_truth;
pub mod skin;
pub mod senses;
pub mod babbling;
pub mod kinematics;
pub mod record;
pub mod schema;
pub mod learning;
pub mod evaluation;
