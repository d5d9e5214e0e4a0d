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

use std::collections::BTreeMap;

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
/// Steps of the deviations where encoders are noisy, too; without, one such step is exact where all of a group are alike.
const JOINT_STEPS: usize = 40;

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
    /// An encoder that says nothing of its joint, where one is taken to be: the degree of freedom, and the standard deviation of
    /// the joint from what is read, radians or metres.
    pub dead: Option<(usize, f64)>,
}

/// A touch at some values: what is left of it, and what its noise depends on.
#[derive(Clone, Debug)]
pub struct Seen {
    /// Which touch.
    pub touch: usize,
    /// Which of its ends met.
    pub ends: [usize; 2],
    /// The residuals.
    pub residuals: Residuals,
    /// The group of its noise, an index into [`Noise::groups`].
    pub group: usize,
    /// The variance that was given with its ends, m².
    pub given: f64,
}

impl Seen {
    /// Contact residuals, metres.
    pub fn apart(&self) -> f64 {
        self.residuals.value.norm()
    }

    /// How many equations it is.
    pub fn size(&self) -> f64 {
        self.residuals.size as f64
    }

    /// The residual's derivative by a degree of freedom as it is.
    pub fn along(&self, dof: usize) -> Vector3<f64> {
        self.residuals.by_dof.iter().filter(|(other, _)| *other == dof).map(|(_, slope)| slope).sum()
    }

    /// What the parameters' covariance makes of the residual's: `J Σ Jᵀ`.
    pub fn taken_up(&self, covariance: &DMatrix<f64>) -> Matrix3<f64> {
        let slopes = &self.residuals.slopes;
        let pairs = slopes.iter().flat_map(|a| slopes.iter().map(move |b| (a, b)));
        pairs.map(|((i, a), (j, b))| a * b.transpose() * covariance[(*i, *j)]).sum()
    }

    /// `∂r/∂q ∂r/∂qᵀ`.
    fn by_joints(&self) -> Matrix3<f64> {
        self.residuals.by_dof.iter().map(|(_, slope)| slope * slope.transpose()).sum()
    }

    /// The unit of as many residuals as there are.
    fn ones(&self) -> Matrix3<f64> {
        let size = self.residuals.size;
        Matrix3::from_diagonal(&Vector3::from_fn(|i, _| if i < size { 1.0 } else { 0.0 }))
    }
}

impl Noise {
    /// The variance of a residual of a group without what noisy encoders add, with what was given of it, m².
    pub fn variance(&self, group: usize, given: f64) -> f64 {
        (given + self.groups[group].powi(2)).max(FINEST * FINEST)
    }

    /// The covariance of a residual, the unit beyond its size.
    pub fn covariance(&self, seen: &Seen) -> Matrix3<f64> {
        let ones = seen.ones();
        let mut covariance = Matrix3::identity() - ones + ones * self.variance(seen.group, seen.given);
        if self.joint > 0.0 {
            covariance += seen.by_joints() * self.joint.powi(2);
        }
        if let Some((dof, deviation)) = self.dead {
            let slope = seen.along(dof) * deviation;
            covariance += slope * slope.transpose();
        }
        covariance
    }

    /// How a residual is weighed: by its noise, and by the probability that its touch is an inlier.
    pub fn weight(&self, seen: &Seen) -> Matrix3<f64> {
        self.covariance(seen)
            .try_inverse()
            .map_or(Matrix3::zeros(), |inverse| inverse * self.inlier_probability(seen))
    }

    /// Cauchy's weight of a residual in units of its group's deviation: from afar, where nothing is known of noise.
    pub fn weight_from_afar(&self, seen: &Seen) -> Matrix3<f64> {
        Matrix3::identity() / (self.groups[seen.group].powi(2) + seen.apart().powi(2))
    }

    /// `−log p(r)` of a residual if it is honest, and if it is false.
    fn costs(&self, seen: &Seen) -> [f64; 2] {
        let width = self.widths[seen.group];
        let of_false = match seen.residuals.size {
            3 => (4.0 / 3.0 * std::f64::consts::PI * width.powi(3)).ln(),
            _ => (2.0 * width).ln(),
        };
        let Some(factor) = self.covariance(seen).cholesky() else { return [f64::INFINITY, of_false] };
        let value = &seen.residuals.value;
        let squares = factor.solve(value).dot(value) + seen.size() * std::f64::consts::TAU.ln();
        [0.5 * squares + factor.l().diagonal().map(f64::ln).sum(), of_false]
    }

    /// The probability that a touch is an inlier.
    pub fn inlier_probability(&self, seen: &Seen) -> f64 {
        if self.false_share <= 0.0 {
            return 1.0;
        }
        let [honest, of_false] = self.costs(seen);
        let odds = (self.false_share / (1.0 - self.false_share)).ln() + honest - of_false;
        1.0 / (1.0 + odds.exp())
    }

    /// `−log p(r)`, whichever it is.
    pub fn cost(&self, seen: &Seen) -> f64 {
        let [honest, of_false] = self.costs(seen);
        if self.false_share <= 0.0 {
            return honest;
        }
        let [honest, of_false] = [honest - (1.0 - self.false_share).ln(), of_false - self.false_share.ln()];
        let low = honest.min(of_false);
        low - ((low - honest).exp() + (low - of_false).exp()).ln()
    }

