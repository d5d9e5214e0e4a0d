//! What a clause is: a command, a polite request, a question, a report of what is past, a prohibition, or none of these.
//!
//! Only a command, a polite request, or a question that feeling about alone can answer gives [`Leave`] to move; all that
//! moves takes one. There is no other way to have one from words.

use super::lexicon::Form;
use super::patterns::has;
use super::slots::{Piece, Sense};

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

/// Leave to move. Only what a partner wants gives it: a command, a polite request, a "yes" to a question whether he wants
/// it, or a touch.
#[derive(Debug)]
pub struct Leave(());

impl Leave {
    /// Leave for a request is leave for what it asks to be done again.
    pub(in crate::interaction::conversation) fn again(&self) -> Leave {
        Leave(())
    }

    /// The leave that a touch of the skin gives: to put a hand there.
    pub(in crate::interaction::conversation) fn by_touch() -> Leave {
        Leave(())
    }

    /// The leave that words give; none unless all of them are understood and they ask for something to be done.
    pub(super) fn by_words(mood: Mood, whole: bool, forbidden: bool) -> Option<Leave> {
        let asked = matches!(mood, Mood::Command | Mood::Polite | Mood::Search);
        (asked && whole && !forbidden).then_some(Leave(()))
    }

    /// The leave that "yes" gives where it was asked whether it should.
    pub(in crate::interaction::conversation) fn by_yes(answer: &super::Understood) -> Option<Leave> {
        (answer.intent == super::Intent::Yes && !answer.forbids).then_some(Leave(()))
    }
}

/// What forbids, wherever it stands.
const FORBIDDING: &[&str] = &[
    "not",
    "never",
    "without",
    "refrain",
    "cease",
    "forbid|prohibit|ban",
    "nothing",
    "neither",
    "nor",
    "abstain|desist",
    "prevent",
    "unless",
    "instead of",
    "rather than",
    "avoid|stop|quit|skip ING",
    "stop|quit|cease ?with ?the ING",
    "leave THING|SOME|BODY alone|be",
    "leave off",
    "HAND off",
    "no ING",
    "no more",
    "no touch|push|lean|move|lift|reach|contact",
    "keep HAND off|away|from|to",
    "hold off|back from|ING",
    "keep|stay off",
    "keep from",
    "from ING",
    "forget ?about ING",
    "i|we would ?really ?absolutely hate|dislike|loathe|resent|mind|object",
    "left THING|BODY alone|be",
    "terrible|awful|horrible|bad|wrong|rude|angry|upset|unhappy|annoyed|shame|pity|unwise|dangerous|foolish if|to|for",
    "anything but",
    "under no",
    "by no means",
    "on no account",
    "no need",
    "no longer",
    "nobody|none",
    "far from ING",
    "beware of",
    "taboo",
    "last thing",
    "bad idea",
    "no !pause",
];

/// Verbs whose command asks to be told.
const TELLING: &[&str] = &[
    "tell",
    "say",
    "describe",
    "explain",
    "know",
    "report",
    "name",
    "count",
    "list",
    "answer",
    "remind",
    "inform",
    "guess",
    "estimate",
    "summarise",
    "summarize",
    "recount",
    "recap",
    "wonder",
    "introduce",
    "state",
    "specify",
    "mention",
    "compare",
    "ask",
    "beg",
    "order",
    "urge",
    "invite",
];
/// What begins a question.
const ASKING: &[&str] =
    &["what", "where", "whereabouts", "which", "who", "whom", "whose", "when", "why", "how", "whether"];
const SUBJECTS: &[&str] = &[
    "you",
    "i",
    "he",
    "she",
    "we",
    "they",
    "it",
    "there",
    "that",
    "this",
    "max",
    "people",
    "person",
    "robots",
    "everyone",
    "everybody",
    "others",
];
/// What others are to do, or what is but to be thought of.
const OF_OTHERS: &[&str] = &[
    "^ let|make|have|allow|get|watch|see|tell|ask him|her|me|people|others ?to VERB",
    "^ think|dream|talk|speak|read|write|sing|worry|hear ?about|of|on|over DOING|VERB",
];
const HELPING: &[&str] = &[
    "be", "do", "have", "should", "shall", "must", "may", "might", "can", "could", "will", "would", "need",
    "ought",
];

/// Whether pieces forbid something.
pub(super) fn forbids(pieces: &[&Piece]) -> bool {
    let last =
        |pair: &[&Piece]| pair[0].words.iter().any(|word| word == "last") && pair[1].word.is(&["i", "we"]);
    // "The last thing I want is …".
    if pieces.windows(2).any(last) {
        return true;
    }
    if negative_question(pieces)
        || has(pieces, "^ i|we do|can|could not know|remember|recall|see|tell|understand|feel|get")
    {
        return false;
    }
    let stripped: Vec<&Piece> = pieces.iter().copied().skip_while(|piece| leads_in(piece)).collect();
    if !has(pieces, "not|never|no") && has(pieces, "without") && (ability(&stripped) || asked_of(&stripped)) {
        return false;
    }
    FORBIDDING.iter().any(|pattern| forbidden_by(pieces, pattern))
}

