//! The skin as the touch sensor knows it: which receptors the map has as neighbours, and how large the patches are.

use nalgebra::Vector3;

use super::SkinContact;
use crate::skin::{Skin, SomatotopicMap, arc};

/// How far skin without receptors may extend that a touch goes on over, metres.
pub(super) const BARE: f64 = 0.05;
/// Neighbours within so many radians of the direction of a touch are ahead of it.
const AHEAD: f64 = 0.7;

/// A skin and the map of its neighbours.
#[derive(Clone, Debug)]
pub(super) struct MappedSkin {
    /// Which receptors are taken for neighbours.
    pub map: SomatotopicMap,
    pub skin: Skin,
}

/// How contacts of one party follow each other, the surest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Following {
    /// On the same receptors.
    Same,
    /// On neighbours.
    Adjacent,
    /// Beyond skin without receptors.
    Beyond,
}

impl MappedSkin {
    /// The limb of a receptor.
    pub fn limb(&self, receptor: usize) -> usize {
        self.skin.receptors[receptor].limb
    }

    /// The centre of a receptor in its limb's frame, metres.
    pub fn centre(&self, receptor: usize) -> Vector3<f64> {
        self.skin.receptors[receptor].position
    }

    /// How far two patches extend from their centres, metres: each by the mean of its half sides.
    fn extents(&self, a: usize, b: usize) -> f64 {
        let extent = |receptor: usize| self.skin.receptors[receptor].half_extents.iter().sum::<f64>();
        0.5 * (extent(a) + extent(b))
    }

    /// About how long the way along the skin is between the centres of two receptors, metres; over a joint, where it
    /// depends on the posture, that between neighbours.
    pub fn way(&self, a: usize, b: usize) -> f64 {
        let [one, other] = [a, b].map(|receptor| &self.skin.receptors[receptor]);
        match one.limb == other.limb {
            true => arc(&[one.position, other.position], &[one.normal, other.normal]),
            false => self.extents(a, b),
        }
    }

    /// Whether two receptors are neighbours by the map, or have one in common and lie side by side: a patch that meets more
    /// than the map keeps of it has neighbours besides.
    fn adjacent(&self, a: usize, b: usize) -> bool {
        let longest =
            |receptor: usize| self.skin.receptors[receptor].half_extents.into_iter().fold(0.0, f64::max);
        let side_by_side = || self.limb(a) == self.limb(b) && self.way(a, b) <= longest(a) + longest(b);
        self.map.adjacent(a, b) || (side_by_side() && self.have_a_neighbour_in_common(a, b))
    }

    fn have_a_neighbour_in_common(&self, a: usize, b: usize) -> bool {
        self.map.neighbours(a).iter().any(|&between| self.map.adjacent(between, b))
    }

    /// How one receptor follows another. `None` if it does not.
    fn following_of(&self, before: usize, after: usize) -> Option<Following> {
        let beyond = || match self.limb(before) == self.limb(after) {
            true => self.way(before, after) - self.extents(before, after) <= BARE,
            false => self.have_a_neighbour_in_common(before, after),
        };
        match before == after {
            true => Some(Following::Same),
            false if self.adjacent(before, after) => Some(Following::Adjacent),
            false => beyond().then_some(Following::Beyond),
        }
    }

    /// How a contact follows another of the same party, at both places of a self-touch.
    pub fn following(&self, before: &SkinContact, after: &SkinContact) -> Option<Following> {
        let straight = self.following_straight(before, after);
        let turned = after.by.own().and_then(|_| self.following_straight(before, &after.turned()));
        straight.into_iter().chain(turned).min()
    }

    fn following_straight(&self, before: &SkinContact, after: &SkinContact) -> Option<Following> {
        let mut spots = before.spots().zip(after.spots());
        let worst = spots.try_fold(Following::Same, |worst, (before, after)| {
            Some(worst.max(self.following_of(before.receptor, after.receptor)?))
        });
        worst.filter(|_| before.by.is_party_of(&after.by))
    }

    /// Whether contacts are of one party on the same or neighbouring receptors.
    pub fn adjoin(&self, a: &SkinContact, b: &SkinContact) -> bool {
        self.following(a, b).is_some_and(|following| following < Following::Beyond)
    }

    /// A contact; a self-touch given from its other side, if it then follows another more surely.
    pub fn turned_like(&self, model: &SkinContact, contact: &SkinContact) -> SkinContact {
        let rank =
            |contact: &SkinContact| self.following_straight(model, contact).unwrap_or(Following::Beyond);
        std::cmp::min_by_key(*contact, contact.turned(), rank)
    }

    /// Whether a touch that came from one receptor to another leaves the map if it goes straight on: no neighbour is
    /// ahead, on the limb or on another.
    pub fn leads_off(&self, from: usize, to: usize) -> bool {
        let limb = self.limb(to);
        let ahead = self.centre(to) - self.centre(from);
        let is_ahead = |&next: &usize| {
            self.limb(next) != limb || (self.centre(next) - self.centre(to)).angle(&ahead) < AHEAD
        };
        self.limb(from) == limb && !self.map.neighbours(to).iter().any(is_ahead)
    }
}
