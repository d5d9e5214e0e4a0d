//! What an utterance means: acts × objects × relations × modifiers, said in patterns.
//!
//! ```text
//! words (lexicon) ─▶ pieces: a thing, a hand, a part (names) ─▶ frames, fillers fall away ─▶ clauses, each with a mood ─▶ request, leave to move
//! ```

mod clauses;
mod frames;
mod leave;
mod lexicon;
mod moods;
mod names;
mod patterns;
mod pieces;
mod places;
mod words;

use std::ops::Deref;

pub use leave::Leave;
pub use moods::Mood;
pub use names::{BodyNames, PartName};
pub(in crate::interaction) use names::{EVERYDAY, name_words, patch_name};
pub use pieces::{HandName, Which};
pub use places::{Aside, End};

use self::clauses::Clause;
use self::lexicon::{Form, Lexicon};
use self::patterns::has;
use self::pieces::{Piece, Sense};
use self::words::Mark;
use super::requests::Intent;

/// A request, how it is said, and a pattern of words that mean it then ([`patterns`](self::patterns)).
type Rule = (Intent, &'static str, &'static str);

/// What is wanted, with what it names.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// What is wanted.
    pub intent: Intent,
    /// The hand that is to do it.
    pub hand: Option<HandName>,
    /// The part of the body that it is about.
    pub part: Option<PartName>,
    /// Which of several things; `None` if it is not said, or there is no such one.
    pub which: Option<Which>,
    /// What a question puts in relation, and to which parts of the body.
    pub related: Option<(End, Vec<PartName>)>,
    /// To which side a thing is to be moved.
    pub aside: Option<Aside>,
    /// Whether it is to be done with a stick.
    pub stick: bool,
    /// Whether the trunk is to help.
    pub lean: bool,
    /// Whether what was done before is to be done again.
    pub again: bool,
    /// Whether it is about all things.
    pub all: bool,
    /// Whether it is about any thing that there may be: "an object".
    pub any: bool,
    /// Whether it asks what or which, not whether.
    pub open: bool,
    /// What a prohibition forbids, or a report is about.
    pub about: Option<Intent>,
}

/// A word that is not known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownWord {
    /// As it was typed.
    pub typed: String,
    /// The nearest known word, which it is taken for; `None` if there is none near.
    pub nearest: Option<String>,
}

impl UnknownWord {
    fn of(word: &words::Word) -> Option<UnknownWord> {
        let typed = word.unknown.clone()?;
        let nearest = Some(word.text.clone()).filter(|text| *text != typed);
        Some(UnknownWord { typed, nearest })
    }

    /// How it is asked back.
    pub fn in_words(&self) -> String {
        match &self.nearest {
            Some(nearest) => format!("I do not know the word \"{}\", only \"{nearest}\"", self.typed),
            None => format!("I do not know the word \"{}\"", self.typed),
        }
    }
}

/// What an utterance means.
#[derive(Debug)]
pub struct Understood {
    /// What is wanted.
    pub request: Request,
    /// What kind of sentence says so.
    pub mood: Mood,
    /// Whether anything is forbidden.
    pub forbids: bool,
    /// The words of it that are not known.
    pub unknown: Vec<UnknownWord>,
    /// Leave to move, where it gives any.
    pub leave: Option<Leave>,
}

impl Deref for Understood {
    type Target = Request;

    fn deref(&self) -> &Request {
        &self.request
    }
}

/// All that is needed to understand a partner.
pub struct Language {
    lexicon: Lexicon,
    names: BodyNames,
    grammar: Vec<Rule>,
}

