//! "Goodbye": the conversation ends.

use super::{Act, Answer, RequestKind};

pub(super) const QUIT: RequestKind = RequestKind {
    told: &[
        "^ end|finish|terminate|conclude|close|stop|leave ?the|this|our conversation|talk|session|chat|dialogue|program",
        "^ log|sign out|off",
        "^ shut down|off",
        "^ turn|switch yourself off",
    ],
    said: &[
        "^ bye|goodbye|farewell|ciao|adieu|quit|exit|byebye",
        "^ see you",
        "^ THING be all",
        "^ i be =going|=leaving $",
        "^ ?let|us|time ?us ?to end|finish THING|it ?here|now|there $",
        "^ that|THING will be all",
        "^ good night",
        "^ ?i|we ?think ?i|we be all|through|=leaving|off|do|finish|done|finished",
        "^ i|we have|must|need|got|should|will|had|ought ?got|better ?to ?better go|leave|run|dash|quit|stop",
        "until next|tomorrow|then|later",
        "over and out",
        "^ all done|finished",
        "talk|speak to you later|soon|tomorrow",
        "^ later $",
        "take care",
        "have a|an ?good|nice|great|lovely day|evening|night|one",
        "^ end|finish|finished $",
        "^ finish ?here|now|up $",
        "time to go|stop|leave|finish|quit|end",
        "let us stop|end|finish|leave|call",
    ],
    ..RequestKind::new(
        ["end our talk", "ended our talk"],
        Act::Minds(|mind, _| {
            *mind.over = true;
            Answer::does("Goodbye", true)
        }),
    )
};
