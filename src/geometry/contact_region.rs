//! All the places at which two convex bodies that touch may be felt to touch.
//!
//! The closest points of two bodies are one pair of many where an edge lies on a face, or a face on a face: which one is
//! found is chance. The region is what both contact faces have in common. A contact face is made of the farthest points in
//! directions a little beside the normal; of two of them, polygons in the plane between the bodies, the common part is a
//! list of half-planes.

use nalgebra::{Matrix3x2, Vector2, Vector3};

use super::frame::tangent_basis;
use super::gap::{ConvexBody, Gap};

/// How far beside the normal the directions are, radians: corners that are farther from the other body than this many times
/// the face's size are no part of the contact.
const BESIDE: f64 = 1e-4;
/// Directions about the normal in which a contact face is looked at.
const DIRECTIONS: usize = 12;
/// No region is larger, metres.
const LARGEST: f64 = 1e3;

/// Where two convex bodies touch: a convex part of the plane between them.
#[derive(Clone, Debug)]
pub struct ContactRegion {
    middle: Vector3<f64>,
    plane: Matrix3x2<f64>,
    corners: Vec<Vector2<f64>>,
}

impl ContactRegion {
    /// The region in which bodies touch that are a small gap apart; `slack` is what it is widened by, metres.
    pub fn new(a: &impl ConvexBody, b: &impl ConvexBody, gap: &Gap, slack: f64) -> ContactRegion {
        let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let mut region = ContactRegion {
            middle: gap.middle(),
            plane: tangent_basis(&gap.normal),
            corners: square.map(|corner| Vector2::from(corner) * LARGEST).to_vec(),
        };
        region.cut_to_face(a, &-gap.normal, slack);
        region.cut_to_face(b, &gap.normal, slack);
        region
    }

    /// Leaves of it what is on a body's contact face, to which a normal out of the body points.
    fn cut_to_face(&mut self, body: &impl ConvexBody, outward: &Vector3<f64>, slack: f64) {
        let along = |turn: usize| {
            let angle = std::f64::consts::TAU * turn as f64 / DIRECTIONS as f64;
            Vector2::new(angle.cos(), angle.sin())
        };
        let corner = |turn: usize| {
            let point = body.support(&(outward + self.plane * along(turn) * BESIDE));
            self.plane.tr_mul(&(point - self.middle))
        };
        let corners: Vec<Vector2<f64>> = (0..DIRECTIONS).map(corner).collect();
        // Along its longest diagonal and across it as well: an edge is thin in no other direction.
        let diagonals = corners.iter().flat_map(|from| corners.iter().map(move |to| to - from));
        let longest = diagonals.max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
        let longest = longest.and_then(|diagonal| diagonal.try_normalize(1e-9)).unwrap_or_else(Vector2::x);
        let across = Vector2::new(-longest.y, longest.x);
        let directions = (0..DIRECTIONS).map(along).chain([longest, -longest, across, -across]);
        for direction in directions.collect::<Vec<_>>() {
            let most = corners.iter().map(|corner| direction.dot(corner)).fold(f64::NEG_INFINITY, f64::max);
            self.cut_in_plane(&direction, most + slack);
        }
    }

    /// Leaves of it the points `p` for which `direction · (p − p₀)`, with any `p₀` given, is at most so much, metres.
    pub fn cut(&mut self, direction: &Vector3<f64>, from: &Vector3<f64>, most: f64) {
        let most = most - direction.dot(&(self.middle - from));
        self.cut_in_plane(&self.plane.tr_mul(direction), most);
    }

    /// Whether nothing is left of it.
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// Cuts the polygon by a half-plane (Sutherland and Hodgman, "Reentrant Polygon Clipping", 1974).
    fn cut_in_plane(&mut self, direction: &Vector2<f64>, most: f64) {
        let beyond = |corner: &Vector2<f64>| direction.dot(corner) - most;
        let mut left = Vec::with_capacity(self.corners.len() + 1);
        for (k, corner) in self.corners.iter().enumerate() {
            let next = &self.corners[(k + 1) % self.corners.len()];
            let (here, there) = (beyond(corner), beyond(next));
            if here <= 0.0 {
                left.push(*corner);
            }
            if (here <= 0.0) != (there <= 0.0) {
                left.push(corner + (next - corner) * (here / (here - there)));
            }
        }
        self.corners = left;
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;

    use super::*;
    use crate::geometry::{Frame, PlacedShape, Precision, Shape, gap_from};

    /// Whether a box on a plate may touch it within a centimetre of a place, metres in the plate's frame.
    fn reaches(turn: Rotation3<f64>, height: f64, [x, y]: [f64; 2]) -> bool {
        let plate = Shape::Box { half_extents: [1.0, 1.0, 0.1] };
        let block = Shape::Box { half_extents: [0.2, 0.1, 0.1] };
        let on = Frame { rotation: *turn.matrix(), origin: Vector3::new(0.3, 0.0, 0.1 + height) };
        let placed = |shape, at| PlacedShape::new(shape, at, Frame::identity()).unwrap();
        let (plate, block) = (placed(&plate, Frame::identity()), placed(&block, on));
        let gap = gap_from(&block, &plate, Precision::Exact, &Vector3::z());
        assert!(gap.distance.abs() < 1e-9 && gap.normal.z > 0.999_999, "{gap:?}");
        let mut region = ContactRegion::new(&block, &plate, &gap, 1e-3);
        let place = Vector3::new(x, y, 0.1);
        for direction in [Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y()] {
            region.cut(&direction, &place, 0.01);
        }
        !region.is_empty()
    }

    #[test]
    fn a_face_on_a_face_touches_in_every_place_that_both_have() {
        let flat = Rotation3::identity();
        for place in [[0.3, 0.0], [0.49, 0.09], [0.11, -0.09]] {
            assert!(reaches(flat, 0.1, place), "{place:?}");
        }
        for place in [[0.52, 0.0], [0.3, 0.12], [-0.3, 0.0]] {
            assert!(!reaches(flat, 0.1, place), "{place:?}");
        }
    }

    #[test]
    fn an_edge_on_a_face_touches_along_the_edge() {
        // About its long side by 30°, and that side aslant.
        let edge = Rotation3::from_axis_angle(&Vector3::z_axis(), 0.4)
            * Rotation3::from_axis_angle(&Vector3::x_axis(), 0.5);
        let height = 0.1 * 0.5f64.cos() + 0.1 * 0.5f64.sin();
        let below = Vector3::new(0.3, 0.0, 0.0) + edge * Vector3::new(0.0, -0.1, -0.1);
        let along = edge * Vector3::x();
        for share in [-0.19, 0.0, 0.19] {
            let place = below + along * share;
            assert!(reaches(edge, height, [place.x, place.y]), "{share}");
        }
        for share in [-0.22, 0.22] {
            let place = below + along * share;
            assert!(!reaches(edge, height, [place.x, place.y]), "{share}");
        }
        let beside = below + Vector3::z().cross(&along) * 0.03;
        assert!(!reaches(edge, height, [beside.x, beside.y]));
    }
}
