//! Avoiding: what comes near is followed by the aura, and the limb that it would meet moves out of its way.
//!
//! All is told in the root's frame by the schema, so that moving limbs do not disturb what is seen of the thing. How large
//! it is nobody tells: only the point of it that is nearest is known, and that it went straight so far.
//!
//! Long for its constants, each of which says what it is.

mod seen_thing;

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use self::seen_thing::{SeenThing, ThingCourse};
use super::actor::Actor;
use crate::creature::Posture;
use crate::geometry::Frame;
use crate::kinematics::{Facing, InverseKinematics, Place};
use crate::peripersonal::{CollisionChecker, Obstacle, OwnBody, distance};
use crate::senses::{Approach, LOOK_PERIOD, SkinContact};
use crate::simulation::EngineResult;

/// The fastest that a joint turns when it gets out of the way, radians a second.
pub const QUICK: f64 = 3.0;
/// What comes this near to the middle of its way is surely met, metres.
const CORE: f64 = 0.02;
/// How far ahead a way is predicted, seconds, and at least, metres.
const AHEAD: f64 = 1.4;
/// How far limbs are to be from the way, metres, …
const WANTED: f64 = 0.03;
/// … when others are to help, and when a plan is made anew.
const ENOUGH: f64 = 0.005;
const KEEP: f64 = 0.012;
/// How far limbs stay from each other, metres.
const MARGIN: f64 = 0.01;
/// How often a plan is made anew at most, seconds.
const PATIENCE: f64 = 0.04;
/// Radii, radians, and how many random postures are drawn within each.
const RADII: [f64; 5] = [0.15, 0.3, 0.6, 1.1, 1.8];
const DRAWS: usize = 40;
/// Candidates whose ways are looked at.
const CANDIDATES: usize = 16;
/// Steps that better the best posture where none is good enough.
const BETTERED: usize = 200;
/// The farthest that a joint goes between two postures that are looked at, radians.
const FINE: f64 = 0.08;

/// Joints that move together to get out of the way.
struct Group {
    /// Whether a limb moves with them.
    carried: Vec<bool>,
    /// All but the things that move.
    clearance: CollisionChecker,
}

/// Where it goes to get out of the way.
struct Escape {
    posture: Posture,
    group: Vec<usize>,
    gap: f64,
}

/// A creature that watches what comes near, step by step.
pub struct Avoiding {
    tracks: BTreeMap<usize, SeenThing>,
    groups: BTreeMap<Vec<usize>, Group>,
    escape: Option<Escape>,
    /// When the aura looks again, and from when on a plan may be made anew, seconds.
    next: f64,
    again: f64,
    /// How often it planned.
    pub plans: usize,
    rng: ChaCha8Rng,
}

impl Group {
    fn new(own: &OwnBody, clearance: &CollisionChecker, joints: &[usize]) -> Group {
        Group { carried: own.moved_by(joints), clearance: clearance.moved_by(own, joints) }
    }

    /// How far the limbs that move are from an obstacle, up to `below`, metres.
    fn gap(&self, clearance: &CollisionChecker, frames: &[Frame], obstacle: &Obstacle, below: f64) -> f64 {
        let limbs = (0..self.carried.len()).filter(|&limb| self.carried[limb]);
        limbs.fold(below, |least, limb| least.min(clearance.to_obstacle(frames, limb, obstacle, least)))
    }

    /// How far they are from a thing on the straight way to a posture and from all of its course once there, up to
    /// [`WANTED`], metres; none where they would meet each other or what else is known to be there.
    fn way(
        &self,
        own: &OwnBody,
        clearance: &CollisionChecker,
        [from, to]: [&[f64]; 2],
        course: &ThingCourse,
    ) -> Option<f64> {
        let far = distance(from, to);
        let steps = (far / FINE).ceil().max(1.0) as usize;
        let seconds = far / QUICK;
        let mut least = WANTED;
        for k in (1..=steps).rev() {
            let share = k as f64 / steps as f64;
            let frames = own.frames(&Posture::between(own.creature(), from, to, share));
            if !clearance.free(&frames, MARGIN) {
                return None;
            }
            let at = seconds * share;
            let until = if k == steps { course.ahead().max(at) } else { at + seconds / steps as f64 };
            let there = course.swept(at - 0.5 * seconds / steps as f64, until, course.radius);
            least = self.gap(clearance, &frames, &there, least);
        }
        Some(least)
    }
}

