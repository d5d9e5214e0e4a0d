//! Polite frames, "could you … if you don't mind", and fillers fall away; what is left is what is wanted, and how it was asked for.

use std::cmp::Reverse;

use super::lexicon::Form;
use super::patterns::{end, is, length, listed};
use super::pieces::{Piece, Sense};
use super::words::Mark;

/// How a frame asks for what it holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// It says that it is wanted: "I want you to …".
    Told,
    /// It asks for it: "could you …?"
    Asked,
    /// It leaves open whether it is wanted: "you could …"; it is asked back.
    Open,
    /// It asks for an answer: "I want to know …".
    Answer,
}

/// Frames, each with what is wanted at its end: its verb, or all from `~` on.
const FRAMES: [(Wish, &str); 4] =
    [(Wish::Asked, ASKED), (Wish::Told, TOLD), (Wish::Open, OPEN), (Wish::Answer, ANSWER)];
/// They ask for an answer.
const ANSWER: &str = "i|we be =curious|=interested|=wondering|=asking ?to|about|in ?know ~ \
     ASKING|if|whether|your|the|its; i|we =wonder|=wondered|=ask ?about ~ ASKING|if|whether; i|we do|can|could not \
     =know|=tell|=see|=understand|=remember ~ ASKING|if|whether|your|the|its";
/// They ask for it.
const ASKED: &str = "can|could|will|would|might|may not you VERB; can|could|will|would|might|may you ?try ?and ?to \
     VERB; can|could|may|might i|we \
     ?ask|trouble|bother|beg|get|have|persuade|tempt|convince|request|invite|see|watch you ?to|for VERB|DOING; \
     can|could|may|might i|we suggest|propose|recommend|request|ask ?that you VERB; do|would|will|can|could you \
     mind|consider|fancy|contemplate|try DOING; will|would you care|agree to VERB; would|may|might|could THING be \
     ?much ?trouble ?possible|okay|ok|alright|fine|acceptable ?to ?ask ?for|if ?you ?to|could VERB; would THING \
     trouble|bother|kill|hurt you ?much to VERB; be THING possible|okay|ok for you to VERB; how|what about ?if \
     ?you ?have|try|start DOING; how about ?if ?you VERB; how|what about a|another ?ANY VERB; why =do not you \
     ?go|try ?and ?to VERB; why not VERB; fancy|care|mind ?to DOING|VERB; ?be ?there any|a chance|way|possibility \
     ?that|of you ?could|can|might|would VERB|DOING; shall|should|could we VERB; i =wonder|=wondered ?if|whether \
     you could|would|might VERB; i be|was =wondering|=hoping|=thinking ?if|whether ?that you \
     could|would|might|should|can|will VERB";
