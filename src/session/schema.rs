//! The learned body schema as a file of names.

use std::path::Path;

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use serde::{Deserialize, Deserializer, Serialize};

use super::stamp::Stamp;
use super::{RecordError, SESSION_FILE, UNIT_LENGTH, files, mistaken};
use crate::creature::{Creature, DofKind, Joint};
use crate::geometry::Frame;
use crate::plausible::{GREATEST_LEARNED, GREATEST_LENGTH, is_deviation};
use crate::schema::{BodySchema, SchemaStd};
use crate::session::record_error::ContentFault;

pub(super) const STAMP: Stamp = Stamp { format: "bodyschema schema", version: 1 };

/// The file, behind its stamp. Fields that it has besides are passed over.
#[derive(Deserialize, Serialize)]
#[serde(expecting = "an object")]
struct SchemaFile {
    creature: String,
    joints: Vec<JointEntry>,
}

/// One joint.
#[derive(Deserialize, Serialize)]
#[serde(expecting = "an object")]
pub(super) struct JointEntry {
    joint: String,
    /// The name of the limb it is mounted on.
    parent: String,
    /// `l_P`: its position in the parent limb's frame, metres.
    position: [f64; 3],
    /// Standard deviation of each of its coordinates, metres; null where nothing determines it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    position_std: Option<[Option<f64>; 3]>,
    axes: Vec<AxisEntry>,
    /// `c`: the origin of the frame of the limb that it carries, in the frame of the joint, metres. Only where
    /// limbs have frames of their own and the touches told this one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    limb_position: Option<[f64; 3]>,
    /// `Q`: the rotation from that frame to the joint's, a unit quaternion w x y z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    limb_quaternion: Option<[f64; 4]>,
}

/// One degree of freedom.
#[derive(Deserialize, Serialize)]
#[serde(expecting = "an object")]
struct AxisEntry {
    dof: String,
    /// Of use to other programs; this one knows it from the creature.
    #[serde(skip_serializing_if = "Option::is_none")]
    kind: Option<DofKind>,
    /// `a_P`, of unit length; a ball has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    axis: Option<[f64; 3]>,
    /// Standard deviation of each of the two coordinates of the axis across its direction, radians; null
    /// where nothing determines it.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    axis_std: Option<Option<f64>>,
}

/// A field that is there, if only as a null.
fn present<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Option<f64>>, D::Error> {
    Option::deserialize(deserializer).map(Some)
}

/// Writes a creature's schema to the file `path`, whole or not at all; its folder is made if missing.
///
/// # Errors
/// [`RecordError::Io`] where the file cannot be written, [`RecordError::Format`] for a schema that
/// could not be read again: of another shape than the creature's, not finite, or with axes that are
/// not of unit length.
pub fn write_schema(path: &Path, creature: &Creature, schema: &BodySchema) -> Result<(), RecordError> {
    write_schema_with_std(path, creature, schema, None)
}

/// Like [`write_schema`], with the standard deviations of the positions and axes where these are known.
///
/// # Errors
/// Those of [`write_schema`], and [`RecordError::Format`] for deviations of another shape than the
/// creature's.
pub fn write_schema_with_std(
    path: &Path,
    creature: &Creature,
    schema: &BodySchema,
    std: Option<&SchemaStd>,
) -> Result<(), RecordError> {
    let shape = |std: &SchemaStd| (std.positions.len(), std.axes.len());
    if std.is_some_and(|std| shape(std) != (schema.positions.len(), schema.axes.len())) {
        let message = "the standard deviations are not those of the schema: give one for each of its numbers";
        return Err(RecordError::format(path, None, message));
    }
    check(creature, schema).map_err(|message| RecordError::format(path, None, message))?;
    let content =
        SchemaFile { creature: creature.name().into(), joints: joint_entries(creature, schema, std) };
    if let Some(folder) = path.parent() {
        files::make_folder(folder)?;
    }
    files::write_json(path, &STAMP.on(&content))
}

/// The joints of a schema by name, in the creature's order.
pub(super) fn joint_entries(
    creature: &Creature,
    schema: &BodySchema,
    std: Option<&SchemaStd>,
) -> Vec<JointEntry> {
    let entry = |(j, joint): (usize, &Joint)| {
        let axes = joint.dof_indices().zip(&joint.dofs).map(|(k, dof)| AxisEntry {
            dof: dof.name.clone(),
            kind: Some(dof.kind),
            axis: (dof.kind != DofKind::Ball).then(|| schema.axes[k].into()),
            axis_std: std.filter(|_| dof.kind != DofKind::Ball).map(|std| determined(std.axes[k])),
        });
        // A limb without a place keeps the joint's frame.
        let pose = schema.limb_poses.get(j).filter(|pose| **pose != Frame::identity());
        JointEntry {
            limb_position: pose.map(|pose| pose.origin.into()),
            limb_quaternion: pose.map(Frame::wxyz),
            joint: joint.name.clone(),
            parent: creature.limbs()[joint.parent].clone(),
            position: schema.positions[j].into(),
            position_std: std.map(|std| std.positions[j].map(determined)),
            axes: axes.collect(),
        }
    };
    creature.joints().iter().enumerate().map(entry).collect()
}

