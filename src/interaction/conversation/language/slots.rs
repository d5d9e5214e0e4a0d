//! What an utterance names beside what is wanted: a thing, which of several, a hand, a part of the body.

use super::body_names::{BodyNames, PartName};
use super::fillers::{FILLERS, filling};
use super::forbidding::facts;
use super::noun_phrases::noun_phrase;
use super::places::{Aside, sideways};
use super::words::Word;

/// Which of several things is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    /// The one on the left …
    Left,
    /// … or on the right.
    Right,
    /// The nearest …
    Nearest,
    /// … or farthest one.
    Farthest,
    /// The one that was found first …
    First,
    /// … second …
    Second,
    /// … third …
    Third,
    /// … or last.
    Last,
    /// Not the one of which they talk.
    Other,
}

/// Which hand is to do it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HandName {
    /// The left one.
    Left,
    /// The right one.
    Right,
    /// Not the one that did something before, or touches it now.
    Other,
}

/// What a stretch of words stands for.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Sense {
    /// A word as it is.
    Word,
    /// One that says nothing by itself: "please", "now".
    Filler,
    /// A thing that is known: "it", "the box", "the nearer one".
    Thing,
    /// Some thing: "something", "an object".
    Some,
    /// A hand of its own.
    Hand(PartName),
    /// Another part of its body.
    Part(PartName),
    /// The side to which a thing is to be moved: "to the left".
    Side(Aside),
}

/// A stretch of words and what it stands for.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Piece {
    pub sense: Sense,
    /// Its last word.
    pub word: Word,
    pub words: Vec<String>,
    /// Whether a frame says that it is wanted: "it would be nice if you …".
    pub requested: bool,
}

impl Piece {
    /// Whether it is a stick, known or not.
    pub fn is_stick(&self) -> bool {
        matches!(self.sense, Sense::Thing | Sense::Some) && self.words.iter().any(|word| word == "stick")
    }

    pub fn is_body(&self) -> bool {
        matches!(self.sense, Sense::Hand(_) | Sense::Part(_))
    }
}

/// The pieces of an utterance.
pub(super) fn pieces(words: &[Word], names: &BodyNames) -> Vec<Piece> {
    let mut pieces = Vec::new();
    let mut k = 0;
    while k < words.len() {
        // What a mark ends does not go on behind it.
        let end = (k..words.len()).find(|&j| words[j].mark.is_some()).map_or(words.len(), |j| j + 1);
        let (sense, length) = sense_of(&words[k..end], names, pieces.last());
        let stretch = &words[k..k + length];
        pieces.push(Piece {
            sense,
            word: stretch[length - 1].clone(),
            words: stretch.iter().map(|word| word.text.clone()).collect(),
            requested: false,
        });
        k += length;
    }
    referred(&mut pieces);
    facts(&mut pieces);
    sideways(&mut pieces);
    pieces
}

/// "Your chin: touch it." It is the part of the body that was named by itself before, where no thing was.
fn referred(pieces: &mut [Piece]) {
    let mut named: Option<PartName> = None;
    for k in 0..pieces.len() {
        match &pieces[k].sense {
            Sense::Part(part) => {
                let ends = pieces[k].word.mark.is_some();
                let told = pieces[..k].iter().any(|piece| {
                    piece.sense == Sense::Word
                        && piece.word.form.is_base()
                        && !piece.word.is(&["be", "do", "have"])
                });
                named = (ends && !told).then(|| part.clone());
            }
            Sense::Thing if pieces[k].word.text == "it" => {
                if let Some(part) = &named {
                    pieces[k].sense = Sense::Part(part.clone());
                }
            }
            Sense::Thing | Sense::Some => named = None,
            _ => {}
        }
    }
}

fn sense_of(words: &[Word], names: &BodyNames, before: Option<&Piece>) -> (Sense, usize) {
    let texts: Vec<&str> = words.iter().map(|word| word.text.as_str()).collect();
    let mine = before.is_some_and(|piece| piece.word.is(&["my", "our", "her", "their"]));
    if let Some((part, length)) = names.at(&texts).filter(|_| !mine) {
        let article = before.is_some_and(|piece| piece.word.is(&["a", "an"]));
        if !article {
            return (if part.is_hand() { Sense::Hand(part) } else { Sense::Part(part) }, length);
        }
    }
    if let Some(hand) = bare_hand(&texts, words, before) {
        return hand;
    }
    if let Some(length) = filling(&texts) {
        return (Sense::Filler, length);
    }
    if let Some(found) = noun_phrase(words, before) {
        return found;
    }
    let filler = words[0].is(FILLERS);
    (if filler { Sense::Filler } else { Sense::Word }, 1)
}

