//! A posture out of the way of a thing, and a straight way to it: found by search, so that it does not matter on which side
//! of the thing a limb is at first.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

use super::seen_thing::{AHEAD, ThingCourse};
use super::{Avoiding, PlaceGoal, QUICK};
use crate::creature::Posture;
use crate::interaction::actor::Actor;
use crate::kinematics::Place;
use crate::peripersonal::{CollisionChecker, OwnBody, distance};
use crate::senses::Approach;

/// What comes this near to the middle of its way is surely met, metres.
const CORE: f64 = 0.02;
/// How far limbs are to be from the way, metres, …
const WANTED: f64 = 0.04;
/// … and when others are to help.
const ENOUGH: f64 = 0.012;
/// How far limbs stay from each other, metres.
const MARGIN: f64 = 0.01;
/// Radii, radians, and how many random postures are drawn within each.
const RADII: [f64; 5] = [0.15, 0.3, 0.6, 1.1, 1.8];
const DRAWS: usize = 40;
/// Candidates whose ways are looked at.
const CANDIDATES: usize = 16;
/// The best that are bettered where none is good enough, by so many steps each, of so many joints at most.
const BEST: usize = 6;
const BETTERED: usize = 160;
const TOGETHER: usize = 3;
/// The farthest that a joint goes between two postures that are looked at, radians.
const FINE: f64 = 0.08;
/// How far from its goal a place may be in a posture that keeps it there, metres.
const AT_GOAL: f64 = 0.008;

/// A limb that a thing is going to meet, and where on it where that is known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Threat {
    pub limb: usize,
    pub place: Option<Place>,
}

/// Where it goes to get out of the way.
pub(super) struct Escape {
    pub posture: Posture,
    pub group: Vec<usize>,
    pub gap: f64,
    /// Whether what was to be done goes on meanwhile.
    pub keeps_goal: bool,
    /// What it is from.
    pub threats: Vec<Threat>,
}

/// What a search is for.
struct Search<'a> {
    own: &'a OwnBody,
    /// The clearance of what moves where what is near now need not be farther away.
    eased: CollisionChecker,
    joints: &'a [usize],
    now: &'a [f64],
    course: &'a ThingCourse,
    /// What is to be kept where it is to be, and the joints that see to that.
    goal: Option<(PlaceGoal, &'a [usize])>,
}

/// A posture that is looked at.
#[derive(Clone)]
struct Rated {
    gap: f64,
    far: f64,
    posture: Posture,
}

/// A clearance where what is near now need not be farther away.
pub(super) fn eased(own: &OwnBody, clearance: &CollisionChecker, now: &[f64]) -> CollisionChecker {
    clearance.eased_at(&[own.frames(now)], MARGIN)
}

/// How far limbs that move, by their clearance, are from a thing on the straight way to a posture and from all of its course
/// once there, up to [`WANTED`], metres; `None` if they would meet each other or what else is known to be there.
pub(super) fn gap_on_way(
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
        least = clearance.least_to(&frames, &there, least);
    }
    Some(least)
}

impl Search<'_> {
    /// A posture with what is to be kept where it is to be; `None` if it cannot be there.
    fn keeping(&self, posture: Posture) -> Option<Posture> {
        let Some((goal, joints)) = self.goal else { return Some(posture) };
        let reach = self.own.bringing(goal.place, goal.point, Vector3::zeros(), joints).solve(&posture);
        (reach.miss < AT_GOAL).then_some(reach.posture)
    }

    /// How far a posture keeps from the course, up to [`WANTED`]; `None` if that is not more than `enough` or where limbs
    /// are in the way of each other.
    fn rate(&self, posture: Posture, enough: f64) -> Option<Rated> {
        let posture = self.keeping(posture)?;
        let frames = self.own.frames(&posture);
        let far = distance(self.now, &posture);
        let seconds = far / QUICK;
        let there = self.course.swept(seconds, self.course.ahead().max(seconds), self.course.radius);
        let gap = self.eased.least_to(&frames, &there, WANTED);
        (gap > enough && self.eased.free(&frames, MARGIN)).then_some(Rated { gap, far, posture })
    }

    /// Betters a posture, a few joints at a time.
    fn better(&self, mut best: Rated, rng: &mut ChaCha8Rng) -> Rated {
        for k in 0..BETTERED {
            let radius = 0.5 * 0.985_f64.powi(k as i32);
            let count = rng.random_range(1..=TOGETHER);
            let some: Vec<usize> = (0..count).filter_map(|_| self.joints.choose(rng).copied()).collect();
            let trial = self.own.posture_near(&best.posture, &some, radius, rng);
            if let Some(found) = self.rate(trial, best.gap) {
                best = found;
                if best.gap >= WANTED {
                    break;
                }
            }
        }
        best
    }

    /// A posture that joints can go straight to so that nothing is met, as near as there is, and how far it keeps from the
    /// course; the one that keeps farthest where none keeps clear.
    fn posture(&self, starts: Vec<Posture>, rng: &mut ChaCha8Rng) -> Option<(Posture, f64)> {
        let start = starts.first()?.clone();
        let mut rated: Vec<Rated> =
            starts.into_iter().filter_map(|posture| self.rate(posture, f64::NEG_INFINITY)).collect();
        for radius in RADII {
            for _ in 0..DRAWS {
                let drawn = self.own.posture_near(&start, self.joints, radius, rng);
                rated.extend(self.rate(drawn, f64::NEG_INFINITY));
            }
        }
        let order = |a: &Rated, b: &Rated| b.gap.total_cmp(&a.gap).then(a.far.total_cmp(&b.far));
        rated.sort_by(order);
        if rated.first().is_some_and(|best| best.gap < WANTED) {
            let best: Vec<Rated> = rated.iter().take(BEST).cloned().collect();
            rated.extend(best.into_iter().map(|found| self.better(found, rng)));
            rated.sort_by(order);
        }
        let mut best: Option<(Posture, f64)> = None;
        for Rated { gap, posture, .. } in rated.into_iter().take(CANDIDATES) {
            if best.as_ref().is_some_and(|best| gap <= best.1) {
                break;
            }
            let Some(gap) = gap_on_way(self.own, &self.eased, [self.now, &posture], self.course) else {
                continue;
            };
            if best.as_ref().is_none_or(|best| gap > best.1) {
                best = Some((posture, gap));
            }
            if gap >= WANTED {
                break;
            }
        }
        best
    }
}

