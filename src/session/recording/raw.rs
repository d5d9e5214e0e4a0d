//! A touch as a log tells it, before it is known whether creature and skin have what it names.

use nalgebra::Vector3;

use crate::creature::Posture;
use crate::session::columns::{CellFault, left_out_in_words};
use crate::session::record_error::ContentFault;
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

/// A log before it is known whether creature and skin have what it names.
#[derive(Debug, Default)]
pub(super) struct RawLog {
    pub touches: Vec<RawTouch>,
    /// The last line, where it ends in the middle and is left out.
    pub cut: Option<usize>,
    /// What looks odd, in sentences.
    pub notes: Vec<String>,
    /// Lines whose touches have numbers that are not finite, with what is wrong.
    pub left_out: Vec<(usize, String)>,
}

impl RawLog {
    /// Takes the touch of a line; one with a number that is not finite is left out.
    ///
    /// # Errors
    /// Where anything else is wrong with it.
    pub fn take(&mut self, line: usize, read: Result<RawTouch, CellFault>) -> Result<(), ContentFault> {
        match read {
            Ok(touch) => self.touches.push(touch),
            Err(CellFault::NotFinite(fault)) => self.left_out.push((line, fault)),
            Err(CellFault::Wrong(fault)) => return Err(fault.into()),
        }
        Ok(())
    }

    /// That touches are left out, as a sentence.
    pub fn left_out_in_words(&self) -> Option<String> {
        left_out_in_words(&self.left_out, self.touches.len() + self.left_out.len())
    }
}
