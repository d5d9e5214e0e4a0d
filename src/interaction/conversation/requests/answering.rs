//! "Yes", "no", "the nearer one".

use super::{Act, Answer, RequestKind};

pub(super) const YES: RequestKind = RequestKind {
    said: &[
        "^ yes|yeah|yep|yup|yea|aye|sure|ok|okay|alright|absolutely|certainly|definitely|affirmative|agreed",
        "^ go ahead|on",
        "^ do it|so|that $",
        "^ correct|exactly|indeed|right|true|naturally|fine|precisely",
        "^ of course",
        "^ that|THING be right|correct|true|fine|it",
        "^ by all means",
        "^ you may|can|should $",
        "^ why not $",
        "^ =do $",
        "^ sounds good|fine|right",
        "^ that|THING be ?the one|idea|case $",
        "^ you be|have ?got right|it",
    ],
    ..RequestKind::new(["", ""], Act::Tells(|_, _| Answer::tells("Good; but I did not ask you anything")))
};

pub(super) const NO: RequestKind = RequestKind {
    said: &[
        "^ no|nope|nah|negative|nay",
        "^ wrong|incorrect|false",
        "^ not really|quite|exactly|THING|yet|now|so|right|correct|true|me|at|in",
        "^ that|THING be not|wrong|false|incorrect",
        "^ i do not think|want|believe",
        "^ certainly|absolutely|definitely|of not",
        "^ of course not",
        "^ rather|better not",
        "^ do not $",
        "^ never $",
        "^ not $",
        "^ you be wrong|mistaken",
    ],
    ..RequestKind::new(["", ""], Act::Minds(|_, _| Answer::tells("All right, I do nothing")))
};

pub(super) const WHICH: RequestKind = RequestKind {
    said: &[
        "^ ?the THING ?farther|further|closer|nearer ?away|off $",
        "^ ?not ?the|it|take|choose|mean|be|want|that|prefer THING ?on|to|at|with|by|that|which|in|i|from|further|closer ?the|your ?my ?left|right|side|front|back|mean|want|end|other $",
        "^ on|to ?the|your|my left|right",
        "^ ?the first|second|third|last|left|right|nearer|farther|nearest|farthest|closer|further|closest $",
        "^ ?the first|second|third|last THING",
        "^ i mean|want|choose|pick|prefer|meant THING",
        "^ i would say THING",
        "^ either|whichever|any $",
        "^ either|whichever|any of THING",
        "^ number one|two|three",
    ],
    ..RequestKind::new(
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
};
