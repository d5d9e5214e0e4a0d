//! "Rest."

use super::super::Conversation;
use super::{Act, Intent, Reply, RequestKind};
use crate::simulation::EngineError;

pub(super) const REST: RequestKind = RequestKind {
    told: &[
        "^ assume|adopt .. start|=starting|=resting|rest|initial|original posture|position|pose",
        "back to the|your ?old start|rest|beginning|place",
        "have|take ?a|your ?good|little|short|well ?earned rest|break|breather",
        "at ease|rest $",
        "starting|initial|resting|rest|home|neutral|default|original|ready|waiting|start position|posture|pose|place|stance|state",
        "go|return|come ?back home",
        "go|return|get|move|come ?back to rest|start|normal|base",
        "lower|drop|relax|withdraw|retract|hang HAND|BODY",
        "put|lower|take|bring|let|lay|rest ?both HAND|BODY down|back|rest|hang|fall|away|in|at|by",
        "put|lower|take|pull down|back HAND|BODY",
        "HAND ?sink|fall|drop|come|go down|back $",
        "HAND ?back ?down to|at|by|in ?your|the side|sides|lap",
        "^ ?time|how ?about ?for ?you|it ?would ?that|to ?deserve|earn|need|get ?yourself|THING ?ought ?a ?little|short|good|well ?deserved|earned rest $",
        "settle down|back",
        "reset yourself|your|BODY",
        "HAND ?go back ?to where|how",
        "back|go|return|move|get|put .. where|how you|THING|they start|begin|was|were|came|be",
        "relax|unwind",
        "^ return $",
        "as you were $",
    ],
    ..RequestKind::new(["go back to rest", "went back to rest"], Act::Moves(|creature, _, _| creature.rest()))
};

impl Conversation {
    fn rest(&mut self) -> Result<Reply, EngineError> {
        self.actor.let_go();
        self.let_be();
        let went = self.settle_at_ready();
        let said =
            if went { "I am at rest again" } else { "I cannot get back to rest: something is in the way" };
        Ok(self.reply(Intent::Rest, said.into(), Some(went), false))
    }
}
