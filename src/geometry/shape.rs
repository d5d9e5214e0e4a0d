//! Convex shapes, each about its own origin.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::capsule::distance_to_sphere;
use super::{Capsule, Frame, Hull};

/// A shape about its own origin, as MJCF's geoms of the same names; lengths in metres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// A ball.
    Sphere {
        /// Its radius.
        radius: f64,
    },
    /// All points within a radius of a segment of the z axis.
    Capsule {
        /// Its radius.
        radius: f64,
        /// Half the segment's length.
        half_length: f64,
    },
    /// An ellipsoid along the axes.
    Ellipsoid {
        /// Its semi-axes.
        semi_axes: [f64; 3],
    },
    /// A cylinder about z.
    Cylinder {
        /// Its radius.
        radius: f64,
        /// Half its height.
        half_length: f64,
    },
    /// A box along the axes.
    Box {
        /// Half its sides.
        half_extents: [f64; 3],
    },
    /// A mesh's convex hull, which is what MuJoCo collides.
    Hull(Hull),
    /// A shape known only by its receptors: each patch is taken for flat.
    Mesh,
}

impl Shape {
    /// The same shape with all lengths so many times as long.
    pub(crate) fn scaled(&self, by: f64) -> Shape {
        match *self {
            Shape::Sphere { radius } => Shape::Sphere { radius: by * radius },
            Shape::Capsule { radius, half_length } => {
                Shape::Capsule { radius: by * radius, half_length: by * half_length }
            }
            Shape::Cylinder { radius, half_length } => {
                Shape::Cylinder { radius: by * radius, half_length: by * half_length }
            }
            Shape::Ellipsoid { semi_axes } => Shape::Ellipsoid { semi_axes: semi_axes.map(|axis| by * axis) },
            Shape::Box { half_extents } => Shape::Box { half_extents: half_extents.map(|half| by * half) },
            Shape::Hull(ref hull) => Shape::Hull(hull.scaled(by)),
            Shape::Mesh => Shape::Mesh,
        }
    }

    /// Whether more is known of it than its receptors: of all but a mesh without a hull.
    pub fn is_solid(&self) -> bool {
        !matches!(self, Shape::Mesh)
    }

    /// Whether it is a box.
    pub fn is_box(&self) -> bool {
        matches!(self, Shape::Box { .. })
    }

    /// Its hull, where it is one.
    pub fn hull(&self) -> Option<&Hull> {
        match self {
            Shape::Hull(hull) => Some(hull),
            _ => None,
        }
    }

    /// Whether it has edges, where its normal jumps.
    pub fn has_edges(&self) -> bool {
        matches!(self, Shape::Box { .. } | Shape::Cylinder { .. } | Shape::Hull(_))
    }

    /// The shape itself as a capsule in the frame that it is placed in, where it is one or a ball.
    #[inline]
    pub fn as_capsule(&self, pose: &Frame) -> Option<Capsule> {
        let (radius, half_length) = match *self {
            Shape::Sphere { radius } => (radius, 0.0),
            Shape::Capsule { radius, half_length } => (radius, half_length),
            _ => return None,
        };
        let along: Vector3<f64> = pose.rotation.column(2) * half_length;
        Some(Capsule { ends: [pose.origin - along, pose.origin + along], radius })
    }

    /// A capsule about the shape, in its axes; none about a mesh without a hull.
    pub fn bounding_capsule(&self) -> Option<Capsule> {
        Some(match *self {
            Shape::Sphere { radius } => Capsule::along(2, 0.0, radius),
            Shape::Capsule { radius, half_length } | Shape::Cylinder { radius, half_length } => {
                Capsule::along(2, half_length, radius)
            }
            Shape::Ellipsoid { semi_axes } => {
                let half = Vector3::from(semi_axes);
                let axis = half.imax();
                let radius = (0..3).filter(|&k| k != axis).map(|k| half[k]).fold(0.0, f64::max);
                Capsule::along(axis, half[axis] - radius, radius)
            }
            Shape::Box { .. } | Shape::Hull(_) => Capsule::about_box(&self.half_bounds()),
            Shape::Mesh => return None,
        })
    }

    /// No point of the shape is farther from its origin, metres.
    pub fn bounding_radius(&self) -> f64 {
        match *self {
            Shape::Sphere { radius } => radius,
            Shape::Capsule { radius, half_length } => half_length + radius,
            _ => self.half_bounds().norm(),
        }
    }

    /// The radius of a ball inside: the largest one but for a hull's; 0 for a mesh without a hull.
    pub fn inradius(&self) -> f64 {
        match *self {
            Shape::Sphere { radius } | Shape::Capsule { radius, .. } => radius,
            Shape::Hull(ref hull) => hull.inradius(),
            _ => self.half_bounds().min(),
        }
    }

