//! Robots to be calibrated and the logs of their touches, as people have them: a description in JSON, URDF, MJCF, a table
//! of Denavit and Hartenberg's numbers; comma-separated values in the units that their columns say.

mod dh;
mod json;
mod log;
mod mjcf;
pub mod simulated;
mod urdf;
mod xml_writer;

use std::path::Path;

use nalgebra::{Rotation3, UnitVector3, Vector3};

pub(crate) use json::{json_of, length, set_prior};
pub use log::{CalibrationLog, add_fixed_places, calibration_table, read_calibration_log};
pub(crate) use log::{joint_cells, joint_titles, name_of};

use crate::calibration::robot::{Element, Form, Robot, RobotDof, Unit, Value};
use crate::creature::DofKind;
use crate::error::Error;
use crate::geometry::Frame;
use crate::model_files::{begins_as, first_letter};
use crate::named::named;
use crate::plausible::{
    GREATEST_ANGLE, GREATEST_COEFFICIENT, GREATEST_LENGTH, is_angle, is_length, place_fault, pose_fault,
    shape_fault,
};
use crate::session::files;

/// The greatest mass, kilograms: that of the heaviest ships.
const GREATEST_MASS: f64 = 1e9;
/// The greatest acceleration by which masses weigh, m/s².
const GREATEST_GRAVITY: f64 = 1e4;

named! {
    "format of a robot",
    /// What a robot's file is.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum RobotFormat {
        /// A description in JSON.
        Json = "description",
        /// URDF.
        Urdf = "URDF",
        /// MJCF.
        Mjcf = "MJCF",
        /// A table of Denavit and Hartenberg's numbers, as comma-separated values.
        Dh = "table",
    }
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
    /// How many links and quantities the robot has from the file.
    own: [usize; 2],
    /// Joints of which the file does not say where they are.
    pub unplaced: Vec<String>,
    /// Whether the file says what is unknown.
    pub says_what_is_open: bool,
    /// What was ignored, in sentences.
    pub notes: Vec<String>,
}

/// A robot's file with what calibration found.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    /// The file.
    pub bytes: Vec<u8>,
    /// What the file's format has no place for, a sentence each.
    pub left_out: Vec<String>,
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
    match fault(&read.robot) {
        Some(fault) => Err(Error::content(path, None, fault)),
        None => Ok(read),
    }
}

fn read_any(path: &Path) -> Result<RobotFile, Error> {
    let bytes = files::read(path)?;
    let (format, (robot, notes)) = match first_letter(&bytes) {
        Some(b'<') if begins_as(&bytes, "mujoco") => (RobotFormat::Mjcf, mjcf::read_mjcf(path)?),
        Some(b'<') => (RobotFormat::Urdf, urdf::read_urdf(path, &bytes)?),
        Some(_) if log::is_log(&bytes) => {
            let fault = "it is a log of touches, not a robot: give the robot first, then the log";
            return Err(Error::content(path, Some(1), fault));
        }
        Some(b'{') => return json::read(path, bytes),
        _ => (RobotFormat::Dh, (dh::read_dh(path, &bytes)?, Vec::new())),
    };
    let mut read = RobotFile { notes, ..RobotFile::new(robot, format, bytes) };
    // In JSON the limbs alone have mounts.
    read.robot.mount_all();
    Ok(read)
}

impl RobotFile {
    /// A robot of a file that says no more.
    fn new(robot: Robot, format: RobotFormat, bytes: Vec<u8>) -> RobotFile {
        let own = [robot.links.len(), robot.quantities.len()];
        let (unplaced, notes) = (Vec::new(), Vec::new());
        RobotFile { robot, format, bytes, own, unplaced, says_what_is_open: false, notes }
    }

    /// The file with other values, in the frames and units that it was given in: only the numbers that changed are others.
    /// What it cannot say is told.
    ///
    /// # Errors
    /// If the file has no place for them.
    pub fn with_values(&self, path: &Path, values: &[Value]) -> Result<Written, Error> {
        match self.format {
            RobotFormat::Json => Ok(json::with_values(&self.bytes, &self.robot, values)),
            RobotFormat::Urdf | RobotFormat::Mjcf => {
                Ok(xml_writer::write_xml(path, &self.bytes, &self.robot, self.own, values)?)
            }
            RobotFormat::Dh => dh::write_dh(path, &self.bytes, &self.robot, values),
        }
    }
}

/// Lets a degree of freedom follow another in proportion, by the coordinate of that one; it becomes an element of a link.
fn follow(
    robot: &mut Robot,
    dof: usize,
    leader: usize,
    [gain, offset]: [f64; 2],
    [link, element]: [usize; 2],
) {
    let RobotDof { coordinate, quantities, .. } = robot.dofs[leader];
    let begins = quantities.map_or(0.0, |q| robot.quantities[q.offset].nominal.number());
    robot.dofs[dof].coordinate = coordinate;
    if let Some(q) = robot.dofs[dof].quantities {
        robot.quantities[q.gain].nominal = Value::Number(gain);
        robot.quantities[q.offset].nominal = Value::Number(offset + gain * begins);
    }
    robot.links[link].elements[element] = Element::Dof(dof);
}

