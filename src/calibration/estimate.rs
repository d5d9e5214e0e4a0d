//! The estimator: the quantities that touches, and what was known before, make most likely.

use std::f64::consts::TAU;

use nalgebra::DMatrix;

use super::noise::{Groups, Noise, NoiseSource, Seen};
use super::problem::{Problem, Weighing, hold, information};
use super::robot::{Knowledge, Robot, Value};
use super::told::Told;
use super::touch::{End, Feature, Touch};
use super::unknowns::Unknowns;
use crate::creature::DofKind;
use crate::learning::least_squares::{Stopping, levenberg_marquardt};

/// Fits from afar, each with the deviation that the one before left.
const APPROACHES: usize = 12;
/// Rounds of what the touches say and how much noise they have, one after the other.
const ROUNDS: usize = 60;
/// Change of the cost that is none: odds of one to a thousand.
const SETTLED: f64 = 1e-3;
/// Linearizations of one fit.
const ITERATIONS: usize = 20;
/// That some touches are false is believed if all are so much likelier then, as a logarithm, …
const FALSE_GAIN: f64 = 10.0;
/// … and the rest have so much less noise: the tails of honest noise gain likelihood, too, but hardly any exactness.
const FALSE_SHARE_OF_NOISE: f64 = 0.7;
/// The median of the absolute value of normal noise, over its deviation.
const NORMAL_MEDIAN: f64 = 0.6745;

/// Of fewer starts that agree, nothing confirms that signs are right.
const CONFIRMED: usize = 2;

/// What noise there may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointNoise {
    /// Encoders are exact.
    None,
    /// Of this deviation, radians and metres.
    Given(f64),
    /// How much the touches show.
    Estimated,
}

/// Whether touches may be false.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FalseTouches {
    /// None is.
    None,
    /// If the touches show it.
    Maybe,
}

/// How to calibrate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimatorOptions {
    /// Noise of encoders.
    pub joint_noise: JointNoise,
    /// False touches.
    pub false_touches: FalseTouches,
}

impl Default for EstimatorOptions {
    fn default() -> EstimatorOptions {
        EstimatorOptions { joint_noise: JointNoise::None, false_touches: FalseTouches::Maybe }
    }
}

/// A robot and its touches, ready to be calibrated.
pub struct Estimator<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// What is to be found.
    pub unknowns: Unknowns,
    touches: &'a [Touch],
    sources: Vec<Vec<NoiseSource>>,
    groups: Groups<Kind>,
    options: EstimatorOptions,
    /// Places of parameters that stay as they are: the touches determine them only together with others.
    held: Vec<usize>,
}

/// How many starts came to the same signs, and of how many.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SignStarts {
    /// Those that came to what was found.
    pub agreeing: usize,
    /// All.
    pub all: usize,
}

impl SignStarts {
    /// Whether what was found is the best, as far as starts tell.
    pub fn agree(&self) -> bool {
        self.agreeing >= CONFIRMED
    }
}

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
    pub seen: Vec<SeenTouch>,
    /// How many starts came to the signs of encoders, where these were to be found.
    pub sign_starts: Option<SignStarts>,
    /// Signs of encoders that the touches do not tell.
    pub untold_signs: Vec<usize>,
}

impl Fit {
    /// The deviation of a residual, on average over the touches, metres.
    fn typical_deviation(&self) -> f64 {
        let variance = |seen: &Seen| {
            let covariance = self.noise.covariance(seen);
            (0..seen.residuals.size).map(|i| covariance[(i, i)]).sum::<f64>() / seen.residuals.size as f64
        };
        let logarithms = self.seen.iter().map(|(_, _, seen)| 0.5 * variance(seen).ln());
        (logarithms.sum::<f64>() / self.seen.len().max(1) as f64).exp()
    }
}

