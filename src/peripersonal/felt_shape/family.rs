//! A family of convex bodies with few numbers, near to most things that hands are made for: a rounded frustum.

use nalgebra::{Rotation3, SVector, Vector3};

use crate::geometry::{ConvexBody, Precision, distance_by_support};

/// How many numbers there are.
pub(super) const NUMBERS: usize = 17;

/// The numbers, unbounded each: middle (3), rotation vector (3), logarithms of the half axes along x and y and of half the
/// height, logarithms of by how much the top is wider than the middle along x and y, how far the top is aside of the middle
/// along x and y, squareness, and the logarithms of the half axes of rounding. Lengths in metres.
pub(super) type Numbers = SVector<f64, NUMBERS>;

/// The convex hull of two parallel discs `|x/a|^p + |y/b|^p ≤ 1`, of different size and one aside of the other, rounded by
/// an ellipsoid (their Minkowski sum): boxes, cylinders, cones, balls, capsules, ellipsoids, bottles, and what is between.
///
/// Its support function is the sum of the discs', whose norms are dual (`1/p + 1/q = 1`), and of the ellipsoid's.
#[derive(Clone, Debug)]
pub(super) struct RoundedFrustum {
    middle: Vector3<f64>,
    turn: Rotation3<f64>,
    /// Half axes in the middle.
    half: [f64; 2],
    half_height: f64,
    /// By how much the top is wider.
    widening: [f64; 2],
    aside: [f64; 2],
    /// The exponent of the dual norm: 1 for rectangles, 2 for ellipses.
    dual: f64,
    /// Half axes of the ellipsoid.
    rounding: Vector3<f64>,
}

impl RoundedFrustum {
    /// The body with these numbers.
    pub fn of(numbers: &Numbers) -> RoundedFrustum {
        let n = numbers;
        RoundedFrustum {
            middle: Vector3::new(n[0], n[1], n[2]),
            turn: Rotation3::new(Vector3::new(n[3], n[4], n[5])),
            half: [n[6].exp(), n[7].exp()],
            half_height: n[8].exp(),
            widening: [n[9].exp(), n[10].exp()],
            aside: [n[11], n[12]],
            dual: 1.0 + 1.0 / (1.0 + (-n[13]).exp()),
            rounding: Vector3::new(n[14].exp(), n[15].exp(), n[16].exp()),
        }
    }

    /// The support point in its own axes, and the support function's value there without the middle.
    fn local(&self, n: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let mut best = (f64::NEG_INFINITY, Vector3::zeros());
        for sign in [1.0, -1.0] {
            let half = [0, 1]
                .map(|k| self.half[k] * if sign > 0.0 { self.widening[k] } else { 1.0 / self.widening[k] });
            let scaled = [half[0] * n.x, half[1] * n.y];
            let powers = scaled.map(|x| x.abs().powf(self.dual));
            let norm = (powers[0] + powers[1]).powf(1.0 / self.dual);
            let point = [0, 1].map(|k| {
                let along = if norm > 0.0 { (scaled[k].abs() / norm).powf(self.dual - 1.0) } else { 0.0 };
                half[k] * along * scaled[k].signum() + sign * self.aside[k]
            });
            let point = Vector3::new(point[0], point[1], sign * self.half_height);
            let value = norm + sign * (self.half_height * n.z + self.aside[0] * n.x + self.aside[1] * n.y);
            if value > best.0 {
                best = (value, point);
            }
        }
        let scaled = self.rounding.component_mul(n);
        let length = scaled.norm();
        let round =
            if length > 0.0 { self.rounding.component_mul(&scaled) / length } else { Vector3::zeros() };
        (best.0 + length, best.1 + round)
    }

    /// The support function: how far it extends along a unit direction, from the origin, metres.
    pub fn extent(&self, direction: &Vector3<f64>) -> f64 {
        self.middle.dot(direction) + self.local(&(self.turn.inverse() * direction)).0
    }
}

impl ConvexBody for RoundedFrustum {
    fn support(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.middle + self.turn * self.local(&(self.turn.inverse() * direction)).1
    }

    fn centre(&self) -> Vector3<f64> {
        self.middle
    }

    fn signed_distance(&self, p: &Vector3<f64>) -> (f64, Vector3<f64>) {
        distance_by_support(self, p, Precision::Exact)
    }
}
