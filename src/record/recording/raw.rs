//! A touch as a log tells it, before it is known whether creature and skin have what it names.

use nalgebra::Vector3;

use crate::creature::Posture;
use crate::skin::Skin;

/// One end of a touch; where a field came from, as an error names it.
#[derive(Clone, Debug, Default)]
pub(super) struct RawEnd {
    /// The name of the limb.
    pub limb: Option<String>,
    /// Where it stands in the line.
    pub limb_place: &'static str,
    /// The id of the receptor.
    pub receptor: Option<String>,
    /// Where it stands in the line.
    pub receptor_place: &'static str,
    /// The point of contact in the limb's frame, metres.
    pub point: Option<Vector3<f64>>,
    /// Standard deviation of each of its coordinates, metres.
    pub deviation: Option<f64>,
}

impl RawEnd {
    /// The receptor, an index into the skin; none where the skin does not have it.
    pub fn receptor(&self, skin: &Skin) -> Option<usize> {
        self.receptor.as_ref().and_then(|id| skin.receptor(id))
    }
}

/// A touch, its posture in the creature's order.
#[derive(Clone, Debug)]
pub(super) struct RawTouch {
    pub line: usize,
    pub bout: Option<u64>,
    pub motion: Option<u64>,
    pub posture: Posture,
    pub ends: [RawEnd; 2],
}
