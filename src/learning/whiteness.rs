//! How much less touches tell than as many independent ones.
//!
//! The information that touches hold is counted as if each had noise of its own. A receptor that is not where the agent
//! believes it to be errs in the same way in every touch, and a thousand touches average it out no better than its
//! receptors are many. Then gaps that share a receptor are alike, which the gaps themselves show.

use super::surface_gap::{SurfaceGap, TAIL};
use super::touch_set::TouchSet;
use crate::schema::BodySchema;
use crate::skin::Skin;

/// Standard deviations of chance beyond which gaps are alike: independent noise is left as it is in 49 of 50 cases.
const CHANCE: f64 = 2.0;

/// How many times greater the variance of what touches determine is than were they independent; 1 where they are, as far
/// as their gaps at a fitted schema show.
///
/// The design effect of Kish ("Survey Sampling", 1965), `1 + Σ_{i≠j} r_i r_j / Σ_i r_i²` over gaps of touches that share a
/// receptor, in units of their own deviations: `deviation`, metres, times each one's scale. Gaps wider than `TAIL` of
/// these count as if they were as wide as that: false touches are no noise.
pub fn design_effect(
    skin: &Skin,
    touches: &TouchSet,
    schema: &BodySchema,
    deviation: f64,
    scales: Option<&[f64]>,
) -> f64 {
    let model = SurfaceGap::new(skin, 1.0);
    let gaps = touches.touches().enumerate().map(|(number, touch)| {
        let scale = deviation * scales.map_or(1.0, |scales| scales[number]);
        let gap = model.gap(&touch.ends, &touch.frames(schema)).distance / scale;
        ([touch.ends[0].receptor, touch.ends[1].receptor], gap.clamp(-TAIL, TAIL))
    });
    design_effect_of(gaps, skin.receptors.len())
}

/// The same of gaps in their own deviations, each with the receptors that it is between.
fn design_effect_of(gaps: impl Iterator<Item = ([usize; 2], f64)>, receptors: usize) -> f64 {
    // Per receptor the sum of its gaps, of their squares, and their number.
    let mut of_receptors = vec![[0.0; 3]; receptors];
    let (mut squares, mut count) = (0.0, 0.0);
    for (ends, gap) in gaps {
        squares += gap * gap;
        count += 1.0;
        for end in ends {
            let sums = &mut of_receptors[end];
            [gap, gap * gap, 1.0].into_iter().zip(sums).for_each(|(one, sum)| *sum += one);
        }
    }
    if squares == 0.0 {
        return 1.0;
    }
    let alike: f64 = of_receptors.iter().map(|[sum, squares, _]| sum * sum - squares).sum::<f64>() / squares;
    let pairs: f64 = of_receptors.iter().map(|[_, _, touches]| touches * (touches - 1.0)).sum();
    let chance = (2.0 * pairs).sqrt() / count;
    if alike > CHANCE * chance { 1.0 + alike } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// Gaps between random receptors of 40, with noise of their own and `shared` times as much of each receptor.
    fn effect(shared: f64, seed: u64) -> f64 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let own: Vec<f64> = (0..40).map(|_| StandardNormal.sample(&mut rng)).collect();
        let gaps = (0..400).map(|_| {
            let ends = [rng.random_range(0..20), rng.random_range(20..40)];
            let noise: f64 = StandardNormal.sample(&mut rng);
            (ends, noise + shared * (own[ends[0]] + own[ends[1]]))
        });
        design_effect_of(gaps.collect::<Vec<_>>().into_iter(), 40)
    }

    #[test]
    fn gaps_that_share_a_receptor_are_seen_to_be_alike_and_others_are_not() {
        assert!((0..20).filter(|&seed| effect(0.0, seed) > 1.0).count() <= 2);
        // A tenth of each gap's variance is that of either receptor, which has 19 other touches on average.
        let mean = (0..20).map(|seed| effect(0.35, seed)).sum::<f64>() / 20.0;
        assert!((3.5..6.5).contains(&mean), "{mean}");
        assert_eq!(design_effect_of(std::iter::empty(), 3), 1.0);
    }
}
