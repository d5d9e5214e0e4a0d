//! The touch sensor: from contacts, step by step, to sensations.
//!
//! "A central component, that fuses these stimulations of the receptors into a coherent touch sensation, forms our
//! touch sensor" (IVA 2009, section 2). Contacts of one step with the same other party are one cluster where their
//! receptors are the same or neighbours in the somatotopic map. Clusters are followed from step to step; what is
//! followed until nothing has touched for [`RELEASE`] is one sensation, told by how long it lasted and how it moved
//! over the skin: the words are those of Yohanan and MacLean, "The Role of Affective Touch in Human-Robot
//! Interaction" (2012), without what only pictures of a hand tell apart.

use nalgebra::Vector3;
use serde::Serialize;

use crate::creature::Body;
use crate::mujoco::Data;
use crate::senses::{ContactReader, Reading, TouchEnd};
use crate::skin::{Skin, SomatotopicMap};

/// How long nothing must touch before a sensation has ended, seconds: a fingertip that bounces over an edge comes
/// back sooner.
pub const RELEASE: f64 = 0.03;
/// Contacts weaker than this are not felt, newtons.
pub const FAINT: f64 = 1e-3;
/// A touch without a way along the skin that is shorter than this is a tap, seconds.
const TAP: f64 = 0.25;
/// Way along the skin from which on a touch moves, metres: the point of contact of something soft shifts as it presses.
const MOVES: f64 = 0.012;
/// Steps in which a way along the skin is measured, metres: less is the jitter of a point of contact.
const STRIDE: f64 = 0.004;
/// Turns back after which a way along the skin is rubbing.
const TURNS_OF_RUB: usize = 1;
/// A cluster goes on where the last one of the same party was, if its point is no farther, metres.
const NEAR: f64 = 0.03;

/// What kind of touch it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Short, and at one place.
    Tap,
    /// Longer, and at one place.
    Press,
    /// Along the skin.
    Stroke,
    /// Along the skin to and fro.
    Rub,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Kind; 4] = [Kind::Tap, Kind::Press, Kind::Stroke, Kind::Rub];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Tap => "tap",
            Kind::Press => "press",
            Kind::Stroke => "stroke",
            Kind::Rub => "rub",
        }
    }
}

/// One side of a contact: a place on the skin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The limb.
    pub limb: usize,
    /// The receptor that holds the point.
    pub receptor: usize,
    /// The point in the limb's frame, metres.
    pub point: Vector3<f64>,
}

/// A contact with the skin in one step.
#[derive(Clone, Debug, PartialEq)]
pub struct SkinContact {
    /// The place on the skin; the one on the earlier limb of a self-touch.
    pub place: Place,
    /// The other place of a self-touch.
    pub other: Option<Place>,
    /// The model's body that touches, where it is not the creature's own.
    pub object: Option<usize>,
    /// Normal force, newtons.
    pub force: f64,
}

impl SkinContact {
    /// Its places on the skin: one, or the two of a self-touch.
    pub fn places(&self) -> impl Iterator<Item = Place> {
        std::iter::once(self.place).chain(self.other)
    }
}

/// The contacts of the skin in the step that `data` has just made, between limbs that are not neighbours and with
/// everything else.
pub fn skin_contacts(body: &Body, skin: &Skin, reader: &ContactReader, data: &Data) -> Vec<SkinContact> {
    let mut found = Vec::new();
    for (contact, force) in data.pressing().filter(|(_, force)| *force >= FAINT) {
        let place = |end: TouchEnd| Place {
            limb: skin.receptors[end.receptor].limb,
            receptor: end.receptor,
            point: end.contact,
        };
        match reader.read(body, skin, data, &contact) {
            Reading::Touch([a, b]) => {
                found.push(SkinContact { place: place(a), other: Some(place(b)), object: None, force });
            }
            Reading::Foreign => {
                // The side that has skin is the creature's.
                let ends = reader.ends(body, skin, data, &contact).into_iter().zip([1, 0]);
                found.extend(ends.filter_map(|(end, other)| {
                    let object = Some(body.model.geom_body(contact.geoms[other]));
                    Some(SkinContact { place: place(end?), other: None, object, force })
                }));
            }
            // Bare on one side of a self-touch: the other side alone cannot tell whom it feels.
            Reading::Bare | Reading::Neighbours => {}
        }
    }
    found
}

