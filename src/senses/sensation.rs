//! Sensations: the report of a touch's onset and, afterwards, of its kind, limb by limb.

use nalgebra::Vector3;
use serde::Serialize;

use super::{SkinContact, Toucher};
use crate::named::named;

named! {
    "touch",
    /// What kind of touch it was.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
    #[serde(rename_all = "snake_case")]
    pub enum TouchKind {
        /// Short, and at one place.
        Tap = "tap",
        /// Longer, and at one place.
        Press = "press",
        /// Along the skin.
        Stroke = "stroke",
        /// Along the skin to and fro.
        Rub = "rub",
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
    /// Way along the skin, over all limbs and joints, metres.
    pub path: f64,
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
    /// Who touched; of a self-touch, with which place of its own last.
    pub by: Toucher,
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
