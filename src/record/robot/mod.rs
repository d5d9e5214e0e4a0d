//! Robots to be calibrated and the logs of their touches, as people have them: a description in JSON, URDF, a table of
//! Denavit and Hartenberg's numbers; comma-separated values in the units that their columns say.

mod columns;
mod json;
mod log;

use std::path::Path;

pub(crate) use json::set_prior;
pub use log::{CalibrationLog, read_calibration_log};

use super::{RecordError, files};
use crate::calibration::robot::{Knowledge, Robot, Value};
use crate::creature::Creature;
use crate::learning::KnownJoint;

/// A robot's file, read.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotFile {
    /// The robot at its maker's numbers.
    pub robot: Robot,
    /// Its tree as a creature, where the file is one.
    pub creature: Option<Creature>,
    /// Joints of which the file does not say where they are.
    pub unplaced: Vec<String>,
    /// Whether the file says what is unknown.
    pub says_what_is_open: bool,
}

/// Reads a robot from a file: JSON, as `docs/calibration.md` says.
///
/// # Errors
/// [`RecordError::Io`] where it cannot be read; [`RecordError::Format`], with the place and the mend, where it is none.
pub fn read_robot(path: &Path) -> Result<RobotFile, RecordError> {
    let bytes = files::read(path)?;
    json::read(path, &bytes)
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
