//! What is drawn besides a model: a body as it was learned, and the places of a touch.

use nalgebra::{Isometry3, Matrix3, Point3, Translation3};

use crate::agent::Agent;
use crate::geometry::Frame;
use crate::kinematics::limb_frames;
use crate::mujoco::{GeomKind, Mark};
use crate::schema::BodySchema;
use crate::skin::Receptor;

/// The learned body's skin, …
const SKIN: [f32; 4] = [0.98, 0.55, 0.12, 0.34];
/// … its joints, and what lies between them.
const JOINT: [f32; 4] = [0.12, 0.28, 0.6, 1.0];
const BONE: [f32; 4] = [0.2, 0.36, 0.66, 1.0];
/// The two receptors that touch, the point where they do, and the glow about it: without any blue.
const FIRING: [f32; 4] = [1.0, 0.45, 0.0, 1.0];
const POINT: [f32; 4] = [0.95, 0.0, 0.0, 1.0];
const GLOW: [f32; 4] = [1.0, 0.25, 0.0, 0.3];
/// Receptors that the model has itself, and those that were grown on it.
const OWN: [f32; 4] = [0.1, 0.45, 0.85, 1.0];
const GROWN: [f32; 4] = [0.95, 0.6, 0.15, 1.0];
/// The share of a receptor's side that is drawn: what lies between neighbours shows where one ends.
const DRAWN: f64 = 0.85;
/// Radii by the size of a body: of a joint, of what lies between joints, of a point that is touched and of its glow,
/// and how thick a receptor is.
const JOINT_RADIUS: f64 = 0.011;
const BONE_RADIUS: f64 = 0.0045;
const POINT_RADIUS: f64 = 0.012;
const GLOW_RADIUS: f64 = 0.03;
const THICKNESS: f64 = 0.003;

/// A body where a schema has it in a posture, its root limb at `X_WR`: its skin, its joints and bones between them.
/// `size` is the body's, metres. Marks of two schemas of the same body agree one by one.
pub fn learned_body(
    agent: &Agent,
    schema: &BodySchema,
    posture: &[f64],
    root: &Isometry3<f64>,
    size: f64,
) -> Vec<Mark> {
    let creature = agent.creature();
    let frames = limb_frames(creature, schema, posture);
    let mut marks = Vec::new();
    for surface in &agent.skin().surfaces {
        let Some((kind, size, middle)) = surface.shape.mark() else { continue };
        let within = Isometry3::from(surface.pose()) * Translation3::from(middle);
        marks.push(Mark {
            kind,
            size,
            pose: root * Isometry3::from(frames[surface.limb]) * within,
            rgba: SKIN,
            emission: 0.3,
        });
    }
    let joints = creature.joints().iter().zip(&schema.positions);
    let begins: Vec<Point3<f64>> = std::iter::once(frames[0].origin)
        .chain(joints.map(|(joint, position)| frames[joint.parent].point(position)))
        .map(|p| root * Point3::from(p))
        .collect();
    for (joint, begin) in creature.joints().iter().zip(&begins[1..]) {
        let bone = Mark::capsule([begins[joint.parent], *begin], BONE_RADIUS * size, BONE);
        marks.extend([bone, Mark::sphere(begin, JOINT_RADIUS * size, JOINT)]);
    }
    marks
}

/// A skin, each receptor with `X_WL` of its limb; those from number `own` on were grown. `size` is the body's, metres.
pub fn skin<'s>(
    receptors: impl Iterator<Item = (&'s Receptor, Isometry3<f64>)>,
    own: usize,
    size: f64,
) -> Vec<Mark> {
    let mark = |(number, (receptor, limb)): (usize, (&Receptor, Isometry3<f64>))| {
        let whole = patch(receptor, &limb, size);
        let [a, b, thickness] = whole.size;
        let rgba = if number < own { OWN } else { GROWN };
        Mark { size: [DRAWN * a, DRAWN * b, thickness], rgba, emission: 0.2, ..whole }
    };
    receptors.enumerate().map(mark).collect()
}

/// A receptor on its limb at `X_WL`.
fn patch(receptor: &Receptor, limb: &Isometry3<f64>, size: f64) -> Mark {
    let axes = Matrix3::from_columns(&[receptor.tangent, receptor.bitangent(), receptor.normal]);
    let [a, b] = receptor.half_extents;
    let pose = limb * Isometry3::from(Frame { rotation: axes, origin: receptor.position });
    Mark { kind: GeomKind::Box, size: [a, b, THICKNESS * size], pose, rgba: FIRING, emission: 1.0 }
}

/// A touch in the world, as bright as `strength` of 0 to 1: the two receptors with `X_WL` of their limbs, and the point.
/// `size` is the body's, metres.
pub fn lit_touch(
    receptors: [(&Receptor, Isometry3<f64>); 2],
    point: &Point3<f64>,
    strength: f64,
    size: f64,
) -> Vec<Mark> {
    if strength <= 0.0 {
        return Vec::new();
    }
    let shining = |mark: Mark, opacity: f32| Mark {
        rgba: [mark.rgba[0], mark.rgba[1], mark.rgba[2], opacity * strength as f32],
        emission: 1.0,
        ..mark
    };
    let lit = |(receptor, limb): &(&Receptor, _)| shining(patch(receptor, limb, size), FIRING[3]);
    let mut marks: Vec<Mark> = receptors.iter().map(lit).collect();
    for (radius, colour) in [(POINT_RADIUS, POINT), (GLOW_RADIUS, GLOW)] {
        marks.push(shining(Mark::sphere(point, radius * size * (0.5 + 0.5 * strength), colour), colour[3]));
    }
    marks
}

/// Marks on their way from some to as many others, at 0 to 1 of it.
pub fn between(from: &[Mark], to: &[Mark], share: f64) -> Vec<Mark> {
    let on_the_way = |(from, to): (&Mark, &Mark)| {
        let nearer = if share < 0.5 { from } else { to };
        let rotation = from.pose.rotation.try_slerp(&to.pose.rotation, share, 1e-9);
        let translation = from.pose.translation.vector.lerp(&to.pose.translation.vector, share);
        let pose =
            Isometry3::from_parts(Translation3::from(translation), rotation.unwrap_or(nearer.pose.rotation));
        let size = std::array::from_fn(|k| from.size[k] + share * (to.size[k] - from.size[k]));
        Mark { pose, size, ..*nearer }
    };
    from.iter().zip(to).map(on_the_way).collect()
}
