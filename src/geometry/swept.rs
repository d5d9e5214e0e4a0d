//! A convex shape that goes straight without turning, and the space that it passes through.

use nalgebra::Vector3;

use super::gap::distance_by_support;
use super::{Capsule, ConvexBody, PlacedShape, Precision};

/// All that a placed shape passes through on a straight way: the convex hull of its first and its last place.
#[derive(Clone, Copy, Debug)]
pub struct SweptShape<'a> {
    /// The shape where it sets out.
    pub shape: PlacedShape<'a>,
    /// Where it goes from there, metres.
    pub way: Vector3<f64>,
}

impl ConvexBody for SweptShape<'_> {
    fn support(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        let first = self.shape.support(direction);
        if self.way.dot(direction) > 0.0 { first + self.way } else { first }
    }

    fn centre(&self) -> Vector3<f64> {
        self.shape.centre() + 0.5 * self.way
    }

    fn as_capsule(&self) -> Option<Capsule> {
        let Capsule { ends, radius } = self.shape.as_capsule()?;
        match (ends[0] == ends[1], self.way == Vector3::zeros()) {
            (true, _) => Some(Capsule { ends: [ends[0], ends[0] + self.way], radius }),
            (false, true) => Some(Capsule { ends, radius }),
            (false, false) => None,
        }
    }

    fn signed_distance(&self, p: &Vector3<f64>) -> (f64, Vector3<f64>) {
        distance_by_support(self, p, Precision::Exact)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Frame, Shape, gap};

    #[test]
    fn a_box_that_goes_straight_is_as_far_as_the_nearest_of_its_places() {
        let shape = Shape::Box { half_extents: [0.1, 0.2, 0.3] };
        let origin = Vector3::new(0.0, 0.5, 0.0);
        let placed = |origin| {
            PlacedShape::new(&shape, Frame { origin, ..Frame::identity() }, Frame::identity())
                .expect("a box is solid")
        };
        let way = Vector3::new(2.0, 0.5, -0.3);
        let ball = Capsule::ball(Vector3::new(1.2, -0.4, 0.2), 0.05);
        let swept = gap(&ball, &SweptShape { shape: placed(origin), way }, Precision::Exact).distance;
        let places = (0..=2000).map(|k| placed(origin + way * (f64::from(k) / 2000.0)));
        let least =
            places.map(|place| gap(&ball, &place, Precision::Exact).distance).fold(f64::INFINITY, f64::min);
        assert!((swept - least).abs() < 1e-4, "{swept} {least}");
    }
}
