//! What asks: to be told, or to feel about, or whether it could; nothing of it asks for something else to be done.

use super::lexicon::Form;
use super::mood::leads_in;
use super::patterns::has;
use super::slots::{Piece, Sense};
use super::words::Mark;

/// Verbs whose command asks to be told.
pub(super) const TELLING: &[&str] = &[
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
pub(super) const ASKING: &[&str] =
    &["what", "where", "whereabouts", "which", "who", "whom", "whose", "when", "why", "how", "whether"];
pub(super) const SUBJECTS: &[&str] = &[
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
pub(super) const HELPING: &[&str] = &[
    "be", "do", "have", "should", "shall", "must", "may", "might", "can", "could", "will", "would", "need",
    "ought",
];

/// Whether it begins as a question does, or ends so.
pub(super) fn asks(pieces: &[&Piece]) -> bool {
    let first = pieces.iter().find(|piece| !leads_in(piece));
    first.is_some_and(|first| first.word.is(ASKING) || first.word.is(HELPING))
        || pieces.last().is_some_and(|last| last.word.mark == Some(Mark::Question))
}

/// "Is there anything?": it takes feeling about to say.
pub(super) fn searching(pieces: &[&Piece]) -> bool {
    // "Have you checked whether there is anything?" is of what was.
    if has(pieces, "if|whether there be SOME|more|another") {
        let was = "^ =did|=had|=were you|we|i|he|she|they";
        return !has(pieces, was) && !has(pieces, "^ =have you|we|i|he|she|they .. whether");
    }
    [
        "^ be there SOME",
        "^ be THING possible|likely ?that there be SOME",
        "^ might|could|would|will|may ?there be ?there SOME",
        "^ do you ?think|reckon|believe|suppose|guess|expect ?that there be SOME",
        "^ what have ?we|you|i =got ?here|there ?out on|in|before|there|here|$",
        "^ be THING ?still ?out|over there $",
        "^ what be ?out|over there",
        "^ what might|could|may|would be ?there|lie on|in|at|near|around|before|there|out|here",
        "^ ?be ?there any|a sign|trace|hint of SOME",
        "^ be there THING in|on|near|before|around|there|here",
        "^ be there ?any|some|more ?more $",
        "^ be there ?any|some|more more|other",
        "^ be SOME there|near|around|before|close|ahead|here|left|within|on|nearby|lie|stand",
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
        "^ can|could|=do you feel|sense|notice|perceive SOME in|on|near|around|nearby|before|there|within",
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
pub(super) fn ability(pieces: &[&Piece]) -> bool {
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
        "^ can|could you .. without",
        "^ would|could|will|can you ever",
        "^ should|shall you|i|we",
    ]
    .iter()
    .any(|pattern| has(pieces, pattern))
        && !has(pieces, "^ can|could i|we ask|trouble|beg|get|have you to")
        && !has(pieces, "^ can|could we|i have|get you")
}

/// A verb that stands between the subject and the rest, turned about.
pub(super) fn asked_of(pieces: &[&Piece]) -> bool {
    let [first, second, ..] = pieces else { return false };
    let helping = first.word.is(HELPING) && first.sense == Sense::Word;
    let subject =
        second.word.is(SUBJECTS) || second.is_body() || matches!(second.sense, Sense::Thing | Sense::Some);
    // "Do people ask you to …": of others.
    let others = first.word.text == "do"
        && second.sense == Sense::Word
        && second.word.form == Form::Other
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
pub(super) fn telling(pieces: &[&Piece]) -> bool {
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
