//! "Stop."

use super::{Act, Answer, RequestKind};

pub(super) const STOP: RequestKind = RequestKind {
    told: &[
        "^ stop|halt|cease|pause|abort|cancel|desist|whoa ?THING|everything|right|what|there|all|at|$",
        "^ wait $",
        "^ wait ?a|just ?moment|minute|second|there $",
        "^ hold THING|on|up $",
        "^ enough",
        "cut|knock|pack THING out|off",
        "cut|knock out|off THING",
        "^ quit|stop|cease|end|halt|drop THING",
        "^ quit|stop|cease|end|halt|finish what|whatever you",
        "^ stop|quit what|that|doing",
        "^ leave THING at that",
        "give THING a rest",
        "give up",
        "call THING off",
        "never mind",
        "^ drop everything|all",
        "^ break off",
        "^ no|not ?any|one more|further",
    ],
    said: &[
        "^ enough",
        "THING be enough",
        "enough ?of THING $",
        "^ enough is",
        "^ ?ok ?THING|that ?be|will ?do ?quite enough|sufficient",
        "^ that|this|THING will do",
        "^ stop|halt|whoa|wait|cease|pause|enough|abort|cancel|woah",
        "never mind",
        "^ no more $",
        "^ freeze $",
        "^ not ?go ?carry continue|on|further",
    ],
    ..RequestKind::new(
        ["stop", "stopped"],
        Act::Minds(|mind, _| {
            *mind.still = true;
            Answer::does("I have stopped, and stay as I am", true)
        }),
    )
};
