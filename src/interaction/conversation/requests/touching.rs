//! "Touch it with your left hand."

use super::super::Conversation;
use super::{Act, Intent, Reply, RequestKind};
use crate::interaction::conversation::language::Leave;
use crate::interaction::tasks::Trouble;
use crate::named::in_words;
use crate::peripersonal::{Level, OutOfReach};
use crate::simulation::EngineError;

pub(super) const TOUCH: RequestKind = RequestKind {
    told: &[
        "swap|switch|change|exchange ?over ?the|your hands|HAND",
        "touch|tap|poke|contact|stroke|pat|prod|nudge|brush|press|rub|tickle|knock ?on|at|against|up THING|SOME|HAND|them",
        "touch|tap|poke|contact|feel THING",
        "^ touch|tap|poke|contact $",
        "^ touch|tap|poke|contact with|using|by|again",
        "reach|stretch|grope|extend ?out ?HAND ?over|out|across for|to|towards|toward|at|and THING",
        "go|head ?over for|to|towards|toward|and THING",
        "reach THING",
        "put|lay|place|rest|set|get|position|move|bring|keep|press|hold|stretch|extend|push|lower|have|land ?your|one|a|both ?down|out HAND|finger|hand ?up|down|out|over|back ?right on|onto|upon|to|against|at|towards|near|over|in ?contact|touch|top ?with|of THING|SOME",
        "make|establish|get|come|have ?into|in ?a|physical|skin contact|touch with",
        "make contact",
        "give THING ?a ?little|gentle|quick touch|poke|tap|pat|stroke|prod",
        "^ use HAND $",
        "use HAND to|for|on ?touch",
        "HAND ?should|must|be|go ?be|go ?should ?be on|onto|to|against THING $",
        "lay|put|place ?a|one finger|hand|HAND on|upon THING",
        "feel THING with HAND",
        "meet THING",
        "^ use STICK ?to|for|on ?touch",
        "^ with HAND $",
        "^ HAND $",
        "^ ?but|and|now|do|try ?THING with HAND ?instead|now $",
        "^ THING with HAND $",
        "reach ?out ?and|to touch",
        "switch|change ?over ?to HAND",
    ],
    needs_body: true,
    needs_thing: true,
    ..RequestKind::new(
        ["touch it", "touched it"],
        Act::Moves(|creature, request, leave| {
            if request.stick {
                return creature.touch_with_stick(request.lean);
            }
            let hand = creature.hand_for(request.hand);
            let reply = creature.touch(hand, request.lean, leave)?;
            // What is too far for the hand may not be for a stick that he holds.
            let out_of_reach = reply.done == Some(false) && creature.is_out_of_hands_reach();
            let may = out_of_reach && hand.is_none() && creature.actor.stick_tip().is_some();
            if may { creature.touch_with_stick(request.lean) } else { Ok(reply) }
        }),
    )
};

impl Conversation {
    /// Whether the thing of which they talk is beyond what either bare hand reaches without leaning, by the map.
    fn is_out_of_hands_reach(&self) -> bool {
        let (Some(i), Some(maps)) = (self.things.it(), self.reachable()) else { return false };
        let at = self.things[i].found.point;
        maps.iter().take(2).all(|map| map.level(&map.frame.inverse_point(&at)) != Level::Near)
    }

    /// Touches the thing of which they talk with the tip of the stick that he holds.
    fn touch_with_stick(&mut self, lean: bool) -> Result<Reply, EngineError> {
        let i = self.things.it().expect("it is known which");
        let Some(tip) = self.actor.stick_tip() else {
            let said = "I hold no stick".to_string();
            return Ok(self.reply(Intent::Touch, said, Some(false), false));
        };
        if self.things[i].in_touch == Some(tip) {
            return Ok(self.reply(Intent::Touch, "The stick touches it already".into(), Some(true), false));
        }
        let found = self.things[i].found.clone();
        self.let_be();
        self.settle_at_ready();
        match self.actor.touch_with_stick(&found, lean, 1) {
            Ok(touching) => {
                self.things.felt_again(i, &touching.found);
                Ok(self.reply(Intent::Touch, "I touch it with the stick".into(), Some(true), false))
            }
            Err(Trouble::Engine(error)) => Err(error),
            Err(Trouble::Nothing) => {
                let said = "I felt about for it with the stick, and felt nothing".to_string();
                Ok(self.reply(Intent::Touch, said, Some(false), false))
            }
            Err(Trouble::Reach(OutOfReach::TooFar(by))) => {
                let said = format!("It is {:.0} cm too far for the stick", (100.0 * by).max(1.0));
                Ok(self.reply(Intent::Touch, said, Some(false), false))
            }
            Err(trouble) => {
                let said = format!("I cannot touch it with the stick: {}", self.in_words(&trouble));
                Ok(self.reply(Intent::Touch, said, Some(false), false))
            }
        }
    }

