//! Voxels: cubes that fill a box.

use nalgebra::Vector3;

/// A box of cubes whose middles are at whole multiples of their side.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    /// The side of a voxel, metres.
    pub voxel: f64,
    /// The first voxel, in voxels from the origin.
    pub first: [i32; 3],
    /// How many voxels there are along each axis.
    pub counts: [usize; 3],
}

impl Lattice {
    /// The box about the boxes of others, whose voxels are as large.
    pub fn about<'l>(all: impl Iterator<Item = &'l Lattice> + Clone) -> Lattice {
        let first = [0, 1, 2].map(|k| all.clone().map(|l| l.first[k]).min().unwrap_or(0));
        let end = [0, 1, 2].map(|k| all.clone().map(|l| l.first[k] + l.counts[k] as i32).max().unwrap_or(0));
        let counts = [0, 1, 2].map(|k| (end[k] - first[k]) as usize);
        Lattice { voxel: { all }.next().map_or(0.0, |l| l.voxel), first, counts }
    }

    /// The voxels that hold all within `radius` of a point, metres; `None` if they are more than `most`.
    pub fn around(middle: &Vector3<f64>, radius: f64, voxel: f64, most: usize) -> Option<Lattice> {
        let bound = |side: f64, k: usize| ((middle[k] + side * radius) / voxel).round() + side;
        let mut lattice = Lattice { voxel, first: [0; 3], counts: [0; 3] };
        let mut all = 1.0;
        for k in 0..3 {
            let (low, high) = (bound(-1.0, k), bound(1.0, k));
            all *= high - low + 1.0;
            let far = low.abs().max(high.abs());
            if !far.is_finite() || far > f64::from(i32::MAX) || all > most as f64 {
                return None;
            }
            (lattice.first[k], lattice.counts[k]) = (low as i32, (high - low) as usize + 1);
        }
        Some(lattice)
    }

    /// How many voxels there are.
    pub fn len(&self) -> usize {
        self.counts.iter().product()
    }

    /// Whether there is no voxel.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Half the side of a voxel, metres.
    pub fn half(&self) -> f64 {
        0.5 * self.voxel
    }

    /// The voxel of a point, counted from the origin.
    pub fn cell(&self, point: &Vector3<f64>) -> [i32; 3] {
        [point.x, point.y, point.z].map(|x| (x / self.voxel).round() as i32)
    }

    /// The index of a voxel; none outside.
    pub fn index(&self, cell: [i32; 3]) -> Option<usize> {
        let mut index = 0;
        for k in [2, 1, 0] {
            let along = i64::from(cell[k]) - i64::from(self.first[k]);
            let along = usize::try_from(along).ok().filter(|&along| along < self.counts[k])?;
            index = index * self.counts[k] + along;
        }
        Some(index)
    }

    /// The voxel of an index, which runs along the first axis first.
    pub fn cell_at(&self, index: usize) -> [i32; 3] {
        let [nx, ny, _] = self.counts;
        let along = [index % nx, index / nx % ny, index / (nx * ny)];
        [0, 1, 2].map(|k| self.first[k] + along[k] as i32)
    }

    /// The middle of a voxel, metres.
    pub fn middle(&self, cell: [i32; 3]) -> Vector3<f64> {
        Vector3::from(cell.map(f64::from)) * self.voxel
    }

    /// How far a point is from a voxel, metres; 0 inside.
    pub fn distance(&self, cell: [i32; 3], point: &Vector3<f64>) -> f64 {
        let offset = point - self.middle(cell);
        offset.map(|x| (x.abs() - self.half()).max(0.0)).norm()
    }

    /// How deep in a voxel a point is, metres; negative outside.
    pub fn distance_to_side(&self, cell: [i32; 3], point: &Vector3<f64>) -> f64 {
        self.half() - (point - self.middle(cell)).amax()
    }
}
