//! Slices of where a creature's hands can get to, as a session keeps them for its report.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::SPACE_FILE;
use super::stamp::Stamp;
use crate::error::Error;
use crate::plausible::{GREATEST_LENGTH, is_length};

const STAMP: Stamp = Stamp { format: "bodyschema space", version: 1 };

/// The least side of a voxel, metres.
const LEAST_VOXEL: f64 = 1e-4;
/// Litres at the most: those of a cube of ten kilometres.
const GREATEST_LITRES: f64 = 1e15;

/// Three slices through the maps of the hands, in the frame of the chest at ease.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct SpaceRecord {
    /// The limb in whose frame the map is told.
    pub chest: String,
    /// The limbs that reach.
    pub hands: Vec<String>,
    /// The side of a voxel, metres.
    pub voxel: f64,
    /// Per hand, the volumes of what is near and of what is far, litres.
    #[serde(rename = "volumes_l", alias = "litres")]
    pub litres: Vec<[f64; 2]>,
    /// What of this is no knowledge but a guess, in sentences.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub doubts: Vec<String>,
    /// The slices.
    pub slices: Vec<SpaceSlice>,
}

/// One slice, seen with an axis to the right and one upwards.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct SpaceSlice {
    /// What it is called.
    pub name: String,
    /// The axes to the right and upwards: 0 is x, 1 is y, 2 is z.
    pub axes: [usize; 2],
    /// Where it cuts the third axis, metres.
    pub at: f64,
    /// The middle of the first voxel along both axes, metres.
    pub first: [f64; 2],
    /// A row of voxels each, the lowest first, a digit per voxel: 0 out of reach, 1 far for one hand, 2 far for
    /// more, 3 near for one hand, 4 near for more.
    pub rows: Vec<String>,
    /// Outlines of the limbs at ease along both axes, metres.
    pub outlines: Vec<Vec<[f64; 2]>>,
}

impl SpaceRecord {
    /// Writes [`SPACE_FILE`] into `folder`, which is made if missing; whole or not at all.
    ///
    /// # Errors
    /// If the folder or the file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        STAMP.write(&folder.join(SPACE_FILE), self)
    }

    /// Reads [`SPACE_FILE`] of `folder`; `None` if there is no such file.
    ///
    /// # Errors
    /// If it cannot be read, or if it holds no such slices or is of
    /// a newer version.
    pub fn read(folder: &Path) -> Result<Option<SpaceRecord>, Error> {
        let path = folder.join(SPACE_FILE);
        if !path.exists() {
            return Ok(None);
        }
        let record: SpaceRecord = STAMP.read(&path, "space")?;
        match record.fault() {
            None => Ok(Some(record)),
            Some(fault) => {
                let message = format!("it has {fault}: make it anew with `bodyschema reach`");
                Err(Error::content(&path, None, message))
            }
        }
    }

    /// What is wrong with it.
    fn fault(&self) -> Option<String> {
        let places = self.slices.iter().flat_map(|slice| {
            let outlines = slice.outlines.iter().flatten().flatten();
            [slice.at].into_iter().chain(slice.first).chain(outlines.copied())
        });
        let litres = self.litres.iter().flatten().all(|litres| (0.0..=GREATEST_LITRES).contains(litres));
        if !((LEAST_VOXEL..=GREATEST_LENGTH).contains(&self.voxel) && litres && { places }.all(is_length)) {
            return Some("a size or a place that cannot be".into());
        }
        if self.hands.len() != self.litres.len() {
            return Some("not the volumes of every hand".into());
        }
        let right = |slice: &SpaceSlice| {
            let digits = |row: &String| row.bytes().all(|digit| (b'0'..=b'4').contains(&digit));
            let [a, b] = slice.axes;
            let equal = slice.rows.iter().all(|row| row.len() == slice.rows[0].len());
            a <= 2 && b <= 2 && a != b && equal && slice.rows.iter().all(digits)
        };
        let wrong = self.slices.iter().position(|slice| !right(slice))?;
        Some(format!(
            "a slice {} with other axes than two of 0 to 2, other digits than 0 to 4, or rows of several lengths",
            wrong + 1
        ))
    }
}
