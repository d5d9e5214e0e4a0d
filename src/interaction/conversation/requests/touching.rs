//! "Touch it with your left hand."

use super::super::Conversation;
use super::{Act, Intent, Reply, RequestKind};
use crate::interaction::conversation::language::Leave;
use crate::interaction::tasks::Trouble;
use crate::interaction::things::KnownThing;
use crate::named::in_words;
use crate::peripersonal::{Level, OutOfReach};
use crate::simulation::EngineError;

pub(super) const TOUCH: RequestKind = RequestKind {
    told: &[
        "touch|tap|poke|contact|stroke|pat|prod|nudge|brush|press|rub|tickle|knock ?on|at|against|up THING|SOME|HAND|them",
        "^ touch|tap|poke|contact $",
        "go|head ?over for|to|towards|toward|and THING",
        "reach THING",
        "put|lay|place|rest|set|get|position|move|bring|keep|press|hold|stretch|extend|push|lower|have|land ?your|one|a|both ?down|out HAND|finger|hand ?up|down|out|over|back ?right on|onto|upon|to|against|at|towards|near|over|in ?contact|touch|top ?with|of THING|SOME",
        "make contact",
        "give THING ?a ?little|gentle|quick touch|poke|tap|pat|stroke|prod",
        "use HAND to|for|on ?touch",
        "HAND ?should|must|be|go ?be|go ?should ?be on|onto|to|against THING $",
        "meet THING",
        "^ use STICK ?to|for|on ?touch",
        "^ HAND $",
        "^ ?but|and|now|do|try ?THING with HAND ?instead|now $",
        "reach ?out ?and|to touch",
        "switch|change ?over ?to HAND",
    ],
    needs_body: true,
    ..RequestKind::new(
        ["touch it", "touched it"],
        Act::Handles(|creature, thing, request, leave| {
            if request.stick {
                return creature.touch_with_stick(thing, request.lean);
            }
            let hand = creature.hand_for(request.hand);
            let reply = creature.touch(thing, hand, request.lean, leave)?;
            // What is too far for the hand may not be for a stick that he holds.
            let out_of_reach = reply.done == Some(false) && creature.is_out_of_hands_reach(thing);
            let may = out_of_reach && hand.is_none() && creature.actor.stick_tip().is_some();
            if may { creature.touch_with_stick(thing, request.lean) } else { Ok(reply) }
        }),
    )
};

impl Conversation {
    /// Whether a thing is beyond what either bare hand reaches without leaning, by the map.
    fn is_out_of_hands_reach(&self, thing: &KnownThing) -> bool {
        let (at, Some(maps)) = (thing.found.point, self.reachable()) else { return false };
        maps.iter().take(2).all(|map| map.level(&map.frame.inverse_point(&at)) != Level::Near)
    }

    /// Touches a thing with the tip of the stick that he holds.
    fn touch_with_stick(&mut self, thing: &KnownThing, lean: bool) -> Result<Reply, EngineError> {
        let Some(tip) = self.actor.stick_tip() else {
            return self.fails(Intent::Touch, "I hold no stick");
        };
        if thing.in_touch == Some(tip) {
            return self.does(Intent::Touch, "The stick touches it already");
        }
        self.let_be();
        self.settle_at_ready();
        match self.actor.touch_with_stick(&thing.found, lean, 1) {
            Ok(touching) => {
                self.things.felt_again(thing.id, &touching.found);
                self.does(Intent::Touch, "I touch it with the stick")
            }
            Err(Trouble::Engine(error)) => Err(error),
            Err(Trouble::Nothing) => {
                self.fails(Intent::Touch, "I felt about for it with the stick, and felt nothing")
            }
            Err(Trouble::Reach(OutOfReach::TooFar(by))) => {
                let said = format!("It is {:.0} cm too far for the stick", (100.0 * by).max(1.0));
                self.fails(Intent::Touch, said)
            }
            Err(trouble) => {
                let said = format!("I cannot touch it with the stick: {}", self.in_words(&trouble));
                self.fails(Intent::Touch, said)
            }
        }
    }

    /// Touches a thing, with a hand or with the one that does not touch it yet.
    pub(super) fn touch(
        &mut self,
        thing: &KnownThing,
        hand: Option<usize>,
        lean: bool,
        _leave: &Leave,
    ) -> Result<Reply, EngineError> {
        let touching = thing.in_touch.and_then(|receptor| self.actor.arm_of(receptor));
        let hand = hand.or_else(|| touching.map(|hand| 1 - hand)).unwrap_or(0);
        if touching == Some(hand)
            && thing.in_touch.is_some_and(|r| self.actor.hands[hand].receptors.contains(&r))
        {
            let said = format!("My {} touches it already", in_words(&self.actor.hands[hand].name));
            return self.does(Intent::Touch, said);
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
        let name = in_words(&self.actor.hands[hand].name);
        match result {
            Ok(touching) => {
                self.things.felt_again(thing.id, &touching.found);
                let said = match touching.corrections {
                    0 => format!("I touch it with my {name}"),
                    _ => format!("I had to feel about for it, and now touch it with my {name}"),
                };
                self.does(Intent::Touch, said)
            }
            Err(Trouble::Engine(error)) => Err(error),
            // It felt about near there, too: what it remembers is no longer so.
            Err(Trouble::Nothing) => {
                let place = self.place(&thing.at);
                self.things.forget(thing.id);
                self.search = None;
                let said = format!("I felt about for it with my {name}, and it is no longer {place}");
                self.fails(Intent::Touch, said)
            }
            Err(trouble) => {
                let hint = match &trouble {
                    Trouble::Reach(OutOfReach::TooFar(_)) if !lean => "; I could lean forward and try again",
                    _ => "",
                };
                let said = format!("I cannot touch it with my {name}: {}{hint}", self.in_words(&trouble));
                self.fails(Intent::Touch, said)
            }
        }
    }

    /// The receptor of a hand that touches a thing, after touching it where none does; what it says where it cannot. Only
    /// what a hand touches can be held.
    pub(super) fn in_hand(
        &mut self,
        thing: &KnownThing,
        hand: Option<usize>,
        lean: bool,
        leave: &Leave,
    ) -> Result<Result<usize, Reply>, EngineError> {
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
        let touched = self.touch(thing, Some(hand.unwrap_or(free)), lean, leave)?;
        // What was not felt there any more has been forgotten.
        Ok(match self.things.get(thing.id).and_then(|known| known.in_touch) {
            Some(receptor) if touched.done == Some(true) => Ok(receptor),
            _ => Err(touched),
        })
    }
}
