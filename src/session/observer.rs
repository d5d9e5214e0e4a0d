//! Who looks on while an experiment runs: a progress bar, a live page, a table.

use crate::deadline::Deadline;
use crate::learning::growth::Growth;
use crate::schema::BodySchema;
use crate::senses::{RecordedTouch, Touch};

/// Looks on while an experiment runs; every method does nothing unless it is given.
///
/// Nothing that an observer does changes what comes out.
pub trait Observer {
    /// Something that a person should know, in a sentence.
    fn note(&self, _sentence: &str) {}
    /// A phase begins; it lasts until the next one.
    fn phase(&self, _phase: Phase) {}
    /// A touch was made.
    fn touched(&self, _touch: &RecordedTouch) {}
    /// The policy has learned from the touches so far.
    fn grew(&self, _growth: &Growth) {}
    /// A touch was taken in by the learner.
    fn learned(&self, _step: &LearningStep) {}
}

/// Nobody looks on.
impl Observer for () {}

/// Several look on.
impl Observer for Vec<&dyn Observer> {
    fn note(&self, sentence: &str) {
        self.iter().for_each(|observer| observer.note(sentence));
    }

    fn phase(&self, phase: Phase) {
        self.iter().for_each(|observer| observer.phase(phase));
    }

    fn touched(&self, touch: &RecordedTouch) {
        self.iter().for_each(|observer| observer.touched(touch));
    }

    fn grew(&self, growth: &Growth) {
        self.iter().for_each(|observer| observer.grew(growth));
    }

    fn learned(&self, step: &LearningStep) {
        self.iter().for_each(|observer| observer.learned(step));
    }
}

/// A phase of an experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The creature babbles.
    Babbling {
        /// Touches that were there before.
        made: usize,
        /// Touches in all, or where the body grows, the most.
        touches: usize,
        /// Whether it ends automatically when all is known that can be touched.
        grows: bool,
        /// After which it ends in any case.
        deadline: Deadline,
    },
    /// A learner takes in touches.
    Learning {
        /// How many.
        touches: usize,
        /// Whether it learns from each as it comes, and not from all at the end.
        each: bool,
    },
    /// A learner takes in the same touches without the disturbances, for comparison.
    LearningUndisturbed,
    /// The last phase is over.
    Done,
}

/// What a learner has come to with one more touch.
#[derive(Clone, Copy, Debug)]
pub struct LearningStep<'a> {
    /// Touches that it has taken in.
    pub touches: usize,
    /// The last of them.
    pub touch: &'a Touch,
    /// The schema, where there is one at this point.
    pub schema: Option<&'a BodySchema>,
    /// How far apart the schema before had put the surfaces that touched, metres; `None` if the learner predicts nothing.
    pub predicted_gap: Option<f64>,
}
