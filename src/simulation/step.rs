//! One step of the physics: the only place where the engine is stepped.

use crate::error::Result;
use crate::mujoco::Data;

/// Makes one step from a state of the whole model: its coordinates and velocities.
///
/// `forces` gives those on all degrees of freedom, newtons and newton metres, once all is computed that depends on the
/// state alone. Geoms of which `meets` says no pass through each other. Contacts, forces and sensors of `data` are then
/// those of the state that the step began with, coordinates and velocities those at its end.
///
/// # Errors
/// Where the engine fails.
pub fn step(
    data: &mut Data,
    (qpos, qvel): (&[f64], &[f64]),
    meets: impl FnMut([usize; 2]) -> bool,
    forces: impl FnOnce(&Data) -> Vec<f64>,
) -> Result<()> {
    data.set_qpos(qpos)?;
    data.set_qvel(qvel)?;
    data.step1()?;
    data.let_pass(meets)?;
    let forces = forces(data);
    data.set_qfrc_applied(&forces)?;
    Ok(data.step2()?)
}