/// One side of a sensation: what a limb felt.
#[derive(Clone, Debug, PartialEq)]
pub struct Side {
    /// The limb.
    pub limb: usize,
    /// The receptors that fired, in the order in which they did first, and when they did first and last, seconds.
    pub receptors: Vec<(usize, [f64; 2])>,
    /// Where it began, in the limb's frame, metres.
    pub point: Vector3<f64>,
    /// Way along the skin, metres.
    pub path: f64,
    /// Unit direction from its beginning to its end, in the limb's frame; zero where it stayed.
    pub direction: Vector3<f64>,
    /// Mean speed along the skin, metres a second.
    pub speed: f64,
}

/// A coherent touch, from its beginning to its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensation {
    /// When it began, seconds.
    pub began: f64,
    /// When it touched last, seconds.
    pub ended: f64,
    /// What kind of touch it was.
    pub kind: Kind,
    /// The model's body that touched; none where the creature touched itself.
    pub object: Option<usize>,
    /// One side, or the two of a self-touch.
    pub sides: Vec<Side>,
    /// Greatest normal force, newtons.
    pub peak_force: f64,
    /// Mean normal force, newtons.
    pub mean_force: f64,
}

/// What the touch sensor tells in a step.
#[derive(Clone, Debug, PartialEq)]
pub enum TouchEvent {
    /// Something began to touch: its number, and where.
    Began {
        /// The number of the sensation, counted from 0.
        number: u64,
        /// The contact, all of its cluster in one.
        contact: SkinContact,
    },
    /// A sensation has ended and is understood.
    Sensed {
        /// The number it began with.
        number: u64,
        /// The sensation.
        sensation: Sensation,
    },
}

/// Follows what touches the skin.
#[derive(Clone, Debug)]
pub struct TouchSensor {
    map: SomatotopicMap,
    tracks: Vec<Track>,
    count: u64,
}

impl TouchSensor {
    /// A sensor that feels nothing yet.
    pub fn new(map: SomatotopicMap) -> TouchSensor {
        TouchSensor { map, tracks: Vec::new(), count: 0 }
    }

    /// Takes in the contacts of one step at `time`, seconds, later than the last one.
    pub fn step(&mut self, time: f64, contacts: &[SkinContact]) -> Vec<TouchEvent> {
        let mut events = Vec::new();
        for cluster in self.clusters(contacts) {
            let found = self.tracks.iter().position(|track| track.goes_on(&cluster, &self.map));
            match found {
                Some(found) => self.tracks[found].add(time, &cluster),
                None => {
                    events.push(TouchEvent::Began { number: self.count, contact: cluster.clone() });
                    self.tracks.push(Track::new(self.count, time, &cluster));
                    self.count += 1;
                }
            }
        }
        let mut k = 0;
        while k < self.tracks.len() {
            if time - self.tracks[k].last > RELEASE {
                let track = self.tracks.remove(k);
                events.push(TouchEvent::Sensed { number: track.number, sensation: track.sensation() });
            } else {
                k += 1;
            }
        }
        events
    }

    /// Contacts of one party and of one patch of skin as one: forces add up, places are their mean by force.
    fn clusters(&self, contacts: &[SkinContact]) -> Vec<SkinContact> {
        let mut clusters: Vec<Vec<&SkinContact>> = Vec::new();
        for contact in contacts {
            let belongs = |cluster: &Vec<&SkinContact>| {
                cluster.iter().any(|other| same_party(contact, other) && self.adjacent(contact, other))
            };
            let (joined, rest): (Vec<_>, Vec<_>) = clusters.into_iter().partition(belongs);
            clusters = rest;
            clusters.push(joined.into_iter().flatten().chain([contact]).collect());
        }
        clusters.iter().map(|cluster| fused(cluster)).collect()
    }

    fn adjacent(&self, a: &SkinContact, b: &SkinContact) -> bool {
        let near = |a: &Place, b: &Place| self.map.adjacent(a.receptor, b.receptor);
        near(&a.place, &b.place)
            && match (&a.other, &b.other) {
                (Some(a), Some(b)) => near(a, b),
                _ => true,
            }
    }
}

fn same_party(a: &SkinContact, b: &SkinContact) -> bool {
    let limbs = |contact: &SkinContact| (contact.place.limb, contact.other.map(|place| place.limb));
    a.object == b.object && limbs(a) == limbs(b)
}

