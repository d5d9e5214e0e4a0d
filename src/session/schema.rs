//! The body schema as a file of names: what was learned of all joints, or what is known of some.

use std::path::Path;

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Map, Value};

use super::stamp::Stamp;
use super::{SESSION_FILE, UNIT_LENGTH, files, mistaken};
use crate::creature::{Creature, Dof, DofKind, Joint};
use crate::error::Error;
use crate::geometry::Frame;
use crate::learning::KnownJoint;
use crate::named::did_you_mean;
use crate::plausible::{GREATEST_LEARNED, GREATEST_LENGTH, is_deviation};
use crate::schema::{BodySchema, SchemaStd};

const STAMP: Stamp = Stamp { format: "bodyschema schema", version: 1 };

/// The fields of a joint.
const OF_JOINT: [&str; 7] =
    ["joint", "parent", "position", "position_std", "axes", "limb_position", "limb_quaternion"];
/// The fields of an axis.
const OF_AXIS: [&str; 4] = ["dof", "kind", "axis", "axis_std"];

/// The file, behind its stamp.
#[derive(Deserialize, Serialize)]
#[serde(expecting = "an object")]
struct SchemaFile {
    creature: Option<String>,
    joints: Vec<JointEntry>,
}

/// One joint.
#[derive(Clone, Deserialize, Serialize)]
#[serde(expecting = "an object")]
pub(super) struct JointEntry {
    joint: String,
    /// The name of the limb it is mounted on.
    parent: Option<String>,
    /// `l_P`: its position in the parent limb's frame, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    position: Option<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    position_std: Option<PositionStd>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    axes: Option<Vec<AxisEntry>>,
    /// `c`: the origin of the frame of the limb that it carries, in the frame of the joint, metres. Only if limbs have
    /// frames of their own and the touches determine this one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    limb_position: Option<[f64; 3]>,
    /// `Q`: the rotation from that frame to the joint's, a unit quaternion w x y z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    limb_quaternion: Option<[f64; 4]>,
}

/// The standard deviation of a position, metres.
#[derive(Clone, Copy, Deserialize, Serialize)]
#[serde(untagged, expecting = "one deviation in metres, or one for each coordinate")]
enum PositionStd {
    /// The same for all coordinates.
    One(f64),
    /// One each; null if nothing determines it.
    Each([Option<f64>; 3]),
}

/// One degree of freedom.
#[derive(Clone, Deserialize, Serialize)]
#[serde(expecting = "an object")]
struct AxisEntry {
    dof: Option<String>,
    /// Of use to other programs; this one knows it from the creature.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    kind: Option<DofKind>,
    /// `a_P`, of unit length; a ball has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    axis: Option<[f64; 3]>,
    /// Standard deviation of each of the two coordinates of the axis across its direction, radians; null if nothing
    /// determines it.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    axis_std: Option<Option<f64>>,
}

/// A field that is there, if only as a null.
fn present<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Option<f64>>, D::Error> {
    Option::deserialize(deserializer).map(Some)
}

/// A joint of the creature as a file has it. A deviation that is null in the file, as of what nothing determines, is
/// infinite.
struct Found {
    joint: usize,
    position: Option<Vector3<f64>>,
    /// `None` if the file gives no deviation.
    position_std: Option<[f64; 3]>,
    axes: Vec<ReadAxis>,
    /// Whether the file says anything of axes.
    gives_axes: bool,
    /// The pose of its limb, if it is given.
    pose: Option<Frame>,
}

/// A degree of freedom by its index, its axis, and the axis' deviation, if the file gives one.
type ReadAxis = (usize, Vector3<f64>, Option<f64>);

/// Writes a creature's schema to the file `path`, whole or not at all, with the standard deviations of the positions and axes
/// if these are known; its folder is made if missing.
///
/// # Errors
/// If the file cannot be written, and for a schema that could not be read again: of another shape than the creature's or its
/// deviations, not finite, or with axes that are not of unit length.
pub fn write_schema(
    path: &Path,
    creature: &Creature,
    schema: &BodySchema,
    std: Option<&SchemaStd>,
) -> Result<(), Error> {
    let shape = |std: &SchemaStd| (std.positions.len(), std.axes.len());
    if std.is_some_and(|std| shape(std) != (schema.positions.len(), schema.axes.len())) {
        let message = "the standard deviations are not those of the schema: give one for each of its numbers";
        return Err(Error::content(path, None, message));
    }
    check(creature, schema).map_err(|message| Error::content(path, None, message))?;
    let joints = joint_entries(creature, schema, std);
    STAMP.write(path, &SchemaFile { creature: Some(creature.name().into()), joints })
}

