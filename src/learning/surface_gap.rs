//! What a skin of receptors really says: the two limbs' surfaces touch, within the two patches.
//!
//! A receptor reports no point. But the agent knows the surface under each patch, in the limb's own frame,
//! and where two limbs touch the gap between their surfaces is zero: one equation as sharp as the contact
//! itself. Where on the patches it happened is known only to lie inside them: four weak equations, the
//! contact's offset from each patch's centre along its sides, with the deviation of a uniform
//! distribution.

use nalgebra::Vector3;

use crate::geometry::{ContactRegion, ConvexBody, Frame, Gap, PlacedShape, Precision, gap_from};
use crate::learning::observation::{Observation, ObservationModel, TouchResiduals};
use crate::skin::{Receptor, Skin};

/// Residuals beyond this many deviations count ever less (Cauchy weights).
pub const TAIL: f64 = 3.0;
/// Mean of the weights, `E[1 / (1 + z²/TAIL²)]`, over a standard normal `z`. Weighted normal equations hold
/// this share of the information `JᵀJ/σ²` that there is in normal noise. For the contact's place in a patch,
/// uniform and not normal, the mean is `√3 arctan(1/√3) = 0.907`: as good as the same.
pub const MEAN_WEIGHT: f64 = 0.913771;
/// `E[w²] / E[w²z²]` over a standard normal `z`, with the weights `w` above: what makes a weighted variance
/// agree with the deviation of normal noise.
const VARIANCE_FACTOR: f64 = 1.363449;

/// Deviation of the contact's place in a patch, in units of a uniform distribution's, where the last word is
/// spoken. A patch is touched again and again on the same side: its places are biased, and a bias does not
/// average out as the model has it. On Max, at gaps of 1 mm, places at their full weight hold 3 % of the
/// information, add 16 % to the error, and leave the intervals too short.
pub const BIASED_PLACES: f64 = 3.0;
/// The same where places are to say nothing: kilometres.
const NO_EVIDENCE: f64 = 1e5;
/// The least deviation of a gap as evidence, metres. Motions stop when limbs are up to a micrometre in each other, always on
/// the same side, and shapes are found to rounding: that is a bias, which does not average out. A rod that is felt along its
/// side tells hardly anything of where it is along itself; by such biases it would seem to.
pub const SHARPEST: f64 = 1e-5;
/// Noise of the gaps below which no better answer is looked for, metres.
pub const CERTAIN_NOISE: f64 = 2e-5;
/// Most steps to the fixed point of a scale.
const SCALE_ITERATIONS: usize = 100;

/// How many half extents of a patch from its middle a contact may be that it felt: surfaces are curved …
const BEYOND: f64 = 1.2;
/// … and how much farther, metres.
const BEYOND_BY: f64 = 2e-3;
/// The least cosine between a patch's normal and that of the surface where it was touched: it was not felt through
/// the limb.
const FACING: f64 = -0.2;

/// The gap of the two surfaces, and the contact inside both patches.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceGap<'a> {
    /// The skin.
    pub skin: &'a Skin,
    /// Standard deviation of the gap, metres.
    pub gap_deviation: f64,
    /// Standard deviation of the contact's place in a patch, in units of a uniform distribution's.
    pub patch_deviation: f64,
}

impl<'a> SurfaceGap<'a> {
    /// The model with a deviation of the gap, metres, and uniform places in the patches.
    pub fn new(skin: &'a Skin, gap_deviation: f64) -> SurfaceGap<'a> {
        SurfaceGap { skin, gap_deviation, patch_deviation: 1.0 }
    }

    /// The same with places in the patches that count less; see [`BIASED_PLACES`].
    pub fn with_biased_places(self) -> SurfaceGap<'a> {
        SurfaceGap { patch_deviation: BIASED_PLACES, ..self }
    }

