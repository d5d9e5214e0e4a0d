//! Which voxels a point of the body can be in: random postures first, then from voxel to voxel by inverse kinematics.
//!
//! A voxel next to one that is reached is sought from the posture there, by a step or two. Voxels go by fronts: a front
//! is worked on by any number of threads, and what they found is put down in order, so that the result is the same for
//! any number of them.

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::lattice::Lattice;
use crate::kinematics::{PlaceChain, Workspace};

/// Random postures that one thread draws at a time, from a random stream of their own.
const DRAWN: usize = 4096;
/// Such draws between looks at whether more are worth their while.
const DRAWS: u64 = 16;
/// Draws go on while at least this share of the postures find a voxel that was not reached before: then they are the
/// cheaper way.
const WORTH: f64 = 0.3;
/// The most rounds of draws.
const MOST_ROUNDS: u64 = 16;
/// The most steps from the posture in one voxel into the next.
const STEPS: usize = 12;
/// How deep inside a voxel the point must be, metres: more than the rounding of what is kept of a posture.
const INSIDE: f64 = 2e-6;

/// The six voxels that share a side with one.
const SIDES: [[i32; 3]; 6] = [[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]];

/// Voxels that are reached, each with the coordinates of a chain that do so.
#[derive(Clone, Debug)]
pub(super) struct Reached {
    pub lattice: Lattice,
    /// Per voxel, its number among those that are reached, counted from 1; 0 for one that is not.
    pub numbers: Vec<u32>,
    /// The voxels in the order in which they were reached.
    pub voxels: Vec<u32>,
    /// The coordinates, voxel by voxel in this order.
    pub coordinates: Vec<f32>,
}

/// The place next to a voxel.
pub(super) fn beside(cell: [i32; 3], way: &[i32; 3]) -> [i32; 3] {
    [0, 1, 2].map(|k| cell[k] + way[k])
}

impl Reached {
    /// Nothing yet.
    pub fn new(lattice: Lattice) -> Reached {
        let numbers = vec![0; lattice.len()];
        Reached { lattice, numbers, voxels: Vec::new(), coordinates: Vec::new() }
    }

    /// The coordinates with which a voxel is reached, by its number counted from 0.
    pub fn coordinates_of(&self, number: usize, length: usize) -> impl Iterator<Item = f64> {
        self.coordinates[number * length..(number + 1) * length].iter().map(|&q| f64::from(q))
    }

    /// Whether a voxel was reached.
    pub fn holds(&self, cell: [i32; 3]) -> bool {
        self.lattice.index(cell).is_some_and(|index| self.numbers[index] > 0)
    }

    fn put(&mut self, voxel: u32, coordinates: &[f32]) {
        let number = &mut self.numbers[voxel as usize];
        if *number == 0 {
            self.voxels.push(voxel);
            *number = self.voxels.len() as u32;
            self.coordinates.extend_from_slice(coordinates);
        }
    }

    /// All voxels that a chain can be in, in any posture within its ranges, besides those that are reached already.
    pub fn fill(&mut self, chain: &PlaceChain, start: &[f64], stream: u64) {
        let mut workspace = Workspace::default();
        let begin: Vec<f32> = start.iter().map(|&q| q as f32).collect();
        if let Some(index) = self.lattice.index(self.lattice.cell(&chain.point(start, &mut workspace))) {
            self.put(index as u32, &begin);
        }
        for round in 0..MOST_ROUNDS {
            let found = self.draw(chain, stream + round * DRAWS);
            if (found as f64) < WORTH * (DRAWS as usize * DRAWN) as f64 {
                break;
            }
        }
        self.grow(chain, 0);
        // Parts that hang together with no other are found by chance alone.
        let known = self.voxels.len();
        if self.draw(chain, stream + MOST_ROUNDS * DRAWS) > 0 {
            self.grow(chain, known);
        }
    }