/// The joints of a schema by name, in the creature's order.
pub(super) fn joint_entries(
    creature: &Creature,
    schema: &BodySchema,
    std: Option<&SchemaStd>,
) -> Vec<JointEntry> {
    // A deviation that says anything.
    let determined = |std: Option<f64>| std.filter(|std| is_deviation(*std) && std.is_finite());
    let entry = |(j, joint): (usize, &Joint)| {
        let axes = joint.dof_indices().zip(&joint.dofs).map(|(k, dof)| AxisEntry {
            dof: Some(dof.name.clone()),
            kind: Some(dof.kind),
            axis: (dof.kind != DofKind::Ball).then(|| schema.axes[k].into()),
            axis_std: std.filter(|_| dof.kind != DofKind::Ball).map(|std| determined(std.axes[k])),
        });
        // A limb without a place keeps the joint's frame.
        let pose = schema.limb_poses.get(j).filter(|pose| **pose != Frame::identity());
        JointEntry {
            joint: joint.name.clone(),
            parent: Some(creature.limbs()[joint.parent].clone()),
            position: Some(schema.positions[j].into()),
            position_std: std.map(|std| PositionStd::Each(std.positions[j].map(determined))),
            axes: Some(axes.collect()),
            limb_position: pose.map(|pose| pose.origin.into()),
            limb_quaternion: pose.map(Frame::wxyz),
        }
    };
    creature.joints().iter().enumerate().map(entry).collect()
}

/// Reads a creature's schema from the file `path`.
///
/// # Errors
/// If the file cannot be read, or if it is no schema or one of a newer version, if its
/// names are not the creature's, an axis is not of unit length, or a position or a deviation cannot be.
pub fn read_schema(path: &Path, creature: &Creature) -> Result<BodySchema, Error> {
    Ok(read_schema_with_std(path, creature)?.0)
}

/// Like [`read_schema`], with the standard deviations of the positions and axes if the file has them.
///
/// # Errors
/// Those of [`read_schema`].
pub fn read_schema_with_std(
    path: &Path,
    creature: &Creature,
) -> Result<(BodySchema, Option<SchemaStd>), Error> {
    let content: SchemaFile = STAMP.read(path, "body schema").map_err(|error| {
        let session = path.parent().filter(|folder| folder.join(SESSION_FILE).exists());
        match session.filter(|_| mistaken::is_missing(&error)) {
            Some(folder) => mistaken::for_schema(folder),
            None => error,
        }
    })?;
    let refuse = |fault: String| Error::content(path, None, fault);
    check_creature(&content, creature).map_err(refuse)?;
    let found = found_joints(&content.joints, creature).map_err(refuse)?;
    let schema = schema_of(&found, creature).map_err(refuse)?;
    let std = std_of(&found, creature).map_err(refuse)?;
    Ok((schema, std))
}

/// Reads what is known of a creature's joints from the file `path`.
///
/// The file holds `{"joints": [{"joint": NAME, "position": [x, y, z], "position_std": S, "axes": [{"dof":
/// NAME, "axis": [x, y, z], "axis_std": S}]}]}`, in metres and radians and in the frames of a schema. A
/// joint with position and all axes and no deviations is known exactly; with deviations it is known nearly,
/// and may then lack its position or its axes. A `schema.json` is such a file.
///
/// # Errors
/// If the file cannot be read, or if it is no such file, has fields that
/// such files do not have, names what the creature has not, or gives numbers that cannot be.
pub fn read_known(path: &Path, creature: &Creature) -> Result<Vec<KnownJoint>, Error> {
    let json = files::read(path)?;
    let refuse = |fault: String| Error::content(path, None, fault);
    let unread = |error| Error::json(path, "object of known joints", &error);
    let content: SchemaFile = serde_json::from_slice(&json).map_err(unread)?;
    let all: Map<String, Value> = serde_json::from_slice(&json).map_err(unread)?;
    check_all_fields(&all).map_err(refuse)?;
    if all.contains_key("format") {
        STAMP.check(path, None, &json)?;
    }
    check_creature(&content, creature).map_err(refuse)?;
    let found = found_joints(&content.joints, creature).map_err(refuse)?;
    let known = found.into_iter().map(|found| {
        let joint = &creature.joints()[found.joint];
        known_joint(found, joint).map_err(|problem| format!("joint \"{}\" {problem}", joint.name))
    });
    Ok(known.collect::<Result<Vec<_>, _>>().map_err(refuse)?.into_iter().flatten().collect())
}

