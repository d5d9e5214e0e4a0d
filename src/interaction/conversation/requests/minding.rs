//! What changes what it keeps in mind alone: "don't touch it", "stop", "keep still", "forget it", "goodbye".

use super::{Act, Answer, RequestKind, doing};
use crate::interaction::conversation::speaking::place_in_words;

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
