//! Touches that a calibration was not fitted to: which, and whether they are where they are predicted.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Matrix3, Vector3};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::estimate::Fit;
use super::noise::Seen;
use super::problem::Estimator;
use super::repeats::postures;
use super::touch::Touch;

/// The share of touches that an interval should hold, …
pub(super) const HOLDS: f64 = 0.95;
/// … and the held-out touches that it takes to say so: one in twenty may lie outside.
pub const FEWEST_HELD_OUT: usize = 20;
/// Stretches of time of which some are held out.
const STRETCHES: usize = 20;

/// Contact residuals, metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Misses {
    /// Root of the mean square.
    pub rms: f64,
    /// The median.
    pub median: f64,
    /// 95 % miss by less.
    pub p95: f64,
    /// The greatest.
    pub max: f64,
}

/// What touches that were not fitted to say.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Judgement {
    /// How many there were.
    pub touches: usize,
    /// At the values from before.
    pub before: Misses,
    /// At the values found.
    pub after: Misses,
    /// The share of them that lies within the interval that is to hold 95 %.
    pub within: f64,
    /// The radius of that interval on average, metres.
    pub interval: f64,
}

impl Misses {
    /// Of touches as they are seen.
    pub fn of<'a>(seen: impl IntoIterator<Item = &'a Seen>) -> Misses {
        let mut sizes: Vec<f64> = seen.into_iter().map(Seen::apart).collect();
        sizes.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let at = share * sizes.len().saturating_sub(1) as f64;
            match (sizes.get(at.floor() as usize), sizes.get(at.ceil() as usize)) {
                (Some(a), Some(b)) => a + (b - a) * at.fract(),
                _ => f64::NAN,
            }
        };
        let squares = mean(sizes.iter().map(|size| size * size));
        Misses { rms: squares.sqrt(), median: at(0.5), p95: at(HOLDS), max: at(1.0) }
    }

    /// The mean over parts that were held out, number by number.
    pub fn mean(parts: impl Iterator<Item = Misses> + Clone) -> Misses {
        let mean = |number: fn(&Misses) -> f64| mean(parts.clone().map(|misses| number(&misses)));
        Misses {
            rms: mean(|m| m.rms),
            median: mean(|m| m.median),
            p95: mean(|m| m.p95),
            max: mean(|m| m.max),
        }
    }
}

/// The mean of numbers, 0 of none.
pub(super) fn mean(numbers: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = numbers.fold((0, 0.0), |(count, sum), number| (count + 1, sum + number));
    sum / f64::from(count.max(1))
}

/// Judges a fit by touches that it was not fitted to.
pub fn judge(estimator: &Estimator, fit: &Fit, fresh: &[Touch]) -> Judgement {
    let of_fresh = estimator.of_touches(fresh);
    let before = of_fresh.seen(&estimator.robot.nominal(), &fit.noise);
    let after = of_fresh.seen(&fit.values, &fit.noise);
    let widths = interval(fit);
    let within = |seen: &Seen| f64::from(u8::from(spread(fit, seen, seen.residuals.value) <= widths));
    let radius = |seen: &Seen| widths * (predicted(fit, seen).trace() - 3.0 + seen.size()).max(0.0).sqrt();
    Judgement {
        touches: fresh.len(),
        before: Misses::of(&before),
        after: Misses::of(&after),
        within: mean(after.iter().map(within)),
        interval: mean(after.iter().map(radius)),
    }
}

/// So many predicted deviations hold 95 % of the touches that were fitted to, each with itself left out.
fn interval(fit: &Fit) -> f64 {
    let left_out = |seen: &Seen| {
        // Of a touch left out, the residual is (I − H)⁻¹ r with its own share H in what was fitted.
        let share = seen.taken_up(&fit.told.covariance) * fit.noise.weight(seen);
        let own = (Matrix3::identity() - share).try_inverse().unwrap_or_else(Matrix3::identity);
        spread(fit, seen, own * seen.residuals.value)
    };
    let mut sizes: Vec<f64> = fit.seen.iter().map(left_out).collect();
    sizes.sort_by(f64::total_cmp);
    // Of n touches and a fresh one, each is as likely the greatest.
    let rank = (HOLDS * (sizes.len() + 1) as f64).ceil() as usize;
    sizes.get(rank.saturating_sub(1)).copied().unwrap_or(f64::INFINITY)
}

/// The covariance of a residual that was not fitted to.
fn predicted(fit: &Fit, seen: &Seen) -> Matrix3<f64> {
    fit.noise.covariance(seen) + seen.taken_up(&fit.told.covariance)
}

/// A residual in units of what is predicted for it: 1 on average for Gaussian noise.
fn spread(fit: &Fit, seen: &Seen, value: Vector3<f64>) -> f64 {
    let squares = predicted(fit, seen).cholesky().map(|factor| factor.solve(&value).dot(&value));
    squares.map_or(f64::INFINITY, |squares| (squares / seen.size()).sqrt())
}

/// Touches that are held out or not together: those of one posture, and of a stretch of time where the log has times. Of each touch
/// the place of its part in a random order.
fn shuffled(touches: &[Touch], count: usize, seed: u64) -> Vec<usize> {
    let times: Option<Vec<f64>> = touches.iter().map(|touch| touch.time).collect();
    let part = times.map_or_else(
        || postures(touches),
        |times| {
            let mut order: Vec<usize> = (0..touches.len()).collect();
            order.sort_by(|a, b| times[*a].total_cmp(&times[*b]));
            let mut part = vec![0; touches.len()];
            order.iter().enumerate().for_each(|(k, touch)| part[*touch] = k * count / touches.len());
            part
        },
    );
    let mut order = Vec::from_iter(part.iter().copied().collect::<BTreeSet<usize>>());
    order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    let rank: BTreeMap<usize, usize> =
        order.into_iter().enumerate().map(|(rank, part)| (part, rank)).collect();
    part.iter().map(|part| rank[part]).collect()
}

/// Touches that are fitted to and those that are held out; no posture is on both sides.
fn divided(touches: &[Touch], held: impl Fn(usize) -> bool) -> [Vec<Touch>; 2] {
    let postures = postures(touches);
    let fitted: BTreeSet<usize> = (0..touches.len()).filter(|i| !held(*i)).map(|i| postures[i]).collect();
    let of = |out: bool| {
        let own = |i: &usize| held(*i) == out && !(out && fitted.contains(&postures[*i]));
        (0..touches.len()).filter(own).map(|i| touches[i].clone()).collect()
    };
    [of(false), of(true)]
}

/// Divides touches at random into those to fit to and a share that is held out.
pub fn split(touches: &[Touch], held_out: f64, seed: u64) -> [Vec<Touch>; 2] {
    let rank = shuffled(touches, STRETCHES, seed);
    let mut sizes: BTreeMap<usize, usize> = BTreeMap::new();
    rank.iter().for_each(|rank| *sizes.entry(*rank).or_default() += 1);
    let mut left = (touches.len() as f64 * held_out).round() as usize;
    sizes.retain(|_, size| {
        let fits = *size <= left;
        left -= if fits { *size } else { 0 };
        fits
    });
    divided(touches, |i| sizes.contains_key(&rank[i]))
}

/// Divides touches at random into so many parts, each of which is held out once: what is fitted to, and what is held out.
pub fn folds(touches: &[Touch], count: usize, seed: u64) -> Vec<[Vec<Touch>; 2]> {
    let count = count.max(1);
    let rank = shuffled(touches, count, seed);
    (0..count).map(|k| divided(touches, |i| rank[i] % count == k)).collect()
}
