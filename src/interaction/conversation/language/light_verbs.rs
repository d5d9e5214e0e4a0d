//! Verbs that say little: "give it a push" is push it, "have a feel of it" is feel it.

use super::slots::{Piece, Sense};

/// Verbs whose action has a noun of the same form; "have a go" and the like repeat, and are left.
const NO_ACTIONS: &[&str] = &[
    "try",
    "go",
    "rest",
    "break",
    "like",
    "be",
    "have",
    "do",
    "can",
    "will",
    "need",
    "want",
    "care",
    "stop",
    "wait",
    "finish",
    "start",
    "quit",
    "end",
    "second",
    "minute",
    "name",
    "place",
    "report",
    "point",
    "pause",
    "memory",
    "guess",
    "count",
    "summary",
    "hand",
    "answer",
    "sit",
    "stand",
    "lie",
    "run",
    "chat",
    "walk",
    "attempt",
    "finger",
    "use",
    "mind",
    "trouble",
    "bother",
    "call",
    "kind",
    "touchdown",
    "clasp",
];

/// "Give it a push", "have a feel of it", "do a sweep": the verb, what it is done to, and how many pieces say so.
pub(super) fn action<'a>(said: &[&'a Piece]) -> Option<(&'a Piece, Option<&'a Piece>, usize)> {
    let is = |k: usize, words: &[&str]| said.get(k).is_some_and(|piece| piece.word.is(words));
    let noun = |k: usize| {
        let verb = |piece: &&&Piece| piece.sense == Sense::Word && piece.word.form.is_base();
        said.get(k).filter(verb).filter(|piece| !piece.word.is(NO_ACTIONS)).copied()
    };
    let article = |k: usize| is(k, &["a", "an", "another", "one", "some"]);
    // "A good long rub".
    let behind = |k: usize| (1..=3).find_map(|by| Some((noun(k + by)?, k + by)));
    let first = said.first()?;
    let names = |piece: &&&Piece| piece.is_body() || matches!(piece.sense, Sense::Thing | Sense::Some);
    let object = said.get(1).filter(names).copied();
    if object.is_some() && is(0, &["give"]) && (article(2) || noun(2).is_some()) {
        let (verb, k) = behind(1)?;
        return Some((verb, object, k + 1));
    }
    if is(0, &["give"]) && article(1) {
        let (verb, k) = behind(1)?;
        return is(k + 1, &["to"]).then_some((verb, None, k + 2));
    }
    let light = first.word.form.is_base() && is(0, &["have", "take", "do", "make", "perform"]);
    let quick = is(0, &["a", "one"]);
    if (light && article(1)) || quick {
        let (verb, k) = behind(usize::from(!quick))?;
        return Some((verb, None, k + 1 + usize::from(is(k + 1, &["of", "at", "on", "to"]))));
    }
    None
}
