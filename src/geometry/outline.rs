//! Convex solids known only by their extents, for drawing.

use nalgebra::Vector3;

use super::Shape;
use super::farthest::FarthestPoint;

/// A convex solid about its own origin, metres.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexOutline(Reach);

#[derive(Clone, Debug, PartialEq)]
enum Reach {
    Shape(Shape),
    Points(FarthestPoint),
}

impl ConvexOutline {
    /// A shape; none of a mesh without a hull.
    pub fn of(shape: Shape) -> Option<ConvexOutline> {
        shape.is_solid().then_some(ConvexOutline(Reach::Shape(shape)))
    }

    /// The convex solid about some points; `None` if there are none.
    pub fn about(points: &[Vector3<f64>]) -> Option<ConvexOutline> {
        (!points.is_empty()).then(|| ConvexOutline(Reach::Points(FarthestPoint::new(points))))
    }

    /// Its farthest point in a direction of any length.
    pub fn support(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        match &self.0 {
            Reach::Shape(shape) => shape.support(direction).unwrap_or_default(),
            Reach::Points(points) => points.along(direction),
        }
    }

    /// Whether it is a shape, and no mesh known by its points alone.
    pub fn is_shape(&self) -> bool {
        matches!(&self.0, Reach::Shape(shape) if shape.hull().is_none())
    }

    /// Whether it is a box.
    pub fn is_box(&self) -> bool {
        matches!(&self.0, Reach::Shape(shape) if shape.is_box())
    }
}
