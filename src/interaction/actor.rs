//! A creature that acts by its schema: it moves, feels, and stops at what it feels.
//!
//! All that it knows of its body is an [`OwnBody`]; all that it knows of the world it has felt. By its handle it has
//! its joint angles, its sense of balance, and what its receptors feel.

use std::collections::VecDeque;

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::stick::HeldStick;
use super::tasks::SearchPlan;
use crate::creature::{Creature, Posture};
use crate::error::{Error, Result};
use crate::geometry::Frame;
use crate::kinematics::Place;
use crate::peripersonal::{CollisionChecker, Obstacle, OwnBody, PosturePath, ReachPlan, Reaching, distance};
use crate::senses::{Balance, SkinContact, Toucher};
use crate::simulation::AgentHandle;

/// How fast the tips of the hands go where nothing is expected, metres a second …
pub const SWIFT: f64 = 0.6;
/// … and where something is.
pub const CAREFUL: f64 = 0.15;
/// The fastest that a joint turns, radians a second.
const FASTEST_JOINT: f64 = 2.0;
/// What is felt no farther than this from the top of the table, with skin that faces it, is the table, metres.
pub(super) const TABLE: f64 = 0.012;
/// Steps of the last motion that are remembered …
const TRAIL: usize = 1500;
/// … and from how many of them it is told which way skin goes.
const LATELY: usize = 15;
/// As many steps back skin has left what it has just met.
const PARTING: usize = 3;

/// A limb that acts.
#[derive(Clone, Debug, PartialEq)]
pub struct Hand {
    /// Its name.
    pub name: String,
    /// The limb.
    pub limb: usize,
    /// The joints that move it and no other hand: its arm's.
    pub arm: Vec<usize>,
    /// All joints that move it: its arm's and those of the trunk that carry it.
    pub leaning: Vec<usize>,
    /// Its receptors.
    pub receptors: Vec<usize>,
    /// The one farthest from its wrist.
    pub tip: usize,
}

impl Hand {
    /// The joints that move it: all of them where it may lean, else its arm's alone.
    pub fn joints(&self, lean: bool) -> &[usize] {
        if lean { &self.leaning } else { &self.arm }
    }
}

/// Something that was felt, and where that was.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundThing {
    /// The receptor that felt it.
    pub receptor: usize,
    /// The number of the thing.
    pub thing: usize,
    /// The posture in which it did.
    pub posture: Posture,
    /// Where that was in the root's frame, by the schema, metres.
    pub point: Vector3<f64>,
    /// The unit direction into the thing, in the root's frame.
    pub direction: Vector3<f64>,
    /// Whether its place is known so well that all of the thing is beyond the plane there.
    pub sharp: bool,
}

/// A creature that acts.
pub struct Actor {
    /// What it knows of its body.
    pub own: OwnBody,
    /// All that it has of where it is.
    pub(super) handle: AgentHandle,
    /// Its surfaces and what it knows to be about it, the table first once it has been felt.
    pub clearance: CollisionChecker,
    /// The limbs that act.
    pub hands: [Hand; 2],
    /// Against gravity, in the root's frame.
    pub up: Vector3<f64>,
    /// The horizontal direction that it faces, in the root's frame.
    pub front: Vector3<f64>,
    /// The height of the table's top along `up` in the root's frame, once it has been felt, metres.
    pub table: Option<f64>,
    /// Whether an arm that touches something feels on with small motions before the other hand comes to it.
    pub feels_on: bool,
    /// Contacts that no motion was meant to bring about.
    pub unintended: usize,
    /// Where it can feel the table, once it has worked that out: another of the same body at the same table may be given it.
    pub reach: Option<SearchPlan>,
    /// The postures for which the idle arm made way last, from which a search for the farthest begins as well.
    pub(super) made_way_for: Vec<Posture>,
    /// The stick that it holds.
    pub(super) stick: Option<HeldStick>,
    /// The receptors of his own skin that last touched where the schema did not have it, and how far apart it had them, metres.
    pub(super) unexpected: Option<([usize; 2], f64)>,
    /// The postures of the last motion, step by step.
    pub(super) trail: VecDeque<Posture>,
    /// Steps made along paths.
    pub(super) steps: usize,
    pub(super) seed: u64,
}

