//! Touches as a least-squares problem over a robot's unknowns.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use rayon::prelude::*;

use super::noise::{Groups, Kind, Noise, Seen};
use super::pairing::assigned;
use super::robot::{Posed, Robot, Value};
use super::told::Told;
use super::touch::{Feature, Touch};
use super::unknowns::Unknowns;
use crate::learning::least_squares::{LeastSquares, Linearization, Stopping, levenberg_marquardt};

/// Linearizations of one fit.
const ITERATIONS: usize = 20;

/// How a residual is weighed in some noise.
pub type Weight = fn(&Noise, &Seen) -> Matrix3<f64>;

/// How to calibrate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimatorOptions {
    /// Noise of encoders, a standard deviation in radians and metres; `None` is as much as the touches show.
    pub joint_noise: Option<f64>,
    /// Whether touches may be false, if they show it.
    pub false_touches: bool,
}

impl Default for EstimatorOptions {
    fn default() -> EstimatorOptions {
        EstimatorOptions { joint_noise: Some(0.0), false_touches: true }
    }
}

/// A robot and its touches, ready to be calibrated.
#[derive(Clone)]
pub struct Estimator<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// What is to be found.
    pub unknowns: Unknowns,
    /// The touches.
    pub touches: &'a [Touch],
    /// How to calibrate.
    pub options: EstimatorOptions,
    groups: Groups,
    /// Places of parameters that stay as they are: the touches determine them only together with others.
    pub(super) held: Vec<usize>,
}

impl<'a> Estimator<'a> {
    /// An estimator of a robot's open quantities from touches.
    pub fn new(robot: &'a Robot, touches: &'a [Touch], options: EstimatorOptions) -> Estimator<'a> {
        let kinds =
            touches.iter().flat_map(|touch| pairs(touch).map(move |ends| kind_of(robot, touch, ends)));
        let groups = Groups::of(kinds);
        let mut estimator =
            Estimator { robot, unknowns: Unknowns::of(robot), touches, options, groups, held: Vec::new() };
        // What the touches do not determine stays at the maker's value.
        let noise = estimator.noise(1.0, 0.0);
        let seen = estimator.seen(&robot.nominal(), &noise);
        estimator.held = Told::by(&estimator.information(&seen, &noise, true)).dependent;
        estimator
    }

    /// The same of other touches, whose noise is of the same groups.
    pub(super) fn of_touches<'b>(&'b self, touches: &'b [Touch]) -> Estimator<'b> {
        Estimator { touches, ..self.clone() }
    }

    /// The same of a robot with other unknowns.
    pub(super) fn of_robot<'b>(&'b self, robot: &'b Robot) -> Estimator<'b> {
        Estimator { robot, unknowns: Unknowns::of(robot), ..self.clone() }
    }

    /// Noise of one deviation in all touches, metres, and of encoders, radians.
    pub fn noise(&self, deviation: f64, joint: f64) -> Noise {
        let groups = self.groups.count();
        Noise {
            groups: vec![deviation; groups],
            joint,
            false_share: 0.0,
            widths: vec![1.0; groups],
            dead: None,
        }
    }

    /// What the touches look like at some values, in some noise; where it is not known who met whom, those that most likely did.
    pub fn seen(&self, values: &[Value], noise: &Noise) -> Vec<Seen> {
        let of_touch = |t: usize| {
            let touch = &self.touches[t];
            let posed = Posed::new(self.robot, values, &touch.posture);
            let see = |ends: [usize; 2]| {
                let place = |quantity, component| self.unknowns.place(quantity, component);
                let residuals = posed.residuals(touch.features(ends), touch.distance, &place);
                let (group, given) = self.source(touch, ends);
                Seen { touch: t, ends, residuals, group, given }
            };
            self.who_met_whom(touch, &posed, noise).into_iter().map(see).collect::<Vec<_>>()
        };
        (0..self.touches.len()).into_par_iter().flat_map_iter(of_touch).collect()
    }

    fn who_met_whom(&self, touch: &Touch, posed: &Posed, noise: &Noise) -> Vec<[usize; 2]> {
        let [a, b] = touch.ends.each_ref().map(Vec::len);
        if [a, b] == [1, 1] {
            return vec![[0, 0]];
        }
        assigned(a, b, &|i, j| {
            let (size, value) = posed.miss(touch.features([i, j]), touch.distance);
            let (group, given) = self.source(touch, [i, j]);
            let variance = noise.variance(group, given);
            // A pair that is surely false is as good as any other that is.
            (1.0 + value.norm_squared() / (size as f64 * variance)).ln()
        })
    }

    /// The group of a pair of ends, and the variance that was given with them: what noise there is at the least; what more there is,
    /// the touches show.
    fn source(&self, touch: &Touch, ends: [usize; 2]) -> (usize, f64) {
        let given = touch.pair(ends).into_iter().filter_map(|end| end.deviation);
        (self.groups.group(&kind_of(self.robot, touch, ends)), given.map(|deviation| deviation.powi(2)).sum())
    }

    /// The information about the unknowns in touches, symmetric; with what was known before.
    pub fn information(&self, seen: &[Seen], noise: &Noise, with_prior: bool) -> DMatrix<f64> {
        let weighed = seen.iter().map(|seen| (seen, noise.weight(seen)));
        let mut information = information(self.unknowns.len(), weighed);
        if with_prior {
            self.unknowns.add_information(&mut information);
        }
        information
    }

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

/// What two of a touch's ends are between.
fn kind_of(robot: &Robot, touch: &Touch, ends: [usize; 2]) -> Kind {
    let features = touch.features(ends);
    let [a, b] = features.map(|feature| feature.link(robot));
    let meet = touch.distance == 0.0 && features.iter().all(|feature| matches!(feature, Feature::Point(..)));
    (a.min(b), a.max(b), meet)
}

/// All pairs of a touch's ends.
pub(super) fn pairs(touch: &Touch) -> impl Iterator<Item = [usize; 2]> {
    let [a, b] = touch.ends.each_ref().map(Vec::len);
    (0..a).flat_map(move |i| (0..b).map(move |j| [i, j]))
}

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
