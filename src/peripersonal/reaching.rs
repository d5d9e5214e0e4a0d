//! Reaching: a posture in which skin touches a place in space, and a way there that keeps clear until the last.

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::collision::CollisionChecker;
use super::own_body::{Doubt, OwnBody};
use super::path::{PosturePath, distance, find_path, straight as straight_to};
use crate::creature::Posture;
use crate::geometry::Frame;
use crate::kinematics::{InverseKinematics, Place, REACHED, Reach};
use crate::skin::Surface;

/// From how far a place is approached straight, metres.
const BEFORE: f64 = 0.06;
/// How far beyond a place the approach goes on where nothing is felt, metres.
const BEYOND: f64 = 0.05;
/// Length of a step of the straight approach, metres.
const STEP: f64 = 0.005;
/// How clear of everything a way keeps, metres.
const MARGIN: f64 = 0.008;
/// How clear of all but what is to be touched the last straight piece keeps, metres.
const SCRAPING: f64 = 0.002;
/// Postures near the place that keep clear and are started from, …
const STARTS: usize = 4;
/// … of so many drawn at random for each, …
const DRAWN: usize = 75;
/// … which differ by this much, in radians (or metres times three).
const DIFFERENT: f64 = 0.5;
/// Candidates, the best first, for which a way is looked for.
const CANDIDATES: usize = 12;
/// What it is worth, in squared shares of the joints' ranges, that a receptor faces where it goes.
const FACING: f64 = 0.7;
/// What a metre is worth that other skin is ahead of the receptor.
const PROTRUDING: f64 = 120.0;
/// How far aside of a place other skin could touch the same thing first, metres: from …
const BESIDE: f64 = 0.012;
/// … to.
const ABOUT: f64 = 0.12;
/// How often it is looked which skin is ahead, which changes as the limb turns …
const FORESIGHT: usize = 4;
/// … until it stays within this, metres.
const SETTLED: f64 = 5e-4;
/// How far behind the place other skin had better be, metres.
const BEHIND: f64 = 0.02;

/// A place in space that is to be touched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReachTarget {
    /// The place in the root's frame, metres.
    pub point: Vector3<f64>,
    /// The unit direction in which the skin goes at the last; zero where it may be any.
    pub direction: Vector3<f64>,
}

/// How to touch a place.
#[derive(Clone, Debug, PartialEq)]
pub struct ReachPlan {
    /// The receptor that is to touch it.
    pub receptor: usize,
    /// Where on its limb's skin.
    pub place: Place,
    /// The posture in which it does.
    pub touching: Posture,
    /// A way from where one is to shortly before the place.
    pub way: PosturePath,
    /// From there straight to the place and a little beyond, to be ended by the touch.
    pub straight: PosturePath,
}

/// Why a place cannot be touched.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OutOfReach {
    /// It is too far by so much, metres.
    #[error("it is out of my reach by {:.0} cm", (100.0 * .0).max(1.0))]
    TooFar(f64),
    /// There are postures for it, but something is in the way of all that were tried.
    #[error("I could reach it, but something is in the way")]
    Barred,
    /// The schema is not good enough to know.
    #[error("I do not know my body well enough for this: {0}")]
    Unknown(Doubt),
}

/// A body that reaches with some of its joints.
#[derive(Clone, Debug)]
pub struct Reaching<'a> {
    own: &'a OwnBody,
    clearance: &'a CollisionChecker,
    /// The joints that may move, by index.
    pub joints: Vec<usize>,
    /// The limb of one's own that is to be touched, where it is one.
    meeting: Option<usize>,
    /// The unit normal into the surface that is to be touched, where it is known and not the way there.
    onto: Option<Vector3<f64>>,
    seed: u64,
}

/// A posture that touches, before a way to it is known.
struct Candidate {
    receptor: usize,
    place: Place,
    reach: Reach,
    cost: f64,
}

