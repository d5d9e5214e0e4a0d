//! The skin as the touch sensor knows it: how far apart places on it are, in whatever posture.

use nalgebra::Vector3;

use super::{SkinContact, SkinSpot, Toucher};
use crate::skin::{Receptor, Skin, SomatotopicMap};

/// How far apart receptors of two limbs are taken to be where the map tells that they are neighbours, but not where the
/// skins of their limbs meet, metres: near enough to go on from one to the other, if nothing is nearer.
const SOMEWHERE_ACROSS: f64 = 0.015;
/// How near to the end of a limb's skin a touch may be about to go on to the next limb, metres.
const BRINK: f64 = 0.012;
/// How near to the edge of the patches a touch may be about to leave them, metres, and in which directions, radians from
/// that in which it goes: a way over the skin may bend.
const EDGE: f64 = 0.006;
const AHEAD: [f64; 3] = [-0.7, 0.0, 0.7];
/// How far from a surface a point still is on it, metres: borders are known that exactly.
const ON_IT: f64 = 0.003;

/// The skin as the sensor knows it: how far apart places are, by which receptors are neighbours, and where there is none.
#[derive(Clone, Debug)]
pub(super) struct FeltSurface {
    map: SomatotopicMap,
    skin: Skin,
    /// Per limb, where its skin ends and a limb begins that has no receptor there, in the limb's frame, metres.
    bare_borders: Vec<Vec<Vector3<f64>>>,
}

impl FeltSurface {
    /// The skin with these neighbours.
    pub fn new(map: SomatotopicMap, skin: &Skin) -> FeltSurface {
        let limbs = skin.receptors.iter().map(|receptor| receptor.limb + 1).max().unwrap_or(0);
        let mut bare_borders = vec![Vec::new(); limbs];
        for (limbs, at) in map.borders() {
            for (here, there) in [(0, 1), (1, 0)] {
                if !has_receptor(skin, limbs[there], &at[there]) {
                    bare_borders[limbs[here]].push(at[here]);
                }
            }
        }
        FeltSurface { map, skin: skin.clone(), bare_borders }
    }

    /// Which receptors are taken for neighbours.
    pub fn map(&self) -> &SomatotopicMap {
        &self.map
    }

    /// About how long the way along the skin is from one place to another, metres; infinite where none is known.
    pub fn way(&self, a: &SkinSpot, b: &SkinSpot) -> f64 {
        if a.limb == b.limb {
            // Round a limb, not through it: an arc between the two normals.
            let [one, other] = [a, b].map(|spot| self.skin.receptors[spot.receptor].normal);
            let cosine = one.dot(&other).clamp(-1.0, 1.0);
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

    /// Whether a touch that goes on from a place in a direction, in the limb's frame, comes to skin that has no receptors, on
    /// its limb or on another.
    pub fn leads_off(&self, spot: &SkinSpot, heading: &Vector3<f64>) -> bool {
        let side = self.skin.receptors[spot.receptor].normal.cross(heading);
        let mut ahead =
            AHEAD.into_iter().map(|angle| spot.point + (heading * angle.cos() + side * angle.sin()) * EDGE);
        ahead.any(|p| self.is_bare(spot, &p))
            || self.bare_borders[spot.limb].iter().any(|border| (border - spot.point).norm() <= BRINK)
    }

    /// Whether no receptor feels a point next to a place of the same limb: none of the surface that is outermost there.
    fn is_bare(&self, spot: &SkinSpot, p: &Vector3<f64>) -> bool {
        let here = &self.skin.receptors[spot.receptor];
        let surfaces = self.skin.surfaces.iter().enumerate().filter(|(_, surface)| surface.limb == spot.limb);
        let measured = surfaces.filter_map(|(s, surface)| Some((s, surface.signed_distance(p)?)));
        let outermost = measured.min_by(|(_, a), (_, b)| a.0.total_cmp(&b.0));
        let (surface, normal) = match outermost {
            Some((s, (_, normal))) => (Some(s), normal),
            None => (here.surface, here.normal),
        };
        let on_it = |other: &&Receptor| other.limb == spot.limb && other.surface == surface;
        !self.skin.receptors.iter().filter(on_it).any(|patch| patch.feels(p, &normal))
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

/// Whether a receptor of a limb feels a point of its skin, in its frame: one whose patch holds it and whose surface it is on.
fn has_receptor(skin: &Skin, limb: usize, point: &Vector3<f64>) -> bool {
    skin.receptors.iter().filter(|receptor| receptor.limb == limb && receptor.holds(point)).any(|receptor| {
        let surface = receptor.surface.and_then(|surface| skin.surfaces[surface].signed_distance(point));
        // What is no solid has its patches alone.
        surface.map_or(receptor.patch_coordinates(point).z.abs(), |(distance, _)| distance.abs()) <= ON_IT
    })
}
