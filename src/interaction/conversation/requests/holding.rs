//! "Pick it up", "let go".

use super::super::speaking::cm;
use super::super::{Conversation, Held};
use super::{Act, Acted, Answer, RequestKind};
use crate::interaction::conversation::grammar::Request;
use crate::interaction::things::KnownThing;

/// How high one hand raises it, metres.
const HEIGHT: f64 = 0.1;
/// How often both hands may begin again.
const CORRECTIONS: usize = 3;

pub(super) const LIFT: RequestKind = RequestKind::of_body(
    ["pick it up", "picked it up"],
    Act::Handles(Conversation::lift),
    "told: LIFT|GRAB|get ?UP THING|SOME; LIFT ?UP ?BIT $; get|have|keep|lay|GRAB ?GOOD ?firm|tight GRAB ?ON|of|OF \
     THING|SOME; PUT|PUSH|take|get|PULL|hold THING|SOME ?BIT UP|off & !to; THING ?UP off|from the TABLE; \
     PUT|PUSH|get|GRAB THING ?UP off|from ?that TABLE; into|in|to|the|mid air; give THING lift; get|have|take \
     hold|grip; LIFT HAND; carry|hold THING; THING in the air; THING off|from TABLE; hold on to THING; UP|off \
     ?TABLE|ground with THING",
);

pub(super) const LET_GO: RequestKind = RequestKind::new(
    ["let go", "let go"],
    Act::Moves(|creature, _, _| creature.release()),
    "told: LET ?THING|SOME go|fall|off|slip|DROP; DROP THING|SOME; ^ DROP $; leave go; leave THING there; leave \
     THING ON TABLE; PUT|lower DOWN|BACK THING|SOME; PUT|lower|sit THING|SOME ?BACK ?down ON ?top ?of \
     THING|SOME|TABLE; open|loosen|relax|unclench|ease|lose|release|give|let ?up ?go ?of ?your GRAB|fist|fingers \
     ?grip|hold; PUT DOWN $; let THING be|stay|stand; ^ DOWN with THING; return THING to THING|the ?TABLE|place; \
     PUT|give|return THING BACK ?where|there|ON|again; HAND HELPING GO off; ON|back TABLE with THING; open ?up \
     ?your HAND; THING BACK ON TABLE; take|get|PULL|remove|move|withdraw ?away|off|back HAND ?away|off|back \
     from|off ?of THING; lower THING|SOME; PUT .. THING|SOME .. down; have|want|need|like THING BACK|DOWN; denied: \
     STOP =holding|=gripping|=grasping|=grabbing|=carrying; not|longer hold|keep THING ?any; not .. GRAB .. \
     longer|more|anymore",
);

impl Conversation {
    fn lift(&mut self, thing: &KnownThing, request: &Request) -> Acted {
        match (&self.holding, request.hand) {
            (Some(held), _) => {
                let with = match held {
                    Held::Stuck { receptor, .. } => self.limb_in_words(*receptor),
                    Held::Palms(_) => "hands".to_string(),
                };
                Ok(Answer::done(format!("I am already holding it, with my {with}")))
            }
            (None, None) => self.lift_with_both(thing),
            (None, hand) => self.lift_with_one(thing, self.hand_for(hand), request.lean),
        }
    }

    /// Between both palms, by friction.
    fn lift_with_both(&mut self, thing: &KnownThing) -> Acted {
        if let Some(known) = self.mind.things.get_mut(thing.id) {
            known.in_touch = None;
        }
        if thing.in_touch.is_none() {
            self.let_be();
            self.settle();
        }
        match self.actor.lift(&thing.found, CORRECTIONS) {
            Ok(grip) => {
                self.holding = Some(Held::Palms(Box::new(grip)));
                Ok(Answer::done("I picked it up between my hands and am squeezing it"))
            }
            Err(trouble) => {
                self.settle();
                let said = "I tried to take it between my hands but am not holding it, and it may have moved";
                Err(self.hindered(said, trouble))
            }
        }
    }

    /// With the hand that was named, by a weld.
    fn lift_with_one(&mut self, thing: &KnownThing, hand: Option<usize>, lean: bool) -> Acted {
        let receptor = self.in_hand(thing, hand, lean)?;
        let name = self.limb_in_words(receptor);
        match self.actor.raise(receptor, HEIGHT) {
            Ok(raised) => {
                self.holding = Some(Held::Stuck { receptor, raised });
                let said = format!("I picked it up with my {name}, which it sticks to");
                Ok(Answer::done(format!("{said}, and am holding it {} higher than it stood", cm(raised))))
            }
            Err(trouble) => {
                self.actor.let_go();
                Err(self.hindered(&format!("I am touching it with my {name}, but cannot raise it"), trouble))
            }
        }
    }

    /// Lets go of what it holds, and takes its hand back from it.
    fn release(&mut self) -> Acted {
        let touching = self.mind.things.iter().any(|known| known.in_touch.is_some());
        let said = match (self.holding.take(), self.actor.stick().is_some()) {
            (Some(held), _) => {
                let (name, lowered) = self.put_down(held)?;
                self.actor.let_go();
                self.actor.wait(0.2)?;
                let put = if lowered { "put it down and " } else { "" };
                format!("I {put}let go of it with my {name}")
            }
            // The stick is all that it holds: it is meant.
            (None, true) if !touching => return self.give_stick_back(),
            (None, stick) => {
                self.actor.let_go();
                let but = if stick { " but the stick" } else { "" };
                let back = if touching { ", and withdrew my hand from what I touched" } else { "" };
                format!("I am not holding anything{but}{back}")
            }
        };
        self.let_be();
        Ok(Answer::done(said))
    }
}
