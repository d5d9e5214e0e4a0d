//! Points spread evenly over a shape's surface.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;
use rand::{Rng, RngExt};

use super::Shape;

/// A point of a surface and the outward unit normal there.
pub type SurfaceSample = (Vector3<f64>, Vector3<f64>);

/// Candidates per sample: thinning leaves those that keep their distance.
const CANDIDATES: usize = 12;
/// How far apart samples stay, in units of the side of the square that one stands for. Points taken at random
/// as long as they keep a distance d fill about 0.7 per d².
const APART: f64 = 0.7;
/// Irrational steps of Roberts' R3 sequence, which fills a cube evenly: powers of the root of x⁴ = x + 1.
const STEPS: [f64; 3] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_2];

impl Shape {
    /// Samples spread over the surface, about one per `spacing` m², in the shape's axes; none of a shape that only
    /// its receptors tell of.
    pub fn samples(&self, spacing: f64) -> Vec<SurfaceSample> {
        let count = ((self.area() / spacing).ceil() as usize).max(24);
        match *self {
            Shape::Sphere { radius } => directions(count).map(|normal| (normal * radius, normal)).collect(),
            Shape::Capsule { radius, half_length } => {
                // Archimedes: a sphere's area is spread evenly along z, and so is a cylinder's.
                let height = 2.0 * (radius + half_length);
                let point = |k: usize| {
                    let z = height * ((k as f64 + 0.5) / count as f64 - 0.5);
                    let core = z.clamp(-half_length, half_length);
                    let up = (z - core) / radius;
                    let ring = (1.0 - up * up).max(0.0).sqrt();
                    let angle = golden() * k as f64;
                    let normal = Vector3::new(ring * angle.cos(), ring * angle.sin(), up);
                    (normal * radius + Vector3::z() * core, normal)
                };
                (0..count).map(point).collect()
            }
            Shape::Mesh => Vec::new(),
            _ => {
                let point = parametrised(self);
                let candidates = (0..CANDIDATES * count).filter_map(|k| {
                    let along = |step: f64| (0.5 + step * k as f64).fract();
                    point(STEPS.map(along))
                });
                thinned(candidates, APART * (self.area() / count as f64).sqrt())
            }
        }
    }
}

/// The angle from a point of a spiral over a sphere to the next, of which no fraction comes near a whole turn, radians.
fn golden() -> f64 {
    PI * (3.0 - 5f64.sqrt())
}

/// Unit vectors spread evenly over the sphere, along a spiral of golden angles.
pub fn directions(count: usize) -> impl Iterator<Item = Vector3<f64>> {
    (0..count).map(move |k| {
        let z = 1.0 - (2 * k + 1) as f64 / count as f64;
        let (sin, cos) = (golden() * k as f64).sin_cos();
        let ring = (1.0 - z * z).sqrt();
        Vector3::new(ring * cos, ring * sin, z)
    })
}

/// A direction drawn uniformly from the sphere.
pub fn random_direction(rng: &mut impl Rng) -> Vector3<f64> {
    loop {
        let v = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
        let squared: f64 = v.norm_squared();
        if squared > 1e-4 && squared < 1.0 {
            return v / squared.sqrt();
        }
    }
}

/// A surface over the unit cube: evenly spread numbers from 0 to 1 give evenly spread points, or `None` if the area there is too
/// small to have one.
type Parametrisation = Box<dyn Fn([f64; 3]) -> Option<SurfaceSample>>;

/// A flat face: a corner and the two sides from there, the normal, and its area.
type Face = ([Vector3<f64>; 3], Vector3<f64>, f64);

/// The surface of a shape with edges, or of an ellipsoid.
fn parametrised(shape: &Shape) -> Parametrisation {
    match shape {
        Shape::Box { half_extents } => {
            let face = |axis: usize, sign: f64| {
                let along = |k: usize| Vector3::ith(k % 3, half_extents[k % 3]);
                let [u, v] = [along(axis + 1), along(axis + 2)];
                let corner = along(axis) * sign - u - v;
                ([corner, 2.0 * u, 2.0 * v], Vector3::ith(axis, sign), 4.0 * u.norm() * v.norm())
            };
            over_faces([0, 1, 2].into_iter().flat_map(|k| [face(k, 1.0), face(k, -1.0)]).collect(), false)
        }
        Shape::Hull(hull) => {
            let face = |([a, b, c], normal, area): Face| ([a, b - a, c - a], normal, area);
            over_faces(hull.faces().map(face).collect(), true)
        }
        &Shape::Cylinder { radius, half_length } => {
            let side = 2.0 * half_length / (2.0 * half_length + radius);
            Box::new(move |[s, t, w]| {
                let across = Vector3::new((TAU * s).cos(), (TAU * s).sin(), 0.0);
                Some(if w < side {
                    (across * radius + Vector3::z() * (half_length * (2.0 * t - 1.0)), across)
                } else {
                    let up = Vector3::z() * if w < 0.5 * (1.0 + side) { 1.0 } else { -1.0 };
                    (across * (radius * t.sqrt()) + up * half_length, up)
                })
            })
        }
        other => {
            let semi_axes = other.half_bounds();
            // The most area by area of the unit sphere.
            let most = semi_axes.product() / semi_axes.min();
            Box::new(move |[s, t, w]| {
                let z = 2.0 * s - 1.0;
                let ring = (1.0 - z * z).sqrt();
                let unit = Vector3::new(ring * (TAU * t).cos(), ring * (TAU * t).sin(), z);
                let gradient = unit.component_div(&semi_axes);
                let stretch = semi_axes.product() * gradient.norm();
                (w * most <= stretch).then(|| (unit.component_mul(&semi_axes), gradient.normalize()))
            })
        }
    }
}

/// Faces one after the other, each over its share of the area; triangles take the half of the parallelogram that is nearer to the
/// corner.
fn over_faces(mut faces: Vec<Face>, triangles: bool) -> Parametrisation {
    let total: f64 = faces.iter().map(|face| face.2).sum();
    let mut sum = 0.0;
    for face in &mut faces {
        sum += face.2 / total;
        face.2 = sum;
    }
    Box::new(move |[s, t, w]| {
        let k = faces.partition_point(|face| face.2 <= w).min(faces.len() - 1);
        let ([corner, u, v], normal, _) = faces[k];
        let (s, t) = if triangles && s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
        Some((corner + u * s + v * t, normal))
    })
}

/// The candidates that keep `apart` from all kept before them.
fn thinned(candidates: impl Iterator<Item = SurfaceSample>, apart: f64) -> Vec<SurfaceSample> {
    let mut kept: Vec<SurfaceSample> = Vec::new();
    let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    // What is near is most likely in the same cell.
    let mut around: Vec<[i64; 3]> = (0..27).map(|k| [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1]).collect();
    around.sort_by_key(|offset| offset.iter().map(|x| x * x).sum::<i64>());
    for (point, normal) in candidates {
        let cell: [i64; 3] = (point / apart).map(|x| x.floor() as i64).into();
        let mut near =
            around.iter().filter_map(|offset| cells.get(&[0, 1, 2].map(|k| cell[k] + offset[k]))).flatten();
        if near.all(|&other| (kept[other].0 - point).norm() >= apart) {
            cells.entry(cell).or_default().push(kept.len());
            kept.push((point, normal));
        }
    }
    kept
}
