//! "Pick it up."

use super::super::{Conversation, Held, Request};
use super::{Act, Intent, Reply, RequestKind};
use crate::interaction::conversation::language::Leave;
use crate::interaction::tasks::Trouble;
use crate::simulation::EngineError;

/// How high it is raised, metres.
const HEIGHT: f64 = 0.1;

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
        "into the|mid air",
        "^ grab|grasp|seize|lift $",
        "^ take THING|SOME",
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
        if let Some(held) = &self.holding {
            let said = format!("I hold it already, with my {}", self.limb_in_words(held.receptor));
            return Ok(self.reply(Intent::Lift, said, Some(true), false));
        }
        let hand = self.hand_for(request.hand);
        let receptor = match self.in_hand(hand, request.lean, leave)? {
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
                self.holding = Some(Held { receptor, raised });
                let said = format!(
                    "I picked it up with my {name}, and hold it {:.0} cm higher than it stood",
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
