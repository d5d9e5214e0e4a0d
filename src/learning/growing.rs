//! From a random initial guess to the optimum: growing the tree limb pair by limb pair, or all of it at once.
//!
//! Solving all joints at once from random axes ends in a wrong minimum more often than not. A pair of
//! limbs with few joints between them is easy; with those joints known, another pair has few unknown
//! ones left. So: take the pair that brings the fewest unknown degrees of freedom and has touches enough,
//! solve the new part with relaxed axes from a few initial guesses, polish it on the sphere, accept it on its
//! residual; release everything known so far on all touches used; repeat.
//!
//! Receptors are coarser: a small part may find a wrong answer that fits its few touches. With them a start takes
//! the body whole: from the receptors' centres with relaxed axes, then by the surfaces with relaxed axes, for joints
//! that turn little are lost in the patches and only the surfaces feel them, then on the sphere. Joints whose touches
//! stay open then are left out.

use std::collections::BTreeSet;

use rand_chacha::ChaCha8Rng;

use crate::agent::Agent;
use crate::deadline::Deadline;
use crate::learning::annealing::{
    AnnealingLimits, HOPELESS, NARROWEST, POINT_FITS, WIDEST, anneal_to, gaps, meet, quantile, usual_miss,
};
use crate::learning::least_squares::{Stopping, levenberg_marquardt};
use crate::learning::observation::PointsMeet;
use crate::learning::open_gaps::OpenGaps;
use crate::learning::touch_set::{PairTouches, PreparedTouch, TouchProblem, TouchSet};
use crate::learning::{AxisModel, Parameters, Prior};
use crate::schema::BodySchema;
use crate::skin::Skin;

/// Root mean square of whitened misses, on touches not fitted to, that points without noise can have.
pub const EXACT: f64 = 1.0;
/// Initial guesses tried for one part of the body before the whole start is given up.
const GUESSES_PER_PART: usize = 12;
/// A body of more degrees of freedom than this is seldom solved whole: that is tried in the end alone, and a few times.
pub const WHOLE_DOF: usize = 60;

/// A part of the body is right when eight tenths of its surfaces' gaps are below this, metres …
const PART_GAP: f64 = 5e-3;
/// … or below this, where fresh touches show that it is noise.
const NOISY_GAP: f64 = 0.04;
/// Deviations of the gap, metres, down to which axes stay relaxed, by the number of the start. Joints that
/// turn little are caught in one wrong minimum or another, and which depends on this.
const RELAXED_GAPS: [f64; 4] = [3e-3, WIDEST, 1e-3, 3e-4];

const HOPELESS_MISFIT: f64 = 100.0;
/// Equations that a joint has to spare at the least.
const SPARE: usize = 3;
/// Of so many joints one may be given up.
const MOST_GIVEN_UP: usize = 4;
/// Touches that fix where a limb is on the joints about it.
const FIXED_BY: usize = 4;
/// Sizes of parts that starts in noise begin with, each of twice as many touches as the one before; the last is the whole body, as
/// every fourth start is.
const NOISY_SIZES: usize = 4;

/// What one start came to.
pub struct Start {
    /// The schema it reached.
    pub schema: BodySchema,
    /// Per joint, whether any touch with it entered the fit.
    pub known: Vec<bool>,
    /// Per limb, whether it is known where points in its own frame are on it: of all, unless limbs have frames
    /// of their own.
    pub placed: Vec<bool>,
    /// Whether every part was accepted.
    pub accepted: bool,
    /// Random initial guesses used.
    pub initial_guesses: usize,
}

impl Start {
    /// Whether all joints between two limbs are known, and both limbs placed.
    pub fn covers(&self, pair: &PairTouches) -> bool {
        pair.chain.joints().all(|joint| self.known[joint]) && pair.limbs.iter().all(|&limb| self.placed[limb])
    }
}