    /// Puts down the voxels of random postures; tells how many are new.
    fn draw(&mut self, chain: &PlaceChain, stream: u64) -> usize {
        let before = self.voxels.len();
        let drawn = (stream..stream + DRAWS).into_par_iter().map(|stream| {
            let mut rng = ChaCha8Rng::seed_from_u64(0);
            rng.set_stream(stream);
            let mut workspace = Workspace::default();
            let mut coordinates = vec![0.0; chain.count()];
            let mut found = Vec::new();
            for k in 0..DRAWN {
                chain.draw(&mut coordinates, k % 2 == 1, || rng.random::<f64>());
                let point = chain.point(&coordinates, &mut workspace);
                let cell = self.lattice.cell(&point);
                let inside = self.lattice.distance_to_side(cell, &point) > INSIDE;
                match self.lattice.index(cell) {
                    Some(index) if inside && self.numbers[index] == 0 => {
                        found.push((
                            index as u32,
                            coordinates.iter().map(|&q| q as f32).collect::<Vec<f32>>(),
                        ));
                    }
                    _ => {}
                }
            }
            found
        });
        let drawn: Vec<_> = drawn.collect();
        drawn.iter().flatten().for_each(|(voxel, coordinates)| self.put(*voxel, coordinates));
        self.voxels.len() - before
    }

    /// Goes on from the voxels reached since the first `from`, until none is left that can be reached from a neighbour.
    fn grow(&mut self, chain: &PlaceChain, from: usize) {
        let mut front = from..self.voxels.len();
        while !front.is_empty() {
            let mut tries: Vec<(u32, u32)> = Vec::new();
            for number in front.clone() {
                let cell = self.lattice.cell_at(self.voxels[number] as usize);
                let around = SIDES.iter().filter_map(|way| self.lattice.index(beside(cell, way)));
                let open = around.filter(|&index| self.numbers[index] == 0);
                tries.extend(open.map(|index| (index as u32, number as u32)));
            }
            tries.sort_unstable();
            let begin = self.voxels.len();
            self.seek(chain, &tries);
            front = begin..self.voxels.len();
        }
    }

    /// Goes into voxels by as many steps as it takes, from one neighbour after the other.
    fn seek(&mut self, chain: &PlaceChain, tries: &[(u32, u32)]) {
        let groups: Vec<&[(u32, u32)]> = tries.chunk_by(|a, b| a.0 == b.0).collect();
        let half = self.lattice.half() - INSIDE;
        let found = groups.par_iter().map_init(
            || (Workspace::default(), vec![0.0; chain.count()]),
            |(workspace, coordinates), group| {
                let voxel = group[0].0;
                let middle: Vector3<f64> = self.lattice.middle(self.lattice.cell_at(voxel as usize));
                group.iter().find_map(|&(_, number)| {
                    let start = self.coordinates_of(number as usize, chain.count());
                    coordinates.iter_mut().zip(start).for_each(|(q, at)| *q = at);
                    let outside = chain.seek(coordinates, &middle, half, STEPS, workspace);
                    let kept = || coordinates.iter().map(|&q| q as f32).collect::<Vec<f32>>();
                    (outside == 0.0).then(|| (voxel, kept()))
                })
            },
        );
        let found: Vec<_> = found.collect();
        found.iter().flatten().for_each(|(voxel, coordinates)| self.put(*voxel, coordinates));
    }

    /// The outermost voxels that are reached.
    pub fn outermost(&self) -> Vec<[i32; 3]> {
        let cells = self.voxels.iter().map(|&voxel| self.lattice.cell_at(voxel as usize));
        cells.filter(|cell| SIDES.iter().any(|way| !self.holds(beside(*cell, way)))).collect()
    }

    /// The same voxels in a box no larger than they need.
    pub fn cropped(&self) -> Reached {
        let (mut first, mut last) = ([i32::MAX; 3], [i32::MIN; 3]);
        for &voxel in &self.voxels {
            let cell = self.lattice.cell_at(voxel as usize);
            for k in 0..3 {
                (first[k], last[k]) = (first[k].min(cell[k]), last[k].max(cell[k]));
            }
        }
        let counts =
            [0, 1, 2].map(|k| usize::try_from(i64::from(last[k]) - i64::from(first[k]) + 1).unwrap_or(0));
        let lattice = Lattice { first, counts, ..self.lattice.clone() };
        let mut numbers = vec![0; lattice.len()];
        let mut voxels = Vec::with_capacity(self.voxels.len());
        for (number, &voxel) in self.voxels.iter().enumerate() {
            if let Some(index) = lattice.index(self.lattice.cell_at(voxel as usize)) {
                numbers[index] = number as u32 + 1;
                voxels.push(index as u32);
            }
        }
        Reached { lattice, numbers, voxels, coordinates: self.coordinates.clone() }
    }
}