/// They say that it is wanted.
const TOLD: &str = "i|we ?do|would ?do \
     =want|=need|=like|=wish|=love|=prefer|=expect|=require|=ask|=beg|=urge|=command|=order|=tell ?for you ?to \
     VERB; i|we would ?much|rather ?much =like|=love|=prefer|=appreciate|=welcome ?THING ?if ?that ?for you ?to \
     ?could|would|can VERB|PAST|DOING; i|we would ?much =like|=love to see|have|watch you VERB|DOING; i|we would \
     ?much|rather =like|=love|=prefer|=appreciate|=welcome THING if|when ~ THING|HAND; i|we =want|=need to \
     see|have you VERB|DOING; i would ?much rather|sooner ?that you ?would VERB|PAST; i|we would|will be ?ever \
     ?so|much|most|more|eternally ?much GOOD ?to|for|by ?you|THING if|when|for|to ?you \
     ?could|would|can|will|to|see|have ?you VERB|PAST|DOING; i be \
     =asking|=begging|=telling|=hoping|=expecting|=counting|=relying|=waiting ?on|for|that you \
     ?to|will|would|can|could VERB|DOING; i ?do|must|would ?strongly|like ?to \
     =suggest|=propose|=recommend|=request|=insist|=say|=vote|=ask|=advise|=demand ?for|on ?that ?you ?to \
     ?should|could|ought VERB|DOING; i ?do|must|would =think|=guess|=believe|=reckon|=say|=feel ?that you \
     should|must|ought|need|have|had ?better ?to VERB; THING would|might|will be ?so|much|such|of ?great \
     GOOD|help|treat|pleasure|thing|idea|service ?thing|idea|help|move|pleasure ?of ?to|for ?you|me ?if|to|when \
     ?you ?to|could|would|can VERB|PAST; THING would|will ?greatly please|help|delight|suit|make ?me|us ?no|my|so \
     ?end|great|day ?GOOD|lot|end|deal|day ?lot|deal ?to ?see|if ?you|have ?you ?could|would|can VERB|PAST|DOING; \
     ?i ?=think|=guess ?that THING =is ?high|about|your time|turn|chance|job|task|mission ?for|that ?you ?to \
     VERB|PAST; time for|to ?you ?to VERB|PAST; THING be okay|ok|fine|alright ?for ?you to VERB; your|the \
     ?next|first|new|only task|job|mission|goal|turn|aim be ?to ?to VERB; what|all ?that ?i|you|we ?would|do|have \
     ?to =like|=want|=need|=do|=ask|=have|=now ?to ?do ?from|of ?you ?to ?do be ?that|for ?you ?to VERB; next ?up \
     VERB; you =should|=must ?rather|perhaps ?try ?and ?to VERB|DOING; you =ought|=need|=have to VERB; you \
     had|would|should|=better better|best VERB; you =are ?hereby \
     free|welcome|allowed|encouraged|invited|requested|asked|required|permitted|supposed|expected to VERB; we \
     should|must VERB; do not forget to VERB; see|look to THING that ?you VERB; you !look|feel|KNOW|CARE BASE; \
     see|check ?out if|whether you can|could VERB; let us|me see|watch|have ?you VERB|DOING; let us ?all ?try \
     VERB|DOING; THING|BODY need|want|require|deserve|could|do ?with DOING; go|carry|come|keep ?ahead|on|right \
     ?ahead|on and|then|=to VERB; go ahead|on VERB; go|come VERB; get ?move|busy|straight|going|down|on ?on|to \
     ?to|with|and DOING; be ?ever ?so GOOD ?ANY ?as|and|enough ?to VERB; do me|us|yourself|one ?one \
     ?big|huge|little|great|small|tiny favour|favor|solid|kindness|service|honour|thing ?and|of|by ?to VERB|DOING; \
     make|be sure|certain|see ?that|to ?and ?to ?it ?that ?you ?to VERB; \
     try|attempt|endeavour|aim|strive|manage|hurry|proceed|begin|start|continue|commence ?your ?best ?up ?hard \
     ?to|and VERB|DOING; =take|=have ?moment|second|minute|time to VERB; feel free|welcome to VERB; do not be \
     shy|afraid|scared|timid|lazy|silly|nervous|worried ?and|to VERB; do not worry|hesitate ?and|to VERB; \
     have|take|give|make a|another ?ANY go|try|shot|stab|crack|bash|attempt|turn|whirl at|of|on|with DOING; \
     please|kindly to VERB; maybe|perhaps|possibly you should|could|can|might VERB; i|we ?would|do ?rather \
     =like|=love|=prefer|=want|=need ?to ?see ?have ~ THING|HAND|PART|STICK; THING|i would be ?much|so GOOD \
     if|with ~ THING|HAND|PART; THING would be ?much|so ~ GOOD ?if FAR|NEAR; ~ THING|HAND should|must|ought|need \
     ?to be|GO|end|stand|lie|stay; =get|=have ~ THING PAST; have|let|make|get ~ HAND TOUCH|GRAB|GO|make; \
     go|get|come ?over|up ?to|there|here|THING and VERB";
/// They leave open whether it is.
const OPEN: &str = "i =think|=guess|=believe|=reckon|=bet ?that you can|could|may|might VERB; THING =is GOOD ?for \
     ?if ?you ?to VERB|PAST; ?my GOOD|wish|plan|idea|request|thing ?thing|idea would|=is ?be ?that|for ?you ?to \
     VERB; do|would you feel like DOING; be you up for DOING; can|could|will|would|may ~ THING|HAND GO|be \
     NEAR|FAR|BIT|a|ANY; can|could|would|will you be able to VERB; if you would|could|can VERB; ~ THING|HAND|PART \
     may|can|might|could VERB; ~ THING|HAND|PART =goes|=comes|=belongs; can|could|may|might ~ THING be PAST; you \
     can|could|may|might|shall ?as ?well VERB; do|would|will|can you ?ever =like|=want|=love|=prefer|=wish to \
     VERB; should|shall you|i VERB; be you ready|willing to VERB; can we VERB; what if you =tried|=try ?to \
     VERB|DOING; what if you PAST";
