//! The data: one posture of a model and what the engine computes from it; one per thread.
//! Long for its accessors, a few lines each.

use std::ptr::NonNull;
use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, UnitVector3, Vector3};

use super::element::{quaternion, vector};
use super::engine::{self, guarded};
use super::error::{Error, Result};
use super::ffi;
use super::model::{Model, slice};

/// An engine function that computes one stage for a posture.
type Computation = unsafe extern "C-unwind" fn(*const ffi::mjModel, *mut ffi::mjData);

/// A place where two geoms touch or nearly do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// The two geoms; the engine puts the one with the lower shape type first.
    pub geoms: [usize; 2],
    /// Midpoint between the two surfaces, in the world frame, in metres.
    pub position: Point3<f64>,
    /// Unit normal from the first geom to the second, in the world frame.
    pub normal: Vector3<f64>,
    /// Distance between the surfaces, in metres; negative where they overlap.
    pub distance: f64,
}

/// The state of a model in one posture.
///
/// Results belong to the posture of the last call that computes them: [`Data::kinematics`] for poses,
/// then [`Data::collision`] for contacts, or [`Data::forward`] for all of it with forces and sensors.
/// For a posture's contacts the first two are enough and give the same contacts as the third.
pub struct Data {
    model: Arc<Model>,
    raw: NonNull<ffi::mjData>,
}

// SAFETY: the data are owned by this value alone and the engine ties them to no thread; the model
// that they refer to is shared and constant.
unsafe impl Send for Data {}

impl Drop for Data {
    fn drop(&mut self) {
        // SAFETY: made by mj_makeData, owned by this value alone, freed once.
        unsafe { ffi::mj_deleteData(self.raw.as_ptr()) }
    }
}

impl std::fmt::Debug for Data {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("Data").field("qpos", &self.qpos()).finish_non_exhaustive()
    }
}

/// Slices one of the data's arrays: `array!(data, xpos[nbody * 3])`.
macro_rules! array {
    ($data:expr, $field:ident[$count:ident $(* $width:literal)?]) => {{
        // SAFETY: the engine allocates `$count * $width` elements for `$field` (mjdata.h), zero or
        // computed, and writes to them only in calls that borrow the data exclusively.
        unsafe { slice($data.raw().$field, $data.model.raw().$count as usize $(* $width)?) }
    }};
}

impl Data {
    /// Data of `model` in its reference posture, nothing computed yet.
    ///
    /// # Errors
    /// [`Error::Engine`] where there is no memory for them.
    pub fn new(model: Arc<Model>) -> Result<Self> {
        // SAFETY: the model is valid; the engine returns null or data that are ours.
        let raw = guarded("mj_makeData", || unsafe { ffi::mj_makeData(model.raw()) })?;
        match NonNull::new(raw) {
            Some(raw) => Ok(Self { model, raw }),
            None => Err(Error::Engine {
                call: "mj_makeData",
                message: "no memory for the data of the model".into(),
            }),
        }
    }

    /// The model that the data belong to.
    pub fn model(&self) -> &Arc<Model> {
        &self.model
    }

    fn raw(&self) -> &ffi::mjData {
        // SAFETY: valid until drop; writers borrow `self` exclusively.
        unsafe { self.raw.as_ref() }
    }

    /// The posture: `nq` coordinates in radians and metres, quaternions w x y z.
    pub fn qpos(&self) -> &[f64] {
        array!(self, qpos[nq])
    }

    /// Sets the posture. What was computed before stays until the next computing call.
    ///
    /// Quaternions need no unit length: the engine normalises them.
    ///
    /// # Errors
    /// [`Error::Size`] where there are not `nq` numbers, [`Error::NotFinite`] where one is NaN,
    /// infinite or beyond the engine's bound of 1e10; the posture is unchanged then.
    pub fn set_qpos(&mut self, qpos: &[f64]) -> Result<()> {
        let at = self.raw().qpos;
        self.write("qpos", at, self.model.nq(), qpos)
    }

    /// Takes over the time, posture and velocities of other data of as many coordinates; nothing is computed.
    ///
    /// # Errors
    /// As [`Data::set_qpos`].
    pub fn take_state(&mut self, other: &Data) -> Result<()> {
        self.set_qpos(other.qpos())?;
        self.set_qvel(other.qvel())?;
        // SAFETY: valid until drop, and borrowed exclusively.
        unsafe { self.raw.as_mut() }.time = other.time();
        Ok(())
    }

