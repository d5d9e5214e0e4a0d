//! "Stop."

use super::{Act, Answer, RequestKind};

pub(super) const STOP: RequestKind = RequestKind::new(
    ["stop", "stopped"],
    Act::Minds(|mind, _| {
        *mind.still = true;
        Answer::done("I have stopped, and stay as I am")
    }),
)
.told(
    "^ STOP $ ; THING|that|ok will DO ; that be enough ; \
         ^ STOP|quit ?DOING ?what|whatever|THING|everything|ALL $ ; \
         ^ STOP what|whatever|THING|ALL|everything ; ^ STOP ?right there ; ^ END what|whatever ; \
         ^ wait|hold ?on|up|it ?there ?moment|minute|second|there $ ; ^ hold on|up ; \
         knock|pack|cut THING off|out ; ^ STOP ; interrupt ; ^ hold your horses ; leave off ; \
         ^ ANY STOP $ ; ^ END that $ ; break THING off ; leave THING at THING ; chuck|pack THING in",
)
.denied(
    "^ STOP|quit what|whatever|you ; ^ STOP|cease ?THING $ ; no more $ ; \
         no|not ?go ?carry ?any continue|on|further ; cut THING out ; ^ leave off",
)
.said(
    "i =said stop ; enough ; ^ THING|that ?be|will ?DO quite|sufficient|do|enough ; \
         ^ STOP|whoa|woah|wait|pause|abort|cancel|halt ; never mind ; ^ ?ANY STOP $ ; leave off $ ; \
         ^ hang on ; THING|that be enough|plenty|sufficient ; ^ give up $ ; ^ break off ; ^ time out $ ; \
         ^ pack THING|in ; ^ cut $ ; ^ chuck THING in ; leave THING at THING ; ^ break THING off ; \
         ^ END THING|that $ ; that|THING be plenty",
);
