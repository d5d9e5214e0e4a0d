//! The clauses of an utterance: each has a mood, and a request that it means.

use std::cmp::Reverse;

use super::frames::{Wish, leads_in};
use super::lexicon::Form;
use super::moods::{Mood, denies, mood};
use super::patterns::{has, length, taken};
use super::pieces::{Piece, Sense};
use super::words::Mark;
use super::{Intent, Rule};

/// What is to be found out, whether it is so or not.
const FACTS: &str = "see|check|find|tell|know|ask|wonder|say|show|feel|look|learn|sure|out ?me|us ?out \
    if|whether|why|what|which|who|where|how|when .. be|have|=did|=does not $";
/// Statements about others than the creature.
const OF_OTHERS: &str = "^ he|she|they|somebody|nobody|people|my|his|her|those|these; ^ i|we & !you|your|THING|SOME|BODY; \
    ^ you PAST|VERB|always|never";
/// Statements of which it is not clear that they are about what it is to do.
const UNCLEAR: &str = "he|she|they|him|her|his|them; we|i|PAST|to|be & !you|your|HAND|BODY|STICK";
/// What is one with the verb after "and": how it is done.
const ONE_WITH_NEXT: &str = "^ ?ANY USE|take|REACH|raise|lift ?out|up HAND ?out|up|and and|then; \
    ^ ?ANY USE|take|REACH|raise|lift ?out|up HAND ?out|up|and $; ^ ?ANY REACH out|over|across|forward|up|down $";
/// How many words more a side counts for that a thing is to be moved to, and a stick.
const MORE: usize = 4;
/// Words that a command may begin with, before its verb.
const MEANS: &str = "with by using to back over in from on up down away off left right out again your the";
/// What names the hand that is to do something, beside what it is to do.
const BY: &[&str] =
    &["USE|take|stretch|extend|raise|lift ?out ?up HAND ?out ?up and|to", "with|by|using|use HAND"];

/// A clause without what says nothing.
pub(super) struct Clause {
    pub pieces: Vec<Piece>,
    pub mood: Mood,
    /// The mark that it ends with.
    pub mark: Option<Mark>,
}

impl Clause {
    fn new(mut pieces: Vec<Piece>) -> Clause {
        let mark = pieces.last().and_then(|last| last.word.mark);
        facts(&mut pieces);
        let mut clause = Clause { pieces, mood: Mood::Statement, mark };
        clause.mood = mood(clause.begun());
        clause
    }

    /// What it begins with, what leads in apart.
    fn begun(&self) -> &[Piece] {
        let begin = self.pieces.iter().take_while(|piece| leads_in(piece)).count();
        // "Hello again" repeats nothing.
        match &self.pieces[begin..] {
            [] => &self.pieces,
            [again] if again.is("again") => &self.pieces,
            begun => begun,
        }
    }

    /// How a frame wants it.
    pub fn wish(&self) -> Option<Wish> {
        self.pieces.iter().find_map(|piece| piece.wanted)
    }

    /// Whether it forbids or denies anything.
    pub fn denies(&self) -> bool {
        self.mood == Mood::Prohibition || denies(&self.pieces)
    }

    /// The same, of what leads in as well.
    fn more(&self, grammar: &[Rule], how: &str) -> Option<(Intent, bool, usize)> {
        let (begun, whole) = (self.most(grammar, how, self.begun()), self.most(grammar, how, &self.pieces));
        if whole.map(|found| found.2) > begun.map(|found| found.2) { whole } else { begun }
    }

