//! Patterns of words, by which requests say what means them.
//!
//! A pattern is a row of words in their dictionary form. `a|b` is either; `?a` may be missing; `..` is any number of words;
//! `^` and `$` are the ends of the clause. `=touching` is the very form. `THING` is one that is known ("it", "the left
//! one"), `SOME` one that is not ("something", "an object"), `HAND` a hand of its own, `PART` any other part of its body,
//! `BODY` either.

use super::slots::{Piece, Sense};

/// Whether pieces have a pattern in them.
pub(super) fn has(pieces: &[&Piece], pattern: &str) -> bool {
    let tokens: Vec<&str> = pattern.split_whitespace().collect();
    match tokens.split_first() {
        Some((&"^", rest)) => goes_on(pieces, rest),
        _ => (0..=pieces.len()).any(|k| goes_on(&pieces[k..], &tokens)),
    }
}

fn goes_on(pieces: &[&Piece], tokens: &[&str]) -> bool {
    let Some((token, rest)) = tokens.split_first() else { return true };
    match *token {
        "$" => pieces.is_empty(),
        ".." => (0..=pieces.len()).any(|k| goes_on(&pieces[k..], rest)),
        token => {
            let (optional, token) = token.strip_prefix('?').map_or((false, token), |token| (true, token));
            let taken = pieces.first().is_some_and(|piece| is(piece, token));
            (taken && goes_on(&pieces[1..], rest)) || (optional && goes_on(pieces, rest))
        }
    }
}

fn is(piece: &Piece, token: &str) -> bool {
    token.split('|').any(|word| match word {
        "THING" => piece.sense == Sense::Thing,
        "SOME" => piece.sense == Sense::Some,
        "HAND" => matches!(piece.sense, Sense::Hand(_)),
        "PART" => matches!(piece.sense, Sense::Part(_)),
        "BODY" => piece.is_body(),
        word => match word.strip_prefix('=') {
            Some(form) => piece.word.text == form,
            None => piece.words.len() == 1 && piece.word.lemma == word,
        },
    })
}

/// The words of a pattern that are words.
pub(super) fn words(pattern: &str) -> impl Iterator<Item = &str> {
    let tokens = pattern.split_whitespace().flat_map(|token| token.trim_start_matches('?').split('|'));
    let tokens = tokens.map(|word| word.trim_start_matches('='));
    tokens
        .filter(|word| word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit()) && !word.is_empty())
}
