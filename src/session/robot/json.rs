//! A robot in JSON: a creature's tree with nominal values, and the sensors and tools mounted on it.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::{Rotation3, Vector3};
use serde::Deserialize;
use serde_json::value::RawValue;

use super::{RobotFile, RobotFormat, Written};
use crate::calibration::robot::{Element, Form, Knowledge, LinkMass, Quantity, Robot, Unit, Value};
use crate::creature::Creature;
use crate::error::Error;
use crate::geometry::{Frame, Shape};
use crate::model_files::{Edits, Origin};
use crate::plausible::GREATEST_LENGTH;
use crate::session::log::units::{Measure, unit};
use crate::session::recording::{creature_of, list, typed};

/// Length of a direction at the most that is given without regard to it.
const GREATEST_DIRECTION: f64 = 1e6;
/// What is on a robot, and what is known of it.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Extras {
    frames: Vec<FrameJson>,
    points: Vec<PointJson>,
    surfaces: Vec<SurfaceJson>,
    masses: Vec<MassJson>,
    gravity: Option<[f64; 3]>,
    values: BTreeMap<String, Numbers>,
    free: Vec<String>,
    fix: Vec<String>,
    prior: BTreeMap<String, Deviation>,
    /// All else is of the creature.
    #[serde(flatten)]
    creature: serde_json::Map<String, serde_json::Value>,
}

/// A deviation: a number in the quantity's own unit, or a text with a unit.
#[derive(Clone, Deserialize)]
#[serde(untagged, expecting = "a deviation such as 0.01 or \"5 mm\"")]
enum Deviation {
    Number(f64),
    Text(String),
}

