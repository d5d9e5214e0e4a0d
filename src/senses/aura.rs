//! The aura: proximity geometries about the limbs that tell what is about to touch, and where.
//!
//! What is inside a [`ProximityGeometry`] is measured exactly, against the surfaces of its limb: the engine's own distances
//! between shapes that do not touch are right for capsules and boxes alone.

use std::collections::{BTreeMap, VecDeque};

use nalgebra::{Matrix3, Vector3};

use super::{Sense, SensedStep, SensingBody};
use crate::error::Result;
use crate::geometry::{Ball, Frame, Precision, gap};
use crate::skin::{AURA_REACH, ProximityGeometry, Skin, Surface, aura_of, surface_of_body};

/// How far ahead a contact is predicted, seconds.
const HORIZON: f64 = 0.6;
/// Receptors named for a contact that is predicted.
const RECEPTORS_NAMED: usize = 5;
/// Every how many seconds what is near is looked at.
const LOOK_PERIOD: f64 = 0.01;
/// Looks from which the motion of an object is told.
const LOOKS: usize = 5;
/// A predicted position closer to a limb than this is a contact, metres.
const THERE: f64 = 5e-4;
/// An object closer to a limb than this touches it, metres: what rests on skin sinks in by less, and rises by less as it rolls.
const TOUCHING: f64 = 1e-3;
/// An object that touched a limb goes on touching it below this distance, metres.
const STILL_TOUCHING: f64 = 3e-3;
/// How long it does so, seconds: contacts flicker.
const FLICKER: f64 = 0.1;
/// A limb in whose frame an object moves by less than this share of its way goes along with it.
const ALONG: f64 = 0.1;
/// An object that moves into a limb it touches by more than this is stopped by it, metres a second.
const STOPPED: f64 = 0.01;

/// An object inside an aura.
#[derive(Clone, Debug, PartialEq)]
pub struct Approach {
    /// The model's body that is near.
    pub object: usize,
    /// The aura limb that it is nearest to.
    pub aura_limb: usize,
    /// The limb of it that is nearest.
    pub limb: usize,
    /// How far its surface is from the limb's, metres.
    pub distance: f64,
    /// The point of the limb's surface that is nearest, in the limb's frame, metres.
    pub point: Vector3<f64>,
    /// The unit direction from there to the object, in the limb's frame.
    pub toward: Vector3<f64>,
    /// How fast the distance becomes less, metres a second; below 0 where the object recedes.
    pub speed: f64,
    /// The contact that is predicted, if the object goes on as it does and the creature stays as it is: with a limb that it
    /// does not touch yet.
    pub contact: Option<PredictedContact>,
}

/// A contact that is about to happen.
#[derive(Clone, Debug, PartialEq)]
pub struct PredictedContact {
    /// The limb that will be hit.
    pub limb: usize,
    /// In how many seconds.
    pub seconds: f64,
    /// The receptors most likely to be hit, the likeliest first.
    pub receptors: Vec<usize>,
}

/// What the sense of proximity reports.
#[derive(Clone, Debug, PartialEq)]
pub enum AuraEvent {
    /// An object has come into the aura of a limb.
    Entered(Approach),
    /// A contact is predicted, with a limb that was not predicted for this object before and that it does not touch.
    Alarm(Approach),
    /// The object has left all auras.
    Left {
        /// The model's body.
        object: usize,
    },
}

/// The sense of what is near.
pub struct Aura {
    /// The proximity geometries.
    geometries: Vec<ProximityGeometry>,
    /// Per object, its surfaces in its own body's frame.
    objects: BTreeMap<usize, Vec<Surface>>,
    followed: BTreeMap<usize, Followed>,
    /// Whether the creature watches out; otherwise nothing is sensed.
    watching: bool,
    next: f64,
    /// The events of the last step.
    events: Vec<AuraEvent>,
}

impl Sense for Aura {
    fn step(&mut self, step: &SensedStep) -> Result<()> {
        self.events.clear();
        if self.watching && step.time >= self.next {
            self.next = step.time + LOOK_PERIOD - 1e-9;
            self.look(step);
        }
        Ok(())
    }
}

