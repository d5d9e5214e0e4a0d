//! The error during learning, and its bound.

use super::measures::{claimed_deviations, rms};
use super::{HeldOutPoint, held_out, held_out_points};
use crate::agent::Agent;
use crate::ground_truth::GroundTruth;
use crate::learning::Learned;
use crate::learning::observability::Observability;
use crate::schema::BodySchema;

/// The least share of the points that a bound must be over to be one of them all.
const MOST_OF_THEM: f64 = 0.95;

/// Measures schemas at the same points: those that the touches determine in the end.
#[derive(Debug)]
pub struct Progress<'a> {
    agent: &'a Agent,
    truth: &'a GroundTruth,
    learned: &'a Learned,
    points: Vec<HeldOutPoint>,
}

impl<'a> Progress<'a> {
    /// For schemas during learning.
    pub fn new(agent: &'a Agent, truth: &'a GroundTruth, learned: &'a Learned) -> Progress<'a> {
        let determined = |point: &HeldOutPoint| {
            let [a, b] = point.limbs;
            learned.reliable_account().is_some_and(|account| account.claims(a, b))
        };
        let mut points = held_out_points(agent);
        // Where nothing is determined, or the learner cannot tell, all count.
        if points.iter().any(determined) {
            points.retain(determined);
        }
        Progress { agent, truth, learned, points }
    }

    /// Root mean square of a schema's held-out errors, millimetres; `None` if there is no point.
    pub fn error_rms(&self, schema: &BodySchema) -> Option<f64> {
        rms(&held_out(self.agent.creature(), self.truth, schema, &self.points))
    }

    /// The Cramér-Rao bound of the same from touches that determine so much, millimetres; `None` if they leave some of it open.
    pub fn bound_rms(&self, observability: &Observability) -> Option<f64> {
        let (creature, schema) = (self.agent.creature(), &self.learned.schema);
        let account = self.learned.account.as_ref()?;
        let (_, deviations) = claimed_deviations(creature, schema, account, observability, &self.points);
        let most = deviations.len() as f64 >= MOST_OF_THEM * self.points.len() as f64;
        rms(&deviations).filter(|rms| most && rms.is_finite())
    }
}