    /// The same with places in the patches that are no evidence at all: what rests on them alone is not known, for a
    /// bias does not average out however many touches share it.
    pub fn without_places(self) -> SurfaceGap<'a> {
        SurfaceGap { patch_deviation: NO_EVIDENCE, ..self }
    }

    /// The surfaces under two receptors where their limbs are; none where one is known only by its receptors.
    fn solids(&self, receptors: [&Receptor; 2], frames: &[Frame; 2]) -> [Option<PlacedShape<'a>>; 2] {
        [0, 1].map(|end| self.skin.surfaces[receptors[end].surface?].placed(&frames[end]))
    }

    /// Where the surfaces under two receptors come closest, given their limbs' frames `X_CA`, `X_CB`. A surface that is
    /// known only by its receptors is flat under each of them.
    pub fn gap(&self, ends: &[Observation; 2], frames: &[Frame; 2]) -> Gap {
        self.gap_from(ends, frames, None)
    }

    /// The same, where the normal is nearly known, from the second surface to the first.
    fn gap_from(&self, ends: &[Observation; 2], frames: &[Frame; 2], guess: Option<Vector3<f64>>) -> Gap {
        let receptors = [0, 1].map(|k| &self.skin.receptors[ends[k].receptor]);
        let normal = |k: usize| frames[k].rotation * receptors[k].normal;
        // The solid's lowest point over the flat patch.
        let over_patch = |solid: PlacedShape, k: usize| {
            let normal = normal(k);
            let lowest = solid.support(&-normal);
            let distance = receptors[k].patch_coordinates(&frames[k].inverse_point(&lowest)).z;
            Gap { distance, normal, points: [lowest, lowest - normal * distance] }
        };
        match self.solids(receptors, frames) {
            // How deep wrong limbs are in each other is of no use but to get them out.
            [Some(a), Some(b)] => {
                gap_from(&a, &b, Precision::ExactWhereShallow, &guess.unwrap_or_else(|| normal(1)))
            }
            [Some(a), None] => over_patch(a, 1),
            [None, Some(b)] => over_patch(b, 0).reversed(),
            // Two flat patches say little more than that their centres are near.
            [None, None] => {
                let points = [0, 1].map(|k| frames[k].point(&receptors[k].position));
                let (first, second) = (normal(0), normal(1));
                let normal = (second - first).try_normalize(1e-9).unwrap_or(second);
                Gap { distance: normal.dot(&(points[0] - points[1])), normal, points }
            }
        }
    }
}

impl SurfaceGap<'_> {
    /// Whether a contact where the surfaces under two receptors come closest is one that the two patches feel: within them,
    /// and on their outside. Limbs that are mirrored close gaps as well, on the wrong side. Where a face or an edge lies on
    /// another, any place that both have may be the one that was felt.
    pub fn is_felt(&self, ends: &[Observation; 2], frames: &[Frame; 2], gap: &Gap) -> bool {
        let receptors = [0, 1].map(|end| &self.skin.receptors[ends[end].receptor]);
        let most = receptors.map(|receptor| receptor.half_extents.map(|half| BEYOND * half + BEYOND_BY));
        let outside = [0, 1].into_iter().all(|end| {
            // The gap's normal points from the second surface to the first.
            let outward = frames[end].rotation.tr_mul(&gap.normal) * if end == 0 { -1.0 } else { 1.0 };
            outward.dot(&receptors[end].normal) > FACING
        });
        let inside = |end: usize| {
            let at = receptors[end].patch_coordinates(&frames[end].inverse_point(&gap.middle()));
            at.x.abs() < most[end][0] && at.y.abs() < most[end][1]
        };
        outside && ((inside(0) && inside(1)) || self.is_felt_somewhere(receptors, frames, gap, most))
    }

    /// Whether any place at which the surfaces touch is within both patches, of these half extents (metres).
    fn is_felt_somewhere(
        &self,
        receptors: [&Receptor; 2],
        frames: &[Frame; 2],
        gap: &Gap,
        most: [[f64; 2]; 2],
    ) -> bool {
        let [Some(first), Some(second)] = self.solids(receptors, frames) else { return false };
        let mut region = ContactRegion::new(&first, &second, gap, BEYOND_BY);
        for (end, receptor) in receptors.into_iter().enumerate() {
            let centre = frames[end].point(&receptor.position);
            for (side, most) in [receptor.tangent, receptor.bitangent()].into_iter().zip(most[end]) {
                let side = frames[end].rotation * side;
                region.cut(&side, &centre, most);
                region.cut(&-side, &centre, most);
            }
        }
        !region.is_empty()
    }
}

