//! The outermost voxels of a region, and the nearest of them to a point.

use std::ops::Range;

use nalgebra::Vector3;

use super::flood::{Reached, SIDES, beside};
use super::lattice::Lattice;

/// The side of a brick, voxels.
const BRICK: i32 = 8;

/// The outermost voxels, brick by brick, so that most of them need not be looked at.
#[derive(Clone, Debug)]
pub(super) struct Shell {
    lattice: Lattice,
    /// Voxels, counted from the origin.
    cells: Vec<[i32; 3]>,
    /// First and last voxel of the box about what is in a brick, and its share of the voxels.
    bricks: Vec<([i32; 3], [i32; 3], Range<usize>)>,
}

impl Shell {
    /// The outermost of the voxels that are reached.
    pub fn new(reached: &Reached) -> Shell {
        let lattice = reached.lattice.clone();
        let cells = reached.voxels.iter().map(|&voxel| lattice.cell_at(voxel as usize));
        let outermost = |cell: &[i32; 3]| SIDES.iter().any(|way| !reached.holds(beside(*cell, way)));
        let mut cells: Vec<[i32; 3]> = cells.filter(outermost).collect();
        let brick = |cell: &[i32; 3]| cell.map(|x| x.div_euclid(BRICK));
        cells.sort_unstable_by_key(|cell| (brick(cell), *cell));
        let mut bricks = Vec::new();
        let mut begin = 0;
        for inside in cells.chunk_by(|a, b| brick(a) == brick(b)) {
            let extreme = |k: usize, pick: fn(i32, i32) -> i32| inside.iter().map(|cell| cell[k]).reduce(pick);
            let corner = |pick| [0, 1, 2].map(|k| extreme(k, pick).unwrap_or_default());
            bricks.push((corner(i32::min), corner(i32::max), begin..begin + inside.len()));
            begin += inside.len();
        }
        Shell { lattice, cells, bricks }
    }

    /// The nearest voxel to a point outside the region, and how far off it is, metres; none where there is none.
    pub fn nearest(&self, point: &Vector3<f64>) -> Option<([i32; 3], f64)> {
        let bound = |first: &[i32; 3], last: &[i32; 3]| {
            let (low, high) = (self.lattice.middle(*first), self.lattice.middle(*last));
            let outside = (low - point).sup(&(point - high)).map(|x| (x - self.lattice.half()).max(0.0));
            outside.norm()
        };
        let mut best: Option<([i32; 3], f64)> = None;
        let mut look = |range: &Range<usize>| {
            for cell in &self.cells[range.clone()] {
                let distance = self.lattice.distance(*cell, point);
                if best.is_none_or(|(_, least)| distance < least) {
                    best = Some((*cell, distance));
                }
            }
            best.map_or(f64::INFINITY, |(_, least)| least)
        };
        let bounds = self.bricks.iter().map(|(first, last, range)| (bound(first, last), range));
        let (_, nearest) = bounds.clone().min_by(|a, b| a.0.total_cmp(&b.0))?;
        let mut least = look(nearest);
        for (bound, range) in bounds {
            if bound < least {
                least = look(range);
            }
        }
        best
    }
}
