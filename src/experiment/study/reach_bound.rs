//! No grip gets farther than this, whatever the search: an upper bound of the true farthest, of limbs that may be in each
//! other and in the table.
//!
//! How far a point gets along a direction `c`, without conditions, is found exactly joint by joint, from the grip to the root
//! (dynamic programming): `S_k(d) = max_θ S_{k+1}(R(a_k, θ)ᵀ d) + d · l_k`, where `d` is the direction as joint k sees it.
//! The grip's height `h` and that it is upright enter by Lagrange's multipliers λ and μ, for any of which
//!
//! ```text
//! front · p  ≤  S(front + λ up; p + μ u) − λ h − λ μ
//! ```
//!
//! holds of every posture in which `up · p = h` and the grip's direction `u` is up; the least of these is the bound. `S` is
//! sublinear in `d`, so that between the places of a grid on a cube its interpolation is no less than it; what angles between
//! those that are tried could add is added.

use nalgebra::{Matrix3, Vector3};

use super::exhaustive_reach::GripProblem;
use crate::creature::DofKind;
use crate::kinematics::rotation;

/// Cells along an edge of the cube, and how far apart angles are that are tried, radians: while multipliers are looked for …
const COARSE: (usize, f64) = (12, 0.08);
/// … and for the bound.
const FINE: (usize, f64) = (40, 0.035);
/// The first step of the multipliers, and the last.
const STEPS: [f64; 2] = [0.4, 0.02];

/// What carries a frame a piece further out, root's side first.
enum Piece {
    Shift(Vector3<f64>),
    Turn { axis: Vector3<f64>, range: [f64; 2] },
    Slide { axis: Vector3<f64>, range: [f64; 2] },
    Fixed(Matrix3<f64>),
}

/// Values at the places of a grid on the cube about the origin, of a function that is homogeneous of degree 1.
struct CubeGrid {
    cells: usize,
    values: Vec<f64>,
}

impl CubeGrid {
    /// The places of the grid, face by face.
    fn places(cells: usize) -> impl Iterator<Item = Vector3<f64>> {
        let side = cells + 1;
        (0..6 * side * side).map(move |at| {
            let (face, i, k) = (at / (side * side), at / side % side, at % side);
            let [a, b] = [i, k].map(|i| 2.0 * i as f64 / cells as f64 - 1.0);
            let mut place = Vector3::zeros();
            place[face / 2] = if face % 2 == 0 { 1.0 } else { -1.0 };
            (place[(face / 2 + 1) % 3], place[(face / 2 + 2) % 3]) = (a, b);
            place
        })
    }

    /// No less than the function in a direction of any length.
    fn at(&self, direction: &Vector3<f64>) -> f64 {
        let axis = direction.iamax();
        let length = direction[axis].abs();
        if length < f64::MIN_POSITIVE {
            return 0.0;
        }
        let face = 2 * axis + usize::from(direction[axis] < 0.0);
        let side = self.cells + 1;
        let [a, b] = [1, 2]
            .map(|k| 0.5 * (direction[(axis + k) % 3] / length + 1.0).clamp(0.0, 2.0) * self.cells as f64);
        let (i, k) = ((a as usize).min(self.cells - 1), (b as usize).min(self.cells - 1));
        let (a, b) = (a - i as f64, b - k as f64);
        let corner = |i: usize, k: usize| self.values[face * side * side + i * side + k];
        length
            * ((1.0 - a) * ((1.0 - b) * corner(i, k) + b * corner(i, k + 1))
                + a * ((1.0 - b) * corner(i + 1, k) + b * corner(i + 1, k + 1)))
    }
}

