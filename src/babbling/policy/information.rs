//! What an imagined touch would tell of the schema.
//!
//! A touch says that the gap of two surfaces is zero. With j its derivative by all parameters and Σ their
//! covariance given the touches so far, the touch brings ½ log(1 + j Σ jᵀ / σ²) nats (Lindley 1956).

use nalgebra::{DMatrix, DVector};

use crate::agent::Agent;
use crate::learning::prediction::{GapRow, covariance};
use crate::learning::rough::{imagined, prepare};
use crate::learning::touch_set::{PreparedTouch, TouchSet};
use crate::learning::{AxisModel, Parameters, Prior, PriorKnowledge};
use crate::schema::BodySchema;
use crate::senses::Touch;

/// The covariance of all positions and axes given the touches so far.
pub struct Information<'a> {
    agent: &'a Agent,
    prior: Prior,
    parameters: Parameters,
    covariance: Option<DMatrix<f64>>,
    deviation: f64,
}

impl<'a> Information<'a> {
    /// Nothing is known yet, not even a schema to say what would tell more.
    pub fn new(agent: &'a Agent) -> Information<'a> {
        let parameters = Parameters::new(agent.creature(), AxisModel::Unit, |_| true);
        let prior = PriorKnowledge::nothing(agent).prior;
        Information { agent, prior, parameters, covariance: None, deviation: 1.0 }
    }

    /// Works the covariance out anew at a schema, with a standard deviation of the gap in metres.
    pub fn rebuild(&mut self, schema: &BodySchema, touches: &[Touch], deviation: f64) {
        let set = prepare(self.agent, touches);
        self.covariance = covariance(self.agent, &set, &self.parameters, &self.prior, schema, deviation);
        self.deviation = deviation;
    }

    /// The gap between two receptors' surfaces in a posture and its derivative by all parameters.
    pub fn row(&self, schema: &BodySchema, receptors: [usize; 2], posture: &[f64]) -> GapRow {
        let mut row = GapRow::default();
        let touch = one(self.agent, receptors, posture);
        row.set(self.agent.skin(), &self.parameters, schema, &touch);
        row
    }

    /// Twice the nats that a touch with this row would bring; 0 where nothing is known.
    pub fn gain(&self, row: &GapRow) -> f64 {
        let variance = self.covariance.as_ref().map_or(0.0, |covariance| row.variance(covariance));
        (1.0 + variance.max(0.0) / self.deviation.powi(2)).ln()
    }

    /// Takes in a touch with this row.
    pub fn update(&mut self, row: &GapRow) {
        let Some(covariance) = &mut self.covariance else { return };
        let variance = self.deviation.powi(2) + row.variance(covariance);
        let mut moved = DVector::zeros(self.parameters.len());
        for &(place, slope) in &row.entries {
            moved.axpy(slope, &covariance.column(place), 1.0);
        }
        covariance.ger(-1.0 / variance, &moved, &moved, 1.0);
    }
}

/// A touch of two receptors in a posture, the lesser limb's receptor first, made ready.
pub fn one(agent: &Agent, receptors: [usize; 2], posture: &[f64]) -> PreparedTouch {
    let set = TouchSet::new(agent.creature(), [imagined(agent.skin(), receptors, posture)]);
    let pair = set.pairs.into_iter().next().expect("one touch makes one pair");
    pair.touches.into_iter().next().expect("and stands in it")
}