    /// Distance of a point to the surface, negative inside, and the outward unit normal of the nearest
    /// surface point, in the shape's axes; none for a mesh without a hull.
    pub fn signed_distance(&self, p: &Vector3<f64>) -> Option<(f64, Vector3<f64>)> {
        Some(match *self {
            Shape::Sphere { radius } => distance_to_sphere(p, radius),
            Shape::Hull(ref hull) => hull.signed_distance(p),
            Shape::Capsule { radius, half_length } => {
                distance_to_sphere(&(p - Vector3::z() * p.z.clamp(-half_length, half_length)), radius)
            }
            Shape::Cylinder { radius, half_length } => {
                let across = Vector3::new(p.x, p.y, 0.0);
                let outward = across.try_normalize(1e-12).unwrap_or(Vector3::x());
                let up = Vector3::z() * p.z.signum();
                blunt(&[(across.norm() - radius, outward), (p.z.abs() - half_length, up)])
            }
            Shape::Box { half_extents } => {
                let face = |k: usize| {
                    let mut normal = Vector3::zeros();
                    normal[k] = if p[k] < 0.0 { -1.0 } else { 1.0 };
                    (p[k].abs() - half_extents[k], normal)
                };
                blunt(&[face(0), face(1), face(2)])
            }
            Shape::Ellipsoid { semi_axes } => ellipsoid(p, semi_axes),
            Shape::Mesh => return None,
        })
    }

    /// Whether a point in the shape's axes is deeper inside than `depth`, metres; of a mesh without a hull it is not known, and none
    /// is.
    pub fn holds(&self, p: &Vector3<f64>, depth: f64) -> bool {
        // Of the thousand limbs that a hub may carry most are far away.
        p.norm_squared() <= self.bounding_radius().powi(2)
            && match self {
                Shape::Hull(hull) => hull.holds(p, depth),
                _ => self.signed_distance(p).is_some_and(|(distance, _)| distance < -depth),
            }
    }

    /// Its farthest point in a direction of any length, in the shape's axes; none for a mesh without a hull.
    pub fn support(&self, direction: &Vector3<f64>) -> Option<Vector3<f64>> {
        let d = direction;
        let unit = |v: Vector3<f64>| v.try_normalize(f64::MIN_POSITIVE).unwrap_or_default();
        let up = |half_length: f64| Vector3::z() * half_length.copysign(d.z);
        Some(match self {
            Shape::Sphere { radius } => unit(*d) * *radius,
            Shape::Capsule { radius, half_length } => unit(*d) * *radius + up(*half_length),
            Shape::Cylinder { radius, half_length } => {
                unit(Vector3::new(d.x, d.y, 0.0)) * *radius + up(*half_length)
            }
            Shape::Box { half_extents } => Vector3::from_fn(|k, _| half_extents[k].copysign(d[k])),
            Shape::Ellipsoid { semi_axes } => {
                let semi_axes = Vector3::from(*semi_axes);
                unit(semi_axes.component_mul(d)).component_mul(&semi_axes)
            }
            Shape::Hull(hull) => hull.support(d),
            Shape::Mesh => return None,
        })
    }

    /// The area of the whole surface, m²; 0 for a mesh without a hull.
    pub fn area(&self) -> f64 {
        use std::f64::consts::PI;
        match *self {
            Shape::Sphere { radius } => 4.0 * PI * radius * radius,
            Shape::Capsule { radius, half_length } => 4.0 * PI * radius * (radius + half_length),
            Shape::Cylinder { radius, half_length } => 2.0 * PI * radius * (radius + 2.0 * half_length),
            Shape::Box { half_extents: [a, b, c] } => 8.0 * (a * b + b * c + c * a),
            Shape::Ellipsoid { semi_axes: [a, b, c] } => {
                // Thomsen's formula, right to about one percent.
                const P: f64 = 1.6075;
                let mean = ((a * b).powf(P) + (b * c).powf(P) + (c * a).powf(P)) / 3.0;
                4.0 * PI * mean.powf(1.0 / P)
            }
            Shape::Hull(ref hull) => hull.area(),
            Shape::Mesh => 0.0,
        }
    }

    /// Half the sides of the box about the shape, along its axes, whose middle is the shape's origin.
    pub fn half_bounds(&self) -> Vector3<f64> {
        match *self {
            Shape::Sphere { radius } => Vector3::repeat(radius),
            Shape::Capsule { radius, half_length } => Vector3::new(radius, radius, radius + half_length),
            Shape::Cylinder { radius, half_length } => Vector3::new(radius, radius, half_length),
            Shape::Box { half_extents } | Shape::Ellipsoid { semi_axes: half_extents } => half_extents.into(),
            Shape::Hull(ref hull) => hull.half_bounds(),
            Shape::Mesh => Vector3::zeros(),
        }
    }
}