    /// Touches the thing of which they talk, with a hand or with the one that does not touch it yet.
    pub(super) fn touch(
        &mut self,
        hand: Option<usize>,
        lean: bool,
        _leave: &Leave,
    ) -> Result<Reply, EngineError> {
        let i = self.things.it().expect("it is known which");
        let found = self.things[i].found.clone();
        let touching = self.things[i].in_touch.and_then(|receptor| self.actor.arm_of(receptor));
        let hand = hand.or_else(|| touching.map(|hand| 1 - hand)).unwrap_or(0);
        if touching == Some(hand)
            && self.things[i].in_touch.is_some_and(|r| self.actor.hands[hand].receptors.contains(&r))
        {
            let said = format!("My {} touches it already", in_words(&self.actor.hands[hand].name));
            return Ok(self.reply(Intent::Touch, said, Some(true), false));
        }
        // Other things' arms first; the one that touches this goes back by itself.
        for k in (0..self.things.len()).filter(|&k| k != i) {
            self.things[k].in_touch = None;
        }
        if touching.is_none() {
            self.settle_at_ready();
        }
        self.things[i].in_touch = None;
        let result = match touching {
            Some(_) => self.actor.touch(&found, hand, lean, 1),
            None => self.actor.touch_again(&found, hand, lean, 1),
        };
        let name = in_words(&self.actor.hands[hand].name);
        match result {
            Ok(touching) => {
                self.things.felt_again(i, &touching.found);
                let said = match touching.corrections {
                    0 => format!("I touch it with my {name}"),
                    _ => format!("I had to feel about for it, and now touch it with my {name}"),
                };
                Ok(self.reply(Intent::Touch, said, Some(true), false))
            }
            Err(Trouble::Engine(error)) => Err(error),
            // It felt about near there, too: what it remembers is no longer so.
            Err(Trouble::Nothing) => {
                let place = self.place(&self.things[i].at);
                self.things.forget(i);
                self.search = None;
                let said = format!("I felt about for it with my {name}, and it is no longer {place}");
                Ok(self.reply(Intent::Touch, said, Some(false), false))
            }
            Err(trouble) => {
                let hint = match &trouble {
                    Trouble::Reach(OutOfReach::TooFar(_)) if !lean => "; I could lean forward and try again",
                    _ => "",
                };
                let said = format!("I cannot touch it with my {name}: {}{hint}", self.in_words(&trouble));
                Ok(self.reply(Intent::Touch, said, Some(false), false))
            }
        }
    }

    /// The receptor of a hand that touches the thing of which they talk, after touching it where none does; what it says
    /// where it cannot. Only what a hand touches can be held.
    pub(super) fn in_hand(
        &mut self,
        hand: Option<usize>,
        lean: bool,
        leave: &Leave,
    ) -> Result<Result<usize, Reply>, EngineError> {
        let i = self.things.it().expect("it is known which");
        let with_stick = self.actor.stick().map(|stick| stick.hand);
        let by_hand = |receptor: &usize| {
            let by = self.actor.arm_of(*receptor);
            by.is_some_and(|by| {
                Some(by) != with_stick
                    && self.actor.hands[by].receptors.contains(receptor)
                    && hand.is_none_or(|hand| hand == by)
            })
        };
        if let Some(receptor) = self.things[i].in_touch.filter(by_hand) {
            return Ok(Ok(receptor));
        }
        let own_side = usize::from(self.actor.side(0) * self.things[i].at.dot(&self.actor.left()) < 0.0);
        let free = with_stick.map_or(own_side, |hand| 1 - hand);
        let touched = self.touch(Some(hand.unwrap_or(free)), lean, leave)?;
        Ok(match self.things[i].in_touch {
            Some(receptor) if touched.done == Some(true) => Ok(receptor),
            _ => Err(touched),
        })
    }
}
