//! Touches as a least-squares problem over a robot's unknowns.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use rayon::prelude::*;

use super::noise::{Noise, NoiseSource, Seen};
use super::pairing::assigned;
use super::robot::{Posed, Robot, Value};
use super::touch::{End, Touch};
use super::unknowns::Unknowns;
use crate::learning::least_squares::{LeastSquares, Linearization};

/// How a residual counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weighing {
    /// By its noise, and by how likely its touch is honest.
    ByNoise,
    /// By Cauchy's weight in units of its group's deviation: from afar, where nothing is known of noise.
    FromAfar,
}

/// The problem of explaining touches by a robot's unknowns.
pub struct Problem<'a> {
    robot: &'a Robot,
    unknowns: &'a Unknowns,
    touches: &'a [Touch],
    /// Per touch where the noise of each pair of its ends comes from: of end `i` of one side and `j` of the other.
    sources: &'a [Vec<NoiseSource>],
    /// The noise.
    pub noise: Noise,
    /// How residuals count.
    pub weighing: Weighing,
    /// Places of parameters that stay as they are.
    pub held: Vec<usize>,
    /// What the last linearization fixed.
    fixed: Vec<Fixed>,
}

/// A pair of ends that are taken to have met, and how its residual is weighed.
#[derive(Clone, Debug)]
struct Fixed {
    touch: usize,
    ends: [usize; 2],
    weight: Matrix3<f64>,
}

impl<'a> Problem<'a> {
    /// The problem of explaining `touches`, whose noise comes from `sources`.
    pub fn new(
        robot: &'a Robot,
        unknowns: &'a Unknowns,
        touches: &'a [Touch],
        sources: &'a [Vec<NoiseSource>],
        noise: Noise,
        weighing: Weighing,
    ) -> Problem<'a> {
        Problem { robot, unknowns, touches, sources, noise, weighing, held: Vec::new(), fixed: Vec::new() }
    }

    /// The residuals at values of the robot's quantities, with their slopes; where it is not known who met whom, of those that
    /// most likely did. Of each its touch and ends.
    pub fn seen(&self, values: &[Value]) -> Vec<(usize, [usize; 2], Seen)> {
        let of_touch = |t: usize| {
            let touch = &self.touches[t];
            let posed = Posed::new(self.robot, values, &touch.posture);
            let pairs = self.pairs(t, &posed);
            let see = |ends: [usize; 2]| {
                let features = [&touch.ends[0][ends[0]].feature, &touch.ends[1][ends[1]].feature];
                let place = |quantity, component| self.unknowns.place(quantity, component);
                let residuals = posed.residuals(features, touch.distance, &place, true);
                (t, ends, Seen { residuals, source: self.source(t, ends) })
            };
            pairs.into_iter().map(see).collect::<Vec<_>>()
        };
        (0..self.touches.len()).into_par_iter().flat_map_iter(of_touch).collect()
    }

    fn source(&self, touch: usize, [i, j]: [usize; 2]) -> NoiseSource {
        self.sources[touch][i * self.touches[touch].ends[1].len() + j]
    }

    /// Who met whom.
    fn pairs(&self, t: usize, posed: &Posed) -> Vec<[usize; 2]> {
        let touch = &self.touches[t];
        let [a, b] = [touch.ends[0].len(), touch.ends[1].len()];
        if a == 1 && b == 1 {
            return vec![[0, 0]];
        }
        let cost = |i: usize, j: usize| {
            let features = [&touch.ends[0][i].feature, &touch.ends[1][j].feature];
            let (size, value) = posed.miss(features, touch.distance);
            let deviation = self.deviation(self.source(t, [i, j]));
            // A pair that is surely false is as good as any other that is.
            (1.0 + value.norm_squared() / (size as f64 * deviation * deviation)).ln()
        };
        assigned(a, b, cost)
    }

    /// The deviation of a residual without what noisy encoders add.
    fn deviation(&self, source: NoiseSource) -> f64 {
        (source.given + self.noise.groups[source.group].powi(2)).sqrt().max(1e-10)
    }

    /// How a residual is weighed.
    fn weight(&self, seen: &Seen) -> Matrix3<f64> {
        match self.weighing {
            Weighing::ByNoise => {
                let inverse = self.noise.covariance(seen).try_inverse().unwrap_or_else(Matrix3::zeros);
                inverse * self.noise.honesty(seen)
            }
            Weighing::FromAfar => {
                let variance = self.noise.groups[seen.source.group].powi(2);
                let squares = seen.residuals.value.norm_squared();
                Matrix3::identity() / (variance + squares)
            }
        }
    }
}

/// `½ rᵀ W r`.
fn squared(value: &Vector3<f64>, weight: &Matrix3<f64>) -> f64 {
    0.5 * value.dot(&(weight * value))
}

impl LeastSquares for Problem<'_> {
    type State = Vec<Value>;

    fn linearize(&mut self, values: &Vec<Value>) -> Linearization {
        let mut total = Linearization::nothing(self.unknowns.len());
        let seen = self.seen(values);
        self.fixed.clear();
        for (touch, ends, seen) in seen {
            let weight = self.weight(&seen);
            add_to(&mut total, &seen.residuals.slopes, &seen.residuals.value, &weight);
            total.cost += squared(&seen.residuals.value, &weight);
            self.fixed.push(Fixed { touch, ends, weight });
        }
        total.scale = total.hessian.diagonal();
        self.unknowns.add_prior(self.robot, values, &mut total);
        hold(&mut total.hessian, &self.held);
        for place in &self.held {
            (total.gradient[*place], total.scale[*place]) = (0.0, 1.0);
        }
        total
    }

    fn cost(&self, values: &Vec<Value>) -> f64 {
        let of_pair = |fixed: &Fixed| {
            let touch = &self.touches[fixed.touch];
            let posed = Posed::new(self.robot, values, &touch.posture);
            let [a, b]: [&End; 2] = [&touch.ends[0][fixed.ends[0]], &touch.ends[1][fixed.ends[1]]];
            squared(&posed.miss([&a.feature, &b.feature], touch.distance).1, &fixed.weight)
        };
        self.fixed.iter().map(of_pair).sum::<f64>() + self.unknowns.prior_cost(self.robot, values)
    }

    fn step(&self, values: &Vec<Value>, step: &DVector<f64>) -> Vec<Value> {
        self.unknowns.step(values, step)
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
