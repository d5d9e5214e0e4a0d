//! Leave to move: only words that ask for it or a "yes" to a question of its own give it; all requests that move take one.

use super::{Intent, Understood};

/// Leave to move.
#[derive(Debug)]
pub struct Leave(());

impl Leave {
    /// Leave for a request is leave for what it asks to be done again.
    pub(in crate::interaction::conversation) fn again(&self) -> Leave {
        Leave(())
    }

    /// The leave that words give that are understood and ask for something to be done.
    pub(super) fn by_words(asked: bool) -> Option<Leave> {
        asked.then_some(Leave(()))
    }

    /// The leave that "yes" gives where it was asked whether it should.
    pub(in crate::interaction::conversation) fn by_yes(answer: &Understood) -> Option<Leave> {
        (answer.intent == Intent::Yes && !answer.forbids).then_some(Leave(()))
    }
}