/// A deviation that tells anything.
fn determined(std: Option<f64>) -> Option<f64> {
    std.filter(|std| is_deviation(*std) && std.is_finite())
}

/// Reads a creature's schema from the file `path`.
///
/// # Errors
/// [`RecordError::Io`] where the file cannot be read, [`RecordError::Format`] where it is no schema or
/// one of a newer version, where its names are not the creature's, where an axis is not of unit length, and where a
/// position or a deviation cannot be.
pub fn read_schema(path: &Path, creature: &Creature) -> Result<BodySchema, RecordError> {
    Ok(read_schema_with_std(path, creature)?.0)
}

/// Like [`read_schema`], with the standard deviations of the positions and axes where the file has them.
///
/// # Errors
/// Those of [`read_schema`].
pub fn read_schema_with_std(
    path: &Path,
    creature: &Creature,
) -> Result<(BodySchema, Option<SchemaStd>), RecordError> {
    let json = files::read(path).map_err(|error| {
        let session = path.parent().filter(|folder| folder.join(SESSION_FILE).exists());
        match session.filter(|_| mistaken::is_missing(&error)) {
            Some(folder) => RecordError::format(folder, None, mistaken::for_schema(folder)),
            None => error,
        }
    })?;
    STAMP.check(path, None, &json)?;
    let content: SchemaFile =
        serde_json::from_slice(&json).map_err(|error| RecordError::json(path, "body schema", &error))?;
    let schema = schema_of(&content, creature).map_err(|message| RecordError::format(path, None, message))?;
    if let Some(fault) = half_deviations(&content.joints) {
        return Err(RecordError::format(path, None, fault));
    }
    Ok((schema, std_of(&content.joints)))
}

/// What is wrong where some joints have deviations and others none: one that is misspelt would be unknown in silence.
fn half_deviations(joints: &[JointEntry]) -> Option<String> {
    let turning = |axis: &&AxisEntry| axis.axis.is_some();
    let with = |joint: &JointEntry| {
        let axes = joint.axes.iter().filter(turning).map(|axis| axis.axis_std.is_some());
        [joint.position_std.is_some()].into_iter().chain(axes).collect::<Vec<_>>()
    };
    let any = joints.iter().flat_map(with).any(|given| given);
    let without = joints.iter().find(|joint| any && with(joint).contains(&false))?;
    Some(format!(
        "joint \"{}\" lacks a position_std or an axis_std, which others have: give it, null where nothing is known, or leave \
         out all",
        without.joint
    ))
}

/// The standard deviations of joints; none where the file has none.
fn std_of(joints: &[JointEntry]) -> Option<SchemaStd> {
    let positions: Option<Vec<_>> = joints.iter().map(|joint| joint.position_std).collect();
    // A ball has no axis, hence no deviation of one.
    let axes = joints.iter().flat_map(|joint| &joint.axes).map(|axis| axis.axis_std.flatten());
    Some(SchemaStd { positions: positions?, axes: axes.collect() })
}

const MEND: &str = "give a schema that was learned with the same model and joints";

fn schema_of(content: &SchemaFile, creature: &Creature) -> Result<BodySchema, ContentFault> {
    if content.creature != creature.name() {
        return Err(
            format!("it is of \"{}\", not of \"{}\": {MEND}", content.creature, creature.name()).into()
        );
    }
    schema_of_joints(&content.joints, creature)
}

