//! "Pick it up."

use super::super::{Conversation, Held};
use super::{Act, Intent, Reply, RequestKind};
use crate::interaction::conversation::language::{Leave, Request};
use crate::interaction::tasks::{LiftTrouble, Trouble};
use crate::interaction::things::KnownThing;
use crate::simulation::EngineError;

/// How high one hand raises it, metres.
const HEIGHT: f64 = 0.1;
/// How often both hands may begin again.
const CORRECTIONS: usize = 3;

pub(super) const LIFT: RequestKind = RequestKind {
    told: &[
        "^ up with THING",
        "pick .. up",
        "pick|take|lift|get up THING|SOME",
        "lift|raise|hoist|heave|elevate THING|SOME|them|up",
        "lift|raise|hoist|heave|elevate ?up ?a ?bit $",
        "get|take|catch|lay|have|keep ?a ?good ?firm|tight hold|grip ?of ?on|of ?THING|SOME",
        "take|get THING up|off",
        "off the table",
        "into|in|to the|mid air",
        "up THING go|come",
        "^ grab|grasp|seize|lift $",
        "^ ?you take THING|SOME",
    ],
    needs_body: true,
    ..RequestKind::new(
        ["pick it up", "picked it up"],
        Act::Handles(|creature, thing, request, leave| creature.lift(thing, request, leave)),
    )
};

impl Conversation {
    fn lift(&mut self, thing: &KnownThing, request: &Request, leave: &Leave) -> Result<Reply, EngineError> {
        let with = match &self.holding {
            Some(Held::Stuck { receptor, .. }) => Some(self.limb_in_words(*receptor)),
            Some(Held::Palms(_)) => Some("hands".to_string()),
            None => None,
        };
        if let Some(with) = with {
            return self.does(Intent::Lift, format!("I hold it already, with my {with}"));
        }
        match request.hand {
            None => self.lift_with_both(thing),
            hand => self.lift_with_one(thing, self.hand_for(hand), request.lean, leave),
        }
    }

    /// Between both palms, by friction.
    fn lift_with_both(&mut self, thing: &KnownThing) -> Result<Reply, EngineError> {
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
                self.does(Intent::Lift, "I picked it up between my hands, and hold it by squeezing")
            }
            Err(LiftTrouble::Other(Trouble::Engine(error))) => Err(error),
            Err(trouble) => {
                self.settle_at_ready();
                let said = format!(
                    "I tried to take it between my hands, and do not hold it: {trouble}; \
                     it may stand elsewhere now"
                );
                self.fails(Intent::Lift, said)
            }
        }
    }

    /// With the hand that was named, by a weld.
    fn lift_with_one(
        &mut self,
        thing: &KnownThing,
        hand: Option<usize>,
        lean: bool,
        leave: &Leave,
    ) -> Result<Reply, EngineError> {
        let receptor = match self.in_hand(thing, hand, lean, leave)? {
            Ok(receptor) => receptor,
            Err(touched) => return Ok(Reply { intent: Intent::Lift, ..touched }),
        };
        if !self.actor.hold(receptor) {
            return self.fails(Intent::Lift, "It slipped away: I no longer feel it");
        }
        let name = self.limb_in_words(receptor);
        match self.actor.raise(receptor, HEIGHT) {
            Ok(raised) => {
                self.holding = Some(Held::Stuck { receptor, raised });
                let said = format!(
                    "I picked it up with my {name}, to which it sticks, and hold it {:.0} cm higher than it stood",
                    100.0 * raised
                );
                self.does(Intent::Lift, said)
            }
            Err(Trouble::Engine(error)) => Err(error),
            Err(trouble) => {
                self.actor.let_go();
                let said =
                    format!("I touch it with my {name}, but cannot raise it: {}", self.in_words(&trouble));
                self.fails(Intent::Lift, said)
            }
        }
    }
}
