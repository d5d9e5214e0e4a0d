//! What kind of sentence a clause is, a table of patterns: the first row that fits.

use super::patterns::has;
use super::pieces::Piece;

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

/// Moods, each with patterns; a statement, where none fits. What is wanted is asked for, or told, as its frame says.
const MOODS: &[(Mood, &str)] = &[
    (Mood::Question, "ANSWER"),
    (Mood::Past, "@past & QUESTION & =did|=have|=has|=were|=was .. not"),
    (Mood::Prohibition, "@denies & !@supposed & !@negative_question"),
    (Mood::Prohibition, "i|we would ?really|absolutely hate|dislike|loathe|resent|mind|object"),
    (Mood::Hypothesis, "@supposed"),
    (Mood::Past, "@past & ^ TELL; @past & !WISHED & !@told"),
    // What is to be told is asked for, however it is wanted: "describe it", "give me an estimate".
    (Mood::Question, "^ TELL|COUNT; ^ give me|us !THING|SOME|back|STICK|my"),
    (Mood::Command, "WISHED"),
    (Mood::Question, "@asking"),
    (Mood::Command, "@told; @begins"),
    (Mood::Question, "QUESTION"),
];

/// Patterns by a name, `@name` in others: what denies or forbids, wherever it stands; a verb first; a verb before who does it, not
/// "have it close to you"; what asks without a mark, or wonders; what the partner does not know, and would; "…, isn't it?"; questions
/// in which what is denied forbids nothing, "haven't you …?"; what is asked with "if" and supposes nothing; what is but supposed; what
/// was, but "have you got it?"; what begins as a command does without a verb, or with what it is to be done with.
const NAMED: &str = "\
    denies: not|never|without|neither|nor|refrain|abstain|cease|desist|prevent|forbid|prohibit|unless; \
        nobody|none|nothing; instead of; rather than; avoid|stop|quit|skip|hate|dislike|loathe|mind|resent ?with \
        ?THING|you|it DOING; leave|left THING|SOME|BODY alone|be; leave off; leave|left THING where|in; let THING \
        be $; ^ HAND off; no ?more DOING|TOUCH|PUSH|LEAN|LIFT|REACH|PULL|GRAB|PUT|contact; keep HAND \
        off|away|from; hold off|back from|DOING; keep|stay off; keep|away|refrain|far from DOING|TOUCH; from \
        DOING; forget ?about DOING; i|we would ?really|absolutely hate|dislike|loathe|resent|mind|object; BAD \
        if|to|for|idea; HAND to yourself; keep HAND to; no business; anything|SOME but; under|by|on no; be \
        forbidden|=forbidden; off limits; make no; nowhere; no need|reason|longer|point; last thing; no|nope|nah \
        ?ANY ?THING $; beware of; cut THING out; :last i|we\n\
    told: ^ !a|an|the VERB & !@inverted\n\
    inverted: ^ !=do !=have !need HELPING ?not SUBJECT|THING|SOME|BODY; ^ be|=does ?any ?of its|your|the|any; \
        ^ =do|=have|need ?not SUBJECT|BODY|THING !AGAIN & !@do_it\n\
    do_it: ^ =have THING|BODY & !QUESTION & !PAST; ^ =do not you & !QUESTION; ^ =do THING|that|so|SOME \
        ?ALL|MORE|one|over AGAIN|MORE|over\n\
    asking: @inverted; what|how|where|which|who =is|=are|=do|=does|can|could|would ?THING|BODY|you|THING|SOME \
        & !@verb; ^ i|we|my|let|THING .. \
        KNOW|=wondering|curious|interested|idea|question|sure|unsure|TELL|ask|hear|learn|find ?me|is ?of|out \
        ?about ASKING|if|whether; ^ ?and|so|in|on|to|for|with|at|from|by|about|up ?to ASKING; ^ let me|us \
        =know|=hear; ^ ?have|do ?you ?have ?you ?any|no idea; @unknowing; @tag & QUESTION; ^ any|DOING|ok|okay & \
        QUESTION\n\
    verb: ^ !a|an|the VERB\n\
    unknowing: ^ i|we do|can|could not =know|=tell|=see|=remember|=understand\n\
    tag: =did|=does|=have|=has|=were|=was|=are|=is ?not you|THING $\n\
    negative: ^ HELPING not SUBJECT|THING|SOME|BODY & !nothing; ^ ?and|so why|how|what|where|who|which; not \
        $; @unknowing; @tag; without & !not|never|no & able|REACH|get|GRAB|TOUCH\n\
    twice: about not; not .. not\n\
    negative_question: @asking & @negative & !@twice\n\
    whether: see|check|find|out|tell|know|feel|look|ask|wonder|say|determine|test|learn|sure|idea|care|clear \
        ?me|us|THING|with ?HAND if|whether; ^ HELPING .. REACH|reach|able|get\n\
    supposed: ^ suppose|supposing|imagine|pretend|assume & !POSE; ^ say you; would happen; what =happens; ^ \
        when|before|after|until|while|once you|i|THING|SUBJECT; ^ =were|=should|=had THING|SOME|BODY|SUBJECT & \
        PAUSED $; unless|if|whether & !@whether\n\
    was: =did|=was|=were|=had|=happened|=went; =have|=has|=having & PAST; =have|=has =been; \
        SUBJECT|you|THING|SOME|BODY|HAND \
        =put|=set|=let|=hit|=touched|=pushed|=moved|=lifted|=found|=felt|=held|=took|=brought|=dropped|=leaned|=reached|=picked|=grabbed; \
        ^ ASKING|you|i|he|she|we|they|THING PAST & !can|could|will|would|VERB; ^ any luck|success; ^ be you|THING \
        ?all|already|SOME =done|=finished|=moved|=put|=touched|=lifted|=pushed|successful\n\
    past: @was & !@got\n\
    got: =have|=has|=had ?THING|SOME|BODY|SUBJECT =got\n\
    begins: ^ *BARE $ & !@stated; ^ \
        with|by|using|to|back|over|in|from|on|up|down|away|off|BODY|THING|SOME|left|right|out|again & VERB & \
        !@stated; ^ =be & !@stated\n\
    stated: ^ SUBJECT; ^ THING|SOME|BODY HELPING|be|PAST|THIRD; ^ to VERB; ^ !=using DOING";

/// The patterns of a name.
pub(super) fn named(name: &str) -> &'static str {
    let mut rows = NAMED.lines().filter_map(|row| row.split_once(": "));
    rows.find(|(other, _)| *other == name).map_or("", |(_, patterns)| patterns)
}

/// What kind of sentence pieces are.
pub(super) fn mood(pieces: &[Piece]) -> Mood {
    MOODS.iter().find(|(_, patterns)| has(pieces, patterns)).map_or(Mood::Statement, |(mood, _)| *mood)
}

/// Whether pieces deny or forbid something.
pub(super) fn denies(pieces: &[Piece]) -> bool {
    has(pieces, "@denies")
}
