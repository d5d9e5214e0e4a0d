//! What forbids: "don't", "no lifting", "leave it alone", "the last thing I want".

use super::asking::{ASKING, HELPING, SUBJECTS, ability, asked_of};
use super::lexicon::Form;
use super::mood::leads_in;
use super::patterns::has;
use super::slots::{Piece, Sense};
use super::words::Mark;

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
    "let THING be $",
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

/// What is not so, where that is to be found out or told.
const FACTS: &str = "see|check|find|tell|know|ask|wonder|say|show|feel|look|learn|test|verify|sure|out ?me|us ?out if|whether|why|what|which|who|where|how|when !and|but .. be|have|=did|=does not $";

/// What is not so, in what is to be found out or asked, forbids nothing: "see whether it isn't there", "isn't there
/// anything?" That is said of facts alone: whoever says "see if you can not touch it" may forbid it.
pub(super) fn facts(pieces: &mut [Piece]) {
    for k in 0..pieces.len() {
        let begins =
            pieces[..k].iter().rposition(|piece| piece.word.mark.is_some()).map_or(0, |mark| mark + 1);
        let before = pieces[begins..=k].iter().filter(|piece| piece.sense != Sense::Filler);
        let before: Vec<&Piece> = before.collect();
        let asked =
            has(&before, "^ be not") && pieces.get(k + 1).is_some_and(|next| next.word.is(&["there"]));
        let told = || has(&before, FACTS);
        if pieces[k].word.is(&["not"]) && pieces[k].sense == Sense::Word && (asked || told()) {
            pieces[k].sense = Sense::Filler;
        }
    }
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
    let asks = pieces.iter().any(|piece| piece.word.mark == Some(Mark::Question));
    let inverted = first.word.is(HELPING) && second.word.is(&["not"]) && third.word.is(SUBJECTS);
    let emphatic = first.word.text == "do" && !asks;
    let why = first.word.is(&["why"]);
    let whether = first.word.is(ASKING)
        || first.word.is(HELPING)
        || (first.word.is(&["so", "and"]) && second.word.is(HELPING));
    (inverted && !emphatic) || (why && asks) || (whether && has(pieces, "or not $"))
}