impl Aura {
    /// The aura of a creature, with the bodies that are no part of it for objects.
    pub(super) fn of(own: &SensingBody) -> Aura {
        let body = own.body;
        let geometries = aura_of(body, own.agent.skin(), own.frames);
        let foreign = |b: &usize| body.limb_of_body[*b].is_none() && body.model.weld(*b) != 0;
        let objects = (1..body.model.nbody()).filter(foreign);
        let objects = objects.map(|object| (object, surface_of_body(&body.model, object)));
        let objects = objects.filter(|(_, surfaces)| !surfaces.is_empty()).collect();
        let (followed, next, events) = (BTreeMap::new(), f64::NEG_INFINITY, Vec::new());
        Aura { geometries, objects, followed, watching: false, next, events }
    }

    /// Watches out for what comes near from now on; nothing was near before.
    pub fn watch_out(&mut self) {
        (self.watching, self.next) = (true, f64::NEG_INFINITY);
        self.followed.clear();
    }

    /// The events of the last step.
    pub fn events(&self) -> &[AuraEvent] {
        &self.events
    }

    /// What is in an aura now.
    pub fn approaches(&self) -> impl Iterator<Item = &Approach> {
        self.followed.values().filter_map(|followed| followed.approach.as_ref())
    }

    /// Looks at what is near.
    fn look(&mut self, step: &SensedStep) {
        let (skin, aura_limbs) = (step.agent.skin(), step.body.creature.aura_limbs());
        let frames = step.body.limb_frames(step.data);
        for (&object, surfaces) in &self.objects {
            let pose = Frame::from(step.data.body_pose(object));
            let view = View { skin, frames: &frames, surfaces, rotation: pose.rotation };
            let extent =
                surfaces.iter().map(|s| s.origin.norm() + s.shape.half_bounds().norm()).fold(0.0, f64::max);
            let near = |geometry: &&ProximityGeometry| {
                let centre = frames[geometry.limb].inverse_point(&pose.origin);
                geometry.holds(&Ball { centre, radius: extent })
            };
            let within =
                self.geometries.iter().filter(near).flat_map(|near| &aura_limbs[near.aura_limb].limbs);
            let limbs: Vec<usize> = within.copied().collect();
            let followed = self.followed.entry(object).or_default();
            followed.see(step.time, &pose.origin, if limbs.is_empty() { &[] } else { &frames });
            let approach = followed.approach(object, &view, &limbs, step);
            match &approach {
                None if followed.approach.is_some() => self.events.push(AuraEvent::Left { object }),
                None => {}
                Some(approach) => {
                    if followed.approach.is_none() {
                        self.events.push(AuraEvent::Entered(approach.clone()));
                    }
                    let limb = |approach: &Approach| Some(approach.contact.as_ref()?.limb);
                    let predicted = limb(approach);
                    if predicted.is_some() && predicted != followed.approach.as_ref().and_then(limb) {
                        self.events.push(AuraEvent::Alarm(approach.clone()));
                    }
                }
            }
            followed.approach = approach;
        }
    }
}

/// What is seen of an object at a look.
struct View<'a> {
    skin: &'a Skin,
    /// Per limb, `X_WL`.
    frames: &'a [Frame],
    /// The surfaces of the object, in its own frame.
    surfaces: &'a [Surface],
    /// How it is turned in the world.
    rotation: Matrix3<f64>,
}

/// The limb that is nearest to an object.
#[derive(Clone, Copy)]
struct NearestLimb {
    /// Metres.
    distance: f64,
    limb: usize,
    /// Where on it, in the world.
    point: Vector3<f64>,
    /// The unit direction from there to the object, in the world.
    toward: Vector3<f64>,
}