/// The ground on which starts are made.
pub struct Nursery<'a> {
    /// The creature.
    pub agent: &'a Agent,
    /// The touches to explain.
    pub touches: &'a TouchSet,
    /// What the touches say.
    pub evidence: Evidence<'a>,
    /// Where joints may be.
    pub prior: &'a Prior,
    /// Joints that keep the prior's mean.
    pub frozen: &'a [bool],
    /// The number of the start: starts differ in more than their random numbers.
    pub turn: usize,
    /// When a start ends with what it has.
    pub deadline: Deadline,
}

/// What a part's solution is judged by.
#[derive(Clone, Copy)]
pub enum Evidence<'a> {
    /// The two places of a touch are one point.
    Points {
        /// What the root mean square of the whitened residuals stays below.
        acceptance: f64,
        /// What noise they have besides, where they show it.
        noise: Option<PointNoise>,
        /// Whether the places are the centres of patches, which have a bias, and not points.
        patches: bool,
    },
    /// The surfaces meet.
    Surfaces(&'a Skin),
}

/// How much noise points show: it is the points' own or that of joints, and nothing tells which.
#[derive(Clone, Copy)]
pub struct PointNoise {
    /// How many times the deviation that points were given with it is, were it all their own.
    pub of_points: f64,
    /// How far each joint is misread, were it all by that, radians.
    pub of_joints: f64,
}

impl PointNoise {
    /// Touches whose points are as inexact under a schema as half of either makes them.
    fn weighed(&self, touches: &TouchSet, schema: &BodySchema) -> TouchSet {
        let mut weighed = touches.clone();
        for touch in weighed.pairs.iter_mut().flat_map(|pair| &mut pair.touches) {
            let rotation = touch.sides[0].frame(schema).rotation;
            let spread = touch.spread_by_angles(schema) * (0.5 * self.of_joints.powi(2));
            touch.ends.iter_mut().for_each(|end| end.covariance *= 1.0 + 0.5 * self.of_points.powi(2));
            touch.ends[0].covariance += rotation.transpose() * spread * rotation;
        }
        weighed
    }
}

impl Evidence<'_> {
    /// Whether the places of a touch are one point, and no patches.
    pub fn exact(&self) -> bool {
        matches!(self, Evidence::Points { patches: false, .. })
    }

    /// Whether there may be noise, of which two starts must agree how much it is.
    pub fn may_be_noisy(&self) -> bool {
        !matches!(self, Evidence::Points { noise: None, patches: false, .. })
    }

    /// Touches of points that a part needs before it is solved: some, and some more per unknown degree of freedom. In noise a wrong
    /// answer may explain few touches, and how many are few depends on the body: starts differ in that.
    fn enough(&self, dof: usize, start: usize) -> usize {
        match self {
            Evidence::Points { noise: Some(_), .. } => (8 + 2 * dof) << (start % NOISY_SIZES),
            _ => 8 + 2 * dof,
        }
    }
}

/// How well a part was solved: 1 is just acceptable.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
struct Misfit(f64);

impl Misfit {
    fn acceptable(self) -> bool {
        self.0 <= 1.0
    }
}