impl ObservationModel for SurfaceGap<'_> {
    /// The gap's normal in the common frame: steps are small, and the next one is near it.
    type Fixed = Option<Vector3<f64>>;

    fn linearize(
        &self,
        ends: &[Observation; 2],
        frames: &[Frame; 2],
        normal: &mut Option<Vector3<f64>>,
    ) -> (TouchResiduals, f64) {
        let found = self.gap_from(ends, frames, *normal);
        *normal = Some(found.normal);
        let middle = found.middle();
        let points = [0, 1].map(|k| frames[k].inverse_point(&middle));
        let mut residuals = TouchResiduals::new(points);
        let gap = found.distance / self.gap_deviation;
        let mut cost = tailed(gap);
        let weight = 1.0 / (1.0 + (gap / TAIL).powi(2)).sqrt();
        residuals.push(found.normal * (weight / self.gap_deviation), gap * weight);
        for (k, offset, deviation, direction) in self.offsets(ends, &points) {
            let value = offset / deviation;
            cost += tailed(value);
            let weight = 1.0 / (1.0 + (value / TAIL).powi(2)).sqrt();
            // The contact moves over a patch as the other limb moves against it.
            let sign = if k == 0 { -1.0 } else { 1.0 };
            residuals.push(frames[k].rotation * direction * (sign * weight / deviation), value * weight);
        }
        (residuals, cost)
    }

    fn cost(&self, ends: &[Observation; 2], frames: &[Frame; 2], normal: &Option<Vector3<f64>>) -> f64 {
        let found = self.gap_from(ends, frames, *normal);
        let middle = found.middle();
        let points = [0, 1].map(|k| frames[k].inverse_point(&middle));
        let offsets = self.offsets(ends, &points);
        let places = offsets.map(|(_, offset, deviation, _)| tailed(offset / deviation));
        tailed(found.distance / self.gap_deviation) + places.iter().sum::<f64>()
    }
}

impl SurfaceGap<'_> {
    /// Per side of each patch: the end, the contact's offset and its deviation in metres, the direction in
    /// the limb's frame.
    fn offsets(
        &self,
        ends: &[Observation; 2],
        points: &[Vector3<f64>; 2],
    ) -> [(usize, f64, f64, Vector3<f64>); 4] {
        let side = |k: usize, second: bool| {
            let receptor = &self.skin.receptors[ends[k].receptor];
            let direction = if second { receptor.bitangent() } else { receptor.tangent };
            let half = receptor.half_extents[usize::from(second)];
            let offset = (points[k] - receptor.position).dot(&direction);
            (k, offset, self.patch_deviation * half / 3f64.sqrt(), direction)
        };
        [side(0, false), side(0, true), side(1, false), side(1, true)]
    }
}

/// Standard deviation of normal gaps, some of them wild, that parameters were fitted to, metres.
///
/// An M-estimate of scale: the root of `σ² = k Σ w²r² (1 − h) / Σ w²(1 − h)` over the standardized gaps
/// `r = g / √(1 − h)`, with their weights `w` at σ and the constant k that makes it agree with a normal
/// distribution. A gap `g` whose share `h` the fit takes up (its leverage) is that much the smaller, and tells
/// that much less (Maronna, Martin and Yohai, Robust Statistics, 2006, sections 2.5 and 5.1). Each of `gaps`
/// is a gap in metres and its leverage. `start` must be of the right size.
pub fn gap_scale(gaps: &[(f64, f64)], start: f64) -> f64 {
    let mut deviation = start;
    for _ in 0..SCALE_ITERATIONS {
        let (mut squares, mut count) = (0.0, 0.0);
        for (gap, leverage) in gaps {
            let left = (1.0 - leverage).clamp(1e-9, 1.0);
            let weight = 1.0 / (1.0 + gap * gap / (left * (TAIL * deviation).powi(2)));
            squares += (weight * gap).powi(2);
            count += weight * weight * left;
        }
        let next = (VARIANCE_FACTOR * squares / count).sqrt();
        if !(next.is_finite() && next > 0.0) {
            return deviation;
        }
        let settled = (next / deviation - 1.0).abs() < 1e-6;
        deviation = next;
        if settled {
            break;
        }
    }
    deviation
}

/// Cauchy's cost, quadratic near zero.
fn tailed(residual: f64) -> f64 {
    0.5 * TAIL * TAIL * (residual / TAIL).powi(2).ln_1p()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    fn normal(rng: &mut ChaCha8Rng) -> f64 {
        StandardNormal.sample(rng)
    }

    #[test]
    fn the_scale_is_that_of_normal_gaps_whatever_their_leverage_and_a_tenth_of_wild_ones() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let leverages: Vec<f64> = (0..20_000).map(|_| rng.random_range(0.0..0.5)).collect();
        let mut gaps: Vec<(f64, f64)> =
            leverages.into_iter().map(|h| (1e-4 * normal(&mut rng) * (1.0 - h).sqrt(), h)).collect();
        let scale = gap_scale(&gaps, 2e-4);
        assert!((scale / 1e-4 - 1.0).abs() < 0.02, "{scale}");
        for gap in gaps.iter_mut().step_by(10) {
            gap.0 = 0.05;
        }
        let scale = gap_scale(&gaps, 2e-4);
        assert!((scale / 1e-4 - 1.0).abs() < 0.02, "{scale} with false touches");
        assert_eq!(gap_scale(&[], 1e-6), 1e-6);
        assert_eq!(gap_scale(&[(0.0, 0.0)], 1e-6), 1e-6);
    }
}
