//! Leave to move: only a command, a polite request, or a question that feeling about alone can answer gives it, and a
//! "yes" to a question of its own, or a touch; all that moves takes one. There is no other way to have one from words.

use super::mood::Mood;

/// Leave to move. Only what a partner wants gives it: a command, a polite request, a "yes" to a question whether he wants
/// it, or a touch.
#[derive(Debug)]
pub struct Leave(());

impl Leave {
    /// Leave for a request is leave for what it asks to be done again.
    pub(in crate::interaction::conversation) fn again(&self) -> Leave {
        Leave(())
    }

    /// The leave that a touch of the skin gives: to put a hand there.
    pub(in crate::interaction::conversation) fn by_touch() -> Leave {
        Leave(())
    }

    /// The leave that words give; none unless all of them are understood and they ask for something to be done.
    pub(super) fn by_words(mood: Mood, whole: bool, forbidden: bool) -> Option<Leave> {
        let asked = matches!(mood, Mood::Command | Mood::Polite | Mood::Search);
        (asked && whole && !forbidden).then_some(Leave(()))
    }

    /// The leave that "yes" gives where it was asked whether it should.
    pub(in crate::interaction::conversation) fn by_yes(answer: &super::Understood) -> Option<Leave> {
        (answer.intent == super::Intent::Yes && !answer.forbids).then_some(Leave(()))
    }
}
