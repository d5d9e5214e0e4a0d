//! What an utterance means: its words, mended; what they name; what kind of sentence each clause is; and the request.
//!
//! ```text
//! words ─ lexicon, spelling ─▶ pieces (a thing, a hand, a part: slots, body_names) ─▶ clauses ─▶ mood ─▶ request
//!                                                                                            └──▶ leave to move
//! ```

mod asking;
mod body_names;
mod clauses;
mod courtesies;
mod fillers;
mod forbidding;
mod frames;
mod gist;
mod idioms;
mod leave;
mod lexicon;
mod light_verbs;
mod mood;
mod noun_phrases;
mod patterns;
mod places;
mod slots;
mod spelling;
mod synonyms;
mod words;

use std::ops::Deref;

pub use body_names::PartName;
pub(in crate::interaction) use body_names::{name_words, patch_name};
pub use leave::Leave;
pub use mood::Mood;
pub use places::{Aside, End};
pub use slots::{HandName, Which};

use self::body_names::BodyNames;
use self::clauses::Clause;
use self::lexicon::Lexicon;
use self::patterns::has;
use self::slots::{Piece, Sense};
use self::words::Mark;
use super::requests::{Intent, REQUESTS, STILL};
use crate::peripersonal::OwnBody;

/// Words before a noun that nobody knows here: what it names is what the utterance is about.
const BEFORE_NOUNS: &[&str] = &[
    "the", "a", "an", "my", "your", "our", "some", "any", "this", "that", "of", "about", "to", "from",
    "with", "in", "on", "at", "for", "into", "no", "up", "down", "over",
];

/// What is wanted, with what it names.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// What is wanted.
    pub intent: Intent,
    /// The hand that is to do it.
    pub hand: Option<HandName>,
    /// The part of the body that it is about.
    pub part: Option<PartName>,
    /// Which of several things.
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
    pub unknown: Vec<String>,
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
}

impl Language {
    /// The language without names of any creature's own.
    pub fn everyday() -> Language {
        Language::with(BodyNames::everyday())
    }

    /// The language, and what a creature's parts are called.
    pub fn of(own: &OwnBody) -> Language {
        Language::with(BodyNames::of(own))
    }

    fn with(names: BodyNames) -> Language {
        let patterns = REQUESTS.iter().flat_map(|(_, kind)| kind.patterns()).flat_map(patterns::words);
        let still = STILL.iter().copied().flat_map(patterns::words);
        let frames = courtesies::patterns()
            .flat_map(patterns::words)
            .chain(patterns::good_words())
            .chain(idioms::words());
        let words = patterns.chain(still).chain(frames).chain(fillers::words());
        let mut words: Vec<&str> = words.chain(noun_phrases::words()).chain(places::words()).collect();
        words.extend(names.words());
        let lexicon = Lexicon::new(words);
        Language { lexicon, names }
    }

    /// What was said means.
    pub fn understand(&self, heard: &str) -> Understood {
        let words = words::words(heard, &self.lexicon);
        let pieces = frames::unframed(slots::pieces(&words, &self.names), &self.lexicon);
        let clauses = clauses::of(&pieces);
        // Across clauses as well: "anything but …".
        let said: Vec<&Piece> = pieces.iter().filter(|piece| piece.sense != Sense::Filler).collect();
        let forbids = clauses.iter().any(Clause::forbids) || forbidding::forbids(&said);
        let unknown: Vec<String> = pieces
            .iter()
            .filter(|piece| piece.sense == Sense::Word && !piece.word.known)
            .map(|piece| piece.word.text.clone())
            .collect();
        let meant = self.meant(&pieces, &clauses);
        let which = slots::which(&pieces);
        // "The one nearest you", and nothing else.
        let names = |piece: &&Piece| {
            piece.sense == Sense::Thing
                || (piece.sense == Sense::Word && piece.word.form == lexicon::Form::Other)
        };
        let answers = which.is_some() && unknown.is_empty() && said.iter().all(names);
        let (intent, clause) = meant.unwrap_or((if answers { Intent::Which } else { Intent::Unknown }, 0));
        let mood = clauses.get(clause).map_or(Mood::Statement, |clause| clause.mood);
        let asks = match intent {
            Intent::HowFar | Intent::WhereOwn | Intent::WhereFelt | Intent::NearOrFar => true,
            Intent::Unknown => clauses.iter().any(|clause| clause.mood == Mood::Question),
            // "Is it bigger than your hand?" is about no place.
            Intent::HowBig => !has(&said, "than"),
            _ => false,
        };
        let related = places::related(&pieces).filter(|_| asks);
        let intent = match &related {
            Some((End::Part(_), _)) => Intent::WhereOwn,
            Some(_) if !matches!(intent, Intent::WhereFelt | Intent::NearOrFar) => Intent::HowFar,
            _ => intent,
        };
        let hypothesis = clauses.iter().any(|clause| clause.mood == Mood::Hypothesis);
        // Whatever is denied anywhere, it is better to ask.
        let denied = said.iter().any(|piece| piece.word.is(&["not", "never", "no", "nope", "nah"]));
        let aside = places::aside(&pieces).filter(|_| intent == Intent::PutAside);
        let clear = aside.is_none_or(|aside| aside.clear);
        let whole = unknown.is_empty() && !hypothesis && !denied && clear && !words::quotes(heard);
        let leave = (intent.moves()).then(|| Leave::by_words(mood, whole, forbids)).flatten();
        let about = match intent {
            Intent::Dont | Intent::Report => clauses.iter().find_map(Clause::about),
            // "Lean forward and touch it."
            Intent::LeanForward => clauses.iter().skip(clause + 1).find_map(Clause::meant),
            _ => None,
        };
        let about = about
            .filter(|about| intent != Intent::LeanForward || (about.moves() && *about != Intent::Repeat));
        let lean = leans(&pieces) && !matches!(intent, Intent::LeanForward | Intent::LeanBack);
        let (hand, part) = slots::hand_and_part(&pieces, about.unwrap_or(intent));
        let any =
            |lemmas: &[&str]| pieces.iter().any(|piece| piece.words.len() == 1 && piece.word.is(lemmas));
        let request = Request {
            intent,
            hand,
            part,
            which,
            related,
            aside,
            stick: slots::with_stick(&pieces),
            lean,
            again: any(&["again", "retry", "repeat", "try", "once"]),
            all: any(&["everything", "all"])
                || pieces.iter().any(|piece| piece.words.iter().any(|word| word == "all")),
            any: pieces.iter().any(|piece| piece.sense == Sense::Some),
            open: any(&["what", "which", "where", "how", "when", "why", "who"]),
            about,
        };
        Understood { request, mood, forbids, unknown, leave }
    }

