//! The touch sensor: from contacts, step by step, to sensations.
//!
//! "A central component, that fuses these stimulations of the receptors into a coherent touch sensation, forms our
//! touch sensor" (IVA 2009, section 2). What touches is followed over the skin from step to step, across joints, too,
//! wherever the somatotopic map has neighbours on two limbs; contacts of one party that one fingertip spans are one,
//! those farther apart are as many touches. What is followed until nothing has touched for [`RELEASE`] is one sensation,
//! told by how long it lasted and how it moved over the skin: the words are those of Yohanan and MacLean, "The Role of
//! Affective Touch in Human-Robot Interaction" (2012), without what only pictures of a hand tell apart.
//!
//! Nothing of this needs to know where the limbs are: ways are measured on each limb, and from one to the next by where
//! their skins meet, which is the same in every posture.

use nalgebra::Vector3;
use serde::Serialize;

use super::touch_trail::Trail;
use crate::senses::{Party, SkinContact, SkinSpot, Toucher};
use crate::skin::{Skin, SomatotopicMap};

/// How long nothing must touch before a sensation has ended, seconds: a fingertip that bounces over an edge comes
/// back sooner.
pub const RELEASE: f64 = 0.03;
/// A touch without a way along the skin that is shorter than this is a tap, seconds.
const TAP: f64 = 0.25;
/// Turns back after which a way along the skin is rubbing.
const TURNS_OF_RUB: usize = 1;
/// A contact goes on where the last one of the same party was, if its point is no farther along the skin, metres: so
/// far a finger of 1 m/s gets until [`RELEASE`] has passed.
const NEAR: f64 = 0.03;
/// Contacts of one party no farther apart are one touch, metres: the two sides of a crease that a fingertip lies in are
/// that far apart at the most, and two fingers side by side are farther.
const TOGETHER: f64 = 0.018;
/// The same over a joint, where the way is known less exactly, metres.
const TOGETHER_ACROSS: f64 = 0.025;
/// How far apart receptors of two limbs are taken to be where the map tells that they are neighbours, but not where the
/// skins of their limbs meet, metres: near enough to go on from one to the other, if nothing is nearer.
const SOMEWHERE_ACROSS: f64 = 0.015;
/// How near to the end of a limb's skin a touch may be about to go on to the next limb, metres.
const BRINK: f64 = 0.012;
/// How wide a gap without skin may be at a joint, metres, and how long a touch that moves is waited for there at the
/// most, seconds.
const GAP: f64 = 0.006;
const LONGEST_GAP: f64 = 0.15;

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

/// What a limb felt of one side of a sensation.
#[derive(Clone, Debug, PartialEq)]
pub struct LimbSensation {
    /// The limb.
    pub limb: usize,
    /// Where it was felt on the limb first, in the limb's frame, metres.
    pub point: Vector3<f64>,
    /// Where it was felt on the limb last, in the limb's frame, metres.
    pub end: Vector3<f64>,
    /// When it was felt on the limb first and last, seconds.
    pub span: [f64; 2],
    /// Way along the limb's skin, metres.
    pub path: f64,
    /// Unit direction from its beginning to its end on the limb, in the limb's frame; zero where it stayed.
    pub direction: Vector3<f64>,
}

/// One side of a sensation: what the skin felt, on one limb or over joints on several.
#[derive(Clone, Debug, PartialEq)]
pub struct SensationSide {
    /// The limb where it began.
    pub limb: usize,
    /// The limb where it ended.
    pub last_limb: usize,
    /// The receptors that fired, in the order in which they did first, and when they did first and last, seconds.
    pub receptors: Vec<(usize, [f64; 2])>,
    /// Where it began, in the frame of the limb where it began, metres.
    pub point: Vector3<f64>,
    /// Way along the skin, over all limbs and joints, metres.
    pub path: f64,
    /// Unit direction from its beginning to its end on the limb where it began, in that limb's frame; zero where it
    /// stayed.
    pub direction: Vector3<f64>,
    /// Mean speed along the skin, metres a second.
    pub speed: f64,
    /// Limb by limb, in the order in which they felt it first.
    pub limbs: Vec<LimbSensation>,
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
    pub sides: Vec<SensationSide>,
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
        /// The contact, all of the touch in one.
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
    surface: FeltSurface,
    touches: Vec<FollowedTouch>,
    count: u64,
    /// What touched in the last step, limb by limb.
    present: Vec<SkinContact>,
}