    /// Back to the reference posture, nothing computed; dear, never per posture.
    ///
    /// # Errors
    /// [`Error::Engine`] where the engine raises one.
    pub fn reset(&mut self) -> Result<()> {
        // SAFETY: both are valid and the data are borrowed exclusively.
        guarded("mj_resetData", || unsafe {
            ffi::mj_resetData(self.model.raw(), self.raw.as_ptr());
        })
    }

    /// The velocities: `nv` numbers in radians and metres a second.
    pub fn qvel(&self) -> &[f64] {
        array!(self, qvel[nv])
    }

    /// Sets the velocities. What was computed before stays until the next computing call.
    ///
    /// # Errors
    /// [`Error::Size`] where there are not `nv` numbers, [`Error::NotFinite`] where one is none.
    pub fn set_qvel(&mut self, qvel: &[f64]) -> Result<()> {
        let at = self.raw().qvel;
        self.write("qvel", at, self.model.nv(), qvel)
    }

    /// Sets the forces on the degrees of freedom, newtons and newton metres, of the steps to come.
    ///
    /// # Errors
    /// As [`Data::set_qvel`].
    pub fn set_qfrc_applied(&mut self, forces: &[f64]) -> Result<()> {
        let at = self.raw().qfrc_applied;
        self.write("qfrc_applied", at, self.model.nv(), forces)
    }

    /// Writes `count` checked numbers into an array of the data that holds as many.
    fn write(&mut self, what: &'static str, target: *mut f64, count: usize, numbers: &[f64]) -> Result<()> {
        if numbers.len() != count {
            return Err(Error::Size { what, expected: count, found: numbers.len() });
        }
        if let Some(index) = numbers.iter().position(|x| x.is_nan() || x.abs() > ffi::mjMAXVAL) {
            return Err(Error::NotFinite { what, index });
        }
        // SAFETY: callers name an array of `count` numbers, and `self` is borrowed exclusively.
        unsafe { std::ptr::copy_nonoverlapping(numbers.as_ptr(), target, count) }
        Ok(())
    }

    /// Simulated time, seconds.
    pub fn time(&self) -> f64 {
        self.raw().time
    }

    /// The forces that gravity, Coriolis and centrifugal accelerations ask for, of the last [`Data::forward`] or
    /// [`Data::step`]: `nv` numbers.
    pub fn qfrc_bias(&self) -> &[f64] {
        array!(self, qfrc_bias[nv])
    }

    /// The forces of springs, dampers and whatever else acts by itself, of the last [`Data::forward`], [`Data::step`]
    /// or [`Data::step1`]: `nv` numbers.
    pub fn qfrc_passive(&self) -> &[f64] {
        array!(self, qfrc_passive[nv])
    }

    /// The inertia matrix of the last [`Data::forward`] or [`Data::step`] times a vector of `nv` numbers.
    ///
    /// # Panics
    /// Where there are not `nv` numbers.
    pub fn mul_inertia(&self, vector: &[f64]) -> Vec<f64> {
        let nv = self.model.nv();
        assert_eq!(vector.len(), nv, "one number per degree of freedom");
        let mut product = vec![0.0; nv];
        // SAFETY: both arrays hold nv numbers; the data are only read.
        unsafe {
            ffi::mj_mulM(self.model.raw(), self.raw.as_ptr(), product.as_mut_ptr(), vector.as_ptr());
        }
        product
    }

    /// The first half of a step: all that depends on the posture and velocities, contacts among it; no forces yet.
    ///
    /// # Errors
    /// As [`Data::collision`].
    pub fn step1(&mut self) -> Result<()> {
        self.run("mj_step1", ffi::mj_step1)
    }

    /// The second half of a step, with the forces set since: contact forces, sensors of them, and the posture at the
    /// end of the step. Contacts and poses are still those of its beginning.
    ///
    /// # Errors
    /// As [`Data::step`].
    pub fn step2(&mut self) -> Result<()> {
        self.run("mj_step2", ffi::mj_step2)
    }

