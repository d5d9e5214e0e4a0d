//! The body schema as a file of names: what was learned of all joints, or what is known of some.

use std::path::Path;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

use super::stamp::Stamp;
use super::{SESSION_FILE, UNIT_LENGTH, files, mistaken};
use crate::creature::{Creature, DofKind, Joint};
use crate::error::Error;
use crate::geometry::Frame;
use crate::learning::KnownJoint;
use crate::named::did_you_mean;
use crate::plausible::{GREATEST_LEARNED, GREATEST_LENGTH, is_deviation};
use crate::schema::{BodySchema, SchemaStd};

const STAMP: Stamp = Stamp { format: "bodyschema schema", version: 1 };

/// The fields of a file, of its joints and of their axes.
const FIELDS: [&[&str]; 3] = [
    &["format", "version", "creature", "joints"],
    &["joint", "parent", "position", "position_std", "axes", "limb_position", "limb_quaternion"],
    &["dof", "kind", "axis", "axis_std"],
];
/// Which of them hold the next.
const LISTS: [&str; 2] = ["joints", "axes"];

/// The file, behind its stamp.
#[derive(Deserialize, Serialize)]
struct SchemaFile {
    creature: Option<String>,
    joints: Vec<JointEntry>,
}

/// One joint.
#[derive(Clone, Deserialize, Serialize)]
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
#[serde(untagged, expecting = "one deviation in metres, or one per coordinate")]
enum PositionStd {
    /// The same for all coordinates.
    One(f64),
    /// One each; null if nothing determines it.
    Each([Option<f64>; 3]),
}

/// One degree of freedom.
#[derive(Clone, Deserialize, Serialize)]
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
        let message = "the standard deviations do not match the schema: give one for each of its numbers";
        return Err(Error::content(path, None, message));
    }
    check_shape(creature, schema).map_err(|message| Error::content(path, None, message))?;
    let joints = joint_entries(creature, schema, std);
    schema_of_joints(&joints, creature).map_err(|message| Error::content(path, None, message))?;
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
        match session.filter(|_| error.is_missing()) {
            Some(folder) => mistaken::for_schema(folder),
            None => error,
        }
    })?;
    let read = content.joints_of(creature).and_then(|joints| {
        let schema = schema_of(&joints, creature)?;
        Ok((schema, std_of(&joints, creature)?))
    });
    read.map_err(|fault| Error::content(path, None, fault))
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
    let all: Value = serde_json::from_slice(&json).map_err(unread)?;
    check_fields(&all, "", 0).map_err(refuse)?;
    if all.get("format").is_some() {
        STAMP.check(path, None, &json)?;
    }
    let joints = content.joints_of(creature).map_err(refuse)?;
    let known = joints.into_iter().map(|(joint, entry)| {
        entry.known(joint, creature).map_err(|fault| refuse(format!("joint \"{}\" {fault}", entry.joint)))
    });
    Ok(known.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
}

/// Refuses fields that no such file has, at any depth: a misspelt one would be ignored. `at` stands before their names.
fn check_fields(object: &Value, at: &str, depth: usize) -> Result<(), String> {
    let known = FIELDS[depth];
    let mut fields = object.as_object().into_iter().flatten().map(|(field, _)| field.as_str());
    if let Some(unknown) = fields.find(|field| !known.contains(field)) {
        let near = did_you_mean(unknown, known.iter().copied());
        let meant = near.map_or(String::new(), |near| format!(" (is {near} meant?)"));
        let fields = known.join(", ");
        return Err(format!(
            "{at}{unknown} is unknown{meant}: rename it or leave it out, the fields are {fields}"
        ));
    }
    let Some(list) = LISTS.get(depth) else { return Ok(()) };
    let mut inner = object[*list].as_array().into_iter().flatten().enumerate();
    inner.try_for_each(|(i, inner)| check_fields(inner, &format!("{at}{list}[{i}]."), depth + 1))
}

impl SchemaFile {
    fn joints_of(&self, creature: &Creature) -> Result<Vec<(usize, &JointEntry)>, String> {
        match self.creature.as_ref().filter(|name| *name != creature.name()) {
            None => joints_of(&self.joints, creature),
            Some(other) => Err(format!(
                "it belongs to \"{other}\", not to \"{}\": give one learned with the same model and joints",
                creature.name()
            )),
        }
    }
}

