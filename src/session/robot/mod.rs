//! Robots to be calibrated and the logs of their touches, as people have them: a description in JSON, URDF, MJCF, a table
//! of Denavit and Hartenberg's numbers; comma-separated values in the units that their columns say.

mod dh;
mod json;
mod log;
mod log_writer;
mod mjcf;
mod mjcf_writer;
mod possible;
mod urdf;
mod urdf_writer;
mod writing;

use std::path::Path;

pub(crate) use json::{json_of, length, set_prior};
pub use log::{CalibrationLog, add_fixed_places, read_calibration_log};
pub use log_writer::calibration_table;
pub(crate) use log_writer::{joint_cells, joint_titles, name_of};
pub use writing::Written;

use crate::calibration::robot::{Knowledge, Robot, Value};
use crate::creature::Creature;
use crate::error::Error;
use crate::learning::KnownJoint;
use crate::model_files::{begins_as, first_letter};
use crate::session::files;

/// What a robot's file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RobotFormat {
    /// A description in JSON.
    Json,
    /// URDF.
    Urdf,
    /// MJCF.
    Mjcf,
    /// A table of Denavit and Hartenberg's numbers, as comma-separated values.
    Dh,
}

/// A robot's file, read.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotFile {
    /// The robot at its maker's numbers.
    pub robot: Robot,
    /// What the file is.
    pub format: RobotFormat,
    /// Its bytes, for the same with other numbers.
    bytes: Vec<u8>,
    /// Its tree as a creature, where the file is one.
    pub creature: Option<Creature>,
    /// Joints of which the file does not say where they are.
    pub unplaced: Vec<String>,
    /// Whether the file says what is unknown.
    pub says_what_is_open: bool,
    /// What was passed over, in sentences.
    pub notes: Vec<String>,
}

/// Whether a file is MJCF, which MuJoCo reads: one that is not to be trusted may crash it.
pub fn is_mjcf(path: &Path) -> bool {
    path.is_file() && std::fs::read(path).is_ok_and(|bytes| begins_as(&bytes, "mujoco"))
}

/// Reads a robot from a file: a description in JSON, URDF, MJCF, or a table of Denavit and Hartenberg's numbers, by its
/// content.
///
/// # Errors
/// If it cannot be read, or, with the place and the fix, if it is none.
pub fn read_robot(path: &Path) -> Result<RobotFile, Error> {
    let read = read_any(path)?;
    match possible::fault(&read.robot) {
        Some(fault) => Err(Error::content(path, None, fault)),
        None => Ok(read),
    }
}

fn read_any(path: &Path) -> Result<RobotFile, Error> {
    let bytes = files::read(path)?;
    let plain = |mut robot: Robot, format, notes, bytes| {
        robot.mount_all();
        RobotFile {
            robot,
            format,
            bytes,
            creature: None,
            unplaced: Vec::new(),
            says_what_is_open: false,
            notes,
        }
    };
    match first_letter(&bytes) {
        Some(b'<') if begins_as(&bytes, "mujoco") => {
            let (robot, notes) = mjcf::read_mjcf(path)?;
            Ok(plain(robot, RobotFormat::Mjcf, notes, bytes))
        }
        Some(b'<') => {
            let (robot, notes) = urdf::read_urdf(path, &bytes)?;
            Ok(plain(robot, RobotFormat::Urdf, notes, bytes))
        }
        Some(_) if log::is_log(&bytes) => Err(Error::content(
            path,
            Some(1),
            "it is a log of touches, where a robot belongs: give the robot first, then the log",
        )),
        Some(b'{') => json::read(path, bytes),
        _ => Ok(plain(dh::read_dh(path, &bytes)?, RobotFormat::Dh, Vec::new(), bytes)),
    }
}

impl RobotFile {
    /// The file with other values, in the frames and units that it was given in: only the numbers that changed are others.
    /// What it cannot say is told.
    ///
    /// # Errors
    /// If the file has no place for them.
    pub fn with_values(&self, path: &Path, values: &[Value]) -> Result<Written, Error> {
        match self.format {
            RobotFormat::Json => Ok(json::with_values(&self.bytes, &self.robot, values)),
            RobotFormat::Urdf => Ok(urdf_writer::write_urdf(path, &self.bytes, &self.robot, values)?),
            RobotFormat::Mjcf => mjcf_writer::write_mjcf(path, &self.bytes, &self.robot, values),
            RobotFormat::Dh => dh::write_dh(path, &self.bytes, &self.robot, values),
        }
    }
}

/// Puts what is known of a creature's joints into its robot: nominal values, and how nearly they are known.
pub fn apply_known(robot: &mut Robot, creature: &Creature, joints: &[KnownJoint]) {
    let knowledge = |exact: bool, deviation: f64| match (exact, deviation.is_finite()) {
        (true, _) => Knowledge::Known,
        (false, true) => Knowledge::Near(deviation),
        (false, false) => Knowledge::Free,
    };
    for known in joints {
        let joint = &creature.joints()[known.joint];
        if let (Some([position, deviation]), Some(at)) =
            (known.position, robot.quantity(&format!("{}.position", joint.name)))
        {
            robot.quantities[at].nominal = Value::Position(position);
            for i in 0..3 {
                robot.quantities[at].knowledge[i] = knowledge(known.exact, deviation[i]);
            }
        }
        for (dof, axis, deviation) in &known.axes {
            let place = dof - joint.first_dof();
            if let Some(at) =
                joint.dofs.get(place).and_then(|dof| robot.quantity(&format!("{}.axis", dof.name)))
            {
                robot.quantities[at].nominal = Value::Direction(*axis);
                robot.quantities[at].knowledge = [knowledge(known.exact, *deviation); 3];
            }
        }
    }
}