impl<'a> Reaching<'a> {
    /// A body that reaches by moving `joints`. Whatever is drawn at random is drawn by the seed.
    pub fn new(
        own: &'a OwnBody,
        clearance: &'a CollisionChecker,
        joints: Vec<usize>,
        seed: u64,
    ) -> Reaching<'a> {
        Reaching { own, clearance, joints, meeting: None, onto: None, seed }
    }

    /// The same where the place is on the skin of a limb, which the straight approach may therefore meet.
    pub fn meeting(self, limb: usize) -> Reaching<'a> {
        Reaching { meeting: Some(limb), ..self }
    }

    /// The same where the unit normal into what is to be touched is known: no skin is to be beyond the plane before that which
    /// touches, from wherever it comes.
    pub fn onto(self, normal: Vector3<f64>) -> Reaching<'a> {
        Reaching { onto: Some(normal), ..self }
    }

    /// The posture, moving the joints from `start`, in which a place of the body is nearest to a place in space, and
    /// how near.
    pub fn solve(&self, place: Place, aim: &ReachTarget, start: &[f64]) -> Reach {
        self.solver(place, aim, start).solve(start)
    }

    fn solver(&self, place: Place, aim: &ReachTarget, at_ease: &[f64]) -> InverseKinematics<'a> {
        self.own.bringing(place, aim.point, aim.direction, &self.joints).at_ease(at_ease)
    }

    /// How to touch a place with one of some receptors, from a posture.
    ///
    /// # Errors
    /// [`OutOfReach`].
    pub fn approach(
        &self,
        from: &[f64],
        receptors: &[usize],
        aim: &ReachTarget,
    ) -> Result<ReachPlan, OutOfReach> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let clearance =
            self.clearance.moved_by(self.own, &self.joints).eased_at(&[self.own.frames(from)], MARGIN);
        let at_ease = self.own.at_ease();
        let (mut candidates, mut nearest) = (Vec::new(), f64::INFINITY);
        // Halfway to ease, in the joints that may move alone.
        let creature = self.own.creature();
        let halfway = Posture::between(creature, from, &at_ease, 0.5);
        let others = (0..creature.joints().len()).filter(|joint| !self.joints.contains(joint));
        let halfway = Posture::with_joints(creature, &halfway, others, from);
        let mut starts = vec![Posture::from(from), halfway];
        starts.extend(self.clear_starts(from, receptors, aim, &clearance, STARTS, &mut rng));
        for &receptor in receptors {
            let flat = self.own.place(receptor);
            // A palm touches with its face, a finger with what points away from the limb's joint.
            let pointing = flat.point.try_normalize(1e-3).unwrap_or(flat.direction);
            let ways =
                [flat.direction, pointing].into_iter().flat_map(|d| starts.iter().map(move |s| (d, s)));
            for (direction, start) in ways {
                let reach = self.solve(Place { direction, ..flat }, aim, start);
                nearest = nearest.min(reach.miss);
                if reach.miss > REACHED || reach.facing <= 0.0 {
                    continue;
                }
                let (receptor, place, reach) =
                    self.first_to_touch(receptors, receptor, reach, direction, aim);
                if reach.miss <= REACHED && reach.facing > 0.0 {
                    let cost = self.effort(from, &reach.posture) - FACING * reach.facing
                        + PROTRUDING * self.protrusion(place.limb, &reach.posture, aim);
                    candidates.push(Candidate { receptor, place, reach, cost });
                }
            }
        }
        if candidates.is_empty() {
            return Err(match nearest {
                near if near <= REACHED => OutOfReach::Barred,
                far => OutOfReach::TooFar(far),
            });
        }
        candidates.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let first = &candidates[0];
        let place = first.place;
        self.own.trusts(&first.reach.posture, [place.limb, 0], &place.point).map_err(OutOfReach::Unknown)?;
        let mut looked_at = 0;
        // What is to be touched is in the way of all but the limbs that are to touch it.
        let (mut others, target) = clearance.but_at(&aim.point, 1e-3);
        if let Some(limb) = self.meeting {
            let touching: Vec<usize> = receptors.iter().map(|&r| self.own.skin().receptors[r].limb).collect();
            others = others.but_between(&[limb], &touching);
        }
        let others = others.eased_at(&[self.own.frames(from)], MARGIN);
        let moved = self.own.moved_by(&self.joints);
        let touches = |limb: usize| receptors.iter().any(|&r| self.own.skin().receptors[r].limb == limb);
        let behind: Vec<usize> = (0..moved.len()).filter(|&limb| moved[limb] && !touches(limb)).collect();
        let comes_clear = |posture: &Posture| {
            let frames = self.own.frames(posture);
            let off = |limb: &usize| {
                target.iter().all(|o| self.clearance.to_obstacle(&frames, *limb, o, SCRAPING) >= SCRAPING)
            };
            others.free(&frames, SCRAPING) && behind.iter().all(off)
        };
        let touching = (BEFORE / STEP).round() as usize + 1;
        for candidate in &candidates {
            let mut straight = self.straight(candidate, aim);
            // What is felt may have any size: only the way up to it is known to be free.
            let before = straight.0.first().expect("a way has a beginning").clone();
            if !clearance.free(&self.own.frames(&before), 0.5 * MARGIN) {
                continue;
            }
            let clear = |two: &[Posture]| straight_to(self.own, &others, &two[0], &two[1], SCRAPING);
            if !straight.0[..touching].iter().all(comes_clear)
                || !straight.0[..touching].windows(2).all(clear)
            {
                continue;
            }
            let further = straight.0[touching - 1..].windows(2).take_while(|two| clear(two)).count();
            straight.0.truncate(touching + further);
            looked_at += 1;
            if let Some(way) =
                find_path(self.own, self.clearance, [from, &before], &self.joints, MARGIN, &mut rng)
            {
                let touching = candidate.reach.posture.clone();
                let Candidate { receptor, place, .. } = *candidate;
                return Ok(ReachPlan { receptor, place, touching, way, straight });
            }
            if looked_at == CANDIDATES {
                break;
            }
        }
        Err(OutOfReach::Barred)
    }

    /// Whether there is a posture in which one of some receptors is at a place, facing it, and no limb is in another or in what
    /// is known to be about; looked for from `starts` postures that keep clear.
    pub fn can_be_at(&self, from: &[f64], receptors: &[usize], aim: &ReachTarget, starts: usize) -> bool {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let clearance = self.clearance.moved_by(self.own, &self.joints);
        let mut from_here = vec![Posture::from(from)];
        from_here.extend(self.clear_starts(from, receptors, aim, &clearance, starts, &mut rng));
        receptors.iter().any(|&receptor| {
            from_here.iter().any(|start| {
                let reach = self.solve(self.own.place(receptor), aim, start);
                reach.miss <= REACHED
                    && reach.facing > 0.0
                    && clearance.free(&self.own.frames(&reach.posture), 0.0)
            })
        })
    }

    /// Random postures that keep clear, in which some receptor is near the place, the nearest first: a solution stays on the
    /// side of the trunk on which it starts.
    fn clear_starts(
        &self,
        from: &[f64],
        receptors: &[usize],
        aim: &ReachTarget,
        clearance: &CollisionChecker,
        count: usize,
        rng: &mut ChaCha8Rng,
    ) -> Vec<Posture> {
        let near = |frames: &[Frame]| {
            let away = receptors.iter().map(|&receptor| {
                let found = &self.own.skin().receptors[receptor];
                (frames[found.limb].point(&found.position) - aim.point).norm()
            });
            away.fold(f64::INFINITY, f64::min)
        };
        let drawn = (0..DRAWN * count).filter_map(|_| {
            let posture = self.own.random_posture(from, &self.joints, rng);
            let frames = self.own.frames(&posture);
            clearance.free(&frames, MARGIN).then(|| (near(&frames), posture))
        });
        let mut drawn: Vec<_> = drawn.collect();
        drawn.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut starts: Vec<Posture> = Vec::new();
        for (_, posture) in drawn {
            if starts.iter().all(|other| distance(other, &posture) > DIFFERENT) {
                starts.push(posture);
            }
            if starts.len() == count {
                break;
            }
        }
        starts
    }

    /// What touches first in a posture that brings a receptor to a place, and the posture that brings this there: the part of
    /// the patch that leads; where the normal of what is to be touched is known, the skin of the limb that is ahead of all other.
    fn first_to_touch(
        &self,
        receptors: &[usize],
        receptor: usize,
        reach: Reach,
        direction: Vector3<f64>,
        aim: &ReachTarget,
    ) -> (usize, Place, Reach) {
        let flat = self.own.place(receptor);
        let ahead = |reach: &Reach, normal: &Vector3<f64>| {
            self.own.frames(&reach.posture)[flat.limb].rotation.tr_mul(normal)
        };
        let Some(normal) = self.onto else {
            let place = Place { direction, ..self.own.leading(receptor, &ahead(&reach, &aim.direction)) };
            let reach = self.solve(place, aim, &reach.posture);
            return (receptor, place, reach);
        };
        let mut found = (receptor, Place { direction, ..flat }, reach);
        for _ in 0..FORESIGHT {
            let (_, before, reach) = &found;
            let foremost = self.foremost(receptors, flat.limb, &ahead(reach, &normal));
            let Some((receptor, point)) = foremost else { break };
            let settled = (point - before.point).norm() < SETTLED;
            let place = Place { point, ..*before };
            found = (receptor, place, self.solve(place, aim, &reach.posture));
            if settled {
                break;
            }
        }
        found
    }

    /// The receptor, among some, and the point of a limb's skin that is farthest in a direction, both in the limb's frame; `None`
    /// if skin without one of those receptors is.
    fn foremost(
        &self,
        receptors: &[usize],
        limb: usize,
        ahead: &Vector3<f64>,
    ) -> Option<(usize, Vector3<f64>)> {
        let skin = self.own.skin();
        let surfaces = skin.surfaces.iter().enumerate().filter(|(_, surface)| surface.limb == limb);
        let (surface, point) = surfaces
            .filter_map(|(index, surface)| Some((index, surface.support(ahead)?)))
            .max_by(|a, b| a.1.dot(ahead).total_cmp(&b.1.dot(ahead)))?;
        let on_it = receptors.iter().copied().filter(|&r| skin.receptors[r].surface == Some(surface));
        let away = |receptor: usize| (skin.receptors[receptor].position - point).norm();
        let receptor = on_it.min_by(|&a, &b| away(a).total_cmp(&away(b)))?;
        Some((receptor, point))
    }

    /// By how much other skin of the limb that touches, or of the one that carries it, fails to be well behind the place,
    /// metres: it might touch first.
    fn protrusion(&self, limb: usize, posture: &[f64], aim: &ReachTarget) -> f64 {
        let frames = self.own.frames(posture);
        let near =
            |surface: &&Surface| surface.limb == limb || self.own.creature().neighbouring(surface.limb, limb);
        let ahead = self.own.skin().surfaces.iter().filter(near).filter_map(|surface| {
            let frame = &frames[surface.limb];
            let point = frame.point(&surface.support(&frame.rotation.tr_mul(&aim.direction))?) - aim.point;
            let along = point.dot(&aim.direction);
            let aside = (point - aim.direction * along).norm();
            (aside > BESIDE && aside < ABOUT).then_some(along + BEHIND)
        });
        ahead.fold(0.0, f64::max)
    }

    /// The straight approach to a place, from before it to beyond it.
    fn straight(&self, candidate: &Candidate, aim: &ReachTarget) -> PosturePath {
        let place = candidate.place;
        let at = |along: f64, near: &[f64]| {
            let aim = ReachTarget { point: aim.point + aim.direction * along, ..*aim };
            self.solver(place, &aim, near)
                .with_steps([2, 6])
                .with_direction_lengths([5e-4; 2])
                .solve(near)
                .posture
        };
        let from_there = |far: f64, step: f64| {
            let steps = (far / STEP).round() as usize;
            let next = |k: usize, last: &[f64]| Some(at(step * k as f64, last));
            PosturePath::stepwise(&candidate.reach.posture, steps, next).0
        };
        let mut way = from_there(BEFORE, -STEP);
        way.reverse();
        way.extend(from_there(BEYOND, STEP).into_iter().skip(1));
        PosturePath(way)
    }

    /// What a posture costs: how far its joints are from their middles, and how far one has to move.
    fn effort(&self, from: &[f64], posture: &[f64]) -> f64 {
        let mut effort = 0.1 * distance(from, posture);
        for &joint in &self.joints {
            let joint = &self.own.creature().joints()[joint];
            for at in joint.elements().filter(|at| !at.is_ball()) {
                let [low, high] = at.range;
                if high > low {
                    let share = (posture[at.coordinate()] - 0.5 * (low + high)) / (0.5 * (high - low));
                    effort += 0.1 * share.powi(4);
                }
            }
        }
        effort
    }
}
