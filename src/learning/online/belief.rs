//! What is believed of a body touch by touch: a schema and the covariance of its parameters.
//!
//! Each touch is one equation, that the gap between two surfaces is zero, and one step of an extended
//! Kalman filter (Jazwinski, "Stochastic Processes and Filtering Theory", 1970, theorem 8.1):
//!
//! ```text
//! s = r + j Σ jᵀ      K = Σ jᵀ / s      x ← x − K gap      Σ ← Σ − K s Kᵀ
//! ```
//!
//! in which j is the gap's derivative and `r = σ² + (κ j Σ jᵀ)²` the variance of the touch: what the schema
//! does not know to first order moves the point of contact over surfaces of curvature κ, and that makes a
//! second-order error, which must not be taken for knowledge.

use nalgebra::{DMatrix, DVector, Matrix2};

use crate::agent::Agent;
use crate::creature::Creature;
use crate::deadline::Deadline;
use crate::learning::Parameters;
use crate::learning::annealing::{NARROWEST, WIDEST, gaps, quantile, typical_gap};
use crate::learning::least_squares::{LeastSquares, Stopping, levenberg_marquardt};
use crate::learning::prediction::{GapRow, information_inverse, invert};
use crate::learning::prior::{CorrelatedPrior, Prior, between_bases};
use crate::learning::surface_gap::SurfaceGap;
use crate::learning::touch_set::{PreparedTouch, TouchProblem, TouchSet};
use crate::schema::BodySchema;
use crate::skin::Skin;

/// The sharpest curvature κ of a limb, 1/m: a finger's.
const CURVATURE: f64 = 50.0;
/// Squared slopes between two tangent bases that tell a turn of the axis from a jump of the basis.
const TURNED: f64 = 1e-3;
/// Linearizations at each deviation when all touches are fitted again.
const ITERATIONS: usize = 2;

/// A Gaussian about a schema.
#[derive(Clone, Debug)]
pub struct Belief {
    /// The mean.
    pub schema: BodySchema,
    /// The parameters that touches determine.
    pub parameters: Parameters,
    /// Their covariance Σ (m², m, 1), symmetric.
    pub covariance: DMatrix<f64>,
    /// Standard deviation σ of a touch's gap, metres.
    pub deviation: f64,
    row: GapRow,
    product: DVector<f64>,
}

/// What was expected of a touch before it was learned from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expectation {
    /// The gap at which the schema put the two surfaces that touched, metres: the error of the prediction.
    pub gap: f64,
    /// Its predicted standard deviation, metres.
    pub deviation: f64,
}

impl Belief {
    /// A belief; its covariance is that of `information`, the normal equations at the schema (lower
    /// triangle). `None` if rounding makes them unusable.
    pub fn new(
        schema: BodySchema,
        parameters: Parameters,
        information: DMatrix<f64>,
        deviation: f64,
    ) -> Option<Belief> {
        let product = DVector::zeros(parameters.len());
        let covariance = information_inverse(information, &parameters)?;
        Some(Belief { schema, parameters, covariance, deviation, row: GapRow::default(), product })
    }

    /// What touches of a gap deviation (metres) and a prior determine of parameters at a schema that was fitted to them. `None` if
    /// rounding forbids it.
    pub fn at(
        agent: &Agent,
        touches: &TouchSet,
        parameters: Parameters,
        prior: &Prior,
        schema: BodySchema,
        deviation: f64,
    ) -> Option<Belief> {
        let model = SurfaceGap::new(agent.skin(), deviation);
        let mut problem = TouchProblem::new(agent.creature(), touches, &parameters, model).with_prior(prior);
        let information = problem.linearize(&schema).hessian;
        Belief::new(schema, parameters, information, deviation)
    }

    /// The belief that all touches give when they are fitted again from this one, to have every derivative where the schema is
    /// now. `None` if rounding forbids it.
    pub fn fitted_again(&self, agent: &Agent, touches: &TouchSet, prior: &Prior) -> Option<Belief> {
        let (schema, deviation) =
            fit_again(agent, touches, &self.parameters, prior, self.schema.clone(), self.deviation);
        Belief::at(agent, touches, self.parameters.clone(), prior, schema, deviation)
    }

    /// Whether the belief has a place for every joint.
    pub fn knows(&self, mut joints: impl Iterator<Item = usize>, frozen: &[bool]) -> bool {
        joints.all(|joint| frozen[joint] || self.parameters.positions[joint].is_some())
    }

    /// What the schema expects of a touch. [`Belief::learn`] learns from that touch.
    pub fn expect(&mut self, skin: &Skin, touch: &PreparedTouch) -> Expectation {
        self.row.set(skin, &self.parameters, &self.schema, touch);
        let variance = multiply(&self.covariance, &self.row.entries, &mut self.product);
        let noise = self.noise(variance);
        Expectation { gap: self.row.gap, deviation: (noise + variance).sqrt() }
    }

    /// Learns from the touch that was expected last; `weight` divides its variance, 1 for a touch like others.
    pub fn learn(&mut self, weight: f64) {
        let variance: f64 = self.row.entries.iter().map(|&(k, slope)| slope * self.product[k]).sum();
        let total = self.noise(variance) / weight + variance;
        if total <= 0.0 || !total.is_finite() {
            return;
        }
        let step = &self.product * (-self.row.gap / total);
        let moved = self.parameters.step(&self.schema, &step);
        self.covariance.ger(-1.0 / total, &self.product, &self.product, 1.0);
        self.carry(&moved);
        self.schema = moved;
    }

