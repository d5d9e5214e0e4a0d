//! What moves nothing. It is only answered: "hello", "thank you", "yes", "the nearer one", "who are you?", "what can you do?",
//! "what did you do?"; or kept in mind: "don't touch it", "stop", "keep still", "forget it", "goodbye".

use super::super::Conversation;
use super::super::grammar::{Request, UnknownWord};
use super::super::mind::Deed;
use super::super::speaking::{place_in_words, sentence};
use super::{Act, Answer, Intent, Reply, RequestKind, doing};

/// What it can do, as it says it.
const ABILITIES: &str = "I can feel around for things (\"is there something in front of you?\"), touch what I felt with either \
hand, feel its shape, pick it up, put it as far away as possible, bring it near, let go; take a \
stick and touch with it; touch my own body (\"touch your nose\"); \
say where a thing or a part of me is, how far, how many, how big, and whether I reach it; lean forward and back; get out of the \
way of what comes; tell what I did; forget, do it again, rest, keep still. \"Quit\" ends our talk";
/// How many of the last things that it did are told.
const LAST: usize = 4;

pub(super) const DONT: RequestKind = RequestKind::answer(
    Act::Minds(|mind, _, request| {
        let Some(intent) = request.about else {
            return Answer::done("All right, I will not do that");
        };
        mind.forbid(intent, request.part.clone());
        Answer::done(format!("All right, I will not {}", doing(intent, request.part.as_ref())[0]))
    }),
    "",
);

pub(super) const KEEP_STILL: RequestKind = RequestKind::answer(
    Act::Minds(|mind, _, _| {
        mind.still = true;
        Answer::done("I will keep still until you ask me to do something")
    }),
    "told: ^ KEEP|LOOK ?BODY|yourself|THING ?all ?as STILL; ^ KEEP ?right where|there|as|like ?you|THING; \
     STOP|KEEP ?right where|there; ^ freeze; ^ stay|still $; ^ stay|remain|keep|hold ?in your|that|this|the|same \
     ?same|present|current POSE; play|be|like|as dead|statue|rock|stone; rest motionless|still; KEEP BODY|yourself \
     ?right where|as they|THING|you be; stay|remain BODY; ^ hold ?THING ?right there|still; ^ =hold =it $; stand \
     by; denied: not a|one|another move|muscle|inch|step|MORE; not|never ?you ?ever ?dare ?to STIR !THING; without \
     =moving; no =moving|movement|movements|motion|motions; nothing move $; do nothing $; no|quit|STOP \
     =fidgeting|=moving|=wriggling|=squirming|STIR",
);

pub(super) const STOP: RequestKind = RequestKind::answer(
    Act::Minds(|mind, _, _| {
        mind.still = true;
        Answer::done("I have stopped and will stay as I am")
    }),
    "said: enough; ^ STOP|whoa|woah|wait; never mind; ^ hang on; ^ give up $; ^ END THING|that $; told: \
     THING|that|ok will DO; ^ STOP|quit ?DOING ?what|whatever|THING|ALL $; ^ wait|hold ?on|up|it ?there \
     ?moment|minute|second|there $; ^ STOP; chuck|pack THING in; denied: cut THING out; ^ leave off",
);

pub(super) const FORGET: RequestKind = RequestKind::new(
    ["forget it", "forgot it"],
    Act::Minds(|mind, actor, request| match mind.things.it().cloned() {
        _ if mind.things.is_empty() => Answer::done("I have not felt anything that I could forget"),
        _ if request.all => {
            mind.things.forget_all();
            Answer::done("I have forgotten all the things that I felt")
        }
        Some(known) => {
            mind.things.forget(known.id);
            Answer::done(format!("I have forgotten the thing {}", place_in_words(actor, &known.at)))
        }
        None => Answer::asks(mind.question(actor)),
    }),
    "told: FORGET; CLEAR ?out your|THING|the|ALL ?whole|entire MEMORY; PUT|CLEAR|get|lose|PUSH|take \
     THING|SOME|ALL|what ?ALL out|from ?of ?from ?your MEMORY; ^ wipe|clear THING|ALL & !HAND|TABLE; CLEAR \
     what|whatever|ALL ?that ?THING ?you KNOW|FEEL|felt|FIND; start ALL|AGAIN|over; from scratch; clean slate; \
     denied: not|longer remember",
);