impl GripProblem<'_> {
    /// No posture has the grip farther in front than this, metres; none where a ball is among the joints.
    pub fn upper_bound(&self) -> Option<f64> {
        let pieces = self.pieces()?;
        let bound = |[by_height, by_tilt]: [f64; 2], fineness: (usize, f64)| {
            let along = self.front + self.up * by_height;
            let point = self.place.point + self.place.direction * by_tilt;
            support(&pieces, &along, &point, fineness) - by_height * (self.height + by_tilt)
        };
        let mut at = [0.0, 0.0];
        let (mut least, mut step) = (bound(at, COARSE), STEPS[0]);
        while step > STEPS[1] {
            let around = [[step, 0.0], [-step, 0.0], [0.0, step], [0.0, -step]];
            let tried = around.map(|change| {
                let there = [at[0] + change[0], at[1] + change[1]];
                (bound(there, COARSE), there)
            });
            let best = tried.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
            if best.0 < least {
                (least, at) = best;
            } else {
                step *= 0.5;
            }
        }
        Some(bound(at, FINE))
    }

    /// The pieces between the root and the grip's limb.
    fn pieces(&self) -> Option<Vec<Piece>> {
        let (creature, schema) = (self.own.creature(), &self.own.schema);
        let mut pieces = Vec::new();
        for joint in self.own.joints_to(self.place.limb) {
            pieces.push(Piece::Shift(schema.positions[joint]));
            for at in creature.joints()[joint].elements() {
                let now = self.from[at.coordinate()];
                let range = if self.joints.contains(&joint) { at.range } else { [now; 2] };
                let axis = schema.axes[at.axis()];
                pieces.push(match at.kind {
                    DofKind::Hinge => Piece::Turn { axis, range },
                    DofKind::Slide => Piece::Slide { axis, range },
                    DofKind::Ball => return None,
                });
            }
            if let Some(pose) = schema.limb_poses.get(joint) {
                pieces.push(Piece::Shift(pose.origin));
                pieces.push(Piece::Fixed(pose.rotation));
            }
        }
        Some(pieces)
    }
}

/// No less than how far a point at the end of some pieces gets along a direction.
fn support(
    pieces: &[Piece],
    along: &Vector3<f64>,
    point: &Vector3<f64>,
    (cells, apart): (usize, f64),
) -> f64 {
    let mut grid = CubeGrid { cells, values: CubeGrid::places(cells).map(|d| d.dot(point)).collect() };
    // No point beyond a piece is farther from it than this.
    let mut length = point.norm();
    for piece in pieces.iter().rev() {
        let values = match piece {
            Piece::Shift(by) => {
                length += by.norm();
                let places = CubeGrid::places(cells).zip(&grid.values);
                places.map(|(d, value)| value + d.dot(by)).collect()
            }
            Piece::Fixed(turn) => CubeGrid::places(cells).map(|d| grid.at(&turn.tr_mul(&d))).collect(),
            Piece::Slide { axis, range } => {
                length += range[0].abs().max(range[1].abs()) * axis.norm();
                let most = |d: &Vector3<f64>| (range[0] * d.dot(axis)).max(range[1] * d.dot(axis));
                CubeGrid::places(cells).zip(&grid.values).map(|(d, value)| value + most(&d)).collect()
            }
            Piece::Turn { axis, range } => {
                let steps = ((range[1] - range[0]) / apart).ceil();
                let turns: Vec<Matrix3<f64>> = (0..=steps as usize)
                    .map(|k| {
                        let angle = range[0] + (range[1] - range[0]) * k as f64 / steps.max(1.0);
                        rotation(axis, angle.sin(), 1.0 - angle.cos()).transpose()
                    })
                    .collect();
                // A direction between two that are tried is one between them in space, and a little more across the axis.
                let between = (range[1] - range[0]) / steps.max(1.0);
                let more = (1.0 / (0.5 * between).cos() - 1.0) * length;
                CubeGrid::places(cells)
                    .map(|d| {
                        let most = turns.iter().map(|turn| grid.at(&(turn * d)));
                        let across = d.cross(axis).norm();
                        most.fold(f64::NEG_INFINITY, f64::max) + more * across
                    })
                    .collect()
            }
        };
        grid.values = values;
    }
    grid.at(along)
}