/// A quantity's value: a number, three of a position or an axis, the rotation vector of an orientation.
#[derive(Clone, Deserialize)]
#[serde(untagged, expecting = "one number or three")]
enum Numbers {
    One(f64),
    Three([f64; 3]),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FrameJson {
    name: String,
    on: String,
    #[serde(default)]
    position: [f64; 3],
    #[serde(default)]
    rpy: [f64; 3],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PointJson {
    name: String,
    on: String,
    #[serde(default)]
    position: [f64; 3],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SurfaceJson {
    name: String,
    on: String,
    #[serde(default)]
    position: [f64; 3],
    #[serde(default)]
    rpy: [f64; 3],
    shape: ShapeJson,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum ShapeJson {
    Plane,
    #[serde(untagged)]
    Solid(Shape),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MassJson {
    on: String,
    mass: f64,
    #[serde(default)]
    centre: [f64; 3],
}

/// Reads a robot from the bytes of a JSON file.
pub(super) fn read(path: &Path, bytes: Vec<u8>) -> Result<RobotFile, Error> {
    let refuse = |message: String| Error::content(path, None, message);
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
    let mut value: serde_json::Value =
        serde_json::from_slice(text).map_err(|error| Error::json(path, "description of a robot", &error))?;
    // Of a session the creature is what is asked for.
    if let Some(creature) = value.get_mut("creature").map(serde_json::Value::take) {
        value = creature;
    }
    typed(value, "").and_then(|extras| robot(extras, bytes)).map_err(refuse)
}

fn robot(mut extras: Extras, bytes: Vec<u8>) -> Result<RobotFile, String> {
    let mut description = serde_json::Value::from(std::mem::take(&mut extras.creature));
    let (mut nominal, mut unplaced) = (Vec::new(), Vec::new());
    for (j, joint) in list(&mut description, "joints").enumerate() {
        let position = three(joint, "position", &format!("joints[{j}]."))?;
        let mut placed = position.is_some();
        let mut axes = Vec::new();
        for (d, dof) in list(joint, "dofs").enumerate() {
            let axis = three(dof, "axis", &format!("joints[{j}].dofs[{d}]."))?;
            placed &= axis.is_some() || dof["kind"] == "ball";
            let axis = Vector3::from(axis.unwrap_or([0.0, 0.0, 1.0]));
            let unit = axis.try_normalize(1e-9).filter(|_| axis.norm() <= GREATEST_DIRECTION);
            axes.push(unit.ok_or_else(|| {
                let (name, length) = (&dof["name"], axis.norm());
                format!("the axis of {name} has length {length}: give a unit vector")
            })?);
        }
        unplaced.extend(joint["name"].as_str().filter(|_| !placed).map(str::to_string));
        nominal.push((Vector3::from(position.unwrap_or_default()), axes));
    }
    let creature = creature_of(description)?;
    let mut robot = robot_of(&creature, &nominal);
    let says_what_is_open = add_extras(&mut robot, extras)?;
    let read = RobotFile::new(robot, RobotFormat::Json, bytes);
    Ok(RobotFile { unplaced, says_what_is_open, ..read })
}

/// A robot with a creature's limbs and joints at their positions and axes on their parents, one for each joint. A limb's frame has
/// the joint that carries it for its origin and, with all joints at zero, its parent's orientation; its points are on a mount of its
/// own.
fn robot_of(creature: &Creature, nominal: &[(Vector3<f64>, Vec<Vector3<f64>>)]) -> Robot {
    let limbs = creature.limbs();
    let mut robot = Robot::new(creature.name(), limbs[0].clone());
    for ((joint, (position, axes)), limb) in creature.joints().iter().zip(nominal).zip(&limbs[1..]) {
        let link = robot.add_place(&joint.name, joint.parent, *position);
        robot.links[link].name.clone_from(limb);
        for (dof, axis) in joint.dofs.iter().zip(axes) {
            let dof = robot.add_dof(&dof.name, dof.kind, dof.range, *axis);
            robot.links[link].elements.push(Element::Dof(dof));
        }
    }
    robot.mount_all();
    robot
}

/// Takes three numbers out of an object, if it has them; `at` is before the field in messages.
fn three(of: &mut serde_json::Value, field: &str, at: &str) -> Result<Option<[f64; 3]>, String> {
    let value = of.as_object_mut().and_then(|object| object.remove(field));
    value.map_or(Ok(None), |value| typed(value, &format!("{at}{field}")))
}

/// Adds what is on a robot; whether it is said what is unknown.
fn add_extras(robot: &mut Robot, extras: Extras) -> Result<bool, String> {
    for frame in extras.frames {
        let on = named(robot, &frame.name, &frame.on)?;
        robot.add_mount(&frame.name, on, pose(frame.position, frame.rpy));
    }
    for point in extras.points {
        let on = named(robot, &point.name, &point.on)?;
        robot.add_place(&point.name, on, point.position.into());
    }
    for surface in extras.surfaces {
        let on = named(robot, &surface.name, &surface.on)?;
        let pose = pose(surface.position, surface.rpy);
        match surface.shape {
            ShapeJson::Plane => {
                robot.add_surface(&surface.name, on, pose, Form::Plane);
            }
            ShapeJson::Solid(Shape::Sphere { radius }) => {
                robot.add_sphere(&surface.name, on, pose, radius);
            }
            ShapeJson::Solid(shape) if shape.is_solid() => {
                robot.add_surface(&surface.name, on, pose, Form::Solid(shape));
            }
            ShapeJson::Solid(_) => {
                return Err(format!(
                    "surface {} is a mesh without a hull: give a supported shape",
                    surface.name
                ));
            }
        }
    }
    for mass in extras.masses {
        let link = named(robot, "a mass", &mass.on)?;
        robot.masses.push(LinkMass { link, mass: mass.mass, centre: mass.centre.into() });
    }
    if let Some(gravity) = extras.gravity {
        robot.gravity = gravity.into();
    }
    for (name, numbers) in &extras.values {
        set_value(robot, name, numbers)?;
    }
    let says = !extras.free.is_empty() || !extras.prior.is_empty();
    for pattern in &extras.free {
        robot.set_knowledge(pattern, Knowledge::Free)?;
    }
    for (pattern, deviation) in &extras.prior {
        match deviation {
            Deviation::Number(number) => {
                let number = possible_deviation(*number, &number.to_string());
                robot.set_knowledge(
                    pattern,
                    Knowledge::Near(number.map_err(|f| format!("{pattern}: {f}"))?),
                )?;
            }
            Deviation::Text(text) => set_prior(robot, pattern, text)?,
        }
    }
    for pattern in &extras.fix {
        robot.set_knowledge(pattern, Knowledge::Known)?;
    }
    Ok(says)
}

/// A unit as it is written, and what it measures.
type WrittenUnit<'t> = (&'t str, Measure);

/// A deviation above 0 in its base unit, and its unit where it has one: `0.01`, `5mm`, `2 deg`.
fn deviation(text: &str) -> Result<(f64, Option<WrittenUnit<'_>>), String> {
    let text = text.trim();
    let number = text.trim_end_matches(|mark: char| mark.is_alphabetic() || mark == '°');
    let word = &text[number.len()..];
    let unit = unit(word).filter(|_| !word.is_empty());
    let per = if word.is_empty() { 1.0 } else { unit.map_or(f64::NAN, |unit| unit.per) };
    let value = number.trim().parse().map_or(f64::NAN, |x: f64| x / per);
    Ok((possible_deviation(value, text)?, unit.map(|unit| (word, unit.measure))))
}

/// A deviation that may be, in its base unit; `text` is what was written.
fn possible_deviation(number: f64, text: &str) -> Result<f64, String> {
    match number {
        _ if !(number.is_finite() && number > 0.0) => Err(format!(
            "\"{text}\" is not a deviation: give a number above 0 and a unit, such as 5mm or 2deg"
        )),
        _ if number > GREATEST_LENGTH => {
            Err(format!("\"{text}\" is too large for a deviation: give less, or use free"))
        }
        _ => Ok(number),
    }
}

/// A deviation of a position, metres.
pub(crate) fn length(text: &str) -> Result<f64, String> {
    match deviation(text)? {
        (_, Some((name, Measure::Angle))) => Err(format!("{name} is not a unit of length: give millimetres")),
        (_, None) => Err(format!("\"{text}\" has no unit: give millimetres, as in {text}mm")),
        (metres, _) => Ok(metres),
    }
}

/// Says that what a pattern names is known to a deviation, which has the unit of what it is of.
pub(crate) fn set_prior(robot: &mut Robot, pattern: &str, text: &str) -> Result<(), String> {
    let (value, unit) = deviation(text).map_err(|fault| format!("{pattern}: {fault}"))?;
    let before: Vec<_> = robot.quantities.iter().map(|quantity| quantity.knowledge).collect();
    robot.set_knowledge(pattern, Knowledge::Near(value))?;
    let measured = |quantity: &Quantity| match quantity.unit {
        Unit::Metre => Some(Measure::Length),
        Unit::Radian => Some(Measure::Angle),
        Unit::One | Unit::Compliance => None,
    };
    let set = robot.quantities.iter().zip(&before).filter(|(now, before)| now.knowledge != **before);
    let other = { set }.find(|(quantity, _)| measured(quantity) != unit.map(|(_, measure)| measure));
    match (other, unit) {
        (None, _) => Ok(()),
        (Some((other, _)), Some((name, _))) => {
            Err(format!("{} is not measured in {name}: use its own unit", other.name))
        }
        (Some((other, _)), None) => {
            let example = if other.unit == Unit::Metre { "mm" } else { "deg" };
            let name = &other.name;
            Err(format!("the deviation of {name} has no unit: give one, as in {pattern}={text}{example}"))
        }
    }
}

fn named(robot: &Robot, what: &str, link: &str) -> Result<usize, String> {
    robot.link(link).ok_or_else(|| {
        format!("{what} is on \"{link}\", which does not exist: name a limb, or a frame defined earlier")
    })
}

/// A pose of a position and URDF's roll, pitch and yaw.
fn pose(position: [f64; 3], turns: [f64; 3]) -> Frame {
    Origin { place: position.into(), turns }.frame()
}

/// Gives a quantity a value of its own.
fn set_value(robot: &mut Robot, name: &str, numbers: &Numbers) -> Result<(), String> {
    let at = robot
        .quantity(name)
        .ok_or_else(|| format!("values: {} has nothing called \"{name}\": leave it out", robot.name))?;
    let value = match (robot.quantities[at].nominal, numbers) {
        (Value::Number(_), Numbers::One(x)) => Value::Number(*x),
        (Value::Position(_), Numbers::Three(at)) => Value::Position((*at).into()),
        (Value::Orientation(_), Numbers::Three(turn)) => {
            Value::Orientation(Rotation3::new(Vector3::from(*turn)).into_inner())
        }
        (Value::Direction(_), Numbers::Three(axis)) => {
            let axis = Vector3::from(*axis).try_normalize(1e-9);
            Value::Direction(axis.ok_or_else(|| format!("values: {name} has length 0: give a direction"))?)
        }
        (Value::Number(_), _) => return Err(format!("values: {name} takes one number")),
        _ => return Err(format!("values: {name} takes three numbers")),
    };
    robot.quantities[at].nominal = value;
    Ok(())
}

/// The file with other values: all that are not the maker's stand by name in a field of their own, before all others.
pub(super) fn with_values(bytes: &[u8], robot: &Robot, values: &[Value]) -> Written {
    let text = String::from_utf8_lossy(bytes);
    let object = serde_json::from_str(text.trim_start_matches('\u{feff}'));
    let object: BTreeMap<&str, &RawValue> = object.unwrap_or_default();
    if !object.contains_key("limbs") {
        let kept = "a whole session keeps its original creature; the new values are in calibration.json";
        return Written { bytes: bytes.to_vec(), left_out: vec![kept.into()] };
    }
    let before = object.get("values").map(|before| before.get());
    let before_named = before.and_then(|before| serde_json::from_str(before).ok());
    let mut named: BTreeMap<String, serde_json::Value> = before_named.unwrap_or_default();
    let others = robot.quantities.iter().zip(values).filter(|(quantity, value)| quantity.nominal != **value);
    named.extend(others.map(|(quantity, value)| (quantity.name.clone(), json_of(value))));
    let line = |(name, value): (String, serde_json::Value)| {
        format!("    {}: {value}", serde_json::Value::from(name))
    };
    let lines: Vec<String> = named.into_iter().map(line).collect();
    let field = format!("{{\n{}\n  }}", lines.join(",\n"));
    let mut edits = Edits::default();
    match before {
        Some(before) => {
            let at = before.as_ptr() as usize - text.as_ptr() as usize;
            edits.replace(at..at + before.len(), field);
        }
        None => edits.insert(text.find('{').map_or(0, |at| at + 1), format!("\n  \"values\": {field},")),
    }
    Written { bytes: edits.of(text.as_bytes()), left_out: Vec::new() }
}

/// A value as a file has it.
pub(crate) fn json_of(value: &Value) -> serde_json::Value {
    match value.numbers().as_slice() {
        [number] => serde_json::json!(number),
        numbers => serde_json::json!(numbers),
    }
}
