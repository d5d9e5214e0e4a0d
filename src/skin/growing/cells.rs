//! From samples of a surface to patches of even size.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use crate::geometry::{SurfaceSample, box_about};

/// Cells whose normals average to less than this face all ways and are split.
const ONE_SIDED: f64 = 0.35;
/// Most cells of one run of Lloyd's iteration.
const MOST_CELLS: usize = 96;
/// Rounds of Lloyd's iteration.
const ROUNDS: usize = 30;
/// A cell bends round an edge where this share of it or more is turned from its middle by more than
/// [`BENT`] allows.
const BENT_SHARE: f64 = 0.01;
/// The cosine of that turn.
const BENT: f64 = 0.2;
/// More sides than this are not told apart.
const MOST_SIDES: usize = 12;
/// How often normals get four times the weight so that no cell bends round an edge.
const WEIGHTS: usize = 4;

/// A flat quadrangle on a surface.
#[derive(Clone, Debug)]
pub struct Patch {
    /// Its centre.
    pub position: Vector3<f64>,
    /// Its sides are the x and y axes, its outward normal the z axis.
    pub orientation: UnitQuaternion<f64>,
    /// Half its sides.
    pub half_extents: [f64; 2],
}

/// What the cells of a surface are to be like.
#[derive(Clone, Copy, Debug)]
pub struct Tiling {
    /// The area that a sample stands for, m².
    pub share: f64,
    /// The area of a cell, m².
    pub area: f64,
    /// Whether the surface has edges, which no cell should bend round.
    pub edges: bool,
    /// The direction that the patches' first sides follow.
    pub long_axis: Vector3<f64>,
}

impl Tiling {
    /// The fewest cells that samples can be gathered in so that each has one outer side and none bends round an edge.
    pub fn fewest(&self, samples: &[SurfaceSample]) -> usize {
        let mean: Vector3<f64> = samples.iter().map(|s| s.1).sum::<Vector3<f64>>() / samples.len() as f64;
        let least = if mean.norm() < ONE_SIDED { 2 } else { 1 };
        let most = MOST_SIDES.min(samples.len());
        if !self.edges {
            return least.min(most);
        }
        // So heavy that only normals count.
        let size = samples.iter().map(|s| s.0.norm_squared()).fold(0.0, f64::max);
        let straight = |&count: &usize| {
            let (centres, owner) = lloyd(samples, 100.0 * size, count, &self.long_axis);
            !bends(samples, &centres, &owner)
        };
        (least..most).find(straight).unwrap_or(most)
    }

    /// Gathers samples into so many cells and makes each a patch.
    ///
    /// Large surfaces are cut in two across their longest side, and their halves again: the time that
    /// Lloyd's iteration takes grows with the samples and with the cells.
    pub fn patches(&self, samples: &[SurfaceSample], count: usize) -> Vec<Patch> {
        if count <= MOST_CELLS {
            return self.gathered(samples, count);
        }
        let [low, high] = box_about(samples.iter().map(|sample| sample.0)).expect("there are samples");
        let axis = (high - low).imax();
        let mut sorted = samples.to_vec();
        sorted.sort_by(|a, b| a.0[axis].total_cmp(&b.0[axis]));
        let first = count / 2;
        let rest = sorted.split_off(samples.len() * first / count);
        let halves = rayon::join(|| self.patches(&sorted, first), || self.patches(&rest, count - first));
        [halves.0, halves.1].concat()
    }

    /// The same without cutting.
    fn gathered(&self, samples: &[SurfaceSample], count: usize) -> Vec<Patch> {
        let Tiling { share, area, edges, long_axis } = self;
        let mut weight = *area;
        let (mut centres, mut owner) = lloyd(samples, weight, count, long_axis);
        for _ in 0..if *edges { WEIGHTS } else { 0 } {
            if !bends(samples, &centres, &owner) {
                break;
            }
            weight *= 4.0;
            (centres, owner) = lloyd(samples, weight, count, long_axis);
        }
        let mut of_cell: Vec<Vec<&SurfaceSample>> = vec![Vec::new(); centres.len()];
        for (sample, &cell) in samples.iter().zip(&owner) {
            of_cell[cell].push(sample);
        }
        let rim = 0.5 * share.sqrt();
        let patch = |(members, &centre): (&Vec<&SurfaceSample>, &usize)| {
            let (position, normal) = samples[centre];
            let along = long_axis - normal * normal.dot(long_axis);
            let tangent = along
                .try_normalize(1e-3)
                .unwrap_or_else(|| crate::geometry::tangent_basis(&normal).column(0).into());
            let bitangent = normal.cross(&tangent);
            let extent = |direction: &Vector3<f64>| {
                members.iter().map(|s| (s.0 - position).dot(direction).abs()).fold(0.0, f64::max) + rim
            };
            let axes = Matrix3::from_columns(&[tangent, bitangent, normal]);
            Patch {
                position,
                orientation: UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes)),
                half_extents: [extent(&tangent), extent(&bitangent)],
            }
        };
        of_cell.iter().zip(&centres).map(patch).collect()
    }
}

