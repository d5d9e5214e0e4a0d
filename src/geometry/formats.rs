//! Shapes as the formats describe them: MJCF's geoms, URDF's geometries.

use super::Shape;

/// A part of a shape as URDF describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct UrdfGeometry {
    /// The element's name: `sphere`, `cylinder`, `box`, or `mesh` for a unit sphere that is scaled.
    pub element: &'static str,
    /// Its attributes, metres; a scale has no unit.
    pub attributes: Vec<(&'static str, Vec<f64>)>,
    /// How far along the shape's z axis the part is from the shape's origin, metres.
    pub height: f64,
}

impl Shape {
    /// MJCF's geom type and sizes, metres; no sizes for a hull, which is a `mesh`, and none at all for what is known
    /// only by its receptors.
    pub fn mjcf(&self) -> Option<(&'static str, Vec<f64>)> {
        Some(match *self {
            Shape::Sphere { radius } => ("sphere", vec![radius]),
            Shape::Capsule { radius, half_length } => ("capsule", vec![radius, half_length]),
            Shape::Ellipsoid { semi_axes } => ("ellipsoid", semi_axes.to_vec()),
            Shape::Cylinder { radius, half_length } => ("cylinder", vec![radius, half_length]),
            Shape::Box { half_extents } => ("box", half_extents.to_vec()),
            Shape::Hull(_) => ("mesh", Vec::new()),
            Shape::Mesh => return None,
        })
    }

    /// The shape in parts that URDF has: it has no capsule, which is a cylinder between two spheres, and no ellipsoid,
    /// which is the mesh of a unit sphere, scaled. None for a mesh, with a hull or without.
    pub fn urdf(&self) -> Option<Vec<UrdfGeometry>> {
        let at = |height: f64, element, attributes| UrdfGeometry { element, attributes, height };
        let sphere = |height: f64, radius: f64| at(height, "sphere", vec![("radius", vec![radius])]);
        let cylinder = |radius: f64, half_length: f64| {
            at(0.0, "cylinder", vec![("radius", vec![radius]), ("length", vec![2.0 * half_length])])
        };
        Some(match *self {
            Shape::Sphere { radius } => vec![sphere(0.0, radius)],
            Shape::Cylinder { radius, half_length } => vec![cylinder(radius, half_length)],
            Shape::Capsule { radius, half_length } => {
                vec![cylinder(radius, half_length), sphere(half_length, radius), sphere(-half_length, radius)]
            }
            Shape::Box { half_extents } => {
                vec![at(0.0, "box", vec![("size", half_extents.map(|x| 2.0 * x).to_vec())])]
            }
            Shape::Ellipsoid { semi_axes } => vec![at(0.0, "mesh", vec![("scale", semi_axes.to_vec())])],
            Shape::Hull(_) | Shape::Mesh => return None,
        })
    }
}
