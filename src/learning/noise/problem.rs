//! The fit of parameters to touches in noise.

use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector, Dyn};

use super::adjusted::{Adjusted, gaps_of};
use super::estimate::{Eliminated, MixedSystem, Noise};
use super::gap::{Compared, NoisyGap};
use crate::agent::Agent;
use crate::deadline::count_work;
use crate::learning::Parameters;
use crate::learning::least_squares::{LeastSquares, Linearization};
use crate::learning::prior::Prior;
use crate::learning::touch_set::LOOK;
use crate::schema::BodySchema;

/// The least-squares problem of touches in some noise: see the [module](super).
pub struct NoisyProblem<'a> {
    of: (&'a Agent, Compared),
    adjusted: &'a Adjusted<'a>,
    parameters: &'a Parameters,
    prior: &'a Prior,
    noise: Noise,
    system: Option<(MixedSystem, Option<Cholesky<f64, Dyn>>)>,
    residuals: Option<Vec<f64>>,
}

impl<'a> NoisyProblem<'a> {
    /// The problem of explaining touches by moving `parameters`.
    pub fn new(
        of: (&'a Agent, Compared),
        adjusted: &'a Adjusted<'a>,
        parameters: &'a Parameters,
        prior: &'a Prior,
        noise: Noise,
    ) -> NoisyProblem<'a> {
        NoisyProblem { of, adjusted, parameters, prior, noise, system: None, residuals: None }
    }

    /// The cost of gaps under the weights of the last linearization.
    fn cost_of(&self, gaps: &[NoisyGap]) -> f64 {
        let Some((system, factor)) = &self.system else { return f64::INFINITY };
        let mut pull = DVector::zeros(system.shifts);
        for (gap, weight) in gaps.iter().zip(&system.weights) {
            for (place, slope) in system.shifts_of(gap) {
                pull[place] += weight * slope * gap.gap;
            }
        }
        let shift = factor.as_ref().map_or(DVector::zeros(0), |factor| -factor.solve(&pull));
        let squares = gaps.iter().zip(&system.weights).map(|(gap, weight)| {
            let moved: f64 = system.shifts_of(gap).map(|(k, slope)| slope * shift[k]).sum();
            weight * (gap.gap + moved).powi(2)
        });
        0.5 * (squares.sum::<f64>() + shift.norm_squared() / system.receptor.powi(2).max(f64::MIN_POSITIVE))
    }
}

impl LeastSquares for NoisyProblem<'_> {
    type State = BodySchema;

    fn linearize(&mut self, schema: &BodySchema) -> Linearization {
        let n = self.parameters.len();
        count_work(self.adjusted.touches.len() * (LOOK + n.pow(2)));
        let gaps = gaps_of(self.of, self.adjusted, self.parameters, schema);
        let nothing = DMatrix::zeros(n, n);
        let mut system = MixedSystem::new(&self.noise, &gaps, &nothing, self.residuals.as_ref());
        // Who is honest is seen best where the step leads.
        if let Some(solved) = system.solve(&gaps, self.parameters, false) {
            system = MixedSystem::new(&self.noise, &gaps, &nothing, Some(&solved.residuals));
            self.residuals = Some(solved.residuals);
        }
        let eliminated = system.eliminated();
        let mut total = match eliminated {
            None => Linearization { cost: f64::INFINITY, ..Linearization::nothing(n) },
            Some(Eliminated { information: hessian, gradient, cost, factor }) => {
                self.system = Some((system, factor));
                Linearization { scale: hessian.diagonal(), hessian, gradient, cost }
            }
        };
        self.prior.add(self.parameters, schema, &mut total);
        total
    }

    fn cost(&self, schema: &BodySchema) -> f64 {
        let gaps = gaps_of(self.of, self.adjusted, self.parameters, schema);
        self.cost_of(&gaps) + self.prior.cost(self.parameters, schema)
    }

    fn step(&self, schema: &BodySchema, step: &DVector<f64>) -> BodySchema {
        self.parameters.step(schema, step)
    }
}
