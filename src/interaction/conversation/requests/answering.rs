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
        "^ i do|think so",
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
        "^ i would|had rather not",
        "^ never $",
        "^ not $",
        "^ you be wrong|mistaken",
    ],
    ..RequestKind::new(["", ""], Act::Minds(|_, _| Answer::tells("All right, I do nothing")))
};

pub(super) const WHICH: RequestKind = RequestKind {
    said: &[
        "^ ?the THING ?farther|further|closer|nearer ?away|off $",
        "^ ?the first|second|third|last|left|right|nearer|farther|nearest|farthest|closer|further|closest of",
        "^ ?not ?the|it|take|choose|mean|be|want|that|prefer THING ?on|to|at|with|by|that|which|in|i|from|further|closer ?the|your ?my ?left|right|side|front|back|mean|want|end|other $",
        "^ ?the first|second|third|last|left|right|nearer|farther|nearest|farthest|closer|further|closest $",
        "^ ?the first|second|third|last THING",
        "^ on|to ?the|your|my left|right",
        "^ i mean|want|choose|pick|prefer|meant THING",
        "^ the closer|nearer|left|right|farther|nearest|first|second|last of",
        "^ i would say THING",
        "^ either|whichever|any $",
        "^ either|whichever|any of THING",
        "^ number one|two|three",
    ],
    ..RequestKind::new(
        ["", ""],
        Act::Minds(|mind, request| match request.which.and_then(|which| mind.find(which)) {
            Some(i) => {
                mind.things.mean(Some(i));
                Answer::tells(format!("You mean the one {}", mind.place(i)))
            }
            None if mind.things.len() == 1 => {
                Answer::tells(format!("I know of one thing only, {}", mind.place(0)))
            }
            None if mind.things.is_empty() => {
                Answer::tells("I have not felt anything yet, so I do not know which you mean")
            }
            None => Answer::tells(format!("I do not know which one you mean. {}", mind.question())),
        }),
    )
};
