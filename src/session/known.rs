//! What a user knows of a body, as a file: a schema whole or in part.

use std::path::Path;

use nalgebra::Vector3;
use serde::de::IgnoredAny;
use serde::{Deserialize, Deserializer};
use serde_json::{Map, Value};

use super::fields::check_fields;
use super::schema::STAMP;
use super::{RecordError, UNIT_LENGTH, files};
use crate::creature::{Creature, DofKind, Joint};
use crate::learning::KnownJoint;
use crate::plausible::{GREATEST_LENGTH, is_deviation, place_fault};
use crate::session::record_error::ContentFault;

/// What the file should be, in the sentence of one that is not.
const CONTENT: &str = "object of known joints";

/// The fields of a joint.
const OF_JOINT: [&str; 7] =
    ["joint", "parent", "position", "position_std", "axes", "limb_position", "limb_quaternion"];
/// The fields of an axis.
const OF_AXIS: [&str; 4] = ["dof", "kind", "axis", "axis_std"];

/// The file. A learned schema is one, too.
#[derive(Deserialize)]
#[serde(expecting = "an object")]
struct KnownJointsFile {
    format: Option<String>,
    creature: Option<String>,
    joints: Vec<KnownJointEntry>,
}

/// One joint.
#[derive(Deserialize)]
#[serde(expecting = "an object")]
struct KnownJointEntry {
    joint: String,
    parent: Option<String>,
    position: Option<[f64; 3]>,
    position_std: Option<PositionStd>,
    axes: Option<Vec<KnownAxisEntry>>,
    limb_position: Option<IgnoredAny>,
    limb_quaternion: Option<IgnoredAny>,
}

/// The deviation of a position.
#[derive(Clone, Copy, Deserialize)]
#[serde(untagged, expecting = "one deviation in metres, or one for each coordinate")]
enum PositionStd {
    /// The same for all coordinates.
    One(f64),
    /// One each; null where nothing is known.
    Each([Option<f64>; 3]),
}

/// One axis.
#[derive(Deserialize)]
#[serde(expecting = "an object")]
struct KnownAxisEntry {
    dof: Option<String>,
    axis: Option<[f64; 3]>,
    /// Absent where the axis is exact, null where nothing is known of it.
    #[serde(default, deserialize_with = "present")]
    axis_std: Option<Option<f64>>,
}

/// Tells null from a field that is not there.
fn present<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Option<f64>>, D::Error> {
    Option::<f64>::deserialize(deserializer).map(Some)
}

/// Reads what is known of a creature's joints from the file `path`.
///
/// The file holds `{"joints": [{"joint": NAME, "position": [x, y, z], "position_std": S, "axes": [{"dof":
/// NAME, "axis": [x, y, z], "axis_std": S}]}]}`, in metres and radians and in the frames of a schema. A
/// joint with position and all axes and no deviations is known exactly; with deviations it is known nearly,
/// and may then lack its position or its axes. A `schema.json` is such a file.
///
/// # Errors
/// [`RecordError::Io`] where the file cannot be read, [`RecordError::Format`] where it is no such file, has fields that
/// such files do not have, names what the creature has not, or gives numbers that cannot be.
pub fn read_known(path: &Path, creature: &Creature) -> Result<Vec<KnownJoint>, RecordError> {
    let json = files::read(path)?;
    let content: KnownJointsFile =
        serde_json::from_slice(&json).map_err(|error| RecordError::json(path, CONTENT, &error))?;
    check_all_fields(&json).map_err(|fault| RecordError::format(path, None, fault))?;
    if content.format.is_some() {
        STAMP.check(path, None, &json)?;
    }
    known_joints(&content, creature).map_err(|message| RecordError::format(path, None, message))
}

/// Refuses fields that no such file has, at any depth: what is misspelt would be unknown in silence.
fn check_all_fields(json: &[u8]) -> Result<(), ContentFault> {
    // It has been read before.
    let Ok(Value::Object(file)) = serde_json::from_slice::<Value>(json) else { return Ok(()) };
    check_fields(&file, "", &["format", "version", "creature", "joints"])?;
    let each = |map: &Map<String, Value>, list: &str| {
        let entries = map.get(list).and_then(Value::as_array).cloned().unwrap_or_default();
        entries.into_iter().enumerate().filter_map(|(i, entry)| match entry {
            Value::Object(entry) => Some((i, entry)),
            _ => None,
        })
    };
    for (i, joint) in each(&file, "joints") {
        check_fields(&joint, &format!("joints[{i}]."), &OF_JOINT)?;
        for (k, axis) in each(&joint, "axes") {
            check_fields(&axis, &format!("joints[{i}].axes[{k}]."), &OF_AXIS)?;
        }
    }
    Ok(())
}

fn known_joints(content: &KnownJointsFile, creature: &Creature) -> Result<Vec<KnownJoint>, ContentFault> {
    if let Some(other) = content.creature.as_ref().filter(|name| *name != creature.name()) {
        return Err(format!(
            "it is of \"{other}\", not of \"{}\": give what is known of that one",
            creature.name()
        )
        .into());
    }
    let mut known: Vec<KnownJoint> = Vec::new();
    for (i, entry) in content.joints.iter().enumerate() {
        let Some(joint) = creature.joints().iter().position(|joint| joint.name == entry.joint) else {
            return Err(format!(
                "its joint {} is \"{}\", which {} does not have among those that move: `bodyschema inspect` names \
                 them",
                i + 1,
                entry.joint,
                creature.name()
            ).into());
        };
        if known.iter().any(|other| other.joint == joint) {
            return Err(format!("joint \"{}\" occurs twice: leave one of them out", entry.joint).into());
        }
        let found = known_joint(entry, creature, joint)
            .map_err(|problem| format!("joint \"{}\" {problem}", entry.joint))?;
        known.extend(found);
    }
    Ok(known)
}

