//! The clauses of an utterance: each has a mood, and a request that it means.

use std::cmp::Reverse;

use super::frames::{Wish, leads_in};
use super::lexicon::Form;
use super::patterns::{has, length, listed, taken};
use super::pieces::{Piece, Sense};
use super::words::Mark;
use super::{Grammar, Intent, Words};

/// What kind of sentence a clause is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mood {
    /// It tells or asks to do something.
    Command,
    /// It asks for an answer.
    Question,
    /// It asks or tells of what was.
    Past,
    /// It forbids something.
    Prohibition,
    /// It is about what is not, or not yet.
    Hypothesis,
    /// It states something.
    Statement,
}

/// What denies or forbids, wherever it stands.
const DENYING: &str = "not|never|without|neither|nor|refrain|abstain|cease|desist|prevent|forbid|prohibit|unless|nobody|none; \
    nothing; instead of; rather than; \
    avoid|stop|quit|skip|hate|dislike|loathe|mind|resent ?with ?THING|you|it DOING; \
    leave|left THING|SOME|BODY alone|be; leave off; leave|left THING where|in; let THING be $; ^ HAND off; \
    no ?more DOING|TOUCH|PUSH|LEAN|LIFT|REACH|PULL|GRAB|PUT|contact; keep HAND off|away|from; \
    hold off|back from|DOING; keep|stay off; keep|away|refrain|far from DOING|TOUCH; from DOING; \
    forget ?about DOING; i|we would ?really|absolutely hate|dislike|loathe|resent|mind|object; \
    BAD if|to|for|idea; HAND to yourself; keep HAND to; no business; anything|SOME but; under|by|on no; \
    be forbidden|=forbidden; off limits; make no; nowhere; no need|reason|longer|point; last thing; \
    no|nope|nah ?ANY ?THING $; beware of; cut THING out";
/// How many words more a side counts for that a thing is to be moved to, and a stick.
const MORE: usize = 4;
/// Words that a command may begin with, before its verb.
const MEANS: &str = "with by using to back over in from on up down away off left right out again your the";