/// The joints of a file, each once and as it can be, with their places in the creature.
fn joints_of<'e>(
    entries: &'e [JointEntry],
    creature: &Creature,
) -> Result<Vec<(usize, &'e JointEntry)>, String> {
    let mut all: Vec<(usize, &JointEntry)> = Vec::with_capacity(entries.len());
    for (i, entry) in entries.iter().enumerate() {
        let name = &entry.joint;
        let Some(joint) = creature.joints().iter().position(|joint| joint.name == *name) else {
            return Err(format!(
                "its joint {} is \"{name}\", which is not a moving joint of {}: choose one that `bodyschema inspect` lists",
                i + 1,
                creature.name()
            ));
        };
        if all.iter().any(|(other, _)| *other == joint) {
            return Err(format!("joint \"{name}\" occurs twice: leave one of them out"));
        }
        entry
            .check(&creature.joints()[joint], creature)
            .map_err(|fault| format!("joint \"{name}\" {fault}"))?;
        all.push((joint, entry));
    }
    Ok(all)
}

impl JointEntry {
    /// Checks that what it says of a joint can be.
    fn check(&self, joint: &Joint, creature: &Creature) -> Result<(), String> {
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
        let deviations = self.position_std().into_iter().flatten().flatten();
        if let Some(wrong) = { deviations }.find(|std| !is_deviation(*std)) {
            return Err(format!(
                "has a position_std of {wrong}, an impossible standard deviation: give metres from 0 to \
                 {GREATEST_LENGTH}, or null"
            ));
        }
        let axes = self.axes.as_deref().unwrap_or_default();
        if self.axes.is_some() && axes.len() != joint.dofs.len() {
            return Err(format!(
                "has {} axes instead of {}: give one for each degree of freedom, in order",
                axes.len(),
                joint.dofs.len()
            ));
        }
        axes.iter().zip(&joint.dofs).try_for_each(|(axis, dof)| axis.check(&dof.name, dof.kind))?;
        self.pose().map(drop)
    }

    /// The standard deviation of each coordinate of its position; `None` if the file gives none.
    fn position_std(&self) -> Option<[Option<f64>; 3]> {
        self.position_std.map(|std| match std {
            PositionStd::One(std) => [Some(std); 3],
            PositionStd::Each(each) => each,
        })
    }

    /// Degrees of freedom by their index, their axes, and the axes' deviations, if the file gives them; those of balls have none.
    fn axes(&self, joint: &Joint) -> Vec<(usize, Vector3<f64>, Option<Option<f64>>)> {
        let axes = self.axes.iter().flatten().zip(joint.dof_indices());
        axes.filter_map(|(entry, k)| Some((k, entry.axis?.into(), entry.axis_std))).collect()
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
            _ => Err("has only one of limb_position and limb_quaternion: give both or neither".into()),
        }
    }

    /// What is known of a joint before the first touch; `None` if the file says only that nothing is.
    fn known(&self, index: usize, creature: &Creature) -> Result<Option<KnownJoint>, String> {
        if self.limb_position.is_some() {
            let message = "has the pose of its limb, so limbs have their own frames: give joints learned with --frames joint";
            return Err(message.into());
        }
        // What is exact has no deviation, and that of what nothing determines is infinite.
        let unknown = |std: Option<f64>| std.unwrap_or(f64::INFINITY);
        let stds = Vector3::from(self.position_std().unwrap_or([Some(0.0); 3]).map(unknown));
        let position = self.position.map(|position| [position.into(), stds]);
        let joint = &creature.joints()[index];
        let axes = self.axes(joint).into_iter().map(|(k, axis, std)| (k, axis, std.map_or(0.0, unknown)));
        let axes: Vec<(usize, Vector3<f64>, f64)> = axes.collect();
        let of_position = position.iter().flat_map(|[_, std]| std.iter().copied());
        let all: Vec<f64> = of_position.chain(axes.iter().map(|(.., std)| *std)).collect();
        let exact = all.iter().all(|std| *std == 0.0);
        if exact && (position.is_none() || axes.len() < axis_count(joint)) {
            if position.is_none() && axes.is_empty() {
                return match self.axes.is_some() {
                    false => Err("has neither a position nor axes: give one of them, or leave it out".into()),
                    true => Ok(None),
                };
            }
            let missing = if position.is_none() { "position" } else { "axes" };
            return Err(format!(
                "has no {missing}, but only a complete joint can be exact: give all of it, or standard deviations \
                 (position_std, axis_std)"
            ));
        }
        if !exact && all.contains(&0.0) {
            let message = "is exact in one part and uncertain in another: give a deviation (position_std, axis_std) above zero for each part, or for none";
            return Err(message.into());
        }
        let axes: Vec<_> = axes.into_iter().filter(|(.., std)| std.is_finite()).collect();
        let position = position.filter(|[_, std]| std.iter().any(|std| std.is_finite()));
        let anything = position.is_some() || !axes.is_empty();
        Ok(anything.then_some(KnownJoint { joint: index, exact, position, axes }))
    }
}

