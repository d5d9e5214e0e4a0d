//! "Rest."

use super::super::Conversation;
use super::{Act, Acted, Answer, RequestKind};

pub(super) const REST: RequestKind =
    RequestKind::new(["go back to rest", "went back to rest"], Act::Moves(|creature, _, _| creature.rest()))
        .past("^ as you be ; HAND BACK")
        .told(
            "^ assume|adopt|resume|take|take .. START ?old POSE ; \
         BACK to the|your|where ?old START|rest|beginning|place ; \
         have|take|get ?yourself|your ?GOOD|BIT|short|well ?earned|deserved rest|break|breather ; at ease ; \
         START POSE ; GO|return|sit ?BACK home ; GO ?BACK to|into rest|START|normal|base ; \
         lower|drop|relax|withdraw|retract|hang|rest|DROP ?both BODY ; \
         PUT|lower|take|bring|let|LET|lay|rest|PULL|DROP ?both HAND ?BACK \
         DOWN|BACK|rest|hang|fall|away|in|at|by|home|drop ; PUT|lower|take|PULL|bring DOWN|BACK HAND ; \
         HAND ?sink|fall|drop|GO DOWN|BACK $ ; HAND ?BACK ?DOWN ?please $ & DOWN|BACK ; \
         HAND ?BACK ?DOWN to|at|by|in ?your side|sides|lap|START|rest ; ^ ?time ?for rest $ ; ^ rest ; \
         settle down|BACK ; reset yourself|your|BODY ; \
         BACK|GO|return|PUT .. where|how ?you|THING|they ?PAST \
         start|begin|=was|=were|came|=started|=began|PAST ; RELAX ; a|short|good|BIT rest|break|breather ; \
         LET HAND sink|drop|fall|hang|rest ; take THING easy ; ?BACK to|into your|the ?START POSE ; \
         DROP|lower HAND ; ^ return $ ; as you were ; take five $ ; GO limp|slack ; \
         GO ?BACK to your|the START ?POSE ; GO BACK to|rest|START ; rest $ ; chill ; \
         stand down|easy|easily ; hang loose ; a rest ; \
         PUT|park|fold|bring|move|return|take|draw|PULL ?both BODY in|back|away|DOWN ; park BODY ; \
         GO|return|fold|move|come BACK|to|in|into ?to|in|into ?your START ?POSE ; \
         assume|adopt|take|resume ?your START POSE ; GO idle|comfortable ; START ?POSE ?please $ ; \
         BACK ?to|at|in ?your START ?POSE ; lower BODY ; BACK to ?your POSE ; GO BACK to POSE ; \
         ease off|up $ ; take|get|PULL|remove HAND off|from TABLE ; ^ stand|kick|simmer|power down|back $ ; \
         ^ slack|ease off ; ^ go BACK $ ; ^ reset $ ; HAND BACK ?to ?where ; ^ go to sleep ; ^ as you be",
        );

impl Conversation {
    fn rest(&mut self) -> Acted {
        self.actor.let_go();
        self.let_be();
        Ok(match self.settle_at_ready() {
            true => Answer::done("I am at rest again"),
            false => Answer::failed("I cannot get back to rest: something is in the way"),
        })
    }
}
