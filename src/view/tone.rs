//! The colour of a verdict by its reliability, on pages and terminals.

use crate::session::LearningRecord;

/// What of a body a verdict stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// All of it.
    Good,
    /// All but for what is named.
    Partly,
    /// Nothing.
    Bad,
}

impl Tone {
    /// That of what is said of a learned body.
    pub fn of(record: &LearningRecord) -> Tone {
        Tone::new(record.converged, record.undetermined.len() + record.undetermined_limbs.len())
    }

    /// That of what was learned, or was not, but for so many joints and limbs.
    pub fn new(converged: bool, undetermined: usize) -> Tone {
        match (converged, undetermined) {
            (true, 0) => Tone::Good,
            (true, _) => Tone::Partly,
            (false, _) => Tone::Bad,
        }
    }

    /// Its class on pages.
    pub(super) fn class(self) -> &'static str {
        match self {
            Tone::Good => "good",
            Tone::Partly => "partly",
            Tone::Bad => "bad",
        }
    }
}
