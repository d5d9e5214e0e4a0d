//! What stretches of words name: a thing, a hand, a part of the body, a side; and what they tell of who is to do what.

use super::Intent;
use super::frames::Wish;
use super::lexicon::{Form, meanings};
use super::names::{BodyNames, PartName};
use super::places::Aside;
use super::words::{Mark, Word};

/// Which of several things is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    /// The one on the left.
    Left,
    /// The one on the right.
    Right,
    /// The nearest one.
    Nearest,
    /// The farthest one.
    Farthest,
    /// The one that was found first.
    First,
    /// The one that was found second.
    Second,
    /// The one that was found third.
    Third,
    /// The one that was found last.
    Last,
    /// Not the one of which they talk.
    Other,
}

/// Words that tell which of several things is meant.
const WHICH: &[(&str, Which)] = &[
    ("nearer nearest closer closest near close", Which::Nearest),
    ("farther farthest further furthest far", Which::Farthest),
    ("left leftmost", Which::Left),
    ("right rightmost", Which::Right),
    ("first former", Which::First),
    ("second", Which::Second),
    ("third", Which::Third),
    ("last latter latest", Which::Last),
    ("other another", Which::Other),
];

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

impl HandName {
    fn of(part: &PartName) -> Option<HandName> {
        let names = [("left", HandName::Left), ("right", HandName::Right), ("other", HandName::Other)];
        names.into_iter().find(|(word, _)| part.has(word)).map(|(_, hand)| hand)
    }
}

/// What a stretch of words stands for.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Sense {
    /// A word as it is.
    Word,
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
    /// What it means, if it is a word.
    pub meanings: Vec<&'static str>,
    /// How a frame says that it is wanted: "could you …".
    pub wanted: Option<Wish>,
}

/// What an adjective may tell of some thing.
const QUALITIES: [&str; 2] = ["SIZED", "SHAPED"];

impl Piece {
    pub fn new(sense: Sense, stretch: &[Word]) -> Option<Piece> {
        let word = stretch.last()?.clone();
        let meanings = match sense {
            // "A large object."
            Sense::Some => stretch
                .iter()
                .flat_map(|word| meanings(&word.lemma, &word.text))
                .filter(|name| QUALITIES.contains(name))
                .collect(),
            _ => meanings(&word.lemma, &word.text).collect(),
        };
        let words = stretch.iter().map(|word| word.text.clone()).collect();
        Some(Piece { sense, word, words, meanings, wanted: None })
    }

    /// Whether it is a stick, known or not.
    pub fn is_stick(&self) -> bool {
        matches!(self.sense, Sense::Thing | Sense::Some)
            && self.words.iter().any(|word| ["stick", "rod"].contains(&word.as_str()))
    }

    pub fn is_body(&self) -> bool {
        self.part().is_some()
    }

    /// The hand or other part that it names.
    pub fn part(&self) -> Option<&PartName> {
        match &self.sense {
            Sense::Hand(part) | Sense::Part(part) => Some(part),
            _ => None,
        }
    }

    /// Whether it is a word with one of some lemmas.
    pub fn is(&self, lemmas: &str) -> bool {
        self.words.len() == 1 && self.word.is(lemmas)
    }
}

/// The pieces of an utterance.
pub(super) fn pieces(words: &[Word], names: &BodyNames) -> Vec<Piece> {
    let mut pieces: Vec<Piece> = Vec::new();
    let mut k = 0;
    while k < words.len() {
        // What a mark ends does not go on behind it.
        let end = (k..words.len()).find(|&j| words[j].mark.is_some()).map_or(words.len(), |j| j + 1);
        let (sense, length) = sense_of(&words[k..end], names, pieces.last());
        pieces.extend(Piece::new(sense, &words[k..k + length]));
        k += length;
    }
    referred(&mut pieces);
    pieces
}

