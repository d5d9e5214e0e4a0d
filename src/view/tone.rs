//! The colour of a verdict by its reliability, on pages and terminals.

use crate::named::named;
use crate::session::LearningRecord;

named! {
    "tone",
    /// What of a body a verdict stands for.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Tone {
        /// All of it.
        Good = "good",
        /// All but for what is named.
        Partly = "partly",
        /// Nothing.
        Bad = "bad",
    }
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
}
