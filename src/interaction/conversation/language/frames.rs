//! Frames: what is said around a request so as not to command it, "it would be lovely if you touched it", "have a go at
//! touching it", "touch it, would you?". They are taken off, and the verb is put as it is told: "touch it".
//!
//! A frame is the beginning of a clause, and ends with the verb of what is wanted; there may be another within it. A
//! frame of what displeases ("I would hate it if you touched it") is none of these, nor of what was, nor of others.

use super::lexicon::{Form, Lexicon};
use super::patterns::{has, length};
use super::slots::{Piece, Sense};
use super::words::{Mark, Word};

/// What says that something would please …
const PLEASING: &[&str] = &[
    "THING would|might|may|could|will ?certainly be ?much|a ?great GOOD ?thing ?idea|of|for ?you|me|us",
    "THING would help|please ?me|us ?out ?a ?great|lot ?deal",
    "THING would make me|us ?so|much GOOD",
    "THING would make my day",
    "i|we would be ?much|most|ever|more|eternally|forever|over ?so ?much GOOD",
    "i|we would ?greatly appreciate|love|like|enjoy|welcome|prefer ?THING",
    "you would make|do me|us ?a ?big|great GOOD|favour|favor|service",
    "i|we would|will|shall|should thank you",
    "would THING be possible",
    "would THING be too much ?trouble|bother|to ?ask",
    "be THING possible",
];
/// … and what goes on from there to the verb.
const IF: &[&str] = &[
    "if|when you ?could|would|can|will|might|manage|should ?to PAST|VERB|left",
    "if|when BODY|THING ?could|would|can|will|might PAST|VERB",
    "if|when you =were to VERB",
    "for you|BODY|THING to VERB",
    "that you ?should|could VERB",
    "to see|have|watch you VERB|DOING",
    "to get|have THING PAST",
];
/// What somebody wants …
const WANTING: &[&str] = &[
    "i|we ?will|would|must|do|be|have|shall ?only|to =want|=wanting|=need|=needing|=like|=love|=wish|=wishing|=ask|=asking|=beg|=begging|=prefer|=order|=ordering|=command|=urge|=urging|=request|=requesting|=expect|=expecting|=require|=advise|=invite|=recommend|=suggest|=suggesting|=propose|=implore|=encourage|=direct|=instruct|=hope|=hoping|=desire",
];
/// … and what goes on from there.
const OF_YOU: &[&str] = &[
    "?of|for you ?now|all ?both ?again ?two ?here to VERB",
    "?that you ?should|could|can|will|would|may|might|must VERB",
    "BODY|THING to VERB",
    "that BODY|THING ?should|could|would VERB",
    "to see|have|watch|get you ?to VERB|DOING",
];
/// What somebody wants to be somewhere else; the rest tells where.
const ELSEWHERE: &str = "THING|SOME|BODY|you ?to ?be ?a ?very|much|right|all|as|even|still ?bit|little|lot|back|way ?more up|down|back|far|farther|further|farthest|away|off|near|nearer|close|closer|closest|nearest|in|on|at|over|here|out|beside|against|between|forward|upright|straight|toward|towards|high|higher|low|lower|aside";
/// What tells of a hand with what is to be done.
const WITH: &[&str] = &["use|using HAND and|to|for VERB|DOING"];
/// What it would be polite to do: "if you could touch it", where nothing follows.
const IF_ALONE: &str = "if you could|would VERB";
/// Frames that say that something is wanted.
const TOLD: &[&str] = &[
    "i be =hoping|=thinking|=wondering ?if|whether ?that you could|would|might|should|can VERB",
    "i =was hope|think|wonder ?if|whether ?that you could|would|might|should|can VERB",
    "you should|could|might|must|can|may|shall|would|will ?well ?as ?well VERB",
    "you ought|need|have ?now to VERB",
    "you had|would|should better VERB",
    "i ?do|must|would think|guess|believe|reckon|say|feel ?that you should|could|might|must|can ?well ?as ?well VERB",
    "i ?do|must|would think|guess|believe|reckon|say|feel ?that you ought|need|have to VERB",
    "i ?do|must|would think|guess|believe|reckon|say|feel ?that you had|would better VERB",
    "you be =to VERB",
    "you be free|welcome|allowed|encouraged|invited|requested|asked|required|permitted|supposed|expected ?now to VERB",
    "?now ?THING ?would ?now be ?high|about|now|your time|turn|chance|job|task|mission ?now|for|that ?you ?to VERB|PAST",
    "THING would|might|will be ?much|a ?great GOOD ?thing ?idea ?of ?you to VERB",
    "time ?for ?you ?to VERB|PAST",
    "THING be okay|ok|fine|alright ?now ?for ?you to VERB",
    "see|check ?out if|whether you can|could VERB",
    "i would say|vote ?for ?that ?you VERB",
    "?now ?THING be time to get DOING",
    "your|the ?next|first|new task|job|mission|goal|turn|aim be ?now|to ?to VERB",
    "?and ?now what|all ?that ?i|you|we ?would|all ?do|have|need|be|want|like|need ?now|to|you|from ?to|you ?do|want be ?that|for ?you ?to VERB",
    "i|we permit|allow|trust|challenge|dare|let you ?to VERB",
    "let us|me ?now see|watch|have|try ?you VERB|DOING",
    "let us VERB",
    "THING|BODY need|want|require|deserve|could|do ?with DOING",
    "go ?ahead|on|right ?ahead|on ?and|then VERB",
    "come ?on ?and|then VERB",
    "carry on and VERB",
    "get DOING",
    "get ?a ?move|busy|straight|going|down|on ?on|to ?to ?with|and DOING",
    "be a ?GOOD ANY ?and VERB",
    "be ?very|ever ?so|a GOOD ?ANY as|and|enough ?to VERB",
    "do me|us|yourself ?a|the ?big|huge|little|great|small|tiny favour|favor|solid|kindness|service|honour ?and|of|by ?to VERB|DOING",
    "make|be sure|certain ?that ?to|and ?you VERB",
    "see|attend to THING ?that ?you ?to VERB",
    "try|attempt|remember|endeavour|endeavor|aim|strive|manage to|and VERB",
    "try|attempt DOING",
    "feel free|welcome to VERB",
    "not be shy|afraid|scared|bashful|timid|lazy|silly|daft|nervous|worried ?and|to|now VERB",
    "not worry|hesitate ?and|to|now VERB",
    "have|take|give|make a|another ?ANY go|try|shot|stab|crack|bash|attempt|turn|whirl at|of|on|with DOING",
    "start|begin|commence|proceed DOING",
    "start|begin|proceed|continue|commence to VERB",
    "please|kindly to VERB",
    "i would|have ?=sooner ?that you PAST|VERB",
    "i would prefer ?THING if you PAST|VERB",
];
/// Frames that ask for it.
const ASKED: &[&str] = &[
    "how|what about ?if ?you ?have|try DOING",
    "how about ?if ?you VERB",
    "why do not you ?go|try ?and ?to VERB",
    "why not VERB",
    "will|would not you VERB",
    "can|could|may|might i|we ?possibly ?ask|trouble|bother|beg|get|have|persuade|tempt|convince|request|invite you ?to|for VERB|DOING",
    "can|could|may|might i|we suggest|propose|recommend ?that you VERB",
    "do|would|will|can|could you ?possibly mind|consider|fancy|try|contemplate|start|begin ?perhaps ?DOING DOING",
    "would|will|could|can you be ?so|very|a ?GOOD ?ANY ?ANY as|and|enough|to ?to VERB",
    "would|will you be willing|inclined|prepared|ready|up|open|happy|glad ?for ?to VERB|DOING",
    "would|will you care|agree|kindly to VERB",
    "might|may i|we ask that you VERB",
    "i wonder ?if|whether you could|would|might|can VERB",
    "might|may you VERB",
    "fancy|mind|care ?to DOING|VERB",
    "be there any|a chance|way|possibility ?that|of you ?could|can|might VERB|DOING",
    "any|a chance|way ?that|of you ?could|can|might VERB|DOING",
    "shall|should|can|could we VERB",
    "do you think|reckon|suppose ?that you could VERB",
    "think|reckon you could|can VERB",
];
/// What a polite word ends with, which says nothing of what is wanted.
const TAGS: &[&str] = &[
    "will|would|can|could ?not you ?please|mind|kindly",
    "would|will|could you be ?so|a ?very GOOD|dear|love|sport|angel|pal|darling",
    "if you ?would|will|could|can|do be ?so|that ?very|a ?ever GOOD|dear|love|sport|willing|able|free|ready|up",
    "if you would|can|could|please|like|want|wish|may|will ?to ?please",
    "if you would|do not mind|object",
    "if THING|that be ?okay|ok|not|alright|possible|fine|all|at ?right|too ?much|with|for ?trouble|bother|you",
    "if THING ?do|would not|=suits|=pleases ?be ?too|bother|trouble|you|a ?much|problem|bother ?trouble",
    "when|whenever|once you be ?good|quite|all ?and =ready|=set|free|able|done",
    "when|whenever|as|if you ?get|have|find ?a|the time|chance|moment|second|like|please|can|minute",
    "there be a GOOD ANY",
    "THING be a GOOD ANY",
    "for a change",
    "i would|will be ?much|most|so|ever|very GOOD",
    "i beg ?of you",
    "THING|that would be ?so|much|very GOOD ?of ?you",
];
/// What may stand before a frame of its own: "could you go ahead and …".
const BEFORE: &[&str] = &["can|could|will|would you"];
/// What is said as of what was, and is not.
const PAST_BUT_POLITE: &[&str] = &["i =was hope|think|wonder", "if|when you =were to", "you =had better"];
/// Verbs whose action has a noun of the same form; "have a go" and the like repeat, and are left.
const NO_ACTIONS: &[&str] = &[
    "try",
    "go",
    "rest",
    "break",
    "like",
    "be",
    "have",
    "do",
    "can",
    "will",
    "need",
    "want",
    "care",
    "stop",
    "wait",
    "finish",
    "start",
    "quit",
    "end",
    "second",
    "minute",
    "name",
    "place",
    "report",
    "point",
    "pause",
    "memory",
    "guess",
    "count",
    "summary",
    "hand",
    "answer",
    "sit",
    "stand",
    "lie",
    "run",
    "chat",
    "walk",
    "attempt",
    "finger",
    "use",
    "mind",
    "trouble",
    "bother",
    "call",
    "kind",
    "touchdown",
    "clasp",
];
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
        let perfect = verb.word.is(&["have"])
            && said.get(taken).is_some_and(|next| {
                matches!(next.word.form, Form::Past | Form::BaseOrPast) || next.word.form == Form::Base
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
    let rest = action(&said).map(|(verb, object, taken)| {
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
    let wants = WANTING.iter().chain(
        ["let us|me have", "i|we would be GOOD with", "THING would ?be ?help|GOOD to have|get"].iter(),
    );
    wants.into_iter().find_map(|wants| {
        length(said, &format!("{wants} {ELSEWHERE}"))?;
        length(said, wants)
    })
}

/// "Give it a push", "have a feel of it", "do a sweep": the verb, what it is done to, and how many pieces say so.
fn action<'a>(said: &[&'a Piece]) -> Option<(&'a Piece, Vec<&'a Piece>, usize)> {
    let noun = |k: usize| {
        said.get(k).filter(|piece| {
            piece.sense == Sense::Word && piece.word.form.is_base() && !piece.word.is(NO_ACTIONS)
        })
    };
    let article =
        |k: usize| said.get(k).is_some_and(|piece| piece.word.is(&["a", "an", "another", "one", "some"]));
    let behind = |k: usize| (1..=3).map(|by| k + by).find(|&k| noun(k).is_some());
    let first = said.first()?;
    let object =
        said.get(1).filter(|piece| piece.is_body() || matches!(piece.sense, Sense::Thing | Sense::Some));
    if let Some(object) = object
        && first.word.is(&["give"])
        && article(2)
    {
        let k = behind(2)?;
        return Some((noun(k)?, vec![object], k + 1));
    }
    if first.word.is(&["give"]) && article(1) {
        let k = behind(1)?;
        let to = said.get(k + 1).filter(|piece| piece.word.is(&["to"]))?;
        let _ = to;
        return Some((noun(k)?, Vec::new(), k + 2));
    }
    let light = first.word.form.is_base() && first.word.is(&["have", "take", "do", "make", "perform"]);
    let quick = first.word.is(&["a"]);
    if (light && article(1)) || quick {
        let k = behind(usize::from(!quick))?;
        let taken =
            k + 1 + usize::from(said.get(k + 1).is_some_and(|next| next.word.is(&["of", "at", "on", "to"])));
        return Some((noun(k)?, Vec::new(), taken));
    }
    None
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

/// All words of frames.
pub(super) fn patterns() -> impl Iterator<Item = &'static str> {
    [PLEASING, IF, WANTING, OF_YOU, WITH, TOLD, ASKED, TAGS, BEFORE, &[ELSEWHERE, IF_ALONE]]
        .into_iter()
        .flatten()
        .copied()
}
