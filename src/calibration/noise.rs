//! How much touches miss by: deviations for each pair of links, of encoders, and the share of touches that say nothing.
//!
//! With its derivative `∂r/∂q` by the joints as they are, a residual of `d` numbers is
//!
//! ```text
//! r ~ N(0, σ² I + σ_q² ∂r/∂q ∂r/∂qᵀ)  with probability 1 − ε,  else uniform in a ball (an interval) as wide as misses get
//! ```
//!
//! where σ² is what is given with the touch and what more its pair of links shows. The deviations are of greatest restricted likelihood
//! by steps that cannot overshoot (Zhou, Hu, Zhou and Lange, "MM Algorithms for Variance Components Models", 2019). A pair's
//! deviation is held to those of the others as if it had been seen a few times more at their mean (Smyth, "Linear Models and
//! Empirical Bayes Methods", 2004): few touches that the parameters can fit exactly would come out as exact.

use nalgebra::{DMatrix, Matrix3, Vector3};

use super::touch::Residuals;

/// No touch is more exact than this, metres: rounding.
const FINEST: f64 = 1e-10;
/// Pairs of links with fewer touches than this share one deviation.
const FEW: usize = 20;
/// So many numbers a pair of links is taken to have been seen by besides its own, as noisy as the other pairs are.
const AS_OTHERS: f64 = 4.0;
/// Widths of a distribution by which a false touch may miss at the least.
const WIDEST: f64 = 10.0;

/// How much noise there is.
#[derive(Clone, Debug, PartialEq)]
pub struct Noise {
    /// Per group of touches the standard deviation of each residual, metres.
    pub groups: Vec<f64>,
    /// Standard deviation of joints as they are about what encoders read, radians and metres.
    pub joint: f64,
    /// Share of touches that are false.
    pub false_share: f64,
    /// Per group how far false touches may miss, metres.
    pub widths: Vec<f64>,
    /// An encoder that says nothing of its joint, where one is taken to be.
    pub dead: Option<DeadEncoder>,
}

/// An encoder that does not follow its joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeadEncoder {
    /// The degree of freedom.
    pub dof: usize,
    /// How far off the joint is from what is read, a standard deviation, radians or metres.
    pub deviation: f64,
}

/// Which group a residual is of, and what is known of its noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseSource {
    /// The group, an index into [`Noise::groups`].
    pub group: usize,
    /// The variance that was given with its ends, m².
    pub given: f64,
}

/// A residual at the present values, with what its noise depends on.
#[derive(Clone, Debug)]
pub struct Seen {
    /// The residuals.
    pub residuals: Residuals,
    /// Where their noise comes from.
    pub source: NoiseSource,
}

impl Noise {
    /// So many groups of the same noise.
    pub fn alike(groups: usize, deviation: f64) -> Noise {
        Noise {
            groups: vec![deviation; groups],
            joint: 0.0,
            false_share: 0.0,
            widths: vec![1.0; groups],
            dead: None,
        }
    }

    /// The covariance of a residual, the unit beyond its size.
    pub fn covariance(&self, seen: &Seen) -> Matrix3<f64> {
        let variance = (seen.source.given + self.groups[seen.source.group].powi(2)).max(FINEST * FINEST);
        let mut covariance = Matrix3::identity();
        (0..seen.residuals.size).for_each(|i| covariance[(i, i)] = variance);
        if self.joint > 0.0 {
            covariance += joint_part(seen) * self.joint.powi(2);
        }
        if let Some(DeadEncoder { dof, deviation }) = self.dead {
            let slope = along(seen, dof) * deviation;
            covariance += slope * slope.transpose();
        }
        covariance
    }

    /// `−log p(r)` of a residual if it is honest.
    pub fn honest_cost(&self, seen: &Seen) -> f64 {
        let covariance = self.covariance(seen);
        let Some(factor) = covariance.cholesky() else { return f64::INFINITY };
        let size = seen.residuals.size as f64;
        let whitened = factor.solve(&seen.residuals.value).dot(&seen.residuals.value);
        0.5 * (whitened + size * std::f64::consts::TAU.ln()) + factor.l().diagonal().map(f64::ln).sum()
    }

