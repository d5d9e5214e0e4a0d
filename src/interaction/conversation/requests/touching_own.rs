//! "Touch your nose."

use super::super::{Conversation, OwnSpot};
use super::{Act, Acted, Answer, RequestKind};
use crate::interaction::body_part::{self, BodyPart};
use crate::interaction::conversation::grammar::Request;
use crate::interaction::own_spot::OwnTouch;
use crate::interaction::tasks::{Trouble, tried};

/// Places of a part that are tried, the one that it is first.
const TRIES: usize = 6;
/// Skin this near to a part is that part, metres: a patch's width.
const NEAR: f64 = 0.01;

pub(super) const TOUCH_OWN: RequestKind = RequestKind::new(
    ["touch myself there", "touched myself"],
    Act::Moves(|creature, request, _| creature.touch_part(request)),
)
.told(
    "TOUCH|GRAB|TEND|REACH ?for|with|to|at|on|onto|against|up|down|behind|out|over|hold|out ?HAND \
         ?to|for|on|onto|towards|at|and ?your|hold ?of PART ; FIND PART with|HAND ; TOUCH|TEND|FEEL BODY ; \
         REACH PART ; TOUCH|TEND|GRAB BODY with HAND ; \
         PUT|get|keep|have|bring|press|point|raise|lift|STRETCH|REACH|hold|let|LET|take|PULL|PUSH|guide \
         ?one ?both HAND|finger|hand|palm ?UP|down|over|back|rest|go|out|TOUCH ?straight \
         ON|OF|upon|over|around|touch|by|behind|near ?contact|top|touch ?with|of BODY ; \
         PUT ?finger|hand|HAND ON BODY ; get|take|catch|have|lay|keep|GRAB hold of BODY ; \
         ^ HAND ?and PART $ ; ^ PART with|by ?your HAND $ ; ^ PART HAND $ ; \
         HAND ?should|must|be|GO ?be|go ON|over BODY ; BODY .. HAND ON THING|PART ; BODY .. HAND ON ; \
         PART .. TOUCH|TEND|GRAB|REACH|FEEL|PUT|give THING|PART ; ^ PART TOUCH|TEND ; USE HAND .. PART ; \
         with|by HAND .. BODY ; make|get|establish contact|touch|CONTACT with|between|ON BODY ; \
         TOUCH|TEND yourself ; TOUCH|TEND yourself ON PART ; BODY and BODY together ; point at|ON BODY ; \
         REACH ?UP|DOWN|out|over|BACK|behind|AROUND ?to|for|and|at|ON ?TOUCH|TEND ?behind BODY ; \
         give BODY ?GOOD ?BIT TOUCH|TEND|rub ; give BODY a ; find BODY with HAND ; GRAB|hold onto|ON BODY ; \
         PUT|PULL|get|move BODY .. ON|near BODY ; ^ HAND ON PART ; HAND ON BODY ; go|head for|to BODY ; \
         PUT BODY on|ON BODY ; GRAB BODY ; PART & HAND & TOUCH|GRAB|PUT|REACH|USE|TEND|get ; ^ PART $ ; \
         HAND to ?your BODY ; RUN|wipe|walk ?your HAND|finger .. PART ; TOUCH|TEND|GRAB|cup|hold .. PART ; \
         HAND & PART & come|land|rest|GO|fall ; FIND PART with HAND ; HAND .. ON BODY",
)
.needs_body();

impl Conversation {
    fn touch_part(&mut self, request: &Request) -> Acted {
        let Some(part) = &request.part else {
            return Ok(Answer::asks("Which part of me do you mean?"));
        };
        let found = match body_part::find(&self.actor, part, self.hand_touching()) {
            Ok(found) => found,
            Err(unknown) => return Ok(Answer::failed(unknown.to_string())),
        };
        let by = self.hand_for(request.hand);
        if request.stick && self.actor.stick_tip().is_none() {
            return Ok(Answer::failed("I hold no stick"));
        }
        self.let_be();
        let mut trouble = None;
        for part in &found {
            // As the arms are, and then with the arm that it is on held out to the other.
            for held_out in [false, true] {
                if held_out && !tried(self.actor.present(part.receptors[0]))?.unwrap_or(false) {
                    break;
                }
                for &receptor in part.receptors.iter().take(TRIES) {
                    let touched = match request.stick {
                        true => self.actor.touch_own_with_stick(receptor),
                        false => self.actor.touch_own_with(receptor, by),
                    };
                    let this = match touched {
                        Ok(touch) => return Ok(self.touches_own(part, receptor, &touch, request.stick)),
                        Err(this) => this.of_task()?,
                    };
                    let met = matches!(this, Trouble::Hit(_) | Trouble::Nothing);
                    trouble.get_or_insert((part.name.clone(), this));
                    if met {
                        self.settle_at_ready();
                    }
                }
            }
        }
        self.settle_at_ready();
        Ok(Answer::failed(match trouble {
            Some((name, trouble)) => format!("I cannot touch my {name}: {}", self.in_words(&trouble)),
            None => format!("I have no skin at my {} that could be touched", part.text()),
        }))
    }

    /// It touches a part of itself.
    fn touches_own(&mut self, part: &BodyPart, receptor: usize, touch: &OwnTouch, by_stick: bool) -> Answer {
        self.spot = Some(OwnSpot { receptor, by_stick });
        let name = if by_stick { "stick".to_string() } else { self.hand_name(touch.hand) };
        Answer::done(match part.off(&self.actor, touch.felt) {
            off if off < NEAR => format!("I touch my {} with my {name}", part.name),
            off => format!("I touch myself {:.0} cm from my {} with my {name}", 100.0 * off, part.name),
        })
    }
}
