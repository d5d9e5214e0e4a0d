//! Frames: what is said around a request so as not to command it, "it would be lovely if you touched it", "have a go at
//! touching it", "touch it, would you?". They are taken off, and the verb is put as it is told: "touch it".
//!
//! A frame is the beginning of a clause, and ends with the verb of what is wanted; there may be another within it. A
//! frame of what displeases ("I would hate it if you touched it") is none of these, nor of what was, nor of others.

use super::courtesies::{
    ASKED, BEFORE, DONE, ELSEWHERE, IF, IF_ALONE, OF_YOU, PAST_BUT_POLITE, PLEASING, TAGS, TOLD, WANTING,
    WANTING_THERE, WITH,
};
use super::lexicon::{Form, Lexicon};
use super::light_verbs;
use super::patterns::{has, length};
use super::slots::{Piece, Sense};
use super::words::{Mark, Word};

/// What cannot be meant as "could you" means it: that is asked, and not asked for.
const STATES: &[&str] = &[
    "reach",
    "see",
    "hear",
    "smell",
    "taste",
    "think",
    "know",
    "understand",
    "mean",
    "want",
    "need",
    "like",
    "believe",
    "be",
    "wonder",
    "love",
    "hope",
    "wish",
];

/// Whether clauses begin behind a piece.
fn parts(piece: &Piece) -> bool {
    piece.word.mark.is_some()
        || (piece.sense == Sense::Word && piece.word.is(&["and", "then", "but", "so", "or", "because"]))
        || super::mood::leads_in(piece)
}

/// Takes the frames off all clauses.
pub(super) fn unframed(mut pieces: Vec<Piece>, lexicon: &Lexicon) -> Vec<Piece> {
    let mut k = 0;
    while k < pieces.len() {
        let begins = k == 0 || parts(&pieces[k - 1]);
        // One frame may stand in another.
        let mut within = k;
        while begins && let Some(after) = unframe(&mut pieces, within, lexicon) {
            within = after;
        }
        k += 1;
    }
    untagged(pieces)
}

/// The places of the pieces from one on that say something, to the end of the sentence.
fn telling_from(pieces: &[Piece], k: usize) -> Vec<usize> {
    let mut places = Vec::new();
    for (place, piece) in pieces.iter().enumerate().skip(k) {
        if piece.sense != Sense::Filler {
            places.push(place);
        }
        if piece.word.mark >= Some(Mark::Stop) {
            break;
        }
    }
    places
}

/// Takes a frame off the clause that begins at a piece, and tells where the next may begin; without one, says plainly
/// what is wanted of a thing.
fn unframe(pieces: &mut Vec<Piece>, k: usize, lexicon: &Lexicon) -> Option<usize> {
    let places = telling_from(pieces, k);
    if places.is_empty() {
        return None;
    }
    let next = take_frame(pieces, &places, lexicon);
    if next.is_none() {
        let _ = say_actively(pieces, &places, lexicon)
            || say_where(pieces, &places, lexicon)
            || say_by_verb(pieces, &places, lexicon);
    }
    next
}

/// The pieces at some places.
fn at<'a>(pieces: &'a [Piece], places: &[usize]) -> Vec<&'a Piece> {
    places.iter().map(|&place| &pieces[place]).collect()
}

/// Whether a sentence ends with a question mark.
fn asks(said: &[&Piece]) -> bool {
    said.last().is_some_and(|last| last.word.mark == Some(Mark::Question))
}

/// Takes a frame off what stands at some places, and tells where the next may begin.
fn take_frame(pieces: &mut Vec<Piece>, places: &[usize], lexicon: &Lexicon) -> Option<usize> {
    let said = at(pieces, places);
    let skipped = BEFORE.iter().find_map(|before| length(&said, before)).unwrap_or(0);
    let begins = if skipped > 0 { vec![0, skipped] } else { vec![0] };
    let (from, taken, polite) = begins.into_iter().find_map(|from| {
        let (taken, polite) = frame(&said[from..], asks(&said) && from == 0)?;
        wants(pieces, &places[from..], taken, polite).then_some((from, taken, polite))
    })?;
    let subject =
        said[from..from + taken - 1].iter().rposition(|piece| piece.is_body() || piece.sense == Sense::Thing);
    // "If your hand touched it", "I want it to come": who does it is told of; "it would be nice" is not.
    let kept = subject.filter(|&subject| subject > 0 && polite).map(|kept| places[from + kept]);
    let (first, verb) = (places[from], places[from + taken - 1]);
    pieces[verb].word = lexicon.told(&pieces[verb].word);
    pieces[verb].requested = true;
    let mut place = 0;
    pieces.retain(|piece| {
        let gone = place >= first && place < verb && Some(place) != kept && piece.sense != Sense::Filler;
        place += 1;
        !gone
    });
    if kept.is_some()
        && let Some(subject) = pieces.get_mut(first)
    {
        subject.requested = true;
    }
    Some(first)
}

