//! "Let go."

use super::super::Conversation;
use super::{Act, Acted, Answer, RequestKind};

pub(super) const LET_GO: RequestKind =
    RequestKind::new(["let go", "let go"], Act::Moves(|creature, _, _| creature.release()))
        .said("^ ?BACK DOWN ?THING ?GO $ ; ^ BACK ON TABLE ; ^ BACK where")
        .told(
            "LET ?THING|SOME go|loose|fall|drop|off|slip|DROP ; LET go ?of ?THING ; DROP THING|SOME ; \
         ^ DROP $ ; leave go ; leave THING there ; leave THING ON TABLE ; \
         PUT|LOWER|lower|lay|sit THING|SOME ?BACK ?right down|gently ; PUT|lower|lay DOWN|BACK THING|SOME ; \
         PUT|lower|lay|sit THING|SOME ?BACK ?down ON ?top ?of THING|SOME|TABLE ; open|unclench HAND ; \
         open|loosen|relax|unclench|ease|lose|release|give|let ?up ?go ?of ?your \
         grip|GRAB|grasp|hold|fist|fingers ?own ?grip|hold ; \
         take|get|PULL HAND off|away|from ?of ?from THING ; PUT DOWN $ ; let THING be|stay|stand ; \
         ^ DOWN with THING ; ^ loose|DROP THING ; return THING to THING|the ?TABLE|place ; \
         PUT|give|return THING BACK ?where|in|there|ON|again ; HAND HELPING GO off ; \
         ON|back TABLE with THING ; BACK with THING ; HAND off THING ; open ?up ?your HAND ; \
         release ?your hold|grip|THING ; put THING BACK ; THING down ; THING BACK ON TABLE ; \
         hands|fingers off ; \
         take|get|PULL|remove|move|withdraw ?away|off|back HAND ?away|off|back from|off ?of THING ; \
         remove HAND ; undo|loosen|lose|open ?up ?your grip|hold|grasp|fist|fingers ; lower THING|SOME ; \
         PUT .. THING|SOME .. down ; leg go ; LET go|loose ; THING down AGAIN ; \
         have|want|need|like THING BACK|DOWN ; PUT THING|SOME DOWN|BACK ?again ; THING free ; \
         DROP|PUT|lower|lay|set ?DOWN what|whatever ; rid of ?your grip|hold ; release|open ?your HAND ; \
         finish|end =holding|=carrying|=gripping ; part with THING",
        )
        .denied(
            "STOP|cease =holding|=gripping|=grasping|=grabbing|=carrying ; \
         no need|longer|more .. hold|=holding ; need|have not|longer|to ?to hold|keep ; \
         not|longer hold|keep THING ?any ; not .. hold|GRAB .. longer|more|anymore ; \
         not hold|GRAB ON ?to THING ; not|stop|finish|no =holding",
        );

impl Conversation {
    /// Lets go of what it holds, and takes its hand back from it.
    fn release(&mut self) -> Acted {
        let touching = self.things.iter().any(|known| known.in_touch.is_some());
        let said = match (std::mem::take(&mut self.holding), self.actor.stick().is_some()) {
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
                let back = if touching { ", and took my hand back from what I touched" } else { "" };
                format!("I hold nothing{but}{back}")
            }
        };
        self.let_be();
        Ok(Answer::done(said))
    }
}
