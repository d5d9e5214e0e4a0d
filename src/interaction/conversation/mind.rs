//! What a creature keeps in mind beside its body: the things that it felt, what it did, what it is not to do.

use nalgebra::Vector3;

use super::grammar::{PartName, Request, Which};
use super::requests::Intent;
use crate::interaction::actor::Actor;
use crate::interaction::things::{KnownThing, ThingId, Things};

/// Places at which a thing was felt that are nearer than this to each other are one, metres: a small patch of skin.
const ONE_PLACE: f64 = 0.01;
/// Places so near to where a thing is taken to be are its own, metres.
const ITS_OWN: f64 = 0.15;

/// Something that it did, or tried to do.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Deed {
    pub intent: Intent,
    /// Whether it came off.
    pub done: bool,
    /// Whether it touched a thing by it.
    pub touched: bool,
    /// What it was, as one who did it says it: `touched it with my left hand`.
    pub words: String,
}

impl Deed {
    /// Whether a question about what is wanted is about this.
    pub fn is(&self, about: Intent) -> bool {
        self.intent == about || (about == Intent::Touch && self.touched)
    }
}

/// Something that it was told not to do.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Forbidden {
    intent: Intent,
    part: Option<PartName>,
}

impl Forbidden {
    /// Whether doing something is forbidden by it: what cannot be done without a touch is, where touching is.
    fn bars(&self, intent: Intent, part: Option<&PartName>) -> bool {
        use Intent::{BringNear, FeelShape, Lift, PutAside, PutFar, Touch};
        let by_touch = [Touch, PutFar, BringNear, PutAside, Lift, FeelShape].contains(&intent);
        // "Don't push it": whichever way.
        let pushed = self.intent == PutFar && intent == PutAside;
        let same = self.intent == intent || pushed || (self.intent == Touch && by_touch);
        let there = self.intent != Intent::TouchOwn || self.part.is_none() || self.part.as_ref() == part;
        same && there
    }

    /// Whether it forbids what a request asks for, or the leaning that it takes.
    pub fn bars_request(&self, request: &Request) -> bool {
        self.bars(request.intent, request.part.as_ref())
            || (request.lean && self.bars(Intent::LeanForward, None))
    }
}

/// All that a request may change that moves nothing.
pub(super) struct Mind<'a> {
    /// Who it is: to look at alone.
    pub actor: &'a Actor,
    pub things: &'a mut Things,
    pub forbidden: &'a mut Vec<Forbidden>,
    pub felt: &'a mut Vec<Vector3<f64>>,
    /// Whether it keeps still until it is asked for something.
    pub still: &'a mut bool,
    /// Whether the conversation is over.
    pub over: &'a mut bool,
}

impl Mind<'_> {
    /// Where a thing is, in words.
    pub fn place(&self, known: &KnownThing) -> String {
        place_in_words(self.actor, &known.at)
    }

    /// Which thing is meant, where words tell it.
    pub fn find(&self, which: Option<Which>) -> Option<&KnownThing> {
        which.and_then(|which| find(self.actor, self.things, which))
    }

    /// Asks which.
    pub fn question(&self) -> String {
        question(self.actor, self.things)
    }

    /// Forgets a thing and where it was felt.
    pub fn forget(&mut self, id: ThingId) {
        if let Some(known) = self.things.get(id) {
            self.felt.retain(|place| (place - known.at).norm() > ITS_OWN);
            self.things.forget(id);
        }
    }

    /// Forgets all things.
    pub fn forget_all(&mut self) {
        self.felt.clear();
        self.things.forget_all();
    }

    /// From now on this is not done without being asked for it twice.
    pub fn forbid(&mut self, intent: Intent, part: Option<PartName>) {
        let forbidden = Forbidden { intent, part };
        if !self.forbidden.contains(&forbidden) {
            self.forbidden.push(forbidden);
        }
    }
}

/// Which of the things that are known words tell apart.
pub(super) fn find<'a>(actor: &Actor, things: &'a Things, which: Which) -> Option<&'a KnownThing> {
    let (left, front) = (actor.left(), actor.front);
    let most = |value: &dyn Fn(&KnownThing) -> f64| things.most(value);
    let nth = |n: usize| things.iter().nth(n);
    match which {
        Which::First => nth(0),
        Which::Second => nth(1),
        Which::Third => nth(2),
        Which::Last => things.iter().next_back(),
        Which::Left => most(&|known| known.at.dot(&left)),
        Which::Right => most(&|known| -known.at.dot(&left)),
        Which::Nearest => most(&|known| -known.at.dot(&front)),
        Which::Farthest => most(&|known| known.at.dot(&front)),
        Which::Other => match (things.it(), things.len()) {
            (Some(it), 2) => things.iter().find(|known| known.id != it.id),
            _ => None,
        },
    }
}

/// Asks which of the things is meant.
pub(super) fn question(actor: &Actor, things: &Things) -> String {
    let places: Vec<String> =
        things.iter().map(|known| format!("the one {}", place_in_words(actor, &known.at))).collect();
    format!("I felt {} things: which one do you mean, {}?", places.len(), places.join(" or "))
}

/// Where a point of the root's frame is, in words.
pub(super) fn place_in_words(actor: &Actor, at: &Vector3<f64>) -> String {
    let side = match at.dot(&actor.left()) {
        x if x > 0.05 => format!("{:.0} cm to my left", 100.0 * x),
        x if x < -0.05 => format!("{:.0} cm to my right", -100.0 * x),
        _ => "straight ahead".into(),
    };
    format!("{:.0} cm in front of me, {side}", 100.0 * at.dot(&actor.front))
}

/// Remembers a place at which something was felt, where it is another than those before.
pub(super) fn felt_at(felt: &mut Vec<Vector3<f64>>, place: Vector3<f64>) {
    if felt.iter().all(|before| (before - place).norm() > ONE_PLACE) {
        felt.push(place);
    }
}

/// Those of some places that are a thing's, by where it is.
pub(super) fn places_of(felt: &[Vector3<f64>], at: &Vector3<f64>) -> Vec<Vector3<f64>> {
    felt.iter().filter(|place| (*place - at).norm() <= ITS_OWN).copied().collect()
}