/// "A hand on", and "left" where it is a hand: "with your left", "but left".
fn bare_hand(texts: &[&str], words: &[Word], before: Option<&Piece>) -> Option<(Sense, usize)> {
    const ONTO: [&str; 14] = [
        "on", "onto", "over", "to", "across", "along", "around", "round", "through", "against", "upon", "in",
        "under", "behind",
    ];
    let hand =
        |words: &[&str]| Sense::Hand(PartName { words: words.iter().map(|word| word.to_string()).collect() });
    if let ["a" | "one", noun @ ("hand" | "finger" | "palm" | "fingertip" | "arm"), next, ..] = texts
        && ONTO.contains(next)
    {
        return Some((hand(&[noun]), 2));
    }
    let owned = usize::from(matches!(texts.first(), Some(&"your" | &"the")));
    let side = texts.get(owned).filter(|side| ["left", "right"].contains(side))?;
    let ends = words[owned].mark.is_some()
        || texts
            .get(owned + 1)
            .is_none_or(|next| ["this", "please", "now", "instead", "and", "again", "to"].contains(next));
    let by = before.is_some_and(|piece| piece.word.is(&["with", "use", "by", "but", "via", "try"]));
    (by && ends).then(|| (hand(&[side, "hand"]), owned + 1))
}

/// Which of several things pieces tell.
pub(super) fn which(pieces: &[Piece]) -> Option<Which> {
    let mut told = None;
    for (k, piece) in pieces.iter().enumerate() {
        let thing = piece.sense == Sense::Thing;
        let beside = ["on", "to"].iter().any(|on| k >= 2 && pieces[k - 2].word.text == *on)
            || (k >= 1
                && piece.words.first().is_some_and(|first| first == "the")
                && pieces[k - 1].word.is(&["on", "to", "at"]));
        let ordinal = piece.word.is(&["first", "last"]);
        let picks = thing || piece.sense == Sense::Word && (beside || ordinal);
        if !picks {
            continue;
        }
        let has = |words: &[&str]| piece.words.iter().any(|word| words.contains(&word.as_str()));
        let this = match () {
            () if has(&["nearer", "nearest", "closer", "closest", "near", "close"]) => Some(Which::Nearest),
            () if has(&["farther", "farthest", "further", "furthest", "far"]) => Some(Which::Farthest),
            () if has(&["left", "leftmost"]) => Some(Which::Left),
            () if has(&["right", "rightmost"]) => Some(Which::Right),
            () if has(&["first", "former"]) => Some(Which::First),
            () if has(&["second"]) => Some(Which::Second),
            () if has(&["third"]) => Some(Which::Third),
            () if has(&["last", "latter", "latest"]) => Some(Which::Last),
            () if has(&["other", "another"]) => Some(Which::Other),
            () => None,
        };
        told = told.or(this);
    }
    told
}

/// Whether something is to be done with a stick: "with the stick", "use your stick".
pub(super) fn with_stick(pieces: &[Piece]) -> bool {
    (1..pieces.len()).any(|k| pieces[k].is_stick() && pieces[k - 1].word.is(&["with", "use", "by", "your"]))
}

/// Which hand a hand's name tells.
pub(super) fn hand_of(part: &PartName) -> Option<HandName> {
    match () {
        () if part.has("left") => Some(HandName::Left),
        () if part.has("right") => Some(HandName::Right),
        () if part.has("other") => Some(HandName::Other),
        () => None,
    }
}

/// The hand that is to do something, and the part of the body that it is about.
pub(super) fn hand_and_part(pieces: &[Piece], intent: super::Intent) -> (Option<HandName>, Option<PartName>) {
    use super::Intent;
    let body: Vec<(usize, &PartName, bool)> = pieces
        .iter()
        .enumerate()
        .filter_map(|(k, piece)| match &piece.sense {
            Sense::Hand(part) => Some((k, part, true)),
            Sense::Part(part) => Some((k, part, false)),
            _ => None,
        })
        .collect();
    let mentioned = body.iter().filter(|(.., acts)| *acts).find_map(|(_, part, _)| hand_of(part));
    match intent {
        Intent::WhereOwn => (None, body.first().map(|(_, part, _)| (*part).clone())),
        Intent::TouchOwn => {
            let before = |k: usize, words: &[&str]| k >= 1 && pieces[k - 1].word.is(words);
            let after = |k: usize, words: &[&str]| pieces.get(k + 1).is_some_and(|next| next.word.is(words));
            const ONTO: &[&str] = &["on", "onto", "to", "against", "at"];
            let acts = |&(k, _, hand): &(usize, &PartName, bool)| {
                hand && (before(k, &["with", "by", "use"])
                    || (k >= 1 && pieces[k - 1].word.text == "using")
                    || after(k, ONTO)
                    || (after(k + 1, ONTO) && pieces[k + 1].word.form.is_base()))
            };
            let by = body.iter().find(|part| acts(part)).filter(|_| body.len() > 1);
            let part = body.iter().find(|part| by.is_none_or(|by| by.0 != part.0) && !part.2);
            let part = part.or(body.iter().find(|part| by.is_none_or(|by| by.0 != part.0)));
            let hand = by.and_then(|(_, part, _)| hand_of(part)).or_else(|| {
                let others = body.iter().filter(|other| other.2 && part.is_none_or(|part| part.0 != other.0));
                others.filter_map(|(_, part, _)| hand_of(part)).next()
            });
            (hand, part.map(|(_, part, _)| (*part).clone()))
        }
        _ => (mentioned, None),
    }
}
