//! The convex hull of a mesh, with which MuJoCo detects its collisions.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::farthest::FarthestPoint;
use super::simplex::on_triangle;

/// A vertex this far beyond a triangle's plane, by the hull's size, shows that the triangle is a sliver
/// whose plane is all rounding: MuJoCo keeps vertices in single precision.
const BEYOND: f64 = 1e-5;
/// The triangles' area vectors of a closed surface add up to nothing: to this share of the area.
const OPEN: f64 = 1e-3;

/// Faces that are looked at first.
const FACES_AROUND: usize = 16;

/// A convex polyhedron with triangles for faces, in its mesh's axes; lengths in metres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Polyhedron", into = "Polyhedron")]
pub struct Hull {
    polyhedron: Polyhedron,
    /// Per triangle, its outward unit normal and how far it is from the origin along it.
    planes: Vec<(Vector3<f64>, f64)>,
    /// Half the sides of the box about the hull whose middle is the origin.
    half_bounds: Vector3<f64>,
    /// The middle of the corners, and how far it is from the surface: the radius of a ball inside.
    middle: Vector3<f64>,
    inradius: f64,
    farthest: FarthestPoint,
}

/// A hull as it is written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Polyhedron {
    vertices: Vec<Vector3<f64>>,
    triangles: Vec<[usize; 3]>,
}

impl TryFrom<Polyhedron> for Hull {
    type Error = &'static str;

    fn try_from(read: Polyhedron) -> Result<Hull, Self::Error> {
        Hull::new(read.vertices, read.triangles).ok_or("the triangles of a hull do not close a convex solid")
    }
}

impl From<Hull> for Polyhedron {
    fn from(hull: Hull) -> Polyhedron {
        hull.polyhedron
    }
}

impl Hull {
    /// The convex solid with these faces, in whatever sense each goes round; `None` if they do not close one.
    pub fn new(vertices: Vec<Vector3<f64>>, triangles: Vec<[usize; 3]>) -> Option<Hull> {
        let finite = vertices.iter().all(|v| v.iter().all(|x| x.is_finite()));
        let known = triangles.iter().flatten().all(|&v| v < vertices.len());
        if !finite || !known || vertices.len() < 4 {
            return None;
        }
        let middle = vertices.iter().sum::<Vector3<f64>>() / vertices.len() as f64;
        let size = vertices.iter().map(|v| (v - middle).norm()).fold(0.0, f64::max);
        let mut hull = Hull {
            half_bounds: vertices.iter().fold(Vector3::zeros(), |half, v| half.sup(&v.abs())),
            farthest: FarthestPoint::new(&vertices),
            polyhedron: Polyhedron { vertices, triangles: Vec::new() },
            planes: Vec::new(),
            middle,
            inradius: 0.0,
        };
        let mut sum = Vector3::zeros();
        for [i, j, k] in triangles {
            let [a, b, c] = [i, j, k].map(|v| hull.polyhedron.vertices[v]);
            let cross = (b - a).cross(&(c - a));
            let Some(normal) = cross.try_normalize(f64::MIN_POSITIVE) else { continue };
            let outward = if normal.dot(&(a - middle)) < 0.0 { -normal } else { normal };
            let offset = outward.dot(&a);
            if outward.dot(&hull.support(&outward)) - offset > BEYOND * size {
                continue;
            }
            sum += outward * (0.5 * cross.norm());
            hull.polyhedron.triangles.push(if outward == normal { [i, j, k] } else { [i, k, j] });
            hull.planes.push((outward, offset));
        }
        let deep = hull.planes.iter().map(|(normal, offset)| offset - normal.dot(&middle));
        hull.inradius = deep.fold(f64::INFINITY, f64::min).clamp(0.0, f64::MAX);
        (hull.inradius > BEYOND * size && sum.norm() <= OPEN * hull.area()).then_some(hull)
    }

    /// The same solid with all lengths so many times as long, by a power of two: to the digit.
    pub(crate) fn scaled(&self, by: f64) -> Hull {
        let vertices = self.vertices().iter().map(|v| v * by).collect();
        Hull::new(vertices, self.triangles().to_vec()).expect("a hull is one in any unit of length")
    }

    /// The corners, metres.
    pub fn vertices(&self) -> &[Vector3<f64>] {
        &self.polyhedron.vertices
    }

    /// The faces: three corners each, counterclockwise as seen from outside.
    pub fn triangles(&self) -> &[[usize; 3]] {
        &self.polyhedron.triangles
    }

    /// Per face, its corners, outward unit normal and area in m².
    pub(super) fn faces(&self) -> impl Iterator<Item = ([Vector3<f64>; 3], Vector3<f64>, f64)> {
        self.triangles().iter().zip(&self.planes).map(|(corners, plane)| {
            let [a, b, c] = corners.map(|v| self.vertices()[v]);
            ([a, b, c], plane.0, 0.5 * (b - a).cross(&(c - a)).norm())
        })
    }

    /// The corner that is farthest in a direction of any length, metres.
    pub fn support(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.farthest.along(direction)
    }

    /// The area of the surface, m².
    pub fn area(&self) -> f64 {
        self.faces().map(|(.., area)| area).sum()
    }

