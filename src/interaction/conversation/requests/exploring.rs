//! "Is there something in front of you?": it feels about on the table.

use super::super::Conversation;
use super::{Act, Intent, Reply, RequestKind};
use crate::geometry::Capsule;
use crate::interaction::conversation::language::Leave;
use crate::interaction::tasks::Trouble;
use crate::peripersonal::Obstacle;
use crate::simulation::EngineError;

pub(super) const EXPLORE: RequestKind = RequestKind {
    told: &[
        "explore|search|scan|scour|sweep|comb|probe|survey|examine|check|inspect|feel|grope|fumble|investigate|rummage ?out|through|over|across|along|on|all|around|about|round ?over|across|on|at|all|of ?the|your|this|what ?whole|entire table|tabletop|space|area|surroundings|desk|surface|scene|environment|place|vicinity|top|front|region|room",
        "feel|look|search|grope|fumble|sweep|hunt|probe|cast|scout|explore|move|wave ?HAND|your ?hands ?out ?all around|about|round",
        "feel|look|search|grope|reach|sweep|move|explore ?HAND ?out ?all over|across|along|in|on|upon ?front ?of ?the|this ?whole table|tabletop|you|surface|desk",
        "look|search|feel|grope|hunt|seek|check|scan|scout|probe|fish ?out|around|about|round|over ?with ?HAND ?on for SOME|THING|more|another",
        "look|search|feel|grope|seek|check ?around|about ?with ?HAND SOME",
        "look|search|feel|check ?out if|whether",
        "find|locate|discover|detect|seek|identify|spot|encounter|uncover ?out|me|us ?if|whether|another|what|all ?there ?be SOME|THING|there|more|another",
        "see|check|find|test|feel|learn|determine|verify|look ?out if|whether|what ?THING|SOME|there|you ?be",
        "reach ?out ?HAND ?over|out|around ?for|to|into|toward ?find SOME",
        "reach|stretch ?out ?your|HAND ?out|forward|ahead|forth $",
        "reach|stretch ?HAND out|forward|ahead $",
        "sweep|run|move|slide|pass|swing|swipe|wave|glide|drag|pat ?your HAND ?slowly|all|back|gently ?and|over ?forth over|across|along|about|around|on|through|above ?the|top ?of ?the table|tabletop|surface|desk",
        "touch|grab|get|take SOME",
        "explore|search|sweep $",
        "what else",
        "^ ?for|try|search ?another|any|some SOME|other|another|more ?else|more|SOME|one $",
        "find|locate|seek|discover THING",
        "run|bump|come|stumble ?up into|across|upon|against SOME",
        "have|take a ?good|quick ?look feel|search|rummage|look around|about|round|for",
        "get to know your|the surroundings|table|space|environment",
        "^ explore|search",
        "keep =looking|=searching|=exploring|=feeling",
        "tell|show ?me what|whether ?SOME be on|in|there",
    ],
    needs_body: true,
    ..RequestKind::new(
        ["feel about for things", "felt about for things"],
        Act::Moves(|creature, request, leave| {
            let hand = creature.hand_for(request.hand);
            creature.explore(hand, leave)
        }),
    )
};

impl Conversation {
    fn explore(&mut self, hand: Option<usize>, _leave: &Leave) -> Result<Reply, EngineError> {
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
