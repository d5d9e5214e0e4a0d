//! "Rest."

use super::super::Conversation;
use super::{Act, Intent, Reply, RequestKind};
use crate::simulation::EngineError;

pub(super) const REST: RequestKind = RequestKind {
    told: &[
        "back to the|your ?old start|rest|beginning|place",
        "^ rest|relax|unwind|chill ?yourself|BODY|for|now|a|well ?while|bit|moment $",
        "have|take ?a|your ?good|little|short|well ?earned rest|break|breather",
        "at ease|rest $",
        "go|return|get|move|come|retreat|bring|put|take|withdraw|pull ?back ?yourself|BODY|everything|both ?back|home|down ?to|into|in ?a|your|the|where|how ?original ?rest|home|neutral|starting|start|initial|resting|first|default|base|ready|usual|normal|relaxed|waiting|original position|posture|pose|place|stance|state",
        "starting|initial|resting|rest|home|neutral|default|original|ready|waiting|start position|posture|pose|place|stance|state",
        "go|return|come ?back home",
        "go|return|get|move|come ?back to rest|start|normal|base",
        "lower|drop|relax|withdraw|retract|hang HAND|BODY",
        "put|lower|take|bring|let|lay|rest ?both HAND|BODY down|back|rest|hang|fall|away|in|at|by",
        "put|lower|take|pull down|back HAND|BODY",
        "HAND ?sink|fall|drop|come|go down|back $",
        "^ assume|adopt .. start|=starting|=resting|rest|initial|original posture|position|pose",
        "HAND ?back ?down to|at|by|in ?your|the side|sides|lap",
        "^ ?time|how ?about ?for ?you|it ?would ?that|to ?deserve|earn|need|get ?yourself|THING ?ought ?a ?little|short|good|well ?deserved|earned rest $",
        "take THING easy",
        "back to where|rest|start|home|how",
        "settle down|back",
        "sit|stand back and relax",
        "calm down",
        "reset yourself|your|BODY",
        "HAND ?go back ?to where|how",
        "back|go|return|move|get|put .. where|how you|THING|they start|begin|was|were|came|be",
        "be at rest|ease",
        "relax|unwind",
        "be|stand idle|down",
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