impl View<'_> {
    /// The nearest of some limbs where the object is at a place in the world.
    fn nearest(&self, limbs: &[usize], place: Vector3<f64>) -> Option<NearestLimb> {
        let x_wo = Frame { origin: place, rotation: self.rotation };
        let mut best: Option<NearestLimb> = None;
        for surface in self.skin.surfaces.iter().filter(|surface| limbs.contains(&surface.limb)) {
            let Some(first) = surface.placed(&self.frames[surface.limb]) else { continue };
            for second in self.surfaces.iter().filter_map(|part| part.placed(&x_wo)) {
                let found = gap(&first, &second, Precision::Exact);
                if best.is_none_or(|best| found.distance < best.distance) {
                    let (point, toward) = (found.points[0], -found.normal);
                    best = Some(NearestLimb { distance: found.distance, limb: surface.limb, point, toward });
                }
            }
        }
        best
    }

    /// When, in seconds, the object that goes on as it does first meets one of some limbs, which, and where, in the world: it
    /// goes forward as far as nothing is near, for nothing can be hit sooner.
    fn predict(
        &self,
        limbs: &[usize],
        place: Vector3<f64>,
        (velocity, acceleration): (Vector3<f64>, Vector3<f64>),
    ) -> Option<(f64, usize, Vector3<f64>)> {
        let fastest = velocity.norm() + acceleration.norm() * HORIZON;
        if fastest < 1e-3 {
            return None;
        }
        let mut seconds = 0.0;
        for _ in 0..200 {
            let there = place + velocity * seconds + acceleration * (0.5 * seconds * seconds);
            let NearestLimb { distance, limb, point, .. } = self.nearest(limbs, there)?;
            let closing = velocity + acceleration * seconds;
            // Something that lies on the skin and leaves it is no danger.
            let leaves = (there - point).dot(&closing) >= 0.0;
            if distance < THERE && !leaves {
                // What brakes as it goes away may stop there as well as come back.
                return ((point - place).dot(&velocity) > 0.0).then_some((seconds, limb, point));
            }
            seconds += distance.max(if leaves { 2e-3 } else { 0.5 * THERE }) / fastest;
            if seconds > HORIZON {
                return None;
            }
        }
        None
    }

    /// The receptors of a limb that are nearest to a point of it in the world.
    fn likeliest(&self, limb: usize, point: &Vector3<f64>) -> Vec<usize> {
        let (receptors, p_l) = (&self.skin.receptors, self.frames[limb].inverse_point(point));
        let mut on_limb: Vec<usize> = self.skin.receptors_on(limb).collect();
        let distance = |&r: &usize| (receptors[r].position - p_l).norm();
        on_limb.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        on_limb.truncate(RECEPTORS_NAMED);
        on_limb
    }
}

/// Where an object was at a look.
#[derive(Clone, Debug)]
struct Look {
    /// Seconds.
    time: f64,
    /// In the world, metres.
    place: Vector3<f64>,
    /// In the frame of every limb; empty if it was in no aura.
    from_limbs: Vec<Vector3<f64>>,
}

/// An object that is followed.
#[derive(Clone, Debug, Default)]
struct Followed {
    /// The last looks.
    looks: VecDeque<Look>,
    /// The limbs that it touches, and when it was last surely there.
    touched: BTreeMap<usize, f64>,
    /// The limb that a contact was foreseen with at the last look, and in how many looks on end.
    foreseen: Option<(usize, usize)>,
    approach: Option<Approach>,
}

impl Followed {
    /// Takes in a look at it; limbs have frames if it is in an aura.
    fn see(&mut self, time: f64, place: &Vector3<f64>, frames: &[Frame]) {
        // What jumps was carried elsewhere: its motion begins anew.
        if self.looks.back().is_some_and(|before| (place - before.place).norm() > AURA_REACH) {
            self.looks.clear();
        }
        let from_limbs = frames.iter().map(|frame| frame.inverse_point(place)).collect();
        self.looks.push_back(Look { time, place: *place, from_limbs });
        if self.looks.len() > LOOKS {
            self.looks.pop_front();
        }
        if frames.is_empty() {
            self.touched.clear();
        }
    }