    /// `−log p(r)` of a residual if it is false.
    pub fn false_cost(&self, seen: &Seen) -> f64 {
        let width = self.widths[seen.source.group];
        match seen.residuals.size {
            3 => (4.0 / 3.0 * std::f64::consts::PI * width.powi(3)).ln(),
            _ => (2.0 * width).ln(),
        }
    }

    /// How likely a touch is honest.
    pub fn honesty(&self, seen: &Seen) -> f64 {
        if self.false_share <= 0.0 {
            return 1.0;
        }
        let odds = (self.false_share / (1.0 - self.false_share)).ln() + self.honest_cost(seen)
            - self.false_cost(seen);
        1.0 / (1.0 + odds.exp())
    }

    /// `−log p(r)`, whichever it is.
    pub fn cost(&self, seen: &Seen) -> f64 {
        let honest = self.honest_cost(seen);
        if self.false_share <= 0.0 {
            return honest;
        }
        let honest = honest - (1.0 - self.false_share).ln();
        let least = self.false_cost(seen) - self.false_share.ln();
        let low = honest.min(least);
        low - ((low - honest).exp() + (low - least).exp()).ln()
    }

    /// The noise of greatest restricted likelihood for residuals with what is known after them: `covariance` of the
    /// parameters takes account of what they took up. `with_joints` says whether encoders are noisy, too, `with_false` whether
    /// touches may be false.
    pub fn estimated(
        &self,
        seen: &[Seen],
        covariance: &DMatrix<f64>,
        with_joints: bool,
        with_false: bool,
    ) -> Noise {
        let mut noise = self.clone();
        let taken_up: Vec<Matrix3<f64>> =
            seen.iter().map(|seen| taken_up(&seen.residuals, covariance)).collect();
        let rounds = if with_joints { 40 } else { 1 };
        let honesty: Vec<f64> = seen.iter().map(|seen| self.honesty(seen)).collect();
        if with_joints && noise.joint == 0.0 {
            noise.joint = noise.start_of_joints(seen);
        }
        for _ in 0..rounds {
            let mut sums = vec![[0.0; 2]; noise.groups.len()];
            // Numbers that are left of each group's once the parameters took up theirs.
            let mut left = vec![0.0; noise.groups.len()];
            let mut joints = [0.0; 2];
            for ((seen, taken_up), honesty) in seen.iter().zip(&taken_up).zip(&honesty) {
                let Some(inverse) = noise.covariance(seen).try_inverse() else { continue };
                let residual = seen.residuals.value;
                let squares = residual * residual.transpose() + taken_up;
                let pulled = inverse * squares * inverse;
                let mut ones = Matrix3::zeros();
                (0..seen.residuals.size).for_each(|i| ones[(i, i)] = 1.0);
                let add = |sums: &mut [f64; 2], part: &Matrix3<f64>| {
                    sums[0] += honesty * (pulled * part).trace();
                    sums[1] += honesty * (inverse * part).trace();
                };
                add(&mut sums[seen.source.group], &ones);
                let own = ((inverse - inverse * taken_up * inverse) * ones).trace();
                left[seen.source.group] += honesty * noise.groups[seen.source.group].powi(2) * own;
                if with_joints {
                    add(&mut joints, &joint_part(seen));
                }
            }
            // Without encoders' noise one such step is exact where all of a group are alike.
            let share = |[above, below]: [f64; 2]| if below > 0.0 { (above / below).sqrt() } else { 1.0 };
            let others = mean_of_many(&noise.groups, &left);
            for (deviation, sums) in noise.groups.iter_mut().zip(&mut sums) {
                if let Some(others) = others {
                    sums[0] += AS_OTHERS * others.powi(2) / deviation.powi(4);
                    sums[1] += AS_OTHERS / deviation.powi(2);
                }
            }
            for (deviation, sums) in noise.groups.iter_mut().zip(sums) {
                let share = share(sums);
                *deviation *= if with_joints { share.sqrt() } else { share };
                *deviation = deviation.max(FINEST);
            }
            noise.joint *= share(joints).sqrt();
        }
        if with_false {
            let most = seen.len() as f64;
            noise.false_share =
                (honesty.iter().map(|honesty| 1.0 - honesty).sum::<f64>() / most).clamp(1e-6, 0.6);
        }
        noise
    }

