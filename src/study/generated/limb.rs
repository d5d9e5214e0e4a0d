//! What a limb is made of: primitive shapes along it.

use nalgebra::{UnitQuaternion, Vector3};

use super::draw::{Draw, quaternion};

/// The kinds of primitive shapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Primitive {
    /// A cylinder with half balls at its ends: radius, half length.
    Capsule,
    /// Radius, half length.
    Cylinder,
    /// Half its sides.
    Box,
    /// Half its axes.
    Ellipsoid,
    /// Radius.
    Sphere,
}

impl Primitive {
    /// Its name in MJCF.
    pub fn name(self) -> &'static str {
        match self {
            Primitive::Capsule => "capsule",
            Primitive::Cylinder => "cylinder",
            Primitive::Box => "box",
            Primitive::Ellipsoid => "ellipsoid",
            Primitive::Sphere => "sphere",
        }
    }
}

/// A primitive shape on a limb, in the limb's frame: its joint is at the origin, and it lies along z.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Its kind.
    pub kind: Primitive,
    /// Its sizes as in MJCF, metres.
    pub size: Vec<f64>,
    /// Its centre, metres.
    pub centre: Vector3<f64>,
    /// How it is turned.
    pub turned: UnitQuaternion<f64>,
}

/// What a limb looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Look {
    One(Primitive),
    /// Balls in a row.
    Beads,
    /// A rod with a ball at its end.
    Club,
    /// Two crossed boxes.
    Cross,
}

const LOOKS: [(Look, f64); 7] = [
    (Look::One(Primitive::Capsule), 0.36),
    (Look::One(Primitive::Box), 0.17),
    (Look::One(Primitive::Cylinder), 0.14),
    (Look::One(Primitive::Ellipsoid), 0.12),
    (Look::Beads, 0.07),
    (Look::Club, 0.08),
    (Look::Cross, 0.06),
];

/// The shapes of a limb from `start` to `end` along its z axis, about so thick: radius, metres.
pub fn limb_shapes(draw: &mut Draw, [start, end]: [f64; 2], radius: f64) -> Vec<Shape> {
    let (middle, half) = (0.5 * (start + end), 0.5 * (end - start));
    // Thicker than long is a ball.
    let radius = radius.min(0.9 * half);
    let look = draw.weighted(&LOOKS);
    let tilt = tilted(draw);
    let at = |kind: Primitive, size: Vec<f64>, z: f64, turned: UnitQuaternion<f64>| Shape {
        kind,
        size,
        centre: Vector3::z() * z,
        turned,
    };
    match look {
        Look::One(kind) => {
            let [x, y] = [0; 2].map(|_| radius * draw.between(0.6, 1.2));
            let size = match kind {
                Primitive::Capsule => vec![radius, half - radius],
                Primitive::Cylinder => vec![radius, half],
                Primitive::Sphere => vec![half],
                Primitive::Box | Primitive::Ellipsoid => vec![x, y, half],
            };
            vec![at(kind, size, middle, tilt)]
        }
        Look::Beads => {
            let count = draw.count(2, 3);
            let step = (end - start) / count as f64;
            let bead =
                |k: usize| at(Primitive::Sphere, vec![0.48 * step], start + (k as f64 + 0.5) * step, tilt);
            (0..count).map(bead).collect()
        }
        Look::Club => {
            let thin = draw.between(0.35, 0.7) * radius;
            let head = (draw.between(1.1, 1.6) * radius).min(half);
            let rod = at(Primitive::Capsule, vec![thin, half - thin], middle, UnitQuaternion::identity());
            vec![rod, at(Primitive::Sphere, vec![head], end - head, tilt)]
        }
        Look::Cross => {
            let across = (draw.between(1.5, 2.5) * radius).min(half);
            let rod = at(
                Primitive::Box,
                vec![0.6 * radius, 0.6 * radius, half],
                middle,
                UnitQuaternion::identity(),
            );
            let beam = vec![across, 0.5 * radius, 0.5 * radius];
            vec![rod, at(Primitive::Box, beam, start + draw.between(0.5, 0.9) * (end - start), tilt)]
        }
    }
}

/// The shape of a trunk about its origin, so large: half its sides, metres.
pub fn trunk_shape(draw: &mut Draw, half: Vector3<f64>) -> Shape {
    let kind = draw.weighted(&[
        (Primitive::Box, 0.4),
        (Primitive::Ellipsoid, 0.4),
        (Primitive::Cylinder, 0.1),
        (Primitive::Sphere, 0.1),
    ]);
    let size = match kind {
        Primitive::Cylinder | Primitive::Capsule => vec![half.x.min(half.y), half.z],
        Primitive::Sphere => vec![half.min()],
        Primitive::Box | Primitive::Ellipsoid => half.iter().copied().collect(),
    };
    Shape { kind, size, centre: Vector3::zeros(), turned: UnitQuaternion::identity() }
}

/// The shape of a palm along z, from `start` on: flat, as wide as it is told, metres.
pub fn palm_shape(draw: &mut Draw, [start, end]: [f64; 2], width: f64, thickness: f64) -> Shape {
    let kind = draw.weighted(&[(Primitive::Box, 0.6), (Primitive::Ellipsoid, 0.4)]);
    Shape {
        kind,
        size: vec![0.5 * width, 0.5 * thickness, 0.5 * (end - start)],
        centre: Vector3::z() * (0.5 * (start + end)),
        turned: UnitQuaternion::identity(),
    }
}

/// A small turn off the limb's line, and any about it.
fn tilted(draw: &mut Draw) -> UnitQuaternion<f64> {
    let [x, y] = [0; 2].map(|_| draw.between(-0.08, 0.08));
    quaternion(1.0, Vector3::new(x, y, 0.0)) * draw.twist()
}
