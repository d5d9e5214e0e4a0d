//! The aura: proximity geometries about the limbs that tell what is about to touch, and where.
//!
//! What is inside a [`ProximityGeometry`] is measured exactly, against the surfaces of its limb: the engine's own distances
//! between shapes that do not touch are right for capsules and boxes alone.

use std::collections::{BTreeMap, VecDeque};

use nalgebra::{Point3, Vector3};

use super::{Sense, SensedStep, SensingBody};
use crate::creature::Body;
use crate::error::Result;
use crate::geometry::{Ball, Frame, Precision, gap};
use crate::mujoco::Data;
use crate::skin::{AURA_REACH, ProximityGeometry, Skin, Surface, aura_of, surface_of_body};

/// How far ahead a contact is predicted, seconds.
const HORIZON: f64 = 0.6;
/// Receptors named for a contact that is predicted.
const RECEPTORS_NAMED: usize = 5;
/// Every how many seconds what is near is looked at.
const LOOK_PERIOD: f64 = 0.01;
/// Looks from which the motion of an object is told.
const LOOKS: usize = 5;
/// An object this near counts as there, metres.
const THERE: f64 = 5e-4;
/// An object this near touches a limb, metres: what rests on skin is in it by less, and rises by less as it rolls …
const TOUCHING: f64 = 1e-3;
/// … and this near it touches it still for so long after, seconds: contacts flicker.
const STILL_TOUCHING: f64 = 3e-3;
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

/// What a sense of proximity tells.
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
            self.events = self.look(step.time, step.body, step.agent.skin(), step.data);
        }
        Ok(())
    }
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

/// An object that is followed.
#[derive(Clone, Debug, Default)]
struct Followed {
    /// When and where it was.
    looks: VecDeque<(f64, Vector3<f64>)>,
    /// Where it was in the frame of every limb, at the last of these looks, as far as it was in an aura.
    seen_from: VecDeque<Vec<Vector3<f64>>>,
    /// The limbs that it touches, and when it was last surely there.
    touched: BTreeMap<usize, f64>,
    /// The limb that a contact was foreseen with at the last look, and in how many looks on end.
    foreseen: Option<(usize, usize)>,
    within: bool,
    alarm: Option<usize>,
    approach: Option<Approach>,
}

