//! The fit of parameters to touches in noise.

use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector, Dyn, Vector3};

use super::adjusted::{Adjusted, gaps_where_skin_is};
use super::estimate::{Eliminated, MixedSystem, Noise};
use super::gap::{Compared, NoisyGap, shift_under};
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
    /// No parameters: what a cost has derivatives by.
    nothing: Parameters,
}

/// A schema, and where the skin is.
#[derive(Clone)]
pub struct Placed {
    /// The schema.
    pub schema: BodySchema,
    /// Per receptor, how far the skin under it is from where it was told to be, in its limb's frame, metres; empty where all is there.
    shifts: Vec<Vector3<f64>>,
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
        let nothing = Parameters::new(of.0.creature(), parameters.axis_model, |_| false);
        NoisyProblem { of, adjusted, parameters, prior, noise, system: None, residuals: None, nothing }
    }

    /// Where the search begins: a schema, with skin where the touches were adjusted to.
    pub fn start(&self, schema: BodySchema) -> Placed {
        Placed { schema, shifts: self.adjusted.shifts.clone() }
    }

    /// The gaps of a schema, by skin where it is, without their derivatives.
    fn gaps(&self, at: &Placed) -> Vec<NoisyGap> {
        gaps_where_skin_is(self.of, self.adjusted, &self.nothing, &at.schema, &at.shifts)
    }

    /// The cost of gaps with skin where it is, in some system.
    fn cost_of(system: &MixedSystem, gaps: &[NoisyGap], shifts: &[Vector3<f64>]) -> f64 {
        let squares = gaps.iter().zip(&system.weights).map(|(gap, weight)| {
            let moved: f64 = gap.shifts().map(|(r, normal)| normal.dot(&shift_under(shifts, r))).sum();
            weight * (gap.gap + moved).powi(2)
        });
        let of_shifts = shifts.iter().map(|shift| shift.norm_squared()).sum::<f64>();
        0.5 * (squares.sum::<f64>() + of_shifts / system.receptor.powi(2).max(f64::MIN_POSITIVE))
    }
}

impl LeastSquares for NoisyProblem<'_> {
    type State = Placed;

    fn linearize(&mut self, at: &Placed) -> Linearization {
        let n = self.parameters.len();
        count_work(self.adjusted.touches.len() * (LOOK + n.pow(2)));
        let gaps = gaps_where_skin_is(self.of, self.adjusted, self.parameters, &at.schema, &at.shifts);
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
            Some(Eliminated { information: hessian, gradient, factor }) => {
                let cost = NoisyProblem::cost_of(&system, &gaps, &at.shifts);
                self.system = Some((system, factor));
                Linearization { scale: hessian.diagonal(), hessian, gradient, cost }
            }
        };
        self.prior.add(self.parameters, &at.schema, &mut total);
        total
    }

    fn cost(&self, at: &Placed) -> f64 {
        let Some((system, _)) = &self.system else { return f64::INFINITY };
        NoisyProblem::cost_of(system, &self.gaps(at), &at.shifts)
            + self.prior.cost(self.parameters, &at.schema)
    }

    /// The skin goes where it most likely is by the new schema.
    fn step(&self, at: &Placed, step: &DVector<f64>) -> Placed {
        let mut next = Placed { schema: self.parameters.step(&at.schema, step), ..at.clone() };
        if let Some((system, Some(factor))) = &self.system {
            next.shifts = system.likeliest_shifts(&self.gaps(&next), factor);
        }
        next
    }
}
