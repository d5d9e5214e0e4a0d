//! Slices of maps as the session keeps them for its report.

use super::picture::{SLICES, Slice, crossing, outlines};
use super::vtk::about;
use crate::peripersonal::{Level, OwnBody, ReachableMap};
use crate::record::{SpaceRecord, SpaceSlice};

/// The three slices of maps, of which there is at least one.
pub fn record(own: &OwnBody, maps: &[ReachableMap]) -> SpaceRecord {
    let limbs = own.creature.limbs();
    let name = |limb: usize| limbs[limb].clone();
    SpaceRecord {
        chest: maps.first().map_or(String::new(), |map| name(map.chest)),
        hands: maps.iter().map(|map| name(map.hand)).collect(),
        voxel: about(maps).voxel,
        litres: maps.iter().map(|map| map.volumes().map(|volume| 1e3 * volume)).collect(),
        slices: SLICES.iter().map(|slice| slice_of(own, maps, slice)).collect(),
    }
}

fn slice_of(own: &OwnBody, maps: &[ReachableMap], slice: &Slice) -> SpaceSlice {
    let lattice = about(maps);
    let [a, b] = slice.axes;
    let at = lattice.cell(&crossing(maps))[slice.across];
    let digit = |u: usize, v: usize| {
        let mut cell = [at; 3];
        (cell[a], cell[b]) = (lattice.first[a] + u as i32, lattice.first[b] + v as i32);
        let count = |level: fn(Level) -> bool| maps.iter().filter(|map| level(map.level_of(cell))).count();
        let near = count(|level| level == Level::Near);
        match (near, count(|level| level != Level::OutOfReach)) {
            (0, 0) => '0',
            (0, 1) => '1',
            (0, _) => '2',
            (1, _) => '3',
            _ => '4',
        }
    };
    let row = |v: usize| (0..lattice.counts[a]).map(|u| digit(u, v)).collect();
    let outlines = maps.first().map_or(Vec::new(), |map| outlines(own, map, slice));
    SpaceSlice {
        name: slice.name.to_string(),
        axes: slice.axes,
        at: f64::from(at) * lattice.voxel,
        first: slice.axes.map(|axis| f64::from(lattice.first[axis]) * lattice.voxel),
        rows: (0..lattice.counts[b]).map(row).collect(),
        outlines: outlines
            .iter()
            .map(|line| line.iter().map(|p| [a, b].map(|k| (1e4 * p[k]).round() / 1e4)).collect())
            .collect(),
    }
}