impl TouchSensor {
    /// A sensor of a skin that feels nothing yet.
    pub fn new(map: SomatotopicMap, skin: &Skin) -> TouchSensor {
        let normals = skin.receptors.iter().map(|receptor| receptor.normal).collect();
        let surface = FeltSurface { map, normals };
        TouchSensor { surface, touches: Vec::new(), count: 0, present: Vec::new() }
    }

    /// Which receptors it takes for neighbours.
    pub fn map(&self) -> &SomatotopicMap {
        &self.surface.map
    }

    /// Takes in the contacts of one step at `time`, seconds, later than the last one.
    pub fn step(&mut self, time: f64, contacts: &[SkinContact]) -> Vec<TouchEvent> {
        let mut events = Vec::new();
        for (touch, contacts) in self.shared_out(contacts) {
            match touch {
                Some(touch) => self.touches[touch].add(time, contacts, &self.surface),
                None => {
                    let touch = FollowedTouch::new(self.count, time, contacts);
                    events.push(TouchEvent::Began { number: self.count, contact: touch.contact() });
                    self.touches.push(touch);
                    self.count += 1;
                }
            }
        }
        self.present = if contacts.is_empty() { Vec::new() } else { self.patches(time) };
        let surface = &self.surface;
        for touch in self.touches.extract_if(.., |touch| touch.is_over(time, surface)) {
            events.push(TouchEvent::Sensed { number: touch.number, sensation: touch.sensation() });
        }
        events
    }

    /// What touches in the last step, the contacts of one party on one patch of a limb's skin as one; what began first,
    /// first.
    pub fn present(&self) -> impl Iterator<Item = &SkinContact> {
        self.present.iter()
    }

    /// Which contacts of a step are of which touch; of none where they begin one.
    fn shared_out(&self, contacts: &[SkinContact]) -> Vec<(Option<usize>, Vec<SkinContact>)> {
        // Each touch goes on with the contact that is nearest to where it was, unless that is nearer to another.
        let mut near: Vec<(f64, usize, usize)> = Vec::new();
        for (t, touch) in self.touches.iter().enumerate() {
            for (c, contact) in contacts.iter().enumerate() {
                let heads = touch.heads.iter().map(|head| self.surface.apart(head, contact));
                near.extend(heads.min_by(f64::total_cmp).filter(|d| *d <= NEAR).map(|d| (d, t, c)));
            }
        }
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut shares: Vec<(Option<usize>, Vec<SkinContact>)> = Vec::new();
        let mut taken = vec![false; contacts.len()];
        for (_, touch, contact) in near {
            if !taken[contact] && shares.iter().all(|(goes_on, _)| *goes_on != Some(touch)) {
                taken[contact] = true;
                shares.push((Some(touch), vec![contacts[contact].clone()]));
            }
        }
        // What else is within a fingertip belongs to it; what is left begins.
        loop {
            let mut nearest: Option<(f64, usize, usize)> = None;
            for c in (0..contacts.len()).filter(|&c| !taken[c]) {
                for (s, (_, share)) in shares.iter().enumerate() {
                    // How near it is, as a share of how near belongs together.
                    let near = share.iter().map(|other| {
                        let across = other.spot.limb != contacts[c].spot.limb;
                        let together = if across { TOGETHER_ACROSS } else { TOGETHER };
                        self.surface.apart(other, &contacts[c]) / together
                    });
                    let near = near.fold(f64::INFINITY, f64::min);
                    if near <= 1.0 && nearest.is_none_or(|(least, ..)| near < least) {
                        nearest = Some((near, s, c));
                    }
                }
            }
            if let Some((_, share, contact)) = nearest {
                taken[contact] = true;
                shares[share].1.push(contacts[contact].clone());
            } else if let Some(first) = taken.iter().position(|taken| !taken) {
                taken[first] = true;
                shares.push((None, vec![contacts[first].clone()]));
            } else {
                return shares;
            }
        }
    }

