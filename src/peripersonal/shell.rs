//! The outermost voxels of a region, and the nearest of them to a point.

use nalgebra::Vector3;

use super::flood::{Reached, SIDES, beside};
use super::lattice::Lattice;

/// So few voxels are looked at one by one.
const LEAF: usize = 8;

/// The outermost voxels as a tree of halves (Bentley 1975): the voxel in the middle of a slice parts the others by the
/// axis whose turn it is.
#[derive(Clone, Debug)]
pub(super) struct Shell {
    lattice: Lattice,
    /// Voxels, counted from the origin.
    cells: Vec<[i32; 3]>,
}

/// Puts the voxel in the middle of a slice where it parts the others, and so on in both halves.
fn part(cells: &mut [[i32; 3]], axis: usize) {
    if cells.len() <= LEAF {
        return;
    }
    let middle = cells.len() / 2;
    let (before, _, after) = cells.select_nth_unstable_by_key(middle, |cell| (cell[axis], *cell));
    part(before, (axis + 1) % 3);
    part(after, (axis + 1) % 3);
}

impl Shell {
    /// The outermost of the voxels that are reached.
    pub fn new(reached: &Reached) -> Shell {
        let lattice = reached.lattice.clone();
        let cells = reached.voxels.iter().map(|&voxel| lattice.cell_at(voxel as usize));
        let outermost = |cell: &[i32; 3]| SIDES.iter().any(|way| !reached.holds(beside(*cell, way)));
        let mut cells: Vec<[i32; 3]> = cells.filter(outermost).collect();
        part(&mut cells, 0);
        Shell { lattice, cells }
    }

    /// The nearest voxel to a point outside the region, and how far off it is, metres; none where there is none.
    pub fn nearest(&self, point: &Vector3<f64>) -> Option<([i32; 3], f64)> {
        // In voxels, so that those need not be put into metres.
        let mut search = ShellSearch { point: point / self.lattice.voxel, best: None, least: f64::INFINITY };
        search.look(&self.cells, 0);
        search.best.map(|cell| (cell, self.lattice.distance(cell, point)))
    }
}

/// A search for the nearest voxel.
struct ShellSearch {
    /// In voxels.
    point: Vector3<f64>,
    best: Option<[i32; 3]>,
    /// The square of its distance, in voxels.
    least: f64,
}

impl ShellSearch {
    fn look(&mut self, cells: &[[i32; 3]], axis: usize) {
        if cells.len() <= LEAF {
            cells.iter().for_each(|cell| self.consider(cell));
            return;
        }
        let middle = cells.len() / 2;
        let offset = self.point[axis] - f64::from(cells[middle][axis]);
        let (before, after) = (&cells[..middle], &cells[middle + 1..]);
        let (nearer, farther) = if offset < 0.0 { (before, after) } else { (after, before) };
        self.look(nearer, (axis + 1) % 3);
        self.consider(&cells[middle]);
        let least = (offset.abs() - 0.5).max(0.0);
        if least * least < self.least {
            self.look(farther, (axis + 1) % 3);
        }
    }

    fn consider(&mut self, cell: &[i32; 3]) {
        let outside = |k: usize| ((self.point[k] - f64::from(cell[k])).abs() - 0.5).max(0.0);
        let [x, y, z] = [outside(0), outside(1), outside(2)];
        let square = x * x + y * y + z * z;
        if square < self.least {
            (self.least, self.best) = (square, Some(*cell));
        }
    }
}
