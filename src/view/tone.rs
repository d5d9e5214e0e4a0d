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
    /// That of what was learned.
    pub fn of(record: &LearningRecord) -> Tone {
        match record.undetermined.is_empty() && record.undetermined_limbs.is_empty() {
            _ if !record.converged => Tone::Bad,
            true => Tone::Good,
            false => Tone::Partly,
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
