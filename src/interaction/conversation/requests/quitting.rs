//! "Goodbye": the conversation ends.

use super::{Act, Answer, RequestKind};

pub(super) const QUIT: RequestKind = RequestKind {
    told: &[
        "^ quit|exit|leave|logout|disconnect|terminate $",
        "^ quit|exit|terminate ?this|the|our program|session|conversation|talk|chat",
        "^ end|finish|terminate|conclude|close|stop|leave ?the|this|our conversation|talk|session|chat|dialogue|program",
        "^ stop|quit =talking|=listening",
        "^ exit",
        "^ log|sign out|off",
        "^ shut down|off",
        "^ turn|switch yourself off",
        "^ stop|end|finish here|it|there|for",
    ],
    said: &[
        "^ bye|goodbye|farewell|ciao|adieu|quit|exit|byebye",
        "^ see|catch you later|soon|tomorrow|again|around",
        "^ see you",
        "^ so long $",
        "^ ?and ?i ?think that|this|it|THING be ?all ?it|for|from ?now|today|me|folks|then $",
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
        "enough for today",
        "time to go|stop|leave|finish|quit|end",
        "^ good bye",
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
