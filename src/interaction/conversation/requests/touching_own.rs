//! "Touch your nose."

use super::super::{Conversation, OwnSpot};
use super::{Act, Intent, Reply, RequestKind};
use crate::interaction::body_part;
use crate::interaction::conversation::language::Request;
use crate::interaction::tasks::Trouble;
use crate::named::in_words;
use crate::simulation::EngineError;

/// Places of a part that are tried, the one that it is first.
const TRIES: usize = 6;
/// Skin this near to a part is that part, metres: a patch's width.
const NEAR: f64 = 0.01;

pub(super) const TOUCH_OWN: RequestKind = RequestKind {
    told: &[
        "run|pass|draw|glide HAND|hand|finger ?all through|over|across|along|down PART",
        "touch|tap|poke|contact|pat|stroke|prod|rub|scratch|grab|grasp|clasp|grip|feel|reach|squeeze|tickle|brush|press|pinch|cover|pull|tug|find|slap|nudge|massage|cup|approach|clutch|hit|meet|hug ?gently|with|for|to|at|on|onto|against|up|down|behind|out|over ?HAND ?to|for|on|towards|at|onto ?your PART",
        "touch|tap|poke|contact|pat|stroke|prod|rub|scratch|squeeze|press|clasp|grip|massage|feel|hold ?you BODY",
        "grab|grasp|reach|hold|take BODY with HAND",
        "put|lay|place|rest|set|get|position|move|bring|keep|press|point|have|lift|raise|stretch|extend|hold|guide|let|take ?a|one|the ?both HAND|finger|hand|palm ?up|down|over|back|rest|go|out ?right on|onto|upon|to|against|at|towards|over|around|in|touch|by|behind|near ?contact|top|touch ?with|of BODY",
        "put|lay|place|rest ?a ?finger|hand on|to|onto BODY",
        "get|take|catch|have|lay|keep|grab hold of BODY",
        "^ HAND ?and PART $",
        "^ PART with ?your HAND $",
        "HAND ?should|must|be|go ?be|go on|onto|to|against BODY $",
        "PART .. HAND on|to|onto|at PART",
        "PART .. touch|tap|poke|pat|grab|reach|feel THING",
        "use HAND .. PART",
        "with HAND .. PART",
        "make|get|establish contact|touch with|between|to BODY",
        "touch yourself",
        "BODY and BODY together",
        "point at|to PART",
        "reach ?up|down|out|over|back|behind ?to|for|and|at|towards ?touch ?behind BODY",
    ],
    needs_body: true,
    ..RequestKind::new(
        ["touch myself there", "touched myself"],
        Act::Moves(|creature, request, _| creature.touch_part(request)),
    )
};

impl Conversation {
    fn touch_part(&mut self, request: &Request) -> Result<Reply, EngineError> {
        let Some(part) = &request.part else {
            return Ok(self.reply(Intent::TouchOwn, "Which part of me do you mean?".into(), None, true));
        };
        let found = match body_part::find(&self.actor, part, self.hand_touching()) {
            Ok(found) => found,
            Err(unknown) => return self.fails(Intent::TouchOwn, unknown.to_string()),
        };
        let by = self.hand_for(request.hand);
        if request.stick && self.actor.stick_tip().is_none() {
            return self.fails(Intent::TouchOwn, "I hold no stick");
        }
        self.let_be();
        let mut trouble = None;
        for part in &found {
            // As the arms are, and then with the arm that it is on held out to the other.
            for held_out in [false, true] {
                if held_out && !self.holds_out(part.receptors[0])? {
                    break;
                }
                for &receptor in part.receptors.iter().take(TRIES) {
                    let touched = match request.stick {
                        true => self.actor.touch_own_with_stick(receptor),
                        false => self.actor.touch_own_with(receptor, by),
                    };
                    match touched {
                        Ok(touch) => {
                            self.spot = Some(OwnSpot { receptor, by_stick: request.stick });
                            let name = match request.stick {
                                true => "stick".to_string(),
                                false => in_words(&self.actor.hands[touch.hand].name),
                            };
                            let said = match part.off(&self.actor, touch.felt) {
                                off if off < NEAR => format!("I touch my {} with my {name}", part.name),
                                off => format!(
                                    "I touch myself {:.0} cm from my {} with my {name}",
                                    100.0 * off,
                                    part.name
                                ),
                            };
                            return self.does(Intent::TouchOwn, said);
                        }
                        Err(Trouble::Engine(error)) => return Err(error),
                        Err(this) => {
                            let met = matches!(this, Trouble::Hit(_) | Trouble::Nothing);
                            trouble.get_or_insert((part.name.clone(), this));
                            if met {
                                self.settle_at_ready();
                            }
                        }
                    }
                }
            }
        }
        self.settle_at_ready();
        let said = match trouble {
            Some((name, trouble)) => format!("I cannot touch my {name}: {}", self.in_words(&trouble)),
            None => format!("I have no skin at my {} that could be touched", part.text()),
        };
        self.fails(Intent::TouchOwn, said)
    }

    /// Holds an arm out so that a spot of it can be touched; whether it does.
    fn holds_out(&mut self, receptor: usize) -> Result<bool, EngineError> {
        match self.actor.present(receptor) {
            Err(Trouble::Engine(error)) => Err(error),
            held_out => Ok(held_out.unwrap_or(false)),
        }
    }
}
