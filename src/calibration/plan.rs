//! What to measure next: of touches that could be made, those that tell most.
//!
//! A touch with whitened slopes `A` adds `log det(I + A Σ Aᵀ)` to the logarithm of how small the volume is that the unknowns
//! may lie in, where `Σ` is their covariance so far (D-optimality; Fedorov, "Theory of Optimal Experiments", 1972). The touches are
//! chosen one after the other, each the one that adds most, and then each is exchanged for a better one as long as there is one.

use nalgebra::{DMatrix, Matrix3};
use rayon::prelude::*;

use super::estimate::Estimator;
use super::noise::{Noise, Seen, taken_up};
use super::robot::{Unit, Value};

/// How far what is free may be off: enough to say where to begin.
const OPEN_POSITION: f64 = 0.1;
const OPEN_ANGLE: f64 = 0.5;
const OPEN_RATIO: f64 = 0.2;
/// Rounds of exchanges at the most.
const ROUNDS: usize = 5;
/// What an exchange must gain.
const WORTHWHILE: f64 = 1e-3;

/// A touch that is worth making.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// Which of the candidates.
    pub candidate: usize,
    /// What it adds to those before it, in nats.
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
}

/// Chooses `count` of the estimator's touches, as they would be at `values` in some noise.
pub fn plan(estimator: &Estimator, values: &[Value], noise: &Noise, count: usize) -> Plan {
    let seen = estimator.seen(values, noise);
    // Of several contacts of a touch the first speaks for it.
    let mut candidates: Vec<(usize, Seen)> = seen.into_iter().map(|(touch, _, seen)| (touch, seen)).collect();
    candidates.dedup_by_key(|(touch, _)| *touch);
    let weights: Vec<Matrix3<f64>> = candidates
        .iter()
        .map(|(_, seen)| noise.covariance(seen).try_inverse().unwrap_or_else(Matrix3::zeros))
        .collect();
    let gain = |covariance: &DMatrix<f64>, k: usize| {
        let spread = Matrix3::identity() + weights[k] * taken_up(&candidates[k].1.residuals, covariance);
        spread.determinant().max(f64::MIN_POSITIVE).ln()
    };
    let mut chosen: Vec<usize> = Vec::new();
    let mut covariance = before(estimator);
    let best = |covariance: &DMatrix<f64>, chosen: &[usize]| -> Option<(usize, f64)> {
        let gains: Vec<f64> = (0..candidates.len())
            .into_par_iter()
            .map(|k| if chosen.contains(&k) { f64::NEG_INFINITY } else { gain(covariance, k) })
            .collect();
        (0..gains.len()).max_by(|a, b| gains[*a].total_cmp(&gains[*b])).map(|k| (k, gains[k]))
    };
    while chosen.len() < count.min(candidates.len()) {
        let Some((k, _)) = best(&covariance, &chosen) else { break };
        update(&mut covariance, &candidates[k].1, &weights[k], 1.0);
        chosen.push(k);
    }
    for _ in 0..ROUNDS {
        let mut exchanged = false;
        for place in 0..chosen.len() {
            let own = chosen[place];
            let mut without = covariance.clone();
            update(&mut without, &candidates[own].1, &weights[own], -1.0);
            let Some((other, more)) = best(&without, &chosen) else { continue };
            if more > gain(&without, own) + WORTHWHILE {
                update(&mut without, &candidates[other].1, &weights[other], 1.0);
                covariance = without;
                chosen[place] = other;
                exchanged = true;
            }
        }
        if !exchanged {
            break;
        }
    }
    told_in_order(estimator, &candidates, &weights, &chosen, gain)
}

/// The touches from the one that tells most on, with what each adds.
fn told_in_order(
    estimator: &Estimator,
    candidates: &[(usize, Seen)],
    weights: &[Matrix3<f64>],
    chosen: &[usize],
    gain: impl Fn(&DMatrix<f64>, usize) -> f64,
) -> Plan {
    let mut left = chosen.to_vec();
    let mut covariance = before(estimator);
    let mut touches = Vec::new();
    while !left.is_empty() {
        let gains: Vec<f64> = left.iter().map(|k| gain(&covariance, *k)).collect();
        let most = (0..left.len()).max_by(|a, b| gains[*a].total_cmp(&gains[*b])).unwrap_or(0);
        let k = left.swap_remove(most);
        let deviations = covariance.diagonal();
        update(&mut covariance, &candidates[k].1, &weights[k], 1.0);
        let shrinks = |i: usize| (deviations[i] / covariance[(i, i)].max(f64::MIN_POSITIVE)).sqrt();
        let tells = (0..deviations.len()).max_by(|a, b| shrinks(*a).total_cmp(&shrinks(*b))).unwrap_or(0);
        touches.push(Planned {
            candidate: candidates[k].0,
            gain: gains[most],
            tells: (tells, shrinks(tells)),
        });
    }
    Plan { touches, covariance }
}

/// What is known before: what is nearly known, and of what is free that it is not beyond all measure.
fn before(estimator: &Estimator) -> DMatrix<f64> {
    let unknowns = &estimator.unknowns;
    let n = unknowns.len();
    let open = |place: usize| {
        let (quantity, _) = unknowns.parameters[place];
        unknowns.deviation_before(place).unwrap_or(match estimator.robot.quantities[quantity].unit {
            Unit::Metre => OPEN_POSITION,
            Unit::Radian => OPEN_ANGLE,
            Unit::One | Unit::Compliance => OPEN_RATIO,
        })
    };
    DMatrix::from_fn(n, n, |i, j| if i == j { open(i).powi(2) } else { 0.0 })
}

/// The covariance after a touch more, or with one less where `sign` is −1: `Σ ∓ Σ Jᵀ (W⁻¹ ± J Σ Jᵀ)⁻¹ J Σ`.
fn update(covariance: &mut DMatrix<f64>, seen: &Seen, weight: &Matrix3<f64>, sign: f64) {
    let n = covariance.nrows();
    // Σ Jᵀ, n × 3.
    let mut across: DMatrix<f64> = DMatrix::zeros(n, 3);
    for (i, slope) in &seen.residuals.slopes {
        for row in 0..n {
            let c = covariance[(row, *i)];
            (0..3).for_each(|k| across[(row, k)] += c * slope[k]);
        }
    }
    let Some(noise) = weight.try_inverse() else { return };
    let spread = noise * sign + taken_up(&seen.residuals, covariance);
    let Some(inverse) = spread.try_inverse() else { return };
    for row in 0..n {
        for column in 0..=row {
            let mut less = 0.0;
            for k in 0..3 {
                for l in 0..3 {
                    less += across[(row, k)] * inverse[(k, l)] * across[(column, l)];
                }
            }
            covariance[(row, column)] -= less;
            covariance[(column, row)] = covariance[(row, column)];
        }
    }
}
