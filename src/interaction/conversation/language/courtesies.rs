//! What is said around a request so as not to command it, as patterns; [`frames`](super::frames) takes it off.

/// What says that something would please …
pub(super) const PLEASING: &[&str] = &[
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
pub(super) const IF: &[&str] = &[
    "if|when you ?could|would|can|will|might|manage|should ?to PAST|VERB|left",
    "if|when BODY|THING ?could|would|can|will|might PAST|VERB",
    "if|when you =were to VERB",
    "for you|BODY|THING to VERB",
    "that you ?should|could VERB",
    "to see|have|watch you VERB|DOING",
    "to get|have THING PAST",
];
/// What somebody wants …
pub(super) const WANTING: &[&str] = &[
    "i|we ?will|would|should|must|do|be|have|shall ?only|to =want|=wanting|=need|=needing|=like|=love|=wish|=wishing|=ask|=asking|=beg|=begging|=prefer|=order|=ordering|=command|=urge|=urging|=request|=requesting|=expect|=expecting|=require|=advise|=invite|=recommend|=suggest|=suggesting|=propose|=implore|=encourage|=direct|=instruct|=hope|=hoping|=desire",
];
/// … and what goes on from there.
pub(super) const OF_YOU: &[&str] = &[
    "?of|for you ?now|all ?both ?again ?two ?here to VERB",
    "?that you ?should|could|can|will|would|may|might|must VERB",
    "BODY|THING to VERB",
    "that BODY|THING ?should|could|would VERB",
    "to see|have|watch|get you ?to VERB|DOING",
];
/// The same of what is to be somewhere else.
pub(super) const WANTING_THERE: &[&str] = &[
    "let us|me have",
    "i|we would be GOOD with",
    "THING would ?be ?help|GOOD to have|get",
    "what i|we ?would want|need|like be",
];
/// What somebody wants to be somewhere else; the rest tells where.
pub(super) const ELSEWHERE: &str = "THING|SOME|BODY|you ?to ?be ?a ?very|much|right|all|as|even|still ?bit|little|lot|back|way ?more up|down|back|far|farther|further|farthest|away|off|near|nearer|close|closer|closest|nearest|in|on|at|over|here|out|beside|against|between|forward|upright|straight|toward|towards|high|higher|low|lower|aside";
/// What is wanted to be done to something, whoever does it; the thing is the last but what is to be done.
pub(super) const DONE: &[&str] = &[
    "i|we ?would want|need|like|love|prefer|have THING|SOME|BODY ?to ?be PAST",
    "can|could i|we have|get THING|SOME PAST",
    "THING|BODY should|must|ought|need|have ?to be PAST",
];
/// What tells of a hand with what is to be done.
pub(super) const WITH: &[&str] = &["use|using HAND and|to|for VERB|DOING", "show ?me BODY by DOING"];
/// What it would be polite to do: "if you could touch it", where nothing follows.
pub(super) const IF_ALONE: &str = "if you could|would VERB";
/// Frames that say that something is wanted.
pub(super) const TOLD: &[&str] = &[
    "i be =hoping|=thinking|=wondering ?if|whether ?that you could|would|might|should|can VERB",
    "i =was hope|think|wonder ?if|whether ?that you could|would|might|should|can VERB",
    "you should|could|might|must|can|may|shall ?well ?as ?well VERB",
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
    "i|we permit|allow|trust|challenge|dare you ?to VERB",
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
    "i suggest|propose|recommend ?for a|another ?ANY VERB",
    "you could ?really do with a ?ANY VERB",
    "show ?me ?THING|SOME by DOING",
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
pub(super) const ASKED: &[&str] = &[
    "how|what about ?if ?you ?have|try DOING",
    "how about ?if ?you VERB",
    "why do not you ?go|try ?and ?to VERB",
    "why not VERB",
    "will|would not you VERB",
    "can|could|may|might i|we ?possibly ?ask|trouble|bother|beg|get|have|persuade|tempt|convince|request|invite you ?to|for VERB|DOING",
    "can|could|may|might i|we suggest|propose|recommend|request|ask ?that you VERB",
    "do|would|will|can|could you ?possibly mind|consider|fancy|try|contemplate|start|begin ?perhaps ?DOING DOING",
    "would|will|could|can you be ?so|very|a ?GOOD ?ANY ?ANY as|and|enough|to ?to VERB",
    "would|will you be willing|inclined|prepared|ready|up|open|happy|glad ?for ?to VERB|DOING",
    "would THING trouble|bother|kill you ?too ?much to VERB",
    "how|what about a|another ?ANY VERB",
    "would|will you care|agree|kindly to VERB",
    "might|may i|we ask that you VERB",
    "i wonder ?if|whether you could|would|might|can VERB",
    "might|may you VERB",
    "fancy|mind|care ?to DOING|VERB",
    "be there any|a chance|way|possibility ?that|of you ?could|can|might VERB|DOING",
    "any|a chance|way ?that|of you ?could|can|might VERB|DOING",
    "shall|should|can|could we VERB",
    "can|could i|we see|have|watch you VERB",
    "do you think|reckon|suppose ?that you could VERB",
    "think|reckon you could|can VERB",
];
/// What a polite word ends with, which says nothing of what is wanted.
pub(super) const TAGS: &[&str] = &[
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
pub(super) const BEFORE: &[&str] = &["can|could|will|would you"];
/// What is said as of what was, and is not.
pub(super) const PAST_BUT_POLITE: &[&str] =
    &["i =was hope|think|wonder", "if|when you =were to", "you =had better"];

/// All words of frames.
pub(super) fn patterns() -> impl Iterator<Item = &'static str> {
    [PLEASING, IF, WANTING, OF_YOU, DONE, WITH, TOLD, ASKED, TAGS, BEFORE, &[ELSEWHERE, IF_ALONE]]
        .into_iter()
        .flatten()
        .copied()
}
