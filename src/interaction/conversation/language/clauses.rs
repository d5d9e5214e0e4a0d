//! The clauses of an utterance: each has a verb of its own, and a mood.

use super::asking;
use super::forbidding;
use super::gist;
use super::lexicon::Form;
use super::mood::{self, Mood};
use super::patterns::{has, length};
use super::slots::{Piece, Sense};
use super::words::Mark;
use crate::interaction::conversation::requests::{Intent, REQUESTS};

/// Verbs that are enough to know what is forbidden: "no pushing".
const DOING: &[(&[&str], Intent)] = &[
    (&["touch", "tap", "poke", "contact", "reach"], Intent::Touch),
    (&["push", "shove", "put", "move", "slide", "shift"], Intent::PutFar),
    (&["pull", "bring", "drag"], Intent::BringNear),
    (&["lift", "pick", "grab", "grasp", "raise", "hold", "take"], Intent::Lift),
    (&["lean", "bend", "tilt"], Intent::LeanForward),
    (&["drop", "release"], Intent::LetGo),
    (&["explore", "search", "feel", "find"], Intent::Explore),
    (&["forget"], Intent::Forget),
];

/// What is wanted where something is to end that is going on; there is no leave in it.
const ENDING: &[(&str, Intent)] = &[
    ("stop|quit|cease =holding|=gripping|=grasping", Intent::LetGo),
    ("stop|quit|cease =leaning|=bending", Intent::LeanBack),
    ("stop|quit|cease =talking|=listening", Intent::Quit),
    ("^ stop|quit|cease|halt what|whatever you", Intent::Stop),
    ("^ stop|quit|cease|halt ?THING $", Intent::Stop),
    (
        "move|step|go|get|lean|duck|dodge|jump .. THING|SOME ?can|could|do|will|would not hit|touch|get|reach|bump|catch|meet",
        Intent::Avoid,
    ),
    ("nothing|nobody touch|hit|reach|get you|PART", Intent::Avoid),
    ("not let THING|SOME touch|hit|reach|get you|BODY", Intent::Avoid),
];

/// A clause without the words that say nothing.
pub(super) struct Clause<'a> {
    pieces: Vec<&'a Piece>,
    /// What it is.
    pub mood: Mood,
}

impl<'a> Clause<'a> {
    fn new(pieces: Vec<&'a Piece>, asks: bool) -> Clause<'a> {
        let mood = mood::mood(&pieces, asks);
        Clause { pieces, mood }
    }

    /// The mark that it ends with.
    pub fn mark(&self) -> Option<Mark> {
        self.pieces.last().and_then(|last| last.word.mark)
    }

    /// Whether it tells something, and asks nothing: "you have done enough, …".
    pub fn tells(&self) -> bool {
        matches!(self.mood, Mood::Past | Mood::Statement | Mood::Question) && !asking::asks(&self.pieces)
    }

    /// Whether it begins with a verb that cannot be of what was: "put" may be.
    pub fn commands_now(&self) -> bool {
        let first = self.pieces.iter().find(|piece| !mood::leads_in(piece));
        first.is_some_and(|first| first.word.form == Form::Base)
    }

    /// Whether it forbids something.
    pub fn forbids(&self) -> bool {
        forbidding::forbids(&self.pieces)
    }

    fn says(&self, patterns: &[&str]) -> bool {
        let stripped: Vec<&Piece> =
            self.pieces.iter().copied().skip_while(|piece| mood::leads_in(piece)).collect();
        let polite = length(&stripped, "can|could|will|would you").unwrap_or(0);
        let stripped = &stripped[polite..];
        patterns
            .iter()
            .any(|pattern| has(&self.pieces, pattern) || (pattern.starts_with('^') && has(stripped, pattern)))
    }

    /// The request that it means, what is said by itself apart.
    pub fn meant(&self) -> Option<Intent> {
        let first = |patterns: fn(&super::super::requests::RequestKind) -> &'static [&'static str]| {
            REQUESTS.iter().find(|(_, kind)| self.says(patterns(kind))).map(|(intent, _)| *intent)
        };
        let (told, asked, past) =
            (|| first(|kind| kind.told), || first(|kind| kind.asked), || first(|kind| kind.past));
        match self.mood {
            Mood::Command | Mood::Polite => {
                gist::way(&self.pieces).or_else(told).or_else(|| gist::told(&self.pieces)).or_else(asked)
            }
            Mood::Search => asked().filter(|intent| *intent == Intent::HowMany).or(Some(Intent::Explore)),
            Mood::Question => asked().or_else(|| told().filter(|_| self.echoes())),
            Mood::Past => past(),
            Mood::Prohibition if self.says(super::super::requests::STILL) => Some(Intent::KeepStill),
            Mood::Prohibition => ENDING
                .iter()
                .find(|(pattern, _)| has(&self.pieces, pattern))
                .map(|(_, intent)| *intent)
                .or_else(|| self.about().map(|_| Intent::Dont)),
            Mood::Statement => told().filter(|_| self.pieces.len() > 1 && self.wishes()),
            Mood::Hypothesis => None,
        }
    }

