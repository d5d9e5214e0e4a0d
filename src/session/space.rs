//! Slices of the hands' reachable workspace, stored in a session for its report.

use std::path::Path;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::SPACE_FILE;
use super::stamp::Stamp;
use crate::error::Error;
use crate::peripersonal::{Lattice, Level, OwnBody, ReachableMap};
use crate::plausible::{GREATEST_LENGTH, is_length};

const STAMP: Stamp = Stamp { format: "bodyschema space", version: 1 };

/// The least side of a voxel, metres.
const LEAST_VOXEL: f64 = 1e-4;
/// Litres at the most: those of a cube of ten kilometres.
const GREATEST_LITRES: f64 = 1e15;

/// Three slices through the maps of the hands, in the frame of the chest in the rest posture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// Outlines of the limbs in the rest posture along both axes, metres.
    pub outlines: Vec<Vec<[f64; 2]>>,
}

impl SpaceRecord {
    /// The three slices of maps, of which there is at least one, and in sentences what of them is a guess.
    pub fn of(own: &OwnBody, maps: &[ReachableMap], doubts: Vec<String>) -> SpaceRecord {
        let lattice = Lattice::about(maps.iter().map(ReachableMap::lattice));
        let limbs = own.creature().limbs();
        let name = |limb: usize| limbs[limb].clone();
        SpaceRecord {
            chest: maps.first().map_or(String::new(), |map| name(map.chest)),
            hands: maps.iter().map(|map| map.name(own)).collect(),
            voxel: lattice.voxel,
            litres: maps.iter().map(|map| map.volumes().map(|volume| 1e3 * volume)).collect(),
            doubts,
            slices: SLICES.iter().map(|(name, axes)| slice_of(own, maps, &lattice, name, *axes)).collect(),
        }
    }

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
                let message = format!("it has {fault}: run `bodyschema reach` again");
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
            return Some("an impossible size or position".into());
        }
        if self.hands.len() != self.litres.len() {
            return Some("no volumes for some hand".into());
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

/// The slices, each with the axes to the right and upwards: as MJCF has them for a body that stands, x ahead, y to the left and z
/// up.
const SLICES: [(&str, [usize; 2]); 3] =
    [("from above", [1, 0]), ("from the side", [0, 2]), ("from the front", [1, 2])];

/// Where the slices cross: the middle of what is near to any hand.
fn crossing(maps: &[ReachableMap]) -> Vector3<f64> {
    let voxels = maps.iter().flat_map(|map| map.voxels().map(move |(cell, level)| (map, cell, level)));
    let near = voxels.filter(|(.., level)| *level == Level::Near);
    let near: Vec<Vector3<f64>> = near.map(|(map, cell, _)| map.lattice().middle(cell)).collect();
    near.iter().sum::<Vector3<f64>>() / near.len().max(1) as f64
}

/// The outlines of a limb's pieces, seen along an axis, in the map's frame: along the two other axes, to a tenth of a millimetre.
fn outlines(own: &OwnBody, map: &ReachableMap, [a, b]: [usize; 2]) -> Vec<Vec<[f64; 2]>> {
    let frames = own.frames(&own.at_ease());
    let to_map = map.frame.inverse();
    let outline = |surface: &crate::skin::Surface| {
        let pose = to_map * frames[surface.limb];
        let around = (0..=48).map(|k| std::f64::consts::TAU * f64::from(k) / 48.0);
        let farthest = around.filter_map(|angle| {
            let mut direction = Vector3::zeros();
            (direction[a], direction[b]) = (angle.cos(), angle.sin());
            let point = pose.point(&surface.support(&pose.rotation.tr_mul(&direction))?);
            Some([a, b].map(|k| (1e4 * point[k]).round() / 1e4))
        });
        farthest.collect()
    };
    own.skin().surfaces.iter().map(outline).filter(|points: &Vec<_>| !points.is_empty()).collect()
}

fn slice_of(
    own: &OwnBody,
    maps: &[ReachableMap],
    lattice: &Lattice,
    name: &str,
    axes @ [a, b]: [usize; 2],
) -> SpaceSlice {
    let at = lattice.cell(&crossing(maps))[3 - a - b];
    let digit = |u: usize, v: usize| {
        let mut cell = [at; 3];
        (cell[a], cell[b]) = (lattice.first[a] + u as i32, lattice.first[b] + v as i32);
        let count = |level: fn(Level) -> bool| maps.iter().filter(|map| level(map.level_of(cell))).count();
        match (count(|level| level == Level::Near), count(|level| level != Level::OutOfReach)) {
            (0, 0) => '0',
            (0, 1) => '1',
            (0, _) => '2',
            (1, _) => '3',
            _ => '4',
        }
    };
    let row = |v: usize| (0..lattice.counts[a]).map(|u| digit(u, v)).collect();
    SpaceSlice {
        name: name.to_string(),
        axes,
        at: f64::from(at) * lattice.voxel,
        first: axes.map(|axis| f64::from(lattice.first[axis]) * lattice.voxel),
        rows: (0..lattice.counts[b]).map(row).collect(),
        outlines: maps.first().map_or(Vec::new(), |map| outlines(own, map, axes)),
    }
}
