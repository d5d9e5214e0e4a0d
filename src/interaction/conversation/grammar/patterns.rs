//! Patterns of pieces, by which requests say what means them, and frames how they are asked for.
//!
//! A pattern is a row of alternatives: `touch|tap` is either lemma, `=touching` the very word, `?a` may be missing, `..` is any number of
//! pieces, `!a|b` where neither follows, `^` and `$` are the ends of the clause. Capitals are kinds of pieces (THING, SOME, STICK, HAND, PART,
//! BODY, SIDE, VERB, BASE, PAST, THIRD, DOING, ANY, WANTED: what a frame wants) and meanings ([`lexicon`](super::lexicon): TOUCH, FAR, AGAIN). `A & B` is both, in any order.

use super::lexicon::Form;
use super::pieces::{Piece, Sense};

/// The pieces that a pattern takes, where they have it in them.
pub(super) fn taken(pieces: &[Piece], pattern: &str) -> Option<Vec<usize>> {
    let mut all = Vec::new();
    for part in pattern.split(" & ") {
        let tokens: Vec<&str> = part.split_whitespace().collect();
        match tokens.as_slice() {
            ["^", rest @ ..] => all.extend(from(pieces, 0, rest)?.0),
            [denied] if denied.starts_with('!') => {
                if pieces.iter().any(|piece| is(piece, &denied[1..])) {
                    return None;
                }
            }
            tokens => all.extend((0..=pieces.len()).find_map(|k| from(pieces, k, tokens))?.0),
        }
    }
    Some(all)
}

/// The patterns of a list, parted by `;`.
pub(super) fn listed(patterns: &str) -> impl Iterator<Item = &str> {
    patterns.split(';').map(str::trim).filter(|pattern| !pattern.is_empty())
}

/// Whether pieces have one of some patterns in them, parted by `;`.
pub(super) fn has(pieces: &[Piece], patterns: &str) -> bool {
    listed(patterns).any(|pattern| taken(pieces, pattern).is_some())
}

/// How many pieces a pattern takes that they begin with; `None` if they do not.
pub(super) fn length(pieces: &[Piece], pattern: &str) -> Option<usize> {
    let tokens: Vec<&str> = pattern.split_whitespace().collect();
    from(pieces, 0, &tokens).map(|(_, end)| end)
}

/// The pieces that tokens take from one on, and where they end.
fn from(pieces: &[Piece], k: usize, tokens: &[&str]) -> Option<(Vec<usize>, usize)> {
    let Some((token, rest)) = tokens.split_first() else { return Some((Vec::new(), k)) };
    let next = pieces.get(k);
    match *token {
        "$" => next.is_none().then(|| (Vec::new(), k)),
        ".." => (k..=pieces.len()).find_map(|k| from(pieces, k, rest)),
        token if token.starts_with('!') => {
            if next.is_some_and(|next| is(next, &token[1..])) {
                None
            } else {
                from(pieces, k, rest)
            }
        }
        token => {
            let (optional, token) = token.strip_prefix('?').map_or((false, token), |token| (true, token));
            let with = next.filter(|next| is(next, token)).and_then(|_| from(pieces, k + 1, rest));
            let with = with.map(|(mut taken, end)| {
                taken.push(k);
                (taken, end)
            });
            // An article says nothing that a pattern would have to name.
            let article =
                || next.filter(|next| next.is("a an the")).and_then(|_| from(pieces, k + 1, tokens));
            with.or_else(|| optional.then(|| from(pieces, k, rest)).flatten()).or_else(article)
        }
    }
}

fn is(piece: &Piece, token: &str) -> bool {
    let word = piece.sense == Sense::Word;
    let verb = |forms: &[Form]| word && forms.contains(&piece.word.form);
    token.split('|').any(|token| match token {
        "THING" => piece.sense == Sense::Thing,
        "SOME" => piece.sense == Sense::Some,
        "STICK" => piece.is_stick(),
        "SIDE" => matches!(piece.sense, Sense::Side(_)),
        "HAND" => matches!(piece.sense, Sense::Hand(_)),
        "PART" => matches!(piece.sense, Sense::Part(_)),
        "BODY" => piece.is_body(),
        "VERB" => verb(&[Form::Base, Form::BaseOrPast]),
        "BASE" => verb(&[Form::Base]),
        "PAST" => verb(&[Form::Past, Form::BaseOrPast]),
        "THIRD" => verb(&[Form::Third]),
        "DOING" => verb(&[Form::Ing]),
        "ANY" => word,
        "WANTED" => !word && piece.wanted.is_some(),
        token if token.starts_with(char::is_uppercase) => {
            (word || piece.sense == Sense::Some) && piece.meanings.contains(&token)
        }
        token => match token.strip_prefix('=') {
            Some(form) => piece.words.len() == 1 && piece.word.text == form,
            None => piece.words.len() == 1 && (piece.word.lemma == token || piece.word.text == token),
        },
    })
}

/// The words of a pattern that are words.
pub(super) fn words(pattern: &str) -> impl Iterator<Item = &str> {
    let tokens = pattern.split_whitespace().flat_map(|token| token.trim_start_matches(['?', '!']).split('|'));
    let tokens = tokens.map(|word| word.trim_start_matches('='));
    tokens
        .filter(|word| !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit()))
}