fn fused(cluster: &[&SkinContact]) -> SkinContact {
    let strongest =
        cluster.iter().max_by(|a, b| a.force.total_cmp(&b.force)).expect("a cluster has contacts");
    let force: f64 = cluster.iter().map(|contact| contact.force).sum();
    let mean = |place: &dyn Fn(&SkinContact) -> Option<Place>| {
        let sum: Vector3<f64> =
            cluster.iter().filter_map(|contact| Some(place(contact)?.point * contact.force)).sum();
        place(strongest).map(|place| Place { point: sum / force, ..place })
    };
    SkinContact {
        place: mean(&|contact| Some(contact.place)).expect("it has a place"),
        other: mean(&|contact| contact.other),
        object: strongest.object,
        force,
    }
}

/// One side of what is being followed.
#[derive(Clone, Debug)]
struct Trail {
    limb: usize,
    receptors: Vec<(usize, [f64; 2])>,
    start: Vector3<f64>,
    now: Vector3<f64>,
    /// Where the last stride ended, and its direction.
    anchor: Vector3<f64>,
    heading: Option<Vector3<f64>>,
    path: f64,
    turns: usize,
}

impl Trail {
    fn new(time: f64, place: &Place) -> Trail {
        Trail {
            limb: place.limb,
            receptors: vec![(place.receptor, [time; 2])],
            start: place.point,
            now: place.point,
            anchor: place.point,
            heading: None,
            path: 0.0,
            turns: 0,
        }
    }

    fn add(&mut self, time: f64, place: &Place) {
        match self.receptors.iter_mut().find(|(receptor, _)| *receptor == place.receptor) {
            Some((_, span)) => span[1] = time,
            None => self.receptors.push((place.receptor, [time; 2])),
        }
        self.now = place.point;
        let stride = self.now - self.anchor;
        let length = stride.norm();
        if length < STRIDE {
            return;
        }
        let heading = stride / length;
        if self.heading.is_some_and(|before| before.dot(&heading) < -0.3) {
            self.turns += 1;
        }
        self.path += length;
        self.anchor = self.now;
        self.heading = Some(heading);
    }

    fn moves(&self) -> bool {
        self.path >= MOVES
    }

    fn side(&self, duration: f64) -> Side {
        let way = self.now - self.start;
        let direction =
            if self.moves() { way.try_normalize(1e-9).unwrap_or_default() } else { Vector3::zeros() };
        let speed = if self.moves() && duration > 0.0 { self.path / duration } else { 0.0 };
        let receptors = self.receptors.clone();
        Side { limb: self.limb, receptors, point: self.start, path: self.path, direction, speed }
    }
}

/// Something that touches, followed from step to step.
#[derive(Clone, Debug)]
struct Track {
    number: u64,
    began: f64,
    last: f64,
    contact: SkinContact,
    trails: Vec<Trail>,
    peak: f64,
    sum: f64,
    steps: usize,
}

impl Track {
    fn new(number: u64, time: f64, contact: &SkinContact) -> Track {
        Track {
            number,
            began: time,
            last: time,
            contact: contact.clone(),
            trails: contact.places().map(|place| Trail::new(time, &place)).collect(),
            peak: contact.force,
            sum: contact.force,
            steps: 1,
        }
    }

    fn goes_on(&self, contact: &SkinContact, map: &SomatotopicMap) -> bool {
        let (before, now) = (&self.contact.place, &contact.place);
        let near = || (before.point - now.point).norm() < NEAR;
        same_party(&self.contact, contact) && (map.adjacent(before.receptor, now.receptor) || near())
    }

    fn add(&mut self, time: f64, contact: &SkinContact) {
        self.last = time;
        self.contact = contact.clone();
        self.trails.iter_mut().zip(contact.places()).for_each(|(trail, place)| trail.add(time, &place));
        self.peak = self.peak.max(contact.force);
        self.sum += contact.force;
        self.steps += 1;
    }

    fn sensation(self) -> Sensation {
        let duration = self.last - self.began;
        let moving = self.trails.iter().filter(|trail| trail.moves());
        let turns = moving.map(|trail| trail.turns).max();
        let kind = match turns {
            Some(turns) if turns >= TURNS_OF_RUB => Kind::Rub,
            Some(_) => Kind::Stroke,
            None if duration < TAP => Kind::Tap,
            None => Kind::Press,
        };
        Sensation {
            began: self.began,
            ended: self.last,
            kind,
            object: self.contact.object,
            sides: self.trails.iter().map(|trail| trail.side(duration)).collect(),
            peak_force: self.peak,
            mean_force: self.sum / self.steps as f64,
        }
    }
}
