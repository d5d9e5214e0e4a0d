//! A touch: two receptors that met, and the posture they met in; and its record, which has the exact contact beside it that the
//! agent does not feel.

use std::collections::BTreeSet;
use std::ops::{Deref, DerefMut};

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

/// Where and how deep two surfaces met exactly: what the engine computes or a recording measured. Evaluation, tests and
/// files have it; the agent's folders never name it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExactContact {
    /// The point of contact in the frame of each end's limb, metres.
    pub points: [Vector3<f64>; 2],
    /// Standard deviation of each coordinate of these points, metres, where a recording gives it.
    pub deviations: [Option<f64>; 2],
    /// How deep the surfaces were in each other, metres. `None` if no forces were at work.
    pub depth: Option<f64>,
}

/// Skin that met skin: two receptors, and the exact contact, which only a record of the touch takes in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Met {
    /// The receptors, the one on the earlier limb first.
    pub receptors: [usize; 2],
    /// The exact contact.
    pub exact_contact: ExactContact,
}

impl Met {
    /// Receptors that met, each at a point of its limb, without forces.
    pub(super) fn at(places: [(usize, Vector3<f64>); 2]) -> Met {
        let points = places.map(|(_, point)| point);
        let exact_contact = ExactContact { points, ..ExactContact::default() };
        Met { receptors: places.map(|(receptor, _)| receptor), exact_contact }
    }
}

/// A touch of the receptors alone, beside the exact contact that it was.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedTouch {
    touch: Touch,
    contact: ExactContact,
}

impl RecordedTouch {
    /// A touch and its contact.
    pub fn new(touch: Touch, contact: ExactContact) -> RecordedTouch {
        RecordedTouch { touch, contact }
    }

    /// The touch as an agent feels it through a kind of skin.
    pub fn felt(&self, input: Input) -> Touch {
        let mut touch = self.touch.clone();
        if input == Input::Contact {
            for (k, end) in touch.ends.iter_mut().enumerate() {
                let (position, deviation) = (self.contact.points[k], self.contact.deviations[k]);
                end.point = Some(FeltPoint { position, deviation });
            }
        }
        touch
    }

    /// The exact contact.
    pub fn exact_contact(&self) -> &ExactContact {
        &self.contact
    }

    /// The exact contact, to be changed.
    pub fn exact_contact_mut(&mut self) -> &mut ExactContact {
        &mut self.contact
    }
}

impl Deref for RecordedTouch {
    type Target = Touch;

    fn deref(&self) -> &Touch {
        &self.touch
    }
}

impl DerefMut for RecordedTouch {
    fn deref_mut(&mut self) -> &mut Touch {
        &mut self.touch
    }
}