pub(super) const QUIT: RequestKind = RequestKind::answer(
    Act::Minds(|mind, _, _| {
        mind.over = true;
        Answer::done("Goodbye")
    }),
    "said: i|we ?have|must|better|should|need ?got|had ?better|best ?to be|dash off|away; ^ BYE|quit|exit; ^ so \
     long $; BYE $; ^ see you; ^ THING be ALL; ^ that|THING will be ALL; ^ good night; ^ ?i|we ?think ?i|we be \
     ALL|through|=leaving|off|=done|=finished; ^ i|we HELPING|=got|better ?to|=got ?to|better \
     =go|=leave|=run|quit|stop; until next|tomorrow|then|later; SPEAK to you later|soon|tomorrow; ^ later $; take \
     care; have a|an ?GOOD day|evening|night|one; keep in touch; end of ?our|this TALK; ^ that|THING be it ?for; \
     catch you later; told: ^ END|STOP|call THING day|here|now; ^ STOP|END here; ^ quit|exit|end|finish $; ^ END \
     ?this|our|THING TALK; ^ turn|switch yourself off; ^ switch|shut|power|log|sign ?THING|yourself off|down|out \
     $; ^ ?have ?to go $; denied: STOP =talking|=listening",
);

pub(super) const GREET: RequestKind = RequestKind::answer(
    Act::Tells(|_, _| Answer::tells("Hello. I cannot see you, but I hear you: what shall I do?")),
    "said: GOOD to meet|see you; how have you be; ^ HELLO; ^ GOOD morning|afternoon|evening|day; ^ \
     morning|evening|afternoon; make your acquaintance; asked: how be THING|life|things|you|ALL ?going; how do you \
     do; you|are|be ?you ok|okay|alright|well $; what be UP $; what be new",
);

pub(super) const THANKS: RequestKind = RequestKind::answer(
    Act::Tells(|_, _| Answer::tells("You are welcome")),
    "said: THANKS ?you|THING|many|much ?for|ALL|so ?THING|your ?help|much; impressed; well|nicely =done|do; ^ GOOD \
     BEING|boy|one; GOOD of you; GOOD job|work|effort; how kind; THING be ?so GOOD; you be GOOD; very|so GOOD; ^ \
     GOOD $; past: you =have =been ?GOOD help|GOOD; ^ that be ?so GOOD ?of ?you",
);

pub(super) const YES: RequestKind = RequestKind::answer(
    Act::Tells(|_, _| Answer::tells("Good; but I did not ask you anything")),
    "said: i agree; ^ YES; ^ go ahead|on; ^ go for it; ^ DO it|so|that|THING $; ^ DO $; ^ of course; ^ that|THING \
     be right|correct|true|fine|it; ^ by all means; ^ you may|can|should $; ^ why not $; ^ i|you do; ^ ALL right \
     $; ^ please $; ^ ?YES that|THING be THING $; ^ you bet",
);

pub(super) const NO: RequestKind = RequestKind::answer(
    Act::Tells(|_, _| Answer::tells("All right, I will do nothing")),
    "said: i disagree; not what i mean|want; change|changed my mind; ^ NO; ^ wrong|incorrect|false; ^ not \
     really|quite|THING|yet|now|so|right|correct|true|me|at|in; ^ that|THING be not|wrong|false|incorrect; ^ i do \
     not think|want|believe; ^ rather|better not; ^ never|not $; ^ i would rather not; ^ let us not; ^ no THANKS \
     ?you; i =said no",
);

pub(super) const WHICH: RequestKind = RequestKind::answer(
    Act::Tells(Conversation::which),
    "said: THING ?that i mean|want|need|think; i be|was =talking|=thinking about|of THING; ^ ?not \
     ?it|take|choose|mean|be|want|that|prefer THING ?ON|with|by|that|which|i|from|FAR|NEAR ?your ?my \
     ?left|right|side|front|back|mean|want|end|other $; ^ ON ?your|my left|right; ^ \
     first|second|third|last|left|right|NEAR|FAR $; ^ i mean|want|choose|pick|prefer|meant THING; ^ \
     either|whichever|any $; ^ number NUMBER; THING ?be THING; ^ leftmost|rightmost|either|whichever ?you \
     ?like|want|please; THING ?over ON left|right; not matter which",
);

pub(super) const WHO: RequestKind = RequestKind::answer(
    Act::Tells(|creature, _| {
        let name = sentence(creature.actor.own.creature().name());
        Answer::tells(format!(
            "I am {name}. I am blindfolded: I know my body from self-touch, and my surroundings from what I feel"
        ))
    }),
    "asked: who HELPING you; who you be; who|what ?you be you; who|whom do|be|have i|we \
     have|the|TELL|=talking|=speaking|SPEAK; which|what KIND|BEING ?of ?BEING|THING|SOME be|are you; your \
     purpose|function|job|name; ^ ?and you be $; you have name; be you ?called|named \
     BEING|real|alive|virtual|SOME|max; you be max; INTRODUCE yourself; call|named|name you; who be \
     =speaking|=talking|there|this; about yourself; be this|that BEING; identify|introduce yourself",
);

