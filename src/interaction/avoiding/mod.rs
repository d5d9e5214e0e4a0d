//! Avoiding: what comes near is followed by the aura, and limbs that it would meet move out of its way while a place of the
//! body goes on where it is to go.
//!
//! All is told in the root's frame by the schema, so that moving limbs do not disturb what is seen of the thing. How large
//! it is nobody tells: only the point of it that is nearest is known, how fast it comes nearer there, and that it went
//! straight so far.
//!
//! ```text
//! aura ─ seen_thing ─ course ─ escape    a posture out of its way, found by search: on which side of it limbs pass
//!                        └──── keeping   joint velocities, step by step: there, where a place is to go, and clear of all
//! ```

mod escape;
mod keeping;
mod seen_thing;

use std::collections::BTreeMap;

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use self::escape::{Escape, Threat, eased, gap_on_way, threats, tiers};
use self::keeping::{Kept, kept};
use self::seen_thing::{Look, SeenThing, ThingCourse};
use super::actor::Actor;
use crate::error::Result;
use crate::geometry::Ball;
use crate::kinematics::Place;
use crate::peripersonal::{CollisionChecker, Obstacle};
use crate::senses::{Approach, Aura, SkinContact};

/// The fastest that a joint turns when it gets out of the way, radians a second.
pub const QUICK: f64 = 3.0;
/// How far limbs are to be from the way when a plan is made anew, metres.
const KEEP: f64 = 0.012;
/// How much worse than it was a plan may have become, metres.
const WORSE: f64 = 0.004;
/// How often a plan is made anew at most, seconds.
const PATIENCE: f64 = 0.04;
/// And after a search in vain, seconds.
const VAIN: f64 = 0.08;
/// A place whose goal is nearer than this to the way of a thing waits until it has passed, metres: a hand's length.
const WAITS: f64 = 0.12;

/// Where a place of the body is to be, and how fast that moves, in the root's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaceGoal {
    /// The place.
    pub place: Place,
    /// Where it is to be, metres.
    pub point: Vector3<f64>,
    /// How fast that moves, metres a second.
    pub velocity: Vector3<f64>,
}

impl PlaceGoal {
    /// The joints of the arm that has the place on its hand; `None` if it is on neither.
    fn arm<'a>(&self, actor: &'a Actor) -> Option<&'a [usize]> {
        let mut hands = actor.hands.iter();
        let holder = hands.find(|hand| actor.own.carried_by(hand.limb)[self.place.limb])?;
        Some(&holder.arm)
    }
}

/// A creature that watches what comes near, step by step.
pub struct Avoiding {
    /// What is to be done meanwhile, as far as nothing is in the way.
    pub goal: Option<PlaceGoal>,
    tracks: BTreeMap<usize, SeenThing>,
    /// What limbs that some joints move are to keep clear of, but the things that move.
    clearances: BTreeMap<Vec<usize>, CollisionChecker>,
    escape: Option<Escape>,
    /// What the last look told, and what is to be kept clear of until the next.
    seen: Vec<Approach>,
    kept: Vec<Kept>,
    /// The joints that take out of the way what comes nearest, where no plan says which.
    getting: Vec<usize>,
    /// From when on a plan may be made anew, seconds.
    again: f64,
    /// How often it planned.
    pub plans: usize,
    rng: ChaCha8Rng,
}

impl Avoiding {
    /// A creature that watches from now on.
    pub fn new(actor: &mut Actor) -> Avoiding {
        actor.handle.sense(Aura::watch_out);
        Avoiding {
            goal: None,
            tracks: BTreeMap::new(),
            clearances: BTreeMap::new(),
            escape: None,
            seen: Vec::new(),
            kept: Vec::new(),
            getting: Vec::new(),
            again: f64::NEG_INFINITY,
            plans: 0,
            rng: ChaCha8Rng::seed_from_u64(actor.seed),
        }
    }

