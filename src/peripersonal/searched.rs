//! What of a table has been searched: down to which height skin has passed over each place of it.

use nalgebra::Vector3;

use super::obstacle::TablePlane;
use super::own_body::OwnBody;
use crate::geometry::Frame;

/// The side of a cell, metres.
pub const CELL: f64 = 0.01;
/// Skin is taken for a point in every square of this area, m²: well below a cell's.
const SPACING: f64 = 3.6e-5;
/// Of the table in front of it so much is mapped, metres: forward from the trunk, and to either side.
const SIZE: [f64; 2] = [0.95, 0.95];

/// Points spread over the skin of each limb, in its frame, metres.
#[derive(Clone, Debug)]
pub struct SkinPoints(Vec<Vec<Vector3<f64>>>);

impl SkinPoints {
    /// The points of some limbs.
    pub fn on(own: &OwnBody, limbs: &[bool]) -> SkinPoints {
        let mut points = vec![Vec::new(); limbs.len()];
        for surface in own.skin().surfaces.iter().filter(|surface| limbs[surface.limb]) {
            let pose = surface.pose();
            points[surface.limb]
                .extend(surface.shape.samples(SPACING).into_iter().map(|(point, _)| pose.point(&point)));
        }
        SkinPoints(points)
    }

    /// All of them where the limbs are at `frames`.
    pub fn at<'a>(&'a self, frames: &'a [Frame]) -> impl Iterator<Item = Vector3<f64>> + 'a {
        self.0.iter().zip(frames).flat_map(|(points, frame)| points.iter().map(|point| frame.point(point)))
    }

    /// Those of a limb, in its frame.
    pub fn of(&self, limb: usize) -> &[Vector3<f64>] {
        &self.0[limb]
    }
}

/// A map of a table in cells of [`CELL`]: how low skin has passed over each without touching anything, and which of them it
/// can pass at all.
#[derive(Clone, Debug)]
pub struct SearchedMap {
    /// The table.
    pub plane: TablePlane,
    size: [usize; 2],
    /// Per cell, the lowest height over the table at which skin was over it, metres: there is nothing above it; infinite where no
    /// skin has passed.
    pub passed: Vec<f64>,
    /// The same of the last motion alone.
    pub lately: Vec<f64>,
    /// Per cell, whether some posture brings skin low enough to it.
    pub reached: Vec<bool>,
}

/// A cell of a [`SearchedMap`].
pub type Cell = usize;

impl SearchedMap {
    /// A table of which nothing has been searched.
    pub fn new(plane: TablePlane) -> SearchedMap {
        let size = [(SIZE[0] / CELL) as usize, (2.0 * SIZE[1] / CELL) as usize];
        let cells = size[0] * size[1];
        let nowhere = vec![f64::INFINITY; cells];
        SearchedMap { plane, size, passed: nowhere.clone(), lately: nowhere, reached: vec![false; cells] }
    }

    /// How many cells there are.
    pub fn cells(&self) -> usize {
        self.passed.len()
    }

    /// The cell that a place of the table is in, forward and to the left, metres.
    pub fn cell(&self, forward: f64, left: f64) -> Option<Cell> {
        let [i, j] = [(forward - self.plane.edge) / CELL, (left + SIZE[1]) / CELL];
        let inside = i >= 0.0 && j >= 0.0 && i < self.size[0] as f64 && j < self.size[1] as f64;
        inside.then(|| i as usize * self.size[1] + j as usize)
    }

    /// The middle of a cell, forward and to the left, metres.
    pub fn middle(&self, cell: Cell) -> [f64; 2] {
        let [i, j] = [cell / self.size[1], cell % self.size[1]];
        [self.plane.edge + (i as f64 + 0.5) * CELL, (j as f64 + 0.5) * CELL - SIZE[1]]
    }

    /// The cells that skin is over, no higher than `below`, in a posture, and how high, metres; a cell as often as points
    /// of the skin are.
    pub fn under<'a>(
        &'a self,
        skin: &'a SkinPoints,
        frames: &'a [Frame],
        below: f64,
    ) -> impl Iterator<Item = (Cell, f64)> + 'a {
        skin.at(frames).filter_map(move |point| {
            let [forward, left, above] = self.plane.coordinates(&point);
            Some((self.cell(forward, left)?, above)).filter(|(_, above)| *above <= below)
        })
    }

    /// Skin passes over the table in a posture and touches nothing but what it has just met.
    pub fn pass(&mut self, skin: &SkinPoints, frames: &[Frame]) {
        for point in skin.at(frames) {
            let [forward, left, above] = self.plane.coordinates(&point);
            if let Some(cell) = self.cell(forward, left) {
                self.passed[cell] = self.passed[cell].min(above);
                self.lately[cell] = self.lately[cell].min(above);
            }
        }
    }

    /// What was searched so near to a place, forward and to the left, metres, may have changed since.
    pub fn forget_about(&mut self, [forward, left]: [f64; 2], radius: f64) {
        for cell in 0..self.cells() {
            let [x, y] = self.middle(cell);
            if (x - forward).hypot(y - left) < radius {
                self.passed[cell] = f64::INFINITY;
            }
        }
    }

    /// The cells that can be reached.
    pub fn reachable(&self) -> impl Iterator<Item = Cell> + '_ {
        (0..self.cells()).filter(|&cell| self.reached[cell])
    }

    /// The cells beside a cell.
    pub fn beside(&self, cell: Cell) -> impl Iterator<Item = Cell> + '_ {
        let [x, y] = self.middle(cell);
        let sides = [[CELL, 0.0], [-CELL, 0.0], [0.0, CELL], [0.0, -CELL]];
        sides.into_iter().filter_map(move |[dx, dy]| self.cell(x + dx, y + dy))
    }

    /// The cells about a place, forward and to the left, metres: its own and the eight next to it.
    pub fn about(&self, [forward, left]: [f64; 2]) -> impl Iterator<Item = Cell> + '_ {
        let aside = [-CELL, 0.0, CELL];
        let all = aside.into_iter().flat_map(move |dx| aside.map(move |dy| [forward + dx, left + dy]));
        all.filter_map(|[x, y]| self.cell(x, y))
    }

    /// The longest piece of the way between two places, but for its ends, on which nothing is higher than `below`, metres.
    pub fn longest_empty(&self, a: [f64; 2], b: [f64; 2], end: f64, below: f64) -> f64 {
        const STEP: f64 = 0.25 * CELL;
        let length = (a[0] - b[0]).hypot(a[1] - b[1]);
        let (mut longest, mut run, mut along) = (0.0f64, 0.0, end);
        while along < length - end {
            let [x, y] = [0, 1].map(|i| a[i] + along / length * (b[i] - a[i]));
            let empty = self.cell(x, y).is_some_and(|cell| self.passed[cell] <= below);
            run = if empty { run + STEP } else { 0.0 };
            longest = longest.max(run);
            along += STEP;
        }
        longest
    }
}
