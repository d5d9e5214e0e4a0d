//! Points of the difference of two bodies, and which point of a simplex of them is nearest to the origin.

use nalgebra::Vector3;

/// A tetrahedron less high than this is flat, metres.
const FLAT: f64 = 1e-12;

/// A point of the difference of two bodies, first less second, and the points of both that it is made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub difference: Vector3<f64>,
    pub points: [Vector3<f64>; 2],
}

/// One to four corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct Simplex {
    corners: [Corner; 4],
    count: usize,
}

/// A point of a simplex, and how it is made of the corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct SimplexPoint {
    pub point: Vector3<f64>,
    /// Positive for the corners of the face that it is on, 0 for others.
    pub weights: [f64; 4],
}

impl Simplex {
    pub fn new(corner: Corner) -> Simplex {
        Simplex { corners: [corner; 4], count: 1 }
    }

    pub fn corners(&self) -> &[Corner] {
        &self.corners[..self.count]
    }

    /// The same with one more corner, of three at the most before.
    #[inline]
    pub fn with(mut self, corner: Corner) -> Simplex {
        self.corners[self.count] = corner;
        self.count += 1;
        self
    }

    /// The face that a point is on: the corners with a weight, and their weights.
    pub fn face_of(&self, found: &SimplexPoint) -> (Simplex, [f64; 4]) {
        let (mut face, mut weights) = (Simplex { count: 0, ..*self }, [0.0; 4]);
        for (corner, &weight) in
            self.corners().iter().zip(&found.weights).filter(|(_, weight)| **weight > 0.0)
        {
            face.corners[face.count] = *corner;
            weights[face.count] = weight;
            face.count += 1;
        }
        (face, weights)
    }

    /// The point nearest to the origin; all four corners have a weight where the origin is inside.
    pub fn nearest_to_origin(&self) -> SimplexPoint {
        let [a, b, c, d] = self.corners.map(|corner| corner.difference);
        match self.count {
            2 => on_segment(&a, &b),
            3 => on_triangle(&[a, b, c]),
            4 => in_tetrahedron(&[a, b, c, d]),
            _ => SimplexPoint { point: a, weights: [1.0, 0.0, 0.0, 0.0] },
        }
    }
}

impl SimplexPoint {
    /// The same with the first corners numbered as in a larger simplex.
    fn among<const N: usize>(self, numbers: [usize; N]) -> SimplexPoint {
        let mut weights = [0.0; 4];
        numbers.iter().zip(self.weights).for_each(|(&number, weight)| weights[number] = weight);
        SimplexPoint { point: self.point, weights }
    }
}

/// The points of both bodies that corners with these weights are made of.
pub(super) fn witnesses(corners: &[Corner], weights: &[f64]) -> [Vector3<f64>; 2] {
    [0, 1].map(|k| corners.iter().zip(weights).map(|(corner, weight)| corner.points[k] * *weight).sum())
}

fn nearer(x: &SimplexPoint, y: &SimplexPoint) -> std::cmp::Ordering {
    x.point.norm_squared().total_cmp(&y.point.norm_squared())
}

fn on_segment(a: &Vector3<f64>, b: &Vector3<f64>) -> SimplexPoint {
    let along = b - a;
    let share = -a.dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
    if share <= 0.0 {
        SimplexPoint { point: *a, weights: [1.0, 0.0, 0.0, 0.0] }
    } else if share >= 1.0 {
        SimplexPoint { point: *b, weights: [0.0, 1.0, 0.0, 0.0] }
    } else {
        SimplexPoint { point: a + along * share, weights: [1.0 - share, share, 0.0, 0.0] }
    }
}

/// By the triangle's plane where the origin is above its inside, or else by its nearest side.
pub(super) fn on_triangle(corners: &[Vector3<f64>; 3]) -> SimplexPoint {
    let [a, b, c] = corners;
    let normal = (b - a).cross(&(c - a));
    // Twice the signed area between a side and the origin, by the length of the normal.
    let area = |p: &Vector3<f64>, q: &Vector3<f64>| (q - p).cross(&-p).dot(&normal);
    let areas = [area(b, c), area(c, a), area(a, b)];
    if normal.norm_squared() > 0.0 && areas.iter().all(|&area| area >= 0.0) {
        let point = normal * (normal.dot(a) / normal.norm_squared());
        let total: f64 = areas.iter().sum();
        // A corner whose side the origin is above keeps a trace of weight: the triangle is the face.
        let [u, v, w] = areas.map(|area| (area / total).max(f64::MIN_POSITIVE));
        return SimplexPoint { point, weights: [u, v, w, 0.0] };
    }
    let sides = [[0, 1], [1, 2], [2, 0]];
    let found = sides.map(|side| on_segment(&corners[side[0]], &corners[side[1]]).among(side));
    found.into_iter().min_by(nearer).expect("a triangle has sides")
}

fn in_tetrahedron(corners: &[Vector3<f64>; 4]) -> SimplexPoint {
    let faces = [([0, 1, 2], 3), ([0, 1, 3], 2), ([0, 2, 3], 1), ([1, 2, 3], 0)];
    let inside = faces.iter().all(|(face, opposite)| {
        let [p, q, r] = face.map(|k| corners[k]);
        let normal = (q - p).cross(&(r - p));
        // A flat tetrahedron has no inside.
        let height = normal.dot(&(corners[*opposite] - p));
        normal.dot(&-p) * height > 0.0 && height.abs() > FLAT * normal.norm()
    });
    if inside {
        return SimplexPoint { point: Vector3::zeros(), weights: [0.25; 4] };
    }
    // Of a sliver rounding cannot tell the faces towards the origin from the others.
    let found = faces.map(|(face, _)| on_triangle(&face.map(|k| corners[k])).among(face));
    found.into_iter().min_by(nearer).expect("a tetrahedron has faces")
}