/// What the partner does not know, and would.
const NOT_KNOWING: &str = "^ i|we do|can|could not =know|=tell|=see|=remember|=understand";
/// What makes a question of what is stated: "…, isn't it?"
const TAG: &str = "=did|=does|=have|=has|=were|=was|=are|=is ?not you|THING $";
/// How something is asked for that is to be told: "describe it", "give me an estimate".
const TELLING: &[&str] = &["^ TELL|COUNT", "^ give me|us !THING|SOME|back|STICK|my"];
/// What names the hand that is to do something, beside what it is to do.
const BY: &[&str] =
    &["USE|take|STRETCH|extend|raise|lift ?out ?up HAND ?out ?up and|to", "with|by|using|use HAND"];

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
        clause.mood = mood(clause.begun(), mark == Some(Mark::Question));
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

    /// The request that its words mean best, and whether they say so of its first verb.
    fn says(&self, grammar: &Grammar, of: fn(&Words) -> &'static str) -> Option<(Intent, bool)> {
        self.most(grammar, of, self.begun()).map(|(intent, heads, _)| (intent, heads))
    }

    /// The same, of what leads in as well, and how much of it means so.
    fn more(&self, grammar: &Grammar, of: fn(&Words) -> &'static str) -> Option<(Intent, bool, usize)> {
        let (begun, whole) = (self.most(grammar, of, self.begun()), self.most(grammar, of, &self.pieces));
        if whole.map(|found| found.2) > begun.map(|found| found.2) { whole } else { begun }
    }

    fn most(
        &self,
        grammar: &Grammar,
        of: fn(&Words) -> &'static str,
        begun: &[Piece],
    ) -> Option<(Intent, bool, usize)> {
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
        for (intent, words) in grammar.iter() {
            for pattern in listed(of(words)) {
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
        }
        best.map(|(most, intent, heads)| (intent, heads, most))
    }

    /// The request that it means, and whether it may be done for that.
    pub fn meant(&self, grammar: &Grammar) -> Option<(Intent, bool)> {
        let no_leave = |meant: Option<(Intent, bool)>| meant.map(|(intent, _)| (intent, false));
        match self.mood {
            Mood::Command => {
                let open = self.wish() == Some(Wish::Open)
                    || (self.mark == Some(Mark::Question) && self.wish() != Some(Wish::Asked));
                let told = self.more(grammar, |words| words.told);
                let asked = self.most(grammar, |words| words.asked, self.begun());
                let answer = self.wish().is_none()
                    && (self.mark == Some(Mark::Question)
                        || has(self.begun(), "^ TELL|KNOW|COUNT|LOOK|FIND|EXAMINE|give|show|check|ask")
                        || !has(self.begun(), "VERB"))
                    || has(self.begun(), "^ TELL|KNOW|COUNT|describe|estimate|guess");
                let question = usize::from(self.mark == Some(Mark::Question) && self.wish().is_none());
                match (told, asked) {
                    (Some((_, _, told)), Some((intent, _, asked))) if answer && asked + question > told => {
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
                let told = has(self.begun(), "^ VERB").then(|| self.more(grammar, |words| words.told));
                let told = told.flatten().filter(|(intent, ..)| !intent.moves());
                let asked = self.more(grammar, |words| words.asked);
                let told = told.filter(|told| asked.is_none_or(|asked| told.2 > asked.2));
                told.or(asked).map(|(intent, heads, _)| (intent, heads))
            }
            Mood::Past => {
                no_leave(self.more(grammar, |words| words.past).map(|(intent, heads, _)| (intent, heads)))
            }
            Mood::Prohibition => no_leave(
                self.says(grammar, |words| words.denied)
                    .or_else(|| self.about(grammar).map(|_| (Intent::Dont, false)))
                    .or_else(|| has(&self.pieces, "not DO THING|so|SOME").then_some((Intent::Dont, false))),
            ),
            Mood::Statement => {
                let others = has(self.begun(), "^ he|she|they|somebody|nobody|people|my|his|her|those|these")
                    || has(self.begun(), "^ i|we & !you|your|THING|SOME|BODY")
                    || has(self.begun(), "^ you PAST|VERB|always|never")
                    || has(&self.pieces, "he|she|they|him|her|his|them")
                    || has(&self.pieces, "we|i|PAST|to|be") && !has(&self.pieces, "you|your|HAND|BODY|STICK");
                let own = self.pieces.len() > 1
                    && !others
                    && self.pieces.iter().all(|piece| piece.word.unknown.is_none());
                let least = |most: Option<(Intent, bool, usize)>| {
                    most.filter(|found| own && found.2 > 1).map(|found| (found.0, false))
                };
                let of = |of| least(self.most(grammar, of, self.begun()));
                of(|words| words.told).or_else(|| of(|words| words.asked))
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
    pub fn about(&self, grammar: &Grammar) -> Option<Intent> {
        if has(&self.pieces, "HAND off|away .. PART") || has(&self.pieces, "leave|left PART alone|be") {
            return Some(Intent::TouchOwn);
        }
        if has(&self.pieces, "HAND off|away")
            || has(&self.pieces, "leave|left THING|SOME alone|be|where|there|in")
        {
            return Some(Intent::Touch);
        }
        let told = grammar.iter().filter(|(intent, _)| intent.moves()).flat_map(|(intent, words)| {
            listed(words.told).map(|pattern| (*intent, pattern.trim_start_matches("^ ")))
        });
        let taken = told.filter_map(|(intent, pattern)| Some((taken(&self.pieces, pattern)?.len(), intent)));
        // The longest, the first of as long ones.
        let best = taken.min_by_key(|(length, _)| Reverse(*length));
        let verb = || DOING.iter().find(|(verbs, _)| has(&self.pieces, verbs)).map(|(_, intent)| *intent);
        best.map(|(_, intent)| intent).or_else(verb)
    }

    /// What is said alone: a greeting, yes, no.
    pub fn alone(&self, grammar: &Grammar) -> Option<Intent> {
        let whole = self.most(grammar, |words| words.said, &self.pieces);
        whole
            .map(|(intent, ..)| intent)
            .or_else(|| self.says(grammar, |words| words.said).map(|(intent, _)| intent))
    }
}

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

/// Whether pieces deny or forbid something.
pub(super) fn denies(pieces: &[Piece]) -> bool {
    // "The last thing I want is …"
    let last = |pair: &[Piece]| pair[0].words.iter().any(|word| word == "last") && pair[1].is("i we");
    listed(DENYING).any(|pattern| has(pieces, pattern)) || pieces.windows(2).any(last)
}

/// All words of these lists.
pub(super) fn patterns() -> impl Iterator<Item = &'static str> {
    listed(DENYING)
}

/// What is not so, in what is to be found out or asked, forbids nothing: "see whether it isn't there", "isn't there anything?"
fn facts(pieces: &mut Vec<Piece>) {
    const FACTS: &str = "see|check|find|tell|know|ask|wonder|say|show|feel|look|learn|sure|out ?me|us ?out if|whether|why|what|which|who|where|how|when \
        .. be|have|=did|=does not $";
    let denied = |k: usize, pieces: &[Piece]| {
        pieces[k].is("not")
            && (has(&pieces[..=k], FACTS) && !has(&pieces[..k], "and|but")
                || has(&pieces[..=k], "^ ?ANY be not $")
                    && pieces.get(k + 1).is_some_and(|next| next.is("there")))
    };
    while let Some(k) = (0..pieces.len()).find(|&k| denied(k, pieces)) {
        pieces.remove(k);
    }
}

fn mood(pieces: &[Piece], asks: bool) -> Mood {
    let wish = pieces.iter().find_map(|piece| piece.wanted);
    let wanted = wish.is_some();
    if wish == Some(Wish::Answer) {
        return Mood::Question;
    }
    let inverted = has(pieces, "^ !=do !=have !need HELPING ?not SUBJECT|THING|SOME|BODY")
        || has(pieces, "^ be|=does ?any ?of its|your|the|any")
        || has(pieces, "^ =do|=have|need ?not SUBJECT|BODY|THING !AGAIN")
            // "Have it close to you."
            && (asks || !has(pieces, "^ =have THING|BODY") || has(pieces, "PAST"));
    let inverted = inverted
        && (asks || !has(pieces, "^ =do not you"))
        && !has(pieces, "^ =do THING|that|so|SOME ?ALL|MORE|one|over AGAIN|MORE|over");
    let wonders = has(
        pieces,
        "^ i|we|my|let|THING .. KNOW|=wondering|curious|interested|idea|question|sure|unsure|TELL|ask|hear|learn|find ?me|is ?of|out ?about ASKING|if|whether",
    ) || has(pieces, NOT_KNOWING);
    let tagged = has(pieces, TAG) && asks;
    let asks_within = !pieces.first().is_some_and(|first| first.word.form.is_base())
        && has(
            pieces,
            "what|how|where|which|who =is|=are|=do|=does|can|could|would ?THING|BODY|you|THING|SOME",
        );
    let asking = tagged
        || wonders
        || asks_within
        || has(pieces, "^ ?and|so|in|on|to|for|with|at|from|by|about|up ?to ASKING")
        || has(pieces, "^ let me|us =know|=hear")
        || inverted
        || has(pieces, "^ any|DOING|ok|okay") && asks
        || has(pieces, "^ ?have|do ?you ?have ?you ?any|no idea");
    let hypothetical = hypothetical(pieces);
    if asks && has(pieces, "=did|=have|=has|=were|=was .. not") && past(pieces) {
        return Mood::Past;
    }
    if !hypothetical && denies(pieces) && !(asking && negative_question(pieces)) {
        return Mood::Prohibition;
    }
    if has(pieces, "i|we would ?really|absolutely hate|dislike|loathe|resent|mind|object") {
        return Mood::Prohibition;
    }
    if hypothetical {
        return Mood::Hypothesis;
    }
    let command = pieces.first().is_some_and(|first| first.sense == Sense::Word && first.word.form.is_base())
        && !inverted;
    if past(pieces) && (has(pieces, "^ TELL") || !wanted && !command) {
        return Mood::Past;
    }
    match () {
        // What is to be told is asked for, however it is wanted.
        () if TELLING.iter().any(|telling| has(pieces, telling)) => Mood::Question,
        () if wanted => Mood::Command,
        () if asking => Mood::Question,
        () if command || begins_as_command(pieces) => Mood::Command,
        () if asks => Mood::Question,
        () => Mood::Statement,
    }
}

/// Whether what is denied in a question forbids nothing: "haven't you …?", "can you reach it without leaning?"
fn negative_question(pieces: &[Piece]) -> bool {
    if has(pieces, "about not") || has(pieces, "not .. not") {
        return false;
    }
    has(pieces, "^ HELPING not SUBJECT|THING|SOME|BODY & !nothing")
        || has(pieces, NOT_KNOWING)
        || has(pieces, TAG)
        || has(pieces, "^ ?and|so why|how|what|where|who|which")
        || has(pieces, "not $")
        || has(pieces, "without") && !has(pieces, "not|never|no") && has(pieces, "able|REACH|get|GRAB|TOUCH")
}

/// Whether it begins as a command does without a verb, or with what it is to be done with.
fn begins_as_command(pieces: &[Piece]) -> bool {
    let subject = has(pieces, "^ SUBJECT")
        || has(pieces, "^ THING|SOME|BODY HELPING|be|PAST|THIRD")
        || has(pieces, "^ to VERB")
        || has(pieces, "^ !=using DOING");
    let verb = |piece: &Piece| piece.sense == Sense::Word && piece.word.form.is_base();
    let means = has(
        pieces,
        "^ with|by|using|to|back|over|in|from|on|up|down|away|off|BODY|THING|SOME|left|right|out|again",
    );
    let bare = pieces.iter().all(|piece| {
        piece.sense != Sense::Word || piece.word.form == Form::Other || verb(piece) && !piece.is("be have do")
    });
    !subject && (bare || means && pieces.iter().any(verb) || has(pieces, "^ =be"))
}

fn hypothetical(pieces: &[Piece]) -> bool {
    let whether = has(
        pieces,
        "see|check|find|out|tell|know|feel|look|ask|wonder|say|determine|test|learn|sure|idea|care|clear ?me|us|THING|with ?HAND if|whether",
    );
    let inverted = has(pieces, "^ =were|=should|=had THING|SOME|BODY|SUBJECT")
        && pieces.last().is_some_and(|last| last.word.mark == Some(Mark::Pause));
    [
        "^ suppose|supposing|imagine|pretend|assume & !POSE",
        "^ say you",
        "would happen",
        "what =happens",
        "^ when|before|after|until|while|once you|i|THING|SUBJECT",
    ]
    .iter()
    .any(|pattern| has(pieces, pattern))
        || inverted
        || (!whether && has(pieces, "if|unless|whether") && !has(pieces, "^ HELPING .. REACH|reach|able|get"))
}

/// Whether it is of what was.
fn past(pieces: &[Piece]) -> bool {
    let done = has(pieces, "PAST");
    if has(pieces, "=have|=has|=had ?THING|SOME|BODY|SUBJECT =got") {
        return false;
    }
    has(pieces, "=did|=was|=were|=had|=happened|=went")
        || has(pieces, "=have|=has|=having & PAST") && done
        || has(pieces, "=have|=has =been")
        || has(
            pieces,
            "SUBJECT|you|THING|SOME|BODY|HAND =put|=set|=let|=hit|=touched|=pushed|=moved|=lifted|=found|=felt|=held|=took|=brought|=dropped|=leaned|=reached|=picked|=grabbed",
        )
        || has(pieces, "^ ASKING|you|i|he|she|we|they|THING PAST & !can|could|will|would|VERB")
        || has(pieces, "^ any luck|success")
        || has(
            pieces,
            "^ be you|THING ?all|already|SOME =done|=finished|=moved|=put|=touched|=lifted|=pushed|successful",
        )
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
        let anew = piece.is("and then but")
            && next.is_some_and(|next| next.word.form.is_base() || next.is("can could would will"))
            && part.iter().any(verb)
            && !has(part, "^ ?ANY use")
            && !(length(rest, "VERB").is_some()
                && has(part, "^ ?ANY USE|take|REACH|raise|lift ?out|up HAND ?out|up|and and|$|then"))
            && !(length(rest, "VERB").is_some()
                && has(part, "^ ?ANY REACH out|over|across|forward|up|down $"));
        if anew {
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