    /// The request, and in which clause it is.
    fn meant(&self, pieces: &[Piece], clauses: &[Clause]) -> Option<(Intent, usize)> {
        let found: Vec<(Intent, usize)> =
            clauses.iter().enumerate().filter_map(|(k, clause)| Some((clause.meant()?, k))).collect();
        // What is wanted comes before what is forbidden beside it.
        let wanted = found.iter().find(|(intent, _)| *intent != Intent::Dont).or(found.first()).copied();
        // What is said of it before it is told: "it's coming, dodge".
        let told = |(intent, k): &(Intent, usize)| {
            wanted.is_some_and(|(first, _)| first == *intent)
                && matches!(clauses[*k].mood, Mood::Command | Mood::Polite)
        };
        let wanted = found.iter().copied().find(told).or(wanted);
        // "Where is it? Touch it!": a sentence of its own that tells to do something.
        let doing = |(intent, k): &(Intent, usize)| {
            let before = k.checked_sub(1).and_then(|before| clauses[before].mark());
            let goes_on =
                before.is_some() && clauses[*k].commands_now() && clauses[..*k].iter().all(Clause::tells);
            let told = matches!(clauses[*k].mood, Mood::Command | Mood::Polite);
            intent.moves() && told && (before >= Some(Mark::Stop) || goes_on)
        };
        let asked =
            wanted.filter(|(_, k)| matches!(clauses[*k].mood, Mood::Question | Mood::Statement | Mood::Past));
        let wanted = asked.and_then(|_| found.iter().copied().find(doing)).or(wanted);
        // "Here is a stick: take it."
        let offered = |before: usize| {
            let offers = |(intent, k): &(Intent, usize)| {
                *intent == Intent::TakeStick && *k < before && clauses[*k].mood == Mood::Statement
            };
            found.iter().any(offers)
        };
        let takes = |(intent, k): &(Intent, usize)| {
            *intent == Intent::Lift && matches!(clauses[*k].mood, Mood::Command | Mood::Polite) && offered(*k)
        };
        let taken = found.iter().find(|meant| takes(meant)).map(|(_, k)| (Intent::TakeStick, *k));
        let wanted = taken.or(wanted);
        // To bend down is but the way to touch one's own leg.
        let own = found.iter().find(|(intent, _)| *intent == Intent::TouchOwn).copied();
        let wanted = if matches!(wanted, Some((Intent::LeanForward, _))) { own.or(wanted) } else { wanted };
        let about_nothing = strange_noun(pieces);
        match wanted {
            Some((Intent::Dont, clause)) => Some((Intent::Dont, clause)),
            Some(wanted) if !about_nothing => Some(wanted),
            _ => clauses.iter().enumerate().find_map(|(k, clause)| Some((clause.by_itself()?, k))),
        }
    }
}

/// Whether the trunk is to help: "leaning forward", "lean".
fn leans(pieces: &[Piece]) -> bool {
    pieces.iter().any(|piece| piece.sense == Sense::Word && piece.word.lemma == "lean")
}

/// Whether an utterance is about something that nobody here knows: the moon, politics.
fn strange_noun(pieces: &[Piece]) -> bool {
    let foreign = |piece: &Piece| piece.sense == Sense::Word && !piece.word.known;
    (0..pieces.len()).any(|k| {
        if !foreign(&pieces[k]) {
            return false;
        }
        let ends_phrase = pieces[k].word.mark.is_some()
            || pieces.get(k + 1).is_none_or(|next| {
                next.sense != Sense::Thing
                    && next.sense != Sense::Some
                    && !next.is_body()
                    && (next.word.is(BEFORE_NOUNS)
                        || foreign(next)
                        || next.word.form != lexicon::Form::Other
                        || next.word.is(&["and", "or", "be", "please"]))
            });
        let object = k == 0
            || pieces[k - 1].word.is(BEFORE_NOUNS)
            || foreign(&pieces[k - 1])
            || pieces[k - 1].word.form != lexicon::Form::Other;
        ends_phrase && object
    })
}

/// What words mean, without a creature's own names.
pub fn understood(request: &str) -> Understood {
    static EVERYDAY: std::sync::LazyLock<Language> = std::sync::LazyLock::new(Language::everyday);
    EVERYDAY.understand(request)
}
