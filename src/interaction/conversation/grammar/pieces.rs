//! What stretches of words name: a thing, a hand, a part of the body, a side; and what they tell of who is to do what.

use super::Intent;
use super::frames::Wish;
use super::lexicon::meanings;
use super::names::{BodyNames, PartName};
use super::patterns::{end, has, listed};
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
    /// The one that was found so manieth, the first by 0.
    Nth(usize),
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
    ("first former", Which::Nth(0)),
    ("second", Which::Nth(1)),
    ("third", Which::Nth(2)),
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
        part.words.iter().find_map(|word| HandName::named(word))
    }

    fn named(word: &str) -> Option<HandName> {
        match word {
            "left" => Some(HandName::Left),
            "right" => Some(HandName::Right),
            "other" => Some(HandName::Other),
            _ => None,
        }
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
    let mut pieces: Vec<Piece> =
        words.iter().filter_map(|word| Piece::new(Sense::Word, std::slice::from_ref(word))).collect();
    for k in 0.. {
        // What a mark ends does not go on behind it.
        let marked = pieces.iter().skip(k).position(|piece| piece.word.mark.is_some());
        let end = marked.map_or(pieces.len(), |far| k + far + 1);
        if k >= end {
            break;
        }
        if let Some((sense, until)) = sense_at(&pieces[..end], k, names) {
            let words: Vec<Word> = pieces[k..until].iter().map(|piece| piece.word.clone()).collect();
            pieces.splice(k..until, Piece::new(sense, &words));
        }
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

/// What names nothing, whatever it looks like: "hand it over", "lower both arms".
const NO_NAMES: &str =
    "<!your|the|a|one|left|right|other|both|with =hand =me|=us|=it|=over|=back|=that|=this; =lower =both";
/// "A hand on", and "left" where it is a hand: "with your left".
const BARE_HANDS: &str = "=a|=one =hand|=finger|=palm|=fingertip|=arm \
    >on|onto|over|to|across|along|around|round|through|against|upon|in|under|behind; \
    <with|use|by|but|via|try =your|=the =left|=right|=other ?=one >$|this|please|now|instead|and|again|to|VERB; \
    <with|use|by|but|via|try =left|=right >$|this|please|now|instead|and|again|to|VERB";
/// What names a thing or some thing, or neither; the first that fits. CLAUSE is one of [`CLAUSES`].
const NOUN_PHRASES: &[(Sense, &str)] = &[
    (Sense::Some, "INDEFINITE ?else|new|more|other ?CLAUSE; =nothing =else ?CLAUSE"),
    (
        Sense::Thing,
        "=whatever|=whichever =was|=is|=comes|=gets|=moves *!PARTING; =whatever|=whichever CLAUSE",
    ),
    // "That you …" begins a clause, "how large" and "which one" ask; "the same thing with your right hand", "stick it there".
    (
        Sense::Word,
        "=that =you|=i|=we; <how ADJECTIVE; =which|=its; *DETERMINER *ADJECTIVE =same =thing|=things",
    ),
    (Sense::Word, "=stick =it|=that|=the|=this|=them|=your|=a"),
    // "Is that a bottle?"
    (Sense::Thing, "=this|=that >=a|=an"),
    // "The nearer", "the second"; not "to the left".
    (Sense::Word, "<on|to|at|from|toward|towards =the *DETERMINER *ADJECTIVE =left|=right"),
    (Sense::Thing, "^ =the *DETERMINER *ADJECTIVE !UNPICKING ADJECTIVE =away"),
    (
        Sense::Thing,
        "=the *DETERMINER *ADJECTIVE !UNPICKING ADJECTIVE >$|please|with|to|of|from|away|now|you|me|over|there",
    ),
    (Sense::Thing, "*DETERMINER DEFINITE *DETERMINER *ADJECTIVE NOUN|PLURAL|AMBIGUOUS ?CLAUSE"),
    (Sense::Some, "*DETERMINER VAGUE *DETERMINER *ADJECTIVE NOUN|PLURAL|AMBIGUOUS ?CLAUSE"),
    (Sense::Thing, "DETERMINER *DETERMINER *ADJECTIVE NOUN|PLURAL|AMBIGUOUS ?CLAUSE"),
    (Sense::Some, "*ADJECTIVE PLURAL ?CLAUSE"),
    // "The can" is a thing, "can you" is not.
    (Sense::Thing, "*ADJECTIVE NOUN ?CLAUSE; *ADJECTIVE !nice|old|new ADJECTIVE =one ?CLAUSE"),
    (Sense::Thing, "=it|=them; =this|=that|=these|=those !a|an|the"),
];
/// What tells which thing it is: "nearest to you", "that you found first", "you did not find yet", "on your right" of one.
pub(super) const CLAUSES: &str = "nearest|closest|farthest|furthest|next to|from you|me; \
    nearest|closest|farthest|furthest|next ?you|me|away; that|which|who !be THIRD *!PARTING; \
    that|which|who be on|at|near|nearest|nearer|closest|close|far|farthest|farther|to|in|there|closer *!PARTING; \
    ?that|which|who you|we|i *HELPED EXPERIENCED&PAST|=come *LATELY; \
    ?that|which|who you|we|i *HELPED do *HELPED EXPERIENCED *LATELY; \
    not *HELPED EXPERIENCED&PAST|=come *LATELY; not *HELPED do *HELPED EXPERIENCED *LATELY; \
    that|which|who HELPED *HELPED EXPERIENCED&PAST|=come *LATELY; \
    that|which|who *HELPED do *HELPED EXPERIENCED *LATELY; <=one on|at =your|=the|=my =left|=right ?side";

/// What the pieces from one on stand for, and up to which; `None` for a word as it is.
fn sense_at(pieces: &[Piece], k: usize, names: &BodyNames) -> Option<(Sense, usize)> {
    let up_to = |patterns: &str| listed(patterns).find_map(|pattern| end(pieces, k, pattern, false));
    if up_to(NO_NAMES).is_some() {
        return None;
    }
    let texts: Vec<&str> = pieces[k..].iter().map(|piece| piece.word.text.as_str()).collect();
    let of_others = k > 0 && pieces[k - 1].is("my our her their a an");
    if let Some((part, length)) = names.at(&texts).filter(|_| !of_others) {
        return Some((if part.is_hand() { Sense::Hand(part) } else { Sense::Part(part) }, k + length));
    }
    if let Some(until) = up_to(BARE_HANDS) {
        let mut words = pieces[k..until].iter().map(|piece| piece.word.text.clone()).collect::<Vec<_>>();
        words.retain(|word| !["a", "your", "the", "one"].contains(&word.as_str()));
        words.extend(HandName::named(&words[0]).map(|_| "hand".to_string()));
        return Some((Sense::Hand(PartName { words }), until));
    }
    let found = NOUN_PHRASES.iter().find_map(|(sense, patterns)| Some((sense.clone(), up_to(patterns)?)));
    found.filter(|(sense, _)| *sense != Sense::Word)
}

/// Which of several things pieces tell.
pub(super) fn which(pieces: &[Piece]) -> Option<Which> {
    let told = |k: usize| {
        let piece: &Piece = &pieces[k];
        let on = |back: usize| k >= back && pieces[k - back].is("on to at");
        let the = piece.words.first().is_some_and(|first| first == "the");
        let picks = piece.sense == Sense::Thing
            || piece.sense == Sense::Word && (on(2) || the && on(1) || piece.is("first last"));
        let listed = |words: &str| words.split(' ').any(|word| piece.words.iter().any(|own| own == word));
        let which = WHICH.iter().filter(|_| picks).find(|(words, _)| listed(words));
        which.map(|(_, which)| *which)
    };
    (0..pieces.len()).find_map(told)
}

/// Whether something is to be done with a stick: "with the stick", "use your stick".
pub(super) fn with_stick(pieces: &[Piece]) -> bool {
    has(pieces, "<with|use|by|your STICK")
}

/// How a hand is named that is to do something: "with your hand", "your hand on your nose", "your hand touch your nose".
const ACTING: &str = "<with|by|use|using HAND; HAND on|onto|to|against|at|upon|over; \
    HAND VERB on|onto|to|against|at|upon|over|BODY";

/// The hand that is to do something, and the part of the body that it is about.
pub(super) fn hand_and_part(pieces: &[Piece], intent: Intent) -> (Option<HandName>, Option<PartName>) {
    let hand = |k: &usize| matches!(pieces[*k].sense, Sense::Hand(_));
    let body: Vec<usize> = (0..pieces.len()).filter(|&k| pieces[k].is_body()).collect();
    let part = |k: usize| pieces[k].part().cloned();
    let side = |k: usize| pieces[k].part().and_then(HandName::of);
    match intent {
        Intent::WhereOwn => (None, body.first().and_then(|&k| part(k))),
        Intent::TouchOwn => {
            let acts = |k: &usize| listed(ACTING).any(|acting| end(pieces, *k, acting, false).is_some());
            let by = body.iter().copied().find(acts).filter(|_| body.len() > 1);
            let others = || body.iter().copied().filter(|&k| Some(k) != by);
            let touched = others().find(|k| !hand(k)).or(others().next());
            let more = || body.iter().copied().filter(|k| hand(k) && Some(*k) != touched).find_map(side);
            (by.and_then(side).or_else(more), touched.and_then(part))
        }
        _ => (body.iter().copied().filter(hand).find_map(side), None),
    }
}
