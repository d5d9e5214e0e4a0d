//! What names a thing: "it", "the nearer one", "something that you felt".

use super::lexicon::Form;
use super::slots::{Piece, Sense};
use super::words::Word;

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
/// What it has done, or not, to what it knows of a thing or a place.
const FELT: &[&str] =
    &["find", "feel", "touch", "discover", "meet", "detect", "notice", "hold", "know", "search", "explore"];
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

/// A thing, or some thing, that words begin with, and of how many words.
pub(super) fn noun_phrase(words: &[Word], before: Option<&Piece>) -> Option<(Sense, usize)> {
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
    // "Is that a bottle?"
    if is(0, &["this", "that"]) && is(1, &["a", "an"]) {
        return Some((Sense::Thing, 1));
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
            || is(k, &["please", "with", "to", "of", "from", "away", "now", "you", "me", "over", "there"]);
        let side = is(k - 1, &["left", "right"])
            && before.is_some_and(|piece| piece.word.is(&["on", "to", "at", "from", "toward", "towards"]));
        if ends && !side {
            return Some((Sense::Thing, k));
        }
    }
    let pronoun = is(0, PRONOUNS) && (is(0, &["it", "them"]) || !is(1, &["a", "an", "the"]));
    pronoun.then_some((Sense::Thing, 1))
}

/// Whether what names a thing may begin with a word, or go on: "the", "my", "long", "it".
pub(super) fn begins_thing(word: &Word) -> bool {
    [DETERMINERS, ADJECTIVES, PRONOUNS].iter().any(|words| words.contains(&word.text.as_str()))
        || word.is(&["my", "your", "our", "his", "her", "their"])
}

/// How many words of what follows a thing tell which it is: "that you found first", "you have felt", "that comes near".
fn relative_clause(words: &[Word]) -> usize {
    if let [that, verb, ..] = words
        && that.is(&["that", "which", "who"])
        && that.mark.is_none()
        && verb.text != "is"
        && verb.form == Form::Third
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
    // "That you have felt before", "you did not find yet", "not found so far": what is not so tells which it is as well.
    let is = |k: usize, list: &[&str]| words.get(k).is_some_and(|word| word.is(list));
    let mut k = usize::from(is(0, &["that", "which"]));
    let subject = is(k, &["you", "we", "i"]);
    k += usize::from(subject);
    let begin = k;
    while is(k, &["have", "do", "be", "not", "never", "just", "already", "first", "last", "yet", "even"]) {
        k += 1;
    }
    let helped = words[..k].iter().any(|word| word.is(&["do"]));
    let begins = subject || is(0, &["not"]) || (begin == 1 && k > begin);
    let verb = |word: &Word| word.is(FELT) && (word.form == Form::Past || helped);
    if !begins || !words.get(k).is_some_and(verb) || words[..k].iter().any(|word| word.mark.is_some()) {
        return 0;
    }
    const WHEN: [&str; 8] = ["first", "last", "before", "just", "so", "far", "earlier", "yet"];
    k + 1 + words[k + 1..].iter().take_while(|word| word.is(&WHEN)).count()
}

/// How many words there are to the end of a clause, from one on.
fn to_the_end(words: &[Word], from: usize) -> usize {
    let ends = |k: usize| words[k].mark.is_some() || k + 1 == words.len();
    let parts = |k: usize| {
        words[k].is(&["with", "by", "and", "then", "please", "or", "but"]) || words[k].text == "using"
    };
    (from..words.len()).find(|&k| ends(k) || parts(k)).map_or(from, |k| if parts(k) { k } else { k + 1 })
}

/// All words of these lists.
pub(super) fn words() -> impl Iterator<Item = &'static str> {
    [THINGS, PRONOUNS, INDEFINITE, DETERMINERS, ADJECTIVES].into_iter().flatten().copied()
}