impl Language {
    /// Requests and the words that mean them, and what a creature's parts are called.
    pub fn new(requests: impl Iterator<Item = (Intent, &'static str)>, names: BodyNames) -> Language {
        let mut grammar: Vec<Rule> = Vec::new();
        for (intent, words) in requests {
            let mut how = "";
            for pattern in patterns::listed(words) {
                let (heading, pattern) = pattern.split_once(": ").unwrap_or((how, pattern));
                how = heading;
                grammar.push((intent, how, pattern));
            }
        }
        let patterns = grammar.iter().map(|(.., pattern)| *pattern).chain(frames::patterns());
        let words = patterns.chain(patterns::listed(moods::named("denies"))).flat_map(patterns::words);
        let lexicon = Lexicon::new(words.map(String::from).chain(names.words().map(String::from)));
        Language { lexicon, names, grammar }
    }

    /// What was said means.
    pub fn understand(&self, heard: &str) -> Understood {
        let words = words::words(heard, &self.lexicon);
        let unknown: Vec<UnknownWord> = words.iter().filter_map(UnknownWord::of).collect();
        let pieces = pieces::pieces(&words, &self.names);
        let mut pieces = frames::unframed(pieces);
        places::sideways(&mut pieces);
        let clauses = clauses::of(&pieces);
        let forbids = clauses.iter().any(Clause::denies) || moods::denies(&pieces) && clauses.len() > 1;
        let which = pieces::which(&pieces);
        // "The one nearest you", and nothing else.
        let names = |piece: &Piece| {
            piece.sense == Sense::Thing || piece.sense == Sense::Word && piece.word.form == Form::Other
        };
        let answers = which.is_some() && unknown.is_empty() && pieces.iter().all(names);
        let other = if answers { Intent::Which } else { Intent::Unknown };
        let (intent, at, heads) = self.meant(&pieces, &clauses).unwrap_or((other, 0, false));
        let mood = clauses.get(at).map_or(Mood::Statement, |clause| clause.mood);
        let asks = match intent {
            Intent::HowFar | Intent::WhereOwn | Intent::WhereFelt | Intent::NearOrFar => true,
            Intent::Unknown => mood == Mood::Question,
            // "Is it bigger than your hand?" is about no place.
            Intent::HowBig => !has(&pieces, "than"),
            _ => false,
        };
        let related = places::related(&pieces).filter(|_| asks);
        let intent = match &related {
            Some((End::Part(_), _)) => Intent::WhereOwn,
            Some(_) if !matches!(intent, Intent::WhereFelt | Intent::NearOrFar) => Intent::HowFar,
            _ => intent,
        };
        let aside = places::aside(&pieces).filter(|_| intent == Intent::PutAside);
        // Whatever is denied or supposed anywhere, it is better to ask.
        let doubtful = clauses.iter().any(|clause| matches!(clause.mood, Mood::Hypothesis | Mood::Past))
            || forbids
            || clauses.iter().any(|clause| has(&clause.pieces, DOUBTFUL))
            || aside.is_some_and(|aside| !aside.clear)
            || words::quotes(heard);
        let whole = unknown.is_empty() && !doubtful;
        let explores = || intent == Intent::Explore && !has(&pieces, OF_NO_PLACE);
        let asked = heads && (mood == Mood::Command || mood == Mood::Question && explores());
        let leave = intent.moves().then(|| Leave::by_words(asked && whole)).flatten();
        let about = match intent {
            Intent::Dont | Intent::Report => clauses.iter().find_map(|clause| clause.about(&self.grammar)),
            // "Lean forward and touch it."
            Intent::LeanForward => clauses
                .iter()
                .skip(at + 1)
                .find_map(|clause| clause.meant(&self.grammar))
                .map(|meant| meant.0),
            _ => None,
        };
        let about = about
            .filter(|about| intent != Intent::LeanForward || (about.moves() && *about != Intent::Repeat));
        let (hand, part) = pieces::hand_and_part(&pieces, about.unwrap_or(intent));
        let any = |lemmas: &str| pieces.iter().any(|piece| piece.is(lemmas));
        let request = Request {
            intent,
            hand,
            part,
            which,
            related,
            aside,
            stick: pieces::with_stick(&pieces),
            lean: any("lean") && !matches!(intent, Intent::LeanForward | Intent::LeanBack),
            again: any("again retry repeat try once"),
            all: pieces
                .iter()
                .any(|piece| piece.words.iter().any(|word| word == "all" || word == "everything")),
            any: pieces.iter().any(|piece| piece.sense == Sense::Some),
            open: any("what which where how when why who"),
            about,
        };
        Understood { request, mood, forbids, unknown, leave }
    }

    /// The request, in which clause it is, and whether it may be done for that.
    fn meant(&self, pieces: &[Piece], clauses: &[Clause]) -> Option<(Intent, usize, bool)> {
        let found: Vec<(Intent, usize, bool)> = clauses
            .iter()
            .enumerate()
            .filter_map(|(k, clause)| clause.meant(&self.grammar).map(|(intent, heads)| (intent, k, heads)))
            .collect();
        let commands = |k: usize| clauses[k].mood == Mood::Command;
        // What is wanted comes before what is forbidden beside it, and what is told before what is asked or said.
        let wanted = found.iter().find(|(intent, ..)| *intent != Intent::Dont).or(found.first()).copied();
        let moves = |(intent, k, _): &(Intent, usize, bool)| commands(*k) && intent.moves();
        let heads = |meant: &(Intent, usize, bool)| moves(meant) && meant.2;
        let told =
            found.iter().find(|meant| heads(meant)).or(found.iter().find(|meant| moves(meant))).copied();
        let wanted = match (wanted, told) {
            (Some((_, k, _)), Some(told)) if !commands(k) && clauses[k].mark >= Some(Mark::Pause) => {
                Some(told)
            }
            _ => wanted,
        };
        // To take it is but the way to put it somewhere.
        let end = wanted.and_then(|(way, at, _)| {
            let (_, ends) = WAYS.iter().find(|(intent, _)| *intent == way)?;
            found.iter().copied().find(|(intent, k, _)| *k > at && commands(*k) && ends.contains(intent))
        });
        let wanted = end.or(wanted);
        let means_it = |(intent, at, _): &(Intent, usize, bool)| {
            *intent == Intent::Dont || !has(&clauses[*at].pieces, STRANGE) && !has(pieces, ELSEWISE)
        };
        let mut alone = clauses.iter().enumerate();
        let alone = || alone.find_map(|(k, clause)| Some((clause.alone(&self.grammar)?, k, false)));
        wanted.filter(means_it).or_else(alone)
    }
}

/// What makes it doubtful whether something is wanted, or wanted now; of somebody else; a question that lacks its "do you".
const DOUBTFUL: &str = "not|never|no|nope|nah|or|if|when|whenever|before|after|until|unless|provided|providing|assuming|tomorrow|later|day; \
    =stop|=wait|=halt; him|he|she|somebody|someone; next time; as i|we|he|she|they; as ?soon|long as; in case; on condition; =left|=right of THING|SOME|PART; the moment|second|minute|instant THING|SOME|BODY|SUBJECT; only|not once; ^ VERB =anything $; \
    ready|prepare to";
/// What makes a question whether there is anything one of no thing on the table: "is there anything that you can do?"
const OF_NO_PLACE: &str = "STICK; SOME ?that you|i|we|he; in|on|ON|under BODY; MORE than; ^ ?and what else $";
/// What is told first but is a way only to what is told then.
const WAYS: &[(Intent, &[Intent])] = &[
    (Intent::LeanForward, &[Intent::TouchOwn]),
    (Intent::Lift, &[Intent::PutFar, Intent::BringNear, Intent::PutAside]),
];
/// What is done to somebody else, and words that name parts or acts and mean something else.
const ELSEWISE: &str = "!feel TOUCH|GRAB|TEND|LIFT ?ON me|us|him|her|my|his|their|our; yourself together; close|open|shut PART; \
    lean on me; stand ON PART; feel free $; run away; in peace; keep in touch; keep the change; off you go; no hard";
/// What nobody here knows, where it is what is spoken of: the moon, politics; not how: "a systematic scan".
const STRANGE: &str = "^ UNKNOWN&MARKED; ^ UNKNOWN >$|UNKNOWN|ANY&INFLECTED|of|to|from|with|in|on|at|for|and|or|behind|like; \
    <my|our|your|some|any|this|that|of|about|to|from|with|in|on|at|for|into|no|UNKNOWN|INFLECTED UNKNOWN&MARKED; \
    <my|our|your|some|any|this|that|of|about|to|from|with|in|on|at|for|into|no|UNKNOWN|INFLECTED UNKNOWN \
    >$|UNKNOWN|ANY&INFLECTED|of|to|from|with|in|on|at|for|and|or|behind|like; <a|an|the UNKNOWN&MARKED; \
    <a|an|the UNKNOWN >$|UNKNOWN|PAST|DOING|THIRD|of|to|from|with|in|on|at|for|and|or|behind|like";