impl Avoiding {
    /// A creature that watches from now on.
    pub fn new(actor: &mut Actor) -> Avoiding {
        actor.handle.watch_out();
        Avoiding {
            tracks: BTreeMap::new(),
            groups: BTreeMap::new(),
            escape: None,
            next: f64::NEG_INFINITY,
            again: f64::NEG_INFINITY,
            plans: 0,
            rng: ChaCha8Rng::seed_from_u64(actor.seed),
        }
    }

    /// Goes on by one step, out of the way of what comes near, and tells what is felt.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn step(&mut self, actor: &mut Actor) -> EngineResult<Vec<SkinContact>> {
        let from = actor.posture();
        let target = match &self.escape {
            None => from.clone(),
            Some(escape) => {
                let far = distance(&from, &escape.posture);
                let share = (QUICK * actor.handle.timestep() / far.max(f64::MIN_POSITIVE)).min(1.0);
                Posture::between(actor.own.creature(), &from, &escape.posture, share)
            }
        };
        let felt = actor.handle.step(&target)?;
        let time = actor.handle.time();
        if time >= self.next {
            self.next = time + LOOK_PERIOD - 1e-9;
            let frames = actor.frames();
            let seen = actor.handle.approaches();
            self.tracks.retain(|object, _| seen.iter().any(|approach| approach.object == *object));
            for approach in &seen {
                let frame = &frames[approach.limb];
                let toward = frame.rotation * approach.toward;
                let nearest = frame.point(&approach.point) + toward * approach.distance;
                self.tracks.entry(approach.object).or_default().look(time, nearest, toward);
                self.heed(actor, approach, time);
            }
            if seen.is_empty() {
                self.escape = None;
            }
        }
        Ok(felt)
    }

    /// Plans a way out where one is needed.
    fn heed(&mut self, actor: &Actor, approach: &Approach, time: f64) {
        let Some(course) = self.tracks.get(&approach.object).and_then(SeenThing::course) else { return };
        if time < self.again {
            return;
        }
        let now = actor.posture();
        let tiers = match self.escape.take() {
            Some(escape) => {
                let group = self.group(actor, &escape.group);
                let eased = group.eased(&actor.own, &now);
                let gap = group.way(&actor.own, &eased, [&now, &escape.posture], &course);
                let threatened = predicted(actor, approach, &course, &now);
                let other = threatened.filter(|(limb, _)| !group.carried[*limb]);
                let kept = gap.is_some_and(|gap| gap >= KEEP.min(escape.gap - 0.004));
                let joints = escape.group.clone();
                self.escape = Some(escape);
                match other {
                    Some((limb, place)) => Some((tiers(actor, limb), place)),
                    None if kept => None,
                    None => Some((vec![joints], threatened.and_then(|(_, place)| place))),
                }
            }
            None => {
                predicted(actor, approach, &course, &now).map(|(limb, place)| (tiers(actor, limb), place))
            }
        };
        let Some((tiers, place)) = tiers else { return };
        self.again = time + PATIENCE;
        let base = self.escape.as_ref().map_or(now.clone(), |escape| escape.posture.clone());
        let mut best: Option<Escape> = None;
        for joints in tiers {
            self.plans += 1;
            let found = self.plan(actor, &joints, [&now, &base], &course, place);
            if let Some((posture, gap)) = found
                && best.as_ref().is_none_or(|best| gap > best.gap + 1e-3)
            {
                // What moved before goes on to where it went.
                let before = self.escape.iter().flat_map(|escape| escape.group.clone());
                let mut group: Vec<usize> = joints.iter().copied().chain(before).collect();
                group.sort_unstable();
                group.dedup();
                best = Some(Escape { posture, group, gap });
            }
            if best.as_ref().is_some_and(|best| best.gap >= ENOUGH) {
                break;
            }
        }
        if best.is_some() {
            self.escape = best;
        }
    }

    fn group(&mut self, actor: &Actor, joints: &[usize]) -> &Group {
        let new = || Group::new(&actor.own, &actor.clearance, joints);
        self.groups.entry(joints.to_vec()).or_insert_with(new)
    }

    /// A posture that some joints can go straight to so that nothing is met, as near as there is, and how far it keeps
    /// from the course; the one that keeps farthest where none keeps clear. Other joints go to where they are in `base`.
    fn plan(
        &mut self,
        actor: &Actor,
        joints: &[usize],
        [now, base]: [&[f64]; 2],
        course: &ThingCourse,
        place: Option<Place>,
    ) -> Option<(Posture, f64)> {
        let mut rng = self.rng.clone();
        let own = &actor.own;
        let group = self.group(actor, joints);
        let eased = group.eased(own, now);
        // These joints begin from where they are.
        let mut start = Posture::from(base);
        for &joint in joints {
            let q = own.creature().joints()[joint].coordinates();
            start[q.clone()].copy_from_slice(&now[q]);
        }
        let mut postures = vec![start.clone()];
        if *base != *start {
            postures.push(Posture::from(base));
        }
        postures.extend(pushes(own, joints, &start, course, place));
        for radius in RADII {
            postures.extend((0..DRAWS).map(|_| nudged(own, joints, &start, radius, &mut rng)));
        }
        let clear = |posture: &[f64], enough: f64| {
            let frames = own.frames(posture);
            let seconds = distance(now, posture) / QUICK;
            let there = course.swept(seconds, course.ahead().max(seconds), course.radius);
            let gap = group.gap(&eased, &frames, &there, WANTED);
            (gap > enough && eased.free(&frames, MARGIN)).then_some(gap)
        };
        let mut rated: Vec<(f64, f64, Posture)> = Vec::new();
        for posture in postures {
            if let Some(gap) = clear(&posture, f64::NEG_INFINITY) {
                rated.push((gap, distance(now, &posture), posture));
            }
        }
        let better =
            |a: &(f64, f64, Posture), b: &(f64, f64, Posture)| b.0.total_cmp(&a.0).then(a.1.total_cmp(&b.1));
        rated.sort_by(better);
        if let Some((mut gap, _, mut posture)) = rated.first().cloned().filter(|best| best.0 < WANTED) {
            for k in 0..BETTERED {
                let radius = 0.5 * 0.985_f64.powi(k as i32);
                let trial = nudged(own, joints, &posture, radius, &mut rng);
                if let Some(found) = clear(&trial, gap) {
                    (gap, posture) = (found, trial);
                    rated.push((gap, distance(now, &posture), posture.clone()));
                    if gap >= WANTED {
                        break;
                    }
                }
            }
            rated.sort_by(better);
        }
        let mut best: Option<(Posture, f64)> = None;
        for (gap, _, posture) in rated.into_iter().take(CANDIDATES) {
            if best.as_ref().is_some_and(|best| gap <= best.1) {
                break;
            }
            let Some(gap) = group.way(own, &eased, [now, &posture], course) else { continue };
            if best.as_ref().is_none_or(|best| gap > best.1) {
                best = Some((posture, gap));
            }
            if gap >= WANTED {
                break;
            }
        }
        self.rng = rng;
        best
    }
}

