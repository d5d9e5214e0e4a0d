//! The skin as the touch sensor knows it: how far apart places on it are, in whatever posture.

use nalgebra::Vector3;

use super::{SkinContact, SkinSpot, Toucher};
use crate::skin::{Skin, SomatotopicMap};

/// How far apart receptors of two limbs are taken to be where the map tells that they are neighbours, but not where the
/// skins of their limbs meet, metres: near enough to go on from one to the other, if nothing is nearer.
const SOMEWHERE_ACROSS: f64 = 0.015;
/// How near to the end of a limb's skin a touch may be about to go on to the next limb, metres.
const BRINK: f64 = 0.012;

/// How far apart places of the skin are, by which receptors are neighbours.
#[derive(Clone, Debug)]
pub(super) struct FeltSurface {
    map: SomatotopicMap,
    /// Per receptor, its outward normal in its limb's frame.
    normals: Vec<Vector3<f64>>,
}

impl FeltSurface {
    /// The skin with these neighbours.
    pub fn new(map: SomatotopicMap, skin: &Skin) -> FeltSurface {
        FeltSurface { map, normals: skin.receptors.iter().map(|receptor| receptor.normal).collect() }
    }

    /// Which receptors are taken for neighbours.
    pub fn map(&self) -> &SomatotopicMap {
        &self.map
    }

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
    pub fn is_brink(&self, spot: &SkinSpot) -> bool {
        self.map.way_to_border(spot.limb, &spot.point).is_some_and(|way| way <= BRINK)
    }

    /// How far two contacts are apart along the skin, both places of a self-touch; infinite for those of two parties.
    pub fn apart(&self, a: &SkinContact, b: &SkinContact) -> f64 {
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
    pub fn is_one_patch(&self, a: &SkinContact, b: &SkinContact) -> bool {
        let near = |a: &SkinSpot, b: &SkinSpot| self.map.adjacent(a.receptor, b.receptor);
        a.parties() == b.parties()
            && near(&a.spot, &b.spot)
            && match (&a.by, &b.by) {
                (Toucher::Own(a), Toucher::Own(b)) => near(a, b),
                _ => true,
            }
    }

    /// A self-touch told from its other side, where that fits another better.
    pub fn turned_like(&self, model: &SkinContact, contact: SkinContact) -> SkinContact {
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