    /// The request that it is about, whatever it says of it.
    pub fn about(&self) -> Option<Intent> {
        if self.says(&["HAND off", "leave|left THING|SOME alone|be", "keep HAND off|away|from|to"]) {
            return Some(Intent::Touch);
        }
        let loose = |pattern: &&&str| has(&self.pieces, pattern.trim_start_matches('^').trim_start());
        REQUESTS
            .iter()
            .find(|(_, kind)| kind.told.iter().any(|pattern| loose(&pattern)))
            .map(|(intent, _)| *intent)
            .or_else(|| {
                DOING
                    .iter()
                    .find(|(verbs, _)| self.pieces.iter().any(|piece| piece.word.is(verbs)))
                    .map(|(_, intent)| *intent)
            })
    }

    /// What is said by itself: a greeting, yes, no.
    pub fn by_itself(&self) -> Option<Intent> {
        REQUESTS.iter().find(|(_, kind)| self.says(kind.said)).map(|(intent, _)| *intent)
    }

    /// "Touch it?": a command but for its mark.
    fn echoes(&self) -> bool {
        self.pieces.first().is_some_and(|first| first.word.form.is_base())
            || self.says(&["^ should|shall you|i", "^ do|would|will you like|want|prefer|love"])
    }

    /// A statement of what somebody wants: nothing that is said of others, or of what was.
    fn wishes(&self) -> bool {
        let others =
            self.pieces.first().is_some_and(|first| first.word.is(&["he", "she", "they", "we", "i"]));
        !others
            && !self.pieces.iter().any(|piece| {
                piece.word.form == Form::Past || (piece.sense == Sense::Word && !piece.word.known)
            })
    }
}

/// The clauses: parted at marks and at "and", "then", "but", where there is a verb on either side.
pub(super) fn of(pieces: &[Piece]) -> Vec<Clause<'_>> {
    let verb = |piece: &Piece| {
        piece.sense == Sense::Word && piece.word.form != Form::Other && piece.word.text != "using"
    };
    let mut parts: Vec<(Vec<&Piece>, bool)> = Vec::new();
    let mut part: Vec<&Piece> = Vec::new();
    for (k, piece) in pieces.iter().enumerate() {
        let joins = piece.sense == Sense::Word && piece.word.is(&["and", "then", "but"]);
        let rest = &pieces[k..];
        let begins_anew = joins
            && rest
                .iter()
                .skip(1)
                .find(|next| next.sense == Sense::Word && !next.word.is(&["then", "not", "do", "never"]))
                .is_some_and(|next| {
                    next.word.form.is_base() || next.word.is(&["can", "could", "would", "will"])
                });
        if begins_anew && part.iter().any(|piece| verb(piece)) {
            parts.push((std::mem::take(&mut part), false));
        }
        if piece.sense != Sense::Filler {
            part.push(piece);
        }
        let marked = piece.word.mark.is_some();
        let asks = piece.word.mark == Some(Mark::Question);
        if marked {
            let sentence = piece.word.mark >= Some(Mark::Stop);
            let more = pieces[k + 1..].iter().any(verb);
            let tag = tag(&pieces[k + 1..]);
            if (part.iter().any(|piece| verb(piece)) && more && !tag)
                || (sentence && more && part.iter().any(|piece| piece.sense != Sense::Word))
            {
                parts.push((std::mem::take(&mut part), asks));
            } else if asks {
                parts.push((std::mem::take(&mut part), true));
            }
        }
    }
    if !part.is_empty() {
        parts.push((part, false));
    }
    parts.retain(|(part, _)| !part.is_empty());
    parts.into_iter().map(|(part, asks)| Clause::new(part, asks)).collect()
}

/// "…, can you?", "…, did you?"
fn tag(pieces: &[Piece]) -> bool {
    let said: Vec<&Piece> = pieces.iter().filter(|piece| piece.sense != Sense::Filler).collect();
    said.len() <= 3 && has(&said, "^ can|could|will|would|do|have|be ?not you|it|THING $")
}