impl Aura {
    /// The aura of a creature, with the bodies that are no part of it for objects.
    pub(super) fn of(own: &SensingBody) -> Aura {
        let body = own.body;
        let geometries = aura_of(body, own.agent.skin(), own.frames);
        let mut objects: BTreeMap<usize, Vec<Surface>> = BTreeMap::new();
        let foreign = |b: &usize| body.limb_of_body[*b].is_none() && body.model.weld(*b) != 0;
        for object in (1..body.model.nbody()).filter(foreign) {
            let surfaces = surface_of_body(&body.model, object);
            if !surfaces.is_empty() {
                objects.insert(object, surfaces);
            }
        }
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

    /// Looks at what is near, given data with poses of a step at `time`, seconds.
    fn look(&mut self, time: f64, body: &Body, skin: &Skin, data: &Data) -> Vec<AuraEvent> {
        let mut events = Vec::new();
        let mut frames: Option<Vec<Frame>> = None;
        for (&object, surfaces) in &self.objects {
            let pose = data.body_pose(object);
            let place = pose.translation.vector;
            let extent =
                surfaces.iter().map(|s| s.origin.norm() + s.shape.half_bounds().norm()).fold(0.0, f64::max);
            let within: Vec<&ProximityGeometry> = {
                let near = |geometry: &&ProximityGeometry| {
                    let carrier = body.limb_pose(data, geometry.limb).unwrap_or_default();
                    let centre = carrier.inverse_transform_point(&Point3::from(place)).coords;
                    geometry.holds(&Ball { centre, radius: extent })
                };
                self.geometries.iter().filter(near).collect()
            };
            let followed = self.followed.entry(object).or_default();
            // What jumps was carried elsewhere: its motion begins anew.
            if followed.looks.back().is_some_and(|(_, before)| (place - before).norm() > AURA_REACH) {
                followed.looks.clear();
            }
            followed.looks.push_back((time, place));
            if followed.looks.len() > LOOKS {
                followed.looks.pop_front();
            }
            if within.is_empty() {
                if std::mem::take(&mut followed.within) {
                    events.push(AuraEvent::Left { object });
                }
                (followed.approach, followed.alarm) = (None, None);
                followed.seen_from.clear();
                followed.touched.clear();
                continue;
            }
            let frames = frames.get_or_insert_with(|| body.limb_frames(data));
            let at = |origin: Vector3<f64>| Frame { origin, ..Frame::from(pose) };
            let limbs: Vec<usize> = within
                .iter()
                .flat_map(|geometry| &body.creature.aura_limbs()[geometry.aura_limb].limbs)
                .copied()
                .collect();
            let nearest = |frame: &Frame| nearest_limb(skin, frames, &limbs, surfaces, frame);
            let Some(NearestLimb { distance, limb, point, toward }) = nearest(&at(place)) else { continue };
            let (velocity, acceleration) = followed.motion();
            let before = nearest(&at(place - velocity * 1e-3));
            let speed = before.map_or(0.0, |before| (before.distance - distance) / 1e-3);
            let (point, toward) = (frames[limb].inverse_point(&point), frames[limb].rotation.tr_mul(&toward));
            followed.seen_from.push_back(frames.iter().map(|frame| frame.inverse_point(&place)).collect());
            if followed.seen_from.len() > LOOKS {
                followed.seen_from.pop_front();
            }
            let of_limb = |limb: usize| nearest_limb(skin, frames, &[limb], surfaces, &at(place));
            let touching = if distance < STILL_TOUCHING {
                followed.touching(time, &limbs, &of_limb)
            } else {
                Vec::new()
            };
            // What touches a limb and moves into it goes no farther.
            let stopped = touching.iter().any(|touched| {
                let toward = frames[touched.limb].rotation.tr_mul(&touched.toward);
                followed.seen_moving(touched.limb).is_some_and(|seen| seen.dot(&toward) < -STOPPED)
            });
            let threatened: Vec<usize> = limbs
                .iter()
                .copied()
                .filter(|&limb| {
                    !touching.iter().any(|touched| touched.limb == limb) && !followed.goes_along(limb)
                })
                .collect();
            let threatened = |frame: &Frame| nearest_limb(skin, frames, &threatened, surfaces, frame);
            // What the skin carries is shaken by it: how it speeds up says nothing of where it goes.
            let motion = if touching.is_empty() {
                (velocity, acceleration)
            } else {
                (followed.drift(), Vector3::zeros())
            };
            let found = (!stopped).then(|| predict(&threatened, &at, place, motion)).flatten();
            followed.foreseen = match (followed.foreseen, &found) {
                (Some((limb, looks)), Some((_, again, _))) if limb == *again => Some((limb, looks + 1)),
                (_, found) => found.as_ref().map(|(_, limb, _)| (*limb, 1)),
            };
            // Shaken things seem to go anywhere for a moment.
            let steady = touching.is_empty() || followed.foreseen.is_some_and(|(_, looks)| looks >= LOOKS);
            let found = found.filter(|_| steady);
            let contact = found.map(|(seconds, limb, point)| {
                let receptors = likeliest(skin, limb, &frames[limb].inverse_point(&point));
                PredictedContact { limb, seconds, receptors }
            });
            let aura_limb = body.creature.aura_of(limb).unwrap_or(within[0].aura_limb);
            let approach = Approach { object, aura_limb, limb, distance, point, toward, speed, contact };
            if !std::mem::replace(&mut followed.within, true) {
                events.push(AuraEvent::Entered(approach.clone()));
            }
            let predicted = approach.contact.as_ref().map(|contact| contact.limb);
            if predicted.is_some() && predicted != followed.alarm {
                events.push(AuraEvent::Alarm(approach.clone()));
            }
            followed.alarm = predicted;
            followed.approach = Some(approach);
        }
        events
    }
}

impl Followed {
    /// The limbs that it touches at a look, with where: what is in reach of nothing has touched nothing.
    fn touching(
        &mut self,
        time: f64,
        limbs: &[usize],
        of_limb: &dyn Fn(usize) -> Option<NearestLimb>,
    ) -> Vec<NearestLimb> {
        let mut touching = Vec::new();
        for nearest in limbs.iter().filter_map(|&limb| of_limb(limb)) {
            if nearest.distance < TOUCHING {
                self.touched.insert(nearest.limb, time);
            }
            let surely = self.touched.get(&nearest.limb);
            if nearest.distance < STILL_TOUCHING && surely.is_some_and(|surely| time - surely <= FLICKER) {
                touching.push(nearest);
            }
        }
        touching
    }

