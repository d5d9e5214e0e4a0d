//! "Stop."

use super::{Act, Answer, RequestKind};

pub(super) const STOP: RequestKind = RequestKind {
    told: &[
        "^ stop|quit|cease|halt|drop ?doing what|whatever|THING|everything|all",
        "^ end|finish what|whatever",
        "^ wait ?a|just ?moment|minute|second|there $",
        "^ hold on|up $",
        "knock|pack THING off",
    ],
    said: &[
        "enough",
        "^ THING|that ?be|will ?do quite|sufficient|do",
        "^ stop|halt|whoa|woah|wait|cease|pause|abort|cancel",
        "never mind",
        "^ no more ?of ?THING $",
        "^ no|not ?go ?carry ?any continue|on|further",
    ],
    ..RequestKind::new(
        ["stop", "stopped"],
        Act::Minds(|mind, _| {
            *mind.still = true;
            Answer::does("I have stopped, and stay as I am", true)
        }),
    )
};