    /// Contacts of the last step, at `time`, of one party and of one patch of a limb's skin as one.
    fn patches(&self, time: f64) -> Vec<SkinContact> {
        let touching = self.touches.iter().filter(|touch| touch.last == time);
        let heads = touching.flat_map(|touch| &touch.heads).map(earlier_first);
        let mut patches: Vec<Vec<SkinContact>> = Vec::new();
        for contact in heads {
            let belongs = |patch: &Vec<SkinContact>| {
                patch.iter().any(|other| self.surface.is_one_patch(&contact, other))
            };
            match patches.iter().position(belongs) {
                Some(first) => {
                    let joined: Vec<_> = patches.extract_if(first + 1.., |patch| belongs(patch)).collect();
                    patches[first].extend(joined.into_iter().flatten().chain([contact]));
                }
                None => patches.push(vec![contact]),
            }
        }
        patches.iter().map(|patch| fused(patch.iter())).collect()
    }
}

/// The skin as the sensor knows it: how far apart places on it are.
#[derive(Clone, Debug)]
pub(super) struct FeltSurface {
    map: SomatotopicMap,
    /// Per receptor, its outward normal in its limb's frame.
    normals: Vec<Vector3<f64>>,
}

impl FeltSurface {
    /// About how long the way along the skin is from one place to another, metres; infinite where none is known.
    pub fn way(&self, a: &SkinSpot, b: &SkinSpot) -> f64 {
        if a.limb == b.limb {
            // Round a limb, not through it: an arc between the two normals.
            let cosine = self.normals[a.receptor].dot(&self.normals[b.receptor]).clamp(-1.0, 1.0);
            let half = 0.5 * cosine.acos();
            let arc = if half > 1e-3 { half / half.sin() } else { 1.0 };
            return (a.point - b.point).norm() * arc;
        }
        match self.map.way_across((a.limb, a.point), (b.limb, b.point)) {
            Some(way) => way,
            None if self.map.adjacent(a.receptor, b.receptor) => SOMEWHERE_ACROSS,
            None => f64::INFINITY,
        }
    }

    /// Whether a place is where the skin of its limb ends and that of another begins.
    fn is_brink(&self, spot: &SkinSpot) -> bool {
        self.map.way_to_border(spot.limb, &spot.point).is_some_and(|way| way <= BRINK)
    }

    /// How far two contacts are apart along the skin, both places of a self-touch; infinite for those of two parties.
    fn apart(&self, a: &SkinContact, b: &SkinContact) -> f64 {
        match (&a.by, &b.by) {
            (Toucher::Own(one), Toucher::Own(other)) => {
                let straight = self.way(&a.spot, &b.spot).max(self.way(one, other));
                let turned = self.way(&a.spot, other).max(self.way(one, &b.spot));
                straight.min(turned)
            }
            (one, other) if one.party() == other.party() => self.way(&a.spot, &b.spot),
            _ => f64::INFINITY,
        }
    }

    /// Whether contacts are of one party on one limb, or on the same two, at neighbouring receptors.
    fn is_one_patch(&self, a: &SkinContact, b: &SkinContact) -> bool {
        let near = |a: &SkinSpot, b: &SkinSpot| self.map.adjacent(a.receptor, b.receptor);
        a.parties() == b.parties()
            && near(&a.spot, &b.spot)
            && match (&a.by, &b.by) {
                (Toucher::Own(a), Toucher::Own(b)) => near(a, b),
                _ => true,
            }
    }

    /// A self-touch told from its other side, where that fits another better.
    fn turned_like(&self, model: &SkinContact, contact: SkinContact) -> SkinContact {
        let (Toucher::Own(model_own), Toucher::Own(own)) = (&model.by, &contact.by) else { return contact };
        let straight = self.way(&model.spot, &contact.spot).max(self.way(model_own, own));
        let turned = self.way(&model.spot, own).max(self.way(model_own, &contact.spot));
        if turned < straight {
            SkinContact { spot: *own, by: Toucher::Own(contact.spot), ..contact }
        } else {
            contact
        }
    }
}