/// "Your chin: touch it." It is the part of the body that was named alone before, where no thing was; or the stick that nothing
/// was told to be done with: "I have a stick for you, take it."
fn referred(pieces: &mut [Piece]) {
    let mut named: Option<Sense> = None;
    let mut stick = false;
    for k in 0..pieces.len() {
        let of_stick = pieces[k].is_stick() && !pieces[0].word.form.is_base();
        stick |= of_stick && !(k > 0 && pieces[k - 1].is("with by use using"));
        if stick && pieces[k].sense == Sense::Thing && pieces[k].is("it") {
            pieces[k].words = vec!["stick".to_string()];
        }
        let told = pieces[..k]
            .iter()
            .any(|piece| piece.sense == Sense::Word && piece.word.form.is_base() && !piece.is("be do have"));
        match &pieces[k].sense {
            part @ (Sense::Part(_) | Sense::Hand(_)) => {
                let with = k > 0 && pieces[k - 1].is("with by use using");
                let alone = match part {
                    Sense::Part(_) => pieces[k].word.mark.is_some(),
                    _ => pieces[k].word.mark == Some(Mark::Pause) && !with,
                };
                named = (alone && !told).then(|| part.clone());
            }
            Sense::Thing if ["it", "that"].contains(&pieces[k].word.text.as_str()) => {
                if let Some(named) = &named {
                    pieces[k].sense = named.clone();
                }
            }
            Sense::Thing | Sense::Some => named = None,
            _ => {}
        }
    }
}

fn sense_of(words: &[Word], names: &BodyNames, before: Option<&Piece>) -> (Sense, usize) {
    let texts: Vec<&str> = words.iter().map(|word| word.text.as_str()).collect();
    let after = |lemmas: &str| before.is_some_and(|piece| piece.is(lemmas));
    // "Hand it over."
    if texts[0] == "hand"
        && texts.get(1).is_some_and(|next| ["me", "us", "it", "over", "back", "that", "this"].contains(next))
        && !after("your the a one left right other both with")
    {
        return (Sense::Word, 1);
    }
    // "Lower both arms."
    if texts.starts_with(&["lower", "both"]) {
        return (Sense::Word, 1);
    }
    let named = names.at(&texts).filter(|_| !after("my our her their a an"));
    if let Some((part, length)) = named {
        return (if part.is_hand() { Sense::Hand(part) } else { Sense::Part(part) }, length);
    }
    if let Some((hand, length)) = bare_hand(&texts, words, before) {
        let words = hand.iter().map(|word| word.to_string()).collect();
        return (Sense::Hand(PartName { words }), length);
    }
    noun_phrase(words, before).unwrap_or((Sense::Word, 1))
}

/// "A hand on", and "left" where it is a hand: "with your left", "but left".
fn bare_hand<'a>(texts: &[&'a str], words: &[Word], before: Option<&Piece>) -> Option<(Vec<&'a str>, usize)> {
    if let ["a" | "one", noun @ ("hand" | "finger" | "palm" | "fingertip" | "arm"), next, ..] = texts
        && "on onto over to across along around round through against upon in under behind"
            .split(' ')
            .any(|on| on == *next)
    {
        return Some((vec![noun], 2));
    }
    let owned = usize::from(matches!(texts.first(), Some(&"your" | &"the")));
    let side = texts.get(owned).filter(|side| ["left", "right", "other"].contains(side))?;
    let one = usize::from(owned > 0 && texts.get(owned + 1) == Some(&"one"));
    let end = owned + one;
    let ends = words[end].mark.is_some()
        || texts
            .get(end + 1)
            .is_none_or(|next| "this please now instead and again to".split(' ').any(|end| end == *next))
        || words.get(end + 1).is_some_and(|next| next.form.is_base());
    let by = before.is_some_and(|piece| piece.is("with use by but via try"));
    let hand = by && ends && (*side != "other" || owned > 0);
    hand.then(|| (vec![*side, "hand"], end + 1))
}

/// What a thing may be called that it felt and cannot see.
const THINGS: &str = "thing things object objects item items stuff obstacle obstacles ball box can bottle brick block cup mug glass bowl \
    plate jar tin book pen pencil spoon fork knife stick rod toy apple orange banana phone key keys cans bottles boxes blocks cups balls \
    bricks pot vase tray lamp tool gadget thingy thingie thingamajig whatsit package parcel carton tube cone die dice egg candle camera \
    cube cylinder sphere gizmo doodad contraption article target device widget tube jug teapot kettle flask tumbler wallet figurine \
    doll torch mouse notebook stapler sponge hammer lemon tomato potato container piece lump chunk thingummy doohickey one ones";
const INDEFINITE: &str = "something anything someone somebody anybody anyone";
const DETERMINERS: &str = "the this that these those a an some any another every all both each one more other which whichever two three its";
const ADJECTIVES: &str = "left right near nearer nearest close closer closest far farther farthest further furthest big bigger biggest large \
    larger small smaller little long tall short round square hard soft light heavy first second third last latest other same new old nice \
    whole entire single next remaining opposite front back flat smooth different middle rightmost leftmost latter former hand more";
