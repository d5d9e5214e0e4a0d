//! Models made ready for simulation with forces that this program applies.

use super::error::{Error, Result};
use super::ffi;
use super::model::Model;

/// The longest step of a simulation, seconds; a model's own step may be shorter. Coarser ones let light things bounce.
pub const LONGEST_STEP: f64 = 0.002;
/// What is added to the inertia of a degree of freedom that is to stay where it is, kilograms or kilograms times square
/// metres: so much that no force of a creature's size moves it.
const RIGID: f64 = 1e6;

/// Rounds in which the engine's solver lets friction hold without creeping.
const NO_SLIP_ROUNDS: i32 = 5;

/// Least room for rows of constraints in the data of a simulated model: a curled body has many contacts.
#[cfg(mujoco_nstack)]
const LEAST_ROWS: i32 = 1000;

impl Model {
    /// The same model where friction holds what it can hold: the engine's own creeps by millimetres a second under a
    /// steady load.
    pub fn without_creep(mut self) -> Model {
        // SAFETY: the model is borrowed by nobody else yet.
        unsafe { (*self.raw_mut()).opt.noslip_iterations = NO_SLIP_ROUNDS };
        self
    }

    /// A copy that forces from outside move, in steps of `timestep` seconds: without actuators and dampers of joints, with
    /// no equality but those that couple joints; degrees of freedom marked in `rigid` as good as stand still. Its sensors
    /// are computed only where `sensing` says so, and the file does not disable them.
    ///
    /// # Errors
    /// [`Error::Size`] where there is not one mark per degree of freedom, [`Error::NotFinite`] for a time step that
    /// is not above zero, [`Error::Engine`] where there is no memory for it.
    pub fn simulated(&self, timestep: f64, rigid: &[bool], sensing: bool) -> Result<Model> {
        if rigid.len() != self.nv() {
            return Err(Error::Size { what: "dof_armature", expected: self.nv(), found: rigid.len() });
        }
        if !(timestep > 0.0 && timestep.is_finite()) {
            return Err(Error::NotFinite { what: "timestep", index: 0 });
        }
        let mut copy = self.copy()?;
        let raw = copy.raw_mut();
        // SAFETY: the copy is not shared yet; the arrays hold a number per degree of freedom and per equality.
        unsafe {
            let option = &raw mut (*raw).opt;
            (*option).timestep = timestep;
            (*option).integrator = ffi::mjINT_EULER as i32;
            // Constraints are made anew within a step where things pass through each other: they would no longer be those
            // of the islands.
            (*option).disableflags |= (ffi::mjDSBL_ACTUATION | ffi::mjDSBL_ISLAND) as i32;
            (*option).enableflags &= !((ffi::mjENBL_ISLAND | ffi::mjENBL_SLEEP) as i32);
            if !sensing {
                (*option).disableflags |= ffi::mjDSBL_SENSOR as i32;
            }
            // Dampers would have the engine factorise its inertia matrix twice a step.
            for dof in 0..rigid.len() {
                *(*raw).dof_damping.add(dof) = 0.0;
            }
            for (dof, _) in rigid.iter().enumerate().filter(|(_, rigid)| **rigid) {
                *(*raw).dof_armature.add(dof) += RIGID;
            }
            for equality in 0..(*raw).neq as usize {
                if *(*raw).eq_type.add(equality) as u32 != ffi::mjEQ_JOINT {
                    #[cfg(not(mujoco_eq_active0))]
                    {
                        *(*raw).eq_active.add(equality) = Default::default();
                    }
                    #[cfg(mujoco_eq_active0)]
                    {
                        *(*raw).eq_active0.add(equality) = Default::default();
                    }
                }
            }
            #[cfg(mujoco_nstack)]
            {
                (*raw).njmax = (*raw).njmax.max(LEAST_ROWS);
                // The engine's own rule for the room of its solver.
                let rows = (*raw).njmax + (*raw).nv;
                (*raw).nstack = (*raw).nstack.max(5 * rows * rows + 20 * ((*raw).nq + (*raw).nv + rows));
            }
        }
        Ok(copy)
    }
}
