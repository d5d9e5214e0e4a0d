//! Where a thing is to go, and what a question puts in relation: "10 cm to the left", "relative to your left hand".

use super::names::PartName;
use super::patterns::{has, length};
use super::pieces::{Piece, Sense};

/// What a question puts in relation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum End {
    /// The thing of which they talk.
    Thing,
    /// A part of its body.
    Part(PartName),
}

/// To which side a thing is to be moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aside {
    /// To its left, or to its right.
    pub left: bool,
    /// How far, metres; `None` if that is not said.
    pub by: Option<f64>,
    /// Whether it is unambiguous: "to my left" is not, nor "to the left of the box".
    pub clear: bool,
}

/// What names a side; the last alone only where nothing follows that it could belong to.
const SIDES: &[&str] = &[
    "to|toward|towards ?your|the|my left|right ?hand ?side|edge|end|half|part",
    "leftward|leftwards|rightward|rightwards",
    "on|onto ?your|the|my left|right ?hand ?side|edge|end|half|part",
    "left|right",
];
/// Verbs that move a thing.
pub(super) const MOVES: &str = "PUT|PUSH|PULL|take|get|keep|make|give|want|bring";

/// "Push it to the left": the side to which a thing is to be moved, where nothing else tells where.
pub(super) fn sideways(pieces: &mut Vec<Piece>) {
    for k in (0..pieces.len()).rev() {
        let (before, rest) = pieces.split_at(k);
        if rest[0].is("a an the") {
            continue;
        }
        let Some(taken) = SIDES.iter().find_map(|side| length(rest, side)) else { continue };
        let moves = has(before, MOVES) || before.iter().any(|piece| piece.wanted.is_some());
        // "To the right with it."
        let with = length(&rest[taken..], "with THING|SOME").is_some();
        // "A bit more to the left."
        let more = has(before, "BIT|MORE|FAR") && length(before, "?a ?BIT ?BIT ?MORE ?FAR $").is_some();
        if !(moves && has(before, "THING|SOME") || with && before.is_empty() || more) {
            continue;
        }
        let (side, behind) = rest.split_at(taken);
        let ends = side.iter().any(|piece| piece.word.mark.is_some())
            || behind.is_empty()
            || length(behind, "and|then|with|as|using|again|BIT|a|some|to|!ANY").is_some()
                && !has(side, "to|on")
            || length(behind, "and|then|with|as|using|again|a|some").is_some()
            || measure(&behind[length(behind, "?by").unwrap_or(0)..]).is_some();
        // "Right to the end" is no side.
        let straight = has(side, "^ right") && has(behind, "^ to|on|up|next|at|in|over|down|off|away");
        let it = before.last().is_some_and(|last| last.word.text == "it");
        let bare = has(side, "^ left|right")
            && (!ends || has(&before[before.len().saturating_sub(1)..], "your|the|my"));
        let elsewhere = !ends && has(behind, "FAR|NEAR|BACK");
        let placed = it || ends && has(before, "put|place|set|lay|position|stand THING $");
        if bare || straight || elsewhere || has(side, "on|onto") && !placed {
            continue;
        }
        let measured = (0..pieces.len()).find_map(|at| measure(&pieces[at..]));
        let of_another = has(behind, "^ of") && !has(behind, "^ of ?the|your TABLE|you|yourself");
        let clear = !has(side, "my") && !has(before, "or|nor $") && !of_another && measured != Some(None);
        let aside = Aside { left: has(side, "left|leftward|leftwards"), by: measured.flatten(), clear };
        let words: Vec<_> = side.iter().map(|piece| piece.word.clone()).collect();
        pieces.splice(k..k + taken, Piece::new(Sense::Side(aside), &words));
    }
}

/// Units of length, metres.
const UNITS: [(&str, f64); 5] = [
    ("centimetres centimetre centimeters centimeter cm", 0.01),
    ("metres metre meter meters", 1.0),
    ("millimetres millimetre mm", 0.001),
    ("inches inch", 0.0254),
    ("feet foot", 0.3048),
];

/// A length that pieces begin with, metres: "10 centimetres"; `Some(None)` if its number is unknown.
fn measure(pieces: &[Piece]) -> Option<Option<f64>> {
    let [number, unit, ..] = pieces else { return None };
    let (_, metres) = UNITS.iter().find(|(words, _)| unit.word.is(words))?;
    Some(number.word.text.parse().ok().map(|number: f64| number * metres))
}

/// Words that put one place in relation to another, some of them right before the place to which.
const RELATING: &str = "from|relative|respect|relation|compare|compared|reference|perspective|viewpoint|than|above|below|lower|higher|under|\
    beneath|underneath|over|behind|beside|between|apart|away|off|near|nearer|close|closer|next|distance|gap|front";
const TO_WHICH: &str =
    "from|to|than|above|below|under|beneath|underneath|over|behind|beside|off|near|with|of|by";

/// What a question puts in relation, and to which parts of the body: "how far is it from your nose?", "where is your right
/// elbow relative to your left hand?"
pub(super) fn related(pieces: &[Piece]) -> Option<(End, Vec<PartName>)> {
    if !(has(pieces, RELATING) || has(pieces, "left|right|side of")) {
        return None;
    }
    let thing = pieces.iter().any(|piece| piece.sense == Sense::Thing && !piece.is_stick());
    let parts: Vec<(usize, &PartName)> =
        pieces.iter().enumerate().filter_map(|(k, piece)| Some((k, piece.part()?))).collect();
    let to_which = |k: usize| k > 0 && has(&pieces[k - 1..k], TO_WHICH);
    let (what, to) = match parts.as_slice() {
        [_, ..] if thing => (End::Thing, parts.iter().map(|(_, part)| *part).collect()),
        // "How far apart are your hands?"
        [(_, both)] if has(pieces, "apart|between|each") => (End::Part((*both).clone()), vec![*both]),
        // "Relative to your left hand, where is your right elbow?"
        [(k, to), (j, part)] if to_which(*k) && !to_which(*j) => (End::Part((*part).clone()), vec![*to]),
        [(_, part), (_, to)] => (End::Part((*part).clone()), vec![*to]),
        _ => return None,
    };
    Some((what, to.into_iter().cloned().collect()))
}

/// The side to which a thing is to be moved.
pub(super) fn aside(pieces: &[Piece]) -> Option<Aside> {
    pieces.iter().find_map(|piece| match piece.sense {
        Sense::Side(aside) => Some(aside),
        _ => None,
    })
}
