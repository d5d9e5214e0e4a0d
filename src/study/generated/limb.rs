//! What a limb is made of: primitive shapes along it.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::draw::{Draw, quaternion};
use crate::geometry::Shape;

/// A primitive shape on a limb and its pose in the limb's frame: the limb's joint is at the origin, and it lies along z.
#[derive(Clone, Debug)]
pub struct LimbPart {
    /// The shape.
    pub shape: Shape,
    /// Its pose.
    pub pose: Isometry3<f64>,
}

/// What a limb looks like.
#[derive(Clone, Copy, Debug)]
enum Look {
    /// One shape of a radius, with half extents across that vary, and half as long as the limb.
    One(fn(radius: f64, across: [f64; 2], half: f64) -> Shape),
    /// Balls in a row.
    Beads,
    /// A rod with a ball at its end.
    Club,
    /// Two crossed boxes.
    Cross,
}

const LOOKS: [(Look, f64); 7] = [
    (Look::One(|radius, _, half| Shape::Capsule { radius, half_length: half - radius }), 0.36),
    (Look::One(|_, [x, y], half| Shape::Box { half_extents: [x, y, half] }), 0.17),
    (Look::One(|radius, _, half| Shape::Cylinder { radius, half_length: half }), 0.14),
    (Look::One(|_, [x, y], half| Shape::Ellipsoid { semi_axes: [x, y, half] }), 0.12),
    (Look::Beads, 0.07),
    (Look::Club, 0.08),
    (Look::Cross, 0.06),
];

/// The shapes of a limb from `start` to `end` along its z axis, about so thick: radius, metres.
pub fn limb_shapes(draw: &mut Draw, [start, end]: [f64; 2], radius: f64) -> Vec<LimbPart> {
    let (middle, half) = (0.5 * (start + end), 0.5 * (end - start));
    // Thicker than long is a ball.
    let radius = radius.min(0.9 * half);
    let look = draw.weighted(&LOOKS);
    let tilt = tilted(draw);
    match look {
        Look::One(shape) => {
            let across = [0; 2].map(|_| radius * draw.between(0.6, 1.2));
            vec![along(shape(radius, across, half), middle, tilt)]
        }
        Look::Beads => {
            let count = draw.count(2, 3);
            let step = (end - start) / count as f64;
            let bead = Shape::Sphere { radius: 0.48 * step };
            (0..count).map(|k| along(bead.clone(), start + (k as f64 + 0.5) * step, tilt)).collect()
        }
        Look::Club => {
            let thin = draw.between(0.35, 0.7) * radius;
            let head = (draw.between(1.1, 1.6) * radius).min(half);
            let rod = Shape::Capsule { radius: thin, half_length: half - thin };
            let rod = along(rod, middle, UnitQuaternion::identity());
            vec![rod, along(Shape::Sphere { radius: head }, end - head, tilt)]
        }
        Look::Cross => {
            let across = (draw.between(1.5, 2.5) * radius).min(half);
            let rod = Shape::Box { half_extents: [0.6 * radius, 0.6 * radius, half] };
            let beam = Shape::Box { half_extents: [across, 0.5 * radius, 0.5 * radius] };
            let at = start + draw.between(0.5, 0.9) * (end - start);
            vec![along(rod, middle, UnitQuaternion::identity()), along(beam, at, tilt)]
        }
    }
}

/// The shape of a trunk about its origin, so large: half its sides, metres.
pub fn trunk_shape(draw: &mut Draw, half: Vector3<f64>) -> LimbPart {
    let shape = draw.weighted::<fn(Vector3<f64>) -> Shape>(&[
        (|half| Shape::Box { half_extents: half.into() }, 0.4),
        (|half| Shape::Ellipsoid { semi_axes: half.into() }, 0.4),
        (|half| Shape::Cylinder { radius: half.x.min(half.y), half_length: half.z }, 0.1),
        (|half| Shape::Sphere { radius: half.min() }, 0.1),
    ]);
    along(shape(half), 0.0, UnitQuaternion::identity())
}

/// The shape of a palm along z, from `start` on: flat, as wide as it is told, metres.
pub fn palm_shape(draw: &mut Draw, [start, end]: [f64; 2], width: f64, thickness: f64) -> LimbPart {
    let shape = draw.weighted::<fn([f64; 3]) -> Shape>(&[
        (|half_extents| Shape::Box { half_extents }, 0.6),
        (|semi_axes| Shape::Ellipsoid { semi_axes }, 0.4),
    ]);
    let half = [0.5 * width, 0.5 * thickness, 0.5 * (end - start)];
    along(shape(half), 0.5 * (start + end), UnitQuaternion::identity())
}

/// A shape whose centre is on the limb's z axis.
fn along(shape: Shape, z: f64, turned: UnitQuaternion<f64>) -> LimbPart {
    LimbPart { shape, pose: Isometry3::from_parts(Translation3::new(0.0, 0.0, z), turned) }
}

/// A small turn off the limb's line, and any about it.
fn tilted(draw: &mut Draw) -> UnitQuaternion<f64> {
    let [x, y] = [0; 2].map(|_| draw.between(-0.08, 0.08));
    quaternion(1.0, Vector3::new(x, y, 0.0)) * draw.twist()
}
