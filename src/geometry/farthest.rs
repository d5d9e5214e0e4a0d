//! Which of many points is the farthest in a direction: what support mappings of polyhedra ask.
//!
//! A direction meets a cube about the origin in a place. The faces of the cube are quartered until each cell has few points
//! that are the farthest of all in a direction through it: these are looked at one by one. So the answer is exact whatever rounding
//! has made of a convex polyhedron's edges, along which others would climb, and takes hardly longer of more points.
//!
//! The directions through a cell are sums of those through its corners, none of them taken less than nought times. What reaches
//! less far than some other point in all four of these is therefore nowhere the farthest.

use std::collections::VecDeque;

use nalgebra::Vector3;

/// So few points of a cell are looked at one by one.
const FEW: usize = 12;
/// How often a face of the cube is quartered at the most: as many points as a flat side has are equally far along its normal,
/// however small the cell about it.
const DEEPEST: usize = 10;
/// Cells at the most, for each point: where many points are all but one, no cell has few of them.
const CELLS: usize = 4;
/// What rounding does to how far a point reaches, by the points' size.
const ROUNDING: f64 = 1e-12;

/// Points, by the directions in which they are the farthest.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FarthestPoint {
    /// Those of the cells that are not quartered, cell by cell.
    points: Vec<Vector3<f64>>,
    /// The faces of the cube and, after them, their quarters.
    cells: Vec<Cell>,
}

/// Directions through a part of a cube's face.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Cell {
    /// Four cells, by the number of the first.
    Quartered(usize),
    /// Points, from the first to before the last.
    Points([usize; 2]),
}

/// Where a cell is on the cube.
#[derive(Clone, Copy)]
struct Square {
    /// The coordinate in which the cube's face is at 1 or -1, and this.
    axis: usize,
    side: f64,
    /// The middle in the next two coordinates, and half a side.
    middle: [f64; 2],
    half: f64,
    /// How often the face was quartered.
    depth: usize,
}

impl Square {
    /// The directions through its corners.
    fn corners(&self) -> [Vector3<f64>; 4] {
        [0, 1, 2, 3].map(|quarter| {
            let corner = self.quarter(quarter, 1.0);
            let mut direction = Vector3::zeros();
            direction[self.axis] = self.side;
            (0..2).for_each(|k| direction[(self.axis + 1 + k) % 3] = corner.middle[k]);
            direction
        })
    }

    /// Those of some points that may be the farthest of all in a direction through it.
    fn farthest_of(&self, points: &[Vector3<f64>], slack: f64) -> Vec<Vector3<f64>> {
        let corners = self.corners();
        let middle: Vector3<f64> = corners.iter().sum();
        let farthest = |direction: &Vector3<f64>| {
            points.iter().max_by(|a, b| direction.dot(a).total_cmp(&direction.dot(b)))
        };
        let far: Vec<&Vector3<f64>> = corners.iter().chain([&middle]).filter_map(farthest).collect();
        let is_beyond = |far: &Vector3<f64>, point: &Vector3<f64>| {
            let between = far - point;
            corners.iter().all(|corner| corner.dot(&between) > slack)
        };
        points.iter().filter(|point| !far.iter().any(|far| is_beyond(far, point))).copied().collect()
    }

    /// A quarter, whose middle is by so much of half a side off this one's in both coordinates.
    fn quarter(&self, quarter: usize, off: f64) -> Square {
        let sign = |bit: usize| if quarter >> bit & 1 == 1 { off } else { -off };
        let middle = [0, 1].map(|k| self.middle[k] + sign(k) * self.half);
        Square { middle, half: 0.5 * self.half, depth: self.depth + 1, ..*self }
    }
}

