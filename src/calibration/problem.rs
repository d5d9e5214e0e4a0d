//! Touches as a least-squares problem over a robot's unknowns.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::estimate::Estimator;
use super::noise::{Noise, Seen};
use super::robot::{Posed, Value};
use crate::learning::least_squares::{LeastSquares, Linearization, Stopping, levenberg_marquardt};

/// Linearizations of one fit.
const ITERATIONS: usize = 20;

/// How a residual is weighed in some noise.
pub type Weight = fn(&Noise, &Seen) -> Matrix3<f64>;

/// The problem of explaining an estimator's touches by its unknowns.
struct Problem<'a> {
    estimator: &'a Estimator<'a>,
    noise: &'a Noise,
    weight: Weight,
    /// Places of parameters that stay as they are.
    held: &'a [usize],
    /// What the last linearization fixed: pairs of ends that are taken to have met, and how their residuals are weighed.
    fixed: Vec<(usize, [usize; 2], Matrix3<f64>)>,
}

impl Estimator<'_> {
    /// The values nearest to others that explain the touches best in some noise, but for what is held.
    pub(super) fn descend(
        &self,
        start: Vec<Value>,
        (noise, weight): (&Noise, Weight),
        held: &[usize],
        relative_cost: f64,
    ) -> Vec<Value> {
        let mut problem = Problem { estimator: self, noise, weight, held, fixed: Vec::new() };
        let stopping = Stopping { iterations: ITERATIONS, relative_cost, ..Stopping::default() };
        self.canonical(levenberg_marquardt(&mut problem, start, stopping).state)
    }
}

/// `½ rᵀ W r`.
fn squared(value: &Vector3<f64>, weight: &Matrix3<f64>) -> f64 {
    0.5 * value.dot(&(weight * value))
}

impl LeastSquares for Problem<'_> {
    type State = Vec<Value>;

    fn linearize(&mut self, values: &Vec<Value>) -> Linearization {
        let (robot, unknowns) = (self.estimator.robot, &self.estimator.unknowns);
        let mut total = Linearization::nothing(unknowns.len());
        self.fixed.clear();
        for seen in self.estimator.seen(values, self.noise) {
            let weight = (self.weight)(self.noise, &seen);
            add_to(&mut total, &seen.residuals.slopes, &seen.residuals.value, &weight);
            total.cost += squared(&seen.residuals.value, &weight);
            self.fixed.push((seen.touch, seen.ends, weight));
        }
        total.scale = total.hessian.diagonal();
        unknowns.add_prior(robot, values, &mut total);
        hold(&mut total.hessian, self.held);
        for place in self.held {
            (total.gradient[*place], total.scale[*place]) = (0.0, 1.0);
        }
        total
    }

    fn cost(&self, values: &Vec<Value>) -> f64 {
        let Estimator { robot, unknowns, .. } = self.estimator;
        let of_pair = |(touch, ends, weight): &(usize, [usize; 2], Matrix3<f64>)| {
            let touch = &self.estimator.touches[*touch];
            let posed = Posed::new(robot, values, &touch.posture);
            squared(&posed.miss(touch.features(*ends), touch.distance).1, weight)
        };
        self.fixed.iter().map(of_pair).sum::<f64>() + unknowns.prior_cost(robot, values)
    }

    fn step(&self, values: &Vec<Value>, step: &DVector<f64>) -> Vec<Value> {
        self.estimator.unknowns.step(values, step)
    }
}

/// Adds a residual to normal equations, of which the lower triangle is kept.
pub(super) fn add_to(
    total: &mut Linearization,
    slopes: &[(usize, Vector3<f64>)],
    value: &Vector3<f64>,
    weight: &Matrix3<f64>,
) {
    for (i, a) in slopes {
        let weighed = weight * a;
        total.gradient[*i] += weighed.dot(value);
        for (j, b) in slopes {
            if i >= j {
                total.hessian[(*i, *j)] += weighed.dot(b);
            }
        }
    }
}

/// Takes parameters out of normal equations: they stay as they are.
pub(super) fn hold(matrix: &mut DMatrix<f64>, held: &[usize]) {
    for place in held {
        matrix.row_mut(*place).fill(0.0);
        matrix.column_mut(*place).fill(0.0);
        matrix[(*place, *place)] = 1.0;
    }
}

/// `Σ Jᵀ W J` of residuals with a weight each, for so many unknowns: symmetric.
pub(super) fn information<'a>(
    unknowns: usize,
    weighed: impl Iterator<Item = (&'a Seen, Matrix3<f64>)>,
) -> DMatrix<f64> {
    let mut total = Linearization::nothing(unknowns);
    for (seen, weight) in weighed {
        add_to(&mut total, &seen.residuals.slopes, &seen.residuals.value, &weight);
    }
    total.hessian.fill_upper_triangle_with_lower_triangle();
    total.hessian
}