    /// Lets pairs of geoms pass through each other in this step: between [`Data::step1`] and [`Data::step2`], contacts
    /// of which `meets` says no get no force. They stay among [`Data::contacts`].
    ///
    /// # Errors
    /// As [`Data::collision`].
    pub fn let_pass(&mut self, mut meets: impl FnMut([usize; 2]) -> bool) -> Result<()> {
        // SAFETY: the engine has written `ncon` contacts, and the data are borrowed exclusively.
        let contacts = unsafe {
            let raw = self.raw.as_mut();
            match raw.ncon {
                0 => &mut [],
                count => std::slice::from_raw_parts_mut(raw.contact, count as usize),
            }
        };
        let mut passed = false;
        for contact in contacts.iter_mut().filter(|contact| contact.geom1 >= 0 && contact.geom2 >= 0) {
            if contact.exclude == 0 && !meets([contact.geom1 as usize, contact.geom2 as usize]) {
                (contact.exclude, contact.efc_address) = (1, -1);
                passed = true;
            }
        }
        if passed {
            // The first half made constraints of all contacts: they are made anew.
            self.run("mj_makeConstraint", ffi::mj_makeConstraint)?;
            self.run("mj_projectConstraint", ffi::mj_projectConstraint)?;
            self.run("mj_referenceConstraint", ffi::mj_referenceConstraint)?;
        }
        Ok(())
    }

