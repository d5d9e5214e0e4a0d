//! What an utterance names beside what is wanted: a thing, which of several, a hand, a part of the body.

use super::body_names::{BodyNames, PartName};
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
    pub fn is_body(&self) -> bool {
        matches!(self.sense, Sense::Hand(_) | Sense::Part(_))
    }
}

/// Words that say nothing by themselves, in their dictionary form.
const FILLERS: &[&str] = &[
    "please",
    "kindly",
    "just",
    "really",
    "actually",
    "gently",
    "softly",
    "carefully",
    "slowly",
    "quickly",
    "fast",
    "um",
    "uh",
    "er",
    "ah",
    "oh",
    "hmm",
    "max",
    "buddy",
    "friend",
    "mate",
    "sir",
    "dear",
    "pal",
    "dude",
    "man",
    "perhaps",
    "maybe",
    "possibly",
    "now",
    "immediately",
    "instantly",
    "simply",
    "quietly",
    "calmly",
    "properly",
    "nicely",
    "lightly",
    "firmly",
    "quite",
    "rather",
    "pretty",
    "so",
    "also",
    "currently",
    "presently",
    "roughly",
    "approximately",
    "anyway",
    "wow",
    "lol",
    "haha",
    "very",
    "even",
    "directly",
    "soon",
    "today",
    "only",
    "safely",
    "steadily",
    "umm",
    "gladly",
    "promptly",
    "meanwhile",
    "hypothetically",
    "bud",
    "champ",
    "chum",
    "bro",
    "honey",
    "sweetie",
    "mister",
    "darling",
];
/// Phrases that say nothing by themselves.
const FILLING: &[&str] = &[
    "for me",
    "for us",
    "right now",
    "at the moment",
    "a little bit",
    "a bit",
    "a little",
    "by the way",
    "by any chance",
    "if possible",
    "right away",
    "straight away",
    "as well",
    "this time",
    "at once",
    "for now",
    "go ahead and",
    "i think",
    "i guess",
    "i suppose",
    "in fact",
    "come on",
    "go on",
    "hey there",
    "right here",
    "would you please",
    "at all",
    "be a dear and",
    "one more thing",
    "next",
    "first of all",
    "at your leisure",
    "in the meantime",
    "kind of",
    "sort of",
    "a lot",
    "be careful and",
    "to me please",
    "for a moment",
    "for a second",
    "for a minute",
    "for a while",
    "a moment",
    "hurry up and",
];
/// What a thing may be called that it felt and cannot see.
const THINGS: &[&str] = &[
    "thing",
    "things",
    "object",
    "objects",
    "item",
    "items",
    "stuff",
    "obstacle",
    "obstacles",
    "ball",
    "box",
    "can",
    "bottle",
    "brick",
    "block",
    "cup",
    "mug",
    "glass",
    "bowl",
    "plate",
    "jar",
    "tin",
    "book",
    "pen",
    "pencil",
    "spoon",
    "fork",
    "knife",
    "stick",
    "rod",
    "toy",
    "apple",
    "orange",
    "banana",
    "phone",
    "key",
    "keys",
    "cans",
    "bottles",
    "boxes",
    "blocks",
    "cups",
    "balls",
    "bricks",
    "pot",
    "vase",
    "tray",
    "lamp",
    "tool",
    "gadget",
    "thingy",
    "thingie",
    "thingamajig",
    "whatsit",
    "package",
    "parcel",
    "carton",
    "tube",
    "cone",
    "die",
    "dice",
    "egg",
    "candle",
    "camera",
    "watch",
    "cube",
    "cylinder",
    "sphere",
    "one",
    "ones",
];
const PRONOUNS: &[&str] = &["it", "this", "that", "them", "these", "those"];
const INDEFINITE: &[&str] = &["something", "anything", "someone", "somebody", "anybody", "anyone"];
const DETERMINERS: &[&str] = &[
    "the",
    "this",
    "that",
    "these",
    "those",
    "a",
    "an",
    "some",
    "any",
    "another",
    "every",
    "all",
    "both",
    "each",
    "one",
    "more",
    "other",
    "which",
    "whichever",
    "two",
    "three",
];
const ADJECTIVES: &[&str] = &[
    "left",
    "right",
    "near",
    "nearer",
    "nearest",
    "close",
    "closer",
    "closest",
    "far",
    "farther",
    "farthest",
    "further",
    "furthest",
    "big",
    "bigger",
    "biggest",
    "large",
    "larger",
    "small",
    "smaller",
    "little",
    "long",
    "tall",
    "short",
    "round",
    "square",
    "hard",
    "soft",
    "light",
    "heavy",
    "first",
    "second",
    "third",
    "last",
    "latest",
    "other",
    "same",
    "new",
    "old",
    "nice",
    "whole",
    "entire",
    "single",
    "next",
    "remaining",
    "opposite",
    "front",
    "back",
    "flat",
    "smooth",
    "different",
    "middle",
    "rightmost",
    "leftmost",
    "latter",
    "former",
    "hand",
    "more",
];

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

