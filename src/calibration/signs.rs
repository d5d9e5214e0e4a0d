//! Which way encoders count, where nobody knows: what small steps cannot find.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::estimate::Fit;
use super::problem::{Estimator, pairs};
use super::robot::{DofQuantities, Knowledge, Posed, Value};
use super::touch::Touch;
use crate::creature::DofKind;

/// Touches that signs are looked for by.
const TOUCHES: usize = 250;
/// Random signs that a search begins from, in each of so many batches at the most.
const BATCH: usize = 8;
const BATCHES: usize = 8;
/// How far off encoders may be where a search begins, radians.
const ASIDE: f64 = 0.2;
/// The best is found when so many starts end there, as nearly as this.
const AGREEING: usize = 3;
const AGREE: f64 = 1.0;
/// Misses that are told apart while offsets are still wrong, and when they are right, metres.
const ROUGH: f64 = 0.05;
const FINE: f64 = 1e-3;
/// A sign is told if the other one is less likely by this, as a logarithm: one to a hundred and fifty.
const TOLD: f64 = 5.0;
const SEED: u64 = 20;

impl Estimator<'_> {
    /// Fits from where the search begins: the nominal values. The sign of an encoder is another than the nominal one only if the
    /// touches demand it.
    pub fn fit(&self) -> Fit {
        let fit = self.fit_from(self.robot.nominal());
        if self.open_signs().is_empty() {
            return fit;
        }
        if fit.explains(self) {
            return self.with_best_signs(fit);
        }
        let (start, starts) = self.with_likely_signs(self.robot.nominal());
        self.with_best_signs(Fit { sign_starts: Some(starts), ..self.fit_from(start) })
    }

    /// Values with likely signs, and how many starts came to them. Signs are exchanged, one or two at a time, from the nominal ones
    /// and from random ones, as long as touches miss less; the rest is fitted, gains last, for with gains that are free wrong signs
    /// find ways out; then signs are exchanged with all else fitted. Begun anew until the best is found several times.
    pub fn with_likely_signs(&self, start: Vec<Value>) -> (Vec<Value>, [usize; 2]) {
        let signs = self.open_signs();
        let mut rng = ChaCha8Rng::seed_from_u64(SEED);
        // Where the search is rough, gains are known, and joints do not give way.
        let mut even = self.robot.clone();
        for quantity in self.robot.encoders().flat_map(|(_, own)| [own.gain, own.compliance]) {
            even.quantities[quantity].knowledge = [Knowledge::Known; 3];
        }
        let even = Estimator::new(&even, self.touches, self.options);
        let fitted = |mut values: Vec<Value>, exchanged: &[usize]| {
            self.forget(&mut values, exchanged);
            let fitted = self.approach(even.approach(values).0).0;
            (self.scatter(&fitted, FINE), fitted)
        };
        let one: Vec<Vec<usize>> = signs.iter().map(|sign| vec![*sign]).collect();
        let two = signs.iter().enumerate().flat_map(|(k, a)| signs[..k].iter().map(move |b| vec![*b, *a]));
        let one_or_two: Vec<Vec<usize>> = one.iter().cloned().chain(two).collect();
        let mut found: Vec<(f64, Vec<Value>)> = Vec::new();
        let mut all = 0;
        let agreeing = |found: &[(f64, Vec<Value>)]| {
            let Some((least, best)) = found.first() else { return 0 };
            let agrees = |(size, values): &&(f64, Vec<Value>)| {
                *size < least + AGREE && signs.iter().all(|sign| values[*sign] == best[*sign])
            };
            found.iter().filter(agrees).count()
        };
        for batch in 0..BATCHES {
            let begun: Vec<Vec<Value>> =
                (0..BATCH).map(|k| self.begun(&start, &signs, batch + k == 0, &mut rng)).collect();
            let descended = begun.into_par_iter().map(|values| {
                let rough = |values: Vec<Value>, _: &[usize]| (self.scatter(&values, ROUGH), values);
                fitted(self.exchanged(values, &one_or_two, rough).1, &[])
            });
            found.extend(descended.collect::<Vec<_>>());
            found.sort_by(|a, b| a.0.total_cmp(&b.0));
            all += BATCH;
            if agreeing(&found) >= AGREEING {
                break;
            }
            // The best may be right but for a sign or two, of joints that few touches tell of.
            let (size, values) = self.exchanged(found[0].1.clone(), &one, fitted);
            if size < found[0].0 {
                found.insert(0, (size, values));
            }
        }
        let starts = [agreeing(&found), all];
        let Some((_, values)) = found.into_iter().next() else { return (start, starts) };
        (self.exchanged(values, &one, fitted).1, starts)
    }

    /// Where a search begins: at nominal values, or with random signs and encoders some way off.
    fn begun(&self, start: &[Value], signs: &[usize], nominal: bool, rng: &mut ChaCha8Rng) -> Vec<Value> {
        let mut values = start.to_vec();
        if nominal {
            return values;
        }
        for sign in signs {
            values[*sign] = Value::Number(if rng.random_bool(0.5) { 1.0 } else { -1.0 });
        }
        let is_hinge = |dof: usize| self.robot.dofs[dof].kind == DofKind::Hinge;
        let free =
            |(dof, q): &(usize, DofQuantities)| is_hinge(*dof) && self.robot.quantities[q.offset].is_open();
        for (_, q) in self.robot.encoders().filter(free) {
            let aside = rng.random_range(-ASIDE..ASIDE);
            values[q.offset] = Value::Number(values[q.offset].number() + aside);
        }
        values
    }

    /// Signs exchanged, some together, as long as a measure of values and what was exchanged falls; it may change the values, too.
    fn exchanged(
        &self,
        start: Vec<Value>,
        together: &[Vec<usize>],
        measure: impl Fn(Vec<Value>, &[usize]) -> (f64, Vec<Value>),
    ) -> (f64, Vec<Value>) {
        let (mut least, mut values) = measure(start, &[]);
        loop {
            let before = least;
            for signs in together {
                let (size, other) = measure(other_signs(&values, signs), signs);
                if size < least - 1e-9 * least.abs() {
                    (least, values) = (size, other);
                }
            }
            if least >= before {
                return (least, values);
            }
        }
    }

    /// Takes what wrong signs may have been made up for with back to what it nominally is: all open gains, and the offsets of the
    /// encoders whose signs were exchanged. It would keep the right ones out.
    fn forget(&self, values: &mut [Value], exchanged: &[usize]) {
        for (_, q) in self.robot.encoders() {
            let offset = exchanged.contains(&q.sign).then_some(q.offset);
            for quantity in offset.into_iter().chain([q.gain]) {
                values[quantity] = self.robot.quantities[quantity].nominal;
            }
        }
    }

    /// How widely touches miss: the sum of the logarithms of their squares, which a few false ones do not rule.
    fn scatter(&self, values: &[Value], finest: f64) -> f64 {
        let step = self.touches.len().div_ceil(TOUCHES);
        let of_touch = |touch: &Touch| {
            let posed = Posed::new(self.robot, values, &touch.posture);
            let miss = |ends| posed.miss(touch.features(ends), touch.distance).1.norm_squared();
            let misses = pairs(touch).map(miss);
            (misses.fold(f64::INFINITY, f64::min) + finest * finest).ln()
        };
        self.touches.iter().step_by(step.max(1)).map(of_touch).sum()
    }

    /// A fit whose signs are none that another of them explains better: each is exchanged once more, with all the rest fitted
    /// anew, and a better fit is taken. Signs that the touches do not tell are those with which all are explained about as well.
    pub(super) fn with_best_signs(&self, mut fit: Fit) -> Fit {
        let signs = self.open_signs();
        loop {
            let exchanged = signs.par_iter().map(|sign| {
                let other = other_signs(&fit.values, &[*sign]);
                let mut afar = other.clone();
                self.forget(&mut afar, &[*sign]);
                // The same touches are often explained by the maker's signs and offsets, too.
                let mut as_made = other.clone();
                self.forget(&mut as_made, &signs);
                let starts = [other, self.approach(afar).0, self.approach(as_made).0];
                let fits = starts.map(|start| self.refitted(start, &fit.noise));
                let differs = |values: &[Value]| values[*sign] != fit.values[*sign];
                let best = fits.into_iter().filter(|(values, _)| differs(values));
                best.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(values, cost)| (*sign, values, cost))
            });
            let exchanged: Vec<(usize, Vec<Value>, f64)> = exchanged.flatten().collect();
            let nominal = self.robot.nominal();
            let least = |(sign, values, cost): &(usize, Vec<Value>, f64)| {
                // The touches demand a sign that is not the maker's.
                let back = values[*sign] == nominal[*sign] && fit.values[*sign] != nominal[*sign];
                cost - if back { AGREE } else { -TOLD }
            };
            let best = exchanged.iter().min_by(|a, b| least(a).total_cmp(&least(b)));
            if let Some(best @ (sign, values, _)) = best
                && least(best) < fit.cost
            {
                let better = self.fit_from(values.clone());
                if least(&(*sign, better.values.clone(), better.cost)) < fit.cost {
                    fit = Fit { sign_starts: fit.sign_starts, ..better };
                    continue;
                }
            }
            let untold = exchanged.iter().filter(|(_, _, cost)| *cost < fit.cost + TOLD);
            fit.untold_signs = untold.map(|(sign, ..)| *sign).collect();
            return fit;
        }
    }
}

/// Values with some signs exchanged.
fn other_signs(values: &[Value], signs: &[usize]) -> Vec<Value> {
    let mut other = values.to_vec();
    signs.iter().for_each(|sign| other[*sign] = Value::Number(-values[*sign].number()));
    other
}
