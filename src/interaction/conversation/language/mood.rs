//! What a clause is: a command, a polite request, a question, a report of what is past, a prohibition, or none of these.

use super::asking::{ASKING, HELPING, SUBJECTS, TELLING, ability, asked_of, searching, telling};
use super::forbidding::forbids;
use super::lexicon::Form;
use super::patterns::has;
use super::slots::{Piece, Sense};
use super::words::Mark;

/// What a clause is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mood {
    /// "Touch it."
    Command,
    /// "Could you touch it?"
    Polite,
    /// "Is there something?": asks for feeling about.
    Search,
    /// "Where is it?", "tell me where it is".
    Question,
    /// "Did you touch it?", "what have you done?"
    Past,
    /// "Don't touch it."
    Prohibition,
    /// "If you touched it …"
    Hypothesis,
    /// "It is near."
    Statement,
}

/// What others are to do, or what is but to be thought of.
const OF_OTHERS: &[&str] = &[
    "^ let|make|have|allow|get|watch|see|tell|ask him|her|me|people|others ?to VERB",
    "^ remember|recall|enjoy|regret|like|love|hate|miss|mention|discuss|fear|deny|admit|imagine|consider|recollect DOING",
    "^ remember|recall|recollect when|how|that|what|where|why|who",
    "^ think|dream|talk|speak|read|write|sing|worry|hear ?about|of|on|over DOING|VERB",
];

/// What a clause is.
pub(super) fn mood(pieces: &[&Piece], asks: bool) -> Mood {
    if has(pieces, "^ why not|do not you") && pieces.len() < 5 {
        return Mood::Statement;
    }
    if forbids(pieces) {
        // "You didn't touch it, did you?"
        let past = asks
            && (has(pieces, "^ you|it|THING =did|=have|=had|=were|=was not")
                || has(pieces, "^ you .. =did|=have|=had|=were|=was not you|it|THING $"));
        return if past { Mood::Past } else { Mood::Prohibition };
    }
    let rest: Vec<&Piece> = pieces.iter().copied().skip_while(|piece| leads_in(piece)).collect();
    let pieces = if rest.is_empty() { pieces } else { rest.as_slice() };
    let Some(first) = pieces.first() else { return Mood::Statement };
    if hypothetical(pieces) {
        return Mood::Hypothesis;
    }
    if searching(pieces) {
        return Mood::Search;
    }
    if OF_OTHERS.iter().any(|pattern| has(pieces, pattern)) {
        return if telling(pieces) { Mood::Question } else { Mood::Statement };
    }
    if first.requested {
        return if telling(pieces) { Mood::Question } else { Mood::Polite };
    }
    if has(pieces, "^ can|could|would you|BODY|THING .. reach .. if") {
        return Mood::Question;
    }
    if past(pieces) {
        return Mood::Past;
    }
    if ability(pieces) {
        return Mood::Question;
    }
    let tells = telling(pieces);
    if polite(pieces) {
        return if tells { Mood::Question } else { Mood::Polite };
    }
    if !asks && has(pieces, "^ THING|SOME be =coming|=approaching|=flying|=heading") {
        return Mood::Statement;
    }
    if first.word.is(ASKING) && !has(pieces, "^ how about =") || asked_of(pieces) {
        return Mood::Question;
    }
    if tells || has(pieces, "^ i .. know|wonder|ask|curious|interest") || has(pieces, "^ let me know") {
        return Mood::Question;
    }
    let tagged = has(pieces, "can|could|will|would you $");
    if tagged {
        return Mood::Polite;
    }
    match (asks, commands(pieces)) {
        (true, _) => Mood::Question,
        (false, true) => Mood::Command,
        (false, false) => Mood::Statement,
    }
}

pub(super) fn leads_in(piece: &Piece) -> bool {
    let words = [
        "and",
        "then",
        "but",
        "hey",
        "hi",
        "hello",
        "ok",
        "okay",
        "right",
        "alright",
        "great",
        "good",
        "fine",
        "first",
        "next",
        "thanks",
        "thank",
        "sorry",
        "yes",
        "yeah",
        "sure",
        "no",
        "or",
        "let",
        "us",
        "whoa",
        "excuse",
        "finally",
        "second",
        "attention",
        "well",
        "robot",
        "quick",
        "hurry",
        "careful",
        "listen",
        "look",
    ];
    piece.sense == Sense::Filler
        // "Your chin, can you touch it?"
        || ((piece.is_body() || piece.sense == Sense::Thing) && piece.word.mark == Some(Mark::Pause))
        || (piece.sense == Sense::Word
            && piece.word.is(&words)
            && !(piece.word.is(&["let", "look", "listen"]) && piece.word.mark.is_none()))
}

fn hypothetical(pieces: &[&Piece]) -> bool {
    let whether =
        has(pieces, "see|check|find|out|tell|know|feel|look|ask|wonder|say|determine|test|learn ?me|us if");
    if has(
        pieces,
        "^ can|could|would you|BODY|THING ?be ?able ?to ?in|within reach|touch|get ?at|to ?THING if",
    ) {
        return false;
    }
    let patterns = [
        "^ suppose|imagine|pretend",
        "^ assume you|i|that|THING|he|she",
        "^ say you",
        "would happen",
        "what =happens",
        "^ when|before|after|until|while you|it|i|THING",
    ];
    // "Were it on the left, …"
    let inverted = pieces.last().is_some_and(|last| last.word.mark == Some(Mark::Pause))
        && has(pieces, "^ =were|=should THING|SOME|BODY|you|i|we|he|she|they|there");
    inverted || patterns.iter().any(|pattern| has(pieces, pattern)) || (!whether && has(pieces, "if"))
}

