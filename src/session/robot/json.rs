//! A robot in JSON: a creature's tree with its maker's numbers, and what is mounted on it.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::{Rotation3, Vector3};
use serde::Deserialize;
use serde::de::IgnoredAny;

use super::{RobotFile, RobotFormat, Written};
use crate::calibration::robot::{Form, Knowledge, LinkMass, NominalJoint, Robot, Unit, Value};
use crate::creature::{Creature, Dof, DofKind, Joint};
use crate::error::Error;
use crate::geometry::{Frame, Shape};
use crate::plausible::GREATEST_LENGTH;

/// Length of a direction at the most that is given without regard to it.
const GREATEST_DIRECTION: f64 = 1e6;

const PI: f64 = std::f64::consts::PI;

/// The file, or the `creature` of a session.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RobotJson {
    name: String,
    limbs: Vec<String>,
    joints: Vec<JointJson>,
    #[serde(flatten)]
    extras: Extras,
    #[serde(default, rename = "aura_limbs")]
    _aura_limbs: IgnoredAny,
}

/// What is on a robot, and what is known of it.
#[derive(Default, Deserialize)]
struct Extras {
    #[serde(default)]
    frames: Vec<FrameJson>,
    #[serde(default)]
    points: Vec<PointJson>,
    #[serde(default)]
    surfaces: Vec<SurfaceJson>,
    #[serde(default)]
    masses: Vec<MassJson>,
    gravity: Option<[f64; 3]>,
    #[serde(default)]
    values: BTreeMap<String, Numbers>,
    #[serde(default)]
    free: Vec<String>,
    #[serde(default)]
    fix: Vec<String>,
    #[serde(default)]
    prior: BTreeMap<String, Deviation>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct JointJson {
    name: String,
    parent: NameOrIndex,
    #[serde(default, rename = "limb")]
    _limb: IgnoredAny,
    position: Option<[f64; 3]>,
    dofs: Vec<DofJson>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DofJson {
    name: String,
    kind: DofKind,
    range: Option<[f64; 2]>,
    axis: Option<[f64; 3]>,
    #[serde(default, rename = "follows")]
    _follows: IgnoredAny,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "a limb's name or its index")]
enum NameOrIndex {
    Name(String),
    Index(usize),
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
#[serde(untagged, expecting = "a number or three")]
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
    let json: RobotJson = serde_path_to_error::deserialize(value).map_err(|error| {
        let place = error.path().to_string();
        let place = if place == "." { String::new() } else { format!("{place}: ") };
        refuse(format!("{place}{}: mend it as the documentation of a robot's file says", error.inner()))
    })?;
    let read = robot(json).map_err(refuse)?;
    Ok(RobotFile { bytes, ..read })
}

fn robot(json: RobotJson) -> Result<RobotFile, String> {
    let mut joints = Vec::new();
    let mut nominal = Vec::new();
    let mut unplaced = Vec::new();
    for joint in &json.joints {
        let parent = match &joint.parent {
            NameOrIndex::Index(index) => *index,
            NameOrIndex::Name(name) => json.limbs.iter().position(|limb| limb == name).ok_or_else(|| {
                format!("joint {}: there is no limb \"{name}\" in limbs: add it, or name another", joint.name)
            })?,
        };
        let mut dofs = Vec::new();
        let mut axes = Vec::new();
        let mut placed = joint.position.is_some();
        for dof in &joint.dofs {
            let range = match (dof.range, dof.kind) {
                (Some(range), _) => range,
                (None, DofKind::Hinge) => [-PI, PI],
                (None, DofKind::Ball) => [0.0, PI],
                (None, DofKind::Slide) => {
                    return Err(format!("{} is a slide and has no range: give its ends in metres", dof.name));
                }
            };
            dofs.push(Dof { name: dof.name.clone(), kind: dof.kind, range, follows: None });
            placed &= dof.axis.is_some() || dof.kind == DofKind::Ball;
            let axis = Vector3::from(dof.axis.unwrap_or([0.0, 0.0, 1.0]));
            if axis.norm() > GREATEST_DIRECTION {
                return Err(format!(
                    "the axis of {} has length {}: give a direction, of length 1 as nearly as may be",
                    dof.name,
                    axis.norm()
                ));
            }
            axes.push(
                axis.try_normalize(1e-9)
                    .ok_or_else(|| format!("the axis of {} has no length: give a direction", dof.name))?,
            );
        }
        if !placed {
            unplaced.push(joint.name.clone());
        }
        nominal.push(NominalJoint { position: joint.position.unwrap_or_default().into(), axes });
        joints.push(Joint::new(joint.name.clone(), parent, dofs));
    }
    let creature =
        Creature::new(json.name, json.limbs, joints, Vec::new()).map_err(|error| error.to_string())?;
    let mut robot = Robot::of_creature(&creature, &nominal);
    let says_what_is_open = add_extras(&mut robot, json.extras)?;
    Ok(RobotFile {
        robot,
        format: RobotFormat::Json,
        bytes: Vec::new(),
        creature: Some(creature),
        unplaced,
        says_what_is_open,
        notes: Vec::new(),
    })
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
                    "surface {} is a mesh without a hull: give a shape that is known",
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

/// Units of deviations, longest first, and what they are of.
const UNITS: [(&str, f64, Unit); 6] = [
    ("mm", 1e-3, Unit::Metre),
    ("cm", 1e-2, Unit::Metre),
    ("deg", PI / 180.0, Unit::Radian),
    ("°", PI / 180.0, Unit::Radian),
    ("rad", 1.0, Unit::Radian),
    ("m", 1.0, Unit::Metre),
];

/// The name of a unit, and what it is of.
type NamedUnit = (&'static str, Unit);

/// A deviation above 0 in its base unit, and its unit where it has one: `0.01`, `5mm`, `2 deg`.
fn deviation(text: &str) -> Result<(f64, Option<NamedUnit>), String> {
    let text = text.trim();
    let unit = UNITS.iter().find(|(name, ..)| text.ends_with(name));
    let number = unit.map_or(text, |(name, ..)| text.trim_end_matches(name).trim());
    let number = number.parse().map_or(f64::NAN, |x: f64| x * unit.map_or(1.0, |(_, factor, _)| *factor));
    Ok((possible_deviation(number, text)?, unit.map(|(name, _, unit)| (*name, *unit))))
}

/// A deviation that may be, in its base unit; `text` is what was written.
fn possible_deviation(number: f64, text: &str) -> Result<f64, String> {
    match number {
        _ if !(number.is_finite() && number > 0.0) => {
            Err(format!("\"{text}\" is no deviation: give a number above 0 and a unit, such as 5mm or 2deg"))
        }
        _ if number > GREATEST_LENGTH => {
            Err(format!("\"{text}\" is no deviation: give less, or say that nothing is known with free"))
        }
        _ => Ok(number),
    }
}

/// A deviation of a position, metres.
pub(crate) fn length(text: &str) -> Result<f64, String> {
    match deviation(text)? {
        (_, Some((name, Unit::Radian))) => {
            Err(format!("a position is not measured in {name}: give millimetres"))
        }
        (_, None) => Err(format!("\"{text}\" has no unit: give millimetres, as in {text}mm")),
        (metres, _) => Ok(metres),
    }
}

/// Says that what a pattern names is known to a deviation, which has the unit of what it is of.
pub(crate) fn set_prior(robot: &mut Robot, pattern: &str, text: &str) -> Result<(), String> {
    let (value, unit) = deviation(text).map_err(|fault| format!("{pattern}: {fault}"))?;
    let before: Vec<_> = robot.quantities.iter().map(|quantity| quantity.knowledge).collect();
    robot.set_knowledge(pattern, Knowledge::Near(value))?;
    let set = robot.quantities.iter().zip(&before);
    let mut named =
        set.filter(|(quantity, before)| quantity.knowledge != **before).map(|(quantity, _)| quantity);
    let fits = |quantity: &&crate::calibration::robot::Quantity| match quantity.unit {
        Unit::Metre | Unit::Radian => unit.map(|(_, unit)| unit) == Some(quantity.unit),
        Unit::One | Unit::Compliance => unit.is_none(),
    };
    match (named.find(|quantity| !fits(quantity)), unit) {
        (None, _) => Ok(()),
        (Some(other), Some((name, _))) => {
            Err(format!("{} is not measured in {name}: give its deviation in its own unit", other.name))
        }
        (Some(other), None) => {
            let example = if other.unit == Unit::Metre { "mm" } else { "deg" };
            Err(format!(
                "the deviation of {} has no unit: give one, as in {pattern}={text}{example}",
                other.name
            ))
        }
    }
}

fn named(robot: &Robot, what: &str, link: &str) -> Result<usize, String> {
    robot.link(link).ok_or_else(|| {
        format!("{what} is on \"{link}\", which there is not: name a limb or a frame before it")
    })
}

/// A pose of a position and URDF's roll, pitch and yaw.
fn pose(position: [f64; 3], [roll, pitch, yaw]: [f64; 3]) -> Frame {
    let rotation = Rotation3::from_euler_angles(roll, pitch, yaw).into_inner();
    Frame { rotation, origin: position.into() }
}

/// Gives a quantity a value of its own.
fn set_value(robot: &mut Robot, name: &str, numbers: &Numbers) -> Result<(), String> {
    let at = robot
        .quantity(name)
        .ok_or_else(|| format!("values: nothing of {} is called \"{name}\": leave it out", robot.name))?;
    let value = match (robot.quantities[at].nominal, numbers) {
        (Value::Number(_), Numbers::One(x)) => Value::Number(*x),
        (Value::Position(_), Numbers::Three(at)) => Value::Position((*at).into()),
        (Value::Orientation(_), Numbers::Three(turn)) => {
            Value::Orientation(Rotation3::new(Vector3::from(*turn)).into_inner())
        }
        (Value::Direction(_), Numbers::Three(axis)) => {
            let axis = Vector3::from(*axis).try_normalize(1e-9);
            Value::Direction(axis.ok_or_else(|| format!("values: {name} has no length: give a direction"))?)
        }
        (Value::Number(_), _) => return Err(format!("values: {name} is one number: give one")),
        _ => return Err(format!("values: {name} has three numbers: give all")),
    };
    robot.quantities[at].nominal = value;
    Ok(())
}

/// The file with other values: all that are not the maker's stand by name in a field of their own, before all others.
pub(super) fn with_values(bytes: &[u8], robot: &Robot, values: &[Value]) -> Written {
    let others = robot.quantities.iter().zip(values).filter(|(quantity, value)| quantity.nominal != **value);
    let mut named: BTreeMap<String, serde_json::Value> = BTreeMap::new();
    let before: Option<BTreeMap<String, serde_json::Value>> =
        serde_json::from_slice::<serde_json::Value>(bytes)
            .ok()
            .and_then(|file| serde_json::from_value(file.get("values")?.clone()).ok());
    named.extend(before.clone().unwrap_or_default());
    for (quantity, value) in others {
        named.insert(quantity.name.clone(), json_of(value));
    }
    let lines: Vec<String> = named
        .iter()
        .map(|(name, value)| format!("    {}: {value}", serde_json::Value::from(name.as_str())))
        .collect();
    let field = format!("\"values\": {{\n{}\n  }}", lines.join(",\n"));
    let text = String::from_utf8_lossy(bytes);
    let object: Result<BTreeMap<&str, &serde_json::value::RawValue>, _> =
        serde_json::from_str(text.trim_start_matches('\u{feff}'));
    let left_out = match &object {
        Ok(object) if object.contains_key("limbs") => Vec::new(),
        _ => vec![
            "a whole session keeps its creature as it was: the new values are in calibration.json"
                .to_string(),
        ],
    };
    if !left_out.is_empty() {
        return Written { bytes: bytes.to_vec(), left_out };
    }
    let old = object.ok().and_then(|object| object.get("values").map(|raw| raw.get().to_string()));
    let text = match old {
        // The old values' text is there once with its name before it.
        Some(old) => text.replacen(&old, field.trim_start_matches("\"values\": "), 1),
        None => text.replacen('{', &format!("{{\n  {field},"), 1),
    };
    Written { bytes: text.into_bytes(), left_out }
}

/// A value as a file has it.
pub(crate) fn json_of(value: &Value) -> serde_json::Value {
    let three = |v: Vector3<f64>| serde_json::json!([v.x, v.y, v.z]);
    match value {
        Value::Position(v) | Value::Direction(v) => three(*v),
        Value::Orientation(r) => three(Rotation3::from_matrix_unchecked(*r).scaled_axis()),
        Value::Number(x) => serde_json::json!(x),
    }
}
