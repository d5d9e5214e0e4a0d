//! "Yes", "no", "the nearer one".

use super::{Act, Answer, RequestKind};

pub(super) const YES: RequestKind =
    RequestKind::new(["", ""], Act::Tells(|_, _| Answer::tells("Good; but I did not ask you anything")))
        .past("^ you understand ?me|THING|right $ ; ^ you have|=got THING|that $")
        .said(
            "i agree ; that|THING suits|works|suit ; ^ that would be GOOD $ ; ^ well $ ; \
         i think|suppose|guess|believe|hope so ; what i mean|want ; ^ make THING so ; \
         you ?have =got|understand THING|me|right ; ^ YES $ ; ^ YES ; ^ YES thing ; ^ go ahead|on ; \
         ^ go for it ; ^ DO it|so|that|THING $ ; ^ DO $ ; ^ of course ; \
         ^ that|THING be right|correct|true|fine|it ; ^ by all means ; ^ you may|can|should $ ; \
         ^ why not $ ; ^ sounds good|fine|right ; ^ that|THING be one|idea|case $ ; \
         ^ YES ?go|DO ?ahead|THING ; you ?have get|=got THING ; ^ i|you ?HELPING do $ ; ^ you|uh huh $ ; \
         ^ i|you do ; ^ ALL right $ ; ^ please $ ; ^ ?YES that|THING be THING $ ; ^ spot on ; ^ you bet ; \
         ^ sounds GOOD ; you understand ?me|THING|right",
        );

pub(super) const NO: RequestKind =
    RequestKind::new(["", ""], Act::Minds(|_, _| Answer::tells("All right, I do nothing")))
        .past(
            "you =got|get THING|that|me wrong ; THING|that be wrong|mistake|mistaken ; you be wrong ; \
         you =misunderstood",
        )
        .said(
            "i disagree ; not what i mean|want ; i do not mean ; =misunderstood ; change|changed my mind ; \
         ^ NO ; ^ NO way|thanks|thank ; ^ wrong|incorrect|false ; \
         ^ not really|quite|THING|yet|now|so|right|correct|true|me|at|in ; \
         ^ that|THING be not|wrong|false|incorrect ; ^ i do not think|want|believe ; ^ YES not ; \
         ^ of course not ; ^ rather|better not ; ^ never|not $ ; ^ you be wrong|mistaken ; \
         ^ i would rather not ; ^ let us not ; ^ no thank|THANKS ?you ; i =said no ; \
         ^ not ?now|today|yet|this|like ?now THANKS ; ^ not bother ; ^ do not bother ; ^ leave THING $ ; \
         ^ uh uh $ ; no|not .. bother|need $",
        );

pub(super) const WHICH: RequestKind = RequestKind::new(
    ["", ""],
    // What words mean is meant from when they were heard on.
    Act::Minds(|mind, request| match (mind.find(request.which), mind.things.it()) {
        (Some(known), _) => Answer::tells(format!("You mean the one {}", mind.place(known))),
        (None, Some(known)) if mind.things.len() == 1 => {
            Answer::tells(format!("I know of one thing only, {}", mind.place(known)))
        }
        (None, _) if mind.things.is_empty() => {
            Answer::tells("I have not felt anything yet, so I do not know which you mean")
        }
        (None, _) => Answer::tells(format!("I do not know which one you mean. {}", mind.question())),
    }),
)
.told("^ choose|mean THING|one")
.said(
    "THING ?that i mean|want|need|think ; i be|was =talking|=thinking about|of THING ; \
         ^ THING be THING ; either|whichever|any one|THING ; THING be THING ?that ; about THING $ ; \
         ^ ?make ?THING THING $ ; \
         ^ ?not ?it|take|choose|mean|be|want|that|prefer THING ?ON|at|with|by|that|which|in|i|from|FAR|NEAR \
         ?your ?my ?left|right|side|front|back|mean|want|end|other $ ; ^ ON ?your|my left|right ; \
         ^ first|second|third|last|left|right|NEAR|FAR $ ; ^ first|second|third|last THING ; \
         THING i mean|want|choose|meant $ ; ^ i mean|want|choose|pick|prefer|meant THING ; \
         ^ either|whichever|any $ ; ^ either|whichever|any of THING ; ^ number NUMBER ; \
         ^ number one|two|three ; ^ THING ON ?your left|right ; THING ?be THING ; ^ not THING THING ; \
         say THING|first|second|last ; both .. whichever|either ; whichever|either $ ; \
         ^ leftmost|rightmost|either|whichever ?you ?like|want|please ; THING ?over ON left|right ; \
         not matter which ; ^ left|right ?hand ?side one|THING ; which ?THING ?you like",
);
