//! How far babbling has come, for a session that is interrupted.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::stamp::Stamp;
use super::{BabblingEffort, PROGRESS_FILE};
use crate::babbling::BoutsDone;
use crate::error::Error;

const STAMP: Stamp = Stamp { format: "bodyschema babbling", version: 1 };

/// The bouts that are done, and what they cost. In a session's folder as long as it babbles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BabblingProgress {
    /// Bouts done.
    pub bouts: u64,
    /// Touches made in them.
    pub touches: usize,
    /// What they cost.
    pub effort: BabblingEffort,
}

impl BabblingProgress {
    /// The bouts done; how often gaps were looked at is not kept.
    pub fn done(&self) -> BoutsDone {
        BoutsDone { bouts: self.bouts, touches: self.touches, effort: self.effort.of_motions }
    }

    /// Writes [`PROGRESS_FILE`] into `folder`, whole or not at all.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        STAMP.write(&folder.join(PROGRESS_FILE), self)
    }

    /// Reads [`PROGRESS_FILE`] of `folder`; none where there is none that can be used.
    pub fn read(folder: &Path) -> Option<BabblingProgress> {
        STAMP.read(&folder.join(PROGRESS_FILE), "progress of babbling").ok()
    }

    /// Removes [`PROGRESS_FILE`] from `folder`, where babbling is done.
    pub fn remove(folder: &Path) {
        // Left behind, it does no harm.
        let _ = std::fs::remove_file(folder.join(PROGRESS_FILE));
    }
}
