//! "Let go."

use super::super::Conversation;
use super::{Act, Intent, Reply, RequestKind};
use crate::simulation::EngineError;

pub(super) const LET_GO: RequestKind = RequestKind {
    told: &[
        "leave THING on",
        "let ?THING|SOME|it go|loose|fall|drop|off|slip",
        "release|drop|unhand|relinquish|free|unclasp|ungrip THING|SOME|the|your|it|them",
        "release|relinquish|free|unclasp|ungrip HAND",
        "^ ungrip|unclasp $",
        "put|set|lay|place|lower|sit|stand|rest THING|SOME ?back ?right down|gently",
        "put|set|lay|place|lower|stand down|back THING|SOME",
        "put|set|lay|place|lower|rest|stand|deposit THING|SOME ?back ?down on|onto|upon ?to ?top ?of THING|the|SOME ?table|tabletop|surface|desk",
        "open|loosen|relax|unclench|ease ?up HAND|your|THING ?own ?grip|grasp|hold|fist|fingers",
        "lose|give ?up your|the grip|hold|grasp",
        "take|get|pull HAND off|away|from ?of ?from THING",
        "put down $",
        "let THING be|stay|stand",
        "^ down with THING",
        "^ loosen|unhand|loose|free THING|$",
        "return THING to THING|the ?table|place",
        "put|set|place|give THING back where|in|there|to|on|again",
        "put|set|place|give THING back $",
    ],
    ..RequestKind::new(["let go", "let go"], Act::Moves(|creature, _, _| creature.release()))
};

impl Conversation {
    /// Lets go of what it holds, and takes its hand back from it.
    fn release(&mut self) -> Result<Reply, EngineError> {
        let held = std::mem::take(&mut self.holding);
        let said = match held {
            Some(held) => {
                let (name, lowered) = self.put_down(held)?;
                self.actor.let_go();
                self.actor.wait(0.2)?;
                if lowered {
                    format!("I put it down and let go of it with my {name}")
                } else {
                    format!("I let go of it with my {name}")
                }
            }
            // Where the stick is all that he holds, it is meant.
            None if self.actor.stick().is_some()
                && self.things.iter().all(|known| known.in_touch.is_none()) =>
            {
                let given = self.give_stick_back()?;
                return Ok(Reply { intent: Intent::LetGo, ..given });
            }
            None => {
                self.actor.let_go();
                let touching = self.things.iter().any(|known| known.in_touch.is_some());
                match (touching, self.actor.stick().is_some()) {
                    (true, true) => {
                        "I hold nothing but the stick, and took my hand back from what I touched".to_string()
                    }
                    (true, false) => "I hold nothing, and took my hand back from what I touched".to_string(),
                    (false, _) => "I hold nothing".to_string(),
                }
            }
        };
        self.let_be();
        self.does(Intent::LetGo, said)
    }
}
