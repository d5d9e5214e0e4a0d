//! "Touch it with your left hand."

use super::super::Conversation;
use super::{Intent, Reply, RequestKind, Utterance};
use crate::interaction::tasks::Trouble;
use crate::peripersonal::OutOfReach;
use crate::simulation::EngineError;

pub(super) const TOUCH: RequestKind = RequestKind {
    means: |utterance: &Utterance| utterance.any(&["touch", "reach", "tap", "point"]),
    needs_body: true,
    needs_thing: true,
    act: |creature, request| creature.touch(request.hand, request.lean),
};

impl Conversation {
    pub(super) fn touch(&mut self, hand: Option<usize>, lean: bool) -> Result<Reply, EngineError> {
        let i = self.things.it().expect("it is known which");
        let found = self.things[i].found.clone();
        let touching = self.things[i].in_touch.and_then(|receptor| self.actor.arm_of(receptor));
        let hand = hand.or_else(|| touching.map(|hand| 1 - hand)).unwrap_or(0);
        if touching == Some(hand)
            && self.things[i].in_touch.is_some_and(|r| self.actor.hands[hand].receptors.contains(&r))
        {
            let said = format!("My {} touches it already", self.actor.hands[hand].name.replace('_', " "));
            return Ok(self.reply(Intent::Touch, said, Some(true), false));
        }
        // Other things' arms first; the one that touches this goes back by itself.
        for k in (0..self.things.len()).filter(|&k| k != i) {
            self.things[k].in_touch = None;
        }
        if touching.is_none() {
            let ready = self.ready.clone();
            self.settle(&ready);
        }
        self.things[i].in_touch = None;
        let result = match touching {
            Some(_) => self.actor.touch(&found, hand, lean, 1),
            None => self.actor.touch_again(&found, hand, lean, 1),
        };
        let name = self.actor.hands[hand].name.replace('_', " ");
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
}