fn forbidden_by(pieces: &[&Piece], pattern: &str) -> bool {
    if pattern == "no !pause" {
        // "No, …" answers; "no lifting" and "no …" otherwise forbid.
        return pieces.iter().enumerate().any(|(k, piece)| {
            piece.word.is(&["no"])
                && piece.word.mark.is_none()
                && k + 1 < pieces.len()
                && !pieces[k + 1].word.is(&["problem", "thanks", "worry"])
        });
    }
    if !pattern.contains("ING") || pattern.contains("THING") {
        return has(pieces, pattern);
    }
    // ING is any verb of that form.
    let ing = |piece: &&&Piece| piece.word.form == Form::Ing;
    pieces.iter().filter(ing).any(|piece| {
        let concrete = pattern.replace("ING", &format!("={}", piece.word.text));
        has(pieces, &concrete)
    })
}

/// "Isn't it …", "haven't you …": asks, and forbids nothing; "don't you touch it" does.
fn negative_question(pieces: &[&Piece]) -> bool {
    let [first, second, third, ..] = pieces else { return false };
    let asks = pieces.iter().any(|piece| piece.word.mark == Some(super::words::Mark::Question));
    let inverted = first.word.is(HELPING) && second.word.is(&["not"]) && third.word.is(SUBJECTS);
    let emphatic = first.word.text == "do" && !asks;
    let why = first.word.is(&["why"]);
    let whether = first.word.is(ASKING)
        || first.word.is(HELPING)
        || (first.word.is(&["so", "and"]) && second.word.is(HELPING));
    (inverted && !emphatic) || (why && asks) || (whether && has(pieces, "or not $"))
}

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
    if first.requested {
        return if telling(pieces) { Mood::Question } else { Mood::Polite };
    }
    if has(pieces, "^ can|could|would you|BODY .. reach .. if") {
        return Mood::Question;
    }
    if past(pieces) {
        return Mood::Past;
    }
    if ability(pieces) {
        return Mood::Question;
    }
    let tells = telling(pieces);
    if OF_OTHERS.iter().any(|pattern| has(pieces, pattern)) {
        return if tells { Mood::Question } else { Mood::Statement };
    }
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

/// Whether it begins as a question does, or ends so.
pub(super) fn asks(pieces: &[&Piece]) -> bool {
    let first = pieces.iter().find(|piece| !leads_in(piece));
    first.is_some_and(|first| first.word.is(ASKING) || first.word.is(HELPING))
        || pieces.last().is_some_and(|last| last.word.mark == Some(super::words::Mark::Question))
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
    ];
    piece.sense == Sense::Filler
        || (piece.sense == Sense::Word
            && piece.word.is(&words)
            && !(piece.word.is(&["let"]) && piece.word.mark.is_none()))
}

fn hypothetical(pieces: &[&Piece]) -> bool {
    let whether =
        has(pieces, "see|check|find|out|tell|know|feel|look|ask|wonder|say|determine|test|learn ?me|us if");
    if has(pieces, "^ can|could|would you|BODY ?be ?able ?to reach|touch|get ?at|to THING if") {
        return false;
    }
    let patterns = [
        "^ suppose|imagine|pretend|assume",
        "^ say you",
        "would happen",
        "what =happens",
        "^ when|before|after|until|while you|it|i|THING",
    ];
    patterns.iter().any(|pattern| has(pieces, pattern)) || (!whether && has(pieces, "if"))
}

/// "Is there anything?": it takes feeling about to say.
fn searching(pieces: &[&Piece]) -> bool {
    [
        "^ be there SOME",
        "^ be THING possible|likely ?that there be SOME",
        "^ might|could|would|will|may ?there be ?there SOME",
        "^ do you ?think|reckon|believe|suppose|guess|expect ?that there be SOME",
        "^ what have ?we|you|i =got ?here|there ?out on|in|before|there|here|$",
        "^ be THING ?still ?out|over there $",
        "^ what be ?out|over there",
        "^ be there THING in|on|near|before|around|there|here",
        "^ be there ?any|some|more ?more $",
        "^ be there ?any|some|more more|other",
        "^ be SOME there|near|around|before|close|ahead|here|left|within|on|nearby|lie|stand",
        "if|whether there be SOME|more|another",
        "^ what be ?lie on|in|near|before|around the|front|THING",
        "^ be SOME in ?your|the front|reach|vicinity|way",
        "^ ?any|some SOME ?else ?there|nearby|around|about|here|out|left|more ?there|here|now $",
        "^ ?any|some SOME ?else ?there|out|left on|in|around|about|near|before ?the|front|THING|you",
        "^ what|which ?SOME|THING be there|here ?on|in|before|near|around|close",
        "^ what be in|on|near|before|around front|you|THING|table|there|SOME",
        "^ what else be",
        "^ what else there|here|on|in|near|around|$",
        "^ what else do =you =find",
        "^ THING|SOME in front ?of",
        "^ what =do|can you find|discover|detect ?there|around|here|on|in|near",
        "^ can|could|=do you find|detect|locate|discover SOME",
        "^ can|could|=do you feel SOME in|on|near|around|nearby|before|there|within",
        "^ =do|=does SOME lie|stand|sit",
        "^ be THING|table empty",
    ]
    .iter()
    .any(|pattern| has(pieces, pattern))
        // What was there nobody feels now.
        && !has(pieces, "=was|=were")
        && !has(pieces, "touch|contact|press|push|hold")
        && !has(pieces, "more than|or")
        && !has(pieces, "be there|SOME BODY|you")
        && !has(pieces, "can|could you do|say|tell")
}

