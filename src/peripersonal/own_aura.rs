//! The aura that a creature acts on: the geometries of proximity about its limbs, where its learned schema has them.
//!
//! The sense of proximity is hardware: it sits on the true body and tells how far something is from a limb, seen from that
//! limb. Where things are that the creature knows of, and which of its limbs will be near them in a posture that it might
//! take, only the schema can say. So these geometries are grown about the limbs' surfaces where the schema has them, and
//! are wrong where it is. About limbs whose place it does not know there is none.

use super::own_body::{Doubt, OwnBody};
use crate::creature::Posture;
use crate::geometry::{Ball, Capsule, Precision, gap};
use crate::skin::{ProximityGeometry, grow_about};

/// Postures in which it is asked whether a limb's place is known: at ease, and so many that it was in without harm. One
/// alone may be one in which what is unknown does not show.
const POSTURES: usize = 5;

/// A limb that something is near to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearLimb {
    /// The aura limb, an index into the creature's.
    pub aura_limb: usize,
    /// The limb of it that is nearest.
    pub limb: usize,
    /// How deep the thing is in the aura, metres: how far from its outside its nearest point is.
    pub depth: f64,
    /// How far the thing is from the limb's surface, metres, below 0 where it is in it.
    pub distance: f64,
}

/// The aura of a creature by its own account.
#[derive(Clone, Debug)]
pub struct OwnAura {
    /// The geometries, about what is known of each aura limb.
    pub geometries: Vec<ProximityGeometry>,
    /// The limbs whose place the creature does not know, and why: they have no aura.
    pub unknown: Vec<(usize, Doubt)>,
}

impl OwnAura {
    /// The aura of a body where its schema has it.
    pub fn new(own: &OwnBody) -> OwnAura {
        let creature = own.creature();
        let unknown: Vec<(usize, Doubt)> =
            (0..creature.limbs().len()).filter_map(|limb| Some((limb, doubt(own, limb)?))).collect();
        let frames = own.frames(&creature.reference_posture());
        let known = |limb: &usize| !unknown.iter().any(|(other, _)| other == limb);
        let geometry = |(number, aura): (usize, &crate::creature::AuraLimb)| {
            let limbs: Vec<usize> = aura.limbs.iter().copied().filter(known).collect();
            grow_about(number, aura, &limbs, own.skin(), &frames)
        };
        let geometries = creature.aura_limbs().iter().enumerate().filter_map(geometry).collect();
        OwnAura { geometries, unknown }
    }

    /// The limbs that a ball of the root's frame is near to in a posture, nearest first: one for each aura that it is in.
    /// A ball without radius is a point.
    pub fn near(&self, own: &OwnBody, posture: &[f64], ball: &Ball) -> Vec<NearLimb> {
        let frames = own.frames(posture);
        let thing = Capsule::ball(ball.centre, ball.radius);
        let near = |geometry: &ProximityGeometry| {
            let there = Ball { centre: frames[geometry.limb].inverse_point(&ball.centre), ..*ball };
            let depth = -geometry.capsule.distance_to(&there);
            if depth <= 0.0 {
                return None;
            }
            let limbs = &own.creature().aura_limbs()[geometry.aura_limb].limbs;
            let known = |limb: usize| limbs.contains(&limb) && !self.unknown.iter().any(|(k, _)| *k == limb);
            let gaps =
                own.skin().surfaces.iter().filter(|surface| known(surface.limb)).filter_map(|surface| {
                    let placed = surface.placed(&frames[surface.limb])?;
                    Some((gap(&placed, &thing, Precision::Exact).distance, surface.limb))
                });
            let (distance, limb) = gaps.min_by(|a, b| a.0.total_cmp(&b.0))?;
            Some(NearLimb { aura_limb: geometry.aura_limb, limb, depth, distance })
        };
        let mut found: Vec<NearLimb> = self.geometries.iter().filter_map(near).collect();
        found.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        found
    }
}

/// Why the creature does not know where a limb is in its root's frame; none where it does.
fn doubt(own: &OwnBody, limb: usize) -> Option<Doubt> {
    let surfaces = own.skin().surfaces.iter().filter(|surface| surface.limb == limb);
    let places: Vec<_> = surfaces.map(|surface| surface.origin).collect();
    let count = own.experienced.len();
    let kept = POSTURES - 1;
    let lived = (0..kept.min(count)).map(|k| own.experienced[k * count / kept.min(count)].clone());
    let postures: Vec<Posture> = std::iter::once(own.at_ease()).chain(lived).collect();
    let asked = postures.iter().flat_map(|posture| places.iter().map(move |place| (posture, place)));
    asked.into_iter().find_map(|(posture, place)| own.trusts(posture, [0, limb], place).err())
}