    /// The noise of greatest restricted likelihood for residuals with what is known after them: `covariance` of the
    /// parameters takes account of what they took up. `with_joints` says whether encoders are noisy, too.
    pub fn estimated(&self, seen: &[Seen], covariance: &DMatrix<f64>, with_joints: bool) -> Noise {
        let mut noise = self.clone();
        let rows: Vec<(&Seen, Matrix3<f64>, f64)> = seen
            .iter()
            .map(|seen| (seen, seen.taken_up(covariance), self.inlier_probability(seen)))
            .collect();
        if with_joints && noise.joint == 0.0 {
            noise.joint = start_of_joints(seen);
        }
        for _ in 0..if with_joints { JOINT_STEPS } else { 1 } {
            let mut sums = vec![[0.0; 2]; noise.groups.len()];
            // Numbers that are left of each group's once the parameters took up theirs.
            let mut left = vec![0.0; noise.groups.len()];
            let mut joints = [0.0; 2];
            for (seen, taken_up, inlier) in &rows {
                let Some(inverse) = noise.covariance(seen).try_inverse() else { continue };
                let residual = seen.residuals.value;
                let pulled = inverse * (residual * residual.transpose() + taken_up) * inverse;
                let add = |sums: &mut [f64; 2], part: &Matrix3<f64>| {
                    sums[0] += inlier * (pulled * part).trace();
                    sums[1] += inlier * (inverse * part).trace();
                };
                let (group, ones) = (seen.group, seen.ones());
                add(&mut sums[group], &ones);
                let own = ((inverse - inverse * taken_up * inverse) * ones).trace();
                left[group] += inlier * noise.groups[group].powi(2) * own;
                if with_joints {
                    add(&mut joints, &seen.by_joints());
                }
            }
            let share = |[above, below]: [f64; 2]| if below > 0.0 { (above / below).sqrt() } else { 1.0 };
            let others = mean_of_many(&noise.groups, &left);
            for (deviation, [above, below]) in noise.groups.iter_mut().zip(sums) {
                let by_others = others.map_or([0.0; 2], |others| {
                    [AS_OTHERS * others.powi(2) / deviation.powi(4), AS_OTHERS / deviation.powi(2)]
                });
                let share = share([above + by_others[0], below + by_others[1]]);
                *deviation = (*deviation * if with_joints { share.sqrt() } else { share }).max(FINEST);
            }
            noise.joint *= share(joints).sqrt();
        }
        if noise.false_share > 0.0 {
            let of_false = rows.iter().map(|(.., inlier)| 1.0 - inlier).sum::<f64>();
            noise.false_share = (of_false / rows.len() as f64).clamp(1e-6, 0.6);
        }
        noise
    }

    /// Sets how far false touches may miss by what is missed now.
    pub fn widen(&mut self, seen: &[Seen]) {
        for (group, width) in self.widths.iter_mut().enumerate() {
            let own = seen.iter().filter(|seen| seen.group == group);
            *width = own.map(Seen::apart).fold(0.0, f64::max).max(WIDEST * self.groups[group]).max(FINEST);
        }
    }
}

/// Encoders' noise that would explain half of the misses.
fn start_of_joints(seen: &[Seen]) -> f64 {
    let squares: f64 = seen.iter().map(|seen| seen.apart().powi(2)).sum();
    let slopes: f64 = seen.iter().map(|seen| seen.by_joints().trace()).sum();
    if slopes > 0.0 { (0.5 * squares / slopes).sqrt() } else { 0.0 }
}

/// The geometric mean of deviations, each counted as often as numbers were left to tell it; none where hardly any were.
fn mean_of_many(deviations: &[f64], left: &[f64]) -> Option<f64> {
    let weights = left.iter().map(|left| left.max(0.0));
    let all: f64 = weights.clone().sum();
    let logarithms: f64 =
        deviations.iter().zip(weights).map(|(deviation, weight)| weight * deviation.ln()).sum();
    (all > 1.0).then(|| (logarithms / all).exp())
}

/// What a touch is between, for its noise: the two links, and whether points met.
pub type Kind = (usize, usize, bool);

/// Groups of touches by what they are between. Those of few touches are one, and where all these are few, too, they are taken to
/// be as noisy as the most frequent ones.
#[derive(Clone, Debug)]
pub struct Groups {
    of_many: BTreeMap<Kind, usize>,
    /// The group of all others.
    rest: usize,
}

impl Groups {
    /// Of so many touches' kinds.
    pub fn of(kinds: impl Iterator<Item = Kind>) -> Groups {
        let mut counts = BTreeMap::new();
        kinds.for_each(|kind| *counts.entry(kind).or_insert(0) += 1);
        let most = counts.iter().max_by_key(|(_, count)| **count).map(|(kind, _)| *kind);
        let few: usize = counts.values().filter(|count| **count < FEW).sum();
        let many = counts.into_iter().filter(|(_, count)| *count >= FEW);
        let of_many: BTreeMap<Kind, usize> =
            many.enumerate().map(|(group, (kind, _))| (kind, group)).collect();
        let most = most.filter(|_| few < FEW).and_then(|kind| of_many.get(&kind).copied());
        Groups { rest: most.unwrap_or(of_many.len()), of_many }
    }

    /// The group of a kind.
    pub fn group(&self, kind: &Kind) -> usize {
        self.of_many.get(kind).copied().unwrap_or(self.rest)
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.of_many.len().max(self.rest + 1)
    }
}
