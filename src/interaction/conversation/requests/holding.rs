//! "Pick it up", "let go", "put it as far away as possible", "bring it near", and "push it to the left".

use super::super::speaking::cm;
use super::super::{Conversation, Held};
use super::{Act, Acted, Answer, RequestKind};
use crate::interaction::conversation::grammar::{Aside, Request};
use crate::interaction::tasks::{Spot, tried};
use crate::interaction::things::KnownThing;

/// How high one hand raises it, metres.
const HEIGHT: f64 = 0.1;
/// How often both hands may begin again.
const CORRECTIONS: usize = 3;
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

pub(super) const LIFT: RequestKind = RequestKind::of_body(
    ["pick it up", "picked it up"],
    Act::Handles(Conversation::lift),
    "told: LIFT|GRAB|get ?UP THING|SOME; LIFT ?UP ?BIT $; get|have|keep|lay|GRAB ?GOOD ?firm|tight GRAB ?ON|of|OF \
     THING|SOME; PUT|PUSH|take|get|PULL|hold THING|SOME ?BIT UP|off & !to; THING ?UP off|from the TABLE; \
     PUT|PUSH|get|GRAB THING ?UP off|from ?that TABLE; into|in|to|the|mid air; give THING lift; get|have|take \
     hold|grip; LIFT HAND; carry|hold THING; THING in the air; THING off|from TABLE; hold on to THING; UP|off \
     ?TABLE|ground with THING",
);

pub(super) const LET_GO: RequestKind = RequestKind::new(
    ["let go", "let go"],
    Act::Moves(|creature, _, _| creature.release()),
    "told: LET ?THING|SOME go|fall|off|slip|DROP; DROP THING|SOME; ^ DROP $; leave go; leave THING there; leave \
     THING ON TABLE; PUT|lower DOWN|BACK THING|SOME; PUT|lower|sit THING|SOME ?BACK ?down ON ?top ?of \
     THING|SOME|TABLE; open|loosen|relax|unclench|ease|lose|release|give|let ?up ?go ?of ?your GRAB|fist|fingers \
     ?grip|hold; PUT DOWN $; let THING be|stay|stand; ^ DOWN with THING; return THING to THING|the ?TABLE|place; \
     PUT|give|return THING BACK ?where|there|ON|again; HAND HELPING GO off; ON|back TABLE with THING; open ?up \
     ?your HAND; THING BACK ON TABLE; take|get|PULL|remove|move|withdraw ?away|off|back HAND ?away|off|back \
     from|off ?of THING; lower THING|SOME; PUT .. THING|SOME .. down; have|want|need|like THING BACK|DOWN; denied: \
     STOP =holding|=gripping|=grasping|=grabbing|=carrying; not|longer hold|keep THING ?any; not .. GRAB .. \
     longer|more|anymore",
);

pub(super) const PUT_FAR: RequestKind = RequestKind::of_body(
    ["put it far away", "put it far away"],
    Act::Handles(|creature, thing, request| creature.put(Goal::Far, thing, request)),
    "told: PUT|PUSH|take|keep|PULL|give|have|want|like|make|want|GO THING|SOME .. FAR; PUT|PUSH|PULL|take|get \
     THING|SOME ?UPRIGHT|right|well off|out|over|across; PUT|PUSH|take|get|REACH|hold .. \
     arms|BODY|full|at|arm|maximum|max|maximal|your LENGTH|range; get|be|make ?yourself rid of; \
     increase|widen|maximise|maximize|extend|lengthen ?its|THING GAP; PUSH THING|SOME; give THING ?BIT ?GOOD PUSH; \
     ^ ?as FAR ?away|off as ..; ^ ?BIT FARTHER; MORE GAP between|from; make|LET THING ?be|GO|stand ?MORE FAR; \
     THING at a distance; PUT|leave|get|have ?as ?much|MORE|some space|room|distance as|between; PUT|PUSH|take \
     THING ON ?far other|far|opposite|back end|side|edge|of|part; THING as FAR as|possible; \
     PUT|PUSH|PULL|take|keep|make|give|want|need|like|prefer|have|GO & THING|SOME & FAR & !NEAR|too|or|how; THING \
     at|on|to ?its FAR|back|other|maximum|greatest end|edge|side|back|GAP|place; make|clear room|space; THING .. \
     FAR ?away|off & !be|how|where|which|NEAR|too; ^ WANTED .. FAR & THING & !too|how|NEAR|or; FAR ?ANY with THING",
);