fn polite(pieces: &[&Piece]) -> bool {
    [
        "^ can|could|will|would you",
        "^ may|might|can|could i|we ask|trouble|bother|beg|have|get you",
        "^ would THING|it be possible",
        "^ how|what about THING|SOME|HAND|a|one|another",
        "^ be so kind|good|nice",
        "^ time for",
        "^ can|could|would|will THING come|go|move|be|get .. nearer|closer|farther|further",
    ]
    .iter()
    .any(|pattern| has(pieces, pattern))
}

/// What is past.
fn past(pieces: &[&Piece]) -> bool {
    let begins = pieces.first().is_some_and(|first| {
        first.sense == Sense::Word
            && first.word.form.is_base()
            && !first.word.is(TELLING)
            && !first.word.is(HELPING)
    });
    let does =
        pieces.first().is_some_and(|first| first.word.text == "do") && has(pieces, "^ do what|as|THING|SOME");
    if has(pieces, "^ can|could|will|would you VERB") && !telling(pieces) {
        return false;
    }
    if has(pieces, "where =have|=has you =got") || has(pieces, "^ =do|=does you|THING|SOME have") {
        return false;
    }
    if (begins && !has(pieces, "^ let|give|show")) || does {
        return false;
    }
    let done = pieces.iter().any(|piece| {
        piece.sense == Sense::Word
            && piece.word.form == Form::Past
            && (piece.word.text == "done" || !piece.word.is(&["be", "do", "have", "suppose", "allow"]))
    });
    let helped = has(pieces, "=did|=was|=were|=had");
    let perfect = has(pieces, "=have|=has|=having you|THING|it|he|SOME|BODY|there|i|not")
        && (done || has(pieces, "=been|=done"));
    let perfect = perfect && !has(pieces, "=has|=have THING|you|SOME|we|i =got ..");
    let perfect = perfect
        || has(pieces, "^ =have|=has|=had you|SOME|THING .. =put|=set|=let|=hit|=come")
        || (has(pieces, "you|THING|it|i|SOME|BODY =have|=has|=had") && done)
        || has(pieces, "you =have|=had =put|=set|=let|=hit");
    let told = has(
        pieces,
        "you|max|BODY|he =touched|=pushed|=moved|=reached|=leaned|=felt|=found|=lifted|=dropped|=put|=took|=did|=went|=held|=brought|=grabbed|=picked|=forgot|=avoided|=explored|=searched|=used|=made|=tried|=hit|=bumped|=knocked|=heard|=noticed|=released|=rested|=stopped|=pulled|=placed|=dodged|=met|=came|=got|=had|=tapped|=poked",
    );
    let wanted = has(pieces, "^ ?so|that you =put|=set|=let|=hit")
        && !has(
            pieces,
            "can|could|would|will|should|want|need|like|have|must|may|shall|wish|get|ask you =put|=set|=let|=hit",
        )
        && !has(pieces, "=did|=have you =put");
    helped
        || perfect
        || (told && !has(pieces, "you =put|=hit"))
        || wanted
        || has(pieces, "what|how ?=has|=have =happened")
        || has(pieces, "=happened")
        || has(pieces, "^ any luck|success")
        || has(pieces, "^ be you done|finished|successful|ready")
        || has(pieces, "^ be THING|it done|finished|=moved|=put|=touched|=lifted|=pushed")
}

/// Whether it begins as a command does: with a verb, or with how or by what hand it is to be done.
fn commands(pieces: &[&Piece]) -> bool {
    let Some(first) = pieces.first() else { return false };
    let verb = |piece: &Piece| piece.sense == Sense::Word && piece.word.form.is_base();
    // "To touch it would be a mistake."
    if first.word.is(&["to"]) && pieces.get(1).is_some_and(|next| verb(next)) {
        return false;
    }
    if verb(first) && !first.word.is(&["be", "mean", "matter"]) || (first.word.text == "be") {
        return true;
    }
    let subject = first.sense == Sense::Word && first.word.is(SUBJECTS)
        || matches!(first.sense, Sense::Thing | Sense::Some)
            && pieces.get(1).is_some_and(|next| next.word.form != Form::Other || next.word.is(HELPING));
    let means =
        ["with", "by", "using", "use", "to", "back", "over", "in", "from", "on", "up", "down", "away", "off"];
    let adverb = first.word.is(&means)
        || first.word.text == "using"
        || first.is_body()
        || first.word.text.ends_with("ly")
        || matches!(first.sense, Sense::Thing | Sense::Some);
    if adverb && !subject && pieces.iter().any(|piece| verb(piece)) {
        return true;
    }
    // Without any verb: "closer", "once more", "left hand on the box".
    let bare = pieces.iter().all(|piece| {
        piece.word.form == Form::Other
            || piece.sense != Sense::Word
            || piece.word.form.is_base()
                && piece.word.is(&["rest", "go", "try", "place", "position", "start", "contact"])
    });
    bare && !subject
}
