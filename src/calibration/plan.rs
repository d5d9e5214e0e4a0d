//! What to measure next: of touches that could be made, those that tell most.
//!
//! With the unknowns' covariance `Σ` so far, what touches will be predicted to miss by has the mean square `tr(M Σ)`, where `M` is
//! the mean of `JᵀJ` over all that could be made. A touch of noise `W⁻¹` takes `tr(S⁻¹ J Σ M Σ Jᵀ)` off it, `S = W⁻¹ + J Σ Jᵀ`
//! (I-optimality; Fedorov, "Theory of Optimal Experiments", 1972). The touches are chosen one after the other, each the one that
//! takes off most.
//!
//! How good a choice can be at all is told by shares `w` of touches in its place: `φ(w) = tr(M Σ(w))` is convex, so that from any
//! shares on no choice of `n` comes below `φ − n (max g − Σ w g)`, where `−n g` is its slope by each (Kiefer and Wolfowitz, "The
//! Equivalence of Two Extremum Problems", 1960). The shares are multiplied by `√g` until that is near (Silvey, Titterington and
//! Torsney, "An Algorithm for Optimal Designs on a Finite Design Space", 1978).

use nalgebra::{DMatrix, DVector, Matrix3};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::noise::{Noise, Seen};
use super::problem::{Estimator, information};
use super::robot::Value;

/// Rounds at the most in which shares are bettered, and how near the best they need to be.
const SHARE_ROUNDS: usize = 300;
const NEAR: f64 = 0.02;
/// Orders at random in which touches are made to compare.
const ORDERS: usize = 9;

/// A touch that is worth making.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// Which of the candidates.
    pub candidate: usize,
    /// By how much the touches before it and it are predicted better than without it: root mean squares, metres.
    pub gain: f64,
    /// The parameter whose deviation it makes smaller most, and by which factor.
    pub tells: (usize, f64),
}

/// A plan, and what it comes to.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The touches, the first one first.
    pub touches: Vec<Planned>,
    /// The covariance of the unknowns after them.
    pub covariance: DMatrix<f64>,
    /// What all candidates will then be predicted to miss by for the unknowns' sake: the root mean square, metres.
    pub predicted: f64,
    /// Below this no choice of as many of the candidates comes, metres.
    pub floor: f64,
    /// So many candidates at random come to as much; none where it takes all of them.
    pub at_random: Option<usize>,
}

/// Chooses `count` of the estimator's touches, as they would be at `values` in some noise.
pub fn plan(estimator: &Estimator, values: &[Value], noise: &Noise, count: usize) -> Plan {
    let candidates = Candidates::new(estimator, values, noise);
    let mut covariance = candidates.before.clone();
    let mut left: Vec<usize> = (0..candidates.touches.len()).collect();
    let mut touches = Vec::new();
    while touches.len() < count && !left.is_empty() {
        let weighted = &covariance * &candidates.mean * &covariance;
        // What a touch takes off the mean square.
        let gain = |k: &usize| {
            let seen = &candidates.touches[*k];
            let spread = candidates.noise[*k] + seen.taken_up(&covariance);
            spread.try_inverse().map_or(0.0, |inverse| (inverse * seen.taken_up(&weighted)).trace())
        };
        let gains: Vec<f64> = left.par_iter().map(gain).collect();
        let most = (0..left.len()).max_by(|a, b| gains[*a].total_cmp(&gains[*b])).unwrap_or(0);
        let k = left.swap_remove(most);
        let without = covariance.clone();
        update(&mut covariance, &candidates.touches[k], &candidates.noise[k]);
        let ratio = |before: f64, after: f64| (before / after.max(f64::MIN_POSITIVE)).sqrt();
        touches.push(Planned {
            candidate: candidates.touches[k].touch,
            gain: candidates.mean_square(&without).sqrt() - candidates.mean_square(&covariance).sqrt(),
            tells: without.diagonal().zip_map(&covariance.diagonal(), ratio).argmax(),
        });
    }
    let reached = candidates.mean_square(&covariance);
    Plan {
        predicted: reached.sqrt(),
        floor: candidates.floor(touches.len() as f64).sqrt(),
        at_random: candidates.at_random(reached),
        touches,
        covariance,
    }
}

/// Touches that could be made.
struct Candidates {
    /// How each would be seen. Of several contacts of a touch the first speaks for it.
    touches: Vec<Seen>,
    /// `W⁻¹` of each.
    noise: Vec<Matrix3<f64>>,
    /// `M`, the mean of `JᵀJ`.
    mean: DMatrix<f64>,
    /// What is known of the unknowns before: what is nearly known, and of what is free that it is not beyond all measure.
    before: DMatrix<f64>,
}

