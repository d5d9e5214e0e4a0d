//! "Feel its shape": it touches a thing all about with the fingertips of both hands, and tells how large it is.

use super::super::Conversation;
use super::{Act, Acted, Answer, RequestKind};
use crate::interaction::conversation::grammar::Request;
use crate::interaction::things::{KnownShape, KnownThing};

pub(super) const FEEL_SHAPE: RequestKind = RequestKind::new(
    ["feel its shape", "felt its shape"],
    Act::Handles(|creature, thing, request, _| creature.feel_shape(thing, request)),
)
.said("^ ALL AROUND|over|sides ?THING $")
.told(
    "FEEL|EXAMINE|SEARCH|FIND|TOUCH|get|make|sense|take|work .. FORM|EDGE|SIZE ; \
         work|find out ?what ?its FORM ; RUN .. EDGE|FORM ; \
         FEEL|FIND|EXAMINE|see ?out what THING|SOME be|look ; \
         FEEL|FIND|EXAMINE|work|see|SEARCH .. how SIZED|SHAPED ; \
         RUN ?with ?your HAND|PART ?slowly ?ALL ?way AROUND|over|along THING|the|its|EDGE ; \
         HAND|PART ?ALL ?way over|around|round|along|across THING ; EXAMINE|SEARCH|palpate THING ; \
         FEEL ?ALL ?way AROUND|over|about THING ; FEEL|TOUCH THING ALL|over|AROUND|up|from|closely ; \
         FEEL|FIND|EXAMINE ?out whether|if|what ?THING ?be|is SHAPED|like|box ; \
         get|have|take|give ?THING a|the ?GOOD ?proper feel|FEEL ?for|of|over ; \
         TOUCH THING ALL over|AROUND ; GO|RUN ?ALL over|AROUND|along ?ALL ?its EDGE|THING ; \
         get|come to KNOW|EXAMINE|learn THING|FORM ; wrap|put|close HAND AROUND THING ; \
         FIND|work|figure|make out what KIND|FORM ; \
         TOUCH THING in|at|from several|different|MORE|many|other|ALL|various ; ^ FEEL THING $ ; \
         take|get THING|its|the ?its SIZE ; GO ?ALL ?way AROUND|over|along THING ; \
         what .. FORM & FEEL|find|work|TOUCH ; FEEL every|ALL ; FEEL EDGE ; learn FORM ; explore THING ; \
         FEEL THING ; EXAMINE|SEARCH THING ?with HAND ; give THING .. FEEL ; FEEL what KIND ; \
         FIND out what THING ; EXAMINE EDGE|FORM|SIZE ; describe with HAND ; \
         TOUCH THING ?ALL .. so|to .. FORM|SIZE|SIZED ; \
         EXAMINE|SEARCH|FEEL|TOUCH|explore|RUN .. every|ALL|each ?face|side|part|bit|face|sides OF THING ; \
         RUN ?HAND over ?every|ALL side|face|part of THING ; MORE contact|points ON THING ; \
         TOUCH THING in|at|from|on .. places|sides|points|spots|times & \
         MORE|NUMBER|ALL|many|different|several ; get the|a lay|idea|sense|picture of ; \
         ^ ALL AROUND THING ; familiar ?with ; have a fiddle|play with THING",
)
.needs_body();

/// Touches of a thing whose shape is to be felt: from so many `bodyschema study shape` measures how well it is known.
const TOUCHES: usize = 15;
/// Touches at the least that tell a shape.
const FEW: usize = 4;
/// Gaps that one body leaves where skin touched it, root mean square, up to which touches are of one thing that stayed, metres.
const FITS: f64 = 0.003;

impl Conversation {
    fn feel_shape(&mut self, thing: &KnownThing, request: &Request) -> Acted {
        let touched_now = |creature: &Conversation| {
            let known = creature.things.get(thing.id)?;
            let touches = known.in_touch.is_some() && creature.actor.posture() == known.found.posture;
            touches.then(|| known.found.clone())
        };
        let found = match touched_now(self) {
            Some(found) => found,
            None => {
                let answer = self.touch(thing, self.hand_for(request.hand), request.lean)?;
                match touched_now(self).filter(|_| answer.done == Some(true)) {
                    Some(found) => found,
                    None => return Ok(Answer::failed(answer.said)),
                }
            }
        };
        self.things.parted();
        let felt = self.actor.feel_shape(&found, TOUCHES);
        let ready = self.ready.clone();
        let went = felt.as_ref().is_ok_and(|felt| self.actor.go_about(&felt.shape, &ready).is_ok());
        if !went {
            self.settle(&ready);
        }
        let felt = match felt {
            Ok(felt) => felt,
            Err(trouble) => {
                let trouble = self.in_words(&trouble.of_task()?);
                return Ok(Answer::failed(format!("I cannot feel its shape: {trouble}")));
            }
        };
        if felt.touches < FEW {
            return Ok(Answer::failed("I could touch it at few places only, so I do not know its shape"));
        }
        if felt.shape.unexplained > FITS {
            return Ok(Answer::failed(
                "What I felt does not fit together: it may have moved, so I do not know its shape",
            ));
        }
        let (front, left, up) = (self.actor.front, self.actor.left(), self.actor.up);
        let sides = [(-front, "in front"), (front, "behind"), (left, "on the left"), (-left, "on the right")];
        let sides = sides.into_iter().chain([(up, "on top")]);
        let unfelt = sides.filter(|(side, _)| !felt.shape.is_felt_along(side)).map(|(_, words)| words);
        let shape =
            KnownShape { size: felt.shape.size(&up), touches: felt.touches, unfelt: unfelt.collect() };
        if let Some(known) = self.things.get_mut(thing.id) {
            known.shape = Some(shape);
        }
        Ok(Answer::done(self.shape_in_words()))
    }
}
