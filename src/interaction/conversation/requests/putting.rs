//! "Put it as far away as possible", and "bring it near".

use super::super::Conversation;
use super::{Intent, Reply, RequestKind, Utterance};
use crate::interaction::tasks::Trouble;
use crate::simulation::EngineError;

/// How far over the table's near edge something is that is brought near, metres.
const NEAR: f64 = 0.14;

pub(super) const PUT_FAR: RequestKind = RequestKind {
    means: |utterance: &Utterance| {
        utterance.any(&["put", "push", "place", "move", "set"])
            && utterance.any(&["far", "away", "farther", "farthest"])
    },
    needs_body: true,
    needs_thing: true,
    act: |creature, request| creature.put(true, request.hand, request.lean),
};

pub(super) const BRING_NEAR: RequestKind = RequestKind {
    means: |utterance: &Utterance| {
        utterance.any(&["bring", "pull", "fetch"])
            || (utterance.any(&["put", "move", "place"])
                && utterance.any(&["near", "nearer", "closer", "close", "back"]))
    },
    needs_body: true,
    needs_thing: true,
    act: |creature, request| creature.put(false, request.hand, request.lean),
};

impl Conversation {
    fn put(&mut self, far: bool, hand: Option<usize>, lean: bool) -> Result<Reply, EngineError> {
        let intent = if far { Intent::PutFar } else { Intent::BringNear };
        let i = self.things.it().expect("it is known which");
        let by_hand = |receptor: &usize| {
            let by = self.actor.arm_of(*receptor);
            by.is_some_and(|by| {
                self.actor.hands[by].receptors.contains(receptor) && hand.is_none_or(|hand| hand == by)
            })
        };
        if self.things[i].in_touch.filter(by_hand).is_none() {
            // Only what a hand touches can be held.
            let own_side = usize::from(self.actor.side(0) * self.things[i].at.dot(&self.actor.left()) < 0.0);
            let touched = self.touch(Some(hand.unwrap_or(own_side)), lean)?;
            if touched.done != Some(true) {
                return Ok(Reply { intent, ..touched });
            }
        }
        let receptor = self.things[i].in_touch.expect("a hand touches it");
        if !self.actor.hold(receptor) {
            self.things[i].in_touch = None;
            return Ok(self.reply(intent, "It slipped away: I no longer feel it".into(), Some(false), false));
        }
        let actor = &mut self.actor;
        if far && lean {
            // Where the other arm cannot make way, what is left is found all the same.
            if let Some(Err(Trouble::Engine(error))) =
                actor.arm_of(receptor).map(|hand| actor.make_way_to_lean(hand))
            {
                return Err(error);
            }
        }
        let limb = actor.own.place(receptor).limb;
        let (point, _) = actor.feels_at(receptor);
        let upright = actor.frames()[limb].rotation.tr_mul(&actor.up);
        let height = point.dot(&actor.up);
        let spot = match far {
            true => actor.farthest(receptor, height, upright, lean, 2),
            false => {
                let edge = actor.trunk_front(actor.table.unwrap_or(height));
                actor.spot_at(receptor, edge + NEAR, 0.15, height, upright)
            }
        };
        let Some(spot) = spot else {
            actor.let_go();
            return Ok(self.reply(intent, "I find no place for it that I reach".into(), Some(false), false));
        };
        let moved = spot.point - point;
        match self.actor.put(receptor, &spot, lean) {
            Ok(()) => {
                let known = &mut self.things[i];
                known.carried(&moved);
                let at = known.at;
                let ready = self.ready.clone();
                let back = self.settle(&ready);
                let how = if lean { "I leaned forward and put it" } else { "I put it" };
                let far = if far { " as far away as I could" } else { " near me" };
                let rest = if back { "" } else { "; my hand is still there" };
                let said = format!("{how}{far}: it is {} now{rest}", self.place(&at));
                Ok(self.reply(intent, said, Some(true), false))
            }
            Err(Trouble::Engine(error)) => Err(error),
            Err(trouble) => {
                self.actor.let_go();
                let said = format!("I held it, but did not get it there: {}", self.in_words(&trouble));
                Ok(self.reply(intent, said, Some(false), false))
            }
        }
    }
}