/// "Can you reach it?": asks whether, and does not ask for it.
fn ability(pieces: &[&Piece]) -> bool {
    [
        "^ can|could|would you .. reach ?at ?to THING $",
        "^ can|could you|BODY get THING $",
        "^ can|could you reach ?at ?to THING",
        "^ can|could you|BODY get at|to THING",
        "^ be|do|have you able|capable|think|have|need",
        "^ would|will you be able|capable",
        "^ would you have|need",
        "^ can|could BODY|THING|it|i|he|we|they",
        "^ can|could you see|hear|smell|taste|think|feel THING|SOME|me",
        "^ do you want|like|need|plan|intend|mean",
        "^ would|will you like|want|prefer|love|enjoy|hate|dislike|rather|agree",
        "^ would|do you mind if",
        "^ would|could|will|can you ever",
        "^ should|shall you|i|we",
    ]
    .iter()
    .any(|pattern| has(pieces, pattern))
        && !has(pieces, "^ can|could i|we ask|trouble|beg|get|have you to")
        && !has(pieces, "^ can|could we|i have|get you")
}

fn polite(pieces: &[&Piece]) -> bool {
    [
        "^ can|could|will|would you",
        "^ may|might|can|could i|we ask|trouble|bother|beg|have|get you",
        "^ would THING|it be possible",
        "^ how|what about THING|SOME|HAND|a|one|another",
        "^ be so kind|good|nice",
        "^ time for",
    ]
    .iter()
    .any(|pattern| has(pieces, pattern))
}

/// A verb that stands between the subject and the rest, turned about.
fn asked_of(pieces: &[&Piece]) -> bool {
    let [first, second, ..] = pieces else { return false };
    let helping = first.word.is(HELPING) && first.sense == Sense::Word;
    let subject =
        second.word.is(SUBJECTS) || second.is_body() || matches!(second.sense, Sense::Thing | Sense::Some);
    // "Do people ask you to …": of others.
    let others = first.word.text == "do"
        && second.sense == Sense::Word
        && second.word.form == super::lexicon::Form::Other
        && !second
            .word
            .is(&["as", "what", "so", "the", "a", "an", "same", "once", "one", "again", "whatever"])
        && !has(pieces, "again|more|same");
    if others && pieces[2..].iter().any(|piece| piece.sense == Sense::Word && piece.word.form.is_base()) {
        return true;
    }
    // "Do it", "have it": commands.
    let command = (first.word.text == "do" || first.word.text == "have" || first.word.text == "need")
        && !second.word.is(&["you", "i", "we", "they"])
        && !second.is_body()
        && !matches!(second.sense, Sense::Some);
    let contraction = second.word.is(&["not"]);
    let wh = pieces
        .iter()
        .any(|piece| piece.sense == Sense::Word && piece.word.is(&["where", "how", "who", "why"]))
        && !has(pieces, "^ feel|find|explore|go|return|put|move|come|see|let|get|work|figure|learn|check");
    (helping && (subject || contraction) && !command)
        || (wh && !pieces[0].word.form.is_base())
        || has(pieces, "^ in|on|to|at|by|from|for|with|of what|which|whom|whose|how")
        || has(pieces, "^ BODY|THING where|how be|do")
        || has(pieces, "^ BODY|THING be where")
}

/// What asks to be told: "tell me", "could you say".
fn telling(pieces: &[&Piece]) -> bool {
    let verb = pieces.iter().find(|piece| {
        piece.sense == Sense::Word
            && piece.word.form != Form::Other
            && !piece.word.is(HELPING)
            && !piece.word.is(&["want", "like", "try", "go", "think", "be", "let", "mind", "give"])
    });
    verb.is_some_and(|verb| verb.word.is(TELLING))
        || pieces.first().is_some_and(|first| first.word.is(TELLING))
        || has(
            pieces,
            "give|let me|us ?a|an|the ?rough|brief|short idea|estimate|summary|description|report|know|number|count|list|hear|account",
        )
        || has(pieces, "^ i .. =to know|hear")
        || has(pieces, "^ ?please ?can|could ?you show me ?what|where|how")
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
    if has(pieces, "where =have|=has you =got") {
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