impl AxisEntry {
    /// Checks that what it says of a degree of freedom can be.
    fn check(&self, name: &str, kind: DofKind) -> Result<(), String> {
        if let Some(other) = self.dof.as_ref().filter(|other| *other != name) {
            return Err(format!("has \"{other}\" instead of \"{name}\": use the creature's order"));
        }
        if self.kind.is_some_and(|other| other != kind) {
            return Err(format!("has a different kind of \"{name}\": give a schema of the same joints"));
        }
        let axis: Vector3<f64> = match (self.axis, kind) {
            (None, DofKind::Ball) => return Ok(()),
            (Some(_), DofKind::Ball) => {
                return Err(format!("has an axis of \"{name}\", which is a ball: leave it out"));
            }
            (None, _) => return Err(format!("has no axis for \"{name}\": give it, or no axes at all")),
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
        match self.axis_std.flatten().filter(|std| !is_deviation(*std)) {
            None => Ok(()),
            Some(wrong) => {
                Err(format!("has an axis_std of {wrong} for \"{name}\": give radians, 0 or above, or null"))
            }
        }
    }
}

/// How many axes a joint has: a ball has none.
fn axis_count(joint: &Joint) -> usize {
    joint.dofs.iter().filter(|dof| dof.kind != DofKind::Ball).count()
}

/// The schema of joints that are all of a creature's.
pub(super) fn schema_of_joints(entries: &[JointEntry], creature: &Creature) -> Result<BodySchema, String> {
    schema_of(&joints_of(entries, creature)?, creature)
}

fn schema_of(joints: &[(usize, &JointEntry)], creature: &Creature) -> Result<BodySchema, String> {
    let (given, wanted) = (joints.len(), creature.joints().len());
    if given != wanted {
        let name = creature.name();
        return Err(format!("it has {given} joints, but {name} has {wanted}: give one with the same joints"));
    }
    let mut schema = BodySchema::zero(creature);
    if joints.iter().any(|(_, entry)| entry.limb_position.is_some()) {
        schema = schema.with_limb_poses();
    }
    for (index, entry) in joints {
        let joint = &creature.joints()[*index];
        let lacks = |what: &str| format!("joint \"{}\" has no {what}: give it", joint.name);
        schema.positions[*index] = entry.position.ok_or_else(|| lacks("position"))?.into();
        let axes = entry.axes(joint);
        if axes.len() != axis_count(joint) {
            return Err(lacks("axes"));
        }
        axes.into_iter().for_each(|(k, axis, _)| schema.axes[k] = axis);
        if let Some(pose) = entry.pose()? {
            schema.limb_poses[*index] = pose;
        }
    }
    check_shape(creature, &schema).map(|()| schema)
}

/// The standard deviations of all joints; `None` if none is given.
fn std_of(joints: &[(usize, &JointEntry)], creature: &Creature) -> Result<Option<SchemaStd>, String> {
    let mut std = SchemaStd {
        positions: vec![[None; 3]; creature.joints().len()],
        axes: vec![None; creature.dof_elements()],
    };
    let known = |std: Option<f64>| std.filter(|std| std.is_finite());
    let (mut given, mut without) = (false, None);
    for (index, entry) in joints {
        let position = entry.position_std();
        let axes = entry.axes(&creature.joints()[*index]);
        let gives = || axes.iter().map(|(.., std)| std.is_some()).chain([position.is_some()]);
        given |= gives().any(|gives| gives);
        without = without.or(gives().any(|gives| !gives).then_some(&entry.joint));
        std.positions[*index] = position.unwrap_or_default().map(known);
        axes.iter().for_each(|(k, _, of_axis)| std.axes[*k] = of_axis.and_then(known));
    }
    match without {
        _ if !given => Ok(None),
        None => Ok(Some(std)),
        // One that is misspelt would be unknown in silence.
        Some(joint) => Err(format!(
            "joint \"{joint}\" has no position_std or axis_std, unlike others: give it (null if unknown), or \
             leave out all"
        )),
    }
}

fn check_shape(creature: &Creature, schema: &BodySchema) -> Result<(), String> {
    if schema.fits(creature) {
        return Ok(());
    }
    Err(format!(
        "the schema does not have {} finite positions and {} finite axes: give a schema of {}",
        creature.joints().len(),
        creature.dof_elements(),
        creature.name()
    ))
}