impl Candidates {
    fn new(estimator: &Estimator, values: &[Value], noise: &Noise) -> Candidates {
        let mut touches = estimator.seen(values, noise);
        touches.dedup_by_key(|seen| seen.touch);
        let covariances = touches.iter().map(|seen| noise.covariance(seen)).collect();
        let unknowns = &estimator.unknowns;
        let variance = |place: usize| {
            let open = unknowns.open_deviation(estimator.robot, place);
            unknowns.deviation_before(place).unwrap_or(open).powi(2)
        };
        let before = DMatrix::from_diagonal(&DVector::from_fn(unknowns.len(), |place, _| variance(place)));
        let share = Matrix3::identity() / touches.len() as f64;
        let mean = information(unknowns.len(), touches.iter().map(|seen| (seen, share)));
        Candidates { touches, noise: covariances, mean, before }
    }

    /// By how much the touches are predicted to miss where so much is known: the mean square, m².
    fn mean_square(&self, covariance: &DMatrix<f64>) -> f64 {
        self.mean.dot(covariance).max(0.0)
    }

    /// Below this mean square no choice of so many comes.
    fn floor(&self, count: f64) -> f64 {
        let weights: Option<Vec<Matrix3<f64>>> = self.noise.iter().map(|noise| noise.try_inverse()).collect();
        let (Some(weights), Some(told_before)) = (weights, self.before.clone().try_inverse()) else {
            return 0.0;
        };
        let mut shares = vec![1.0 / self.touches.len() as f64; self.touches.len()];
        let mut floor = 0.0f64;
        for _ in 0..SHARE_ROUNDS {
            let shared = self.touches.iter().zip(&weights).zip(&shares);
            let shared = shared.map(|((seen, weight), share)| (seen, weight * (share * count)));
            let told = &told_before + information(self.before.nrows(), shared);
            let Some(covariance) = told.try_inverse() else { break };
            let weighted = &covariance * &self.mean * &covariance;
            let slopes: Vec<f64> = self
                .touches
                .par_iter()
                .zip(&weights)
                .map(|(seen, weight)| (weight * seen.taken_up(&weighted)).trace().max(0.0))
                .collect();
            let mean: f64 = slopes.iter().zip(&shares).map(|(slope, share)| slope * share).sum();
            let most = slopes.iter().copied().fold(0.0, f64::max);
            let reached = self.mean_square(&covariance);
            floor = floor.max(reached - count * (most - mean));
            if floor > (1.0 - NEAR) * reached {
                break;
            }
            shares.iter_mut().zip(&slopes).for_each(|(share, slope)| *share *= slope.sqrt());
            let sum: f64 = shares.iter().sum();
            shares.iter_mut().for_each(|share| *share /= sum);
        }
        floor
    }

    /// How many touches at random come to a mean square: the median of several orders; none where most come to it with all of
    /// the candidates at the earliest.
    fn at_random(&self, mean_square: f64) -> Option<usize> {
        let mut order: Vec<usize> = (0..self.touches.len()).collect();
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let mut counts: Vec<usize> = (0..ORDERS)
            .map(|_| {
                order.shuffle(&mut rng);
                let mut covariance = self.before.clone();
                let enough = order.iter().position(|&k| {
                    update(&mut covariance, &self.touches[k], &self.noise[k]);
                    self.mean_square(&covariance) <= mean_square
                });
                enough.map_or(usize::MAX, |last| last + 1)
            })
            .collect();
        counts.sort_unstable();
        Some(counts[ORDERS / 2]).filter(|count| *count < self.touches.len())
    }
}

/// The covariance after a touch more: `Σ − Σ Jᵀ (W⁻¹ + J Σ Jᵀ)⁻¹ J Σ`.
fn update(covariance: &mut DMatrix<f64>, seen: &Seen, noise: &Matrix3<f64>) {
    let n = covariance.nrows();
    // Σ Jᵀ, n × 3.
    let mut across: DMatrix<f64> = DMatrix::zeros(n, 3);
    for (i, slope) in &seen.residuals.slopes {
        for row in 0..n {
            let c = covariance[(row, *i)];
            (0..3).for_each(|k| across[(row, k)] += c * slope[k]);
        }
    }
    let Some(inverse) = (noise + seen.taken_up(covariance)).try_inverse() else { return };
    *covariance -= &across * inverse * across.transpose();
}
