//! "Again."

use super::super::Conversation;
use super::{Act, Acted, Answer, RequestKind};
use crate::interaction::conversation::grammar::{Leave, Request};

pub(super) const REPEAT: RequestKind = RequestKind::new(
    ["do it again", "did it again"],
    Act::Moves(|creature, request, leave| creature.repeat(request, leave)),
)
.said("^ another $ ; NUMBER MORE time")
.told(
    "^ ?and ?try AGAIN ; ^ ?and AGAIN but ; from the top ; DO over ; another|other go|try|time ; \
         ^ REPEAT ; REPEAT THING ; ^ encore ; once|one|twice|another ?last MORE ?again|time ; \
         DO|TRY|attempt|have ?THING|so|that|SOME ?same ?thing ?ALL|over ?yet ?once ?over \
         AGAIN|over|anew|afresh ; \
         have|take|give ?THING ?another ?second|third|further|MORE \
         go|try|TRY|attempt|shot|crack|stab|bash|whirl|GO ; go AGAIN|over ; DO THING ?one|once MORE|again ; \
         another|one|a|second MORE|another|last|go ?go TRY|go|attempt|shot|crack|time ; \
         DO ?that same ?again|thing ; same again|thing|procedure ; TRY ?THING ?ALL AGAIN|harder|MORE|over ; \
         ^ same THING $ ; DO as .. before ; the same ?thing with|ON|AGAIN ; have|get THING AGAIN ; \
         go|start|TRY over again ; do what you =did ; keep =trying|going ; as|like before ; \
         another try|go|time ; second|third time ; TRY AGAIN ; AGAIN $ & !HELLO ; DO .. AGAIN ; \
         AGAIN with HAND ; one more ; MORE time ; ^ ?and same ?thing ; \
         make|have|give ?it another|MORE|second ?ANY TRY|try|attempt|shot|go|time ; \
         ^ another|MORE|second TRY|attempt ; perform|play|show|see ?THING|that AGAIN ; \
         go through THING AGAIN ; REPEAT ; REPEAT ?your|that last|action|thing ; same .. with|using HAND ; \
         another|one ?MORE go|try|attempt ; see|hear THING AGAIN ; another|one ?MORE round|turn ; \
         ^ take two ; run THING BACK",
);

impl Conversation {
    fn repeat(&mut self, request: &Request, leave: &Leave) -> Acted {
        let Some(last) = self.last.clone() else {
            return Ok(Answer::failed("I have not done anything yet that I could do again"));
        };
        let again = Request { hand: request.hand.or(last.hand), lean: request.lean || last.lean, ..last };
        Ok(self.act(again, Some(leave.again()), &[])?.into())
    }
}