/// A self-touch as it is told outside: the place on the earlier limb first.
fn earlier_first(contact: &SkinContact) -> SkinContact {
    match contact.by {
        Toucher::Own(own) if own.limb < contact.spot.limb => {
            SkinContact { spot: own, by: Toucher::Own(contact.spot), force: contact.force }
        }
        _ => contact.clone(),
    }
}

/// Contacts of one party as one: forces add up, places are their mean by force, of those on the limb of the strongest.
fn fused<'a>(contacts: impl Iterator<Item = &'a SkinContact> + Clone) -> SkinContact {
    let strongest = contacts.clone().max_by(|a, b| a.force.total_cmp(&b.force)).expect("there is a contact");
    let mean = |strongest: SkinSpot, spot: &dyn Fn(&SkinContact) -> Option<SkinSpot>| {
        let (mut sum, mut weight) = (Vector3::zeros(), 0.0);
        for contact in contacts.clone() {
            if let Some(spot) = spot(contact).filter(|spot| spot.limb == strongest.limb) {
                sum += spot.point * contact.force;
                weight += contact.force;
            }
        }
        SkinSpot { point: sum / weight, ..strongest }
    };
    let by = match strongest.by {
        Toucher::Own(other) => Toucher::Own(mean(other, &|contact| contact.by.own())),
        thing => thing,
    };
    let force = contacts.clone().map(|contact| contact.force).sum();
    SkinContact { spot: mean(strongest.spot, &|contact| Some(contact.spot)), by, force }
}

/// Something that touches, followed from step to step.
#[derive(Clone, Debug)]
struct FollowedTouch {
    number: u64,
    began: f64,
    last: f64,
    /// Its contacts in the last step in which it touched.
    heads: Vec<SkinContact>,
    trails: Vec<Trail>,
    peak: f64,
    sum: f64,
    steps: usize,
}

impl FollowedTouch {
    fn new(number: u64, time: f64, contacts: Vec<SkinContact>) -> FollowedTouch {
        let contact = fused(contacts.iter());
        FollowedTouch {
            number,
            began: time,
            last: time,
            trails: contact.spots().map(|spot| Trail::new(time, &spot)).collect(),
            heads: contacts,
            peak: contact.force,
            sum: contact.force,
            steps: 1,
        }
    }

    /// All its contacts as one.
    fn contact(&self) -> SkinContact {
        fused(self.heads.iter())
    }

    fn add(&mut self, time: f64, contacts: Vec<SkinContact>, surface: &FeltSurface) {
        let before = self.heads[0].clone();
        let contacts: Vec<SkinContact> =
            contacts.into_iter().map(|contact| surface.turned_like(&before, contact)).collect();
        for (k, trail) in self.trails.iter_mut().enumerate() {
            let spots = contacts.iter().filter_map(|contact| Some((contact.spots().nth(k)?, contact.force)));
            trail.add(time, spots, surface);
        }
        self.last = time;
        self.heads = contacts;
        let force: f64 = self.heads.iter().map(|contact| contact.force).sum();
        self.peak = self.peak.max(force);
        self.sum += force;
        self.steps += 1;
    }

    /// Whether nothing has touched for so long that it has ended: for longer where it was about to go on to another limb.
    fn is_over(&self, time: f64, surface: &FeltSurface) -> bool {
        let silent = time - self.last;
        if silent <= RELEASE || silent > RELEASE + LONGEST_GAP {
            return silent > RELEASE;
        }
        let brink = self.heads.iter().flat_map(SkinContact::spots).any(|spot| surface.is_brink(&spot));
        let pace = self.trails.iter().filter_map(|trail| trail.pace(self.last)).fold(0.0, f64::max);
        !brink || pace == 0.0 || silent > RELEASE + GAP / pace
    }

    fn sensation(self) -> Sensation {
        let duration = self.last - self.began;
        let moving = self.trails.iter().filter(|trail| trail.moves());
        let turns = moving.map(Trail::turns).max();
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
            by: self.heads[0].by.party(),
            sides: self.trails.iter().map(|trail| trail.side(duration)).collect(),
            peak_force: self.peak,
            mean_force: self.sum / self.steps as f64,
        }
    }
}
