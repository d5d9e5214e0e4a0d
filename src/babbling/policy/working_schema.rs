//! The schema that a policy aims by, learned anew now and then.

use crate::learning::Learner;
use crate::schema::BodySchema;
use crate::senses::Touch;

/// Touches at which a schema is learned at first.
const FIRST: [usize; 6] = [20, 30, 42, 56, 72, 90];
/// After these the count grows by this share until the learner says that it has converged …
const GROWTH: f64 = 1.15;
/// … and by this one from then on.
const CONVERGED_GROWTH: f64 = 1.5;
/// What a schema is taken to be wrong by where its learner does not say, metres.
const UNKNOWN_DEVIATION: f64 = 0.02;

/// A learner, when to ask it, and what it said last.
pub struct WorkingSchema<'a> {
    learner: Box<dyn Learner + 'a>,
    schema: Option<BodySchema>,
    deviation: f64,
    converged: bool,
    touches: usize,
    due: usize,
}

impl<'a> WorkingSchema<'a> {
    /// No schema yet, and the learner that will give one.
    pub fn new(learner: Box<dyn Learner + 'a>) -> WorkingSchema<'a> {
        WorkingSchema {
            learner,
            schema: None,
            deviation: UNKNOWN_DEVIATION,
            converged: false,
            touches: 0,
            due: FIRST[0],
        }
    }

    /// Takes a touch; whether it brought a new schema.
    pub fn touched(&mut self, touch: &Touch) -> bool {
        self.learner.touch(touch);
        self.touches += 1;
        if self.touches < self.due {
            return false;
        }
        let learned = self.learner.learn();
        self.converged = learned.verdict.converged();
        self.deviation = learned.deviation.unwrap_or(UNKNOWN_DEVIATION);
        self.schema = Some(learned.schema);
        let growth = if self.converged { CONVERGED_GROWTH } else { GROWTH };
        let grown = (self.touches as f64 * growth).ceil() as usize;
        let first = FIRST.into_iter().find(|&count| count > self.touches && !self.converged);
        self.due = first.unwrap_or(grown);
        true
    }

    /// The schema; none before enough touches.
    pub fn schema(&self) -> Option<&BodySchema> {
        self.schema.as_ref()
    }

    /// By how much the schema was wrong about the gaps of touches that it had not seen, metres.
    pub fn deviation(&self) -> f64 {
        self.deviation
    }

    /// Whether the learner takes its schema for right.
    pub fn converged(&self) -> bool {
        self.converged
    }
}