impl Actor {
    /// A creature on a stage that acts with two limbs, by their names, and faces along x of its root.
    ///
    /// # Errors
    /// If the creature on the stage is another than the one that learned, or the hands are not two limbs with skin that move apart.
    pub fn new(own: OwnBody, handle: AgentHandle, hands: [&str; 2], seed: u64) -> Result<Actor, Error> {
        let clearance = CollisionChecker::new(&own);
        Actor::with_clearance(own, clearance, handle, hands, seed)
    }

    /// The same with the clearance of the body, which takes a while to work out, at hand.
    ///
    /// # Errors
    /// As [`Actor::new`].
    pub fn with_clearance(
        own: OwnBody,
        clearance: CollisionChecker,
        handle: AgentHandle,
        hands: [&str; 2],
        seed: u64,
    ) -> Result<Actor, Error> {
        let known = (own.creature().limbs(), own.creature().joints().len(), own.creature().coordinates());
        let there = handle.agent().creature();
        if known != (there.limbs(), there.joints().len(), there.coordinates()) {
            let told = |creature: &Creature| (creature.name().to_string(), creature.joints().len());
            let [(known, joints), (there, others)] = [told(own.creature()), told(there)];
            return Err(Error::usage(format!(
                "the schema belongs to {known} with {joints} joints, but the scene has {there} with {others}: \
                 give the scene of the creature that learned it"
            )));
        }
        let skin = |skin: &crate::skin::Skin| {
            skin.receptors.iter().map(|receptor| receptor.id.clone()).collect::<Vec<_>>()
        };
        if skin(own.skin()) != skin(handle.agent().skin()) {
            let sentence =
                "the scene's creature has different receptors from the one that learned the schema";
            return Err(Error::usage(sentence));
        }
        let limb = |name: &str| {
            let limb = own.creature().limb(name);
            limb.ok_or_else(|| Error::usage(format!("no limb {name}: give two of {}", known.0.join(", "))))
        };
        let limbs = [limb(hands[0])?, limb(hands[1])?];
        let up = handle.sense(|balance: &mut Balance| balance.up);
        // A creature that lies has no front along x; any horizontal direction is as good.
        let level = |v: Vector3<f64>| (v - up * v.dot(&up)).try_normalize(1e-3);
        let front = level(Vector3::x()).or(level(Vector3::y())).unwrap_or_else(Vector3::x);
        let hand = |k: usize| {
            let (limb, other) = (limbs[k], limbs[1 - k]);
            let receptors = own.receptors_on(&own.hand_of(limb));
            let tip = own.from_tip(limb, &receptors).first().copied().ok_or_else(|| {
                Error::usage(format!("{} has no receptors: nothing can be felt with it", hands[k]))
            })?;
            let arm = own.joints_of(limb, &[other]);
            if arm.is_empty() {
                let [hand, other] = [hands[k], hands[1 - k]];
                return Err(Error::usage(format!("{hand} moves only with {other}: give two other limbs")));
            }
            let leaning = own.joints_to(limb);
            Ok(Hand { name: hands[k].to_string(), limb, arm, leaning, receptors, tip })
        };
        let hands = [hand(0)?, hand(1)?];
        let (table, unintended) = (None, 0);
        Ok(Actor {
            own,
            handle,
            clearance,
            hands,
            up,
            front,
            table,
            unintended,
            feels_on: false,
            reach: None,
            made_way_for: Vec::new(),
            unexpected: None,
            stick: None,
            trail: VecDeque::new(),
            steps: 0,
            seed,
        })
    }

    /// The posture that it feels itself in.
    pub fn posture(&self) -> Posture {
        self.handle.posture()
    }

    /// Its limbs' poses in the root's frame as the schema has them.
    pub fn frames(&self) -> Vec<Frame> {
        self.own.frames(&self.handle.posture())
    }

    /// A new random stream.
    pub(super) fn new_rng(&mut self) -> ChaCha8Rng {
        self.seed = self.seed.wrapping_add(1);
        ChaCha8Rng::seed_from_u64(self.seed)
    }

    /// Does something with obstacles beside those that are known.
    pub(super) fn with_obstacles<T>(
        &mut self,
        obstacles: impl IntoIterator<Item = Obstacle>,
        act: impl FnOnce(&mut Actor) -> T,
    ) -> T {
        let known = self.clearance.obstacles.len();
        self.clearance.obstacles.extend(obstacles);
        let done = act(self);
        self.clearance.obstacles.truncate(known);
        done
    }

