//! "Feel its shape": it touches a thing all about with the fingertips of both hands, and tells how large it is.

use super::super::Conversation;
use super::{Act, Intent, Reply, RequestKind};
use crate::interaction::conversation::language::{Leave, Request};
use crate::interaction::tasks::Trouble;
use crate::interaction::things::{KnownShape, KnownThing};
use crate::simulation::EngineError;

pub(super) const FEEL_SHAPE: RequestKind = RequestKind {
    told: &[
        "have|take|get a ?good|proper feel of|for THING",
        "feel|explore|examine|inspect|investigate|palpate|study|trace|follow|check|find|discover|learn|work|figure|determine|measure|test|make|map|get|see|probe|scan|sense|recognise|recognize|identify .. shape|form|outline|contour|contours|size|edges|edge|corners|outside|dimensions|rim|curves|geometry|sides|surface|extent|proportions",
        "feel|find|discover ?out what THING|SOME THING be",
        "feel|find|work|figure|see|check|learn|explore|discover|determine|test|measure .. how big|large|wide|tall|long|thick|high|round|small|broad|deep",
        "run|pass|slide|move|glide|stroke|let|guide|trace|draw|brush|wander|go|walk ?with HAND|PART ?all ?the|slowly ?way over|along|around|round|across|about THING|the|its ?whole|entire ?edge|edges|surface|outline|outside|sides|$",
        "explore|examine|inspect|palpate|measure|study|investigate|trace THING",
        "feel ?all ?the ?way round|around|over|about|along THING",
        "feel THING all|carefully|thoroughly|closely|over|around|round|about|up|from",
        "feel|tell|find|check|test ?out whether|if|what ?THING .. round|square|flat|pointed|like|rounded|angular|box",
        "get a|the feel of|for",
        "touch THING all over|around|round",
        "go|run|pass|move over|around|round|along ?all its|the edge|edges|outline|sides|side|rim|surface|contour|contours",
        "get|come to know|learn THING",
        "wrap|put|close HAND around|round THING",
        "find|work|figure|make out what kind|sort|shape|form",
        "touch THING in|at|from several|different|more|many|other|all|various",
        "^ feel THING $",
        "take|get THING|its|the ?its measurements",
        "go ?all ?the ?way over|around|round|along THING",
        "fingers over THING",
    ],
    needs_body: true,
    ..RequestKind::new(
        ["feel its shape", "felt its shape"],
        Act::Handles(|creature, thing, request, leave| creature.feel_shape(thing, request, leave)),
    )
};

/// Touches of a thing whose shape is to be felt: from so many `bodyschema study shape` measures how well it is known.
const TOUCHES: usize = 15;
/// Touches at the least that tell a shape.
const FEW: usize = 4;
/// Gaps that one body leaves where skin touched it, root mean square, up to which touches are of one thing that stayed, metres.
const FITS: f64 = 0.003;

impl Conversation {
    fn feel_shape(
        &mut self,
        thing: &KnownThing,
        request: &Request,
        leave: &Leave,
    ) -> Result<Reply, EngineError> {
        let touched_now = |creature: &Conversation| {
            let known = creature.things.get(thing.id)?;
            let touches = known.in_touch.is_some() && creature.actor.posture() == known.found.posture;
            touches.then(|| known.found.clone())
        };
        let found = match touched_now(self) {
            Some(found) => found,
            None => {
                let hand = self.hand_for(request.hand);
                let reply = self.touch(thing, hand, request.lean, leave)?;
                match touched_now(self).filter(|_| reply.done == Some(true)) {
                    Some(found) => found,
                    None => return Ok(Reply { intent: Intent::FeelShape, done: Some(false), ..reply }),
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
            Err(Trouble::Engine(error)) => return Err(error),
            Err(trouble) => {
                let said = format!("I cannot feel its shape: {}", self.in_words(&trouble));
                return self.fails(Intent::FeelShape, said);
            }
        };
        if felt.touches < FEW {
            return self
                .fails(Intent::FeelShape, "I could touch it at few places only, so I do not know its shape");
        }
        if felt.shape.unexplained > FITS {
            return self.fails(
                Intent::FeelShape,
                "What I felt does not fit together: it may have moved, so I do not know its shape",
            );
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
        let known = self.shape_in_words();
        self.does(Intent::FeelShape, known)
    }
}
