//! A creature's memory besides its body: the things it felt, what it did, what it must not do.

use nalgebra::Vector3;

use super::grammar::{PartName, Request, Which};
use super::requests::Intent;
use super::speaking::place_in_words;
use crate::interaction::actor::Actor;
use crate::interaction::things::{KnownThing, Things};

/// Something that it did, or tried to do.
pub(super) struct Deed {
    pub intent: Intent,
    /// Whether it came off.
    pub done: bool,
    /// Whether it touched a thing by it.
    pub touched: bool,
    /// What it was, as one who did it says it: `touched it with my left hand`.
    pub words: String,
}

/// All that a request may change that moves nothing.
#[derive(Default)]
pub(super) struct Mind {
    /// What it remembers of things, and which of them is meant.
    pub things: Things,
    pub deeds: Vec<Deed>,
    /// What it was told not to do, and to which part of its body.
    forbidden: Vec<(Intent, Option<PartName>)>,
    /// Whether it keeps still until it is asked for something.
    pub still: bool,
    /// Whether the conversation is over.
    pub over: bool,
}

impl Mind {
    /// Which of the things that are known words tell apart.
    pub fn find(&self, actor: &Actor, which: Option<Which>) -> Option<&KnownThing> {
        let (left, front, things) = (actor.left(), actor.front, &self.things);
        let most = |along: Vector3<f64>| things.most(|known| known.at.dot(&along));
        match which? {
            Which::Nth(at) => things.iter().nth(at),
            Which::Last => things.iter().next_back(),
            Which::Left => most(left),
            Which::Right => most(-left),
            Which::Nearest => most(-front),
            Which::Farthest => most(front),
            Which::Other => match (things.it(), things.len()) {
                (Some(it), 2) => things.iter().find(|known| known.id != it.id),
                _ => None,
            },
        }
    }

    /// Asks which of the things is meant.
    pub fn question(&self, actor: &Actor) -> String {
        let place = |known: &KnownThing| format!("the one {}", place_in_words(actor, &known.at));
        let places: Vec<String> = self.things.iter().map(place).collect();
        format!("I felt {} things: which one do you mean, {}?", places.len(), places.join(" or "))
    }

    /// From now on this is not done without being asked for it twice.
    pub fn forbid(&mut self, intent: Intent, part: Option<PartName>) {
        let forbidden = (intent, part);
        if !self.forbidden.contains(&forbidden) {
            self.forbidden.push(forbidden);
        }
    }

    /// Whether what a request asks for is forbidden, or the leaning that it takes.
    pub fn forbids(&self, request: &Request) -> bool {
        self.forbidden.iter().any(|told| bars(told, request))
    }

    /// What a request asks for is no longer forbidden.
    pub fn allow(&mut self, request: &Request) {
        self.forbidden.retain(|told| !bars(told, request));
    }
}

/// Whether what is forbidden bars a request: what cannot be done without a touch is, where touching is.
fn bars((told, part): &(Intent, Option<PartName>), request: &Request) -> bool {
    use Intent::{BringNear, FeelShape, LeanForward, Lift, PutAside, PutFar, Touch, TouchOwn};
    let same = match told {
        Touch => [Touch, PutFar, BringNear, PutAside, Lift, FeelShape].contains(&request.intent),
        // "Don't push it": whichever way.
        PutFar => [PutFar, PutAside].contains(&request.intent),
        TouchOwn => request.intent == TouchOwn && (part.is_none() || *part == request.part),
        told => *told == request.intent,
    };
    same || (*told == LeanForward && request.lean)
}