/// Whether any cell bends round an edge.
fn bends(samples: &[SurfaceSample], centres: &[usize], owner: &[usize]) -> bool {
    let mut turned = vec![(0usize, 0usize); centres.len()];
    for (sample, &cell) in samples.iter().zip(owner) {
        turned[cell].0 += usize::from(sample.1.dot(&samples[centres[cell]].1) < BENT);
        turned[cell].1 += 1;
    }
    turned.iter().any(|&(turned, all)| turned as f64 > BENT_SHARE * all as f64)
}

/// The cells' middle samples, and per sample its cell: Lloyd's iteration on distance² + `weight` (1 − cosine of
/// the normals).
fn lloyd(
    samples: &[SurfaceSample],
    weight: f64,
    count: usize,
    long_axis: &Vector3<f64>,
) -> (Vec<usize>, Vec<usize>) {
    // Farthest-point start: deterministic and spread out.
    let mut centres = vec![farthest(samples, |k| -(samples[k].0.dot(long_axis)))];
    let mut nearest = vec![f64::INFINITY; samples.len()];
    while centres.len() < count {
        let last = samples[centres[centres.len() - 1]].0;
        for (nearest, sample) in nearest.iter_mut().zip(samples) {
            *nearest = nearest.min((last - sample.0).norm());
        }
        centres.push(farthest(samples, |k| nearest[k]));
    }
    let mut owner = vec![0; samples.len()];
    for _ in 0..ROUNDS {
        for (sample, owner) in samples.iter().zip(&mut owner) {
            // Normals count as well, so that no cell folds around an edge that another could cover.
            let cost = |c: usize| {
                let (point, normal) = samples[c];
                (point - sample.0).norm_squared() + weight * (1.0 - normal.dot(&sample.1))
            };
            let mut best = (0, f64::INFINITY);
            for (cell, &centre) in centres.iter().enumerate() {
                let cost = cost(centre);
                if cost < best.1 {
                    best = (cell, cost);
                }
            }
            *owner = best.0;
        }
        let mut sums = vec![(Vector3::zeros(), Vector3::zeros(), 0usize); centres.len()];
        for (sample, &cell) in samples.iter().zip(&owner) {
            let sum: &mut (Vector3<f64>, Vector3<f64>, usize) = &mut sums[cell];
            *sum = (sum.0 + sample.0, sum.1 + sample.1, sum.2 + 1);
        }
        let means: Vec<SurfaceSample> = sums
            .into_iter()
            .map(|(places, normals, number)| (places / number.max(1) as f64, normals / number.max(1) as f64))
            .collect();
        let mut middles = vec![(None, f64::INFINITY); centres.len()];
        for (k, (sample, &cell)) in samples.iter().zip(&owner).enumerate() {
            let (middle, facing) = means[cell];
            let cost = (sample.0 - middle).norm_squared() + weight * (1.0 - sample.1.dot(&facing));
            if cost < middles[cell].1 {
                middles[cell] = (Some(k), cost);
            }
        }
        let mut moved = false;
        for (centre, (middle, _)) in centres.iter_mut().zip(middles) {
            if let Some(middle) = middle.filter(|middle| middle != centre) {
                *centre = middle;
                moved = true;
            }
        }
        if !moved {
            break;
        }
    }
    (centres, owner)
}

/// The sample with the greatest value; the first of equals.
fn farthest(samples: &[SurfaceSample], value: impl Fn(usize) -> f64) -> usize {
    let mut best = (0, f64::NEG_INFINITY);
    for k in 0..samples.len() {
        let found = value(k);
        if found > best.1 + 1e-12 {
            best = (k, found);
        }
    }
    best.0
}
