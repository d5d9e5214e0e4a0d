//! "Goodbye": the conversation ends.

use super::{Act, Answer, RequestKind};

pub(super) const QUIT: RequestKind = RequestKind::new(
    ["end our talk", "ended our talk"],
    Act::Minds(|mind, _| {
        *mind.over = true;
        Answer::done("Goodbye")
    }),
)
.past("that|THING be ALL")
.told(
    "^ END|STOP|call THING day|here|now ; ^ STOP|END here ; wrap THING up|for ?for ?today ; \
         ^ quit|exit|end|finish $ ; ^ END|leave|finish|end ?this|our|THING TALK ; ^ log|sign out|off ; \
         ^ shut down|off ; ^ turn|switch yourself off ; \
         ^ switch|shut|power|log|sign ?THING|yourself off|down|out $ ; wrap THING|up ; \
         call THING a night|day ; ^ ?have ?to go $ ; ^ go home $ ; power down ; time to go home",
)
.denied("STOP|cease =talking|=listening")
.said(
    "i|we ?have|must|better|should|need ?got|had ?better|best ?to be|dash off|away ; \
         i must|have ?to dash|run|go|leave ; end of our|the TALK ; \
         i be =going|=leaving|=off home|off|away|now ; no more questions ; \
         see you later|tomorrow|soon|then|again|around ; meet again ; you may go ; leave THING at THING ; \
         ^ BYE|quit|exit ; ^ so long $ ; BYE $ ; ^ YES BYE ; ^ see|SEE you ; ^ THING be ALL ; \
         ^ i be =going|=leaving $ ; ^ ?let|us|time ?us ?to end|finish THING|it ?here|now|there $ ; \
         ^ that|THING will be ALL ; ^ good night ; \
         ^ ?i|we ?think ?i|we be ALL|through|=leaving|off|=done|=finished ; \
         ^ i|we HELPING|=got|better ?to|=got ?to|better =go|=leave|=run|quit|stop ; \
         until next|tomorrow|then|later ; over and out ; ^ ALL =done|=finished ; \
         SPEAK to you later|soon|tomorrow ; ^ later $ ; take care ; have a|an ?GOOD day|evening|night|one ; \
         ^ END $ ; ^ finish ?here|now|up $ ; time to go|stop|leave|finish|quit|end ; let us STOP|END|call ; \
         that be ALL|THING ?for today ; keep in touch ; ALL for today|now ; THING ALL for|today ; \
         we be =done|=finished ; i be =done|off ; END here ; wrap THING up ; end of ?our|this TALK ; \
         ^ end TALK ; ^ that|THING be it ?for ?now ; SPEAK ?to ?you again ; catch you later ; \
         i be out|off $ ; wrap up ; night night ; ^ =dismissed ; no more for today|now ; \
         time|HELPING|have to go ?home|now ; have to go ; ^ gotta go",
);