pub(super) const HELP: RequestKind = RequestKind::answer(
    Act::Tells(|_, _| Answer::tells(ABILITIES)),
    "said: ^ i =need|=want .. help|assistance; ^ i could|can ?use ?some help; ^ how do|does THING|it work; ^ i be \
     stuck|lost|confused; told: give|show ?me|us .. COMMANDS; guide|instruct|help|assist|teach me; walk me \
     through; asked: what ?all you can|could|may do; what to SPEAK|TELL|do; what ?else|ALL|things|KIND ?of \
     ?SOME|THING HELPING you|i|we TELL|SPEAK|understand|offer|KNOW|try|want|request|DO; what be you \
     able|capable|good|for; what|which|TELL|your|all|give|any ?ALL|of ?THING|your|ALL|be ?your COMMANDS; help \
     ?me|us ?out $; what be possible; what be my|the options|choices|possibilities; be there ?any COMMANDS|help; \
     what you HELPING|understand|KNOW $; how .. ?to USE you; what i HELPING; how HELPING i; how do you \
     work|function; what next|now|else $; ^ COMMANDS",
);

pub(super) const REPORT: RequestKind = RequestKind::answer(
    Act::Tells(Conversation::report),
    "told: the result|outcome|upshot|summary|story; asked: what ?have HAPPEN; how do|be THING|that go|went|turn; \
     success|successful; what be result|outcome|upshot; summary|report|recap|recount; status|progress; ^ ?ALL \
     =done|=finished $; past: you; what|how|where =went|go; how many time|times & you; you|BODY|HAND|THING|SOME \
     PAST; what ?be result|outcome|upshot; THING|SOME GO|work|HAPPEN|succeed|fall|fail; HAPPEN; \
     success|luck|work|successful; ^ HELPING you|THING|SOME; what come|came of|out",
);

impl Conversation {
    /// What words mean is meant from when they were heard on.
    fn which(&self, request: &Request) -> Answer {
        let things = &self.mind.things;
        Answer::tells(match (request.which, things.it()) {
            (Some(_), Some(known)) => format!("You mean the one {}", self.place(&known.at)),
            (None, Some(known)) if things.len() == 1 => {
                format!("I know of only one thing, {}", self.place(&known.at))
            }
            _ if things.is_empty() => "I have not felt anything yet, so I do not know which you mean".into(),
            _ => format!("I do not know which one you mean. {}", self.mind.question(&self.actor)),
        })
    }

    fn report(&self, request: &Request) -> Answer {
        let asked = |deed: &&Deed| {
            request.about.is_none_or(|about| {
                let touch = about == Intent::Touch;
                // "What did you touch?" is about its own body as well.
                let own = touch && request.open && deed.intent == Intent::TouchOwn;
                deed.intent == about || (touch && deed.touched) || own
            })
        };
        let deeds: Vec<&Deed> = self.mind.deeds.iter().filter(asked).collect();
        let last: Vec<&str> = deeds.iter().rev().take(LAST).rev().map(|deed| deed.words.as_str()).collect();
        Answer::tells(match (request.about.filter(|_| !request.open), last.as_slice()) {
            (None, []) if self.mind.deeds.is_empty() => "I have not done anything yet".to_string(),
            (None, []) => "I have not done anything of that kind".to_string(),
            (None, told) => format!("I {}", told.join("; then I ")),
            (Some(about), []) => format!("No, I did not {}", doing(about, None)[0]),
            (Some(_), [.., latest]) => match deeds.iter().rev().find(|deed| deed.done) {
                Some(deed) => format!("Yes: I {}", deed.words),
                None => format!("No: I {latest}"),
            },
        })
    }

    /// What it says where it did not understand: why, and three examples that fit what it knows by now.
    pub(in super::super) fn not_understood(&self, unknown: &[UnknownWord]) -> Reply {
        let things = &self.mind.things;
        let examples = match (things.is_empty(), things.iter().any(|known| known.in_touch.is_some())) {
            (true, _) => ["is there something in front of you?", "touch your nose", "what can you do?"],
            (_, false) => ["touch it with your left hand", "is it near or far?", "is there anything else?"],
            (_, true) => {
                ["where do you feel this?", "touch it with your other hand", "put it as far away as possible"]
            }
        };
        let told = unknown.first().map_or("I did not understand that".to_string(), UnknownWord::in_words);
        let examples = examples.join("\", \"");
        self.reply(
            Intent::Unknown,
            Answer::tells(format!("{told}. I understand, for example: \"{examples}\"")),
        )
    }
}
