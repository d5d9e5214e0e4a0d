//! "Put it as far away as possible", and "bring it near".

use super::super::{Conversation, Request};
use super::{Act, Intent, Reply, RequestKind};
use crate::interaction::conversation::language::Leave;
use crate::interaction::tasks::Trouble;
use crate::simulation::EngineError;

/// How far over the table's near edge something is that is brought near, metres.
const NEAR: f64 = 0.14;

/// How much effort is made to find the farthest place.
const EFFORT: usize = 2;

pub(super) const PUT_FAR: RequestKind = RequestKind {
    told: &[
        "put|push|move|place|set|shove|slide|send|carry|take|throw|shift|get|bring|transport|position|deliver|displace|nudge|keep|reposition|stow|lay|drag|relocate|toss|stand THING|SOME .. far|farther|further|farthest|furthest|away|distant|remote|distance",
        "put|push|move|place|set|shove|slide|send|carry|take|shift|get THING|SOME ?right|well off to|into|over|there|toward|towards|far|$",
        "put|push|move|place|set|shove|slide|send|carry|take|shift|transport|position|nudge THING|SOME ?straight|right|all ?the ?way out|forward|forwards|ahead|outward|outwards|across|beyond|aside|yonder|over",
        "put|push|move|place|set|shove|slide|send|carry|take|get|shift|transport|position|stretch|hold|deposit .. arms|BODY|full|at|arm|maximum|maximal|max ?is|own length|reach|extent|stretch|distance|range",
        "put|push|move|place|set|shove|slide|send|carry|take|get|shift|transport|position THING .. end|edge|side|rear|border|rim|corner|limit",
        "out of ?my|your|the|easy ?easy reach|range",
        "get|be|make ?yourself rid of",
        "increase|widen|maximise|maximize|extend|enlarge|lengthen ?the|a|its|THING ?a distance|gap|space|room|separation",
        "push|shove|nudge THING|SOME",
        "give THING ?a ?little|gentle|good push|shove|nudge",
        "like|want|need|have THING ?a ?bit|little|lot|much|as far|farther|further|away",
        "^ put|push|shove ?as|so|very far|away|further|farther",
        "put|push|move|get|take|carry|shift|set THING|SOME out of",
        "^ ?even|a|as|much|still ?bit|little|lot farther|further|away|far ?away|off|out|as $",
        "clear|clean|tidy|remove THING ?aside|away|from",
        "put THING to|at|on|over|in|behind|beyond|near ?the far|other|farther|opposite|distance",
        "more distance|space|room between|from",
        "make THING ?be further|farther|far|more|distant|remote",
        "banish|remove THING",
        "away with THING",
        "THING ?to ?could|should|must ?to =be|go|come|move|get|stay ?go|away ?even|much|a ?still ?bit|little|lot|long ?way far|farther|further|away|farthest|distant|miles|beyond",
        "put|leave|get|have ?as ?much|more|some space|room|distance as|between",
    ],
    needs_body: true,
    needs_thing: true,
    ..RequestKind::new(
        ["put it far away", "put it far away"],
        Act::Moves(|creature, request, leave| creature.put(true, request, leave)),
    )
};

pub(super) const BRING_NEAR: RequestKind = RequestKind {
    told: &[
        "let THING come ?a ?bit|little closer|nearer|near|here",
        "THING ?to ?could|should|must ?to =be|come|go|get|move ?a|much|even|rather|right|very ?bit|little|lot|up closer|nearer|near|close|here",
        "bring|pull|fetch|draw|drag|haul|tug|retrieve|recover|collect !far|farther|farthest|further|furthest|away|off THING|SOME|them|me",
        "get THING|SOME ?over ?back ?right here|closer|nearer|near|back|to|toward|towards|in",
        "put|move|place|slide|shift|set|take|push|transport|scoot|nudge|reposition|carry|have|bring|pull|get !far|opposite|other ?THING|SOME ?a|as|right|very|all|over|up|even|much|bit|little|rather|back ?bit|little|lot|way|more|to near|nearer|close|closer|here|nearest|closest|toward|towards|adjacent|beside|inward|inwards|this",
        "put|move|place|slide|shift|set|take|push|carry !far|opposite|other THING|SOME ?back|right|up|over|close|in|just ?right|front|close|back ?of to|toward|towards|by|near|beside|next|before|against|into|in ?front ?of ?your|to ?own you|me|yourself|PART|here|body|lap|self",
        "^ ?a|much|even|still ?bit|little|lot closer|nearer|near",
        "reduce|decrease|shorten|close|narrow|lessen|minimise|minimize|shrink|cut ?the|its|your distance|gap|space|separation",
        "like|want|need|have THING ?a ?bit|little|lot|much closer|nearer|near|here|close",
        "^ bring|pull|fetch|draw|drag|retrieve|haul $",
        "come ?back here|back|closer|nearer with THING",
        "make THING ?come|be closer|nearer|near|close",
        "^ ?over here $",
    ],
    needs_body: true,
    needs_thing: true,
    ..RequestKind::new(
        ["bring it near", "brought it near"],
        Act::Moves(|creature, request, leave| creature.put(false, request, leave)),
    )
};

impl Conversation {
    fn put(&mut self, far: bool, request: &Request, leave: &Leave) -> Result<Reply, EngineError> {
        let intent = if far { Intent::PutFar } else { Intent::BringNear };
        let lean = request.lean;
        let receptor = match self.in_hand(self.hand_for(request.hand), lean, leave)? {
            Ok(receptor) => receptor,
            Err(touched) => return Ok(Reply { intent, ..touched }),
        };
        let i = self.things.it().expect("it is known which");
        if !self.actor.hold(receptor) {
            self.things[i].in_touch = None;
            return Ok(self.reply(intent, "It slipped away: I no longer feel it".into(), Some(false), false));
        }
        let actor = &mut self.actor;
        if far && lean {
            // Where the other arm cannot make way, what is left is found all the same.
            if let Err(Trouble::Engine(error)) = actor.make_way_to_lean(receptor, EFFORT) {
                return Err(error);
            }
        }
        let limb = actor.own.place(receptor).limb;
        let (point, _) = actor.feels_at(receptor);
        let upright = actor.frames()[limb].rotation.tr_mul(&actor.up);
        let height = point.dot(&actor.up);
        // What was searched is no longer so.
        self.search = None;
        let actor = &mut self.actor;
        let spot = match far {
            true => actor.farthest(receptor, height, upright, lean, EFFORT),
            false => {
                let edge = actor.trunk_front(actor.table.unwrap_or(height));
                actor.spot_at(receptor, edge + NEAR, 0.15, height, upright)
            }
        };
        let Some(spot) = spot else {
            actor.let_go();
            return Ok(self.reply(intent, "I find no place for it that I reach".into(), Some(false), false));
        };
        match self.actor.put(receptor, &spot, lean) {
            Ok(stands) => {
                let moved = stands - point;
                let known = &mut self.things[i];
                known.carried(&moved);
                let at = known.at;
                let back = self.settle_at_ready();
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
