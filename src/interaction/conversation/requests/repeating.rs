//! "Again."

use super::super::Conversation;
use super::{Act, Intent, Reply, RequestKind};
use crate::interaction::conversation::language::{Leave, Request};
use crate::simulation::EngineError;

pub(super) const REPEAT: RequestKind = RequestKind {
    told: &[
        "^ ?and|now ?try again|repeat|retry|redo|encore|rerun",
        "once|one|twice|another ?more|last more|again|time",
        "do|try|attempt|perform ?THING|so|the|that ?same ?thing ?all|over again|over|anew|afresh",
        "have|take|give ?THING ?a second|third|another|further go|try|attempt|shot",
        "do|try|see|have ?THING|SOME ?all ?over ?yet ?once again",
        "go again",
        "do THING ?one|once more",
        "another|one|have|give|make ?THING ?another|a|one ?more|second|last go|try|attempt|shot|crack|whirl",
        "same again|thing|procedure",
        "try ?THING|it ?all again|anew|harder|more|over",
        "^ same THING $",
        "go|start|try over again",
        "^ try ?that|THING ?harder|more $",
        "do what you =did",
        "keep =trying|going",
        "as|like before",
    ],
    ..RequestKind::new(
        ["do it again", "did it again"],
        Act::Moves(|creature, request, leave| creature.repeat(request, leave)),
    )
};

impl Conversation {
    fn repeat(&mut self, request: &Request, leave: &Leave) -> Result<Reply, EngineError> {
        let Some(last) = self.last.clone() else {
            return self.fails(Intent::Repeat, "I have not done anything yet that I could do again");
        };
        let again = Request { hand: request.hand.or(last.hand), lean: request.lean || last.lean, ..last };
        let reply = self.act(again, Some(leave.again()), &[])?;
        Ok(Reply { intent: Intent::Repeat, ..reply })
    }
}
