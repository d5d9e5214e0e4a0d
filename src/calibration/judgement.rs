//! How a calibration is judged: by touches that it was not fitted to.

use nalgebra::Matrix3;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::estimate::{Estimator, Fit, SeenTouch};
use super::noise::{Seen, taken_up};
use super::touch::Touch;

/// The share of touches that an interval should hold.
const HOLDS: f64 = 0.95;

/// How far apart what touched is put, metres.
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
    pub fn of(seen: &[SeenTouch]) -> Misses {
        let mut sizes: Vec<f64> = seen.iter().map(|(_, _, seen)| seen.residuals.value.norm()).collect();
        sizes.sort_by(f64::total_cmp);
        let at = |share: f64| quantile(&sizes, share);
        let squares: f64 = sizes.iter().map(|size| size * size).sum();
        Misses {
            rms: (squares / sizes.len().max(1) as f64).sqrt(),
            median: at(0.5),
            p95: at(HOLDS),
            max: sizes.last().copied().unwrap_or(f64::NAN),
        }
    }
}

/// Judges a fit by touches that it was not fitted to.
pub fn judge(estimator: &Estimator, fit: &Fit, fresh: &[Touch]) -> Judgement {
    let before = estimator.seen_of(fresh, &estimator.robot.nominal(), &fit.noise);
    let after = estimator.seen_of(fresh, &fit.values, &fit.noise);
    let widths = interval(fit);
    let within =
        after.iter().filter(|(_, _, seen)| spread(fit, seen, seen.residuals.value) <= widths).count();
    let radius = |seen: &Seen| {
        widths * (predicted(fit, seen).trace() - (3 - seen.residuals.size) as f64).max(0.0).sqrt()
    };
    Judgement {
        touches: fresh.len(),
        before: Misses::of(&before),
        after: Misses::of(&after),
        within: within as f64 / after.len().max(1) as f64,
        interval: after.iter().map(|(_, _, seen)| radius(seen)).sum::<f64>() / after.len().max(1) as f64,
    }
}

/// So many predicted deviations hold 95 % of the touches that were fitted to, each with itself left out.
fn interval(fit: &Fit) -> f64 {
    let left_out = |seen: &Seen| {
        // Of a touch left out, the residual is (I − H)⁻¹ r with its own share H in what was fitted.
        let share = taken_up(&seen.residuals, &fit.told.covariance);
        let weight =
            fit.noise.covariance(seen).try_inverse().unwrap_or_else(Matrix3::zeros) * fit.noise.honesty(seen);
        let own = (Matrix3::identity() - share * weight).try_inverse().unwrap_or_else(Matrix3::identity);
        spread(fit, seen, own * seen.residuals.value)
    };
    let mut sizes: Vec<f64> = fit.seen.iter().map(|(_, _, seen)| left_out(seen)).collect();
    sizes.sort_by(f64::total_cmp);
    // Of n touches and a fresh one, each is as likely the greatest.
    let rank = (HOLDS * (sizes.len() + 1) as f64).ceil() as usize;
    sizes.get(rank.saturating_sub(1)).copied().unwrap_or(f64::INFINITY)
}

/// The covariance of a residual that was not fitted to.
fn predicted(fit: &Fit, seen: &Seen) -> Matrix3<f64> {
    fit.noise.covariance(seen) + taken_up(&seen.residuals, &fit.told.covariance)
}

/// A residual in units of what is predicted for it: 1 on average for Gaussian noise.
fn spread(fit: &Fit, seen: &Seen, value: nalgebra::Vector3<f64>) -> f64 {
    let size = seen.residuals.size as f64;
    let whitened = predicted(fit, seen).cholesky().map(|factor| factor.solve(&value).dot(&value));
    whitened.map_or(f64::INFINITY, |squares| (squares / size).sqrt())
}

/// How far apart touches would be whose ends are those of different ones: what a body that explains nothing leaves. None where no
/// two touches are between the same links.
pub fn apart_at_random(estimator: &Estimator, fit: &Fit) -> Option<Misses> {
    let touches = estimator.touches();
    let links = |touch: &Touch| touch.ends.each_ref().map(|ends| ends[0].feature.link(estimator.robot));
    let mut exchanged = Vec::new();
    for (i, touch) in touches.iter().enumerate() {
        // One from far down the log: neighbours are often alike.
        let after = (1..touches.len()).map(|step| &touches[(i + touches.len() / 2 + step) % touches.len()]);
        if let Some(other) = after.take(touches.len() - 1).find(|other| links(other) == links(touch)) {
            let mut mixed = touch.clone();
            mixed.ends[1].clone_from(&other.ends[1]);
            exchanged.push(mixed);
        }
    }
    let seen = estimator.seen_of(&exchanged, &fit.values, &fit.noise);
    (!seen.is_empty()).then(|| Misses::of(&seen))
}

/// Divides touches at random into those to fit to and a share that is held out.
pub fn split(touches: &[Touch], held_out: f64, seed: u64) -> [Vec<Touch>; 2] {
    let mut order: Vec<usize> = (0..touches.len()).collect();
    order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    let held = ((touches.len() as f64 * held_out).round() as usize).min(touches.len());
    let part = |places: &[usize]| {
        let mut places = places.to_vec();
        places.sort_unstable();
        places.iter().map(|place| touches[*place].clone()).collect()
    };
    [part(&order[held..]), part(&order[..held])]
}

/// Divides touches at random into so many parts, each of which is held out once: what is fitted to, and what is held out.
pub fn folds(touches: &[Touch], count: usize, seed: u64) -> Vec<[Vec<Touch>; 2]> {
    let mut order: Vec<usize> = (0..touches.len()).collect();
    order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    let mut part = vec![0; touches.len()];
    order.iter().enumerate().for_each(|(rank, touch)| part[*touch] = rank % count.max(1));
    let of = |held: bool, k: usize| {
        touches
            .iter()
            .zip(&part)
            .filter(|(_, part)| (**part == k) == held)
            .map(|(touch, _)| touch.clone())
            .collect()
    };
    (0..count).map(|k| [of(false, k), of(true, k)]).collect()
}

/// The value below which a share of sorted values lies.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let at = share * sorted.len().saturating_sub(1) as f64;
    let (low, high) = (at.floor() as usize, at.ceil() as usize);
    match (sorted.get(low), sorted.get(high)) {
        (Some(a), Some(b)) => a + (b - a) * (at - low as f64),
        _ => f64::NAN,
    }
}