/// The schema of joints that are a creature's.
pub(super) fn schema_of_joints(
    joints: &[JointEntry],
    creature: &Creature,
) -> Result<BodySchema, ContentFault> {
    if joints.len() != creature.joints().len() {
        return Err(format!(
            "it has {} joints, but {} has {}: {MEND}",
            joints.len(),
            creature.name(),
            creature.joints().len()
        )
        .into());
    }
    let mut schema = BodySchema::zero(creature);
    if joints.iter().any(|entry| entry.limb_position.is_some() || entry.limb_quaternion.is_some()) {
        schema = schema.with_limb_poses();
    }
    for (i, (entry, joint)) in joints.iter().zip(creature.joints()).enumerate() {
        let parent = &creature.limbs()[joint.parent];
        if (&entry.joint, &entry.parent) != (&joint.name, parent) {
            return Err(format!(
                "its joint {} is \"{}\" on \"{}\", but the creature's is \"{}\" on \"{parent}\": {MEND}",
                i + 1,
                entry.joint,
                entry.parent,
                joint.name
            )
            .into());
        }
        schema.positions[i] = entry.position.into();
        possible(entry).map_err(|problem| format!("joint \"{}\" {problem}", joint.name))?;
        read_axes(entry, joint, &mut schema.axes[joint.dof_indices()])
            .map_err(|problem| format!("joint \"{}\" {problem}: {MEND}", joint.name))?;
        if let Some(pose) = schema.limb_poses.get_mut(i) {
            *pose = read_pose(entry).map_err(|problem| format!("joint \"{}\" {problem}", joint.name))?;
        }
    }
    check(creature, &schema).map(|()| schema)
}

/// Refuses numbers of a joint that cannot be. What is written may be farther off: learning may have gone astray.
fn possible(entry: &JointEntry) -> Result<(), String> {
    let places = [Some(entry.position), entry.limb_position].into_iter().flatten();
    let beyond = |x: &f64| x.is_nan() || x.abs() > GREATEST_LEARNED;
    if let Some(wrong) = places.flatten().find(beyond) {
        return Err(format!("has a coordinate of {wrong} m: give metres"));
    }
    let positions = entry.position_std.iter().flatten();
    let axes = entry.axes.iter().filter_map(|axis| axis.axis_std.as_ref());
    match positions.chain(axes).flatten().find(|std| !is_deviation(**std)) {
        Some(wrong) => Err(format!(
            "has a standard deviation of {wrong}: give one that is not negative, to {GREATEST_LENGTH} at the most, or null"
        )),
        None => Ok(()),
    }
}

/// The pose of a joint's limb; that of the joint where none is given.
fn read_pose(entry: &JointEntry) -> Result<Frame, ContentFault> {
    match (entry.limb_position, entry.limb_quaternion) {
        (None, None) => Ok(Frame::identity()),
        (Some(position), Some([w, x, y, z])) => {
            let quaternion = Quaternion::new(w, x, y, z);
            let length = quaternion.norm();
            if length.is_nan() || (length - 1.0).abs() > UNIT_LENGTH {
                return Err(
                    format!("has a limb_quaternion of length {length}: divide it by its length").into()
                );
            }
            let rotation = UnitQuaternion::from_quaternion(quaternion).to_rotation_matrix().into_inner();
            Ok(Frame { rotation, origin: position.into() })
        }
        _ => Err("has one of limb_position and limb_quaternion: give both or none".into()),
    }
}

fn read_axes(entry: &JointEntry, joint: &Joint, axes: &mut [Vector3<f64>]) -> Result<(), ContentFault> {
    if entry.axes.len() != joint.dofs.len() {
        return Err(format!("has {} axes in place of {}", entry.axes.len(), joint.dofs.len()).into());
    }
    for ((found, dof), axis) in entry.axes.iter().zip(&joint.dofs).zip(axes) {
        if found.dof != dof.name {
            return Err(format!("has \"{}\" in place of \"{}\"", found.dof, dof.name).into());
        }
        if found.kind.is_some_and(|kind| kind != dof.kind) {
            return Err(format!("has another kind of \"{}\"", dof.name).into());
        }
        match found.axis {
            Some(found) if dof.kind != DofKind::Ball => *axis = found.into(),
            None if dof.kind != DofKind::Ball => {
                return Err(format!("has no axis of \"{}\"", dof.name).into());
            }
            _ => {}
        }
    }
    Ok(())
}

fn check(creature: &Creature, schema: &BodySchema) -> Result<(), ContentFault> {
    if !schema.fits(creature) {
        return Err(format!(
            "the schema has not {} positions and {} axes of finite numbers: give one of {}",
            creature.joints().len(),
            creature.dof_elements(),
            creature.name()
        )
        .into());
    }
    for (joint, pose) in creature.joints().iter().zip(&schema.limb_poses) {
        let turned = pose.rotation.tr_mul(&pose.rotation) - Matrix3::identity();
        if turned.amax() > UNIT_LENGTH || pose.rotation.determinant() < 0.0 {
            return Err(
                format!("the pose of the limb on \"{}\" has no rotation: give one", joint.name).into()
            );
        }
    }
    for (dof, axis) in creature.dofs().zip(&schema.axes) {
        if dof.kind != DofKind::Ball && (axis.norm() - 1.0).abs() > UNIT_LENGTH {
            return Err(format!(
                "the axis of \"{}\" has length {}: divide it by its length",
                dof.name,
                axis.norm()
            )
            .into());
        }
    }
    Ok(())
}