impl<'a> Estimator<'a> {
    /// An estimator of a robot's open quantities from touches.
    pub fn new(robot: &'a Robot, touches: &'a [Touch], options: EstimatorOptions) -> Estimator<'a> {
        let kinds: Vec<Kind> = touches.iter().flat_map(|touch| kinds_of(touch, robot)).collect();
        let groups = Groups::of(&kinds);
        let sources = sources_of(robot, &groups, touches);
        let unknowns = Unknowns::of(robot);
        let mut estimator =
            Estimator { robot, unknowns, touches, sources, groups, options, held: Vec::new() };
        // What the touches do not determine stays at the maker's value.
        let noise = estimator.noise(1.0, 0.0);
        let seen = estimator.seen(&robot.nominal(), &noise);
        estimator.held = Told::by(&estimator.information(&seen, &noise, true)).dependent;
        estimator
    }

    /// Other touches as they are seen at some values, with the noise of these.
    pub fn seen_of(&self, touches: &[Touch], values: &[Value], noise: &Noise) -> Vec<SeenTouch> {
        let sources = sources_of(self.robot, &self.groups, touches);
        let weighing = Weighing::ByNoise;
        Problem::new(self.robot, &self.unknowns, touches, &sources, noise.clone(), weighing).seen(values)
    }

    /// What there is at other values of the same touches, by all of a robot's parameters that `unknowns` has.
    pub(super) fn seen_by(&self, robot: &Robot, unknowns: &Unknowns, fit: &Fit) -> Vec<SeenTouch> {
        let (noise, weighing) = (fit.noise.clone(), Weighing::ByNoise);
        Problem::new(robot, unknowns, self.touches, &self.sources, noise, weighing).seen(&fit.values)
    }

    /// Noise of one deviation in all touches, metres, and of encoders, radians.
    pub fn noise(&self, deviation: f64, joint: f64) -> Noise {
        Noise { joint, ..Noise::alike(self.groups.count(), deviation) }
    }

    /// What noise there may be.
    pub fn options(&self) -> EstimatorOptions {
        self.options
    }

    /// The touches.
    pub fn touches(&self) -> &'a [Touch] {
        self.touches
    }

    fn problem(&self, noise: Noise, weighing: Weighing, held: &[usize]) -> Problem<'_> {
        let mut problem =
            Problem::new(self.robot, &self.unknowns, self.touches, &self.sources, noise, weighing);
        problem.held = held.to_vec();
        problem
    }

    /// What the touches look like at some values, in some noise.
    pub fn seen(&self, values: &[Value], noise: &Noise) -> Vec<SeenTouch> {
        self.problem(noise.clone(), Weighing::ByNoise, &[]).seen(values)
    }

    /// Deviations by the medians of what is left, group by group.
    fn typical(&self, seen: &[SeenTouch], before: &Noise) -> Noise {
        let mut noise = before.clone();
        for (group, deviation) in noise.groups.iter_mut().enumerate() {
            let mut sizes: Vec<f64> = seen
                .iter()
                .filter(|(_, _, seen)| seen.source.group == group)
                .map(|(_, _, seen)| seen.residuals.value.norm() / (seen.residuals.size as f64).sqrt())
                .collect();
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
        let mut noise = Noise::alike(self.groups.count(), 1.0);
        for _ in 0..APPROACHES {
            let seen = self.seen(&values, &noise);
            let next = self.typical(&seen, &noise);
            let settled = next.groups.iter().zip(&noise.groups).all(|(a, b)| (a / b - 1.0).abs() < 0.02);
            noise = next;
            if settled {
                break;
            }
            let mut problem = self.problem(noise.clone(), Weighing::FromAfar, &self.held);
            let stopping = Stopping { iterations: ITERATIONS, relative_cost: 1e-3, ..Stopping::default() };
            values = self.canonical(levenberg_marquardt(&mut problem, values, stopping).state);
        }
        (values, noise)
    }

    /// Fits from given values: by weights that bear with false touches first, and by all touches alike, for what few touches
    /// tell looks false as long as it is wrong. Where touches may be false, that some are is believed if they are much likelier
    /// then.
    pub fn fit_from(&self, start: Vec<Value>) -> Fit {
        let (values, noise) = self.approach(start.clone());
        let alike = self.settled(start, Noise::alike(self.groups.count(), 1.0), false);
        let apart = self.settled(values.clone(), noise.clone(), false);
        let all = if alike.cost < apart.cost { alike } else { apart };
        if self.options.false_touches == FalseTouches::None {
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
        let signs = self.robot.dofs.iter().filter_map(|dof| Some(dof.quantities?.sign));
        signs.filter(|sign| self.robot.quantities[*sign].knowledge[0] != Knowledge::Known).collect()
    }

    /// Values that mean the same in one way of saying it: gains are positive where a sign is to be found that can be exchanged
    /// instead, and offsets of hinges less than half a turn from what was nominal.
    fn canonical(&self, mut values: Vec<Value>) -> Vec<Value> {
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

    /// A fit again, with every touch taken for honest.
    pub(super) fn with_all_honest(&self, fit: &Fit) -> Fit {
        self.settled(fit.values.clone(), self.noise_at(&fit.values, fit.noise.joint), false)
    }

    /// As much noise as there seems to be at some values, and so much of encoders.
    pub(super) fn noise_at(&self, values: &[Value], joint: f64) -> Noise {
        let noise = self.noise(1.0, joint);
        self.typical(&self.seen(values, &noise), &noise)
    }

    /// Values and noise in turn, until neither changes.
    pub(super) fn settled(&self, mut values: Vec<Value>, mut noise: Noise, with_false: bool) -> Fit {
        let with_joints = self.options.joint_noise == JointNoise::Estimated;
        if let JointNoise::Given(deviation) = self.options.joint_noise {
            noise.joint = deviation;
        }
        if with_false {
            let seen = self.seen(&values, &noise);
            noise.false_share = 0.1;
            noise.widen(&only(&seen));
        }
        let mut held = self.held.clone();
        let nominal = self.robot.nominal();
        loop {
            let mut cost = f64::INFINITY;
            for _ in 0..ROUNDS {
                let mut problem = self.problem(noise.clone(), Weighing::ByNoise, &held);
                let stopping =
                    Stopping { iterations: ITERATIONS, relative_cost: 1e-9, ..Stopping::default() };
                values = self.canonical(levenberg_marquardt(&mut problem, values, stopping).state);
                let seen = self.seen(&values, &noise);
                let told = Told::by(&self.information(&seen, &noise, true));
                noise = noise.estimated(&only(&seen), &told.covariance, with_joints, with_false);
                let now = self.cost_of(&self.seen(&values, &noise), &values, &noise);
                let settled = (cost - now).abs() < SETTLED;
                cost = now;
                if settled || !now.is_finite() {
                    break;
                }
            }
            // What the touches determine less well than it was known before goes back to where it was.
            let vague = self.vague(&values, &noise, &held);
            if vague.is_empty() {
                break;
            }
            for place in &vague {
                let (q, component) = self.unknowns.parameters[*place];
                values[q] = values[q].with_component_of(&nominal[q], component);
            }
            held.extend(vague);
        }
        let seen = self.seen(&values, &noise);
        let mut told = Told::by(&self.information(&seen, &noise, true));
        let alone = held
            .into_iter()
            .filter(|place| told.is_told(*place))
            .map(|place| vec![place])
            .collect::<Vec<_>>();
        told.ties.extend(alone);
        let cost = self.cost_of(&seen, &values, &noise);
        Fit { values, noise, cost, told, seen, sign_starts: None, untold_signs: Vec::new() }
    }

    /// Parameters beside those that are held of which the touches say less than that they are near the maker's value.
    fn vague(&self, values: &[Value], noise: &Noise, held: &[usize]) -> Vec<usize> {
        let seen = self.seen(values, noise);
        let mut information = self.information(&seen, noise, true);
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
        let mut problem = self.problem(noise.clone(), Weighing::ByNoise, &self.held);
        let stopping = Stopping { iterations: ITERATIONS, relative_cost: 1e-6, ..Stopping::default() };
        let values = self.canonical(levenberg_marquardt(&mut problem, start, stopping).state);
        let cost = self.cost_of(&self.seen(&values, noise), &values, noise);
        (values, cost)
    }

    /// `−log` of how likely touches and values are together.
    fn cost_of(&self, seen: &[SeenTouch], values: &[Value], noise: &Noise) -> f64 {
        let touches: f64 = seen.iter().map(|(_, _, seen)| noise.cost(seen)).sum();
        touches + self.unknowns.prior_cost(self.robot, values)
    }

    /// The information about the unknowns in touches, symmetric; with what was known before.
    pub fn information(&self, seen: &[SeenTouch], noise: &Noise, with_prior: bool) -> DMatrix<f64> {
        let weighed = seen.iter().filter_map(|(_, _, seen)| {
            Some((seen, noise.covariance(seen).try_inverse()? * noise.honesty(seen)))
        });
        let mut information = information(self.unknowns.len(), weighed);
        if with_prior {
            self.unknowns.add_information(&mut information);
        }
        information
    }
}

/// What kind a touch is of, for its noise: the two links, and whether points met.
type Kind = (usize, usize, bool);

/// A touch, an index, which of its ends met, and what is left.
pub type SeenTouch = (usize, [usize; 2], Seen);

fn kind_of(touch: &Touch, [a, b]: [&End; 2], robot: &Robot) -> Kind {
    let (a_link, b_link) = (a.feature.link(robot), b.feature.link(robot));
    let meet = is_point(&a.feature) && is_point(&b.feature) && touch.distance == 0.0;
    (a_link.min(b_link), a_link.max(b_link), meet)
}

/// The kinds of all pairs of a touch's ends.
fn kinds_of(touch: &Touch, robot: &Robot) -> Vec<Kind> {
    pairs(touch).map(|ends| kind_of(touch, ends, robot)).collect()
}

fn pairs(touch: &Touch) -> impl Iterator<Item = [&End; 2]> {
    touch.ends[0].iter().flat_map(|a| touch.ends[1].iter().map(move |b| [a, b]))
}

fn sources_of(robot: &Robot, groups: &Groups<Kind>, touches: &[Touch]) -> Vec<Vec<NoiseSource>> {
    // Deviations that were given are what noise there is at the least: what more there is, the touches show.
    let of_pair = |touch: &Touch, ends: [&End; 2]| {
        let given = ends.iter().filter_map(|end| end.deviation).map(|deviation| deviation.powi(2)).sum();
        NoiseSource { group: groups.group(&kind_of(touch, ends, robot)), given }
    };
    touches.iter().map(|touch| pairs(touch).map(|ends| of_pair(touch, ends)).collect()).collect()
}

fn is_point(feature: &Feature) -> bool {
    matches!(feature, Feature::Point(..))
}

fn only(seen: &[SeenTouch]) -> Vec<Seen> {
    seen.iter().map(|(_, _, seen)| seen.clone()).collect()
}
