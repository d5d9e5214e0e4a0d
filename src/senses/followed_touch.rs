//! Something that touches, followed from step to step until it is understood.

use super::mapped_skin::{Following, MappedSkin};
use super::touch_sensor::RELEASE;
use super::touch_trail::{LONGEST, Trail};
use super::{Sensation, SkinContact, TouchKind};

/// A touch that stays on its patch and is shorter than this is a tap, seconds.
const TAP: f64 = 0.25;

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
    pub fn new(number: u64, time: f64, contacts: &[SkinContact], skin: &MappedSkin) -> FollowedTouch {
        let trails = contacts[0].spots().map(|_| Trail::default()).collect();
        let heads = vec![contacts[0]];
        let mut touch =
            FollowedTouch { number, began: time, last: time, heads, trails, peak: 0.0, sum: 0.0, steps: 0 };
        touch.add(time, contacts, skin);
        touch
    }

    /// How a contact of a step at `time` follows it. `None` if it does not.
    pub fn following(&self, time: f64, contact: &SkinContact, skin: &MappedSkin) -> Option<Following> {
        let following = self.heads.iter().filter_map(|head| skin.following(head, contact)).min();
        // While it is waited for it comes back from beyond where it was; what stayed on its patch was lifted.
        let waits = time - self.last > RELEASE;
        following.filter(|following| match following {
            Following::Same => !waits || self.trails.iter().any(|trail| trail.moves().0),
            Following::Adjacent => true,
            Following::Beyond => waits,
        })
    }

    /// Goes on with the contacts of a step.
    pub fn add(&mut self, time: f64, contacts: &[SkinContact], skin: &MappedSkin) {
        let before = self.heads[0];
        self.heads = contacts.iter().map(|contact| skin.turned_like(&before, contact)).collect();
        for (k, trail) in self.trails.iter_mut().enumerate() {
            let spots = self.heads.iter().filter_map(|contact| contact.spots().nth(k));
            trail.add(time, spots.map(|spot| spot.receptor));
        }
        self.last = time;
        let force: f64 = self.heads.iter().map(|contact| contact.force).sum();
        self.peak = self.peak.max(force);
        self.sum += force;
        self.steps += 1;
    }

    /// Whether nothing has touched for so long that it has ended.
    pub fn is_over(&self, time: f64, skin: &MappedSkin) -> bool {
        let silent = time - self.last;
        let patience = || self.trails.iter().map(|trail| trail.patience(skin)).fold(0.0, f64::max);
        silent > RELEASE && (silent > RELEASE + LONGEST || silent > RELEASE + patience())
    }

    /// What it was.
    pub fn sensation(self, skin: &MappedSkin) -> Sensation {
        let duration = self.last - self.began;
        let moves: Vec<(bool, bool)> = self.trails.iter().map(Trail::moves).collect();
        let kind = match (moves.iter().any(|(along, _)| *along), moves.iter().any(|(_, back)| *back)) {
            (_, true) => TouchKind::Rub,
            (true, false) => TouchKind::Stroke,
            (false, false) if duration < TAP => TouchKind::Tap,
            (false, false) => TouchKind::Press,
        };
        Sensation {
            began: self.began,
            ended: self.last,
            kind,
            by: self.heads[0].by,
            sides: self.trails.iter().map(|trail| trail.side(skin, duration)).collect(),
            peak_force: self.peak,
            mean_force: self.sum / self.steps as f64,
        }
    }
}