pub(super) const BRING_NEAR: RequestKind = RequestKind::of_body(
    ["bring it near", "brought it near"],
    Act::Handles(|creature, thing, request| creature.put(Goal::Near, thing, request)),
    "said: ^ NEAR $; told: PULL ?THING|SOME ?BIT NEAR & !FAR; PULL ?me THING|SOME & !FAR|UP; \
     PUT|PUSH|PULL|take|get|make THING|SOME .. ?right|over|up|back ?close|near ON|by|near|beside|next|before|into \
     ?in ?front ?of ?your|to you|me|yourself|PART|here|body|lap & !FAR; THING ?to ?could|should|must ?to =be|GO \
     ?BIT ?MORE NEAR; ^ ?BIT ?MORE =closer|=nearer ?please $; \
     reduce|decrease|shorten|close|narrow|minimise|minimize|shrink|lessen|cut ?its|your GAP; ^ PULL $; ^ ?over \
     here $; THING right in front of you|yourself|BODY; \
     PUT|PUSH|PULL|take|keep|make|give|want|need|like|prefer|have|GO & THING|SOME & NEAR & !FAR|too|or|how; \
     PUT|PUSH|PULL|take|get|want|need|like|have|GIVE THING|SOME .. ON|next|before|beside|by|near ?to \
     you|yourself|me; THING ?right next|beside|before|by ?to you|yourself|me|PART; PUT|PUSH|PULL THING .. \
     your|this way|direction; ^ WANTED .. NEAR & THING & !too|how|FAR|or; NEAR with THING; ^ in front of BODY|you \
     $",
);

pub(super) const PUT_ASIDE: RequestKind = RequestKind::of_body(
    ["move it to the side", "moved it to the side"],
    Act::Handles(|creature, thing, request| match request.aside {
        Some(aside) => creature.put(Goal::Aside(aside), thing, request),
        None => Ok(Answer::failed("I do not know to which side I should move it")),
    }),
    "told: VERB .. SIDE; PUSH|PUT & THING|SOME & SIDE",
);

/// Where a thing is to be put.
#[derive(Clone, Copy)]
enum Goal {
    Far,
    Near,
    Aside(Aside),
}

impl Conversation {
    fn lift(&mut self, thing: &KnownThing, request: &Request) -> Acted {
        match (&self.holding, request.hand) {
            (Some(held), _) => {
                let with = match held {
                    Held::Stuck { receptor, .. } => self.limb_in_words(*receptor),
                    Held::Palms(_) => "hands".to_string(),
                };
                Ok(Answer::done(format!("I am already holding it, with my {with}")))
            }
            (None, None) => self.lift_with_both(thing),
            (None, hand) => self.lift_with_one(thing, self.hand_for(hand), request.lean),
        }
    }

    /// Between both palms, by friction.
    fn lift_with_both(&mut self, thing: &KnownThing) -> Acted {
        if let Some(known) = self.mind.things.get_mut(thing.id) {
            known.in_touch = None;
        }
        if thing.in_touch.is_none() {
            self.let_be();
            self.settle();
        }
        match self.actor.lift(&thing.found, CORRECTIONS) {
            Ok(grip) => {
                self.holding = Some(Held::Palms(Box::new(grip)));
                Ok(Answer::done("I picked it up between my hands and am squeezing it"))
            }
            Err(trouble) => {
                self.settle();
                let said = "I tried to take it between my hands but am not holding it, and it may have moved";
                Err(self.hindered(said, trouble))
            }
        }
    }

    /// With the hand that was named, by a weld.
    fn lift_with_one(&mut self, thing: &KnownThing, hand: Option<usize>, lean: bool) -> Acted {
        let receptor = self.in_hand(thing, hand, lean)?;
        let name = self.limb_in_words(receptor);
        match self.actor.raise(receptor, HEIGHT) {
            Ok(raised) => {
                self.holding = Some(Held::Stuck { receptor, raised });
                let said = format!("I picked it up with my {name}, which it sticks to");
                Ok(Answer::done(format!("{said}, and am holding it {} higher than it stood", cm(raised))))
            }
            Err(trouble) => {
                self.actor.let_go();
                Err(self.hindered(&format!("I am touching it with my {name}, but cannot raise it"), trouble))
            }
        }
    }