/// Whether a frame of so many pieces, its verb the last, says what somebody wants now.
fn wants(pieces: &[Piece], places: &[usize], taken: usize, polite: bool) -> bool {
    let said = at(pieces, places);
    let (frame, verb) = (&said[..taken - 1], said[taken - 1]);
    let able = said[..taken].iter().any(|piece| piece.word.is(&["can", "could", "able"]));
    // "If only you could": a sigh.
    let sighs = pieces[places[0]..places[taken - 1]].iter().any(|piece| piece.word.is(&["only"]));
    // "You could have touched it"; but "have a little rest" is none.
    let perfect = verb.word.is(&["have"])
        && places.get(taken).is_some_and(|&next| {
            next == places[taken - 1] + 1
                && pieces[next].sense == Sense::Word
                && matches!(pieces[next].word.form, Form::Past | Form::BaseOrPast | Form::Base)
        });
    let past = ["was", "were", "had", "did", "been"];
    let was = frame.iter().any(|piece| past.contains(&piece.word.text.as_str()))
        && !PAST_BUT_POLITE.iter().any(|past| has(frame, past));
    let doubts = |before: usize| pieces[before].word.is(&["maybe", "perhaps", "possibly"]);
    let unsure = polite && said[0].word.is(&["i"]) && places[0].checked_sub(1).is_some_and(doubts);
    // "Another go": once more.
    let again =
        verb.word.is(&["go", "try", "attempt"]) && frame.iter().any(|piece| piece.word.is(&["a", "another"]));
    !(sighs || perfect || was || unsure || again || (able && verb.word.is(STATES)))
}

/// "I want it lifted": lift it.
fn say_actively(pieces: &mut Vec<Piece>, places: &[usize], lexicon: &Lexicon) -> bool {
    let said = at(pieces, places);
    let taken = DONE.iter().find_map(|done| length(&said, done));
    let Some(taken) = taken.filter(|_| !asks(&said) || said[0].word.is(&["can", "could"])) else {
        return false;
    };
    let names = |piece: &&Piece| piece.is_body() || matches!(piece.sense, Sense::Thing | Sense::Some);
    let Some(object) = said[..taken].iter().rposition(names) else { return false };
    if said[taken - 1].word.is(&["be", "have"]) {
        return false;
    }
    let (first, verb_at) = (places[0], places[taken - 1]);
    let (mut object, mut verb) = (pieces[places[object]].clone(), pieces[verb_at].clone());
    object.word.mark = verb.word.mark;
    verb.word = Word { mark: None, ..lexicon.told(&verb.word) };
    verb.requested = true;
    pieces.splice(first..=verb_at, [verb, object]);
    true
}

/// "I would like it nearer": put it nearer; "I would like you upright": move yourself upright.
fn say_where(pieces: &mut Vec<Piece>, places: &[usize], lexicon: &Lexicon) -> bool {
    let said = at(pieces, places);
    let Some(taken) = elsewhere(&said).filter(|&taken| !asks(&said) && taken < said.len()) else {
        return false;
    };
    let own = said[taken].word.text == "you";
    let (first, object) = (places[0], places[taken]);
    let mut verb = pieces[first].clone();
    verb.word = lexicon.word(if own { "move" } else { "put" });
    (verb.sense, verb.requested) = (Sense::Word, true);
    verb.words = vec![verb.word.text.clone()];
    if own {
        pieces[object].word = Word { mark: pieces[object].word.mark, ..lexicon.word("yourself") };
        pieces[object].words = vec!["yourself".into()];
    }
    pieces.splice(first..object, [verb]);
    true
}

