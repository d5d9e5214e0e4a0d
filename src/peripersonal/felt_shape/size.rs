//! The size of a thing from its estimated shape: height, and length and breadth seen from above.

use nalgebra::{Vector2, Vector3};

use super::ShapeEstimate;
use crate::geometry::tangent_basis;

/// Level directions among which a thing's breadth is looked for.
const HEADINGS: usize = 36;
/// What is left of the deviation of before where touches tell how far a thing reaches: with normals within half a radian.
const FELT: f64 = 0.8;

/// A length, and how surely it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeltLength {
    /// Metres.
    pub length: f64,
    /// One standard deviation, metres.
    pub deviation: f64,
}

/// How large a thing is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeltSize {
    /// Along `up`; from what it stands on, where it stands.
    pub height: FeltLength,
    /// Across its breadth, level.
    pub length: FeltLength,
    /// The least of its level widths.
    pub breadth: FeltLength,
}

impl ShapeEstimate {
    /// How large it is; `up` is a unit direction in the root's frame.
    pub fn size(&self, up: &Vector3<f64>) -> FeltSize {
        let level = tangent_basis(up);
        let heading = |k: usize| {
            let (sin, cos) = (std::f64::consts::PI * k as f64 / HEADINGS as f64).sin_cos();
            level * Vector2::new(cos, sin)
        };
        let narrower = |a: &Vector3<f64>, b: &Vector3<f64>| self.width(a).total_cmp(&self.width(b));
        let narrow = (0..HEADINGS).map(heading).min_by(narrower).expect("there are headings");
        let level = |direction: &Vector3<f64>| FeltLength {
            length: self.width(direction),
            deviation: self.doubt(direction).hypot(self.doubt(&-direction)),
        };
        let height = match &self.stands {
            Some((_, far)) => FeltLength { length: self.extent(up) + far, deviation: self.doubt(up) },
            None => level(up),
        };
        FeltSize { height, length: level(&up.cross(&narrow)), breadth: level(&narrow) }
    }

    /// Whether touches tell how far it reaches along a unit direction, or only what things are usually like.
    pub fn is_felt_along(&self, direction: &Vector3<f64>) -> bool {
        self.doubt(direction) < FELT * self.body.before()
    }
}
