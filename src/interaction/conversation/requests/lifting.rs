//! "Pick it up."

use super::super::{Conversation, Held, Request};
use super::{Act, Intent, Reply, RequestKind};
use crate::interaction::conversation::language::Leave;
use crate::interaction::tasks::{LiftTrouble, Trouble};
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
        "grasp|grab|grip|seize|clasp|clutch|catch|snatch THING|SOME|hold",
        "get|take|catch|lay|have|keep ?a ?good ?firm|tight hold|grip ?of ?on|of ?THING|SOME",
        "take|get THING|SOME ?up ?off in|into|with|between|from ?your|both HAND|hands",
        "take|get THING up|off",
        "hold THING ?up ?high ?in|with|between ?the|HAND|mid ?air",
        "hold ?on|onto ?to THING",
        "scoop|pick|snatch THING ?up",
        "^ take|hold THING|SOME $",
        "off the table",
        "into|in|to the|mid air",
        "up THING go|come",
        "^ grab|grasp|seize|lift $",
        "^ ?you take THING|SOME",
    ],
    needs_body: true,
    needs_thing: true,
    ..RequestKind::new(
        ["pick it up", "picked it up"],
        Act::Moves(|creature, request, leave| creature.lift(request, leave)),
    )
};

impl Conversation {
    fn lift(&mut self, request: &Request, leave: &Leave) -> Result<Reply, EngineError> {
        let with = match &self.holding {
            Some(Held::Stuck { receptor, .. }) => Some(self.limb_in_words(*receptor)),
            Some(Held::Palms(_)) => Some("hands".to_string()),
            None => None,
        };
        if let Some(with) = with {
            return Ok(self.reply(
                Intent::Lift,
                format!("I hold it already, with my {with}"),
                Some(true),
                false,
            ));
        }
        match request.hand {
            None => self.lift_with_both(),
            hand => self.lift_with_one(self.hand_for(hand), request.lean, leave),
        }
    }

    /// Between both palms, by friction.
    fn lift_with_both(&mut self) -> Result<Reply, EngineError> {
        let i = self.things.it().expect("it is known which");
        let touching = self.things[i].in_touch.take();
        if touching.is_none() {
            self.let_be();
            self.settle_at_ready();
        }
        let found = self.things[i].found.clone();
        match self.actor.lift(&found, CORRECTIONS) {
            Ok(grip) => {
                self.holding = Some(Held::Palms(Box::new(grip)));
                let said = "I picked it up between my hands, and hold it by squeezing";
                Ok(self.reply(Intent::Lift, said.into(), Some(true), false))
            }
            Err(LiftTrouble::Other(Trouble::Engine(error))) => Err(error),
            Err(trouble) => {
                self.settle_at_ready();
                let said = format!(
                    "I tried to take it between my hands, and do not hold it: {trouble}; \
                     it may stand elsewhere now"
                );
                Ok(self.reply(Intent::Lift, said, Some(false), false))
            }
        }
    }

    /// With the hand that was named, by a weld.
    fn lift_with_one(
        &mut self,
        hand: Option<usize>,
        lean: bool,
        leave: &Leave,
    ) -> Result<Reply, EngineError> {
        let receptor = match self.in_hand(hand, lean, leave)? {
            Ok(receptor) => receptor,
            Err(touched) => return Ok(Reply { intent: Intent::Lift, ..touched }),
        };
        if !self.actor.hold(receptor) {
            return Ok(self.reply(
                Intent::Lift,
                "It slipped away: I no longer feel it".into(),
                Some(false),
                false,
            ));
        }
        let name = self.limb_in_words(receptor);
        match self.actor.raise(receptor, HEIGHT) {
            Ok(raised) => {
                self.holding = Some(Held::Stuck { receptor, raised });
                let said = format!(
                    "I picked it up with my {name}, to which it sticks, and hold it {:.0} cm higher than it stood",
                    100.0 * raised
                );
                Ok(self.reply(Intent::Lift, said, Some(true), false))
            }
            Err(Trouble::Engine(error)) => Err(error),
            Err(trouble) => {
                self.actor.let_go();
                let said =
                    format!("I touch it with my {name}, but cannot raise it: {}", self.in_words(&trouble));
                Ok(self.reply(Intent::Lift, said, Some(false), false))
            }
        }
    }
}