    /// How it approaches some limbs at the last look.
    fn approach(
        &mut self,
        object: usize,
        view: &View,
        limbs: &[usize],
        step: &SensedStep,
    ) -> Option<Approach> {
        let place = self.looks.back()?.place;
        let NearestLimb { distance, limb, point, toward } = view.nearest(limbs, place)?;
        let (velocity, acceleration) = self.motion();
        let before = view.nearest(limbs, place - velocity * 1e-3);
        let speed = before.map_or(0.0, |before| (before.distance - distance) / 1e-3);
        let touching = self.touching(step.time, limbs, |limb| view.nearest(&[limb], place));
        // What touches a limb and moves into it goes no farther.
        let stopped = touching.iter().any(|touched| {
            let toward = view.frames[touched.limb].rotation.tr_mul(&touched.toward);
            self.seen_moving(touched.limb).is_some_and(|(seen, _)| seen.dot(&toward) < -STOPPED)
        });
        let is_touched = |limb: &usize| touching.iter().any(|touched| touched.limb == *limb);
        // A limb that moves with it holds it, or it lies on the limb.
        let goes_along =
            |limb: &usize| self.seen_moving(*limb).is_some_and(|(seen, speed)| seen.norm() < ALONG * speed);
        let threatened = limbs.iter().filter(|limb| !is_touched(limb) && !goes_along(limb));
        let threatened: Vec<usize> = threatened.copied().collect();
        // What the skin carries is shaken by it: how it speeds up says nothing of where it goes.
        let motion = match touching.is_empty() {
            true => (velocity, acceleration),
            false => (self.drift(), Vector3::zeros()),
        };
        let found = if stopped { None } else { view.predict(&threatened, place, motion) };
        self.foreseen = match (self.foreseen, &found) {
            (Some((limb, looks)), Some((_, again, _))) if limb == *again => Some((limb, looks + 1)),
            (_, found) => found.as_ref().map(|(_, limb, _)| (*limb, 1)),
        };
        // Shaken things seem to go anywhere for a moment.
        let steady = touching.is_empty() || self.foreseen.is_some_and(|(_, looks)| looks >= LOOKS);
        let contact = found.filter(|_| steady).map(|(seconds, limb, point)| PredictedContact {
            limb,
            seconds,
            receptors: view.likeliest(limb, &point),
        });
        let aura_limb = step.body.creature.aura_of(limb)?;
        let frame = &view.frames[limb];
        let (point, toward) = (frame.inverse_point(&point), frame.rotation.tr_mul(&toward));
        Some(Approach { object, aura_limb, limb, distance, point, toward, speed, contact })
    }

    /// The limbs that it touches at a look, with where: what is in reach of nothing has touched nothing.
    fn touching(
        &mut self,
        time: f64,
        limbs: &[usize],
        nearest: impl Fn(usize) -> Option<NearestLimb>,
    ) -> Vec<NearestLimb> {
        let mut touching: Vec<NearestLimb> = limbs.iter().filter_map(|&limb| nearest(limb)).collect();
        touching.retain(|nearest| {
            if nearest.distance < TOUCHING {
                self.touched.insert(nearest.limb, time);
            }
            let surely = self.touched.get(&nearest.limb);
            nearest.distance < STILL_TOUCHING && surely.is_some_and(|surely| time - surely <= FLICKER)
        });
        touching
    }

    /// How it moves as seen from a limb, in that limb's frame, and how fast in the world, since it came into an aura: metres a
    /// second. `None` if it was seen there but once.
    fn seen_moving(&self, limb: usize) -> Option<(Vector3<f64>, f64)> {
        let mut within = self.looks.iter().rev().take_while(|look| !look.from_limbs.is_empty());
        let last = within.next()?;
        let first = within.last()?;
        let seconds = last.time - first.time;
        let speed = (last.place - first.place).norm() / seconds;
        Some(((last.from_limbs[limb] - first.from_limbs[limb]) / seconds, speed))
    }

    /// Its mean velocity over all looks, metres a second.
    fn drift(&self) -> Vector3<f64> {
        match (self.looks.front(), self.looks.back()) {
            (Some(first), Some(last)) if last.time > first.time => {
                (last.place - first.place) / (last.time - first.time)
            }
            _ => Vector3::zeros(),
        }
    }

    /// Velocity now and acceleration, metres and seconds, by the parabola through three looks.
    fn motion(&self) -> (Vector3<f64>, Vector3<f64>) {
        let velocity = |a: &Look, b: &Look| (b.place - a.place) / (b.time - a.time);
        let looks: Vec<&Look> = self.looks.iter().collect();
        match looks.as_slice() {
            [] | [_] => (Vector3::zeros(), Vector3::zeros()),
            [a, b] => (velocity(a, b), Vector3::zeros()),
            [a, .., c] => {
                let b = looks[looks.len() / 2];
                let (first, second) = (velocity(a, b), velocity(b, c));
                let acceleration = (second - first) / (0.5 * (c.time - a.time));
                (second + acceleration * (0.5 * (c.time - b.time)), acceleration)
            }
        }
    }
}