/// Refuses fields that no such file has, at any depth: a misspelt one would be ignored.
fn check_all_fields(file: &Map<String, Value>) -> Result<(), String> {
    check_fields(file, "", &["format", "version", "creature", "joints"])?;
    fn each<'a>(map: &'a Map<String, Value>, list: &str) -> impl Iterator<Item = &'a Map<String, Value>> {
        map.get(list).and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_object)
    }
    for (i, joint) in each(file, "joints").enumerate() {
        check_fields(joint, &format!("joints[{i}]."), &OF_JOINT)?;
        for (k, axis) in each(joint, "axes").enumerate() {
            check_fields(axis, &format!("joints[{i}].axes[{k}]."), &OF_AXIS)?;
        }
    }
    Ok(())
}

/// Refuses an object with a field that is none of `known`; `at` stands before its name, with a dot where it is a place.
fn check_fields(map: &Map<String, Value>, at: &str, known: &[&str]) -> Result<(), String> {
    let Some(unknown) = map.keys().find(|key| !known.contains(&key.as_str())) else { return Ok(()) };
    let near = did_you_mean(unknown, known.iter().copied());
    let meant = near.map_or(String::new(), |near| format!(" (is {near} meant?)"));
    let fields = known.join(", ");
    Err(format!("{at}{unknown} is unknown{meant}: rename it or leave it out, the fields are {fields}"))
}

fn check_creature(content: &SchemaFile, creature: &Creature) -> Result<(), String> {
    match content.creature.as_ref().filter(|name| *name != creature.name()) {
        None => Ok(()),
        Some(other) => Err(format!(
            "it is of \"{other}\", not of \"{}\": give one that was learned with the same model and joints",
            creature.name()
        )),
    }
}

/// The joints of a file, each once.
fn found_joints(entries: &[JointEntry], creature: &Creature) -> Result<Vec<Found>, String> {
    let mut all: Vec<Found> = Vec::with_capacity(entries.len());
    for (i, entry) in entries.iter().enumerate() {
        let name = &entry.joint;
        let Some(joint) = creature.joints().iter().position(|joint| joint.name == *name) else {
            return Err(format!(
                "its joint {} is \"{name}\", which {} does not have among those that move: name one that \
                 `bodyschema inspect` lists",
                i + 1,
                creature.name()
            ));
        };
        if all.iter().any(|other| other.joint == joint) {
            return Err(format!("joint \"{name}\" occurs twice: leave one of them out"));
        }
        all.push(entry.found(joint, creature).map_err(|problem| format!("joint \"{name}\" {problem}"))?);
    }
    Ok(all)
}

impl JointEntry {
    /// What the file has of a joint, if it can be.
    fn found(&self, index: usize, creature: &Creature) -> Result<Found, String> {
        let joint = &creature.joints()[index];
        let parent = &creature.limbs()[joint.parent];
        if let Some(other) = self.parent.as_ref().filter(|other| *other != parent) {
            return Err(format!(
                "is on \"{parent}\", not on \"{other}\": give it in the frame of \"{parent}\""
            ));
        }
        let places = [self.position, self.limb_position].into_iter().flatten();
        // What was learned may be far off.
        if let Some(wrong) = places.flatten().find(|x| x.is_nan() || x.abs() > GREATEST_LEARNED) {
            return Err(format!("has a coordinate of {wrong} m: give metres"));
        }
        if self.position.is_none() && self.position_std.is_some() {
            return Err("has a position_std but no position: give both or neither".into());
        }
        let unknown = |std: Option<f64>| std.unwrap_or(f64::INFINITY);
        let given = self.position_std.map(|std| match std {
            PositionStd::One(std) => [Some(std); 3],
            PositionStd::Each(each) => each,
        });
        if let Some(wrong) = given.iter().flatten().flatten().find(|std| !is_deviation(**std)) {
            return Err(format!(
                "has a position_std of {wrong}, and no standard deviation of {wrong} can be: give metres that are not negative, to {GREATEST_LENGTH} at \
                 the most, or null"
            ));
        }
        Ok(Found {
            joint: index,
            position: self.position.map(Vector3::from),
            position_std: given.map(|each| each.map(unknown)),
            axes: self.axes.as_ref().map_or(Ok(Vec::new()), |axes| read_axes(axes, joint))?,
            gives_axes: self.axes.is_some(),
            pose: self.pose()?,
        })
    }

