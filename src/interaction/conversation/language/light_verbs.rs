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
pub(super) fn action<'a>(said: &[&'a Piece]) -> Option<(&'a Piece, Vec<&'a Piece>, usize)> {
    let noun = |k: usize| {
        said.get(k).filter(|piece| {
            piece.sense == Sense::Word && piece.word.form.is_base() && !piece.word.is(NO_ACTIONS)
        })
    };
    let article =
        |k: usize| said.get(k).is_some_and(|piece| piece.word.is(&["a", "an", "another", "one", "some"]));
    let behind = |k: usize| (1..=3).map(|by| k + by).find(|&k| noun(k).is_some());
    let first = said.first()?;
    let object =
        said.get(1).filter(|piece| piece.is_body() || matches!(piece.sense, Sense::Thing | Sense::Some));
    if let Some(object) = object
        && first.word.is(&["give"])
        && (article(2) || noun(2).is_some())
    {
        let k = behind(1)?;
        return Some((noun(k)?, vec![object], k + 1));
    }
    if first.word.is(&["give"]) && article(1) {
        let k = behind(1)?;
        let to = said.get(k + 1).filter(|piece| piece.word.is(&["to"]))?;
        let _ = to;
        return Some((noun(k)?, Vec::new(), k + 2));
    }
    let light = first.word.form.is_base() && first.word.is(&["have", "take", "do", "make", "perform"]);
    let quick = first.word.is(&["a", "one"]);
    if (light && article(1)) || quick {
        let k = behind(usize::from(!quick))?;
        let taken =
            k + 1 + usize::from(said.get(k + 1).is_some_and(|next| next.word.is(&["of", "at", "on", "to"])));
        return Some((noun(k)?, Vec::new(), taken));
    }
    None
}