/// What is known of one joint; none where the file says only that nothing is.
fn known_joint(
    entry: &KnownJointEntry,
    creature: &Creature,
    index: usize,
) -> Result<Option<KnownJoint>, ContentFault> {
    let joint = &creature.joints()[index];
    let parent = &creature.limbs()[joint.parent];
    if entry.limb_position.is_some() || entry.limb_quaternion.is_some() {
        return Err(
            "tells the pose of its limb, so that limbs are in frames of their own: give joints that were \
                    learned with --frames joint"
                .into(),
        );
    }
    if let Some(other) = entry.parent.as_ref().filter(|other| *other != parent) {
        return Err(
            format!("is on \"{parent}\", not on \"{other}\": give it in the frame of \"{parent}\"").into()
        );
    }
    let position = position(entry)?;
    let axes = match &entry.axes {
        None => Vec::new(),
        Some(axes) => read_axes(axes, joint)?,
    };
    let deviations = || {
        let position = position.iter().flat_map(|[_, std]| std.iter().copied());
        position.chain(axes.iter().map(|(_, _, std)| *std))
    };
    let turning = joint.dofs.iter().filter(|dof| dof.kind != DofKind::Ball).count();
    let exact = deviations().all(|std| std == 0.0);
    if exact && (position.is_none() || axes.len() < turning) {
        if position.is_none() && axes.is_empty() {
            return match (&entry.position, &entry.axes) {
                (None, None) => {
                    Err("has neither a position nor axes: give what is known, or leave it out".into())
                }
                _ => Ok(None),
            };
        }
        let missing = if position.is_none() { "position" } else { "axes" };
        return Err(format!(
            "has no {missing}, and only a whole joint can be known exactly: give all of it, or deviations \
             (position_std, axis_std) of what is given"
        )
        .into());
    }
    if !exact && deviations().any(|std| std == 0.0) {
        return Err(
            "is known exactly in one part and nearly in another: give a deviation (position_std, axis_std) \
             greater than zero to each part, or to none"
                .into(),
        );
    }
    let axes = axes.into_iter().filter(|(_, _, std)| std.is_finite()).collect::<Vec<_>>();
    let position = position.filter(|[_, std]| std.iter().any(|std| std.is_finite()));
    let anything = position.is_some() || !axes.is_empty();
    Ok(anything.then_some(KnownJoint { joint: index, exact, position, axes }))
}

/// The position and its deviations, zero where it is exact and infinite where nothing is known.
fn position(entry: &KnownJointEntry) -> Result<Option<[Vector3<f64>; 2]>, String> {
    let Some(position) = entry.position else {
        return match entry.position_std {
            None => Ok(None),
            Some(_) => Err("has a position_std but no position: give both or neither".into()),
        };
    };
    let std = match entry.position_std {
        None => [0.0; 3],
        Some(PositionStd::One(std)) => [std; 3],
        Some(PositionStd::Each(each)) => each.map(|std| std.unwrap_or(f64::INFINITY)),
    };
    if let Some(wrong) = std.iter().find(|std| !is_deviation(**std)) {
        return Err(format!(
            "has a position_std of {wrong}: give metres that are not negative, to {GREATEST_LENGTH} at the most, or null"
        ));
    }
    if let Some(fault) = place_fault(&position.into()) {
        return Err(format!("has a position that {fault}"));
    }
    Ok(Some([position.into(), std.into()]))
}

/// Degree of freedom, axis and deviation of every axis, zero where it is exact and infinite where nothing
/// is known.
fn read_axes(axes: &[KnownAxisEntry], joint: &Joint) -> Result<Vec<(usize, Vector3<f64>, f64)>, String> {
    if axes.len() != joint.dofs.len() {
        return Err(format!(
            "has {} axes in place of {}: give one for each degree of freedom, in their order",
            axes.len(),
            joint.dofs.len()
        ));
    }
    let mut read = Vec::new();
    for ((entry, dof), k) in axes.iter().zip(&joint.dofs).zip(joint.dof_indices()) {
        if let Some(other) = entry.dof.as_ref().filter(|other| **other != dof.name) {
            return Err(format!(
                "has \"{other}\" in place of \"{}\": keep to the creature's order",
                dof.name
            ));
        }
        let axis: Vector3<f64> = match (entry.axis, dof.kind) {
            (None, DofKind::Ball) => continue,
            (Some(_), DofKind::Ball) => {
                return Err(format!("has an axis of \"{}\", which is a ball: leave it out", dof.name));
            }
            (None, _) => {
                return Err(format!("has no axis of \"{}\": give it, or no axes at all", dof.name));
            }
            (Some(axis), _) => axis.into(),
        };
        let length = axis.norm();
        if (length - 1.0).abs() > UNIT_LENGTH {
            return Err(match axis.try_normalize(1e-9) {
                Some(unit) => format!(
                    "has an axis of \"{}\" of length {length}: divide it by its length, [{}, {}, {}]",
                    dof.name, unit.x, unit.y, unit.z
                ),
                None => format!("has an axis of \"{}\" of length zero: give a direction", dof.name),
            });
        }
        let std = match entry.axis_std {
            None => 0.0,
            Some(std) => std.unwrap_or(f64::INFINITY),
        };
        if !is_deviation(std) {
            return Err(format!(
                "has an axis_std of {std} for \"{}\": give radians that are not negative, or null",
                dof.name
            ));
        }
        read.push((k, axis, std));
    }
    Ok(read)
}
