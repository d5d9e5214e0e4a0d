//! "Touch it with your left hand."

use super::super::Conversation;
use super::{Act, Acted, Answer, RequestKind};
use crate::interaction::tasks::Trouble;
use crate::interaction::things::KnownThing;
use crate::peripersonal::{Level, OutOfReach};

pub(super) const TOUCH: RequestKind = RequestKind::new(
    ["touch it", "touched it"],
    Act::Handles(|creature, thing, request, _| {
        if request.stick {
            return creature.touch_with_stick(thing, request.lean);
        }
        let hand = creature.hand_for(request.hand);
        let answer = creature.touch(thing, hand, request.lean)?;
        // What is too far for the hand may not be for a stick that he holds.
        let out_of_reach = answer.done == Some(false) && creature.is_out_of_hands_reach(thing);
        let may = out_of_reach && hand.is_none() && creature.actor.stick_tip().is_some();
        if may { creature.touch_with_stick(thing, request.lean) } else { Ok(answer) }
    }),
)
.told(
    "^ USE STICK ?to|for|on ?TOUCH ; TOUCH ?on|at|against|up THING|SOME|HAND|them ; ^ TOUCH ; \
         ^ TOUCH $ ; GO ?over ON|and THING ; REACH THING ; REACH ?out ?and|for|to ?TOUCH THING ; \
         PUT|get|keep|have|press|hold|bring|REACH|lower|lay|PULL|PUSH|land ?your|one|both ?down|out \
         HAND|finger|hand ?UP|DOWN|out|over|BACK|flat ?right ON|OF|near|over|in ?CONTACT|touch|top|with \
         ?with|of THING|SOME ; make|have|get CONTACT|contact|touch ?with ; \
         make|get|have ?in CONTACT with THING|SOME ; BODY .. rest|be ON THING ; \
         give THING ?BIT ?GOOD|quick TOUCH|PUSH|tap|poke|pat ; USE HAND ?to|for|on ?TOUCH ; \
         HAND ?should|must|be|GO ?be|go|should ?be ON THING ; HAND ON THING|SOME ; HAND to THING ; \
         ^ HAND $ ; ^ ?but|and|do|try ?THING with|use HAND ?instead|now $ ; REACH ?out ?and|to|for TOUCH ; \
         switch|change|swap ?over ?to HAND ; ^ THING TOUCH THING ; ^ TOUCH with HAND ; \
         TOUCH with STICK|HAND ; TOUCH & THING ; TOUCH THING with HAND|STICK ; HAND TOUCH THING ; \
         with HAND TOUCH THING ; next up TOUCH ; THING with HAND ; touch with|between HAND ; \
         finger|fingertips on THING ; ^ THING & other|instead ; HAND TOUCH ; TOUCH THING ?again ; \
         see TOUCH of THING ; PUT|lay|get .. HAND|finger|fingertip .. ON THING ; \
         make|establish|get|see ?some ?physical contact|CONTACT ?between|with .. THING ; \
         contact|CONTACT .. THING ; turn ?at TOUCH THING ; HAND .. TOUCH THING ; \
         give THING .. TOUCH|dab|poke|tap|touch ; HAND ?GO ON THING ; finger ON THING ; TOUCH ?of THING ; \
         rest HAND ON THING ; TOUCH ON THING ; HAND .. ON|meet THING ; TOUCH THING ?with other|left|right ; \
         HAND ON THING ; establish contact|CONTACT ; ^ HAND only|now $ ; go for THING & !it",
)
.needs_body();

impl Conversation {
    /// Whether a thing is beyond what either bare hand reaches without leaning, by the map.
    fn is_out_of_hands_reach(&self, thing: &KnownThing) -> bool {
        let (at, Some(maps)) = (thing.found.point, self.reachable()) else { return false };
        maps.iter().take(2).all(|map| map.level(&map.frame.inverse_point(&at)) != Level::Near)
    }

