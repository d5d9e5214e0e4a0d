//! Fitting a body of the family to what was felt, with the smallest deformation.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Vector3};

use super::FeltShape;
use super::family::RoundedFrustum;
use crate::geometry::{ConvexBody, Precision, directions, distance_by_support};

/// How far a corner of a thing is from the family's body, one standard deviation, in shares of its size …
const BENDS: f64 = 0.2;
/// … and over what angle of its direction that changes, radians.
const WITHIN: f64 = 0.5;
/// Corners of a body.
const CORNERS: usize = 250;
/// Corners no farther behind the farthest one than this share where skin touches, metres.
const SHARING: f64 = 5e-4;
/// Rounds of bending.
const ROUNDS: usize = 12;

/// The convex hull of corners: points of the family's body that are farthest in directions all about, each moved along its
/// direction. How far is a Gaussian process over directions (Rasmussen and Williams 2006, section 2.2).
#[derive(Clone, Debug)]
pub(super) struct BentBody {
    directions: Vec<Vector3<f64>>,
    unbent: Vec<Vector3<f64>>,
    corners: Vec<Vector3<f64>>,
    middle: Vector3<f64>,
    variance: f64,
    /// What was told, in how far each corner moved, and its covariance.
    rows: DMatrix<f64>,
    factor: Option<Cholesky<f64, Dyn>>,
}

impl BentBody {
    /// A body of the family, not bent; `size` in metres.
    pub fn new(family: &RoundedFrustum, size: f64) -> BentBody {
        let directions: Vec<Vector3<f64>> = directions(CORNERS).collect();
        let unbent: Vec<Vector3<f64>> =
            directions.iter().map(|direction| family.support(direction)).collect();
        let (corners, middle) = (unbent.clone(), family.centre());
        let rows = DMatrix::zeros(0, CORNERS);
        BentBody { directions, unbent, corners, middle, variance: (BENDS * size).powi(2), rows, factor: None }
    }

    /// The same bent so that the skin that touched touches it, to `exactness` in metres, and no other is in it; it does not reach
    /// below a plane at a distance from the origin along `down`, but down to it.
    pub fn bent(mut self, felt: &FeltShape, stands: Option<(Vector3<f64>, f64)>, exactness: f64) -> BentBody {
        let covariance = DMatrix::from_fn(CORNERS, CORNERS, |i, j| {
            kernel(&self.directions[i], &self.directions[j], self.variance)
        });
        let mut moved = DVector::zeros(CORNERS);
        for _ in 0..ROUNDS {
            let mut rows: Vec<DVector<f64>> = Vec::new();
            let mut residuals = Vec::new();
            let mut tell = |body: &BentBody, normal: &Vector3<f64>, residual: f64| {
                rows.push(body.moves(normal));
                residuals.push(residual);
            };
            felt.gaps(&self).iter().for_each(|gap| tell(&self, &gap.normal, gap.distance));
            if let Some((down, far)) = &stands {
                let extent = self.support(down).dot(down);
                tell(&self, down, far - extent);
            }
            // Linearised about what it is now: rows · moved' = rows · moved − residual, extents being what moves.
            let count = rows.len();
            let rows = DMatrix::from_fn(count, CORNERS, |i, j| rows[i][j]);
            let wanted = &rows * &moved + DVector::from_vec(residuals.clone());
            let toward = &covariance * rows.transpose();
            let mut told = &rows * &toward;
            for i in 0..count {
                told[(i, i)] += exactness * exactness;
            }
            let Some(factor) = Cholesky::new(told) else { break };
            let next = &toward * factor.solve(&wanted);
            let change = (&next - &moved).amax();
            // Half a step: which corners touch changes on the way.
            moved = 0.5 * &moved + 0.5 * next;
            for (k, corner) in self.corners.iter_mut().enumerate() {
                *corner = self.unbent[k] + self.directions[k] * moved[k];
            }
            (self.rows, self.factor) = (rows, Some(factor));
            if change < 0.1 * exactness {
                break;
            }
        }
        self
    }

    /// Points whose convex hull it is.
    pub fn corners(&self) -> &[Vector3<f64>] {
        &self.corners
    }

    /// How much each corner moves the body's extent along a unit direction.
    fn moves(&self, normal: &Vector3<f64>) -> DVector<f64> {
        let far: Vec<f64> = self.corners.iter().map(|corner| corner.dot(normal)).collect();
        let most = far.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let weights: Vec<f64> = far.iter().map(|far| ((far - most) / SHARING).exp()).collect();
        let sum: f64 = weights.iter().sum();
        let row = weights.iter().zip(&self.directions).map(|(w, direction)| w / sum * direction.dot(normal));
        DVector::from_iterator(CORNERS, row)
    }

    /// One standard deviation of how far it extends anywhere before anything is told, metres.
    pub fn before(&self) -> f64 {
        self.variance.sqrt()
    }

    /// One standard deviation of how far it extends along a unit direction, metres.
    pub fn deviation(&self, direction: &Vector3<f64>) -> f64 {
        let kernels: Vec<f64> =
            self.directions.iter().map(|other| kernel(direction, other, self.variance)).collect();
        let known = self.factor.as_ref().map_or(0.0, |factor| {
            let toward = &self.rows * DVector::from_vec(kernels);
            toward.dot(&factor.solve(&toward))
        });
        (self.variance - known).max(0.0).sqrt()
    }
}

impl ConvexBody for BentBody {
    fn support(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        let far = |corner: &&Vector3<f64>| corner.dot(direction);
        *self.corners.iter().max_by(|a, b| far(a).total_cmp(&far(b))).expect("a body has corners")
    }

    fn centre(&self) -> Vector3<f64> {
        self.middle
    }

    fn signed_distance(&self, p: &Vector3<f64>) -> (f64, Vector3<f64>) {
        distance_by_support(self, p, Precision::ExactWhereShallow)
    }
}

fn kernel(a: &Vector3<f64>, b: &Vector3<f64>, variance: f64) -> f64 {
    variance * ((a.dot(b) - 1.0) / (WITHIN * WITHIN)).exp()
}