/// What it has done, or not, to what it knows of a thing or a place.
const EXPERIENCED: &str = "find feel touch discover meet detect notice hold know search explore come";
/// Words that end a relative clause.
const PARTING: &str = "with by and then please or but using";

/// A thing, or some thing, that words begin with, and of how many words.
fn noun_phrase(words: &[Word], before: Option<&Piece>) -> Option<(Sense, usize)> {
    let listed = |k: usize, list: &str| {
        words.get(k).is_some_and(|word: &Word| list.split_whitespace().any(|other| other == word.text))
    };
    if listed(0, INDEFINITE) || listed(0, "nothing") && listed(1, "else") {
        let more = 1 + usize::from(listed(1, "else new more other"));
        return Some((Sense::Some, more + relative_clause(&words[more.min(words.len())..])));
    }
    if listed(0, "whatever whichever") {
        let be = usize::from(listed(1, "was is comes gets moves"));
        let clause = if be > 0 { to_the_end(&words[1..], 1) } else { relative_clause(&words[1..]) };
        return (clause > 0).then_some((Sense::Thing, 1 + clause));
    }
    // "That you …" begins a clause, "how large" and "which one" ask.
    let begins = listed(0, "that") && listed(1, "you i we") && words[0].mark.is_none();
    let asks = before.is_some_and(|piece| piece.is("how")) && listed(0, ADJECTIVES) || listed(0, "which");
    if begins || asks {
        return None;
    }
    // "Is that a bottle?"
    if listed(0, "this that") && listed(1, "a an") {
        return Some((Sense::Thing, 1));
    }
    let mut k = (0..words.len())
        .take_while(|&k| listed(k, DETERMINERS) && !(k > 0 && listed(k - 1, "its one")))
        .count();
    // "The one", not "one thing".
    if k > 1 && listed(k - 1, "one") && !listed(k, ADJECTIVES) && !listed(k, THINGS) {
        k -= 1;
    }
    let determined = k;
    while listed(k, ADJECTIVES) {
        k += 1;
    }
    // "The same thing with your right hand."
    if k > 0 && listed(k - 1, "same") && listed(k, "thing things") {
        return None;
    }
    // "Stick it there."
    if listed(0, "stick") && listed(1, "it that the this them your a") {
        return None;
    }
    // "The can" is a thing, "can you" is not.
    if listed(k, THINGS)
        && (determined > 0
            || k > 0 && listed(k, "one") && !listed(k - 1, "nice old new")
            || !listed(k, "can one die key glass tin"))
        && !listed(0, "its")
    {
        let definite = (0..determined).any(|j| listed(j, "the this that these those both all"));
        let vague = (0..determined).any(|j| listed(j, "a an any some another more"));
        let plural = determined == 0 && words[k].text.ends_with('s') && !listed(k, "glass");
        let sense = if definite || !(vague || plural) { Sense::Thing } else { Sense::Some };
        // "The one on your right."
        let side = listed(k, "one")
            && listed(k + 1, "on at")
            && listed(k + 2, "your the my")
            && listed(k + 3, "left right");
        let beside = if side { 3 + usize::from(listed(k + 4, "side")) } else { 0 };
        return Some((sense, k + 1 + beside + relative_clause(&words[k + 1 + beside..])));
    }
    // "The nearer", "the second".
    if listed(0, "the")
        && (k > determined || listed(k - 1, "other"))
        && !listed(k - 1, "back front hand middle whole entire same")
    {
        let ends = k == words.len()
            || words[k - 1].mark.is_some()
            || listed(k, "please with to of from away now you me over there");
        let side = listed(k - 1, "left right")
            && before.is_some_and(|piece| piece.is("on to at from toward towards"));
        if ends && !side {
            // "The one farther away", and nothing else.
            let away = usize::from(before.is_none() && listed(k, "away off"));
            return Some((Sense::Thing, k + away));
        }
    }
    let pronoun = listed(0, "it them") || listed(0, "this that these those") && !listed(1, "a an the");
    pronoun.then_some((Sense::Thing, 1))
}

