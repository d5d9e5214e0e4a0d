//! "Put it as far away as possible", "bring it near", and "push it to the left".

use super::super::Conversation;
use super::{Act, Intent, Reply, RequestKind};
use crate::interaction::conversation::language::{Aside, Leave, Request};
use crate::interaction::tasks::Trouble;
use crate::interaction::things::KnownThing;
use crate::simulation::EngineError;

/// How far before the trunk something is that is brought near, metres: where the table begins nobody knows, and all of the
/// thing is to stand on it …
const NEAR: f64 = 0.2;
/// … and how far over its side of the middle, metres: the first of these that can be reached.
const ACROSS: [f64; 3] = [0.15, 0.25, 0.05];
/// A little farther than where something is to be put does as well: in such steps, metres …
const STEP: f64 = 0.03;
/// … so many of them.
const STEPS: u32 = 8;
/// How far something is moved to a side where that is not told, metres.
const ASIDE: f64 = 0.15;

/// How much effort is made to find the farthest place.
const EFFORT: usize = 2;

pub(super) const PUT_FAR: RequestKind = RequestKind {
    told: &[
        "put|push|move|place|set|shove|slide|send|carry|take|throw|shift|get|bring|transport|position|deliver|displace|nudge|keep|reposition|stow|lay|drag|relocate|toss|stand THING|SOME .. far|farther|further|farthest|furthest|away|distant|remote|distance",
        "put|push|move|place|set|shove|slide|send|carry|take|shift|get THING|SOME ?right|well off to|into|over|there|toward|towards|far|$",
        "put|push|move|place|set|shove|slide|send|carry|take|shift|transport|position|nudge THING|SOME ?straight|right|all ?the ?way out|forward|forwards|ahead|outward|outwards|across|beyond|aside|yonder|over",
        "put|push|move|place|set|shove|slide|send|carry|take|get|shift|transport|position|stretch|hold|deposit .. arms|BODY|full|at|arm|maximum|maximal|max ?is|own length|reach|extent|stretch|distance|range",
        "out of ?my|your|the|easy ?easy reach|range",
        "get|be|make ?yourself rid of",
        "increase|widen|maximise|maximize|extend|enlarge|lengthen ?the|a|its|THING ?a distance|gap|space|room|separation",
        "push|shove|nudge THING|SOME",
        "give THING ?a ?little|gentle|good push|shove|nudge",
        "^ put|push|shove ?as|so|very far|away|further|farther",
        "put|push|move|get|take|carry|shift|set THING|SOME out of",
        "^ ?even|a|as|much|still ?bit|little|lot farther|further|away|far ?away|off|out|as $",
        "put THING to|at|on|over|in|behind|beyond|near ?the far|other|farther|opposite|distance",
        "more distance|space|room between|from",
        "make THING ?be further|farther|far|more|distant|remote",
        "away with THING",
        "THING ?to ?could|should|must ?to =be|go|come|move|get|stay ?go|away ?even|much|a ?still ?bit|little|lot|long ?way far|farther|further|away|farthest|distant|miles|beyond",
        "put|leave|get|have ?as ?much|more|some space|room|distance as|between",
    ],
    needs_body: true,
    ..RequestKind::new(
        ["put it far away", "put it far away"],
        Act::Handles(|creature, thing, request, leave| creature.put(Goal::Far, thing, request, leave)),
    )
};

pub(super) const BRING_NEAR: RequestKind = RequestKind {
    told: &[
        "THING ?to ?could|should|must ?to =be|come|go|get|move ?a|much|even|rather|right|very ?bit|little|lot|up closer|nearer|near|close|here",
        "bring|pull|fetch|draw|drag|haul|tug|retrieve|recover|collect !far|farther|farthest|further|furthest|away|off THING|SOME|them|me",
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
    ..RequestKind::new(
        ["bring it near", "brought it near"],
        Act::Handles(|creature, thing, request, leave| creature.put(Goal::Near, thing, request, leave)),
    )
};

pub(super) const PUT_ASIDE: RequestKind = RequestKind {
    told: &["SIDE"],
    needs_body: true,
    ..RequestKind::new(
        ["move it to the side", "moved it to the side"],
        Act::Handles(|creature, thing, request, leave| {
            let Some(aside) = request.aside else {
                return creature.fails(Intent::PutAside, "I do not know to which side I am to move it");
            };
            creature.put(Goal::Aside(aside), thing, request, leave)
        }),
    )
};

/// Where a thing is to be put.
#[derive(Clone, Copy)]
enum Goal {
    Far,
    Near,
    Aside(Aside),
}

impl Conversation {
    fn put(
        &mut self,
        goal: Goal,
        thing: &KnownThing,
        request: &Request,
        leave: &Leave,
    ) -> Result<Reply, EngineError> {
        let intent = match goal {
            Goal::Far => Intent::PutFar,
            Goal::Near => Intent::BringNear,
            Goal::Aside(_) => Intent::PutAside,
        };
        let far = matches!(goal, Goal::Far);
        let lean = request.lean;
        let receptor = match self.in_hand(thing, self.hand_for(request.hand), lean, leave)? {
            Ok(receptor) => receptor,
            Err(touched) => return Ok(Reply { intent, ..touched }),
        };
        if !self.actor.hold(receptor) {
            self.things.parted();
            return self.fails(intent, "It slipped away: I no longer feel it");
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
        let (front, left, up) = (actor.front, actor.left(), actor.up);
        let spot = match goal {
            Goal::Far => actor.farthest(receptor, height, upright, lean, EFFORT),
            Goal::Near => {
                let edge = actor.trunk_front(actor.table.unwrap_or(height));
                let side = actor.arm_of(receptor).map_or(0.0, |hand| actor.side(hand));
                let near = |k: u32| front * (edge + NEAR + STEP * f64::from(k)) + up * height;
                let places = (0..STEPS).flat_map(|k| ACROSS.map(|by| near(k) + left * (side * by)));
                actor.spot_at(receptor, places, upright)
            }
            Goal::Aside(aside) => {
                let way = if aside.left { left } else { -left };
                let far = aside.by.unwrap_or(ASIDE);
                // What is too far is left out, as long as anything of it is left.
                let shorter = (0..STEPS).map(|k| far * (1.0 - f64::from(k) / f64::from(STEPS)));
                actor.spot_at(receptor, shorter.map(|far| point + way * far), upright)
            }
        };
        let Some(spot) = spot else {
            actor.let_go();
            return self.fails(intent, "I find no place for it that I reach");
        };
        match self.actor.put(receptor, &spot, lean) {
            Ok(stands) => {
                let mut at = stands;
                if let Some(known) = self.things.get_mut(thing.id) {
                    known.carried(&(stands - point));
                    at = known.at;
                }
                let back = self.settle_at_ready();
                let how = if lean { "I leaned forward and" } else { "I" };
                let done = match goal {
                    Goal::Far => "put it as far away as I could".to_string(),
                    Goal::Near => "put it near me".to_string(),
                    Goal::Aside(aside) => {
                        let side = if aside.left { "left" } else { "right" };
                        let moved = (stands - point).dot(&left) * if aside.left { 100.0 } else { -100.0 };
                        format!("moved it {moved:.0} cm to my {side}")
                    }
                };
                let rest = if back { "" } else { "; my hand is still there" };
                let said = format!("{how} {done}: it is {} now{rest}", self.place(&at));
                self.does(intent, said)
            }
            Err(Trouble::Engine(error)) => Err(error),
            Err(trouble) => {
                self.actor.let_go();
                let said = format!("I held it, but did not get it there: {}", self.in_words(&trouble));
                self.fails(intent, said)
            }
        }
    }
}