    /// Makes the covariance that with one touch more, given by the derivative of its gap as pairs of place and slope;
    /// the schema stays.
    pub fn tell(&mut self, row: &[(usize, f64)]) {
        let total = self.deviation.powi(2) + multiply(&self.covariance, row, &mut self.product);
        self.covariance.ger(-1.0 / total, &self.product, &self.product, 1.0);
    }

    /// `r`, the variance of a touch whose gap the schema knows to `variance`.
    fn noise(&self, variance: f64) -> f64 {
        self.deviation.powi(2) + (CURVATURE * variance).powi(2)
    }

    /// Where the tangent basis of an axis jumps from one schema to the next, turns the covariance with it.
    fn carry(&mut self, moved: &BodySchema) {
        for (k, offset) in self.parameters.axes.iter().enumerate() {
            let Some(offset) = *offset else { continue };
            let turn = between_bases(&self.schema, moved, k);
            if (turn - Matrix2::identity()).norm_squared() > TURNED {
                let rows = turn * self.covariance.fixed_rows::<2>(offset);
                self.covariance.fixed_rows_mut::<2>(offset).copy_from(&rows);
                let columns = self.covariance.fixed_columns::<2>(offset) * turn.transpose();
                self.covariance.fixed_columns_mut::<2>(offset).copy_from(&columns);
            }
        }
    }

    /// Whether the tangent basis of an axis jumps from the schema to another.
    pub fn jumps(&self, to: &BodySchema) -> bool {
        let jumped = |k| (between_bases(&self.schema, to, k) - Matrix2::identity()).norm_squared() > TURNED;
        (0..self.parameters.axes.len()).any(|k| self.parameters.axes[k].is_some() && jumped(k))
    }

    /// Makes the position of a joint uncertain by `deviation`, metres, in each coordinate.
    pub fn doubt_position(&mut self, joint: usize, deviation: f64) {
        if let Some(offset) = self.parameters.positions[joint] {
            (0..3).for_each(|i| self.covariance[(offset + i, offset + i)] += deviation * deviation);
        }
    }

    /// The belief as all that is known before a fit to other touches. `None` if rounding forbids it.
    pub fn as_prior(&self, creature: &Creature) -> Option<Prior> {
        let correlated = Some(self.marginal(self.parameters.clone())?);
        Some(Prior { correlated, ..Prior::size(creature, f64::INFINITY) })
    }

    /// What is known of some parameters, whatever the others are. `None` if rounding forbids it.
    pub fn marginal(&self, parameters: Parameters) -> Option<CorrelatedPrior> {
        let places = parameters.places_in(&self.parameters);
        let chosen: Vec<usize> = places.iter().map(|(_, there)| *there).collect();
        let covariance = self.covariance.select_rows(&chosen).select_columns(&chosen);
        let variances = covariance.diagonal();
        let mut information = invert(covariance)?;
        information.fill_upper_triangle_with_lower_triangle();
        Some(CorrelatedPrior { mean: self.schema.clone(), parameters, information, variances })
    }
}

/// Sets the product to `Σ jᵀ`; returns `j Σ jᵀ`.
fn multiply(covariance: &DMatrix<f64>, row: &[(usize, f64)], product: &mut DVector<f64>) -> f64 {
    product.fill(0.0);
    for &(column, slope) in row {
        product.axpy(slope, &covariance.column(column), 1.0);
    }
    row.iter().map(|&(k, slope)| slope * product[k]).sum()
}

/// Fits `parameters` to all touches from a schema that is nearly right: the schema, and the deviation of the gaps,
/// metres. The fit begins no narrower than `least`, metres.
pub fn fit_again(
    agent: &Agent,
    touches: &TouchSet,
    parameters: &Parameters,
    prior: &Prior,
    mut schema: BodySchema,
    least: f64,
) -> (BodySchema, f64) {
    let skin = agent.skin();
    let spare = (touches.len() as f64 - 0.7 * parameters.len() as f64).max(1.0);
    let scatter = (touches.len() as f64 / spare).sqrt();
    let noise = |found: &[f64]| (scatter * typical_gap(found)).clamp(NARROWEST, WIDEST);
    let mut found = gaps(skin, touches, &schema);
    let mut deviation = (2.0 * quantile(&found, 0.9)).clamp(least, WIDEST);
    loop {
        let model = SurfaceGap::new(skin, deviation);
        let mut problem = TouchProblem::new(agent.creature(), touches, parameters, model).with_prior(prior);
        let stopping =
            Stopping { iterations: ITERATIONS, relative_cost: 1e-3, cost: 0.0, deadline: Deadline::Never };
        schema = levenberg_marquardt(&mut problem, schema, stopping).state;
        found = gaps(skin, touches, &schema);
        let next = (1.5 * quantile(&found, 0.9)).min(0.5 * deviation).max(noise(&found));
        if next > 0.7 * deviation {
            break;
        }
        deviation = next;
    }
    (schema, noise(&found))
}