fn filling(texts: &[&str]) -> Option<usize> {
    let begins = |phrase: &&&str| {
        let words: Vec<&str> = phrase.split(' ').collect();
        texts.len() >= words.len() && words.iter().zip(texts).all(|(a, b)| a == b)
    };
    FILLING.iter().filter(begins).map(|phrase| phrase.split(' ').count()).max()
}

/// A thing, or some thing, that words begin with, and of how many words.
fn noun_phrase(words: &[Word], before: Option<&Piece>) -> Option<(Sense, usize)> {
    let is = |k: usize, list: &[&str]| words.get(k).is_some_and(|word| list.contains(&word.text.as_str()));
    if is(0, INDEFINITE) {
        let more = 1 + usize::from(is(1, &["else", "new", "more", "other"]));
        return Some((Sense::Some, more + relative_clause(&words[more.min(words.len())..])));
    }
    if is(0, &["whatever", "whichever"]) {
        let clause = relative_clause(&words[1..]);
        let be = is(1, &["was", "is", "comes", "gets", "moves"]);
        let clause = if clause == 0 && be { 1 + to_the_end(&words[1..], 1) } else { 1 + clause };
        return (clause > 1).then_some((Sense::Thing, clause));
    }
    // "That you …" begins a clause.
    if is(0, &["that"]) && is(1, &["you", "i", "we"]) && words[0].mark.is_none() {
        return None;
    }
    // "How large" asks.
    if before.is_some_and(|piece| piece.word.is(&["how"])) && is(0, ADJECTIVES) {
        return None;
    }
    let mut k = 0;
    while is(k, DETERMINERS) {
        k += 1;
    }
    // "The one", not "one thing".
    if k > 1 && is(k - 1, &["one"]) && !is(k, ADJECTIVES) && !is(k, THINGS) {
        k -= 1;
    }
    let determined = k;
    while is(k, ADJECTIVES) {
        k += 1;
    }
    // "The can" is a thing, "can you" is not; "which one" asks.
    let noun =
        is(k, THINGS) && (determined > 0 || !is(k, &["can", "one", "watch", "die", "key", "glass", "tin"]));
    if noun && !is(0, &["which", "whichever"]) {
        let plural = words[k].text.ends_with('s') && !is(k, &["glass"]);
        let definite =
            (0..determined).any(|j| is(j, &["the", "this", "that", "these", "those", "both", "all"]));
        let vague = (0..determined).any(|j| is(j, &["a", "an", "any", "some", "another", "more"]));
        let bare = determined == 0 && plural;
        let length = k + 1 + relative_clause(&words[k + 1..]);
        return Some((if definite || !(vague || bare) { Sense::Thing } else { Sense::Some }, length));
    }
    // "The nearer", "the second".
    if determined > 0 && k > determined && is(0, &["the"]) && !is(k - 1, &["back", "front", "hand", "middle"])
    {
        let ends = k == words.len()
            || words[k - 1].mark.is_some()
            || is(k, &["please", "with", "to", "from", "away", "now", "you", "me", "over", "there"]);
        let side = is(k - 1, &["left", "right"])
            && before.is_some_and(|piece| piece.word.is(&["on", "to", "at", "from"]));
        if ends && !side {
            return Some((Sense::Thing, k));
        }
    }
    let pronoun = is(0, PRONOUNS) && (is(0, &["it", "them"]) || !is(1, &["a", "an", "the"]));
    pronoun.then_some((Sense::Thing, 1))
}

