//! What is drawn besides a model: a learned body, and the receptors of a touch.

use nalgebra::{Isometry3, Matrix3, Point3, Translation3};

use crate::creature::Body;
use crate::geometry::Frame;
use crate::kinematics::limb_frames;
use crate::mujoco::{GeomCopy, GeomKind, Mark};
use crate::schema::BodySchema;
use crate::skin::Receptor;

/// The colours of the two receptors, of the point where they touch, and of the glow about it: without any blue.
const FIRING: [f32; 4] = [1.0, 0.45, 0.0, 1.0];
const POINT: [f32; 4] = [0.95, 0.0, 0.0, 1.0];
const GLOW: [f32; 4] = [1.0, 0.25, 0.0, 0.3];
/// Radii of the point and of its glow, and how thick a receptor is, by the size of the body.
const POINT_RADIUS: f64 = 0.012;
const GLOW_RADIUS: f64 = 0.03;
const THICKNESS: f64 = 0.003;

/// The geoms of a body placed by a schema in a posture, its root limb at `X_WR`.
pub(super) fn learned_body(
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

/// A touch: its two receptors with `X_WL` of their limbs, and the point. `size` is the body's, metres.
pub(super) fn lit_touch(
    receptors: [(&Receptor, Isometry3<f64>); 2],
    point: &Point3<f64>,
    size: f64,
) -> Vec<Mark> {
    let patch = |(receptor, limb): (&Receptor, Isometry3<f64>)| {
        let axes = Matrix3::from_columns(&[receptor.tangent, receptor.bitangent(), receptor.normal]);
        let [a, b] = receptor.half_extents;
        let pose = limb * Isometry3::from(Frame { rotation: axes, origin: receptor.position });
        Mark { kind: GeomKind::Box, size: [a, b, THICKNESS * size], pose, rgba: FIRING, emission: 1.0 }
    };
    let sphere = |radius: f64, colour| Mark { emission: 1.0, ..Mark::sphere(point, radius * size, colour) };
    let [a, b] = receptors.map(patch);
    vec![a, b, sphere(POINT_RADIUS, POINT), sphere(GLOW_RADIUS, GLOW)]
}

/// Geoms moved from some poses towards others, at 0 to 1 of the path.
pub(super) fn between(from: &[GeomCopy], to: &[GeomCopy], share: f64) -> Vec<GeomCopy> {
    let moved = |(from, to): (&GeomCopy, &GeomCopy)| {
        let nearer = if share < 0.5 { from } else { to };
        let rotation = from.pose.rotation.try_slerp(&to.pose.rotation, share, 1e-9);
        let translation = from.pose.translation.vector.lerp(&to.pose.translation.vector, share);
        let rotation = rotation.unwrap_or(nearer.pose.rotation);
        GeomCopy { geom: from.geom, pose: Isometry3::from_parts(Translation3::from(translation), rotation) }
    };
    from.iter().zip(to).map(moved).collect()
}