    /// Lets go of what it holds, and takes its hand back from it.
    fn release(&mut self) -> Acted {
        let touching = self.mind.things.iter().any(|known| known.in_touch.is_some());
        let said = match (self.holding.take(), self.actor.stick().is_some()) {
            (Some(held), _) => {
                let (name, lowered) = self.put_down(held)?;
                self.actor.let_go();
                self.actor.wait(0.2)?;
                let put = if lowered { "put it down and " } else { "" };
                format!("I {put}let go of it with my {name}")
            }
            // The stick is all that it holds: it is meant.
            (None, true) if !touching => return self.give_stick_back(),
            (None, stick) => {
                self.actor.let_go();
                let but = if stick { " but the stick" } else { "" };
                let back = if touching { ", and withdrew my hand from what I touched" } else { "" };
                format!("I am not holding anything{but}{back}")
            }
        };
        self.let_be();
        Ok(Answer::done(said))
    }

    fn put(&mut self, goal: Goal, thing: &KnownThing, request: &Request) -> Acted {
        let lean = request.lean;
        let receptor = self.in_hand(thing, self.hand_for(request.hand), lean)?;
        if matches!(goal, Goal::Far) && lean {
            // Where the other arm cannot make way, what is left is found all the same.
            tried(self.actor.make_way_to_lean(receptor, EFFORT))?;
        }
        // What was searched is no longer so.
        self.search = None;
        let point = self.actor.feels_at(receptor).0;
        let Some(spot) = self.spot_for(goal, receptor, lean) else {
            self.actor.let_go();
            return Ok(Answer::failed("I find no place for it within my reach"));
        };
        let stands = self.actor.put(receptor, &spot, lean).map_err(|trouble| {
            self.actor.let_go();
            self.hindered("I held it, but did not get it there", trouble)
        })?;
        let moved = stands - point;
        if let Some(known) = self.mind.things.get_mut(thing.id) {
            known.carried(&moved);
        }
        let at = self.mind.things.get(thing.id).map_or(stands, |known| known.at);
        let rest = if self.settle() { "" } else { "; my hand is still there" };
        let how = if lean { "I leaned forward and" } else { "I" };
        let done = match goal {
            Goal::Far => "put it as far away as I could".to_string(),
            Goal::Near => "put it near me".to_string(),
            Goal::Aside(aside) => {
                let (side, left) = (if aside.left { "left" } else { "right" }, moved.dot(&self.actor.left()));
                format!("moved it {} to my {side}", cm(if aside.left { left } else { -left }))
            }
        };
        Ok(Answer::done(format!("{how} {done}: it is {} now{rest}", self.place(&at))))
    }

    /// Where what a receptor holds is to be put.
    fn spot_for(&mut self, goal: Goal, receptor: usize, lean: bool) -> Option<Spot> {
        let actor = &mut self.actor;
        let (point, (front, left, up)) = (actor.feels_at(receptor).0, (actor.front, actor.left(), actor.up));
        let height = point.dot(&up);
        match goal {
            Goal::Far => actor.farthest(receptor, height, actor.upright(receptor).direction, lean, EFFORT),
            Goal::Near => {
                let edge = actor.trunk_front(actor.table.unwrap_or(height));
                let side = actor.arm_of(receptor).map_or(0.0, |hand| actor.side(hand));
                let near = |k: u32| front * (edge + NEAR + STEP * f64::from(k)) + up * height;
                let places = (0..STEPS).flat_map(|k| ACROSS.map(|by| near(k) + left * (side * by)));
                actor.spot_at(receptor, places)
            }
            Goal::Aside(aside) => {
                let way = if aside.left { left } else { -left };
                let far = aside.by.unwrap_or(ASIDE);
                // What is too far is left out, as long as anything of it is left.
                let shorter = (0..STEPS).map(|k| far * (1.0 - f64::from(k) / f64::from(STEPS)));
                actor.spot_at(receptor, shorter.map(|far| point + way * far))
            }
        }
    }
}