impl Nursery<'_> {
    /// One start from a random initial guess.
    pub fn start(&self, rng: &mut ChaCha8Rng) -> Start {
        let mut guess = self.prior.mean.clone();
        for joint in (0..self.frozen.len()).filter(|&joint| !self.frozen[joint]) {
            self.prior.randomize_joint(self.agent.creature(), &mut guess, joint, rng);
        }
        let touches = self.without(&self.starved());
        // Points are sharp enough to grow on, every fourth start is whole for safety; receptors are coarse.
        if self.evidence.exact() && self.turn % 4 < 3 {
            self.grown(&touches, guess, rng)
        } else {
            self.whole(&touches, guess, rng)
        }
    }

    /// All joints at once; of surfaces without those whose touches stay open.
    fn whole(&self, touches: &TouchSet, guess: BodySchema, rng: &mut ChaCha8Rng) -> Start {
        let mut start = self.nothing(guess);
        let part = unknown_joints(&touches.pairs, &start.known);
        if part.is_empty() || self.deadline.has_passed() {
            return start;
        }
        let (schema, mut misfit) = self.solve_once(touches, &start.schema, (&part, &[]), rng);
        start.schema = schema;
        start.initial_guesses += 1;
        part.iter().for_each(|&joint| start.known[joint] = true);
        if misfit.acceptable() {
            misfit = self.settle_known(touches, &mut start);
        }
        start.accepted = match self.evidence {
            Evidence::Points { .. } => misfit.acceptable(),
            // Whether what is open still may be is for all touches to say.
            Evidence::Surfaces(_) => misfit.0 <= NOISY_GAP / PART_GAP,
        };
        if matches!(self.evidence, Evidence::Surfaces(_)) && misfit.acceptable() {
            self.give_up(touches, &mut start);
        }
        start
    }

    /// Limb pair by limb pair.
    fn grown(&self, touches: &TouchSet, guess: BodySchema, rng: &mut ChaCha8Rng) -> Start {
        let mut start = self.nothing(guess);
        // Joints that could not be solved: no touch with them is used.
        let mut given_up = vec![false; start.known.len()];
        loop {
            let touches = touches.filter(|pair| pair.chain.joints().all(|joint| !given_up[joint]));
            let part = self.next_part(&touches, &start.known).filter(|_| !self.deadline.has_passed());
            let Some(part) = part else { return start };
            let rest = unknown_joints(&touches.pairs, &start.known).len() == part.len();
            let loose = self.loosened(&touches, &start.known, &part);
            let in_part = |joint: usize| part.contains(&joint) || loose.contains(&joint);
            let closed = closed(&touches, &start.known, in_part);
            // Parts get several initial guesses, for what is known is worth keeping.
            let guesses = &mut start.initial_guesses;
            let (schema, misfit) = self.solve_part(&closed, &start.schema, (&part, &loose), rng, guesses);
            if !misfit.acceptable() && !rest {
                part.iter().for_each(|&joint| given_up[joint] = true);
                continue;
            }
            start.schema = schema;
            part.iter().for_each(|&joint| start.known[joint] = true);
            start.accepted = misfit.acceptable() && self.settle_known(&touches, &mut start).acceptable();
            if !start.accepted {
                return start;
            }
        }
    }

    /// A start of which nothing is known but what was before; that is right, if it is anything.
    fn nothing(&self, schema: BodySchema) -> Start {
        let placed = vec![true; self.agent.creature().limbs().len()];
        let accepted = self.frozen.contains(&true);
        Start { schema, known: self.frozen.to_vec(), placed, accepted, initial_guesses: 0 }
    }

    /// Fits all that is known of a start to the touches that tell of it.
    fn settle_known(&self, touches: &TouchSet, start: &mut Start) -> Misfit {
        let used = touches.filter(|pair| start.covers(pair));
        let parameters = self.parameters(AxisModel::Unit, &|joint| start.known[joint]);
        let (schema, misfit) = self.settle(&used, &parameters, start.schema.clone(), 30);
        start.schema = schema;
        misfit
    }

    /// The noise of points: root mean square of the whitened residuals of the part that is solved first, in units
    /// of one standard deviation each; parameters take up some of it, which is counted in. No acceptance is asked for, so that a
    /// wrong minimum of all initial guesses makes it too large.
    pub fn point_noise(&self, rng: &mut ChaCha8Rng) -> Option<PointNoise> {
        let touches = self.without(&self.starved());
        let part = self.next_part(&touches, self.frozen)?;
        let closed = closed(&touches, self.frozen, |joint| part.contains(&joint));
        let schema = &self.prior.mean;
        let (schema, Misfit(misfit)) = self.solve_part(&closed, schema, (&part, &[]), rng, &mut 0);
        let (rows, unknowns) =
            (3 * closed.len(), part.iter().map(|&joint| self.unknowns(joint)).sum::<usize>());
        // Misfits are told in units of what is accepted.
        let rms = EXACT * misfit * (rows as f64 / rows.saturating_sub(unknowns).max(1) as f64).sqrt();
        Some(PointNoise { of_points: rms, of_joints: rms / lever(&closed, &schema) })
    }

    /// The joints with too few touches to solve them: each touch closes one gap, or brings a point together.
    pub fn starved(&self) -> Vec<bool> {
        let mut starved = vec![false; self.agent.creature().joints().len()];
        loop {
            let mut counts = vec![0; starved.len()];
            for pair in self.without(&starved).pairs {
                pair.chain.joints().for_each(|joint| counts[joint] += pair.touches.len());
            }
            let least = |joint: usize| match self.evidence {
                Evidence::Points { .. } => self.unknowns(joint) / 2 + SPARE,
                Evidence::Surfaces(_) => self.unknowns(joint) + SPARE,
            };
            let short = |joint: usize| !starved[joint] && !self.frozen[joint] && counts[joint] < least(joint);
            let Some(joint) = (0..starved.len()).filter(|&j| short(j)).min_by_key(|&j| counts[j]) else {
                return starved;
            };
            starved[joint] = true;
        }
    }

    /// The numbers that a joint adds: its position, and a direction per axis.
    fn unknowns(&self, joint: usize) -> usize {
        3 + 2 * self.agent.creature().joints()[joint].dofs.len()
    }

    /// The touches with none of some joints between their limbs.
    fn without(&self, joints: &[bool]) -> TouchSet {
        self.touches.filter(|pair| pair.chain.joints().all(|joint| !joints[joint]))
    }

    /// Leaves out, one by one, the joints whose touches stay open, and fits the others anew: these may be right.
    fn give_up(&self, touches: &TouchSet, start: &mut Start) {
        for _ in 0..start.known.len() / MOST_GIVEN_UP {
            let used = touches.filter(|pair| start.covers(pair));
            let open = OpenGaps::new(self.agent, &used, &start.schema);
            let Some(worst) = open.worst_joint.filter(|_| !open.tolerable()) else { return };
            start.known[worst] = false;
            self.settle_known(touches, start);
        }
    }

    fn parameters(&self, axis_model: AxisModel, free: &dyn Fn(usize) -> bool) -> Parameters {
        Parameters::new(self.agent.creature(), axis_model, |joint| free(joint) && !self.frozen[joint])
    }

    /// Closes the gaps; the schema and the width that eight tenths of them stay below, metres. Relaxed axes
    /// are put back on the sphere.
    fn close(&self, touches: &TouchSet, parameters: &Parameters, start: BodySchema) -> (BodySchema, f64) {
        let narrowest = match parameters.axis_model {
            AxisModel::Relaxed => RELAXED_GAPS[self.turn % 2 + 2 * (self.turn / 4 % 2)],
            AxisModel::Unit => NARROWEST,
        };
        let limits = AnnealingLimits { narrowest, deadline: self.deadline, ..AnnealingLimits::default() };
        let annealed = anneal_to(limits, self.agent, touches, parameters, self.prior, start);
        let mut schema = annealed.schema;
        schema.normalize_axes(self.agent.creature());
        (schema, annealed.p80_gap)
    }

    /// The unknown joints of the part to solve next, those of one pair of limbs: of the pairs with touches enough the one with
    /// fewest unknowns, of others the one that has most touches for its size; none when no touch brings a new joint.
    fn next_part(&self, touches: &TouchSet, known: &[bool]) -> Option<Vec<usize>> {
        let parts: Vec<Vec<usize>> = touches.pairs.iter().map(|pair| unknown_joints([pair], known)).collect();
        let dof = |part: &[usize]| -> usize {
            part.iter().map(|&j| self.agent.creature().joints()[j].dofs.len()).sum()
        };
        let touches_of = |part: &[usize]| -> usize {
            let closed = parts
                .iter()
                .zip(&touches.pairs)
                .filter(|(other, _)| !other.is_empty() && other.iter().all(|joint| part.contains(joint)));
            closed.map(|(_, pair)| pair.touches.len()).sum()
        };
        let candidates = || parts.iter().filter(|part| !part.is_empty());
        let rich = candidates()
            .filter(|part| touches_of(part) >= self.evidence.enough(dof(part), self.turn))
            .min_by_key(|part| (dof(part), std::cmp::Reverse(touches_of(part))));
        let richest = || candidates().max_by_key(|part| (1000 * touches_of(part)) / dof(part).max(1));
        rich.or_else(richest).cloned()
    }

    /// The known joints on limbs that a part is the first to touch. Nothing told so far where an untouched limb is
    /// along the axes of the joints on it: what was found there is gauge freedom, and is to be found now.
    fn loosened(&self, touches: &TouchSet, known: &[bool], part: &[usize]) -> Vec<usize> {
        let mut met = vec![[0; 2]; self.agent.creature().limbs().len()];
        for pair in &touches.pairs {
            let unknown = |joint: &usize| !known[*joint];
            if pair.chain.joints().filter(unknown).all(|joint| part.contains(&joint)) {
                let now = usize::from(pair.chain.joints().any(|joint| unknown(&joint)));
                pair.limbs.iter().for_each(|&limb| met[limb][now] += pair.touches.len());
            }
        }
        let first = |limb: usize| met[limb][0] < FIXED_BY && met[limb][1] > 0;
        let joints = self.agent.creature().joints().iter().enumerate();
        let loose = joints.filter(|(j, joint)| known[*j] && (first(j + 1) || first(joint.parent)));
        loose.map(|(j, _)| j).filter(|&j| !self.frozen[j]).collect()
    }

    /// Solves the joints of `part` by the touches that it closes from several initial guesses, and those that it loosens
    /// from where they are, all others held; the best schema and its residual.
    fn solve_part(
        &self,
        touches: &TouchSet,
        schema: &BodySchema,
        part: (&[usize], &[usize]),
        rng: &mut ChaCha8Rng,
        initial_guesses: &mut usize,
    ) -> (BodySchema, Misfit) {
        let mut best = self.solve_once(touches, schema, part, rng);
        *initial_guesses += 1;
        for _ in 1..GUESSES_PER_PART {
            if best.1.acceptable() || self.deadline.has_passed() {
                break;
            }
            let trial = self.solve_once(touches, schema, part, rng);
            *initial_guesses += 1;
            if trial.1 < best.1 {
                best = trial;
            }
        }
        best
    }

    /// The same from one initial guess.
    fn solve_once(
        &self,
        touches: &TouchSet,
        schema: &BodySchema,
        (part, loose): (&[usize], &[usize]),
        rng: &mut ChaCha8Rng,
    ) -> (BodySchema, Misfit) {
        let in_part = |joint: usize| part.contains(&joint) || loose.contains(&joint);
        let relaxed = self.parameters(AxisModel::Relaxed, &in_part);
        let unit = self.parameters(AxisModel::Unit, &in_part);
        let creature = self.agent.creature();
        let mut trial = schema.clone();
        part.iter().for_each(|&joint| self.prior.randomize_joint(creature, &mut trial, joint, rng));
        let meet = |parameters: &Parameters, schema: BodySchema, fits: usize| {
            meet(creature, touches, parameters, self.prior, schema, (fits, self.deadline))
        };
        trial = meet(&relaxed, trial, POINT_FITS);
        if self.evidence.exact() {
            (trial, _) = self.solve(touches, &relaxed, trial, 100);
        }
        trial.normalize_axes(creature);
        if let Evidence::Points { .. } = self.evidence {
            return self.settle(touches, &unit, trial, 60);
        }
        let trial = meet(&unit, trial, POINT_FITS / 2);
        let miss = usual_miss(touches, &trial);
        match miss > HOPELESS {
            true => (trial, Misfit(HOPELESS_MISFIT * miss)),
            false => self.close_both(touches, &unit, trial),
        }
    }

    /// Fits unit axes to points, then to surfaces where these are known.
    fn settle(
        &self,
        touches: &TouchSet,
        parameters: &Parameters,
        start: BodySchema,
        iterations: usize,
    ) -> (BodySchema, Misfit) {
        match self.evidence {
            Evidence::Points { acceptance, .. } => {
                let (schema, rms) = self.solve(touches, parameters, start, iterations);
                (schema, Misfit(rms / acceptance))
            }
            Evidence::Surfaces(skin) => {
                if quantile(&gaps(skin, touches, &start), 0.8) > PART_GAP {
                    return self.close_both(touches, parameters, start);
                }
                let (schema, p80_gap) = self.close(touches, parameters, start);
                (schema, Misfit(p80_gap / PART_GAP))
            }
        }
    }

    /// Closes the gaps with relaxed axes, then on the sphere.
    fn close_both(&self, touches: &TouchSet, unit: &Parameters, start: BodySchema) -> (BodySchema, Misfit) {
        let relaxed = self.parameters(AxisModel::Relaxed, &|joint| unit.positions[joint].is_some());
        let (schema, _) = self.close(touches, &relaxed, start);
        let (schema, p80_gap) = self.close(touches, unit, schema);
        (schema, Misfit(p80_gap / PART_GAP))
    }

    /// One least-squares solve by points; the schema and the root mean square of its whitened residuals.
    fn solve(
        &self,
        touches: &TouchSet,
        parameters: &Parameters,
        start: BodySchema,
        iterations: usize,
    ) -> (BodySchema, f64) {
        let count = (3 * touches.len()).max(1) as f64;
        let model = match (self.evidence, parameters.axis_model) {
            (Evidence::Points { .. }, AxisModel::Unit) => PointsMeet::Shaped,
            _ => PointsMeet::Anyhow,
        };
        let weighed;
        let touches = match self.evidence {
            Evidence::Points { noise: Some(noise), .. } => {
                weighed = noise.weighed(touches, &start);
                &weighed
            }
            _ => touches,
        };
        let mut problem = TouchProblem::new(self.agent.creature(), touches, parameters, model);
        // Exact points are sharp enough to do without.
        if !self.evidence.exact() {
            problem = problem.with_prior(self.prior);
        }
        // Far below what noise can do there is nothing left to gain here.
        let cost = 0.5 * count * 1e-6;
        let stopping = Stopping { iterations, relative_cost: 1e-4, cost, deadline: self.deadline };
        let solution = levenberg_marquardt(&mut problem, start, stopping);
        (solution.state, (2.0 * solution.cost / count).sqrt())
    }
}

