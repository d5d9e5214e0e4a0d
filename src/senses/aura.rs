//! The aura: proximity geometries about the limbs that tell what is about to touch, and where.
//!
//! "Around every geometry representing a limb of Max's body, 17 proximity geometries were added forming a 'proximity
//! aura'" (IVA 2009, section 2). Here a limb's geometry is a capsule about its surfaces, grown by how far it
//! reaches; it takes part in no contact. What is inside one is measured exactly, against the surfaces of its limb:
//! the engine's own distances between shapes that do not touch are right for capsules and boxes alone.

use std::collections::{BTreeMap, VecDeque};

use nalgebra::{Point3, Vector3};

use crate::creature::Body;
use crate::geometry::{Ball, Capsule, Frame, Precision, gap};
use crate::mujoco::Data;
use crate::skin::{Skin, Surface, surface_of_body};

/// How far an aura reaches beyond its limb, metres: an object of 1 m/s is noticed a third of a second before.
pub const REACH: f64 = 0.35;
/// How far ahead a contact is predicted, seconds.
pub const HORIZON: f64 = 0.6;
/// Receptors named for a contact that is predicted.
pub const RECEPTORS_NAMED: usize = 5;
/// Every how many seconds what is near is looked at.
pub const LOOK_PERIOD: f64 = 0.01;
/// Looks from which the motion of an object is told.
const LOOKS: usize = 5;
/// An object this near counts as there, metres.
const THERE: f64 = 5e-4;

/// The proximity geometry of one aura limb: a capsule in the frame of one of its limbs.
#[derive(Clone, Debug, PartialEq)]
pub struct ProximityGeometry {
    /// The aura limb, an index into the creature's.
    pub aura_limb: usize,
    /// The limb that carries it.
    pub limb: usize,
    /// The capsule in that limb's frame, its reach beyond the limb included.
    pub capsule: Capsule,
}

impl ProximityGeometry {
    /// Whether a ball, in the frame of [`ProximityGeometry::limb`], is partly inside.
    fn holds(&self, ball: &Ball) -> bool {
        self.capsule.distance_to(ball) < 0.0
    }
}

/// Makes the proximity geometries of a creature, one for each aura limb that has a surface: about it in the
/// reference posture, whose limb frames `X_WL` are given.
pub fn grow_aura(body: &Body, skin: &Skin, frames: &[Frame]) -> Vec<ProximityGeometry> {
    let directions: Vec<Vector3<f64>> = (0..26)
        .map(|k| Vector3::new((k % 3) as f64 - 1.0, (k / 3 % 3) as f64 - 1.0, (k / 9) as f64 - 1.0))
        .filter(|direction| direction.norm() > 0.0)
        .collect();
    let geometry = |(aura_limb, aura): (usize, &crate::creature::AuraLimb)| {
        let limb = *aura.limbs.first()?;
        let mut points = Vec::new();
        for surface in skin.surfaces.iter().filter(|surface| aura.limbs.contains(&surface.limb)) {
            let farthest = directions.iter().filter_map(|direction| surface.support(direction));
            points.extend(farthest.map(|p| frames[limb].inverse_point(&frames[surface.limb].point(&p))));
        }
        let limbs = Capsule::about_points(&points)?;
        let capsule = Capsule { radius: limbs.radius + REACH, ..limbs };
        Some(ProximityGeometry { aura_limb, limb, capsule })
    };
    body.creature.aura_limbs().iter().enumerate().filter_map(geometry).collect()
}

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
    /// The contact that is predicted, if the object goes on as it does and the creature stays as it is.
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
    /// A contact is predicted, with a limb that was not predicted for this object before.
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
    pub geometries: Vec<ProximityGeometry>,
    /// Per object, its surfaces in its own body's frame.
    objects: BTreeMap<usize, Vec<Surface>>,
    followed: BTreeMap<usize, Followed>,
    next: f64,
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
    within: bool,
    alarm: Option<usize>,
    approach: Option<Approach>,
}

impl Aura {
    /// The aura of a creature whose limbs are at `X_WL` in its reference posture, with the bodies that are no part of it
    /// for objects.
    pub fn new(body: &Body, skin: &Skin, frames: &[Frame]) -> Aura {
        let geometries = grow_aura(body, skin, frames);
        let mut objects: BTreeMap<usize, Vec<Surface>> = BTreeMap::new();
        let foreign = |b: &usize| body.limb_of_body[*b].is_none() && body.model.weld(*b) != 0;
        for object in (1..body.model.nbody()).filter(foreign) {
            let surfaces = surface_of_body(&body.model, object);
            if !surfaces.is_empty() {
                objects.insert(object, surfaces);
            }
        }
        Aura { geometries, objects, followed: BTreeMap::new(), next: f64::NEG_INFINITY }
    }

    /// What is in an aura now.
    pub fn approaches(&self) -> impl Iterator<Item = &Approach> {
        self.followed.values().filter_map(|followed| followed.approach.as_ref())
    }

    /// Looks at what is near, at most every 10 ms, given data with poses of a step at `time`, seconds.
    pub fn step(&mut self, time: f64, body: &Body, skin: &Skin, data: &Data) -> Vec<AuraEvent> {
        let mut events = Vec::new();
        if time < self.next {
            return events;
        }
        self.next = time + LOOK_PERIOD - 1e-9;
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
            if followed.looks.back().is_some_and(|(_, before)| (place - before).norm() > REACH) {
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
            let contact =
                predict(&nearest, &at, place, velocity, acceleration).map(|(seconds, limb, point)| {
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
    velocity: Vector3<f64>,
    acceleration: Vector3<f64>,
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
