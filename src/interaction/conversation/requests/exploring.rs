//! "Is there something in front of you?": it feels about on the table.

use super::super::Conversation;
use super::{Intent, Reply, RequestKind, Utterance};
use crate::geometry::Capsule;
use crate::interaction::tasks::Trouble;
use crate::peripersonal::Obstacle;
use crate::simulation::EngineError;

pub(super) const EXPLORE: RequestKind = RequestKind {
    means: |utterance: &Utterance| {
        utterance.any(&[
            "something",
            "anything",
            "explore",
            "search",
            "find",
            "look",
            "feel",
            "around",
            "there",
        ]) && !utterance.any(&["touch", "reach"])
    },
    needs_body: true,
    needs_thing: false,
    act: |creature, request| creature.explore(request.hand),
};

impl Conversation {
    fn explore(&mut self, hand: Option<usize>) -> Result<Reply, EngineError> {
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
        for known in self.things.iter() {
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
        let i = self.things.remember(&found, Some(found.receptor));
        self.things.mean((self.things.len() == 1).then_some(i));
        let limb = self.limb_in_words(found.receptor);
        let something = if self.things.len() > before && before > 0 { "something else" } else { "something" };
        let said = format!("Yes, I feel {something} with my {limb}, {}", self.place(&self.things[i].at));
        Ok(self.reply(Intent::Explore, said, Some(true), false))
    }
}
