//! Something that touches, followed from step to step until it is understood.

use nalgebra::Vector3;

use super::felt_surface::FeltSurface;
use super::touch_sensor::RELEASE;
use super::touch_trail::Trail;
use super::{Sensation, SkinContact, SkinSpot, TouchKind, Toucher};

/// A touch without a way along the skin that is shorter than this is a tap, seconds.
const TAP: f64 = 0.25;
/// Turns back after which a way along the skin is rubbing.
const TURNS_OF_RUB: usize = 1;
/// How wide a gap without skin may be at a joint, metres, and how long a touch that moves is waited for there at the
/// most, seconds.
const GAP: f64 = 0.006;
const LONGEST_GAP: f64 = 0.15;
/// How far a touch may go over skin without receptors, metres, and how long it is waited for there at the most, seconds.
const BARE: f64 = 0.05;
const LONGEST_BARE: f64 = 0.5;

/// Something that touches, followed from step to step.
#[derive(Clone, Debug)]
pub(super) struct FollowedTouch {
    /// Counted from 0.
    pub number: u64,
    began: f64,
    /// When it touched last, seconds.
    pub last: f64,
    /// Its contacts in the last step in which it touched.
    pub heads: Vec<SkinContact>,
    trails: Vec<Trail>,
    peak: f64,
    sum: f64,
    steps: usize,
}

impl FollowedTouch {
    /// What begins at `time` with these contacts.
    pub fn new(number: u64, time: f64, contacts: Vec<SkinContact>) -> FollowedTouch {
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
    pub fn contact(&self) -> SkinContact {
        fused(self.heads.iter())
    }

    /// Goes on with the contacts of a step.
    pub fn add(&mut self, time: f64, contacts: Vec<SkinContact>, surface: &FeltSurface) {
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

    /// Whether nothing has touched for so long that it has ended.
    pub fn is_over(&self, time: f64, surface: &FeltSurface) -> bool {
        let silent = time - self.last;
        silent > RELEASE && (silent > RELEASE + LONGEST_BARE || silent > self.patience(surface))
    }

    /// How far it may have gone on since it touched last, metres.
    pub fn gone_on(&self, time: f64) -> f64 {
        self.pace().map_or(0.0, |pace| pace * (time - self.last))
    }

    /// How long nothing must touch before it has ended, seconds: longer where it was about to go on to another limb, or
    /// over skin that has no receptors.
    fn patience(&self, surface: &FeltSurface) -> f64 {
        let Some(pace) = self.pace() else { return RELEASE };
        if self.trails.iter().any(|trail| trail.leads_off(surface)) {
            RELEASE + (BARE / pace).min(LONGEST_BARE)
        } else if self.heads.iter().flat_map(SkinContact::spots).any(|spot| surface.is_brink(&spot)) {
            RELEASE + (GAP / pace).min(LONGEST_GAP)
        } else {
            RELEASE
        }
    }

    /// How fast it moved when it touched last, metres a second; none where it stayed.
    fn pace(&self) -> Option<f64> {
        self.trails.iter().filter_map(|trail| trail.pace(self.last)).max_by(f64::total_cmp)
    }

    /// What it was.
    pub fn sensation(self) -> Sensation {
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

/// A self-touch as it is told outside: the place on the earlier limb first.
pub(super) fn earlier_first(contact: &SkinContact) -> SkinContact {
    match contact.by {
        Toucher::Own(own) if own.limb < contact.spot.limb => {
            SkinContact { spot: own, by: Toucher::Own(contact.spot), force: contact.force }
        }
        _ => contact.clone(),
    }
}

/// Contacts of one party as one: forces add up, places are their mean by force, of those on the limb of the strongest.
pub(super) fn fused<'a>(contacts: impl Iterator<Item = &'a SkinContact> + Clone) -> SkinContact {
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
