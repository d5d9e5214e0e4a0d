//! The shapes of the engine's geoms.

use super::{GeomKind, Model};
use crate::geometry::{Hull, Shape};

impl Shape {
    /// The shape of a geom, site or mark of this kind and size; none for what is no primitive solid.
    pub fn primitive(kind: GeomKind, [x, y, z]: [f64; 3]) -> Option<Shape> {
        Some(match kind {
            GeomKind::Sphere => Shape::Sphere { radius: x },
            GeomKind::Capsule => Shape::Capsule { radius: x, half_length: y },
            GeomKind::Ellipsoid => Shape::Ellipsoid { semi_axes: [x, y, z] },
            GeomKind::Cylinder => Shape::Cylinder { radius: x, half_length: y },
            GeomKind::Box => Shape::Box { half_extents: [x, y, z] },
            GeomKind::Mesh | GeomKind::Plane | GeomKind::HeightField | GeomKind::Other(_) => return None,
        })
    }

    /// Whether geoms of a kind have a shape that a limb can be made of.
    pub fn is_of_kind(kind: GeomKind) -> bool {
        kind == GeomKind::Mesh || Shape::primitive(kind, [0.0; 3]).is_some()
    }

    /// The shape of a model's geom, a mesh by its hull; none for planes and height fields, which no limb is made of.
    pub fn of_geom(model: &Model, geom: usize) -> Option<Shape> {
        let info = model.geom(geom);
        if info.kind != GeomKind::Mesh {
            return Shape::primitive(info.kind, info.size);
        }
        let hull = model.mesh_hull(geom).and_then(|(corners, faces)| Hull::new(corners, faces));
        Some(hull.map_or(Shape::Mesh, Shape::Hull))
    }
}
