//! "Forget it", "forget everything you felt".

use super::{Act, Answer, RequestKind};

pub(super) const FORGET: RequestKind = RequestKind::new(
    ["forget it", "forgot it"],
    Act::Minds(|mind, request| {
        let one = mind.find(request.which).or(mind.things.it());
        let one = one.map(|known| (known.id, mind.place(known)));
        match one.filter(|_| !request.all) {
            _ if mind.things.is_empty() => Answer::done("There is nothing that I have felt and could forget"),
            Some((id, place)) => {
                mind.forget(id);
                Answer::done(format!("I have forgotten the thing {place}"))
            }
            None if request.all => {
                mind.forget_all();
                Answer::done("I have forgotten all that I felt of things")
            }
            None => Answer::asks(mind.question()),
        }
    }),
)
.told(
    "FORGET ; FORGET ?about THING|SOME|everything|ALL ; \
         CLEAR ?out your|THING|the|ALL ?whole|entire MEMORY ; \
         PUT|CLEAR|get|lose|PUSH|take THING|SOME|ALL|what ?ALL out|from ?of ?from ?your MEMORY ; \
         ^ wipe|clear THING|everything|ALL & !HAND|TABLE ; \
         CLEAR what|whatever|ALL ?that ?THING ?you KNOW|FEEL|felt|FIND ; FRESH|fresh START|beginning ; \
         start ALL|AGAIN|afresh|over ; from scratch ; remember nothing ; clean slate ; LET THING slip ; \
         as if|though .. never ; put THING behind you ; lose THING from ; MEMORY .. CLEAR ; \
         PUT|get|take|clear THING|SOME|ALL out of ?your head|mind|memory|BODY ; begin|start anew",
)
.denied("not|longer remember ; need not|longer|to remember|KNOW ; forget about =remembering");
