//! Which way encoders count, where nobody knows: what small steps cannot find.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::estimate::{Estimator, Fit};
use super::robot::{Knowledge, Posed, Value};
use crate::creature::DofKind;

/// Touches that signs are looked for by.
const TOUCHES: usize = 250;
/// Random signs that a search begins from.
const STARTS: usize = 24;
/// Of what the search ends with, so many are fitted.
const FITTED: usize = 6;
/// Misses that are told apart while offsets are still wrong, and when they are right, metres.
const ROUGH: f64 = 0.05;
const FINE: f64 = 1e-3;
/// A sign is told if the other one is less likely by this, as a logarithm: one to a hundred and fifty.
const TOLD: f64 = 5.0;
const SEED: u64 = 20;

impl Estimator<'_> {
    /// Signs that are to be found.
    pub fn open_signs(&self) -> Vec<usize> {
        let signs = self.robot.dofs.iter().filter_map(|dof| Some(dof.quantities?.sign));
        signs.filter(|sign| self.robot.quantities[*sign].knowledge[0] != Knowledge::Known).collect()
    }

    /// Values with likely signs: by exchanging one at a time, from the nominal ones and from random ones, as long as touches
    /// miss less; then with all else fitted, the same again.
    pub fn with_likely_signs(&self, start: Vec<Value>) -> Vec<Value> {
        let signs = self.open_signs();
        let mut rng = ChaCha8Rng::seed_from_u64(SEED);
        let starts: Vec<Vec<Value>> = (0..STARTS)
            .map(|k| {
                let mut values = start.clone();
                for sign in signs.iter().filter(|_| k > 0) {
                    values[*sign] = Value::Number(if rng.random_bool(0.5) { 1.0 } else { -1.0 });
                }
                values
            })
            .collect();
        let descended = starts.into_par_iter().map(|values| {
            self.exchanged(values, &signs, |values| (self.scatter(values, ROUGH), values.to_vec()))
        });
        let mut found: Vec<(f64, Vec<Value>)> = descended.collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found.dedup_by(|a, b| a.1 == b.1);
        found.truncate(FITTED);
        let fitted = |values: &[Value]| {
            let fitted = self.approach(values.to_vec()).0;
            (self.scatter(&fitted, FINE), fitted)
        };
        let mut best: Option<(f64, Vec<Value>)> = None;
        for (_, values) in found {
            let found = fitted(&values);
            if best.as_ref().is_none_or(|best| found.0 < best.0) {
                best = Some(found);
            }
        }
        let Some((_, values)) = best else { return start };
        self.exchanged(values, &signs, fitted).1
    }

    /// Signs exchanged one at a time as long as a measure falls, which may change the values, too.
    fn exchanged(
        &self,
        start: Vec<Value>,
        signs: &[usize],
        measure: impl Fn(&[Value]) -> (f64, Vec<Value>),
    ) -> (f64, Vec<Value>) {
        let (mut least, mut values) = measure(&start);
        loop {
            let before = least;
            for sign in signs {
                let mut other = values.clone();
                other[*sign] = Value::Number(-values[*sign].number());
                let (size, other) = measure(&other);
                if size < least - 1e-9 * least.abs() {
                    (least, values) = (size, other);
                }
            }
            if least >= before {
                return (least, values);
            }
        }
    }

    /// How widely touches miss: the sum of the logarithms of their squares, which a few false ones do not rule.
    fn scatter(&self, values: &[Value], finest: f64) -> f64 {
        let step = self.touches().len().div_ceil(TOUCHES);
        let of_touch = |touch: &super::touch::Touch| {
            let posed = Posed::new(self.robot, values, &touch.posture);
            let pairs = touch.ends[0]
                .iter()
                .flat_map(|a| touch.ends[1].iter().map(move |b| [&a.feature, &b.feature]));
            let misses = pairs.map(|features| posed.miss(features, touch.distance).1.norm_squared());
            (misses.fold(f64::INFINITY, f64::min) + finest * finest).ln()
        };
        self.touches().iter().step_by(step.max(1)).map(of_touch).sum()
    }

    /// Signs that the touches do not tell: with the other one, all are explained about as well.
    pub fn untold_signs(&self, fit: &Fit) -> Vec<usize> {
        let untold = |sign: &usize| {
            let mut other = fit.values.clone();
            other[*sign] = Value::Number(-other[*sign].number());
            let (values, cost) = self.refitted(other, &fit.noise);
            values[*sign] != fit.values[*sign] && cost < fit.cost + TOLD
        };
        self.open_signs().into_iter().filter(untold).collect()
    }

    /// Values that mean the same in one way of saying it: gains are positive where a sign is to be found that can be exchanged
    /// instead, and offsets of hinges less than half a turn from what was nominal.
    pub(super) fn canonical(&self, mut values: Vec<Value>) -> Vec<Value> {
        let open = self.open_signs();
        for dof in &self.robot.dofs {
            let Some(q) = dof.quantities else { continue };
            if open.contains(&q.sign) && values[q.gain].number() < 0.0 {
                for quantity in [q.sign, q.gain] {
                    values[quantity] = Value::Number(-values[quantity].number());
                }
            }
            if dof.kind == DofKind::Hinge && self.robot.quantities[q.offset].is_open() {
                let before = self.robot.quantities[q.offset].nominal.number();
                let turns = ((values[q.offset].number() - before) / TAU).round();
                values[q.offset] = Value::Number(values[q.offset].number() - turns * TAU);
            }
        }
        values
    }
}
