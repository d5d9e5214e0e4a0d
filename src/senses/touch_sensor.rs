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

use crate::senses::{Party, SkinContact, SkinSpot, Toucher};
use crate::skin::SomatotopicMap;

/// How long nothing must touch before a sensation has ended, seconds: a fingertip that bounces over an edge comes
/// back sooner.
pub const RELEASE: f64 = 0.03;
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
pub enum TouchKind {
    /// Short, and at one place.
    Tap,
    /// Longer, and at one place.
    Press,
    /// Along the skin.
    Stroke,
    /// Along the skin to and fro.
    Rub,
}

impl TouchKind {
    /// All kinds.
    pub const ALL: [TouchKind; 4] = [TouchKind::Tap, TouchKind::Press, TouchKind::Stroke, TouchKind::Rub];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            TouchKind::Tap => "tap",
            TouchKind::Press => "press",
            TouchKind::Stroke => "stroke",
            TouchKind::Rub => "rub",
        }
    }
}

/// One side of a sensation: what a limb felt.
#[derive(Clone, Debug, PartialEq)]
pub struct LimbSensation {
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
    pub kind: TouchKind,
    /// Who touched.
    pub by: Party,
    /// One side, or the two of a self-touch.
    pub sides: Vec<LimbSensation>,
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
    tracks: Vec<FollowedTouch>,
    count: u64,
    /// When the last step was, seconds.
    now: f64,
}

impl TouchSensor {
    /// A sensor that feels nothing yet.
    pub fn new(map: SomatotopicMap) -> TouchSensor {
        TouchSensor { map, tracks: Vec::new(), count: 0, now: f64::NEG_INFINITY }
    }

    /// Takes in the contacts of one step at `time`, seconds, later than the last one.
    pub fn step(&mut self, time: f64, contacts: &[SkinContact]) -> Vec<TouchEvent> {
        let mut events = Vec::new();
        self.now = time;
        for cluster in self.clusters(contacts) {
            let found = self.tracks.iter().position(|track| track.goes_on(&cluster, &self.map));
            match found {
                Some(found) => self.tracks[found].add(time, &cluster),
                None => {
                    events.push(TouchEvent::Began { number: self.count, contact: cluster.clone() });
                    self.tracks.push(FollowedTouch::new(self.count, time, &cluster));
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

    /// What touches in the last step, the contacts of one party on one patch of skin as one; what began first, first.
    pub fn present(&self) -> impl Iterator<Item = &SkinContact> {
        self.tracks.iter().filter(|track| track.last == self.now).map(|track| &track.contact)
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
        let near = |a: &SkinSpot, b: &SkinSpot| self.map.adjacent(a.receptor, b.receptor);
        near(&a.spot, &b.spot)
            && match (&a.by, &b.by) {
                (Toucher::Own(a), Toucher::Own(b)) => near(a, b),
                _ => true,
            }
    }
}

fn same_party(a: &SkinContact, b: &SkinContact) -> bool {
    a.parties() == b.parties()
}

fn fused(cluster: &[&SkinContact]) -> SkinContact {
    let strongest =
        cluster.iter().max_by(|a, b| a.force.total_cmp(&b.force)).expect("a cluster has contacts");
    let force: f64 = cluster.iter().map(|contact| contact.force).sum();
    let mean = |strongest: SkinSpot, spot: &dyn Fn(&SkinContact) -> Option<SkinSpot>| {
        let sum: Vector3<f64> =
            cluster.iter().filter_map(|contact| Some(spot(contact)?.point * contact.force)).sum();
        SkinSpot { point: sum / force, ..strongest }
    };
    let by = match strongest.by {
        Toucher::Own(other) => Toucher::Own(mean(other, &|contact| contact.by.own())),
        thing => thing,
    };
    SkinContact { spot: mean(strongest.spot, &|contact| Some(contact.spot)), by, force }
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
    fn new(time: f64, spot: &SkinSpot) -> Trail {
        Trail {
            limb: spot.limb,
            receptors: vec![(spot.receptor, [time; 2])],
            start: spot.point,
            now: spot.point,
            anchor: spot.point,
            heading: None,
            path: 0.0,
            turns: 0,
        }
    }

    fn add(&mut self, time: f64, spot: &SkinSpot) {
        match self.receptors.iter_mut().find(|(receptor, _)| *receptor == spot.receptor) {
            Some((_, span)) => span[1] = time,
            None => self.receptors.push((spot.receptor, [time; 2])),
        }
        self.now = spot.point;
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

    fn side(&self, duration: f64) -> LimbSensation {
        let way = self.now - self.start;
        let direction =
            if self.moves() { way.try_normalize(1e-9).unwrap_or_default() } else { Vector3::zeros() };
        let speed = if self.moves() && duration > 0.0 { self.path / duration } else { 0.0 };
        let receptors = self.receptors.clone();
        LimbSensation { limb: self.limb, receptors, point: self.start, path: self.path, direction, speed }
    }
}

/// Something that touches, followed from step to step.
#[derive(Clone, Debug)]
struct FollowedTouch {
    number: u64,
    began: f64,
    last: f64,
    contact: SkinContact,
    trails: Vec<Trail>,
    peak: f64,
    sum: f64,
    steps: usize,
}

impl FollowedTouch {
    fn new(number: u64, time: f64, contact: &SkinContact) -> FollowedTouch {
        FollowedTouch {
            number,
            began: time,
            last: time,
            contact: contact.clone(),
            trails: contact.spots().map(|spot| Trail::new(time, &spot)).collect(),
            peak: contact.force,
            sum: contact.force,
            steps: 1,
        }
    }

    fn goes_on(&self, contact: &SkinContact, map: &SomatotopicMap) -> bool {
        let (before, now) = (&self.contact.spot, &contact.spot);
        let near = || (before.point - now.point).norm() < NEAR;
        same_party(&self.contact, contact) && (map.adjacent(before.receptor, now.receptor) || near())
    }

    fn add(&mut self, time: f64, contact: &SkinContact) {
        self.last = time;
        self.contact = contact.clone();
        self.trails.iter_mut().zip(contact.spots()).for_each(|(trail, spot)| trail.add(time, &spot));
        self.peak = self.peak.max(contact.force);
        self.sum += contact.force;
        self.steps += 1;
    }

    fn sensation(self) -> Sensation {
        let duration = self.last - self.began;
        let moving = self.trails.iter().filter(|trail| trail.moves());
        let turns = moving.map(|trail| trail.turns).max();
        let kind = match turns {
            Some(turns) if turns >= TURNS_OF_RUB => TouchKind::Rub,
            Some(_) => TouchKind::Stroke,
            None if duration < TAP => TouchKind::Tap,
            None => TouchKind::Press,
        };
        Sensation {
            began: self.began,
            ended: self.last,
            kind,
            by: self.contact.by.party(),
            sides: self.trails.iter().map(|trail| trail.side(duration)).collect(),
            peak_force: self.peak,
            mean_force: self.sum / self.steps as f64,
        }
    }
}