impl Group {
    /// Its clearance where what is near now need not be farther away.
    fn eased(&self, own: &OwnBody, now: &[f64]) -> CollisionChecker {
        self.clearance.eased_at(&[own.frames(now)], MARGIN)
    }
}

/// The limb that a thing is going to meet first, and where on it where that is known.
fn predicted(
    actor: &Actor,
    approach: &Approach,
    course: &ThingCourse,
    now: &[f64],
) -> Option<(usize, Option<Place>)> {
    if let Some(contact) = &approach.contact {
        let place = contact.receptors.first().map(|&receptor| actor.own.place(receptor));
        return Some((contact.limb, place));
    }
    // Farther ahead than the aura predicts.
    const STEP: f64 = 0.1;
    let frames = actor.own.frames(now);
    let steps = (AHEAD / STEP) as usize;
    (0..steps).find_map(|k| {
        let from = STEP * k as f64;
        let there = course.swept(from, from + STEP, CORE);
        let met = |limb: &usize| actor.clearance.to_obstacle(&frames, *limb, &there, CORE) < 0.0;
        (0..frames.len()).find(met).map(|limb| (limb, None))
    })
}

/// The joints that can take a limb out of the way: those that move few others first.
fn tiers(actor: &Actor, limb: usize) -> Vec<Vec<usize>> {
    let own = &actor.own;
    let arm = actor.hands.iter().find(|hand| own.carried_by(hand.arm[0] + 1)[limb]);
    let mut tiers = match arm {
        Some(hand) => vec![hand.arm.clone(), hand.leaning.clone()],
        None => {
            let hands = actor.hands.each_ref().map(|hand| hand.limb);
            vec![own.joints_of(limb, &hands), own.joints_to(limb)]
        }
    };
    tiers.retain(|joints| !joints.is_empty());
    tiers.dedup();
    tiers
}