    /// Encoders' noise that would explain half of the misses.
    fn start_of_joints(&self, seen: &[Seen]) -> f64 {
        let (mut squares, mut slopes) = (0.0, 0.0);
        for seen in seen {
            squares += seen.residuals.value.norm_squared();
            slopes += joint_part(seen).trace();
        }
        if slopes > 0.0 { (0.5 * squares / slopes).sqrt() } else { 0.0 }
    }

    /// Sets how far false touches may miss by what is missed now.
    pub fn widen(&mut self, seen: &[Seen]) {
        for (group, width) in self.widths.iter_mut().enumerate() {
            let misses = seen.iter().filter(|seen| seen.source.group == group);
            let most = misses.map(|seen| seen.residuals.value.norm()).fold(0.0, f64::max);
            *width = most.max(WIDEST * self.groups[group]).max(FINEST);
        }
    }
}

/// The geometric mean of deviations, each counted as often as numbers were left to tell it; none where hardly any were.
fn mean_of_many(deviations: &[f64], left: &[f64]) -> Option<f64> {
    let weights = left.iter().map(|left| left.max(0.0));
    let all: f64 = weights.clone().sum();
    let logarithms: f64 =
        deviations.iter().zip(weights).map(|(deviation, weight)| weight * deviation.ln()).sum();
    (all > 1.0).then(|| (logarithms / all).exp())
}

/// A residual's derivative by a degree of freedom as it is; both sides may move with it.
pub fn along(seen: &Seen, dof: usize) -> Vector3<f64> {
    seen.residuals.by_dof.iter().filter(|(other, _)| *other == dof).map(|(_, slope)| slope).sum()
}

/// `∂r/∂q ∂r/∂qᵀ`.
fn joint_part(seen: &Seen) -> Matrix3<f64> {
    // Both sides may move with one joint.
    let mut slopes: Vec<(usize, Vector3<f64>)> = Vec::with_capacity(seen.residuals.by_dof.len());
    for (dof, slope) in &seen.residuals.by_dof {
        match slopes.iter_mut().find(|(other, _)| other == dof) {
            Some((_, sum)) => *sum += slope,
            None => slopes.push((*dof, *slope)),
        }
    }
    slopes.iter().map(|(_, slope)| slope * slope.transpose()).sum()
}

/// What the parameters' covariance makes of a residual's: `J Σ Jᵀ`.
pub fn taken_up(residuals: &Residuals, covariance: &DMatrix<f64>) -> Matrix3<f64> {
    let mut sum = Matrix3::zeros();
    for (i, a) in &residuals.slopes {
        for (j, b) in &residuals.slopes {
            sum += a * b.transpose() * covariance[(*i, *j)];
        }
    }
    sum
}

/// Groups of touches by what they are between. Those of few touches are one, and where all these are few, too, they are taken to
/// be as noisy as the most frequent ones.
#[derive(Clone, Debug)]
pub struct Groups<K> {
    of_many: Vec<K>,
    /// The group of all others.
    rest: usize,
}

impl<K: Ord + Copy> Groups<K> {
    /// Of so many touches' keys.
    pub fn of(keys: &[K]) -> Groups<K> {
        let mut counts = std::collections::BTreeMap::new();
        keys.iter().for_each(|key| *counts.entry(*key).or_insert(0) += 1);
        let most = counts.iter().max_by_key(|(_, count)| **count).map(|(key, _)| *key);
        let of_many: Vec<K> =
            counts.iter().filter(|(_, count)| **count >= FEW).map(|(key, _)| *key).collect();
        let few: usize = counts.values().filter(|count| **count < FEW).sum();
        let most = of_many.iter().position(|key| Some(*key) == most);
        let rest = most.filter(|_| few < FEW).unwrap_or(of_many.len());
        Groups { of_many, rest }
    }

    /// The group of a key.
    pub fn group(&self, key: &K) -> usize {
        self.of_many.iter().position(|other| other == key).unwrap_or(self.rest)
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.of_many.len().max(self.rest + 1)
    }
}
