//! Maps as a cloud of dots about a body: the outermost voxels of what is near, and of all that is reached.

use serde::Serialize;

use crate::peripersonal::{Level, ReachableMap};
use crate::view::body::whole;

/// A dot in the middle of every outermost voxel, in the root's frame.
#[derive(Clone, Debug, Default, Serialize)]
pub struct SpaceCloud {
    /// The side of a voxel, in the viewer's parts of a metre.
    voxel: i64,
    /// Per dot its place, in these parts, and how far away it is: 2 near, 1 far.
    points: Vec<[i64; 4]>,
}

impl SpaceCloud {
    /// The dots of some maps of the same voxels: near is what is near to any of them.
    pub fn new(maps: &[ReachableMap]) -> SpaceCloud {
        let Some(first) = maps.first() else { return SpaceCloud::default() };
        let level = |cell: [i32; 3]| {
            let levels = maps.iter().map(|map| map.level_of(cell).number());
            levels.max().unwrap_or(Level::OutOfReach.number())
        };
        let mut cells: Vec<[i32; 3]> =
            maps.iter().flat_map(|map| map.voxels().map(|(cell, _)| cell)).collect();
        cells.sort_unstable();
        cells.dedup();
        let dot = |cell: [i32; 3]| {
            let own = level(cell);
            let beside = |k: usize, by: i32| {
                let mut other = cell;
                other[k] += by;
                level(other)
            };
            let outermost = (0..3).any(|k| beside(k, -1) < own || beside(k, 1) < own);
            let place = first.frame.point(&first.lattice().middle(cell));
            outermost.then(|| [whole(place.x), whole(place.y), whole(place.z), i64::from(own)])
        };
        SpaceCloud {
            voxel: whole(first.lattice().voxel),
            points: cells.into_iter().filter_map(dot).collect(),
        }
    }
}