    /// How it moves as seen from a limb, in that limb's frame, metres a second; none where it was seen but once.
    fn seen_moving(&self, limb: usize) -> Option<Vector3<f64>> {
        let seen = self.seen_from.len();
        let (first, last) = (self.seen_from.front()?, self.seen_from.back()?);
        let begun = self.looks.get(self.looks.len().checked_sub(seen)?)?.0;
        let seconds = self.looks.back()?.0 - begun;
        (seconds > 0.0).then(|| (last[limb] - first[limb]) / seconds)
    }

    /// Whether it moves and a limb moves with it, as one that holds it does, or that it lies on.
    fn goes_along(&self, limb: usize) -> bool {
        let begun = self.looks.len().checked_sub(self.seen_from.len()).and_then(|k| self.looks.get(k));
        let (Some(begun), Some(now), Some(seen)) = (begun, self.looks.back(), self.seen_moving(limb)) else {
            return false;
        };
        let speed = (now.1 - begun.1).norm() / (now.0 - begun.0);
        seen.norm() < ALONG * speed
    }

    /// Its mean velocity over all looks, metres a second.
    fn drift(&self) -> Vector3<f64> {
        let [Some(first), Some(last)] = [self.looks.front(), self.looks.back()] else {
            return Vector3::zeros();
        };
        if last.0 > first.0 { (last.1 - first.1) / (last.0 - first.0) } else { Vector3::zeros() }
    }

    /// Velocity now and acceleration, metres and seconds, by the parabola through three looks.
    fn motion(&self) -> (Vector3<f64>, Vector3<f64>) {
        let looks: Vec<&(f64, Vector3<f64>)> = self.looks.iter().collect();
        let none = (Vector3::zeros(), Vector3::zeros());
        match looks.as_slice() {
            [] | [_] => none,
            [a, b] => ((b.1 - a.1) / (b.0 - a.0), Vector3::zeros()),
            [a, .., c] => {
                let b = looks[looks.len() / 2];
                let (first, second) = ((b.1 - a.1) / (b.0 - a.0), (c.1 - b.1) / (c.0 - b.0));
                let acceleration = (second - first) / (0.5 * (c.0 - a.0));
                (second + acceleration * (0.5 * (c.0 - b.0)), acceleration)
            }
        }
    }
}

/// The nearest of some limbs to an object in a frame `X_WO`.
fn nearest_limb(
    skin: &Skin,
    frames: &[Frame],
    limbs: &[usize],
    object: &[Surface],
    x_wo: &Frame,
) -> Option<NearestLimb> {
    let mut best: Option<NearestLimb> = None;
    for surface in skin.surfaces.iter().filter(|surface| limbs.contains(&surface.limb)) {
        let Some(first) = surface.placed(&frames[surface.limb]) else { continue };
        for second in object.iter().filter_map(|part| part.placed(x_wo)) {
            let found = gap(&first, &second, Precision::Exact);
            if best.is_none_or(|best| found.distance < best.distance) {
                let (point, toward) = (found.points[0], -found.normal);
                best = Some(NearestLimb { distance: found.distance, limb: surface.limb, point, toward });
            }
        }
    }
    best
}

/// When, in seconds, an object that goes on as it does first meets a limb, which, and where, in the world: it goes
/// forward as far as nothing is near, for nothing can be hit sooner.
fn predict(
    nearest: &dyn Fn(&Frame) -> Option<NearestLimb>,
    at: &dyn Fn(Vector3<f64>) -> Frame,
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
        let NearestLimb { distance, limb, point, .. } = nearest(&at(there))?;
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

/// The receptors of a limb that are nearest to a point of it.
fn likeliest(skin: &Skin, limb: usize, p_l: &Vector3<f64>) -> Vec<usize> {
    let mut on_limb: Vec<usize> =
        (0..skin.receptors.len()).filter(|&r| skin.receptors[r].limb == limb).collect();
    let distance = |&r: &usize| (skin.receptors[r].position - p_l).norm();
    on_limb.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    on_limb.truncate(RECEPTORS_NAMED);
    on_limb
}
