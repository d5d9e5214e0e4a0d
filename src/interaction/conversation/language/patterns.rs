//! Patterns of words, by which requests say what means them, and frames how they are asked for.
//!
//! A pattern is a row of words in their dictionary form. `a|b` is either; `?a` may be missing; `..` is any number of words;
//! `^` and `$` are the ends of the clause; `!a|b` where neither follows. `=touching` is the very form. `THING` is one that is known ("it", "the left
//! one"), `SOME` one that is not ("something", "an object"), `STICK` a stick, `HAND` a hand of its own, `PART` any
//! other part of its body, `BODY` either, `SIDE` a side to which a thing is to be moved. `VERB` is any verb as it is told, `PAST` as of what was, `DOING` its gerund; `GOOD` is what pleases, `ANY`
//! any word.

use super::lexicon::Form;
use super::slots::{Piece, Sense};

/// What pleases whom it is done for.
const GOOD: &str = "good nice great lovely wonderful splendid helpful handy useful super brilliant fantastic marvellous \
    excellent perfect ideal best better wise wiser smart clever kind sweet cool awesome amazing fun funny grateful glad \
    happy happier pleased delighted delightful thankful obliged appreciative thrilled grand fab terrific preferable \
    advisable desirable sensible magnificent superb neat overjoyed ecstatic chuffed convenient nicer easier";

/// Whether pieces have a pattern in them.
pub(super) fn has(pieces: &[&Piece], pattern: &str) -> bool {
    let tokens: Vec<&str> = pattern.split_whitespace().collect();
    match tokens.split_first() {
        Some((&"^", rest)) => behind(pieces, rest).is_some(),
        _ => (0..=pieces.len()).any(|k| behind(&pieces[k..], &tokens).is_some()),
    }
}

/// How many pieces a pattern takes that they begin with; none where they do not.
pub(super) fn length(pieces: &[&Piece], pattern: &str) -> Option<usize> {
    let tokens: Vec<&str> = pattern.split_whitespace().collect();
    behind(pieces, &tokens).map(|rest| pieces.len() - rest)
}

/// How many pieces are left behind those that tokens take.
fn behind(pieces: &[&Piece], tokens: &[&str]) -> Option<usize> {
    let Some((token, rest)) = tokens.split_first() else { return Some(pieces.len()) };
    match *token {
        "$" => pieces.is_empty().then_some(0),
        token if token.starts_with('!') => {
            let none = pieces.iter().all(|piece| !is(piece, &token[1..]));
            none.then(|| behind(pieces, rest)).flatten()
        }
        ".." => (0..=pieces.len()).find_map(|k| behind(&pieces[k..], rest)),
        token => {
            let (optional, token) = token.strip_prefix('?').map_or((false, token), |token| (true, token));
            let taken = pieces.first().filter(|piece| is(piece, token));
            taken
                .and_then(|_| behind(&pieces[1..], rest))
                .or_else(|| optional.then(|| behind(pieces, rest)).flatten())
        }
    }
}

fn is(piece: &Piece, token: &str) -> bool {
    let verb = |fits: fn(Form) -> bool| piece.sense == Sense::Word && fits(piece.word.form);
    token.split('|').any(|word| match word {
        "THING" => piece.sense == Sense::Thing,
        "SOME" => piece.sense == Sense::Some,
        "STICK" => piece.is_stick(),
        "SIDE" => matches!(piece.sense, Sense::Side(_)),
        "HAND" => matches!(piece.sense, Sense::Hand(_)),
        "PART" => matches!(piece.sense, Sense::Part(_)),
        "BODY" => piece.is_body(),
        "VERB" => verb(Form::is_base),
        "PAST" => verb(|form| matches!(form, Form::Past | Form::BaseOrPast)),
        "DOING" => verb(|form| form == Form::Ing),
        "GOOD" => GOOD.split_whitespace().any(|good| piece.word.lemma == good),
        "ANY" => piece.sense == Sense::Word,
        word => match word.strip_prefix('=') {
            Some(form) => piece.words.len() == 1 && piece.word.text == form,
            None => piece.words.len() == 1 && (piece.word.lemma == word || piece.word.text == word),
        },
    })
}

/// The words of a pattern that are words.
pub(super) fn words(pattern: &str) -> impl Iterator<Item = &str> {
    let tokens = pattern.split_whitespace().flat_map(|token| token.trim_start_matches(['?', '!']).split('|'));
    let tokens = tokens.map(|word| word.trim_start_matches('='));
    tokens
        .filter(|word| word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit()) && !word.is_empty())
}

/// The words that please.
pub(super) fn good_words() -> impl Iterator<Item = &'static str> {
    GOOD.split_whitespace()
}