/// What ends a polite request without saying what is wanted.
const TAGS: &str = "will|would|can|could ?not you ?please|mind|kindly $; would|will|could you be ?so \
     GOOD|love|sport; if you $; if you would|can|could|please|like|want|wish|may|will|fancy ?to ?please $; if you \
     would|do not mind|object ?much; if THING ?do|would not ?be ?bother|trouble|you|=suits|=pleases \
     ?much|problem|bother|you ?trouble $; when|whenever|once you be ?good|all ?and =ready|=set|free|able|done; \
     when|whenever|as|if you ?get|have|find time|chance|moment|second|minute; when|whenever|as|if you \
     like|please|can; THANKS ?you ?in ?so ?much|advance|lot $; for ?me|us ?one ?moment|second|minute|while $";
/// What says nothing of what is wanted, wherever it stands.
const FILLERS: &str = "please|kindly !to; just|simply|now|um|uh|er|hmm; oh|ah|actually|really|very|quite|too; \
     gently|carefully|slowly|softly|quickly|lightly|firmly|immediately|directly; \
     <ANY|THING|SOME|BODY perhaps|maybe|possibly; also|somehow|somewhat|asap|already|even|slightly|exactly; \
     roughly|approximately|precisely|completely|absolutely|perfectly|entirely|thoroughly|properly; \
     basically|honestly|certainly|definitely|probably|surely|both|own|currently; then|indeed|soon; for \
     me|us; a ?wee|tiny ?little bit|tad|little|while; at the|this moment; right now|away; if possible; by \
     any chance; this time; so far; at all; as well; of course; with care; do you think|reckon|suppose|know; would you say; \
     <!you|be|a|an|the|my|call|name !a|an|the \
     max|mate|buddy|partner|robot|friend|guys|pal|sir|dear|lad|bud";

/// What may stand before what a clause begins with.
const LEADING_IN: &str = "BODY&MARKED|THING&MARKED|look&MARKED|listen&MARKED|again&MARKED|you&MARKED|no&MARKED|so&MARKED|go&MARKED|\
    right&MARKED|thanks&MARKED|thank&MARKED|well&MARKED|and|then|but|hey|hi|hello|ok|okay|alright|great|good|fine|first|next|\
    sorry|yes|yeah|sure|or|whoa|excuse|finally|second|attention|quick|hurry|careful|nice";
/// Questions that begin as a request does: whether it is able to.
const ABILITY: &str = "can|could THING be =reached|=touched|=grasped|=gripped; can|could|would|will you ?be ?able \
     ?to ?maybe ?still REACH THING|that|there; can|could|would|will you ?be ?able ?to get at|to THING|there|that; \
     can|could|would|will you be able to TOUCH|GRAB|get|FEEL; be you able; can|could you get HAND ON THING; you \
     can|could|would ?be ?able ?to REACH THING|that; can|could|would you TOUCH|GRAB !STICK THING from|without; \
     can|could you FEEL SOME|THING $; can|could you FEEL SOME; =do|=does you =have|=need; you \
     ?should|could|must|might|would =have; would you =have !a|the|another; would|will|do you =need ?to; \
     can|could|would|will you .. without =leaning|=bending|=stretching|=moving; would|be THING ?be possible ?for \
     ?you ?to REACH THING|that; would|could|can ?ANY BODY ?be ?able";

/// How many frames may be in each other.
const FRAMES_IN_FRAMES: usize = 3;

