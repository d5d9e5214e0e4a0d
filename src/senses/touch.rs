//! A touch: two receptors that met, and the posture they met in.

use std::collections::BTreeSet;

use super::SkinSpot;
use crate::creature::{Creature, Posture};
use crate::skin::Skin;

/// One end of a touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchEnd {
    /// The receptor that was touched, an index into the skin.
    pub receptor: usize,
    /// The exact point of contact in the receptor's limb's frame, metres. A skin does not report it:
    /// only learning from `contact` input may use it.
    pub contact: nalgebra::Vector3<f64>,
    /// Standard deviation of each coordinate of that point, metres; none where nobody gave it: the learner
    /// then goes by how far the points miss each other.
    pub deviation: Option<f64>,
}

impl From<SkinSpot> for TouchEnd {
    fn from(spot: SkinSpot) -> TouchEnd {
        TouchEnd { receptor: spot.receptor, contact: spot.point, deviation: None }
    }
}

/// The pairs of limbs that touched.
pub fn limb_pairs(skin: &Skin, touches: &[Touch]) -> BTreeSet<[usize; 2]> {
    touches.iter().map(|touch| touch.limbs(skin)).collect()
}

/// When and how hard limbs met that were moved by forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Simulated time since the beginning of the bout, seconds.
    pub time: f64,
    /// The force with which the two surfaces press on each other along their normal, newtons; above zero.
    pub force: f64,
    /// How deep the two surfaces were in each other, metres. Nothing feels it; it tells how exact the touch is.
    pub depth: f64,
}

impl Touch {
    /// The limbs of its two ends, in their order.
    pub fn limbs(&self, skin: &Skin) -> [usize; 2] {
        self.ends.map(|end| skin.receptors[end.receptor].limb)
    }

    /// The same touch of a creature with all lengths so many times as long.
    pub(crate) fn scaled(&self, creature: &Creature, by: f64) -> Touch {
        let end = |end: TouchEnd| TouchEnd {
            contact: by * end.contact,
            deviation: end.deviation.map(|deviation| by * deviation),
            ..end
        };
        Touch {
            posture: self.posture.scaled(creature, by),
            ends: self.ends.map(end),
            moment: self.moment.map(|moment| Moment { depth: by * moment.depth, ..moment }),
            ..*self
        }
    }
}

/// A self-touch as the agent feels it.
#[derive(Clone, Debug, PartialEq)]
pub struct Touch {
    /// The bout of babbling it belongs to.
    pub bout: u64,
    /// The motions made in that bout until it, this one included.
    pub motion: u64,
    /// Posture coordinates in the creature's order: radians, metres, quaternions.
    pub posture: Posture,
    /// The two ends; the one on the earlier limb first.
    pub ends: [TouchEnd; 2],
    /// When and how hard it was; none where no forces were at work.
    pub moment: Option<Moment>,
}
