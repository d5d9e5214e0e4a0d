//! Gaps that are a function of the posture.
//!
//! Noise differs from touch to touch; the gaps of a wrong answer do not: a wrong axis leaves much the same gap in postures that
//! are much the same. How wide gaps are tells the two apart only where other touches show how narrow they could be.

use std::collections::BTreeMap;

use super::open::SHARPLY_OPEN;
use super::{Member, Scrutiny, ToldTouch};
use crate::learning::annealing::{quantile, sorted};
use crate::learning::surface_gap::CERTAIN_NOISE;
use crate::schema::BodySchema;

/// Touches of a pair of limbs from which on a pattern in their gaps shows.
const SHOWING: usize = 30;
/// Most touches of a pair of limbs that are looked at.
const MOST: usize = 1000;
/// Gaps count as no more than so many times half of all: a few wide ones are no pattern.
const WIDEST: f64 = 3.0;
/// Likeness of gaps in neighbouring postures from which on they are a pattern.
const PATTERN: f64 = 0.5;
/// The share of its touches that a joint or a limb has with patterns where it is wrong.
const MOSTLY: f64 = 0.5;

impl Scrutiny<'_> {
    /// The joint or the limb of whose touches most have gaps that are a function of the posture under a schema that was fitted to
    /// them; `deviation` is that of a gap, metres.
    ///
    /// Where touches may be noisy nothing is asked of gaps that are wide: a misplaced receptor leaves much the same gap in much the
    /// same postures as well.
    pub fn patterned(&self, told: &[&ToldTouch], schema: &BodySchema, deviation: f64) -> Option<Member> {
        let may_be_noise = self.has_false_touches && deviation > CERTAIN_NOISE;
        if self.by_points() || may_be_noise {
            return None;
        }
        let mut pairs: BTreeMap<[usize; 2], Vec<&ToldTouch>> = BTreeMap::new();
        for &touch in told {
            pairs.entry(touch.limbs).or_default().push(touch);
        }
        let against: BTreeMap<[usize; 2], bool> = pairs
            .into_iter()
            .map(|(limbs, touches)| (limbs, self.likeness(&touches, schema) > PATTERN))
            .collect();
        let told = told.iter().map(|&touch| (touch, against[&touch.limbs]));
        self.most_suspect(told, |_, of_it| of_it.against > MOSTLY * (of_it.right + of_it.against))
    }

    /// How alike the gaps of two limbs are in neighbouring postures, as [`likeness`](crate::learning::noise::likeness) has it of
    /// neighbouring places; 0 where gaps are as narrow as those of right answers, or few.
    fn likeness(&self, touches: &[&ToldTouch], schema: &BodySchema) -> f64 {
        if touches.len() < SHOWING {
            return 0.0;
        }
        let step = touches.len().div_ceil(MOST).max(1);
        let touches: Vec<&ToldTouch> = touches.iter().copied().step_by(step).collect();
        let gap = |touch: &&ToldTouch| touch.prepared.gap(self.agent.skin(), schema).distance;
        let gaps: Vec<f64> = touches.iter().map(gap).collect();
        let usual = quantile(&sorted(gaps.iter().map(|gap| gap.abs())), 0.5);
        if usual <= SHARPLY_OPEN {
            return 0.0;
        }
        let gaps: Vec<f64> = gaps.iter().map(|gap| (gap / usual).clamp(-WIDEST, WIDEST)).collect();
        let (mut alike, mut all) = (0.0, 0.0);
        for (own, gap) in touches.iter().zip(&gaps) {
            let apart = |other: &ToldTouch| -> f64 {
                own.coordinates.iter().zip(&other.coordinates).map(|(a, b)| (a - b).powi(2)).sum()
            };
            let others = touches.iter().zip(&gaps).filter(|(other, _)| !std::ptr::eq(**other, *own));
            let nearest = others.map(|(other, gap)| (apart(other), gap));
            if let Some((_, other)) = nearest.min_by(|a, b| a.0.total_cmp(&b.0)) {
                alike += gap * other;
                all += gap * gap;
            }
        }
        alike / all
    }
}