impl FarthestPoint {
    /// Of some points.
    pub fn new(points: &[Vector3<f64>]) -> FarthestPoint {
        let slack = ROUNDING * points.iter().map(|point| point.amax()).fold(0.0, f64::max);
        let most_cells = 6 + CELLS * points.len();
        let face = |face: usize| {
            let side = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
            Square { axis: face / 2, side, middle: [0.0; 2], half: 1.0, depth: 0 }
        };
        let mut filled = FarthestPoint { points: Vec::new(), cells: vec![Cell::Points([0; 2]); 6] };
        // Large cells first.
        let mut open: VecDeque<(usize, Square, Vec<Vector3<f64>>)> =
            (0..6).map(|number| (number, face(number), face(number).farthest_of(points, slack))).collect();
        while let Some((cell, square, own)) = open.pop_front() {
            let first = filled.cells.len();
            if own.len() <= FEW || square.depth == DEEPEST || first >= most_cells {
                let first = filled.points.len();
                filled.points.extend(own);
                filled.cells[cell] = Cell::Points([first, filled.points.len()]);
                continue;
            }
            filled.cells[cell] = Cell::Quartered(first);
            filled.cells.extend([Cell::Points([0; 2]); 4]);
            open.extend((0..4).map(|number| {
                let quarter = square.quarter(number, 0.5);
                (first + number, quarter, quarter.farthest_of(&own, slack))
            }));
        }
        filled
    }

    /// The farthest in a direction of any length; the origin where there are no points.
    pub fn along(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        let axis = direction.iamax();
        let mut cell = 2 * axis + usize::from(direction[axis] < 0.0);
        // Where the direction meets the cell, from -1 to 1 in both coordinates.
        let mut at = [1, 2].map(|k| direction[(axis + k) % 3] / direction[axis].abs());
        loop {
            match self.cells[cell] {
                Cell::Quartered(first) => {
                    let upper = at.map(|at| at > 0.0);
                    cell = first + usize::from(upper[0]) + 2 * usize::from(upper[1]);
                    at = [0, 1].map(|k| 2.0 * at[k] + if upper[k] { -1.0 } else { 1.0 });
                }
                Cell::Points([first, end]) => {
                    let mut found = Vector3::zeros();
                    let mut most = f64::NEG_INFINITY;
                    for point in &self.points[first..end] {
                        let far = direction.dot(point);
                        if far > most {
                            (most, found) = (far, *point);
                        }
                    }
                    return found;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// A random vector.
    fn vector(rng: &mut ChaCha8Rng) -> Vector3<f64> {
        Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0))
    }

    #[test]
    fn the_farthest_of_all_is_found_whatever_the_direction() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        // Along the edges of cells, too.
        let mut directions: Vec<Vector3<f64>> = (0..27)
            .map(|k| Vector3::new(k % 3, k / 3 % 3, k / 9).map(|x: i32| f64::from(x - 1)))
            .chain((0..200).map(|_| vector(&mut rng) * 5.0))
            .collect();
        directions.extend(directions.clone().iter().map(|direction| direction * 1e-9));
        for count in [0, 1, 4, 8, 12, 13, 100, 2000] {
            // All near a ball's surface, as a hull's corners are, and some twice.
            let mut points: Vec<Vector3<f64>> =
                (0..count).map(|_| vector(&mut rng).normalize() * 0.3).collect();
            points.extend(points.clone().iter().take(3));
            // Two rims, whose points are all equally far along their axis.
            points.extend((0..count / 2).map(|k| {
                let angle = std::f64::consts::TAU * f64::from(k) / f64::from(count / 2);
                Vector3::new(0.2 * angle.cos(), if k % 2 == 0 { 0.35 } else { -0.35 }, 0.2 * angle.sin())
            }));
            let farthest = FarthestPoint::new(&points);
            for direction in &directions {
                let far = points.iter().map(|p| direction.dot(p)).fold(f64::NEG_INFINITY, f64::max);
                let found = farthest.along(direction);
                match count {
                    0 => assert_eq!(found, Vector3::zeros()),
                    _ => assert_eq!(direction.dot(&found), far, "{count} points"),
                }
            }
        }
    }

    #[test]
    fn few_points_are_looked_at_however_many_there_are() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let points: Vec<Vector3<f64>> = (0..20_000).map(|_| vector(&mut rng).normalize()).collect();
        let farthest = FarthestPoint::new(&points);
        let most = farthest.cells.iter().map(|cell| match cell {
            Cell::Points([first, end]) => end - first,
            Cell::Quartered(_) => 0,
        });
        assert!(most.max().is_some_and(|most| most <= FEW));
        // Each is in the few cells that it may be the farthest in.
        assert!(farthest.points.len() < 6 * points.len(), "{}", farthest.points.len());
    }
}