/// How many words of what follows a thing tell which it is: "that you found first", "you did not find yet", "nearest to you".
fn relative_clause(words: &[Word]) -> usize {
    let is = |k: usize, list: &str| words.get(k).is_some_and(|word| word.is(list));
    if is(0, "nearest closest farthest furthest next") {
        let to = usize::from(is(1, "to from") && is(2, "you me"));
        return 1 + to + usize::from(is(1 + to, "you me away"));
    }
    let that = usize::from(is(0, "that which who"));
    let marked = |until: usize| words[..until].iter().any(|word| word.mark.is_some());
    if that == 1 && words.len() > 1 && !marked(1) {
        if words[1].form == Form::Third && !is(1, "be") {
            return to_the_end(words, 1);
        }
        if is(1, "be")
            && is(2, "on at near nearest nearer closest close far farthest farther to in there closer")
        {
            return to_the_end(words, 2);
        }
    }
    let subject = usize::from(is(that, "you we i"));
    let mut k = that + subject;
    while is(k, "have do be not never just already first last yet even") {
        k += 1;
    }
    let helped = words[..k].iter().any(|word| word.is("do"));
    let begins = subject > 0 || is(0, "not") || (that == 1 && k > 1);
    let verb =
        |word: &Word| word.is(EXPERIENCED) && (word.form == Form::Past || helped || word.text == "come");
    if !begins || !words.get(k).is_some_and(verb) || marked(k) {
        return 0;
    }
    k + 1
        + words[k + 1..]
            .iter()
            .take_while(|word| word.is("first last before just so far earlier yet across"))
            .count()
}

/// How many words there are to the end of a clause, from one on.
fn to_the_end(words: &[Word], from: usize) -> usize {
    let end = (from..words.len()).find(|&k| words[k].is(PARTING)).unwrap_or(words.len());
    words[..end].iter().position(|word| word.mark.is_some()).map_or(end, |k| k + 1)
}

/// All words of these lists.
pub(super) fn words() -> impl Iterator<Item = &'static str> {
    [THINGS, INDEFINITE, DETERMINERS, ADJECTIVES].into_iter().flat_map(str::split_whitespace)
}

/// Which of several things pieces tell.
pub(super) fn which(pieces: &[Piece]) -> Option<Which> {
    let picks = |k: usize| {
        let piece: &Piece = &pieces[k];
        let on = |back: usize| k >= back && pieces[k - back].is("on to at");
        let the = piece.words.first().is_some_and(|first| first == "the");
        piece.sense == Sense::Thing
            || piece.sense == Sense::Word && (on(2) || the && on(1) || piece.is("first last"))
    };
    let told = |piece: &Piece| {
        let listed = |words: &str| words.split(' ').any(|word| piece.words.iter().any(|own| own == word));
        WHICH.iter().find(|(words, _)| listed(words)).map(|(_, which)| *which)
    };
    (0..pieces.len()).filter(|&k| picks(k)).find_map(|k| told(&pieces[k]))
}

/// Whether something is to be done with a stick: "with the stick", "use your stick".
pub(super) fn with_stick(pieces: &[Piece]) -> bool {
    (1..pieces.len()).any(|k| pieces[k].is_stick() && pieces[k - 1].is("with use by your"))
}

/// The hand that is to do something, and the part of the body that it is about.
pub(super) fn hand_and_part(pieces: &[Piece], intent: Intent) -> (Option<HandName>, Option<PartName>) {
    let hand = |k: usize| matches!(pieces[k].sense, Sense::Hand(_));
    let body: Vec<usize> = (0..pieces.len()).filter(|&k| pieces[k].is_body()).collect();
    let part = |k: usize| pieces[k].part().cloned();
    let side = |k: usize| pieces[k].part().and_then(HandName::of);
    match intent {
        Intent::WhereOwn => (None, body.first().and_then(|&k| part(k))),
        Intent::TouchOwn => {
            let onto =
                |k: usize| pieces.get(k).is_some_and(|piece| piece.is("on onto to against at upon over"));
            let acts = |k: usize| {
                let by = k >= 1 && pieces[k - 1].is("with by use using");
                let verb = pieces.get(k + 1).is_some_and(|next| next.word.form.is_base());
                let another = pieces.get(k + 2).is_some_and(Piece::is_body);
                hand(k) && (by || onto(k + 1) || verb && (onto(k + 2) || another))
            };
            let by = body.iter().copied().find(|&k| acts(k)).filter(|_| body.len() > 1);
            let others = || body.iter().copied().filter(|&k| Some(k) != by);
            let touched = others().find(|&k| !hand(k)).or(others().next());
            let more = || body.iter().copied().filter(|&k| hand(k) && Some(k) != touched).find_map(side);
            (by.and_then(side).or_else(more), touched.and_then(part))
        }
        _ => (body.iter().copied().filter(|&k| hand(k)).find_map(side), None),
    }
}