/// How many words of what follows a thing tell which it is: "that you found first", "you have felt", "that comes near".
fn relative_clause(words: &[Word]) -> usize {
    if let [that, verb, ..] = words
        && that.is(&["that", "which", "who"])
        && that.mark.is_none()
        && verb.text != "is"
        && verb.form == super::lexicon::Form::Third
    {
        return to_the_end(words, 1);
    }
    const MOST: [&str; 5] = ["nearest", "closest", "farthest", "furthest", "next"];
    if let [most, ..] = words
        && most.is(&MOST)
    {
        let whom = |k: usize| words.get(k).is_some_and(|word| word.is(&["you", "me", "away"]));
        let to = usize::from(words.get(1).is_some_and(|word| word.is(&["to", "from"])) && whom(2));
        return 1 + to + usize::from(whom(1 + to));
    }
    if let [that, be, place, ..] = words
        && that.is(&["that", "which"])
        && be.is(&["be"])
        && place.is(&[
            "on", "at", "near", "nearest", "nearer", "closest", "close", "far", "farthest", "farther", "to",
            "in", "there", "closer",
        ])
    {
        return to_the_end(words, 2);
    }
    let mut k = usize::from(words.first().is_some_and(|word| word.is(&["that", "which"])));
    let you = words.get(k).is_some_and(|word| word.is(&["you"]));
    k += 1;
    k += usize::from(words.get(k).is_some_and(|word| word.text == "have"));
    k += usize::from(words.get(k).is_some_and(|word| word.is(&["just", "already", "first", "last"])));
    let felt = ["find", "feel", "touch", "discover", "meet", "detect", "notice", "hold", "know"];
    let verb = words.get(k).is_some_and(|word| word.is(&felt) && word.form == super::lexicon::Form::Past);
    if !you || !verb {
        return 0;
    }
    k + 1
        + words[k + 1..]
            .iter()
            .take_while(|word| word.is(&["first", "last", "before", "just", "so", "far", "earlier"]))
            .count()
}

/// How many words there are to the end of a clause, from one on.
fn to_the_end(words: &[Word], from: usize) -> usize {
    let ends = |k: usize| words[k].mark.is_some() || k + 1 == words.len();
    let parts = |k: usize| {
        words[k].is(&["with", "by", "and", "then", "please", "or", "but"]) || words[k].text == "using"
    };
    (from..words.len()).find(|&k| ends(k) || parts(k)).map_or(from, |k| if parts(k) { k } else { k + 1 })
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

/// Which hand a hand's name tells.
pub(super) fn hand_of(part: &PartName) -> Option<HandName> {
    match () {
        () if part.has("left") => Some(HandName::Left),
        () if part.has("right") => Some(HandName::Right),
        () if part.has("other") => Some(HandName::Other),
        () => None,
    }
}

/// All words of these lists.
pub(super) fn words() -> impl Iterator<Item = &'static str> {
    let filling = FILLING.iter().flat_map(|phrase| phrase.split(' '));
    [FILLERS, THINGS, PRONOUNS, INDEFINITE, DETERMINERS, ADJECTIVES]
        .into_iter()
        .flatten()
        .copied()
        .chain(filling)
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