/// The pieces without frames and fillers.
pub(super) fn unframed(mut pieces: Vec<Piece>) -> Vec<Piece> {
    fill(&mut pieces);
    let mut k = 0;
    while k < pieces.len() {
        let begins = pieces[..k].iter().all(leads_in)
            || pieces[k - 1].word.mark.is_some()
            || pieces[k - 1].is("and then but so");
        let may_be_tag = k > 1 || k == 0 && pieces.len() > 4;
        let tag = listed(TAGS).filter(|_| may_be_tag).find_map(|tag| tag_length(&pieces, k, tag));
        if let Some(tag) = tag {
            cut(&mut pieces, k, tag);
            continue;
        }
        // A frame may be in a frame: "could you try to …".
        let mut wish = None;
        for _ in 0..FRAMES_IN_FRAMES {
            let Some((within, taken)) = begins.then(|| framed(&pieces[k..])).flatten() else { break };
            wish = wish.filter(|_| within != Wish::Open).or(Some(within));
            pieces.drain(k..k + taken);
            pieces[k].wanted = wish;
            pieces[k].word.form = Form::Base;
            activate(&mut pieces, k);
            if taken == 0 {
                break;
            }
        }
        k += 1;
    }
    pieces
}

/// "It … to be lifted" is "lift it …".
fn activate(pieces: &mut Vec<Piece>, k: usize) {
    let done = "*to|be|must|should|need|ought|have|can|could !=left|be|need|have|can PAST";
    if pieces[k].sense != Sense::Word
        && let Some(end) = end(pieces, k + 1, done, false)
    {
        pieces.drain(k + 1..end - 1);
        pieces.swap(k, k + 1);
        pieces[k].wanted = pieces[k + 1].wanted.take();
        pieces[k].word.form = Form::Base;
    }
}

/// The frame that pieces begin with, and how many it takes up to its verb.
fn framed(pieces: &[Piece]) -> Option<(Wish, usize)> {
    if listed(ABILITY).any(|question| length(pieces, question).is_some()) {
        return None;
    }
    let taken = |frame: &str| match frame.split_once("~ ") {
        Some((before, kept)) => {
            length(pieces, before).filter(|&taken| length(&pieces[taken..], kept).is_some())
        }
        None => length(pieces, frame)?.checked_sub(1),
    };
    let frames = FRAMES.iter().flat_map(|(wish, frames)| listed(frames).map(move |frame| (*wish, frame)));
    let found = frames.filter_map(|(wish, frame)| Some((wish, taken(frame)?)));
    // The longest, the first of as long ones.
    found.min_by_key(|(_, taken)| Reverse(*taken))
}

fn tag_length(pieces: &[Piece], k: usize, tag: &str) -> Option<usize> {
    // A tag ends its sentence.
    let end = (k..pieces.len()).find(|&j| pieces[j].word.mark.is_some()).map_or(pieces.len(), |j| j + 1);
    length(&pieces[k..end], tag).filter(|taken| *taken > 0)
}

/// Takes fillers out.
fn fill(pieces: &mut Vec<Piece>) {
    let mut k = 0;
    while k < pieces.len() {
        let taken = listed(FILLERS).filter_map(|filler| Some(end(pieces, k, filler, true)? - k)).max();
        // "Right now?" alone is no filler.
        let Some(taken) = taken.filter(|&taken| taken > 0 && taken < pieces.len()) else {
            k += 1;
            continue;
        };
        let asks = pieces[k].is("do would") && taken > 2;
        cut(pieces, k, taken);
        if asks && let Some(last) = pieces.last_mut() {
            last.word.mark = Some(Mark::Question);
        }
    }
}

/// Takes some pieces out; the mark behind them is behind what is before them.
fn cut(pieces: &mut Vec<Piece>, k: usize, taken: usize) {
    let mark = pieces[k + taken - 1].word.mark;
    pieces.drain(k..k + taken);
    if let Some(before) = k.checked_sub(1).and_then(|before| pieces.get_mut(before)) {
        before.word.mark = before.word.mark.max(mark);
    }
}

/// Whether a piece may stand before what a clause begins with: "and", "hello", "your chin, …".
pub(super) fn leads_in(piece: &Piece) -> bool {
    is(piece, LEADING_IN)
}

/// All words of frames and fillers.
pub(super) fn patterns() -> impl Iterator<Item = &'static str> {
    let lists = FRAMES.iter().map(|(_, frames)| *frames).chain([TAGS, FILLERS, ABILITY]);
    lists.flat_map(listed)
}
