//! Patterns of pieces, by which requests say what means them, and frames how they are asked for.
//!
//! A pattern is a row of alternatives: `touch|tap` is either lemma, `=touching` the very word, `:last` has that word in it, `a&b` is both,
//! `?a` may be missing, `*a` is any number of them, `*!a` of others, `..` of all; `!a|b` where neither follows, `>a` and `<a` where one
//! follows or is before, `<!a` where none is before; `^` and `$` are the ends of the clause. Capitals are kinds of pieces (THING, SOME,
//! STICK, HAND, PART, BODY, SIDE, VERB, BASE, PAST, THIRD, DOING, ANY; WANTED, WISHED and ANSWER by a frame; MARKED, QUESTION and PAUSED by a
//! mark) and meanings ([`lexicon`](super::lexicon): TOUCH, FAR, AGAIN). `A & B` is both, in any order; `@name` and `!@name` are
//! patterns of [`moods`](super::moods).

use super::frames::Wish;
use super::lexicon::Form;
use super::moods::named;
use super::pieces::{CLAUSES, Piece, Sense};
use super::words::Mark;

/// The pieces that a pattern takes, where they have it in them.
pub(super) fn taken(pieces: &[Piece], pattern: &str) -> Option<Vec<usize>> {
    let mut all = Vec::new();
    for part in pattern.split(" & ") {
        let tokens: Vec<&str> = part.split_whitespace().collect();
        match tokens.as_slice() {
            ["^", rest @ ..] => all.extend(from(pieces, 0, rest, true)?.0),
            [part] if part.trim_start_matches('!').starts_with('@') => {
                let (wanted, name) = part.split_once('@')?;
                if has(pieces, named(name)) != wanted.is_empty() {
                    return None;
                }
            }
            [denied] if denied.starts_with('!') => {
                if pieces.iter().any(|piece| is(piece, &denied[1..])) {
                    return None;
                }
            }
            tokens => all.extend((0..=pieces.len()).find_map(|k| from(pieces, k, tokens, true))?.0),
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
    end(pieces, 0, pattern, true)
}

/// Where a pattern ends that is at a place among pieces; `None` if it is not there. `articles` are skipped that it does not name.
pub(super) fn end(pieces: &[Piece], k: usize, pattern: &str, articles: bool) -> Option<usize> {
    let tokens: Vec<&str> = pattern.split_whitespace().collect();
    from(pieces, k, &tokens, articles).map(|(_, end)| end)
}

/// The pieces that tokens take from one on, and where they end; `articles` are skipped that no token names.
fn from(pieces: &[Piece], k: usize, tokens: &[&str], articles: bool) -> Option<(Vec<usize>, usize)> {
    let Some((token, rest)) = tokens.split_first() else { return Some((Vec::new(), k)) };
    let (before, next) = (k.checked_sub(1).map(|k| &pieces[k]), pieces.get(k));
    let go_on = |holds: bool| holds.then(|| from(pieces, k, rest, articles)).flatten();
    let (kind, alternatives) = match token.split_at(1) {
        ("<", denied) if denied.starts_with('!') => {
            return go_on(before.is_none_or(|before| !is(before, &denied[1..])));
        }
        ("<", alternatives) => return go_on(before.is_some_and(|before| is(before, alternatives))),
        (">", following) => {
            return go_on(next.map_or(following.starts_with('$'), |next| is(next, following)));
        }
        ("!", denied) => return go_on(next.is_none_or(|next| !is(next, denied))),
        ("^", "") => return go_on(k == 0),
        ("$", "") => return go_on(next.is_none()),
        (kind @ ("?" | "*"), alternatives) => (kind, alternatives),
        _ => ("", *token),
    };
    if alternatives == ".." {
        return (k..=pieces.len()).find_map(|k| from(pieces, k, rest, articles));
    }
    if alternatives == "CLAUSE" {
        let clause = |clause| {
            let tokens: Vec<&str> = str::split_whitespace(clause).chain(rest.iter().copied()).collect();
            from(pieces, k, &tokens, articles)
        };
        return listed(CLAUSES).find_map(clause).or_else(|| go_on(kind == "?"));
    }
    let takes = |next: &&Piece| match alternatives.strip_prefix('!') {
        Some(denied) => !is(next, denied),
        None => is(next, alternatives),
    };
    let after = if kind == "*" { tokens } else { rest };
    let with = next.filter(takes).and_then(|_| from(pieces, k + 1, after, articles));
    let with = with.map(|(mut taken, end)| {
        taken.push(k);
        (taken, end)
    });
    // An article says nothing that a pattern would have to name.
    let article = || {
        let skipped = next.filter(|next| articles && next.is("a an the"));
        skipped.and_then(|_| from(pieces, k + 1, tokens, articles))
    };
    with.or_else(|| go_on(!kind.is_empty())).or_else(article)
}

/// Whether a piece is what one of some alternatives says; all of what `&` joins.
pub(super) fn is(piece: &Piece, token: &str) -> bool {
    token.split('|').any(|token| token.split('&').all(|token| is_one(piece, token)))
}

fn is_one(piece: &Piece, token: &str) -> bool {
    let word = piece.sense == Sense::Word;
    let verb = |forms: &[Form]| word && forms.contains(&piece.word.form);
    match token {
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
        "INFLECTED" => piece.word.form != Form::Other,
        "UNKNOWN" => word && piece.word.unknown.as_ref() == Some(&piece.word.text),
        "MARKED" => piece.word.mark.is_some(),
        "WISHED" => piece.wanted.is_some(),
        "ANSWER" => piece.wanted == Some(Wish::Answer),
        "QUESTION" => piece.word.mark == Some(Mark::Question),
        "PAUSED" => piece.word.mark == Some(Mark::Pause),
        "BARE" => {
            !word || piece.word.form == Form::Other || piece.word.form.is_base() && !piece.is("be have do")
        }
        "WANTED" => !word && piece.wanted.is_some(),
        token if token.starts_with(char::is_uppercase) => {
            (word || piece.sense == Sense::Some) && piece.meanings.contains(&token)
        }
        token if token.starts_with(':') => piece.words.iter().any(|word| *word == token[1..]),
        token => match token.strip_prefix('=') {
            Some(form) => piece.words.len() == 1 && piece.word.text == form,
            None => piece.words.len() == 1 && (piece.word.lemma == token || piece.word.text == token),
        },
    }
}

/// The words of a pattern that are words.
pub(super) fn words(pattern: &str) -> impl Iterator<Item = &str> {
    let tokens = pattern.split_whitespace().flat_map(|token| token.trim_start_matches(['?', '!']).split('|'));
    let tokens = tokens.map(|word| word.trim_start_matches('='));
    tokens
        .filter(|word| !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit()))
}
