//! A touch: two receptors that met, and the posture they met in.

use std::collections::BTreeSet;
use std::ops::Deref;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::creature::{Creature, Posture};
use crate::named::named;
use crate::skin::Skin;

named! {
    "input",
    /// What a skin reports of where it was touched.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    #[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
    pub enum Input {
        /// The receptors that fired, as in the paper.
        #[default]
        Receptor = "receptor",
        /// The contact points as well, for recordings that have them and for comparison.
        Contact = "contact",
    }
}

/// Where a skin that reports points was touched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeltPoint {
    /// The point in the receptor's limb's frame, metres.
    pub position: Vector3<f64>,
    /// Standard deviation of each of its coordinates, metres. `None` if it is not given: the learner then estimates it
    /// from how far the points miss each other.
    pub deviation: Option<f64>,
}

/// One end of a touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchEnd {
    /// The receptor that was touched, an index into the skin.
    pub receptor: usize,
    /// Where, if the skin reports points ([`Input::Contact`]).
    pub point: Option<FeltPoint>,
}

impl TouchEnd {
    /// An end of which a skin reports the receptor alone.
    pub fn at(receptor: usize) -> TouchEnd {
        TouchEnd { receptor, point: None }
    }

    /// `p_LR` as a skin reports it, metres: the receptor's centre, or the point if the skin reports points.
    pub fn position(&self, input: Input, skin: &Skin) -> Vector3<f64> {
        match (input, self.point) {
            (Input::Contact, Some(point)) => point.position,
            _ => skin.receptors[self.receptor].position,
        }
    }
}

/// The pairs of limbs that touched.
pub fn limb_pairs(skin: &Skin, touches: &[impl Deref<Target = Touch>]) -> BTreeSet<[usize; 2]> {
    touches.iter().map(|touch| touch.limbs(skin)).collect()
}

/// When and how hard limbs met that were moved by forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Simulated time since the beginning of the bout, seconds.
    pub time: f64,
    /// The force with which the two surfaces press on each other along their normal, newtons; above zero.
    pub force: f64,
}

impl Touch {
    /// The limbs of its two ends, in their order.
    pub fn limbs(&self, skin: &Skin) -> [usize; 2] {
        self.ends.map(|end| skin.receptors[end.receptor].limb)
    }

    /// The same touch of a creature with all lengths so many times as long.
    pub(crate) fn scaled(&self, creature: &Creature, by: f64) -> Touch {
        let scaled = |point: FeltPoint| FeltPoint {
            position: by * point.position,
            deviation: point.deviation.map(|deviation| by * deviation),
        };
        let end = |end: TouchEnd| TouchEnd { point: end.point.map(scaled), ..end };
        Touch { posture: self.posture.scaled(creature, by), ends: self.ends.map(end), ..*self }
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
    /// When and how hard it was; `None` if no forces were at work.
    pub moment: Option<Moment>,
}