/// Postures in which a place of the body is pushed off the way of a thing, in several directions and by several lengths.
fn pushes(
    own: &OwnBody,
    joints: &[usize],
    start: &[f64],
    course: &ThingCourse,
    place: Option<Place>,
) -> Vec<Posture> {
    let Some(place) = place else { return Vec::new() };
    let place = Place { direction: Vector3::zeros(), ..place };
    let here = own.frames(start)[place.limb].point(&place.point);
    let Some(along) = course.velocity.try_normalize(1e-6) else { return Vec::new() };
    let passed = course.middle + along * (here - course.middle).dot(&along);
    let any = if along.x.abs() < 0.8 { Vector3::x() } else { Vector3::y() };
    let aside = (here - passed).try_normalize(1e-4).unwrap_or_else(|| along.cross(&any).normalize());
    let other = along.cross(&aside);
    let mut postures = Vec::new();
    for length in [0.04, 0.12, 0.25] {
        for k in 0..8 {
            let angle = TAU * f64::from(k) / 8.0;
            let point =
                passed + (aside * angle.cos() + other * angle.sin()) * (course.radius + WANTED + length);
            let target = Place { limb: 0, point, direction: Vector3::zeros() };
            let mut solver = InverseKinematics::new(own.creature(), &own.schema, [place, target])
                .with_facing(Facing::Parallel)
                .moving(|joint| joints.contains(&joint))
                .at_ease(start);
            postures.push(solver.solve(start).posture);
        }
    }
    postures
}

/// A posture that differs in some joints by at most `radius`, radians.
fn nudged(own: &OwnBody, joints: &[usize], from: &[f64], radius: f64, rng: &mut ChaCha8Rng) -> Posture {
    let mut posture = Posture::from(from);
    for &joint in joints {
        let joint = &own.creature().joints()[joint];
        for at in joint.elements().filter(|at| !at.is_ball() && at.follows.is_none()) {
            let ([low, high], q) = (at.range, at.coordinate());
            if high > low {
                posture[q] = (posture[q] + rng.random_range(-radius..radius)).clamp(low, high);
            }
        }
    }
    own.creature().couple(&mut posture);
    posture
}

impl Actor {
    /// Stays as it is for some time but for what has to get out of the way of things that come near; all that is felt.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn avoid(&mut self, avoiding: &mut Avoiding, seconds: f64) -> EngineResult<Vec<SkinContact>> {
        let steps = (seconds / self.handle.timestep()).ceil().max(1.0) as usize;
        let mut felt = Vec::new();
        for _ in 0..steps {
            felt.extend(avoiding.step(self)?);
        }
        Ok(felt)
    }
}
