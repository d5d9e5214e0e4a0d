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

/// Takes a frame off the clause that begins at a piece; where the next may begin.
fn unframe(pieces: &mut Vec<Piece>, k: usize, lexicon: &Lexicon) -> Option<usize> {
    let places = telling_from(pieces, k);
    let said: Vec<&Piece> = places.iter().map(|&place| &pieces[place]).collect();
    let asks = said.last().is_some_and(|last| last.word.mark == Some(Mark::Question));
    let skipped = BEFORE.iter().find_map(|before| length(&said, before)).unwrap_or(0);
    for from in if skipped > 0 { vec![0, skipped] } else { vec![0] } {
        let said = &said[from..];
        let Some((taken, polite)) = frame(said, asks && from == 0) else { continue };
        let verb = said[taken - 1];
        let able = said[..taken].iter().any(|piece| piece.word.is(&["can", "could", "able"]));
        // "If only you could": a sigh.
        if pieces[places[from]..places[from + taken - 1]].iter().any(|piece| piece.word.is(&["only"])) {
            continue;
        }
        // "You could have touched it"; but "have a rest" is none.
        let perfect = verb.word.is(&["have"])
            && places.get(from + taken).is_some_and(|&next| {
                next == places[from + taken - 1] + 1
                    && pieces[next].sense == Sense::Word
                    && matches!(pieces[next].word.form, Form::Past | Form::BaseOrPast | Form::Base)
            });
        let frame = &said[..taken - 1];
        let was = frame
            .iter()
            .any(|piece| ["was", "were", "had", "did", "been"].contains(&piece.word.text.as_str()))
            && !PAST_BUT_POLITE.iter().any(|past| has(frame, past));
        let unsure = polite
            && said[0].word.is(&["i"])
            && places[from]
                .checked_sub(1)
                .is_some_and(|before| pieces[before].word.is(&["maybe", "perhaps", "possibly"]));
        if was || unsure || perfect || (able && verb.word.is(STATES)) {
            continue;
        }
        let word = lexicon.told(&verb.word);
        let subject =
            said[..taken - 1].iter().rposition(|piece| piece.is_body() || piece.sense == Sense::Thing);
        // "If your hand touched it", "I want it to come": who does it is told of; "it would be nice" is not.
        let kept = subject.filter(|&subject| subject > 0 && polite);
        let (first, verb_at) = (places[from], places[from + taken - 1]);
        let kept = kept.map(|kept| places[from + kept]);
        pieces[verb_at].word = word;
        pieces[verb_at].requested = true;
        let mut place = 0;
        pieces.retain(|piece| {
            let gone =
                place >= first && place < verb_at && Some(place) != kept && piece.sense != Sense::Filler;
            place += 1;
            !gone
        });
        if kept.is_some()
            && let Some(subject) = pieces.get_mut(first)
        {
            subject.requested = true;
        }
        return Some(first);
    }
    let done = DONE
        .iter()
        .find_map(|done| length(&said, done))
        .filter(|_| !asks || said[0].word.is(&["can", "could"]));
    if let Some(taken) = done
        && let Some(object) = said[..taken]
            .iter()
            .rposition(|piece| piece.is_body() || matches!(piece.sense, Sense::Thing | Sense::Some))
        && !said[taken - 1].word.is(&["be", "have"])
    {
        // "I want it lifted": lift it.
        let (first, object, verb_at) = (places[0], places[object], places[taken - 1]);
        let object = Piece {
            word: Word { mark: pieces[verb_at].word.mark, ..pieces[object].word.clone() },
            ..pieces[object].clone()
        };
        let mut verb = pieces[verb_at].clone();
        verb.word = Word { mark: None, ..lexicon.told(&verb.word) };
        verb.requested = true;
        pieces.splice(first..=verb_at, [verb, object]);
        return None;
    }
    if !asks && let Some(taken) = elsewhere(&said) {
        // "I would like it nearer": put it nearer, or be it there thyself.
        let [put, you] = ["put", "yourself"].map(|text| lexicon.word(text));
        let own = said[taken].word.text == "you";
        let (first, object) = (places[0], places[taken]);
        let mut verb = pieces[first].clone();
        verb.word = if own { lexicon.word("move") } else { put };
        (verb.sense, verb.requested) = (Sense::Word, true);
        verb.words = vec![verb.word.text.clone()];
        if own {
            pieces[object].word = Word { mark: pieces[object].word.mark, ..you };
            pieces[object].words = vec!["yourself".into()];
        }
        pieces.splice(first..object, [verb]);
        return None;
    }
    let rest = light_verbs::action(&said).map(|(verb, object, taken)| {
        let mut verb = verb.clone();
        verb.requested = said[0].requested;
        let object: Vec<Piece> = object.into_iter().cloned().collect();
        (verb, object, taken)
    });
    let (mut verb, mut object, taken) = rest?;
    let (first, last) = (places[0], places[taken - 1]);
    let mark = pieces[last].word.mark;
    verb.word = Word { mark: None, ..lexicon.told(&verb.word) };
    object.insert(0, verb);
    if let Some(end) = object.last_mut() {
        end.word.mark = end.word.mark.max(mark);
    }
    pieces.splice(first..=last, object);
    None
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
