//! "Feel its shape": it touches a thing with either hand, and tells how far apart that was.

use super::super::{Conversation, Request};
use super::{Act, Intent, Reply, RequestKind};
use crate::interaction::conversation::language::Leave;
use crate::simulation::EngineError;

pub(super) const FEEL_SHAPE: RequestKind = RequestKind {
    told: &[
        "have|take|get a ?good|proper feel of|for THING",
        "feel|explore|examine|inspect|investigate|palpate|study|trace|follow|check|find|discover|learn|work|figure|determine|measure|test|make|map|get|see|probe|scan|sense|recognise|recognize|identify .. shape|form|outline|contour|contours|size|edges|edge|corners|outside|dimensions|rim|curves|geometry|sides|surface|extent|proportions",
        "feel|find|work|figure|see|check|learn|explore|discover|determine|test|measure .. how big|large|wide|tall|long|thick|high|round|small|broad|deep",
        "run|pass|slide|move|glide|stroke|let|guide|trace|draw|brush|wander|go|walk ?with HAND|PART ?all ?the|slowly ?way over|along|around|round|across|about THING|the|its ?whole|entire ?edge|edges|surface|outline|outside|sides|$",
        "run|pass|slide|move|glide|trace|draw HAND ?all over|along|around|round THING",
        "explore|examine|inspect|palpate|measure|study|investigate|trace THING",
        "feel ?all ?the ?way round|around|over|about|along THING",
        "feel THING all|carefully|thoroughly|closely|over|around|round|about|up|from",
        "feel THING ?with|using ?HAND ?to|and ?learn|find ?out $",
        "feel|tell|find|check|test ?out whether|if|what ?THING .. round|square|flat|pointed|like|rounded|angular|box",
        "get a|the feel of|for",
        "touch THING all ?over|around|round",
        "get|come to know|learn THING",
        "wrap|put|close HAND around|round THING",
        "find|work|figure|make out what ?kind|sort|shape|form",
        "touch THING in|at|from several|different|more|many|other|all|various",
        "^ feel THING $",
        "take|get THING|its|the ?its measurements",
        "measure",
        "go over|around|round|along THING",
        "use HAND to feel|explore|examine|learn",
        "explore|feel ?out its|the shape|form",
        "fingers over THING",
    ],
    needs_body: true,
    needs_thing: true,
    ..RequestKind::new(
        ["feel its shape", "felt its shape"],
        Act::Moves(|creature, request, leave| creature.feel_shape(request, leave)),
    )
};

impl Conversation {
    fn feel_shape(&mut self, request: &Request, leave: &Leave) -> Result<Reply, EngineError> {
        let first = self.hand_for(request.hand).unwrap_or(0);
        let mut last = None;
        for hand in [first, 1 - first] {
            let reply = self.touch(Some(hand), request.lean, leave)?;
            if reply.done == Some(true) || last.is_none() {
                last = Some(reply);
            }
        }
        let felt = self.things.it().map_or(0, |i| self.felt_places(i).len());
        let known = self.shape_in_words();
        let done = felt > 1;
        Ok(self.reply(Intent::FeelShape, known, Some(done), false))
    }
}
