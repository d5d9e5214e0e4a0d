//! The estimator: the quantities that touches, and what was known before, make most likely.

use std::f64::consts::TAU;

use super::noise::{Noise, Seen};
use super::problem::{Estimator, hold};
use super::robot::Value;
use super::told::Told;
use crate::creature::DofKind;

/// Fits from afar, each with the deviation that the one before left.
const APPROACHES: usize = 12;
/// Rounds of what the touches say and how much noise they have, one after the other.
const ROUNDS: usize = 60;
/// Change of the cost that is none: odds of one to a thousand.
const SETTLED: f64 = 1e-3;
/// That some touches are false is believed if all are so much likelier then, as a logarithm, …
const FALSE_GAIN: f64 = 10.0;
/// … and the rest have so much less noise: the tails of honest noise gain likelihood, too, but hardly any exactness.
const FALSE_SHARE_OF_NOISE: f64 = 0.7;
/// The median of the absolute value of normal noise, over its deviation.
const NORMAL_MEDIAN: f64 = 0.6745;

/// What was found.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The values of the robot's quantities.
    pub values: Vec<Value>,
    /// The noise of the touches.
    pub noise: Noise,
    /// `−log` of how likely the touches and the values are together.
    pub cost: f64,
    /// What is told.
    pub told: Told,
    /// The touches as they are seen at the values: which, who met whom, what is left.
    pub seen: Vec<Seen>,
    /// How many starts came to the signs of encoders, and of how many, where these were to be found.
    pub sign_starts: Option<[usize; 2]>,
    /// Signs of encoders that the touches do not tell.
    pub untold_signs: Vec<usize>,
}

impl Fit {
    /// The deviation of a residual, on average over the touches, metres.
    fn typical_deviation(&self) -> f64 {
        let variance = |seen: &Seen| {
            let covariance = self.noise.covariance(seen);
            (0..seen.residuals.size).map(|i| covariance[(i, i)]).sum::<f64>() / seen.size()
        };
        let logarithms = self.seen.iter().map(|seen| 0.5 * variance(seen).ln());
        (logarithms.sum::<f64>() / self.seen.len().max(1) as f64).exp()
    }
}