    /// A body that reaches with some joints; a new random stream with each.
    pub fn reaching(&mut self, joints: Vec<usize>) -> Reaching<'_> {
        self.seed = self.seed.wrapping_add(1);
        Reaching::new(&self.own, &self.clearance, joints, self.seed)
    }

    /// On which arm a receptor is, by its hand: the arm that felt.
    pub fn arm_of(&self, receptor: usize) -> Option<usize> {
        self.arm_with(self.own.skin().receptors[receptor].limb)
    }

    /// Which arm a limb is part of, by its hand; `None` if it is of neither.
    pub(super) fn arm_with(&self, limb: usize) -> Option<usize> {
        self.hands.iter().position(|hand| self.own.carried_by(hand.arm[0] + 1)[limb])
    }

    /// The joints of both arms.
    pub fn arms(&self) -> Vec<usize> {
        self.hands.iter().flat_map(|hand| hand.arm.clone()).collect()
    }

    /// A point and the outward normal of a receptor in the root's frame, now and by the schema.
    pub fn feels_at(&self, receptor: usize) -> (Vector3<f64>, Vector3<f64>) {
        let place = self.own.place(receptor);
        let frame = self.frames()[place.limb];
        (frame.point(&place.point), frame.rotation * place.direction)
    }

    /// Whether what is felt is the table, as far as it is known where that is.
    pub fn is_table(&self, contact: &SkinContact) -> bool {
        let (point, normal) = self.feels_at(contact.spot.receptor);
        let down = normal.dot(&self.up) < -0.2;
        match (self.table, contact.by) {
            (Some(height), Toucher::Thing(_)) => down && (point.dot(&self.up) - height).abs() < TABLE,
            _ => false,
        }
    }

    /// Whether what is felt is a thing that is not the table, and not one's own skin.
    pub(super) fn is_thing(&self, contact: &SkinContact) -> bool {
        matches!(contact.by, Toucher::Thing(_)) && !self.is_table(contact)
    }

    /// Makes the table's height known: from its near side on nothing is to go below it.
    pub fn know_table(&mut self, height: f64) {
        self.table = Some(height);
        self.clearance.obstacles = self.table_plane().map(Obstacle::Table).into_iter().collect();
    }

    /// How far forward the trunk reaches at a height: no table is nearer than this, metres along `front`.
    pub fn trunk_front(&self, height: f64) -> f64 {
        let frames = self.own.frames(&self.own.at_ease());
        let trunk = self.own.skin().surfaces.iter().filter(|surface| self.arm_with(surface.limb).is_none());
        // What is far above or below has the table in front of it or over it.
        let front = trunk.filter_map(|surface| {
            let frame = &frames[surface.limb];
            let point = frame.point(&surface.support(&frame.rotation.tr_mul(&self.front))?);
            ((point.dot(&self.up) - height).abs() < 0.25).then_some(point.dot(&self.front))
        });
        front.fold(f64::NEG_INFINITY, f64::max).max(0.0)
    }

    /// Follows a path, the tips of the hands at most at `speed` metres a second, until skin feels something that the
    /// motion does not just part from and that is `heeded`. Returns the contacts that stopped it; none if it arrived.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn follow(
        &mut self,
        way: &PosturePath,
        speed: f64,
        heeded: impl Fn(&Actor, &SkinContact) -> bool,
    ) -> Result<Vec<SkinContact>> {
        let mut parting: Option<Vec<SkinContact>> = None;
        let step = self.handle.timestep();
        let tips = self.hands.iter().map(|hand| hand.tip).chain(self.stick_tip());
        let places: Vec<Place> = tips.map(|tip| self.own.place(tip)).collect();
        for target in &way.0 {
            let start = self.posture();
            let joints = distance(&start, target);
            let [from, to] = [&start, target].map(|posture| self.own.frames(posture));
            let way = |place: &Place| {
                (from[place.limb].point(&place.point) - to[place.limb].point(&place.point)).norm()
            };
            let tips = places.iter().map(way).fold(0.0, f64::max);
            let seconds = (joints / FASTEST_JOINT).max(tips / speed);
            let steps = (seconds / step).ceil().max(1.0) as usize;
            for k in 1..=steps {
                let posture = Posture::between(self.own.creature(), &start, target, k as f64 / steps as f64);
                let felt = self.step(&posture)?;
                self.trail.push_back(posture);
                self.steps += 1;
                if self.trail.len() > TRAIL {
                    self.trail.pop_front();
                }
                // What touches at the start is being left; once it is left it counts anew.
                let left = parting.get_or_insert_with(|| felt.clone());
                left.retain(|before| felt.iter().any(|now| now.has_parties_of(before)));
                let is_left = |now: &SkinContact| left.iter().any(|before| before.has_parties_of(now));
                let news: Vec<SkinContact> =
                    felt.iter().copied().filter(|now| !is_left(now) && heeded(self, now)).collect();
                if !news.is_empty() {
                    self.heed_own_touch(&news);
                    return Ok(news);
                }
            }
        }
        Ok(Vec::new())
    }

    /// Follows the path of a plan, then goes straight on, until skin feels something; see [`Actor::follow`]. Contact may
    /// come sooner than planned: a thing can be larger than the room that it was given.
    pub(super) fn approach(&mut self, plan: &ReachPlan) -> Result<Vec<SkinContact>> {
        let felt = self.follow(&plan.way, SWIFT, |_, _| true)?;
        if felt.is_empty() { self.follow(&plan.straight, CAREFUL, |_, _| true) } else { Ok(felt) }
    }

    /// Has been put into a posture by a partner: nothing is remembered of how it came there.
    pub fn was_placed(&mut self) {
        self.trail.clear();
    }

    /// The postures that it went through since it had made so many steps, as far as it remembers them, the latest first.
    pub(super) fn lately(&self, since: usize) -> impl Iterator<Item = &Posture> {
        self.trail.iter().rev().take(self.steps - since)
    }

    /// Goes on by one step, at whose end it is in a posture, and tells what touches it.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn step(&mut self, towards: &[f64]) -> Result<Vec<SkinContact>> {
        let felt = self.handle.step(towards)?;
        Ok(self.understood(felt))
    }

    /// Holds what the limb of a receptor touches by a weld, until it is let go; whether there was something that can be held.
    pub fn hold(&mut self, receptor: usize) -> bool {
        // What a stick touches cannot be held by it.
        self.stick_tip() != Some(receptor) && self.handle.hold(receptor)
    }

    /// Lets go of all that it holds.
    pub fn let_go(&mut self) {
        self.handle.let_go();
    }

    /// Stays as it is for some time.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn wait(&mut self, seconds: f64) -> Result<Vec<SkinContact>> {
        let posture = self.posture();
        let steps = (seconds / self.handle.timestep()).ceil().max(1.0) as usize;
        let mut felt = Vec::new();
        for _ in 0..steps {
            felt = self.step(&posture)?;
        }
        Ok(felt)
    }

    /// What a contact of a thing tells, in the present posture; `None` if it is one's own skin.
    pub fn found(&self, contact: &SkinContact) -> Option<FoundThing> {
        let Toucher::Thing(thing) = contact.by else { return None };
        let receptor = contact.spot.receptor;
        let limb = self.own.skin().receptors[receptor].limb;
        let frame = self.frames()[limb];
        let place = self.own.place(receptor);
        let before = self.trail.len().checked_sub(LATELY).map(|k| self.own.frames(&self.trail[k])[limb]);
        let moved = before.map(|before| frame.point(&place.point) - before.point(&place.point));
        let place = match moved.and_then(|moved| moved.try_normalize(1e-4)) {
            Some(ahead) => self.own.leading(receptor, &frame.rotation.tr_mul(&ahead)),
            None => place,
        };
        let (point, direction) = (frame.point(&place.point), frame.rotation * place.direction);
        Some(FoundThing { receptor, thing, posture: self.posture(), point, direction, sharp: false })
    }

    /// The place of the skin that felt something.
    pub fn felt_with(&self, found: &FoundThing) -> Place {
        let place = self.own.place(found.receptor);
        let frame = self.own.frames(&found.posture)[place.limb];
        self.own.on_surface(found.receptor, &frame.inverse_point(&found.point)).unwrap_or(place)
    }

    /// The way back on which the skin of a receptor came here, `far` metres of it; `None` if it has not moved.
    pub fn back_by(&self, receptor: usize, far: f64) -> Option<PosturePath> {
        let place = self.own.place(receptor);
        let at = |posture: &[f64]| self.own.frames(posture)[place.limb].point(&place.point);
        let here = at(self.trail.back()?);
        let mut way = Vec::new();
        // Not where it is: for a step more what it touches would be pushed.
        for posture in self.trail.iter().rev().skip(PARTING).step_by(5) {
            way.push(posture.clone());
            if (at(posture) - here).norm() > far {
                return Some(PosturePath(way));
            }
        }
        (way.len() > 2).then_some(PosturePath(way))
    }
}
