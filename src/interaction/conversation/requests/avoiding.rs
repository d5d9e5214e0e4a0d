//! "Avoid it", "watch out": it watches what comes near, and gets out of its way.

use super::super::Conversation;
use super::{Act, Acted, Answer, RequestKind};
use crate::interaction::avoiding::Avoiding;

/// How long it watches, seconds of its own time, …
const WATCHING: f64 = 5.0;
/// … how far joints have gone where it got out of a way, radians.
const MOVED: f64 = 0.02;

pub(super) const AVOID: RequestKind = RequestKind::new(
    ["get out of the way", "watched what came near"],
    Act::Moves(|creature, _, _| creature.watch_out()),
)
.told(
    "AVOID THING|SOME ; AVOID ; out of ?its|his|my|harm|THING way ; \
         GO|keep|stay|steer|PULL|hold|stand ?yourself|BODY ?well clear ; \
         GO|jump|stand|shift ?yourself|BODY ?out|over aside|SIDEWAYS ; watch|look|mind out ; \
         make way|room ; \
         GO|keep|stay|back|jump|draw|PULL ?yourself|BODY|PART ?BACK|well away|off|FAR ?from \
         ?THING|SOME|what & !HAND ; keep|KEEP|maintain ?your|some ?safe distance ; PROTECT yourself|BODY ; \
         get out ?of there|here $ ; ^ move $ ; ^ GO|jump BACK $ ; \
         THING|SOME ?be =coming|=approaching|=flying ; let THING|SOME pass ; take cover|evasive ; \
         shy|shrink|flinch|draw|back away ; incoming ; evasive ; give THING ?wide room|way|space|berth ; \
         on your|guard guard ; beware ; mind your|the BODY|yourself ; heads|HEAD up ; \
         move so .. miss|past ; GO out of ?its|THING ; AVOID be|get ; get|be missed ; \
         ^ ?be careful|alert|watchful $ ; GO|keep|stay|step|get ?yourself ?well ?right out|clear of ; \
         GO|keep|stay ?well out of ?its path ; mind|watch|beware THING|SOME =coming|=approaching ; \
         mind|watch ?out ?for THING|SOME ; duck ; THING|SOME =comes|=approaches|=flies ; about to hit ; \
         do not .. =hit|=touched|=struck ; GO|stay|keep ?yourself out of ?its range|reach|way|path ; \
         =look|watch|mind out for THING ; mind|watch your|the BODY ; clear off ; ^ out of there|it ; \
         here come THING|SOME ; ^ run|move|get|back away $ ; ^ danger",
)
.denied(
    "not|nothing|never LET|let THING|SOME ?at|ever hit|TOUCH|reach|bump|get|TEND|catch ; let nothing ; \
         not get|be hit|=touched|=struck|caught|bumped & !THING ; not to get|be hit|=touched & !THING ; \
         GO .. THING|SOME HELPING|do not hit|TOUCH|get|reach|catch|meet ; \
         nothing|nobody TOUCH|hit|reach|get you|PART|BODY ; not THING hit|touch you|BODY ; \
         not bump|run|collide into|with|ON ; avoid|dodge ?=being|=getting =hit|hit|it|THING ; \
         without =being hit ; let THING go|pass .. TOUCH ; mind|watch THING|SOME =coming|=approaching ; \
         take care not ; HAND|BODY away from what|whatever ; \
         THING|SOME .. not hit|TOUCH|reach|bump|get|catch you|BODY",
)
.said(
    "THING|SOME ?be =coming|=approaching|=flying|=heading ?UPRIGHT|right at|ON|for|your ?you|PART|way ; \
         THING|SOME ?be =coming|=approaching|=flying|=moving ; beware ; ^ mind $ ; here come THING|SOME",
)
.needs_body();

impl Conversation {
    /// Watches for a while, out of the way of what comes.
    fn watch_out(&mut self) -> Acted {
        // What it touches it cannot keep away from: the arm first.
        let touched = self.things.iter().any(|known| known.in_touch.is_some());
        self.let_be();
        let before = self.actor.posture();
        let mut avoiding = Avoiding::new(&mut self.actor);
        let (mut seconds, mut met) = (0.0, false);
        let step = self.actor.handle.timestep();
        while seconds < WATCHING {
            met |= !avoiding.step(&mut self.actor)?.is_empty();
            seconds += step;
        }
        let moved = self.actor.posture().distance(&before) > MOVED;
        let from = if touched { "I took my arm away from it, and watched" } else { "I watched" };
        let said = match (moved, met) {
            (true, false) => "I got out of the way of what came, and it did not touch me".to_string(),
            (true, true) => "I moved out of the way of what came, but it touched me".to_string(),
            (false, false) => format!("{from} for {WATCHING:.0} seconds: nothing came at me"),
            (false, true) => {
                format!("{from} for {WATCHING:.0} seconds; I feel a touch, but nothing came at me")
            }
        };
        Ok(Answer::does(said, !(moved && met)))
    }
}
