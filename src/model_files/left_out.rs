//! What was left out of a file that the engine does not take as it is.

use std::collections::BTreeMap;

/// What was left out of a model's file, each with its number.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LeftOut {
    /// Parts of the body that could not be read.
    pub lost: BTreeMap<String, usize>,
    /// What has nothing to do with where limbs are and what they touch.
    pub unneeded: BTreeMap<String, usize>,
    /// Entries of `<equality>` that couple joints or close the tree, and are not heeded.
    pub unheeded: usize,
    /// What was read otherwise than it stands there, or looks odd, a sentence each.
    pub notes: Vec<String>,
}

impl LeftOut {
    /// Whether nothing was.
    pub fn is_empty(&self) -> bool {
        self.lost.is_empty() && self.unneeded.is_empty()
    }

    pub(crate) fn lose(&mut self, what: impl Into<String>, count: usize) {
        if count > 0 {
            *self.lost.entry(what.into()).or_default() += count;
        }
    }

    pub(crate) fn spare(&mut self, what: impl Into<String>) {
        *self.unneeded.entry(what.into()).or_default() += 1;
    }

    /// What was left out, for a sentence: what is lost of the body by name, all else as a number of kinds; none where
    /// nothing was.
    pub fn in_words(&self) -> Option<String> {
        const SHOWN: usize = 4;
        let kinds = |count: usize, of: &str| match count {
            0 => None,
            1 => Some(format!("1 kind of {of}")),
            count => Some(format!("{count} kinds of {of}")),
        };
        let lost = self.lost.iter().take(SHOWN).map(|(what, count)| counted(what, *count));
        let more = kinds(self.lost.len().saturating_sub(SHOWN), "other part of the body");
        let unneeded = kinds(self.unneeded.len(), "part that a body schema does not need");
        let all: Vec<String> = lost.chain(more).chain(unneeded).collect();
        (!all.is_empty()).then(|| all.join(", "))
    }
}

/// A thing with its number.
fn counted(what: &str, count: usize) -> String {
    if count == 1 { what.to_string() } else { format!("{what} ({count} times)") }
}