    /// Touches a thing with the tip of the stick that he holds.
    fn touch_with_stick(&mut self, thing: &KnownThing, lean: bool) -> Acted {
        let Some(tip) = self.actor.stick_tip() else { return Ok(Answer::failed("I hold no stick")) };
        if thing.in_touch == Some(tip) {
            return Ok(Answer::done("The stick touches it already"));
        }
        self.let_be();
        self.settle_at_ready();
        let said = match self.actor.touch_with_stick(&thing.found, lean, 1) {
            Ok(touching) => {
                self.things.felt_again(thing.id, &touching.found);
                return Ok(Answer::done("I touch it with the stick"));
            }
            Err(Trouble::Nothing) => "I felt about for it with the stick, and felt nothing".into(),
            Err(Trouble::Reach(OutOfReach::TooFar(by))) => {
                format!("It is {:.0} cm too far for the stick", (100.0 * by).max(1.0))
            }
            Err(trouble) => {
                format!("I cannot touch it with the stick: {}", self.in_words(&trouble.of_task()?))
            }
        };
        Ok(Answer::failed(said))
    }

    /// Touches a thing, with a hand or with the one that does not touch it yet.
    pub(super) fn touch(&mut self, thing: &KnownThing, hand: Option<usize>, lean: bool) -> Acted {
        let touching = thing.in_touch.and_then(|receptor| self.actor.arm_of(receptor));
        let hand = hand.or_else(|| touching.map(|hand| 1 - hand)).unwrap_or(0);
        let name = self.hand_name(hand);
        let by_it = |receptor| self.actor.hands[hand].receptors.contains(&receptor);
        if touching == Some(hand) && thing.in_touch.is_some_and(by_it) {
            return Ok(Answer::done(format!("My {name} touches it already")));
        }
        // Other things' arms first; the one that touches this goes back by itself.
        self.things.parted();
        if touching.is_none() {
            self.settle_at_ready();
        }
        let result = match touching {
            Some(_) => self.actor.touch(&thing.found, hand, lean, 1),
            None => self.actor.touch_again(&thing.found, hand, lean, 1),
        };
        let said = match result {
            Ok(touching) => {
                self.things.felt_again(thing.id, &touching.found);
                let felt_about =
                    if touching.corrections > 0 { "had to feel about for it, and now " } else { "" };
                return Ok(Answer::done(format!("I {felt_about}touch it with my {name}")));
            }
            // It felt about near there, too: what it remembers is no longer so.
            Err(Trouble::Nothing) => {
                let place = self.place(&thing.at);
                self.things.forget(thing.id);
                self.search = None;
                format!("I felt about for it with my {name}, and it is no longer {place}")
            }
            Err(trouble) => {
                let too_far = matches!(trouble, Trouble::Reach(OutOfReach::TooFar(_))) && !lean;
                let hint = if too_far { "; I could lean forward and try again" } else { "" };
                format!("I cannot touch it with my {name}: {}{hint}", self.in_words(&trouble.of_task()?))
            }
        };
        Ok(Answer::failed(said))
    }

    /// The receptor of a hand that touches a thing, after touching it where none does; what it says where it cannot. Only
    /// what a hand touches can be held.
    pub(super) fn in_hand(
        &mut self,
        thing: &KnownThing,
        hand: Option<usize>,
        lean: bool,
    ) -> Result<Result<usize, Answer>, Trouble> {
        let with_stick = self.actor.stick().map(|stick| stick.hand);
        let by_hand = |receptor: &usize| {
            let by = self.actor.arm_of(*receptor);
            by.is_some_and(|by| {
                Some(by) != with_stick
                    && self.actor.hands[by].receptors.contains(receptor)
                    && hand.is_none_or(|hand| hand == by)
            })
        };
        if let Some(receptor) = thing.in_touch.filter(by_hand) {
            return Ok(Ok(receptor));
        }
        let own_side = usize::from(self.actor.side(0) * thing.at.dot(&self.actor.left()) < 0.0);
        let free = with_stick.map_or(own_side, |hand| 1 - hand);
        let touched = self.touch(thing, Some(hand.unwrap_or(free)), lean)?;
        // What was not felt there any more has been forgotten.
        Ok(match self.things.get(thing.id).and_then(|known| known.in_touch) {
            Some(receptor) if touched.done == Some(true) => Ok(receptor),
            _ => Err(touched),
        })
    }
}