impl Avoiding {
    /// A way out of the course of a thing for limbs that it threatens, with as few joints as will do, and so that a place
    /// stays where it is to be if it can; `None` if nothing is better than to stay. Joints that moved `before` go on to
    /// where they go in `base`.
    pub(super) fn way_out(
        &mut self,
        actor: &Actor,
        [now, base]: [&[f64]; 2],
        course: &ThingCourse,
        threatened: &[Threat],
        before: &[usize],
    ) -> Option<Escape> {
        let mut best: Option<Escape> = None;
        let doing = self.goal.and_then(|goal| Some((goal, goal.arm(actor)?)));
        'search: for goal in doing.map(Some).into_iter().chain([None]) {
            for joints in tiers(actor, threatened) {
                self.plans += 1;
                let mut group: Vec<usize> = joints.iter().chain(before).copied().collect();
                group.extend(goal.iter().flat_map(|(_, arm)| arm.iter()));
                group.sort_unstable();
                group.dedup();
                let mut rng = self.rng.clone();
                let own = &actor.own;
                let eased = eased(own, self.clearance_of(actor, &group), now);
                let search = Search { own, eased, joints: &joints, now, course, goal };
                // These joints begin from where they are.
                let start = Posture::with_joints(own.creature(), base, joints.iter().copied(), now);
                let mut starts = vec![start.clone(), Posture::from(base)];
                for place in threatened.iter().filter_map(|threat| threat.place) {
                    starts.extend(pushes(own, &joints, &start, course, place));
                }
                let found = search.posture(starts, &mut rng);
                self.rng = rng;
                if let Some((posture, gap)) = found
                    && best.as_ref().is_none_or(|best| gap > best.gap + 1e-3)
                {
                    let keeps_goal = goal.is_some();
                    best = Some(Escape { posture, group, gap, keeps_goal, threats: threatened.to_vec() });
                }
                if best.as_ref().is_some_and(|best| best.gap >= ENOUGH) {
                    break 'search;
                }
            }
        }
        best
    }
}

/// The limbs that a thing is going to meet, the one that the aura foretells first.
pub(super) fn threats(actor: &Actor, approach: &Approach, course: &ThingCourse, now: &[f64]) -> Vec<Threat> {
    let mut found: Vec<Threat> = Vec::new();
    if let Some(contact) = &approach.contact {
        let place = contact.receptors.first().map(|&receptor| actor.own.place(receptor));
        found.push(Threat { limb: contact.limb, place });
    }
    let frames = actor.own.frames(now);
    let there = course.swept(0.0, AHEAD, CORE);
    let met = |limb: &usize| actor.clearance.to_obstacle(&frames, *limb, &there, CORE) < 0.0;
    let further =
        (1..frames.len()).filter(met).filter(|&limb| found.iter().all(|threat| threat.limb != limb));
    let further: Vec<Threat> = further.map(|limb| Threat { limb, place: None }).collect();
    found.extend(further);
    found
}

/// The joints that can take limbs out of the way: those that move few others first, all in the end.
pub(super) fn tiers(actor: &Actor, threatened: &[Threat]) -> Vec<Vec<usize>> {
    let own = &actor.own;
    let mut tiers: [Vec<usize>; 3] = Default::default();
    for &Threat { limb, .. } in threatened {
        match actor.arm_with(limb) {
            Some(arm) => {
                tiers[0].extend(&actor.hands[arm].arm);
                tiers[1].extend(&actor.hands[arm].leaning);
            }
            None => {
                let hands = actor.hands.each_ref().map(|hand| hand.limb);
                let alone = own.joints_of(limb, &hands);
                tiers[0].extend(if alone.is_empty() { own.joints_to(limb) } else { alone });
                tiers[1].extend(own.joints_to(limb));
            }
        }
    }
    tiers[2].extend(0..own.creature().joints().len());
    let mut tiers: Vec<Vec<usize>> = tiers
        .into_iter()
        .map(|mut joints| {
            joints.sort_unstable();
            joints.dedup();
            joints
        })
        .filter(|joints| !joints.is_empty())
        .collect();
    tiers.dedup();
    tiers
}

/// Postures in which a place of the body is pushed off the way of a thing, in several directions and by several lengths.
fn pushes(
    own: &OwnBody,
    joints: &[usize],
    start: &[f64],
    course: &ThingCourse,
    place: Place,
) -> Vec<Posture> {
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
            let solver = own.bringing(place, point, Vector3::zeros(), joints).at_ease(start);
            postures.push(solver.solve(start).posture);
        }
    }
    postures
}
