//! What changes what it keeps in mind alone: "don't touch it", "stop", "keep still", "forget it", "goodbye".

use super::{Act, Answer, RequestKind, doing};
use crate::interaction::conversation::speaking::place_in_words;

pub(super) const DONT: RequestKind = RequestKind::new(
    ["", ""],
    Act::Minds(|mind, _, request| {
        let Some(intent) = request.about else {
            return Answer::done("All right, I do not do that");
        };
        mind.forbid(intent, request.part.clone());
        Answer::done(format!("All right, I will not {}", doing(intent, request.part.as_ref())[0]))
    }),
    "",
);

pub(super) const KEEP_STILL: RequestKind = RequestKind::new(
    ["keep still", "kept still"],
    Act::Minds(|mind, _, _| {
        mind.still = true;
        Answer::done("I keep still until you ask me to do something")
    }),
    "told: ^ KEEP|LOOK ?BODY|yourself|THING ?all ?as STILL ; ^ KEEP ?right where|there|as|like ?you|THING ; \
     STOP|KEEP ?right where|there ; ^ freeze ; ^ stay|still $ ; ^ stay|remain|keep|hold ?in \
     your|that|this|the|same ?same|present|current POSE ; keep|hold ?your ground ; ^ statue $ ; \
     play|be|like|as dead|statue|rock|stone ; rest motionless|still ; KEEP BODY|yourself ?right where|as \
     they|THING|you be ; stay|remain BODY ; ^ hold ?THING ?right there|still ; ^ =hold =it $ ; stand by ; \
     KEEP ?in POSE $ ; denied: not a|one|another move|muscle|inch|step|MORE ; not|never ?you ?even ?ever \
     ?dare ?to STIR !THING ; without =moving ; no =moving|movement|movements|motion|motions ; =move not ; \
     nothing move $ ; do nothing $ ; no|not ?any movement|movements|=moving ; nobody move ; not go|get \
     anywhere ; no|quit|stop|STOP =fidgeting|=moving|=wriggling|=squirming|fidget|STIR",
);

pub(super) const STOP: RequestKind = RequestKind::new(
    ["stop", "stopped"],
    Act::Minds(|mind, _, _| {
        mind.still = true;
        Answer::done("I have stopped, and stay as I am")
    }),
    "said: i =said stop ; enough ; ^ THING|that ?be|will ?DO quite|sufficient|do|enough ; ^ \
     STOP|whoa|woah|wait|pause|abort|cancel|halt ; never mind ; ^ hang on ; THING|that be \
     enough|plenty|sufficient ; ^ give up $ ; ^ time out $ ; ^ pack THING|in ; ^ cut $ ; ^ END THING|that \
     $ ; told: THING|that|ok will DO ; ^ STOP|quit ?DOING ?what|whatever|THING|everything|ALL $ ; ^ END \
     what|whatever ; ^ wait|hold ?on|up|it ?there ?moment|minute|second|there $ ; knock|pack|cut THING \
     off|out ; ^ STOP ; ^ hold your horses ; ^ END that $ ; break THING off ; leave THING at THING ; \
     chuck|pack THING in ; denied: no more $ ; no|not ?go ?carry ?any continue|on|further ; cut THING out ; \
     ^ leave off",
);

pub(super) const FORGET: RequestKind = RequestKind::new(
    ["forget it", "forgot it"],
    Act::Minds(|mind, actor, request| match mind.find(actor, request.which).or(mind.things.it()).cloned() {
        _ if mind.things.is_empty() => Answer::done("There is nothing that I have felt and could forget"),
        _ if request.all => {
            mind.forget_all();
            Answer::done("I have forgotten all that I felt of things")
        }
        Some(known) => {
            mind.forget(&known);
            Answer::done(format!("I have forgotten the thing {}", place_in_words(actor, &known.at)))
        }
        None => Answer::asks(mind.question(actor)),
    }),
    "told: FORGET ; CLEAR ?out your|THING|the|ALL ?whole|entire MEMORY ; PUT|CLEAR|get|lose|PUSH|take \
     THING|SOME|ALL|what ?ALL out|from ?of ?from ?your MEMORY ; ^ wipe|clear THING|everything|ALL & \
     !HAND|TABLE ; CLEAR what|whatever|ALL ?that ?THING ?you KNOW|FEEL|felt|FIND ; fresh START|beginning ; \
     start ALL|AGAIN|afresh|over ; from scratch ; clean slate ; LET THING slip ; put THING behind you ; \
     lose THING from ; MEMORY .. CLEAR ; PUT|get|take|clear THING|SOME|ALL out of ?your \
     head|mind|memory|BODY ; begin|start anew ; denied: not|longer remember ; forget about =remembering",
);

pub(super) const QUIT: RequestKind = RequestKind::new(
    ["end our talk", "ended our talk"],
    Act::Minds(|mind, _, _| {
        mind.over = true;
        Answer::done("Goodbye")
    }),
    "said: i|we ?have|must|better|should|need ?got|had ?better|best ?to be|dash off|away ; no more \
     questions ; ^ BYE|quit|exit ; ^ so long $ ; BYE $ ; ^ see you ; ^ THING be ALL ; ^ i be \
     =going|=leaving $ ; ^ ?let|us|time ?us ?to end|finish THING|it ?here|now|there $ ; ^ that|THING will \
     be ALL ; ^ good night ; ^ ?i|we ?think ?i|we be ALL|through|=leaving|off|=done|=finished ; ^ i|we \
     HELPING|=got|better ?to|=got ?to|better =go|=leave|=run|quit|stop ; until next|tomorrow|then|later ; \
     over and out ; ^ ALL =done|=finished ; SPEAK to you later|soon|tomorrow ; ^ later $ ; take care ; have \
     a|an ?GOOD day|evening|night|one ; ^ END $ ; keep in touch ; ALL for today|now ; THING ALL for|today ; \
     end of ?our|this TALK ; ^ that|THING be it ?for ?now ; catch you later ; i be out|off $ ; night \
     night ; ^ =dismissed ; no more for today|now ; told: ^ END|STOP|call THING day|here|now ; ^ STOP|END \
     here ; wrap THING up|for ?for ?today ; ^ quit|exit|end|finish $ ; ^ END|leave|finish|end \
     ?this|our|THING TALK ; ^ turn|switch yourself off ; ^ switch|shut|power|log|sign ?THING|yourself \
     off|down|out $ ; wrap THING|up ; ^ ?have ?to go $ ; denied: STOP|cease =talking|=listening",
);
