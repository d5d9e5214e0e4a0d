//! "Touch it with your left hand."

use super::super::Conversation;
use super::super::speaking::cm;
use super::{Act, Acted, Answer, RequestKind};
use crate::interaction::tasks::Trouble;
use crate::interaction::things::KnownThing;
use crate::peripersonal::{Level, OutOfReach};

pub(super) const TOUCH: RequestKind = RequestKind::of_body(
    ["touch it", "touched it"],
    Act::Handles(|creature, thing, request| {
        if request.stick {
            return creature.touch_with_stick(thing, request.lean);
        }
        let hand = creature.hand_for(request.hand);
        let touched = creature.touch(thing, hand, request.lean);
        // What is too far for the hand may not be for a stick that he holds.
        let could_not = matches!(touched, Err(Trouble::Told(_)));
        let may = could_not && hand.is_none() && creature.actor.stick_tip().is_some();
        if may && creature.is_out_of_hands_reach(thing) {
            return creature.touch_with_stick(thing, request.lean);
        }
        touched
    }),
    "told: ^ USE STICK ?to|for|on ?TOUCH; TOUCH ?on|at|against|up THING|SOME|HAND|them; ^ TOUCH; GO ?over ON|and \
     THING; REACH ?out ?and|for|to ?TOUCH THING; PUT|get|keep|have|press|hold|REACH|lower|PULL|PUSH|land ?your|one \
     ?down|out HAND|finger|hand ?UP|DOWN|out|over|BACK|flat ?right ON|OF|near ?CONTACT|top|with ?with|of \
     THING|SOME; make|get|have ?in CONTACT with THING|SOME; USE HAND ?to|for|on ?TOUCH; HAND ?should|must|be|GO \
     ?be|go|should ?be ON THING; HAND ON THING|SOME; ^ HAND $; ^ ?but|and|do|try ?THING with|use HAND ?instead $; \
     REACH ?out ?and|to|for TOUCH; switch|change|swap ?over ?to HAND; TOUCH & THING; HAND TOUCH THING; ^ THING & \
     other|instead; HAND TOUCH; PUT|get .. HAND|finger|fingertip .. ON THING; give THING .. TOUCH; TOUCH THING \
     ?with other|left|right",
);

impl Conversation {
    /// Whether a thing is beyond what either bare hand reaches without leaning, by the map.
    fn is_out_of_hands_reach(&self, thing: &KnownThing) -> bool {
        let (at, Some(maps)) = (thing.found.point, self.reachable()) else { return false };
        maps.iter().take(2).all(|map| map.level(&map.frame.inverse_point(&at)) != Level::Near)
    }

    /// Touches a thing with the tip of the stick that he holds.
    fn touch_with_stick(&mut self, thing: &KnownThing, lean: bool) -> Acted {
        let Some(tip) = self.actor.stick_tip() else { return Ok(Answer::failed("I am not holding a stick")) };
        if thing.in_touch == Some(tip) {
            return Ok(Answer::done("The stick touches it already"));
        }
        self.let_be();
        self.settle();
        match self.actor.with_stick(|actor, hand| actor.touch_again(&thing.found, hand, lean)) {
            Ok(touching) => {
                self.mind.things.felt_again(thing.id, &touching.found);
                Ok(Answer::done("I touch it with the stick"))
            }
            Err(Trouble::Nothing) => {
                Err(Trouble::Told("I felt around for it with the stick and felt nothing".into()))
            }
            Err(Trouble::Reach(OutOfReach::TooFar(by))) => {
                Err(Trouble::Told(format!("It is {} beyond the reach of the stick", cm(by.max(0.01)))))
            }
            Err(trouble) => Err(self.hindered("I cannot touch it with the stick", trouble)),
        }
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
        self.mind.things.parted();
        if touching.is_none() {
            self.settle();
        }
        let result = match touching {
            Some(_) => self.actor.touch(&thing.found, hand, lean),
            None => self.actor.touch_again(&thing.found, hand, lean),
        };
        match result {
            Ok(touching) => {
                self.mind.things.felt_again(thing.id, &touching.found);
                let felt_about =
                    if touching.corrections > 0 { "had to feel around for it, and now " } else { "" };
                Ok(Answer::done(format!("I {felt_about}touch it with my {name}")))
            }
            // It felt about near there, too: what it remembers is no longer so.
            Err(Trouble::Nothing) => {
                self.mind.things.forget(thing.id);
                self.search = None;
                let place = self.place(&thing.at);
                Err(Trouble::Told(format!(
                    "I felt around for it with my {name}, and it is no longer {place}"
                )))
            }
            Err(trouble) => {
                let too_far = matches!(trouble, Trouble::Reach(OutOfReach::TooFar(_))) && !lean;
                let hint = if too_far { " unless I lean forward" } else { "" };
                Err(self.hindered(&format!("I cannot touch it with my {name}{hint}"), trouble))
            }
        }
    }

    /// The receptor of a hand that holds a thing from now on, after touching it where none does. Only what a hand touches can
    /// be held.
    pub(super) fn in_hand(
        &mut self,
        thing: &KnownThing,
        hand: Option<usize>,
        lean: bool,
    ) -> Result<usize, Trouble> {
        let with_stick = self.actor.stick().map(|stick| stick.hand);
        let by_hand = |receptor: &usize| {
            self.actor.arm_of(*receptor).is_some_and(|by| {
                Some(by) != with_stick
                    && self.actor.hands[by].receptors.contains(receptor)
                    && hand.is_none_or(|hand| hand == by)
            })
        };
        let receptor = match thing.in_touch.filter(by_hand) {
            Some(receptor) => receptor,
            None => {
                let own_side = self.actor.hand_towards(&thing.at);
                let free = with_stick.map_or(own_side, |hand| 1 - hand);
                self.touch(thing, Some(hand.unwrap_or(free)), lean)?;
                self.mind.things.get(thing.id).and_then(|known| known.in_touch).ok_or(Trouble::Nothing)?
            }
        };
        if self.actor.hold(receptor) {
            return Ok(receptor);
        }
        self.mind.things.parted();
        Err(Trouble::Told("It slipped away: I no longer feel it".into()))
    }
}
