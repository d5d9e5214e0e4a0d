//! Where a thing is to go, and what a question puts in relation: "10 cm to the left", "relative to your left hand".

use super::body_names::PartName;
use super::gist::MOVING;
use super::patterns::{has, length};
use super::slots::{Piece, Sense};

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
    /// How far, metres; none where that is not told.
    pub by: Option<f64>,
    /// Whether it is told for certain: "to my left" is not, nor "to the left of the box".
    pub clear: bool,
}

/// What tells a side; the last alone only where nothing follows that it could belong to.
const SIDES: &[&str] = &[
    "to|toward|towards ?your|the|my left|right ?hand ?side|edge|end|half|part",
    "leftward|leftwards|rightward|rightwards",
    "on|onto ?your|the|my left|right ?hand ?side|edge|end|half|part",
    "left|right",
];

/// "Push it to the left": the side to which a thing is to be moved, where nothing else tells where.
pub(super) fn sideways(pieces: &mut Vec<Piece>) {
    for k in (0..pieces.len()).rev() {
        let all: Vec<&Piece> = pieces.iter().collect();
        let (before, rest) = all.split_at(k);
        let moves = has(before, MOVING) && has(before, "THING|SOME");
        let Some(taken) = SIDES.iter().find_map(|side| length(rest, side)).filter(|_| moves) else {
            continue;
        };
        let (side, behind) = rest.split_at(taken);
        let ends = side.iter().any(|piece| piece.word.mark.is_some())
            || behind.first().is_none_or(|next| next.sense == Sense::Filler)
            || length(behind, "please|and|then|with|as|using|again").is_some()
            || measure(&behind[length(behind, "?by").unwrap_or(0)..]).is_some();
        let it = before.last().is_some_and(|last| last.word.text == "it");
        let bare = has(side, "^ left|right") && (!ends || has(&before[k.max(1) - 1..], "your|the|my"));
        let told_otherwise = !ends && has(behind, "far|near|away|closer|nearer|farther|back");
        if bare || told_otherwise || has(side, "on|onto") && !it {
            continue;
        }
        let of_another =
            has(behind, "^ of") && !has(behind, "^ of ?the|your table|tabletop|desk|you|yourself");
        let measured = (0..all.len()).find_map(|at| measure(&all[at..]));
        let aside = Aside {
            left: has(side, "left|leftward|leftwards"),
            by: measured.flatten(),
            clear: !has(side, "my") && !has(before, "or|nor $") && !of_another && measured != Some(None),
        };
        let word = side.last().map(|last| last.word.clone());
        let words = side.iter().flat_map(|piece| piece.words.clone()).collect();
        let piece = word.map(|word| Piece { sense: Sense::Side(aside), word, words, requested: false });
        pieces.splice(k..k + taken, piece);
    }
}

/// A length that pieces begin with, metres: "10 centimetres"; `Some(None)` where it is one and cannot be told.
fn measure(pieces: &[&Piece]) -> Option<Option<f64>> {
    let [number, unit, ..] = pieces else { return None };
    let (_, length) = UNITS.iter().find(|(words, _)| unit.word.is(words))?;
    Some(number.word.text.parse().ok().map(|number: f64| number * length))
}

/// Units of length, metres.
const UNITS: [(&[&str], f64); 5] = [
    (&["centimetres", "centimetre", "centimeters", "cm"], 0.01),
    (&["metres", "metre", "meter", "meters"], 1.0),
    (&["millimetres", "millimetre", "mm"], 0.001),
    (&["inches", "inch"], 0.0254),
    (&["feet", "foot"], 0.3048),
];

/// Words that put one place in relation to another, some of them right before the place to which.
const RELATING: &str = "from|relative|respect|relation|compare|than|above|below|under|beneath|underneath|over|behind|beside|between|apart|away|off|near|nearer|close|closer|next|distance|gap|front|reference|perspective|viewpoint";
const TO_WHICH: &str =
    "from|to|than|above|below|under|beneath|underneath|over|behind|beside|off|near|with|of|by";

/// What a question puts in relation, and to which parts of the body: "how far is it from your nose?", "where is your right
/// elbow relative to your left hand?"
pub(super) fn related(pieces: &[Piece]) -> Option<(End, Vec<PartName>)> {
    let said: Vec<&Piece> = pieces.iter().filter(|piece| piece.sense != Sense::Filler).collect();
    if !(has(&said, RELATING) || has(&said, "left|right|side of")) {
        return None;
    }
    let thing = said.iter().any(|piece| piece.sense == Sense::Thing && !piece.is_stick());
    let parts: Vec<(usize, &PartName)> = said
        .iter()
        .enumerate()
        .filter_map(|(k, piece)| match &piece.sense {
            Sense::Hand(part) | Sense::Part(part) => Some((k, part)),
            _ => None,
        })
        .collect();
    let to_which = |k: usize| k > 0 && has(&said[k - 1..k], TO_WHICH);
    let (what, to) = match parts.as_slice() {
        [_, ..] if thing => (End::Thing, parts.iter().map(|(_, part)| *part).collect()),
        // "How far apart are your hands?"
        [(_, both)] if has(&said, "apart|between|each") => (End::Part((*both).clone()), vec![*both]),
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

/// All words of these lists.
pub(super) fn words() -> impl Iterator<Item = &'static str> {
    let units = UNITS.iter().flat_map(|(words, _)| words.iter().copied());
    RELATING.split('|').chain(units)
}