    /// Goes on by one step, out of the way of what comes near, and tells what is felt.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn step(&mut self, actor: &mut Actor) -> Result<Vec<SkinContact>> {
        let now = actor.posture();
        let goal = self.goal.filter(|goal| !self.waits(goal));
        let target = self.towards(actor, &now, goal).unwrap_or(now);
        let felt = actor.step(&target)?;
        // A stick that he holds is near, and no threat.
        let held = actor.stick().map(|stick| stick.thing);
        let others = |approach: &&Approach| Some(approach.object) != held;
        let near = |aura: &mut Aura| aura.approaches().filter(others).cloned().collect::<Vec<_>>();
        let seen = actor.handle.sense(near);
        // Nothing new is told between two looks.
        if seen != self.seen {
            self.look(actor, &seen);
            self.seen = seen;
        }
        Ok(felt)
    }

    /// Takes in a look at all that is near.
    fn look(&mut self, actor: &Actor, seen: &[Approach]) {
        let time = actor.handle.time();
        let now = actor.posture();
        let frames = actor.own.frames(&now);
        self.tracks.retain(|object, _| seen.iter().any(|approach| approach.object == *object));
        for approach in seen {
            let frame = &frames[approach.limb];
            let toward = frame.rotation * approach.toward;
            let nearest = frame.point(&approach.point) + toward * approach.distance;
            let look = Look { time, nearest, toward, speed: approach.speed };
            self.tracks.entry(approach.object).or_default().look(look);
        }
        for approach in seen {
            self.heed(actor, approach, time);
        }
        if seen.is_empty() {
            self.escape = None;
        }
        let courses: Vec<ThingCourse> = self.tracks.values().filter_map(SeenThing::course).collect();
        let leaves_to = self.escape.as_ref().map(|escape| actor.own.moved_by(&escape.group));
        let nearest: Vec<Threat> =
            seen.iter().map(|approach| Threat { limb: approach.limb, place: None }).collect();
        self.getting = tiers(actor, &nearest).into_iter().next().unwrap_or_default();
        self.kept = kept(actor, &frames, seen, &courses, leaves_to.as_deref(), time);
    }

    /// Whether what is to be done had better wait until a thing has passed.
    fn waits(&self, goal: &PlaceGoal) -> bool {
        let suspended = self.escape.as_ref().is_some_and(|escape| !escape.keeps_goal);
        suspended
            && self.tracks.values().filter_map(SeenThing::course).any(|course| {
                let ahead = course.swept(0.0, course.ahead(), course.radius);
                let hand = Ball { centre: goal.point, radius: WAITS };
                matches!(ahead, Obstacle::Capsule(way) if way.distance_to(&hand) < 0.0)
            })
    }

    /// Plans a way out where one is needed.
    fn heed(&mut self, actor: &Actor, approach: &Approach, time: f64) {
        let Some(course) = self.tracks.get(&approach.object).and_then(SeenThing::course) else { return };
        if time < self.again {
            return;
        }
        let now = actor.posture();
        let mut threatened = threats(actor, approach, &course, &now);
        let mut before = Vec::new();
        // A plan is given up for one that is clearly better alone.
        let mut incumbent = f64::NEG_INFINITY;
        if let Some(escape) = self.escape.take() {
            before.clone_from(&escape.group);
            let clearance = self.clearance_of(actor, &escape.group);
            let others = threatened.iter().any(|threat| !clearance.is_exposed(threat.limb));
            let eased = eased(&actor.own, clearance, &now);
            let gap = gap_on_way(&actor.own, &eased, [&now, &escape.posture], &course);
            let holds = gap.is_some_and(|gap| gap >= KEEP.min(escape.gap - WORSE));
            threatened.extend(escape.threats.iter().copied().filter(|_| !holds));
            self.escape = Some(escape);
            if holds && !others {
                return;
            }
            if !others {
                incumbent = gap.unwrap_or(incumbent);
            }
        }
        if threatened.is_empty() {
            return;
        }
        self.again = time + PATIENCE;
        let base = self.escape.as_ref().map_or(now.clone(), |escape| escape.posture.clone());
        match self.way_out(actor, [&now, &base], &course, &threatened, &before) {
            Some(found) if found.gap > incumbent + WORSE => self.escape = Some(found),
            _ => self.again = time + VAIN,
        }
    }

    fn clearance_of(&mut self, actor: &Actor, joints: &[usize]) -> &CollisionChecker {
        let new = || actor.clearance.moved_by(&actor.own, joints);
        self.clearances.entry(joints.to_vec()).or_insert_with(new)
    }
}