/// What a slide or a hinge does at a distance from its reference.
fn moved(slides: bool, axis: &Vector3<f64>, by: f64) -> Frame {
    if slides {
        return Frame { origin: axis * by, ..Frame::identity() };
    }
    let turn = Rotation3::from_axis_angle(&UnitVector3::new_normalize(*axis), by);
    Frame { rotation: turn.into_inner(), origin: Vector3::zeros() }
}

/// What a geom without a name is called: the one of so many of its body, counted from 0.
fn surface_name(body: &str, place: usize, count: usize) -> String {
    if count == 1 { body.to_string() } else { format!("{body}.{}", place + 1) }
}

/// What of an encoder `format` has no word for, a sentence each: its gain, unless it follows another, and how far its joint gives
/// way.
fn unsaid_of_encoder(robot: &Robot, values: &[Value], dof: usize, format: &str) -> Vec<String> {
    let RobotDof { name, quantities, kind, .. } = &robot.dofs[dof];
    let Some(q) = quantities else { return Vec::new() };
    let [gain, compliance] = [q.gain, q.compliance].map(|quantity| values[quantity].number());
    let mut unsaid = Vec::new();
    if gain != 1.0 && robot.leads(dof) {
        unsaid.push(format!(
            "gain of {name} ({gain:.6}) cannot be expressed in {format}: multiply its encoder reading by it"
        ));
    }
    if compliance != 0.0 {
        let (unit, load) = match kind {
            DofKind::Slide => ("m/N", "force"),
            DofKind::Hinge | DofKind::Ball => ("rad/(N m)", "torque"),
        };
        unsaid.push(format!(
            "compliance of {name} ({compliance:.3e} {unit}) cannot be expressed in {format}: add it times the \
             {load} to its encoder reading"
        ));
    }
    unsaid
}

/// What is wrong with a robot, whatever file it is from, and the fix.
fn fault(robot: &Robot) -> Option<String> {
    let quantities = robot.quantities.iter().filter_map(|quantity| {
        let fault = match (&quantity.nominal, quantity.unit) {
            (Value::Position(place), _) => place_fault(place),
            (Value::Direction(_) | Value::Orientation(_), _) => None,
            (Value::Number(x), Unit::Metre) => beyond(*x, is_length(*x), GREATEST_LENGTH, "metres"),
            (Value::Number(x), Unit::Radian) => beyond(*x, is_angle(*x), GREATEST_ANGLE, "radians"),
            (Value::Number(x), _) => {
                beyond(*x, x.abs() <= GREATEST_COEFFICIENT, GREATEST_COEFFICIENT, "a number")
            }
        };
        fault.map(|fault| format!("{} {fault}", quantity.name))
    });
    let ranges = robot.dofs.iter().filter_map(|dof| {
        let (name, [low, high]) = (&dof.name, dof.range);
        let is_possible = if dof.kind == DofKind::Slide { is_length } else { is_angle };
        (!(low <= high && is_possible(low) && is_possible(high))).then(|| {
            format!("the range of {name} is {low} to {high}: give two numbers in order, radians or metres")
        })
    });
    let surfaces = robot.surfaces.iter().filter_map(|surface| {
        let shape = || match &surface.form {
            Form::Solid(shape) => shape_fault(shape),
            Form::Plane => None,
            Form::Sphere(radius) => {
                let possible = robot.quantities[*radius].nominal.number() > 0.0;
                (!possible).then(|| "has no radius above 0: give metres".into())
            }
        };
        let fault = pose_fault(&surface.pose).or_else(shape)?;
        Some(format!("surface {} {fault}", surface.name))
    });
    let masses = robot.masses.iter().filter_map(|mass| {
        let link = &robot.links[mass.link].name;
        if !(0.0..=GREATEST_MASS).contains(&mass.mass) {
            return Some(format!("the mass of {link} is {}: give kilograms, 0 or above", mass.mass));
        }
        place_fault(&mass.centre).map(|fault| format!("the centre of mass of {link} {fault}"))
    });
    let weight = robot.gravity.norm();
    let gravity = (weight.is_nan() || weight > GREATEST_GRAVITY)
        .then(|| format!("its gravity is {:?}: give m/s², such as 0, 0, -9.81", robot.gravity.as_slice()));
    quantities.chain(ranges).chain(surfaces).chain(masses).chain(gravity).next()
}

fn beyond(x: f64, possible: bool, greatest: f64, unit: &str) -> Option<String> {
    (!possible).then(|| format!("is {x}: give {unit} within {greatest}"))
}