/// The joints between the limbs of some pairs that are not known.
fn unknown_joints<'p>(pairs: impl IntoIterator<Item = &'p PairTouches>, known: &[bool]) -> Vec<usize> {
    let joints = pairs.into_iter().flat_map(|pair| pair.chain.joints());
    let unknown: BTreeSet<usize> = joints.filter(|&joint| !known[joint]).collect();
    unknown.into_iter().collect()
}

/// How fast the points of touches part as a joint is misread: root mean square of the whitened residuals, 1 a radian.
fn lever(touches: &TouchSet, schema: &BodySchema) -> f64 {
    let square = |touch: &PreparedTouch| {
        let variance = touch.ends.iter().map(|end| end.covariance.trace()).sum::<f64>();
        touch.spread_by_angles(schema).trace() / variance
    };
    (touches.touches().map(square).sum::<f64>() / touches.len().max(1) as f64).sqrt()
}

/// The touches of the pairs that a part closes: they need it, and nothing else that is unknown.
fn closed(touches: &TouchSet, known: &[bool], in_part: impl Fn(usize) -> bool) -> TouchSet {
    touches.filter(|pair| {
        let mut joints = pair.chain.joints();
        joints.clone().any(&in_part) && joints.all(|joint| known[joint] || in_part(joint))
    })
}