    /// How far the middle of the corners is from the surface: the radius of a ball inside.
    pub fn inradius(&self) -> f64 {
        self.inradius
    }

    /// Half the sides of the box about the hull whose middle is the origin.
    pub fn half_bounds(&self) -> Vector3<f64> {
        self.half_bounds
    }

    /// Whether a point is deeper inside than `depth`, metres, which is 0 at the least.
    pub fn holds(&self, p: &Vector3<f64>, depth: f64) -> bool {
        // Of most points the box about the hull tells, or the ball inside.
        if p.iter().zip(&self.half_bounds).any(|(at, half)| at.abs() > *half) {
            return false;
        }
        if (p - self.middle).norm() < (1.0 - 1e-12) * self.inradius - depth {
            return true;
        }
        // Faces that follow each other lie beside each other: a few from all around tell of most points outside.
        let around = self.planes.iter().step_by(self.planes.len() / FACES_AROUND + 1);
        around.chain(&self.planes).all(|(normal, offset)| normal.dot(p) - offset < -depth)
    }

    /// Distance of a point to the surface, negative inside, and the outward unit normal there.
    pub fn signed_distance(&self, p: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let beyond = |(normal, offset): &(Vector3<f64>, f64)| normal.dot(p) - offset;
        let (mut farthest, mut most) = (0, f64::NEG_INFINITY);
        for (k, plane) in self.planes.iter().enumerate() {
            let distance = beyond(plane);
            if distance > most {
                (farthest, most) = (k, distance);
            }
        }
        let normal = self.planes[farthest].0;
        if most <= 0.0 {
            return (most, normal);
        }
        let nearest_of =
            |k: usize| p + on_triangle(&self.triangles()[k].map(|v| self.vertices()[v] - p)).point;
        // No face is nearer than its plane, so the search starts where the plane is farthest: mostly it ends
        // there as well.
        let mut nearest = nearest_of(farthest);
        let mut least = (p - nearest).norm();
        for (k, plane) in self.planes.iter().enumerate() {
            let bound = beyond(plane);
            if bound > 0.0 && bound < least && least > most * (1.0 + 1e-12) {
                let found = nearest_of(k);
                let distance = (p - found).norm();
                if distance < least {
                    (nearest, least) = (found, distance);
                }
            }
        }
        (least, (p - nearest).try_normalize(1e-12).unwrap_or(normal))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Shape;

    /// A box's corners and its faces, each face as two triangles that go round as they happen to.
    fn boxed(half: [f64; 3]) -> Hull {
        let sign = |bit: usize| if bit == 0 { -1.0 } else { 1.0 };
        let corner = |v: usize| Vector3::from_fn(|k, _| half[k] * sign(v >> k & 1));
        let face = |axis: usize, side: usize| {
            let [u, v] = [(axis + 1) % 3, (axis + 2) % 3].map(|k| 1 << k);
            let base = side << axis;
            [[base, base + u, base + v], [base + u, base + v, base + u + v]]
        };
        let triangles = (0..6).flat_map(|f| face(f / 2, f % 2)).collect();
        Hull::new((0..8).map(corner).collect(), triangles).unwrap()
    }

    #[test]
    fn the_hull_of_a_box_is_the_box() {
        let half = [0.1, 0.2, 0.3];
        let (hull, shape) = (boxed(half), Shape::Box { half_extents: half });
        assert!((hull.area() - shape.area()).abs() < 1e-12);
        assert_eq!((hull.half_bounds(), hull.inradius()), (shape.half_bounds(), 0.1));
        for k in 0..2000 {
            let turn = |step: f64| (k as f64 * step).fract() - 0.5;
            let p = Vector3::new(turn(0.618_034), turn(0.414_214), turn(0.732_051));
            let ((found, n), (expected, m)) = (hull.signed_distance(&p), shape.signed_distance(&p).unwrap());
            assert!((found - expected).abs() < 1e-12, "{p:?}: {found} for {expected}");
            assert!((n - m).norm() < 1e-9 || expected < 0.0, "{p:?}: {n} for {m}");
            assert!([0.0, 0.03].iter().all(|&depth| hull.holds(&p, depth) == (found < -depth)), "{p:?}");
        }
    }

    #[test]
    fn what_closes_no_solid_is_no_hull() {
        let hull = boxed([0.1; 3]);
        let (vertices, triangles) = (hull.vertices().to_vec(), hull.triangles().to_vec());
        assert!(Hull::new(vertices.clone(), triangles[1..].to_vec()).is_none(), "one face is missing");
        assert!(Hull::new(vertices.clone(), vec![[0, 1, 99]]).is_none(), "there is no such corner");
        let flat = vertices.iter().map(|v| Vector3::new(v.x, v.y, 0.0)).collect();
        assert!(Hull::new(flat, triangles.clone()).is_none(), "it is flat");
        let text = serde_json::to_string(&hull).unwrap();
        assert_eq!(serde_json::from_str::<Hull>(&text).unwrap(), hull);
        assert!(serde_json::from_str::<Hull>(&text.replace("[0,", "[99,")).is_err());
    }
}