    /// The request that some of its words mean best, whether they say so of the first verb, and how much of them does.
    fn most(&self, grammar: &[Rule], how: &str, begun: &[Piece]) -> Option<(Intent, bool, usize)> {
        // With what it is to be done does not say what.
        let acts = |piece: &Piece| {
            piece.wanted.is_some()
                || piece.sense == Sense::Word && piece.word.form.is_base() && !piece.is("be do have use")
        };
        let by = (0..begun.len()).find_map(|k| {
            let taken = BY.iter().find_map(|by| length(&begun[k..], by))?;
            begun[..k].iter().chain(&begun[k + taken..]).any(acts).then_some((k, taken))
        });
        let begun: Vec<Piece> = match by {
            Some((k, taken)) => begun[..k].iter().chain(&begun[k + taken..]).cloned().collect(),
            None => begun.to_vec(),
        };
        let head = begun
            .iter()
            .position(|piece| piece.wanted.is_some())
            .or_else(|| {
                let means = |piece: &Piece| piece.sense != Sense::Word || piece.is(MEANS);
                begun
                    .iter()
                    .position(|piece| piece.sense == Sense::Word && piece.word.form.is_base())
                    .filter(|&k| begun[..k].iter().all(means))
            })
            .unwrap_or(0);
        let mut best: Option<(usize, Intent, bool)> = None;
        for (intent, _, pattern) in grammar.iter().filter(|(_, said, _)| *said == how) {
            let Some(taken) = taken(&begun, pattern) else { continue };
            // "To the left" says more than the words about it, and "the stick" where it is named.
            let stick = pattern.contains("STICK");
            let says_more =
                |piece: &Piece| matches!(piece.sense, Sense::Side(_)) || stick && piece.is_stick();
            let more = taken.iter().any(|&k| says_more(&begun[k]));
            let weight = taken.len() + if more { MORE } else { 0 };
            if best.is_none_or(|(most, ..)| weight > most) {
                best = Some((weight, *intent, taken.contains(&head)));
            }
        }
        best.map(|(most, intent, heads)| (intent, heads, most))
    }

    /// The request that it means, and whether it may be done for that.
    pub fn meant(&self, grammar: &[Rule]) -> Option<(Intent, bool)> {
        let begun = self.begun();
        match self.mood {
            Mood::Command => {
                let (question, wish) = (self.mark == Some(Mark::Question), self.wish());
                let open = wish == Some(Wish::Open) || question && wish != Some(Wish::Asked);
                let told = self.more(grammar, "told");
                let asked = self.most(grammar, "asked", begun);
                let tells = has(begun, "^ TELL|KNOW|COUNT|LOOK|FIND|EXAMINE|give|show|check|ask");
                let answer = wish.is_none() && (question || tells || !has(begun, "VERB"))
                    || has(begun, "^ TELL|KNOW|COUNT|describe|estimate|guess");
                let more = usize::from(question && wish.is_none());
                match (told, asked) {
                    (Some((.., told)), Some((intent, _, asked))) if answer && asked + more > told => {
                        Some((intent, false))
                    }
                    (None, Some((intent, ..))) => Some((intent, false)),
                    (told, _) => {
                        told.map(|(intent, heads, _)| (intent, heads && !open && !self.tells_of_past()))
                    }
                }
            }
            Mood::Question => {
                // "Introduce yourself": it is told to tell.
                let told = has(begun, "^ VERB").then(|| self.more(grammar, "told"));
                let told = told.flatten().filter(|(intent, ..)| !intent.moves());
                let asked = self.more(grammar, "asked");
                let told = told.filter(|told| asked.is_none_or(|asked| told.2 > asked.2));
                told.or(asked).map(|(intent, heads, _)| (intent, heads))
            }
            Mood::Past => self.more(grammar, "past").map(|(intent, ..)| (intent, false)),
            Mood::Prohibition => {
                let denied = self.most(grammar, "denied", begun).map(|(intent, ..)| intent);
                let dont = || self.about(grammar).is_some() || has(&self.pieces, "not DO THING|so|SOME");
                denied.or_else(|| dont().then_some(Intent::Dont)).map(|intent| (intent, false))
            }
            Mood::Statement => {
                let known = self.pieces.iter().all(|piece| piece.word.unknown.is_none());
                let own = known && !has(begun, OF_OTHERS) && !has(&self.pieces, UNCLEAR);
                let of = |of| self.most(grammar, of, begun).filter(|found| own && found.2 > 1);
                of("told").or_else(|| of("asked")).map(|found| (found.0, false))
            }
            Mood::Hypothesis => None,
        }
    }

    /// Whether anything in it is of what was, but what is wanted as if it were.
    fn tells_of_past(&self) -> bool {
        let past = |piece: &Piece| {
            piece.sense == Sense::Word && piece.word.form == Form::Past && piece.word.text != "left"
        };
        self.pieces.iter().any(|piece| past(piece) && piece.wanted.is_none())
    }