/// The intersection of perpendicular slabs, each given by the distance beyond it and its normal.
fn blunt(slabs: &[(f64, Vector3<f64>)]) -> (f64, Vector3<f64>) {
    let beyond: Vector3<f64> = slabs.iter().map(|(d, normal)| normal * d.max(0.0)).sum();
    let outside = beyond.norm();
    if outside > 0.0 {
        return (outside, beyond / outside);
    }
    let nearest = slabs.iter().max_by(|a, b| a.0.total_cmp(&b.0)).expect("a shape has slabs");
    *nearest
}

/// The nearest point of an ellipsoid by its Lagrange multiplier (Eberly, "Distance from a point to an ellipse, an ellipsoid, or a
/// hyperellipsoid"), as trust regions find theirs (Moré and Sorensen, "Computing a Trust Region Step", 1983).
fn ellipsoid(p: &Vector3<f64>, semi_axes: [f64; 3]) -> (f64, Vector3<f64>) {
    let e = Vector3::from(semi_axes);
    let y = p.map(|x| x.abs().max(1e-12 * e.min()));
    let weighted = e.component_mul(&y);
    // The multiplier is counted from where the least axis has its pole: near to it nothing cancels.
    let least = e.min() * e.min();
    let beyond = e.map(|e| e * e - least);
    // The squared length of e y / (t + e² − least²), and half of how fast it falls.
    let value = |t: f64| {
        (0..3).fold((0.0, 0.0), |(squared, falls), k| {
            let term = weighted[k] / (t + beyond[k]);
            (squared + term * term, falls + term * term / (t + beyond[k]))
        })
    };
    // It is to be 1. Where a single term is, it is more; from there on the inverse of the length is concave and grows, so that
    // Newton's steps come ever nearer to the root and never beyond it.
    let mut t = (weighted - beyond).max();
    for _ in 0..100 {
        let (squared, falls) = value(t);
        let next = t + squared * (squared.sqrt() - 1.0) / falls;
        if next <= t || next.is_nan() {
            break;
        }
        t = next;
    }
    let nearest = Vector3::from_fn(|k, _| (e[k] * weighted[k] / (t + beyond[k])).copysign(p[k]));
    let normal = Vector3::from_fn(|k, _| nearest[k] / (e[k] * e[k])).normalize();
    let inside = value(least).0 < 1.0;
    let distance = (p - nearest).norm();
    (if inside { -distance } else { distance }, normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPES: [Shape; 5] = [
        Shape::Sphere { radius: 0.3 },
        Shape::Capsule { radius: 0.1, half_length: 0.3 },
        Shape::Ellipsoid { semi_axes: [0.3, 0.2, 0.1] },
        Shape::Cylinder { radius: 0.2, half_length: 0.1 },
        Shape::Box { half_extents: [0.1, 0.2, 0.3] },
    ];

    /// From the nearest point of an ellipsoid to any point leads its normal, inside, outside and near its axes, however flat or long
    /// it is.
    #[test]
    fn the_nearest_point_of_an_ellipsoid_is_where_its_normal_leads_to_the_point() {
        for semi_axes in [[0.3, 0.2, 0.1], [1.0, 1e-3, 0.5], [1e-3, 1e-3, 1.0], [0.2, 0.2, 0.2]] {
            for p in [
                [0.5, 0.2, -0.4],
                [1e-9, -0.6, 0.05],
                [10.0, 20.0, -30.0],
                [1e-4, 1e-5, -2e-4],
                [0.0, 0.0, 0.7],
            ] {
                let p = Vector3::from(p);
                let (distance, normal) = ellipsoid(&p, semi_axes);
                let nearest = p - normal * distance;
                let scaled = nearest.component_div(&Vector3::from(semi_axes));
                assert!((scaled.norm() - 1.0).abs() < 1e-6, "{semi_axes:?} {p:?}: {}", scaled.norm());
                let outward = scaled.component_div(&Vector3::from(semi_axes)).normalize();
                assert!((outward - normal).norm() < 1e-6, "{semi_axes:?} {p:?}: {outward} {normal}");
            }
        }
    }

    /// Moving a point by its distance against the normal must land on the surface, and outside the
    /// distance's gradient is the normal.
    #[test]
    fn the_distance_leads_to_the_surface() {
        let points = [[0.5, 0.2, -0.4], [0.01, -0.6, 0.05], [-0.3, 0.31, 0.62], [0.02, 0.05, 0.03]];
        for shape in SHAPES {
            for p in points.map(Vector3::from) {
                let (distance, normal) = shape.signed_distance(&p).unwrap();
                assert!((normal.norm() - 1.0).abs() < 1e-12);
                let landed = shape.signed_distance(&(p - normal * distance)).unwrap().0;
                assert!(landed.abs() < 1e-9, "{shape:?} {p:?}: {landed}");
                if distance > 0.0 {
                    let step = 1e-6;
                    let moved = shape.signed_distance(&(p + normal * step)).unwrap().0;
                    assert!((moved - distance - step).abs() < 1e-9, "{shape:?} {p:?}");
                }
            }
        }
    }
}
