//! Random things that two hands may lift.

use std::f64::consts::TAU;

use nalgebra::{Isometry3, Translation3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::at_table::{THING, TOP, standing};
use crate::geometry::{Hull, Shape};
use crate::simulation::{Substance, Thing};

/// The least and greatest width of a thing, metres.
const WIDTHS: [f64; 2] = [0.04, 0.15];
/// The least and greatest mass, kilograms, …
const MASSES: [f64; 2] = [0.1, 1.0];
/// … and coefficient of friction.
const FRICTIONS: [f64; 2] = [0.5, 1.0];
/// Rings of a turned hull.
const RINGS: usize = 9;

/// The kinds of things.
pub const KINDS: [&str; 5] = ["box", "cylinder", "capsule", "sphere", "hull"];

/// A thing of a kind that stands on the table, or lies there where it is a capsule, with a random size, place, heading, mass
/// and friction.
pub fn random(kind: &str, rng: &mut ChaCha8Rng) -> Thing {
    let mut half = || 0.5 * rng.random_range(WIDTHS[0]..WIDTHS[1]);
    let (a, b, c) = (half(), half(), half());
    let shape = match kind {
        "box" => Shape::Box { half_extents: [a, b, c] },
        "cylinder" => Shape::Cylinder { radius: a, half_length: c },
        // No longer than things are wide.
        "capsule" => {
            let radius = 0.5 * WIDTHS[0] + 0.6 * (a - 0.5 * WIDTHS[0]);
            let longest = 0.5 * WIDTHS[1] - radius;
            Shape::Capsule { radius, half_length: longest * rng.random_range(0.1..1.0) }
        }
        "sphere" => Shape::Sphere { radius: a },
        _ => turned(Vector3::new(a, b, c), rng),
    };
    let (x, y) = (rng.random_range(0.3..0.75), rng.random_range(-0.45..0.45));
    let (middle, turn) = standing(&shape, rng.random_range(0.0..TAU));
    // A hull's origin need not be halfway up.
    let middle = match shape.hull() {
        Some(hull) => -hull.support(&-Vector3::z()).z,
        None => middle,
    };
    let substance = Substance {
        mass: Some(rng.random_range(MASSES[0]..MASSES[1])),
        friction: Some(rng.random_range(FRICTIONS[0]..FRICTIONS[1])),
    };
    let pose = Isometry3::from_parts(Translation3::new(x, y, TOP + middle), turn);
    Thing { name: THING.into(), shape, pose, fixed: false, substance }
}

/// A convex body like what stands in kitchens: a prism, a can, a cup, a pear or a fruit, with some corners around, that
/// tapers to the top or to the bottom and is rounded more or less; no farther from its middle than `half` along the axes.
fn turned(half: Vector3<f64>, rng: &mut ChaCha8Rng) -> Shape {
    let corners = rng.random_range(3..16usize);
    let taper: f64 = rng.random_range(-0.35..0.35);
    let roundness: f64 = rng.random_range(2.0..8.0);
    // A flat bottom, on which it stands.
    let lowest: f64 = rng.random_range(-0.95..-0.8);
    let begin = rng.random_range(0.0..TAU);
    let mut vertices = Vec::new();
    for ring in 0..RINGS {
        let z = lowest + (0.97 - lowest) * ring as f64 / (RINGS - 1) as f64;
        // The lesser of a line and a superellipse, both of which bend inwards or not at all.
        let width =
            (1.0 - taper.abs() + taper * z).min((1.0 - z.abs().powf(roundness)).powf(1.0 / roundness));
        for corner in 0..corners {
            let angle = begin + TAU * corner as f64 / corners as f64;
            vertices.push(Vector3::new(
                half.x * width * angle.cos(),
                half.y * width * angle.sin(),
                half.z * z,
            ));
        }
    }
    let mut triangles = Vec::new();
    for ring in 0..RINGS - 1 {
        for corner in 0..corners {
            let [a, b] = [corner, (corner + 1) % corners].map(|corner| ring * corners + corner);
            triangles.extend([[a, b, b + corners], [a, b + corners, a + corners]]);
        }
    }
    for first in [0, (RINGS - 1) * corners] {
        triangles.extend((1..corners - 1).map(|k| [first, first + k, first + k + 1]));
    }
    let half = half.x.min(half.y);
    Hull::new(vertices, triangles).map_or(Shape::Cylinder { radius: half, half_length: half }, Shape::Hull)
}