    /// The contacts that press, of the last [`Data::step2`], [`Data::step`] or [`Data::forward`], with their normal
    /// forces, newtons, all above zero.
    pub fn pressing(&self) -> impl Iterator<Item = (Contact, f64)> + '_ {
        let with_forces = self.numbered_contacts().map(|(i, contact)| (contact, self.contact_force(i).x));
        with_forces.filter(|(_, force)| *force > 0.0)
    }

    /// Computes the poses of bodies, joints, geoms and sites.
    ///
    /// # Errors
    /// [`Error::Engine`], after which the data are reset; [`Error::Warning`].
    pub fn kinematics(&mut self) -> Result<()> {
        self.run("mj_kinematics", ffi::mj_kinematics)
    }

    #[cfg(feature = "render")]
    /// Computes all that a picture shows: poses, centres of mass, cameras, lights and tendons.
    pub(super) fn place(&mut self) -> Result<()> {
        self.kinematics()?;
        self.run("mj_comPos", ffi::mj_comPos)?;
        self.run("mj_camlight", ffi::mj_camlight)?;
        self.run("mj_tendon", ffi::mj_tendon)
    }

    #[cfg(feature = "render")]
    /// For calls of the engine that take the data as theirs.
    pub(super) fn raw_mut(&mut self) -> *mut ffi::mjData {
        self.raw.as_ptr()
    }

    /// Finds the contacts; after [`Data::kinematics`].
    ///
    /// # Errors
    /// As [`Data::kinematics`]; [`Error::Warning`] also where there are more contacts than the model
    /// has room for: none are kept then.
    pub fn collision(&mut self) -> Result<()> {
        self.run("mj_collision", ffi::mj_collision)
    }

    /// Computes everything for the posture: poses, contacts, forces, sensors.
    ///
    /// # Errors
    /// As [`Data::collision`].
    pub fn forward(&mut self) -> Result<()> {
        self.run("mj_forward", ffi::mj_forward)
    }

    /// Computes the sensors that depend on the posture alone; those of anything but joints are right after
    /// [`Data::forward`] only.
    ///
    /// # Errors
    /// As [`Data::kinematics`].
    pub fn sense_positions(&mut self) -> Result<()> {
        self.run("mj_sensorPos", ffi::mj_sensorPos)
    }

    fn run(&mut self, call: &'static str, stage: Computation) -> Result<()> {
        let (model, data) = (self.model.raw(), self.raw.as_ptr());
        // SAFETY: both are valid and the data are borrowed exclusively.
        if let Err(error) = guarded(call, || unsafe { stage(model, data) }) {
            // The engine stopped half-way, its stack pointer wherever it was.
            self.reset()?;
            return Err(error);
        }
        match self.warned() {
            Some(message) => Err(Error::Warning { call, message }),
            None => Ok(()),
        }
    }

    /// Whether the last call warned; if so the contacts are dropped, for they may be incomplete.
    ///
    /// The engine calls the warning handler the first time only and counts afterwards, so the counters
    /// are what tells, and they start anew.
    fn warned(&mut self) -> Option<String> {
        // SAFETY: valid, and borrowed exclusively.
        let data = unsafe { self.raw.as_mut() };
        let raised = data.warning.iter().position(|warning| warning.number != 0);
        let heard = engine::take_warning();
        if raised.is_none() && heard.is_none() {
            return None;
        }
        let message = heard.unwrap_or_else(|| {
            let kind = raised.unwrap_or(0);
            // SAFETY: takes two numbers and returns a string of the engine's own.
            unsafe { engine::text(ffi::mju_warningText(kind as i32, data.warning[kind].lastinfo as _)) }
        });
        for warning in &mut data.warning {
            warning.number = 0;
        }
        data.ncon = 0;
        Some(message)
    }

    /// The contacts of the last [`Data::collision`] or [`Data::forward`].
    pub fn contacts(&self) -> impl Iterator<Item = Contact> + '_ {
        self.numbered_contacts().map(|(_, contact)| contact)
    }

    /// The same with their numbers among all, in the engine's order: contacts of a deformable body, which carry a geom of -1,
    /// are none of a geom pair, but take a number.
    fn numbered_contacts(&self) -> impl Iterator<Item = (usize, Contact)> + '_ {
        let raw = self.raw();
        // SAFETY: the engine has written `ncon` contacts, and writes again only through `&mut self`.
        let all = unsafe { slice(raw.contact, raw.ncon as usize) }.iter().enumerate();
        all.filter(|(_, raw)| raw.geom1 >= 0 && raw.geom2 >= 0).map(|(i, raw)| {
            let contact = Contact {
                geoms: [raw.geom1 as usize, raw.geom2 as usize],
                position: Point3::new(raw.pos[0], raw.pos[1], raw.pos[2]),
                normal: Vector3::new(raw.frame[0], raw.frame[1], raw.frame[2]),
                distance: raw.dist,
            };
            (i, contact)
        })
    }

    /// The force of contact `i` of the last [`Data::forward`], in newtons, in the contact's frame: along
    /// its normal, then along its two tangents. All zero where no force was computed.
    ///
    /// # Panics
    /// Where there is no contact `i`.
    pub fn contact_force(&self, i: usize) -> Vector3<f64> {
        assert!(i < self.raw().ncon as usize, "there is no contact {i}");
        let mut wrench = [0.0; 6];
        // SAFETY: both are valid, the data are only read, the index is in range, and the engine writes
        // six numbers.
        unsafe {
            ffi::mj_contactForce(self.model.raw(), self.raw.as_ptr(), i as i32, wrench.as_mut_ptr());
        }
        vector(&wrench)
    }

    /// The sensors' numbers of the last [`Data::forward`], [`Data::step2`] or [`Data::sense_positions`]; see
    /// [`Sensor`](super::Sensor).
    pub fn sensordata(&self) -> &[f64] {
        array!(self, sensordata[nsensordata])
    }

    /// The pose of body `i` in the world frame.
    pub fn body_pose(&self, i: usize) -> Isometry3<f64> {
        pose(&array!(self, xpos[nbody * 3])[3 * i..], quaternion(&array!(self, xquat[nbody * 4])[4 * i..]))
    }

    /// The pose of geom `i` in the world frame.
    pub fn geom_pose(&self, i: usize) -> Isometry3<f64> {
        pose(
            &array!(self, geom_xpos[ngeom * 3])[3 * i..],
            rotation(&array!(self, geom_xmat[ngeom * 9])[9 * i..]),
        )
    }

    /// The pose of site `i` in the world frame.
    pub fn site_pose(&self, i: usize) -> Isometry3<f64> {
        pose(
            &array!(self, site_xpos[nsite * 3])[3 * i..],
            rotation(&array!(self, site_xmat[nsite * 9])[9 * i..]),
        )
    }

    /// The anchor of joint `i` in the world frame, in metres.
    pub fn joint_anchor(&self, i: usize) -> Point3<f64> {
        vector(&array!(self, xanchor[njnt * 3])[3 * i..]).into()
    }

    /// The axis of joint `i` in the world frame; without meaning for ball and free joints.
    pub fn joint_axis(&self, i: usize) -> UnitVector3<f64> {
        UnitVector3::new_unchecked(vector(&array!(self, xaxis[njnt * 3])[3 * i..]))
    }
}

/// A position and an orientation as a pose.
fn pose(position: &[f64], orientation: UnitQuaternion<f64>) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::from(vector(position)), orientation)
}

/// The engine's row-major rotation matrix as a unit quaternion.
fn rotation(rows: &[f64]) -> UnitQuaternion<f64> {
    let matrix = Matrix3::from_row_slice(&rows[..9]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix))
}