    /// The request that it is about, whatever it says of it.
    pub fn about(&self, grammar: &[Rule]) -> Option<Intent> {
        let of = |rows: &[(&str, Intent)]| {
            rows.iter().find(|(patterns, _)| has(&self.pieces, patterns)).map(|(_, intent)| *intent)
        };
        let told = grammar.iter().filter(|(intent, how, _)| *how == "told" && intent.moves());
        let taken = told.filter_map(|(intent, _, pattern)| {
            Some((taken(&self.pieces, pattern.trim_start_matches("^ "))?.len(), *intent))
        });
        // The longest, the first of as long ones.
        let best = taken.min_by_key(|(length, _)| Reverse(*length));
        of(LEAVING).or(best.map(|(_, intent)| intent)).or_else(|| of(DOING))
    }

    /// What is said alone: a greeting, yes, no.
    pub fn alone(&self, grammar: &[Rule]) -> Option<Intent> {
        let said = |pieces| self.most(grammar, "said", pieces);
        said(&self.pieces).or_else(|| said(self.begun())).map(|(intent, ..)| intent)
    }
}

/// What is forbidden where no verb says so.
const LEAVING: &[(&str, Intent)] = &[
    ("HAND off|away .. PART; leave|left PART alone|be", Intent::TouchOwn),
    ("HAND off|away; leave|left THING|SOME alone|be|where|there|in", Intent::Touch),
];
/// Verbs that are enough to know what is forbidden: "no pushing".
const DOING: &[(&str, Intent)] = &[
    ("LEAN", Intent::LeanForward),
    ("FORGET", Intent::Forget),
    ("LIFT|GRAB", Intent::Lift),
    ("DROP", Intent::LetGo),
    ("PULL", Intent::BringNear),
    ("PUT|PUSH", Intent::PutFar),
    ("TOUCH|REACH", Intent::Touch),
    ("SEARCH|FEEL|FIND", Intent::Explore),
];

/// What is not so, in what is to be found out or asked, forbids nothing: "see whether it isn't there", "isn't there anything?"
fn facts(pieces: &mut Vec<Piece>) {
    let denied = |k: usize, pieces: &[Piece]| {
        let asked = has(&pieces[..=k], FACTS) && !has(&pieces[..k], "and|but");
        let there = pieces.get(k + 1).is_some_and(|next| next.is("there"));
        pieces[k].is("not") && (asked || there && has(&pieces[..=k], "^ ?ANY be not $"))
    };
    while let Some(k) = (0..pieces.len()).find(|&k| denied(k, pieces)) {
        pieces.remove(k);
    }
}

/// The clauses: parted at marks and at "and", "then", "but", where there is a verb on either side.
pub(super) fn of(pieces: &[Piece]) -> Vec<Clause> {
    let verb = |piece: &Piece| {
        piece.sense == Sense::Word && piece.word.form != Form::Other && piece.word.text != "using"
    };
    let mut parts: Vec<Vec<Piece>> = vec![Vec::new()];
    for (k, piece) in pieces.iter().enumerate() {
        let rest = &pieces[k + 1..];
        let part = parts.last().map_or(&[][..], Vec::as_slice);
        let next = rest.iter().find(|next| next.sense == Sense::Word && !next.is("then not do never"));
        let begins = next.is_some_and(|next| next.word.form.is_base() || next.is("can could would will"));
        // "Use your left hand and touch it", "reach out and touch it" are one.
        let one = has(part, "^ ?ANY use") || length(rest, "VERB").is_some() && has(part, ONE_WITH_NEXT);
        if piece.is("and then but") && begins && part.iter().any(verb) && !one {
            parts.push(Vec::new());
        }
        let mark = piece.word.mark;
        if let Some(part) = parts.last_mut() {
            part.push(piece.clone());
            let (before, behind) = (part.iter().any(verb), rest.iter().any(verb));
            let sentence = mark >= Some(Mark::Stop) && part.iter().any(|piece| piece.sense != Sense::Word);
            let tag = has(rest, "^ can|could|will|would|do|have|be ?not you|THING $");
            if mark.is_some() && behind && (before && !tag || sentence) || mark == Some(Mark::Question) {
                parts.push(Vec::new());
            }
        }
    }
    parts.into_iter().filter(|part| !part.is_empty()).map(Clause::new).collect()
}
