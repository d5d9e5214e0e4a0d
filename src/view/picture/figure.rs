//! What is drawn besides a model: a body as it was learned, and the places of a touch.

use nalgebra::{Isometry3, Matrix3, Point3, Translation3};

use crate::creature::Body;
use crate::geometry::Frame;
use crate::kinematics::limb_frames;
use crate::mujoco::{GeomCopy, GeomKind, Mark};
use crate::schema::BodySchema;
use crate::skin::Receptor;

/// The two receptors that touch, the point where they do, and the glow about it: without any blue.
const FIRING: [f32; 4] = [1.0, 0.45, 0.0, 1.0];
const POINT: [f32; 4] = [0.95, 0.0, 0.0, 1.0];
const GLOW: [f32; 4] = [1.0, 0.25, 0.0, 0.3];
/// Receptors that the model has itself, and those that were grown on it.
const OWN: [f32; 4] = [0.1, 0.45, 0.85, 1.0];
const GROWN: [f32; 4] = [0.95, 0.6, 0.15, 1.0];
/// The share of a receptor's side that is drawn: what lies between neighbours shows where one ends.
const DRAWN: f64 = 0.85;
/// Radii by the size of a body: of a point that is touched and of its glow, and how thick a receptor is.
const POINT_RADIUS: f64 = 0.012;
const GLOW_RADIUS: f64 = 0.03;
const THICKNESS: f64 = 0.003;

/// The geoms of a body where a schema has them in a posture, its root limb at `X_WR`.
pub fn learned_body(
    body: &Body,
    schema: &BodySchema,
    posture: &[f64],
    root: &Isometry3<f64>,
) -> Vec<GeomCopy> {
    let frames = limb_frames(&body.creature, schema, posture);
    let place = |geom: usize| {
        let (info, limb) = (body.model.geom(geom), body.limb_of_geom(geom)?);
        let on_limb = body.geom_in_limb(&info);
        Some(GeomCopy { geom, pose: root * Isometry3::from(frames[limb]) * on_limb })
    };
    (0..body.model.ngeom()).filter(|&geom| !body.model.is_aura(geom)).filter_map(place).collect()
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

/// Geoms on their way from some places to others, at 0 to 1 of it.
pub fn between(from: &[GeomCopy], to: &[GeomCopy], share: f64) -> Vec<GeomCopy> {
    let on_the_way = |(from, to): (&GeomCopy, &GeomCopy)| {
        let nearer = if share < 0.5 { from } else { to };
        let rotation = from.pose.rotation.try_slerp(&to.pose.rotation, share, 1e-9);
        let translation = from.pose.translation.vector.lerp(&to.pose.translation.vector, share);
        let rotation = rotation.unwrap_or(nearer.pose.rotation);
        GeomCopy { geom: from.geom, pose: Isometry3::from_parts(Translation3::from(translation), rotation) }
    };
    from.iter().zip(to).map(on_the_way).collect()
}
