//! "Rest."

use super::{RequestKind, Utterance};

pub(super) const REST: RequestKind = RequestKind {
    means: |utterance: &Utterance| {
        utterance.any(&["rest", "stop", "relax"]) || utterance.text.contains("let go")
    },
    needs_body: false,
    needs_thing: false,
    act: |creature, request| {
        creature.actor.let_go();
        let ready = creature.ready.clone();
        let went = creature.settle(&ready);
        let said =
            if went { "I am at rest again" } else { "I cannot get back to rest: something is in the way" };
        Ok(creature.reply(request.intent, said.into(), Some(went), false))
    },
};
