//! Slices through the maps of where hands can get to.

use nalgebra::Vector3;

use super::space_record::{SpaceRecord, SpaceSlice};
use crate::export::about;
use crate::peripersonal::{Level, OwnBody, ReachableMap};

/// The slices, each with the axes to the right and upwards: as MJCF has them for a body that stands, x ahead, y to the left and z
/// up.
const SLICES: [(&str, [usize; 2]); 3] =
    [("from above", [1, 0]), ("from the side", [0, 2]), ("from the front", [1, 2])];

/// Where the slices cross: the middle of what is near to any hand.
fn crossing(maps: &[ReachableMap]) -> Vector3<f64> {
    let near = |map: &ReachableMap| -> Vec<Vector3<f64>> {
        let near = map.voxels().filter(|(_, level)| *level == Level::Near);
        near.map(|(cell, _)| map.lattice().middle(cell)).collect()
    };
    let near: Vec<Vector3<f64>> = maps.iter().flat_map(near).collect();
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

impl SpaceRecord {
    /// The three slices of maps, of which there is at least one, and in sentences what of them is a guess.
    pub fn of(own: &OwnBody, maps: &[ReachableMap], doubts: Vec<String>) -> SpaceRecord {
        let limbs = own.creature().limbs();
        let name = |limb: usize| limbs[limb].clone();
        SpaceRecord {
            chest: maps.first().map_or(String::new(), |map| name(map.chest)),
            hands: maps.iter().map(|map| map.name(own)).collect(),
            voxel: about(maps).voxel,
            litres: maps.iter().map(|map| map.volumes().map(|volume| 1e3 * volume)).collect(),
            doubts,
            slices: SLICES.iter().map(|(name, axes)| slice_of(own, maps, name, *axes)).collect(),
        }
    }
}

fn slice_of(own: &OwnBody, maps: &[ReachableMap], name: &str, axes @ [a, b]: [usize; 2]) -> SpaceSlice {
    let lattice = about(maps);
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
