//! What a creature in conversation does when it is asked to, request by request.

use super::{Conversation, Intent, NEAR, Reply};
use crate::geometry::Capsule;
use crate::interaction::tasks::Trouble;
use crate::peripersonal::{Obstacle, OutOfReach};
use crate::simulation::EngineError;

impl Conversation {
    pub(super) fn explore(&mut self, hand: Option<usize>) -> Result<Reply, EngineError> {
        self.let_be();
        if self.actor.table.is_none() {
            let heights: Vec<f64> = (0..2).filter_map(|hand| self.actor.feel_table(hand).ok()).collect();
            let Some(height) = heights.into_iter().reduce(f64::min) else {
                let said = "I lowered my hands and felt no table in front of me".to_string();
                return Ok(self.reply(Intent::Explore, said, Some(false), false));
            };
            self.actor.know_table(height);
        }
        // What is known already is kept clear of.
        let table = self.actor.clearance.obstacles.clone();
        for known in &self.things {
            self.actor.clearance.obstacles.push(Obstacle::Capsule(Capsule::ball(known.at, 0.07)));
        }
        let first = hand.unwrap_or(1);
        let mut found = None;
        for hand in [first, 1 - first].into_iter().take(if hand.is_some() { 1 } else { 2 }) {
            match self.actor.explore(hand) {
                Ok(Some(thing)) => {
                    found = Some(thing);
                    break;
                }
                Ok(None) | Err(Trouble::Hit(_) | Trouble::Nothing | Trouble::Reach(_)) => {
                    let ready = self.ready.clone();
                    self.settle(&ready);
                }
                Err(Trouble::Engine(error)) => return Err(error),
            }
        }
        self.actor.clearance.obstacles = table;
        let Some(found) = found else {
            let said = match self.things.len() {
                0 => "I felt about on the table as far as I reach and found nothing",
                _ => "I felt about and found nothing else",
            };
            return Ok(self.reply(Intent::Explore, said.into(), Some(true), false));
        };
        let before = self.things.len();
        let i = self.remember(&found, Some(found.receptor));
        self.it = (self.things.len() == 1).then_some(i);
        let limb = self.limb_in_words(found.receptor);
        let something = if self.things.len() > before && before > 0 { "something else" } else { "something" };
        let said = format!("Yes, I feel {something} with my {limb}, {}", self.place(&self.things[i].at));
        Ok(self.reply(Intent::Explore, said, Some(true), false))
    }

    pub(super) fn limb_in_words(&self, receptor: usize) -> String {
        let own = &self.actor.own;
        let limb = own.skin().receptors[receptor].limb;
        let aura = own.creature().aura_of(limb).map(|aura| own.creature().aura_limbs()[aura].name.clone());
        aura.unwrap_or_else(|| own.creature().limbs()[limb].clone()).replace('_', " ")
    }

    pub(super) fn touch(&mut self, hand: Option<usize>, lean: bool) -> Result<Reply, EngineError> {
        let i = self.it.expect("it is known which");
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
                self.things[i].found = touching.found.clone();
                self.things[i].at = touching.found.point + touching.found.direction * 0.02;
                self.things[i].in_touch = Some(touching.found.receptor);
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

    pub(super) fn put(&mut self, far: bool, hand: Option<usize>, lean: bool) -> Result<Reply, EngineError> {
        let intent = if far { Intent::PutFar } else { Intent::BringNear };
        let i = self.it.expect("it is known which");
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
                known.at += moved;
                known.found.point += moved;
                known.in_touch = None;
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

    pub(super) fn how_far(&self) -> Reply {
        let it = self.it.or((self.things.len() == 1).then_some(0));
        let Some(known) = it.map(|i| &self.things[i]) else {
            let said =
                if self.things.is_empty() { "I have not felt anything yet".into() } else { self.question() };
            return self.reply(Intent::HowFar, said, None, false);
        };
        let distances = self.actor.distances(&known.at);
        let nearest = distances.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        let hands = self.actor.hands.each_ref().map(|hand| {
            let distance =
                distances.iter().find(|(limb, _)| *limb == hand.limb).map_or(f64::NAN, |(_, d)| *d);
            format!("{:.0} cm from my {}", 100.0 * distance.max(0.0), hand.name.replace('_', " "))
        });
        let near = nearest.map_or(String::new(), |(limb, distance)| {
            let limb = self.actor.own.creature().limbs()[*limb].replace('_', " ");
            format!("; the nearest to it is my {limb}, {:.0} cm away", 100.0 * distance.max(0.0))
        });
        let said = format!("It is {}: {} and {}{near}", self.place(&known.at), hands[0], hands[1]);
        self.reply(Intent::HowFar, said, None, false)
    }

    pub(super) fn where_felt(&self) -> Reply {
        let touching =
            self.things.iter().filter_map(|known| known.in_touch.map(|receptor| (known, receptor)));
        let told: Vec<String> = touching
            .map(|(known, receptor)| {
                let id = &self.actor.own.skin().receptors[receptor].id;
                format!(
                    "I feel it with my {} (receptor {id}), {}",
                    self.limb_in_words(receptor),
                    self.place(&known.at)
                )
            })
            .collect();
        let said = match (told.is_empty(), self.it.or(self.things.len().checked_sub(1))) {
            (false, _) => told.join("; "),
            (true, Some(i)) => {
                let known = &self.things[i];
                format!(
                    "I do not feel it now; I felt it with my {}, and it is {}",
                    self.limb_in_words(known.found.receptor),
                    self.place(&known.at)
                )
            }
            (true, None) => "I do not feel anything".into(),
        };
        self.reply(Intent::WhereFelt, said, None, false)
    }
}