    /// The pose of its limb, if one is given.
    fn pose(&self) -> Result<Option<Frame>, String> {
        match (self.limb_position, self.limb_quaternion) {
            (None, None) => Ok(None),
            (Some(position), Some([w, x, y, z])) => {
                let quaternion = Quaternion::new(w, x, y, z);
                let length = quaternion.norm();
                if length.is_nan() || (length - 1.0).abs() > UNIT_LENGTH {
                    return Err(format!("has a limb_quaternion of length {length}: divide it by its length"));
                }
                let rotation = UnitQuaternion::from_quaternion(quaternion).to_rotation_matrix().into_inner();
                Ok(Some(Frame { rotation, origin: position.into() }))
            }
            _ => Err("has one of limb_position and limb_quaternion: give both or none".into()),
        }
    }
}

/// How many axes a joint has: a ball has none.
fn axis_count(joint: &Joint) -> usize {
    joint.dofs.iter().filter(|dof| dof.kind != DofKind::Ball).count()
}

/// The axes of a joint, as [`Found`] has them.
fn read_axes(axes: &[AxisEntry], joint: &Joint) -> Result<Vec<ReadAxis>, String> {
    if axes.len() != joint.dofs.len() {
        return Err(format!(
            "has {} axes in place of {}: give one for each degree of freedom, in their order",
            axes.len(),
            joint.dofs.len()
        ));
    }
    let mut read = Vec::new();
    for ((entry, dof), k) in axes.iter().zip(&joint.dofs).zip(joint.dof_indices()) {
        let Dof { name, kind, .. } = dof;
        if let Some(other) = entry.dof.as_ref().filter(|other| *other != name) {
            return Err(format!("has \"{other}\" in place of \"{name}\": give them in the creature's order"));
        }
        if entry.kind.is_some_and(|other| other != *kind) {
            return Err(format!("has another kind of \"{name}\": give a schema of the same joints"));
        }
        let axis: Vector3<f64> = match (entry.axis, kind) {
            (None, DofKind::Ball) => continue,
            (Some(_), DofKind::Ball) => {
                return Err(format!("has an axis of \"{name}\", which is a ball: leave it out"));
            }
            (None, _) => return Err(format!("has no axis of \"{name}\": give it, or no axes at all")),
            (Some(axis), _) => axis.into(),
        };
        let length = axis.norm();
        if length.is_nan() || (length - 1.0).abs() > UNIT_LENGTH {
            return Err(match axis.try_normalize(1e-9) {
                Some(unit) => format!(
                    "has an axis of \"{name}\" of length {length}: divide it by its length, [{}, {}, {}]",
                    unit.x, unit.y, unit.z
                ),
                None => format!("has an axis of \"{name}\" of length zero: give a direction"),
            });
        }
        if let Some(wrong) = entry.axis_std.flatten().filter(|std| !is_deviation(*std)) {
            return Err(format!(
                "has an axis_std of {wrong} for \"{name}\", a standard deviation of {wrong}: give radians that are not negative, \
                 or null"
            ));
        }
        read.push((k, axis, entry.axis_std.map(|std| std.unwrap_or(f64::INFINITY))));
    }
    Ok(read)
}

/// The schema of joints that are all of a creature's.
pub(super) fn schema_of_joints(entries: &[JointEntry], creature: &Creature) -> Result<BodySchema, String> {
    schema_of(&found_joints(entries, creature)?, creature)
}

fn schema_of(found: &[Found], creature: &Creature) -> Result<BodySchema, String> {
    let (given, wanted) = (found.len(), creature.joints().len());
    if given != wanted {
        let name = creature.name();
        return Err(format!("it has {given} joints, but {name} has {wanted}: give one of the same joints"));
    }
    let mut schema = BodySchema::zero(creature);
    if found.iter().any(|found| found.pose.is_some()) {
        schema = schema.with_limb_poses();
    }
    for found in found {
        let joint = &creature.joints()[found.joint];
        let lacks = |what: &str| format!("joint \"{}\" has no {what}: give it", joint.name);
        schema.positions[found.joint] = found.position.ok_or_else(|| lacks("position"))?;
        if found.axes.len() != axis_count(joint) {
            return Err(lacks("axes"));
        }
        found.axes.iter().for_each(|(k, axis, _)| schema.axes[*k] = *axis);
        if let Some(pose) = found.pose {
            schema.limb_poses[found.joint] = pose;
        }
    }
    check(creature, &schema).map(|()| schema)
}

