//! Robots to be calibrated. What else was here is in [`session`](crate::session).

mod robot;

pub use crate::session::*;
pub use robot::{
    CalibrationLog, RobotFile, RobotFormat, Written, add_fixed_places, apply_known, calibration_table,
    is_mjcf, read_calibration_log, read_robot,
};
pub(crate) use robot::{joint_cells, joint_titles, json_of, length, name_of, set_prior};
