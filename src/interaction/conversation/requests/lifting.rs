//! "Pick it up."

use super::super::{Conversation, Held};
use super::{Act, Acted, Answer, RequestKind, SLIPPED};
use crate::interaction::conversation::grammar::Request;
use crate::interaction::things::KnownThing;

/// How high one hand raises it, metres.
const HEIGHT: f64 = 0.1;
/// How often both hands may begin again.
const CORRECTIONS: usize = 3;

pub(super) const LIFT: RequestKind = RequestKind::new(
    ["pick it up", "picked it up"],
    Act::Handles(|creature, thing, request, _| creature.lift(thing, request)),
)
.said("^ UP ?UP ?you ?come|go $ ; ^ ?UP off TABLE ; ^ UP ?she|he ?GO")
.told(
    "^ up with THING ; pick .. up ; LIFT|GRAB THING|SOME ?UP ; LIFT|GRAB|get ?UP THING|SOME ; \
         LIFT THING|SOME|them|UP ?UP|off|high ; LIFT ?UP ?BIT $ ; \
         get|take|catch|have|keep|lay|GRAB ?GOOD ?firm|tight hold|grip|GRAB ?ON|of|OF THING|SOME ; \
         PUT|PUSH|take|get|bring|PULL|hold THING|SOME ?BIT up|UP|off|upward & !to ; \
         THING ?UP off|from the TABLE ; PUT|PUSH|take|get|GRAB THING ?UP off|from ?that TABLE ; \
         into|in|to|the|mid air ; UP THING GO ; ^ LIFT|GRAB $ ; ^ GRAB THING|SOME ; hold THING|SOME ?UP ; \
         take|get|hold THING|SOME in|into|between HAND ; with HAND LIFT|GRAB THING|SOME ; give THING lift ; \
         THING up ; pick THING ; get|have|take hold|grip ; GRAB & LIFT ; LIFT HAND ; carry|hold THING ; \
         get|have|take|keep THING in|between your|BODY ; take|get|bring|have .. THING up|UP|aloft ; \
         THING in the air ; THING off|from TABLE ; LIFT ?up AGAIN ; hold|GRAB ON THING ; hold on to THING ; \
         up|UP|off ?TABLE|ground with THING ; into ?your BODY with THING ; ^ BODY GRAB|LIFT THING",
)
.needs_body();

impl Conversation {
    fn lift(&mut self, thing: &KnownThing, request: &Request) -> Acted {
        let with = match &self.holding {
            Some(Held::Stuck { receptor, .. }) => Some(self.limb_in_words(*receptor)),
            Some(Held::Palms(_)) => Some("hands".to_string()),
            None => None,
        };
        match (with, request.hand) {
            (Some(with), _) => Ok(Answer::done(format!("I hold it already, with my {with}"))),
            (None, None) => self.lift_with_both(thing),
            (None, hand) => self.lift_with_one(thing, self.hand_for(hand), request.lean),
        }
    }

    /// Between both palms, by friction.
    fn lift_with_both(&mut self, thing: &KnownThing) -> Acted {
        if let Some(known) = self.things.get_mut(thing.id) {
            known.in_touch = None;
        }
        if thing.in_touch.is_none() {
            self.let_be();
            self.settle_at_ready();
        }
        match self.actor.lift(&thing.found, CORRECTIONS) {
            Ok(grip) => {
                self.holding = Some(Held::Palms(Box::new(grip)));
                Ok(Answer::done("I picked it up between my hands, and hold it by squeezing"))
            }
            Err(trouble) => {
                let trouble = trouble.of_task()?;
                self.settle_at_ready();
                let said = "I tried to take it between my hands, and do not hold it";
                Ok(Answer::failed(format!("{said}: {trouble}; it may stand elsewhere now")))
            }
        }
    }

    /// With the hand that was named, by a weld.
    fn lift_with_one(&mut self, thing: &KnownThing, hand: Option<usize>, lean: bool) -> Acted {
        let receptor = match self.in_hand(thing, hand, lean)? {
            Ok(receptor) => receptor,
            Err(answer) => return Ok(answer),
        };
        if !self.actor.hold(receptor) {
            return Ok(Answer::failed(SLIPPED));
        }
        let name = self.limb_in_words(receptor);
        match self.actor.raise(receptor, HEIGHT) {
            Ok(raised) => {
                self.holding = Some(Held::Stuck { receptor, raised });
                let higher = 100.0 * raised;
                let said = format!("I picked it up with my {name}, to which it sticks");
                Ok(Answer::done(format!("{said}, and hold it {higher:.0} cm higher than it stood")))
            }
            Err(trouble) => {
                let trouble = self.in_words(&trouble.of_task()?);
                self.actor.let_go();
                Ok(Answer::failed(format!("I touch it with my {name}, but cannot raise it: {trouble}")))
            }
        }
    }
}