/// The standard deviations of all joints; `None` if none is given.
fn std_of(found: &[Found], creature: &Creature) -> Result<Option<SchemaStd>, String> {
    let gives = |found: &Found| {
        let axes = found.axes.iter().map(|(.., std)| std.is_some());
        [found.position_std.is_some()].into_iter().chain(axes).collect::<Vec<bool>>()
    };
    if !found.iter().flat_map(gives).any(|given| given) {
        return Ok(None);
    }
    // One that is misspelt would be unknown in silence.
    if let Some(without) = found.iter().find(|found| gives(found).contains(&false)) {
        return Err(format!(
            "joint \"{}\" lacks a position_std or an axis_std, which others have: give it, null where nothing is known, or leave \
             out all",
            creature.joints()[without.joint].name
        ));
    }
    let mut std = SchemaStd {
        positions: vec![[None; 3]; creature.joints().len()],
        axes: vec![None; creature.dof_elements()],
    };
    let known = |std: f64| Some(std).filter(|std| std.is_finite());
    for found in found {
        std.positions[found.joint] = found.position_std.map_or([None; 3], |each| each.map(known));
        found.axes.iter().for_each(|(k, _, of_axis)| std.axes[*k] = of_axis.and_then(known));
    }
    Ok(Some(std))
}

/// What is known of a joint before the first touch; `None` if the file says only that nothing is.
fn known_joint(found: Found, joint: &Joint) -> Result<Option<KnownJoint>, String> {
    if found.pose.is_some() {
        return Err(
            "has the pose of its limb, so that limbs are in frames of their own: give joints that were learned with \
                    --frames joint"
                .into(),
        );
    }
    // What is exact has no deviation.
    let stds = Vector3::from(found.position_std.unwrap_or_default());
    let position = found.position.map(|position| [position, stds]);
    let axes = found.axes.into_iter().map(|(k, axis, std)| (k, axis, std.unwrap_or_default()));
    let axes: Vec<(usize, Vector3<f64>, f64)> = axes.collect();
    let all: Vec<f64> = { position.iter().flat_map(|[_, std]| std.iter().copied()) }
        .chain(axes.iter().map(|(.., std)| *std))
        .collect();
    let exact = all.iter().all(|std| *std == 0.0);
    if exact && (position.is_none() || axes.len() < axis_count(joint)) {
        if position.is_none() && axes.is_empty() {
            return match found.gives_axes {
                false => Err("has neither a position nor axes: give what is known, or leave it out".into()),
                true => Ok(None),
            };
        }
        let missing = if position.is_none() { "position" } else { "axes" };
        return Err(format!(
            "has no {missing}, and only a whole joint can be known exactly: give all of it, or deviations (position_std, \
             axis_std) of what is given"
        ));
    }
    if !exact && all.contains(&0.0) {
        return Err(
            "is known exactly in one part and nearly in another: give a deviation (position_std, axis_std) \
             greater than zero to each part, or to none"
                .into(),
        );
    }
    let axes: Vec<_> = axes.into_iter().filter(|(.., std)| std.is_finite()).collect();
    let position = position.filter(|[_, std]| std.iter().any(|std| std.is_finite()));
    let anything = position.is_some() || !axes.is_empty();
    Ok(anything.then_some(KnownJoint { joint: found.joint, exact, position, axes }))
}

fn check(creature: &Creature, schema: &BodySchema) -> Result<(), String> {
    if !schema.fits(creature) {
        return Err(format!(
            "the schema has not {} positions and {} axes of finite numbers: give one of {}",
            creature.joints().len(),
            creature.dof_elements(),
            creature.name()
        ));
    }
    for (joint, pose) in creature.joints().iter().zip(&schema.limb_poses) {
        let turned = pose.rotation.tr_mul(&pose.rotation) - Matrix3::identity();
        if turned.amax() > UNIT_LENGTH || pose.rotation.determinant() < 0.0 {
            return Err(format!("the pose of the limb on \"{}\" has no rotation: give one", joint.name));
        }
    }
    for (dof, axis) in creature.dofs().zip(&schema.axes) {
        let length = axis.norm();
        if dof.kind != DofKind::Ball && (length - 1.0).abs() > UNIT_LENGTH {
            return Err(format!("the axis of \"{}\" has length {length}: divide it by its length", dof.name));
        }
    }
    Ok(())
}