impl Estimator<'_> {
    /// As much noise as there seems to be at some values, by the medians of what is left, group by group; and so much of encoders.
    pub(super) fn noise_at(&self, values: &[Value], joint: f64) -> Noise {
        let mut noise = self.noise(1.0, joint);
        let seen = self.seen(values, &noise);
        for (group, deviation) in noise.groups.iter_mut().enumerate() {
            let own = seen.iter().filter(|seen| seen.group == group);
            let mut sizes: Vec<f64> = own.map(|seen| seen.apart() / seen.size().sqrt()).collect();
            if !sizes.is_empty() {
                sizes.sort_by(f64::total_cmp);
                *deviation = (sizes[sizes.len() / 2] / NORMAL_MEDIAN).max(1e-9);
            }
        }
        noise
    }

    /// Approaches from values that may be far off: fits by weights that bear with any miss.
    pub fn approach(&self, start: Vec<Value>) -> (Vec<Value>, Noise) {
        let mut values = start;
        let mut noise = self.noise(1.0, 0.0);
        for _ in 0..APPROACHES {
            let next = self.noise_at(&values, 0.0);
            let settled = next.groups.iter().zip(&noise.groups).all(|(a, b)| (a / b - 1.0).abs() < 0.02);
            noise = next;
            if settled {
                break;
            }
            values = self.descend(values, (&noise, Noise::weight_from_afar), &self.held, 1e-3);
        }
        (values, noise)
    }

    /// Fits from given values: by weights that bear with false touches first, and by all touches alike, for what few touches
    /// tell looks false as long as it is wrong. Where touches may be false, that some are is believed if they are much likelier
    /// then.
    pub fn fit_from(&self, start: Vec<Value>) -> Fit {
        let (values, noise) = self.approach(start.clone());
        let alike = self.settled(start, self.noise(1.0, 0.0), false);
        let apart = self.settled(values.clone(), noise.clone(), false);
        let all = if alike.cost < apart.cost { alike } else { apart };
        if !self.options.false_touches {
            return all;
        }
        let some = self.settled(values, noise, true);
        let sharper = some.typical_deviation() < FALSE_SHARE_OF_NOISE * all.typical_deviation();
        // Whoever takes enough of them for false explains the rest.
        let enough = some.redundancy().spare() >= 0.0;
        if sharper && enough && some.cost < all.cost - FALSE_GAIN { some } else { all }
    }

    /// Signs that are to be found.
    pub fn open_signs(&self) -> Vec<usize> {
        let signs = self.robot.encoders().map(|(_, own)| own.sign);
        signs.filter(|sign| self.robot.quantities[*sign].is_open()).collect()
    }

    /// Values that mean the same in one way of saying it: gains are positive where a sign is to be found that can be exchanged
    /// instead, and offsets of hinges less than half a turn from what was nominal.
    pub(super) fn canonical(&self, mut values: Vec<Value>) -> Vec<Value> {
        for (dof, q) in self.robot.encoders() {
            if self.robot.quantities[q.sign].is_open() && values[q.gain].number() < 0.0 {
                for quantity in [q.sign, q.gain] {
                    values[quantity] = Value::Number(-values[quantity].number());
                }
            }
            let offset = &self.robot.quantities[q.offset];
            if self.robot.dofs[dof].kind == DofKind::Hinge && offset.is_open() {
                let turns = ((values[q.offset].number() - offset.nominal.number()) / TAU).round();
                values[q.offset] = Value::Number(values[q.offset].number() - turns * TAU);
            }
        }
        values
    }

    /// Values and noise in turn, until neither changes.
    pub(super) fn settled(&self, mut values: Vec<Value>, mut noise: Noise, with_false: bool) -> Fit {
        let with_joints = self.options.joint_noise.is_none();
        noise.joint = self.options.joint_noise.unwrap_or(noise.joint);
        if with_false {
            let seen = self.seen(&values, &noise);
            noise.false_share = 0.1;
            noise.widen(&seen);
        }
        let mut held = self.held.clone();
        let nominal = self.robot.nominal();
        loop {
            let mut cost = f64::INFINITY;
            for _ in 0..ROUNDS {
                values = self.descend(values, (&noise, Noise::weight), &held, 1e-9);
                let seen = self.seen(&values, &noise);
                let told = Told::by(&self.information(&seen, &noise, true));
                noise = noise.estimated(&seen, &told.covariance, with_joints);
                let now = self.cost_of(&seen, &values, &noise);
                let settled = (cost - now).abs() < SETTLED;
                cost = now;
                if settled || !now.is_finite() {
                    break;
                }
            }
            // What the touches determine less well than it was known before goes back to where it was; its other parts are fitted again.
            let vague = self.vague(&values, &noise, &held);
            if vague.is_empty() {
                break;
            }
            for place in &vague {
                let (q, _) = self.unknowns.parameters[*place];
                values[q] = nominal[q];
            }
            held.extend(vague);
        }
        let seen = self.seen(&values, &noise);
        let mut told = Told::by(&self.information(&seen, &noise, true));
        held.retain(|place| told.is_told(*place));
        told.ties.extend(held.into_iter().map(|place| vec![place]));
        let cost = self.cost_of(&seen, &values, &noise);
        Fit { values, noise, cost, told, seen, sign_starts: None, untold_signs: Vec::new() }
    }

    /// Parameters beside those that are held of which the touches say less than that they are near the maker's value.
    fn vague(&self, values: &[Value], noise: &Noise, held: &[usize]) -> Vec<usize> {
        let mut information = self.information(&self.seen(values, noise), noise, true);
        hold(&mut information, held);
        let told = Told::by(&information);
        let beyond = |place: &usize| {
            let known = self.unknowns.deviation_before(*place).is_some() || held.contains(place);
            let open = self.unknowns.open_deviation(self.robot, *place);
            !known && (told.dependent.contains(place) || told.covariance[(*place, *place)] > open * open)
        };
        (0..self.unknowns.len()).filter(beyond).collect()
    }

    /// Values fitted from others in noise that stays as it is, and `−log` of how likely they and the touches are.
    pub(super) fn refitted(&self, start: Vec<Value>, noise: &Noise) -> (Vec<Value>, f64) {
        let values = self.descend(start, (noise, Noise::weight), &self.held, 1e-6);
        let cost = self.cost_of(&self.seen(&values, noise), &values, noise);
        (values, cost)
    }

    /// `−log` of how likely touches and values are together.
    fn cost_of(&self, seen: &[Seen], values: &[Value], noise: &Noise) -> f64 {
        let touches: f64 = seen.iter().map(|seen| noise.cost(seen)).sum();
        touches + self.unknowns.prior_cost(self.robot, values)
    }
}