/// "Give it a push": push it.
fn say_by_verb(pieces: &mut Vec<Piece>, places: &[usize], lexicon: &Lexicon) -> bool {
    let said = at(pieces, places);
    let Some((verb, object, taken)) = light_verbs::action(&said) else { return false };
    let (first, last) = (places[0], places[taken - 1]);
    let mark = pieces[last].word.mark;
    let word = Word { mark: None, ..lexicon.told(&verb.word) };
    let mut plain = vec![Piece { word, requested: said[0].requested, ..verb.clone() }];
    plain.extend(object.cloned());
    if let Some(end) = plain.last_mut() {
        end.word.mark = end.word.mark.max(mark);
    }
    pieces.splice(first..=last, plain);
    true
}

/// How many pieces a frame takes with its verb, and whether its subject may be told in it.
fn frame(said: &[&Piece], asks: bool) -> Option<(usize, bool)> {
    let joined = |heads: &[&str], tails: &[&str]| {
        heads.iter().find_map(|head| tails.iter().find_map(|tail| length(said, &format!("{head} {tail}"))))
    };
    let with = || WITH.iter().find_map(|frame| length(said, frame));
    let pleasing =
        || joined(PLEASING, IF).or_else(|| joined(WANTING, OF_YOU)).or_else(with).map(|taken| (taken, true));
    let told = || TOLD.iter().find_map(|frame| length(said, frame)).map(|taken| (taken, false));
    let asked = || ASKED.iter().find_map(|frame| length(said, frame)).map(|taken| (taken, false));
    let alone = || {
        let taken = length(said, IF_ALONE)?;
        let rest = &said[taken..];
        let end =
            (0..rest.len()).find(|&k| length(&rest[k..], "THING would be ?so|very|ever GOOD").is_some());
        let rest = &rest[..end.unwrap_or(rest.len())];
        let goes_on = rest.iter().any(|piece| {
            piece
                .word
                .is(&["what", "how", "would", "will", "could", "can", "then", "where", "who", "why", "be"])
        });
        (!goes_on && !asks).then_some((taken, false))
    };
    let found = asked().or_else(alone).or_else(|| if asks { None } else { pleasing().or_else(told) })?;
    (found.0 > 1).then_some(found)
}

/// How many pieces say that somebody wants what follows them to be elsewhere.
fn elsewhere(said: &[&Piece]) -> Option<usize> {
    WANTING.iter().chain(WANTING_THERE).find_map(|wants| {
        ["", "to see|have|get"].iter().find_map(|more| {
            let wants = format!("{wants} {more}");
            length(said, &format!("{wants} {ELSEWHERE}"))?;
            length(said, &wants)
        })
    })
}

/// Takes what is said in the end out of politeness off every sentence that has something else in it.
fn untagged(mut pieces: Vec<Piece>) -> Vec<Piece> {
    let mut k = 1;
    while k < pieces.len() {
        let begins =
            pieces[k - 1].word.mark.is_some() || pieces[..k].iter().any(|piece| piece.word.form.is_base());
        let places = telling_from(&pieces, k);
        let said: Vec<&Piece> = places.iter().map(|&place| &pieces[place]).collect();
        let ends =
            |taken: &usize| *taken > 0 && (*taken == said.len() || said[*taken - 1].word.mark.is_some());
        let taken = TAGS.iter().filter_map(|tag| length(&said, tag).filter(ends)).max();
        let verb = sentence_commands(&pieces[..k]);
        if let Some(taken) = taken.filter(|_| begins && verb && places[0] == k) {
            let last = places[taken - 1];
            let mark = pieces[last].word.mark.map(|mark| mark.min(Mark::Stop));
            pieces.drain(k..=last);
            pieces[k - 1].word.mark = pieces[k - 1].word.mark.max(mark);
            continue;
        }
        k += 1;
    }
    pieces
}

/// Whether the sentence that ends here is told or asked for: "touch it", not "you touched it".
fn sentence_commands(before: &[Piece]) -> bool {
    let from = before.iter().rposition(|piece| piece.word.mark >= Some(Mark::Stop)).map_or(0, |k| k + 1);
    let from = if from == before.len() { 0 } else { from };
    let said: Vec<&Piece> = before[from..]
        .iter()
        .filter(|piece| piece.sense != Sense::Filler)
        .skip_while(|piece| super::mood::leads_in(piece))
        .collect();
    let past = said.iter().any(|piece| piece.word.form == Form::Past);
    said.first().is_some_and(|first| first.word.form.is_base() && !first.word.is(&["be"]))
        || (!past && has(&said, "^ BODY|THING"))
}
