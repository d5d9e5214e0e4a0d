//! The second-order learner: all touches at once, from any initial guess to the optimum.
//!
//! It starts from random initial guesses, growing the tree limb pair by limb pair or solving it whole (see
//! [`growing`](super::growing)), and accepts a start only on touches that it was not fitted to: a low
//! residual on the touches used is no proof. What it accepts is fitted once more to all touches.
//!
//! Long: its parts are taken apart together with those of the other learners, when learning goes in stages.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, Matrix3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::agent::Agent;
use crate::deadline::Deadline;
use crate::geometry::Frame;
use crate::learning::annealing::{NARROWEST, anneal, gaps, quantile, typical_gap};
use crate::learning::curvature::distances_by_curvature;
use crate::learning::growing::{EXACT, Evidence, Nursery, Start, WHOLE_DOF};
use crate::learning::growing_limbs::LimbNursery;
use crate::learning::least_squares::{LeastSquares, Stopping, levenberg_marquardt};
use crate::learning::noise::{Noise, NoisyGap, NoisyProblem, gaps_of, information, likeness, widening};
use crate::learning::observability::Observability;
use crate::learning::observation::{Input, Observation, PointsMeet, SkinKnowledge};
use crate::learning::open_gaps::{GapTally, MOST_FALSE, OpenGaps, witnesses};
use crate::learning::prediction::{GapRow, covariance, information_inverse};
use crate::learning::surface_gap::{CERTAIN_NOISE, MEAN_WEIGHT, SHARPEST, SurfaceGap, TAIL, gap_scale};
use crate::learning::touch_set::{LimbTouch, PairTouches, PreparedTouch, TouchProblem, TouchSet};
use crate::learning::twins::without_twins;
use crate::learning::{
    Account, AxisModel, Basis, Learned, Learner, LengthUnit, LimbFrames, Parameters, Prior, PriorKnowledge,
    Verdict, Witnesses,
};
use crate::schema::{BodySchema, unfelt_shifts};
use crate::senses::Touch;
use crate::skin::{Receptor, Skin};

/// Every how many touches one is kept back to judge a start.
const KEPT_BACK: usize = 5;
/// Fits in which the touches are weighed by how noisy joints spread them, the first with none weighed.
const WEIGHINGS: usize = 3;
/// Starts tried before the learner says that it failed.
const STARTS: usize = 24;
/// Starts tried with a body too large to be solved whole.
const LARGE_STARTS: usize = 2;
/// Starts after which one is taken though it knows fewer joints than have touches of their own.
const INCOMPLETE_STARTS: usize = 2;
/// The same where limbs have frames of their own, …
const INCOMPLETE_LIMB_STARTS: usize = 6;
/// … and after which none is made more where all know nothing: chains are too long to begin with any.
const BLIND_LIMB_STARTS: usize = 3;
/// Where gaps show noise, only trying can tell whether less of it was to be had: two starts must agree on the
/// least noise to this share of it.
const AGREEMENT: f64 = 0.03;
/// The same for places that are taken for one point: there is but one least sum of squares.
const POINT_AGREEMENT: f64 = 1e-3;
/// So many starts that agree on what the touches do not bear out are not bettered by more, …
const HOPELESS_STARTS: usize = 3;
/// … but tangles are many, and alike in how wide their gaps are, metres.
const TANGLED: f64 = 5e-3;
/// Touches of one limb pair that a start uses at most; the last fit uses all.
const TOUCHES_PER_PAIR: usize = 150;
/// How far apart two points that are one may be where nothing else is given, per coordinate, metres.
const CONTACT_DEVIATION: f64 = 1e-4;
/// The share of all touches that limbs which could be placed have at the least where there is noise: of the wrong answers
/// seen none had more than 0.14, of the right ones of 512 touches most had more than 0.3.
const FEWEST_TELL: f64 = 0.2;
/// Whitened residuals above which points are taken to have noise, and a second start must agree.
const VISIBLE_NOISE: f64 = 0.1;
/// How many times wider than in the part that is solved first the misses may be elsewhere: a part is solved on
/// others that are held where noise left them, …
const NOISE_MARGIN: f64 = 3.0;
/// … and how many times that where no start is accepted; joints that are misread add up in long chains.
const WIDER: [f64; 2] = [1.0, 3.0];
/// The most noise of gaps and points that is believed, metres: in more, schemas that are wrong look like noise.
const MOST_NOISE: f64 = 0.02;
/// Random stream of the look at how much noise points have; starts count from 0 and never get here.
const NOISE_STREAM: u64 = u64::MAX - 4;
/// How many times wider than the touches that a schema was fitted to it may leave fresh ones, beyond what it
/// takes up by its parameters.
const FRESH_NOISE: f64 = 1.5;
/// Starts tried with points that have noise before more of it is allowed for.
const NOISY_STARTS: usize = 8;
/// How far a curved limb is taken to bulge out of a flat patch, metres.
const NORMAL_DEVIATION: f64 = 6e-3;
/// The share that noise may be of how far touches lie about their middle on the limbs: of more, a body whose limbs are all in
/// one place would explain them as well.
const MOST_OF_EXTENT: f64 = 0.5;
/// So many times as far apart as in their own postures are points that touched in others, and surfaces: of these right answers
/// leave five times as much where angles are read to 2 degrees, twelve times to one, and wrong ones four times at the most.
const POINTS_APART: f64 = 2.0;
const GAPS_APART: f64 = 4.5;
/// Limbs that meet within this in any posture are a point, metres.
const POINT: f64 = 1e-6;
/// Touches of a limb that lie less about their middle than this share of how far they are from its joint are at one point.
const ONE_POINT: f64 = 0.05;
/// The same as [`EXACT`] for receptor centres: they have a bias, the bulge of the limb.
const BIASED: f64 = 1.5;
/// Eight tenths of the gaps of touches not fitted to stay within this many of the deviations that the
/// schema predicts for them: 1.28 of a normal distribution, and a margin for few touches.
const FRESH_GAP: f64 = 1.9;
/// A gap is open when it is wider than this many predicted deviations.
const OPEN: f64 = 5.0;
/// Share of open gaps that no joint exceeds on touches not fitted to: false touches, and chance in few.
const FRESH_OPEN: f64 = 0.3;
/// Likeness of gaps of neighbouring touches from which on it is the schema that is wrong: right ones leave less than 0.17,
/// wrong ones that look like noise more than 0.44.
const ALIKE: f64 = 0.3;
/// How far apart receptors of a limb are whose touches bear one another out, metres: two patches …
const SAME_PLACE: f64 = 0.05;
/// … and how many others it takes: of 2,000 touches of Max half of the honest ones have them, and one in 16 of false ones.
const WITNESSES: usize = 4;
/// Touches of a limb from which on others of it are foretold.
const FORETOLD_BY: usize = 4;
/// Points are exact where this share of their touches misses by less than so many deviations.
const USUAL: f64 = 0.8;
const EXACTLY: f64 = 1e-4;
/// Touches that are left for every unknown number, where others need not be looked at.
const ENOUGH: usize = 3;
/// Touches with a joint below which their share of open gaps says little of it.
const FEW: usize = 4;
/// Leverage of a touch from which on no other one checks it.
const UNCHECKED: f64 = 0.98;
/// A touch tests a schema that predicts its gap to this, metres.
const TELLING: f64 = 0.01;
/// Width of a gap that nothing asks to predict better, metres.
const CLOSE_ENOUGH: f64 = 2e-5;

/// A bias of all gaps is taken up by parameters and leaves a fiftieth of itself; what exact gaps tell at second order is told
/// by no less than so many times what is left.
const TAKEN_UP: f64 = 1e3;
/// … and by no less than this, metres.
const SHARPLY: f64 = 1e-8;
/// Fits to exact touches, each as sharp as the gaps that the one before left; and no sharper than rounding, metres.
const SHARPENINGS: usize = 3;
const ROUNDING: f64 = 1e-11;
/// Linearizations of the last fit.
const LAST_ITERATIONS: usize = 30;
/// Least relative fall of its cost that counts as progress.
const LAST_RELATIVE_COST: f64 = 1e-9;

/// The learner `lm`.
pub struct SecondOrder {
    agent: Agent,
    input: Input,
    knowledge: SkinKnowledge,
    frames: LimbFrames,
    seed: u64,
    known: PriorKnowledge,
    deadline: Deadline,
    touches: Vec<Touch>,
}

impl SecondOrder {
    /// A learner whose initial guesses are drawn from `seed`.
    pub fn new(agent: &Agent, input: Input, seed: u64) -> SecondOrder {
        let known = PriorKnowledge::nothing(agent);
        let knowledge = SkinKnowledge::Surface;
        let frames = LimbFrames::Joint;
        SecondOrder {
            agent: agent.clone(),
            input,
            knowledge,
            frames,
            seed,
            known,
            deadline: Deadline::NEVER,
            touches: Vec::new(),
        }
    }

    /// Sets what the agent knows of its skin, its surfaces by default. Contact points need no skin.
    pub fn with_skin(mut self, knowledge: SkinKnowledge) -> SecondOrder {
        self.knowledge = knowledge;
        self
    }

    /// Sets which frames points on limbs are given in, those of their joints by default. Limbs with frames of
    /// their own need exact points; nothing that is known of joints is minded with them.
    pub fn with_frames(mut self, frames: LimbFrames) -> SecondOrder {
        self.frames = frames;
        self
    }

    /// Sets what is known of the joints already.
    pub fn with_known(mut self, known: PriorKnowledge) -> SecondOrder {
        self.known = known;
        self
    }

    pub(crate) fn basis(&self) -> Basis {
        Basis { input: self.input, skin: self.knowledge, frames: self.frames }
    }

    fn evidence(&self) -> Evidence<'_> {
        match (self.input, self.knowledge) {
            (Input::Contact, _) => Evidence::Points { acceptance: EXACT, patches: false },
            (Input::Receptor, SkinKnowledge::Centres) => {
                Evidence::Points { acceptance: BIASED, patches: true }
            }
            (Input::Receptor, SkinKnowledge::Surface) => Evidence::Surfaces(self.agent.skin()),
        }
    }

    /// The touches so far.
    pub fn touches(&self) -> &[Touch] {
        &self.touches
    }

    /// Forgets all touches but the last ones.
    pub fn forget_before(&mut self, last: usize) {
        self.touches.drain(..self.touches.len().saturating_sub(last));
    }

    /// All touches between their limbs, ready for a solver.
    pub fn prepared(&self) -> impl Iterator<Item = ([usize; 2], PreparedTouch)> {
        self.touches.iter().map(|touch| self.prepare_one(touch))
    }

    /// The limbs, the earlier one first, and a touch ready for a solver.
    pub fn prepare_one(&self, touch: &Touch) -> ([usize; 2], PreparedTouch) {
        self.limb_touch(touch).prepare(self.agent.creature())
    }

    fn prepare<'t>(&self, touches: impl Iterator<Item = &'t Touch>) -> TouchSet {
        TouchSet::new(self.agent.creature(), touches.map(|touch| self.limb_touch(touch)))
    }

    fn limb_touch<'t>(&self, touch: &'t Touch) -> LimbTouch<'t> {
        let ends = touch.ends.map(|end| Observation {
            receptor: end.receptor,
            position: self.input.position(self.agent.skin(), &end),
            covariance: match self.input {
                Input::Contact => Matrix3::identity() * contact_variance(end.deviation),
                Input::Receptor => self.agent.skin().receptors[end.receptor].covariance(NORMAL_DEVIATION),
            },
        });
        let limbs = touch.ends.map(|end| self.agent.skin().receptors[end.receptor].limb);
        LimbTouch { limbs, posture: &touch.posture, ends }
    }

    /// The touches that starts are fitted to: not those kept back, and not all of the most frequent pairs.
    fn fitted(&self) -> Vec<&Touch> {
        let mut per_pair = BTreeMap::new();
        let few_of_a_pair = |touch: &&Touch| {
            let limbs = touch.ends.map(|end| self.agent.skin().receptors[end.receptor].limb);
            let count = per_pair.entry(limbs).or_insert(0);
            *count += 1;
            *count <= TOUCHES_PER_PAIR
        };
        let fitted = self.touches.iter().enumerate().filter(|(i, _)| !kept_back(*i));
        fitted.map(|(_, touch)| touch).filter(few_of_a_pair).collect()
    }

    /// Those of some touches that others bear out, by what they felt alone: false ones are scattered over the skin, honest
    /// ones come again where limbs can meet. All, where so few come again that this tells nothing.
    fn borne_out<'t>(&self, touches: &[&'t Touch]) -> Vec<&'t Touch> {
        let felt = |touch: &Touch| touch.ends.map(|end| &self.agent.skin().receptors[end.receptor]);
        let near = |a: &Receptor, b: &Receptor| {
            a.limb == b.limb && (a.position - b.position).norm_squared() < SAME_PLACE * SAME_PLACE
        };
        let felt: Vec<[&Receptor; 2]> = touches.iter().map(|touch| felt(touch)).collect();
        let borne_out = |[a, b]: &[&Receptor; 2]| {
            let alike = felt.iter().filter(|[c, d]| near(a, c) && near(b, d));
            // It is like itself.
            alike.take(WITNESSES + 1).count() > WITNESSES
        };
        let kept: Vec<&Touch> =
            touches.iter().zip(&felt).filter(|(_, ends)| borne_out(ends)).map(|(touch, _)| *touch).collect();
        let unknowns = Parameters::new(self.agent.creature(), AxisModel::Unit, |_| true).len();
        if kept.len() < ENOUGH * unknowns { touches.to_vec() } else { kept }
    }

    /// How badly a start misses touches it was not fitted to, 1 is just acceptable; and the noise of the
    /// touches that it was fitted to, metres.
    fn judge(&self, search: &StartSearch, fitted: &TouchSet, fresh: &TouchSet, start: &Start) -> (f64, f64) {
        let used = fresh.filter(|pair| start.covers(pair));
        if used.is_empty() {
            return (f64::INFINITY, f64::INFINITY);
        }
        match search.evidence {
            Evidence::Points { acceptance, .. } => {
                // Touches of a limb that hardly any other tells of are not foretold.
                let of_limbs = fitted.count_of_limbs(self.agent.creature());
                let foretold =
                    used.filter(|pair| pair.limbs.iter().all(|&limb| of_limbs[limb] >= FORETOLD_BY));
                if foretold.is_empty() {
                    return (f64::INFINITY, f64::INFINITY);
                }
                let fresh = point_misfit(&foretold, &start.schema);
                let miss = |touch: &PreparedTouch| touch.miss(&start.schema).norm();
                let shrunk = shrunk(&foretold, miss, POINTS_APART, POINT);
                // Points without noise are their own proof; others are not.
                if !search.noisy {
                    return ((fresh / acceptance).max(shrunk), 0.0);
                }
                let known = fitted.filter(|pair| start.covers(pair));
                let noise = point_misfit(&known, &start.schema);
                // What few touches leave open is no noise.
                if usual_point_misfit(&known, &start.schema) < EXACTLY {
                    return ((fresh / acceptance).max(shrunk), 0.0);
                }
                let free = |joint: usize| start.known[joint] && !self.known.frozen[joint];
                let unknowns = Parameters::new(self.agent.creature(), AxisModel::Unit, free).len() as f64;
                // Of `n` equations with `p` unknowns the mean square is `1 − p/n` of the noise's, of fresh ones
                // about `1 + p/n`.
                let share = (unknowns / (3 * known.len()).max(1) as f64).min(0.9);
                let expected = noise * ((1.0 + share) / (1.0 - share)).sqrt();
                // Limbs that are all in one place explain touches as well as this.
                let vague = noise * taken_deviation(&known) / (MOST_OF_EXTENT * extent(&known));
                let misfit =
                    (fresh / acceptance).max(fresh / (FRESH_NOISE * expected)).max(vague).max(shrunk);
                (misfit, noise)
            }
            Evidence::Surfaces(_) => self.judge_gaps(&fitted.filter(|pair| start.covers(pair)), &used, start),
        }
    }

    /// The share of the noise within which two starts have come to the same.
    fn agreement(&self) -> f64 {
        match self.evidence() {
            Evidence::Points { .. } => POINT_AGREEMENT,
            Evidence::Surfaces(_) => AGREEMENT,
        }
    }

    /// Compares the gaps of fresh touches with what the schema predicts of them. A schema that fits by
    /// chance predicts better than it does; one that few touches leave open predicts badly, and is right.
    fn judge_gaps(&self, fitted: &TouchSet, fresh: &TouchSet, start: &Start) -> (f64, f64) {
        let free = |joint: usize| start.known[joint] && !self.known.frozen[joint];
        let parameters = Parameters::new(self.agent.creature(), AxisModel::Unit, free);
        let deviation = noise(self.agent.skin(), fitted, &parameters, &start.schema);
        let schema = &start.schema;
        let mut noise = Noise::of_gaps(deviation);
        let (mut alike, mut spread) = (0.0, deviation);
        let covariance = if deviation > CERTAIN_NOISE {
            let gaps = gaps_of(&self.agent, fitted, &parameters, schema, &[]);
            let mut prior = DMatrix::zeros(parameters.len(), parameters.len());
            self.known.prior.add_information(&parameters, &mut prior);
            noise = Noise::estimate(&gaps, &parameters, &prior, None, false);
            alike = likeness(fitted, &gaps, &noise);
            spread = noise.deviation(&gaps);
            information(&gaps, &parameters, &noise)
                .and_then(|information| information_inverse(information + prior, &parameters))
        } else {
            covariance(&self.agent, fitted, &parameters, &self.known.prior, schema, deviation)
        };
        let Some(covariance) = covariance else { return (f64::INFINITY, deviation) };
        let deviation = if deviation > CERTAIN_NOISE { spread } else { deviation };
        let mut found = GapTally::new(self.agent.creature().joints().len());
        let mut normalized = Vec::with_capacity(fresh.len());
        let mut tested = 0;
        let mut gaps = gaps_of(&self.agent, fresh, &parameters, schema, &[]).into_iter();
        for pair in &fresh.pairs {
            for gap in gaps.by_ref().take(pair.touches.len()) {
                let predicted = gap.predicted(&covariance);
                let variance = noise.variance(&gap) + predicted + CLOSE_ENOUGH * CLOSE_ENOUGH;
                let deviations = gap.gap.abs() / variance.sqrt();
                tested += usize::from(predicted < TELLING * TELLING);
                found.add(&pair.chain, deviations > OPEN);
                normalized.push(deviations);
            }
        }
        // Who predicts nothing is never wrong: that proves nothing.
        if tested < FEW || 2 * tested < fresh.len() {
            return (f64::INFINITY, deviation);
        }
        normalized.sort_by(f64::total_cmp);
        // One open touch may be false, whatever it is with; and so may as many as elsewhere.
        let chance = GapTally::of_chance(&self.agent, fitted);
        let told = found.beyond(&chance).filter(|[_, all]| *all >= FEW as f64);
        let worst = told.map(|[open, all]| (open - 1.0) / all / FRESH_OPEN).fold(0.0, f64::max);
        let [open, all] = found.all;
        let closed = 0.8 * (1.0 - open / all);
        let misfit = (quantile(&normalized, closed) / FRESH_GAP).max(worst);
        let tolerable = OpenGaps::new(&self.agent, fitted, schema).worst;
        let most = (open - 1.0) / (MOST_FALSE * all);
        let model = SurfaceGap::new(self.agent.skin(), 1.0);
        let gap = |touch: &PreparedTouch| model.gap(&touch.ends, &touch.frames(schema)).distance.abs();
        let shrunk = shrunk(fitted, gap, GAPS_APART, NARROWEST);
        let refusals = [misfit, most, alike / ALIKE, tolerable, deviation / MOST_NOISE, shrunk];
        (refusals.into_iter().fold(0.0, f64::max), deviation)
    }

    /// A schema in which every limb that is not placed has the frame of its joint, and every joint its position
    /// where its own motion cannot feel it.
    fn settled(&self, mut schema: BodySchema, placed: &[bool]) -> BodySchema {
        for joint in 0..schema.limb_poses.len() {
            if !placed[joint + 1] {
                let pose = schema.limb_poses[joint].inverse();
                schema.reframe(self.agent.creature(), joint + 1, &pose);
                // Free of the last digit.
                schema.limb_poses[joint] = Frame::identity();
            }
        }
        schema.settle_positions(self.agent.creature());
        schema
    }

    /// Fits all known joints to all touches: the schema, what it rests on, and the deviation of a touch.
    fn polish(&self, start: &Start) -> (BodySchema, Account, f64) {
        let all = self.prepare(self.touches.iter());
        let used = all.filter(|pair| start.covers(pair));
        let parameters = self.parameters(&start.known, &start.placed);
        let schema = self.with_frozen(&start.schema);
        match self.evidence() {
            Evidence::Points { .. } => {
                let stopping =
                    Stopping { iterations: 60, relative_cost: 1e-9, cost: 0.0, deadline: Deadline::NEVER };
                let fit = |schema: BodySchema, prior: &Prior| {
                    let mut problem =
                        TouchProblem::new(self.agent.creature(), &used, &parameters, PointsMeet::Shaped)
                            .with_prior(prior);
                    levenberg_marquardt(&mut problem, schema, stopping).state
                };
                let mut schema = match self.input {
                    Input::Receptor => fit(schema, &self.known.prior),
                    Input::Contact => fit(schema, &self.known.given),
                };
                if self.input == Input::Contact && self.known.is_given() && !self.noise_is_given() {
                    // What is known weighs as much as it should against touches as noisy as they are, not as they were taken to
                    // be.
                    for _ in 0..WEIGHINGS {
                        let noise = self.excess_noise(&used, &parameters, &schema);
                        schema = fit(schema, &self.known.given.sharpened(noise));
                    }
                }
                let schema = self.settled(schema, &start.placed);
                let told = match self.frames {
                    LimbFrames::Joint if self.input == Input::Contact => {
                        without_twins(self.agent.creature(), &used, &schema, &self.known.frozen)
                    }
                    _ => used,
                };
                let (account, deviation) = self.account_of(&told, &schema);
                (schema, account, deviation)
            }
            Evidence::Surfaces(skin) => {
                let annealed = anneal(&self.agent, &used, &parameters, &self.known.prior, schema);
                let mut schema = annealed.schema;
                let stopping = Stopping {
                    iterations: LAST_ITERATIONS,
                    relative_cost: LAST_RELATIVE_COST,
                    cost: 0.0,
                    deadline: Deadline::NEVER,
                };
                if annealed.gap_deviation <= CERTAIN_NOISE {
                    let deviation = self.gap_deviation(skin, &used, &parameters, &schema);
                    let model = SurfaceGap::new(skin, deviation).with_biased_places();
                    let mut problem = TouchProblem::new(self.agent.creature(), &used, &parameters, model)
                        .with_prior(&self.known.prior);
                    schema = levenberg_marquardt(&mut problem, schema, stopping).state;
                    schema = self.sharpened(skin, &used, &parameters, schema);
                } else {
                    let mut noise: Option<Noise> = None;
                    for _ in 0..WEIGHINGS {
                        let (found, widening) = self.noise(&used, &parameters, &schema, noise);
                        let prior = &self.known.prior;
                        let mut problem =
                            NoisyProblem::new(&self.agent, &used, &parameters, prior, (found, &widening));
                        schema = levenberg_marquardt(&mut problem, schema, stopping).state;
                        noise = Some(found);
                    }
                }
                let (account, deviation) = self.account_of(&used, &schema);
                (schema, account, deviation)
            }
        }
    }

    /// Whether any touch says how exact its points are.
    fn noise_is_given(&self) -> bool {
        self.touches.iter().flat_map(|touch| &touch.ends).any(|end| end.deviation.is_some())
    }

    /// How many times more noise points have than they are taken to have: by what is left of each of their equations that
    /// parameters do not take up.
    fn excess_noise(&self, used: &TouchSet, parameters: &Parameters, schema: &BodySchema) -> f64 {
        let misfit: f64 = used
            .touches()
            .map(|touch| PointsMeet::Shaped.squared_misfit(&touch.ends, &touch.frames(schema)))
            .sum();
        let spare = 3.0 * used.len() as f64 - parameters.len() as f64;
        (misfit / spare.max(1.0)).sqrt()
    }

    /// The fit to touches that show no noise, as far as they go: where surfaces are round and bodies move in a plane, gaps hardly
    /// feel what is across it.
    fn sharpened(
        &self,
        skin: &Skin,
        touches: &TouchSet,
        parameters: &Parameters,
        mut schema: BodySchema,
    ) -> BodySchema {
        // What is well known is at its place in a step or two, what is not in many, and each closes gaps fourfold.
        let stopping = Stopping { iterations: LAST_ITERATIONS, relative_cost: 1e-2, ..Stopping::default() };
        let mut left = typical_gap(&gaps(skin, touches, &schema));
        for _ in 0..SHARPENINGS {
            if left >= NARROWEST || left <= ROUNDING {
                break;
            }
            // A place in a patch says nothing that gaps so narrow do not.
            let model = SurfaceGap::new(skin, left).without_places();
            let mut problem = TouchProblem::new(self.agent.creature(), touches, parameters, model)
                .with_prior(&self.known.prior);
            let sharper = levenberg_marquardt(&mut problem, schema.clone(), stopping).state;
            let now = typical_gap(&gaps(skin, touches, &sharper));
            if now >= left {
                break;
            }
            (schema, left) = (sharper, now);
        }
        schema
    }

    /// A schema with the frozen joints exactly as they are known: starts scale every axis to unit length, which
    /// may change its last digit.
    fn with_frozen(&self, schema: &BodySchema) -> BodySchema {
        let mut schema = schema.clone();
        for (j, joint) in
            self.agent.creature().joints().iter().enumerate().filter(|(j, _)| self.known.frozen[*j])
        {
            schema.positions[j] = self.known.prior.mean.positions[j];
            for k in joint.dof_indices() {
                schema.axes[k] = self.known.prior.mean.axes[k];
            }
        }
        schema
    }

    /// Fits all touches so far from a schema that is nearly right, without any initial guess or judgement: the last
    /// step of [`Learner::learn`] alone.
    pub fn refine(&self, schema: &BodySchema) -> Learned {
        self.refine_known(schema, vec![true; self.agent.creature().joints().len()])
    }

    /// The same for the joints that are `known` at all, and the touches with only such joints between limbs.
    pub(crate) fn refine_known(&self, schema: &BodySchema, known: Vec<bool>) -> Learned {
        let placed = vec![true; self.agent.creature().limbs().len()];
        let start = Start { schema: schema.clone(), known, placed, accepted: true, initial_guesses: 0 };
        let (schema, account, deviation) = self.polish(&start);
        Learned {
            schema,
            basis: self.basis(),
            verdict: Verdict::Unjudged("it was refined from a given schema".to_string()),
            initial_guesses: 0,
            fresh_rms: f64::NAN,
            account: Some(account),
            deviation: Some(deviation),
            changes: Vec::new(),
        }
    }

    /// What all touches so far determine at a schema, and the deviation of a touch that they show, metres.
    pub fn observe(&self, schema: &BodySchema) -> (Observability, f64) {
        let seen = self.observe_touches(&self.placed_touches(schema), schema);
        (seen.observability, seen.deviation)
    }

    /// The account of a schema by all touches so far, and the deviation of a touch that they show, metres.
    pub fn account(&self, schema: &BodySchema) -> (Account, f64) {
        self.account_of(&self.placed_touches(schema), schema)
    }

    /// The touches of limbs that a schema places.
    fn placed_touches(&self, schema: &BodySchema) -> TouchSet {
        let placed =
            |pair: &PairTouches| pair.limbs.iter().all(|&limb| schema.places(self.agent.creature(), limb));
        self.prepare(self.touches.iter()).filter(placed)
    }

    fn account_of(&self, used: &TouchSet, schema: &BodySchema) -> (Account, f64) {
        let Seen { observability, witnesses, checked, deviation } = self.observe_touches(used, schema);
        let account = Account::new(&self.agent, schema, observability, witnesses);
        (self.with_curvature(account, &checked, schema), deviation)
    }

    /// An account with what exact touches of round limbs tell at second order, where limbs are open at first order.
    fn with_curvature(&self, account: Account, checked: &TouchSet, schema: &BodySchema) -> Account {
        let Evidence::Surfaces(skin) = self.evidence() else { return account };
        let all_placed = account.classes().len() <= 1;
        if all_placed || self.frames != LimbFrames::Joint {
            return account;
        }
        let deviation = SHARPLY.max(TAKEN_UP * typical_gap(&gaps(skin, checked, schema)));
        if deviation > SHARPEST {
            return account;
        }
        let distances = distances_by_curvature(&self.agent, schema, &account, checked, deviation);
        account.with_distances(self.agent.creature(), distances)
    }

    /// What touches determine at a schema.
    fn observe_touches(&self, used: &TouchSet, schema: &BodySchema) -> Seen {
        let Evidence::Surfaces(skin) = self.evidence() else { return self.observe_witnesses(used, schema) };
        let parameters = self.touched(used).0;
        let deviation = self.gap_deviation(skin, used, &parameters, schema);
        let used = if deviation > CERTAIN_NOISE {
            let (noise, _) = self.noise(used, &parameters, schema, None);
            let gaps = gaps_of(&self.agent, used, &parameters, schema, &[]);
            witnesses(&self.agent, used, schema, |number| noise.variance(&gaps[number]).sqrt(), false)
        } else {
            witnesses(&self.agent, used, schema, |_| deviation, true)
        };
        self.observe_witnesses(&used, schema)
    }

    /// The noise of touches at a schema that was fitted to them, and how much wider it makes each gap, metres.
    /// `before` is a rough guess.
    fn noise(
        &self,
        touches: &TouchSet,
        parameters: &Parameters,
        schema: &BodySchema,
        before: Option<Noise>,
    ) -> (Noise, Vec<f64>) {
        let mut prior = DMatrix::zeros(parameters.len(), parameters.len());
        self.known.prior.add_information(parameters, &mut prior);
        let estimate = |widening: &[f64], before| {
            let gaps = gaps_of(&self.agent, touches, parameters, schema, widening);
            Noise::estimate(&gaps, parameters, &prior, before, true)
        };
        let noise = before.unwrap_or_else(|| estimate(&[], None));
        let widening = widening(&self.agent, touches, schema, noise.joint);
        (estimate(&widening, Some(noise)), widening)
    }

    /// What of the joints and limbs of some touches may be fitted, and which limbs are placed at all.
    fn touched(&self, used: &TouchSet) -> (Parameters, Vec<bool>) {
        let mut touched = vec![false; self.agent.creature().joints().len()];
        used.pairs.iter().flat_map(|pair| pair.chain.joints()).for_each(|joint| touched[joint] = true);
        let mut placed = vec![self.frames == LimbFrames::Joint; self.agent.creature().limbs().len()];
        used.pairs.iter().flat_map(|pair| pair.limbs).for_each(|limb| placed[limb] = true);
        (self.parameters(&touched, &placed), placed)
    }

    fn observe_witnesses(&self, used: &TouchSet, schema: &BodySchema) -> Seen {
        let (parameters, placed) = self.touched(used);
        let mut spread = 0.0;
        let mut touches = used.clone();
        let (found, deviation, at_floor) = match self.evidence() {
            Evidence::Points { .. } => {
                let (found, misses) = loop {
                    let mut problem =
                        TouchProblem::new(self.agent.creature(), &touches, &parameters, PointsMeet::Shaped);
                    let model = problem.linearize(schema);
                    let spare = (3 * touches.len()).saturating_sub(parameters.len()).max(1);
                    let misses = (2.0 * model.cost / spare as f64).sqrt();
                    // Points that miss by more than they were taken to say that much less.
                    let least = misses.max(1.0).powi(2);
                    let found =
                        self.observability(&parameters, schema, model.hessian / least, 3 * touches.len());
                    match self.checked_points(&touches, schema, &found, least) {
                        Some(few) => touches = few,
                        None => break (found, misses),
                    }
                };
                (found, taken_deviation(used) * misses, misses <= 1.0)
            }
            Evidence::Surfaces(skin) => {
                let mut deviation = self.gap_deviation(skin, used, &parameters, schema);
                let mut noise = Noise::of_gaps(deviation);
                let noisy = deviation > CERTAIN_NOISE;
                if noisy {
                    noise = self.noise(used, &parameters, schema, None).0;
                    deviation = noise.deviation(&gaps_of(&self.agent, used, &parameters, schema, &[]));
                    spread = deviation;
                }
                noise.contact = noise.contact.max(SHARPEST);
                let found = loop {
                    let widening =
                        if noisy { widening(&self.agent, &touches, schema, noise.joint) } else { Vec::new() };
                    let gaps = gaps_of(&self.agent, &touches, &parameters, schema, &widening);
                    let hessian = if noisy {
                        information(&gaps, &parameters, &noise)
                            .unwrap_or_else(|| DMatrix::zeros(parameters.len(), parameters.len()))
                    } else {
                        let model = SurfaceGap::new(skin, noise.contact).without_places();
                        let mut problem =
                            TouchProblem::new(self.agent.creature(), &touches, &parameters, model);
                        problem.linearize(schema).hessian / MEAN_WEIGHT
                    };
                    let found = self.observability(&parameters, schema, hessian, 5 * touches.len());
                    // Without some of the touches others may be the only ones that are left.
                    match checked(&touches, &gaps, &found, &noise) {
                        Some(few) => touches = few,
                        None => break found,
                    }
                };
                (found, deviation, deviation <= NARROWEST)
            }
        };
        let witnesses = Witnesses {
            of_limbs: used.count_of_limbs(self.agent.creature()),
            point_deviation: if self.input == Input::Contact { deviation } else { spread },
            at_floor,
        };
        Seen { observability: found.with_placed(placed), witnesses, checked: touches, deviation }
    }

    /// The same as [`checked`] of points, of which each gives three equations: those are left whose every equation others
    /// check. One false touch places a limb that has no other one, and no residual shows it. `found` is what they determine
    /// with a variance so many times (`share`) that of the points.
    fn checked_points(
        &self,
        touches: &TouchSet,
        schema: &BodySchema,
        found: &Observability,
        share: f64,
    ) -> Option<TouchSet> {
        let mut few = touches.clone();
        // Many touches of one pair of limbs check one another.
        for pair in few.pairs.iter_mut().filter(|pair| pair.touches.len() < FEW) {
            let (limbs, chain) = (pair.limbs, pair.chain.clone());
            pair.touches.retain(|touch| {
                let alone = PairTouches { limbs, chain: chain.clone(), touches: vec![touch.clone()] };
                let alone = TouchSet { pairs: vec![alone] };
                let mut problem =
                    TouchProblem::new(self.agent.creature(), &alone, &found.parameters, PointsMeet::Shaped);
                let information = problem.linearize(schema).hessian / share;
                found.greatest_leverage(&information) < UNCHECKED
            });
        }
        few.pairs.retain(|pair| !pair.touches.is_empty());
        (few.len() < touches.len()).then_some(few)
    }

    /// What information (lower triangle) of so many residuals determines, with what was known in advance.
    fn observability(
        &self,
        parameters: &Parameters,
        schema: &BodySchema,
        mut hessian: DMatrix<f64>,
        rows: usize,
    ) -> Observability {
        self.known.given.add_information(parameters, &mut hessian);
        self.fix_choices(parameters, schema, &mut hessian);
        Observability::new(
            self.agent.creature(),
            parameters.clone(),
            &self.known.frozen,
            hessian,
            rows,
            LengthUnit::METRE,
        )
    }

    /// Adds to normal equations (lower triangle) that limbs' origins do not shift where their joints cannot feel
    /// it, for that is gauge freedom: see [`BodySchema::settle_positions`].
    fn fix_choices(&self, parameters: &Parameters, schema: &BodySchema, hessian: &mut DMatrix<f64>) {
        for (joint, offset) in self.agent.creature().joints().iter().zip(&parameters.limb_origins) {
            if let Some(offset) = *offset {
                let mut block = hessian.fixed_view_mut::<3, 3>(offset, offset);
                block +=
                    unfelt_shifts(self.agent.creature(), joint, &schema.axes) * CONTACT_DEVIATION.powi(-2);
            }
        }
    }

    /// What may be fitted of joints that are known at all and limbs that are placed.
    fn parameters(&self, known: &[bool], placed: &[bool]) -> Parameters {
        let free = |joint: usize| known[joint] && !self.known.frozen[joint];
        let parameters = Parameters::new(self.agent.creature(), AxisModel::Unit, free);
        match self.frames {
            LimbFrames::Joint => parameters,
            LimbFrames::Limb => parameters.with_limb_poses(|joint| known[joint] && placed[joint + 1], None),
        }
    }

    /// Standard deviation of the gaps at a fitted schema, metres.
    fn gap_deviation(
        &self,
        skin: &Skin,
        touches: &TouchSet,
        parameters: &Parameters,
        schema: &BodySchema,
    ) -> f64 {
        let start = noise(skin, touches, parameters, schema);
        let mut problem =
            TouchProblem::new(self.agent.creature(), touches, parameters, SurfaceGap::new(skin, start))
                .with_prior(&self.known.prior);
        let Some(covariance) = information_inverse(problem.linearize(schema).hessian, parameters) else {
            return start;
        };
        let mut row = GapRow::default();
        let rows = touches.touches().map(|touch| {
            row.set(skin, parameters, schema, touch);
            (row.gap, MEAN_WEIGHT * row.variance(&covariance) / start.powi(2))
        });
        gap_scale(&rows.collect::<Vec<_>>(), start).max(NARROWEST)
    }
}

/// The touches that are closed and that others check; none where that are all.
///
/// A touch whose leverage is nearly 1 closes its gap whatever the truth is: the fit has a parameter for it alone.
/// What rests on such touches is not known, however small it leaves the gaps (Baarda's reliability, "A Testing
/// Procedure for Use in Geodetic Networks", 1968). `found` is what they determine in some noise; `gaps` are theirs.
fn checked(touches: &TouchSet, gaps: &[NoisyGap], found: &Observability, noise: &Noise) -> Option<TouchSet> {
    let mut gaps = gaps.iter();
    let mut few = touches.clone();
    for pair in &mut few.pairs {
        pair.touches.retain(|_| {
            let gap = gaps.next().expect("every touch has a gap");
            let variance = noise.variance(gap);
            let weight = 1.0 / (1.0 + gap.gap * gap.gap / (TAIL * TAIL * variance));
            // The weights that the information was divided by are 1 for a gap that is closed.
            let leverage = weight * gap.predicted(&found.covariance) / (MEAN_WEIGHT * variance);
            // A gap that is open speaks against the schema, and for nothing.
            leverage < UNCHECKED && gap.gap * gap.gap <= OPEN * OPEN * variance
        });
    }
    few.pairs.retain(|pair| !pair.touches.is_empty());
    (few.len() < touches.len()).then_some(few)
}

/// Standard deviation of the gaps of touches that parameters were fitted to, as they show it, metres.
fn noise(skin: &Skin, touches: &TouchSet, parameters: &Parameters, schema: &BodySchema) -> f64 {
    let typical = typical_gap(&gaps(skin, touches, schema));
    // Parameters take up a part of the gaps.
    let spare = (touches.len() as f64 - 0.7 * parameters.len() as f64).max(1.0);
    let scatter = (touches.len() as f64 / spare).sqrt();
    (typical * scatter).max(NARROWEST)
}

/// The variance of each coordinate of a point of contact, m²: from its standard deviation where that is given, but
/// no point is taken to be more exact than [`CONTACT_DEVIATION`] allows.
fn contact_variance(deviation: Option<f64>) -> f64 {
    let least = 0.5 * CONTACT_DEVIATION * CONTACT_DEVIATION;
    deviation.map_or(least, |deviation| least.max(deviation * deviation))
}

/// How far apart, per coordinate and as a root mean square, the two places of a touch are taken to be, metres.
fn taken_deviation(touches: &TouchSet) -> f64 {
    let touches = || touches.touches();
    let variance =
        |touch: &PreparedTouch| (touch.ends[0].covariance + touch.ends[1].covariance).trace() / 3.0;
    (touches().map(variance).sum::<f64>() / touches().count().max(1) as f64).sqrt()
}

/// How far, per coordinate and as a root mean square, the places of touches lie about their middle on a limb: on that of the
/// two limbs of a touch on which they lie the farther, metres.
fn extent(touches: &TouchSet) -> f64 {
    let mut places: BTreeMap<usize, Vec<Vector3<f64>>> = BTreeMap::new();
    for pair in &touches.pairs {
        for (limb, end) in pair.limbs.into_iter().zip([0, 1]) {
            places.entry(limb).or_default().extend(pair.touches.iter().map(|touch| touch.ends[end].position));
        }
    }
    let variance = |places: Vec<Vector3<f64>>| {
        let count = places.len() as f64;
        let middle = places.iter().sum::<Vector3<f64>>() / count;
        places.iter().map(|place| (place - middle).norm_squared()).sum::<f64>() / (3.0 * count)
    };
    let variances: BTreeMap<usize, f64> =
        places.into_iter().map(|(limb, places)| (limb, variance(places))).collect();
    let larger = |pair: &PairTouches| variances[&pair.limbs[0]].max(variances[&pair.limbs[1]]);
    let sum: f64 = touches.pairs.iter().map(|pair| pair.touches.len() as f64 * larger(pair)).sum();
    (sum / touches.len().max(1) as f64).sqrt()
}

/// How nearly touches would be explained in any postures as well, 1 is just too nearly: as by a body that is shrunk to the point
/// where its limbs meet, or whose limbs spin about themselves. In the postures for comparison each joint is as in another touch
/// of the same limbs, and there the median `miss` is to be so many `times` as large, and as the `least` that tells, metres.
fn shrunk(touches: &TouchSet, miss: impl Fn(&PreparedTouch) -> f64, times: f64, least: f64) -> f64 {
    let (mut honest, mut mixed) = (Vec::new(), Vec::new());
    for pair in touches.pairs.iter().filter(|pair| pair.touches.len() > 1) {
        let count = pair.touches.len();
        for (i, touch) in pair.touches.iter().enumerate() {
            let other = |side: usize, place: usize| {
                &pair.touches[(i + 1 + (2 * place + side) % (count - 1)) % count].sides[side]
            };
            let sides = [0, 1].map(|side| touch.sides[side].mixed(|place| other(side, place)));
            honest.push(miss(touch));
            mixed.push(miss(&PreparedTouch { sides, ends: touch.ends }));
        }
    }
    if honest.is_empty() {
        return 0.0;
    }
    let [honest, mixed] = [honest, mixed].map(|mut misses: Vec<f64>| {
        misses.sort_by(f64::total_cmp);
        quantile(&misses, 0.5)
    });
    times * honest.max(least) / mixed.max(least)
}

fn kept_back(touch: usize) -> bool {
    touch % KEPT_BACK == KEPT_BACK - 1
}

/// Root mean square of the whitened misses of a schema.
fn point_misfit(touches: &TouchSet, schema: &BodySchema) -> f64 {
    let squares: f64 = squared_point_misfits(touches, schema).sum();
    (squares / (3.0 * touches.len() as f64)).sqrt()
}

/// The misfit that most touches stay below, in the same units.
fn usual_point_misfit(touches: &TouchSet, schema: &BodySchema) -> f64 {
    let mut misfits: Vec<f64> =
        squared_point_misfits(touches, schema).map(|squared| (squared / 3.0).sqrt()).collect();
    misfits.sort_by(f64::total_cmp);
    quantile(&misfits, USUAL)
}

/// Per touch, the sum of the squares of its three whitened residuals.
fn squared_point_misfits(touches: &TouchSet, schema: &BodySchema) -> impl Iterator<Item = f64> {
    touches.touches().map(|touch| PointsMeet::Shaped.squared_misfit(&touch.ends, &touch.frames(schema)))
}

/// What touches determine at a schema.
struct Seen {
    observability: Observability,
    witnesses: Witnesses,
    /// The touches that others check: what it all rests on.
    checked: TouchSet,
    /// The deviation of a touch that they show, metres.
    deviation: f64,
}

/// How to look for an answer.
struct StartSearch<'a> {
    /// What the touches say, and how well an answer has to explain it.
    evidence: Evidence<'a>,
    /// Whether two starts must agree on how much noise there is.
    noisy: bool,
    /// Most starts.
    starts: usize,
}

/// What a search found.
struct SearchResult {
    best: Judged,
    /// Random initial guesses used.
    initial_guesses: usize,
    /// Whether starts agreed on an answer that was not accepted.
    settled: bool,
}

/// A start and how it did on touches that it was not fitted to.
struct Judged {
    start: Start,
    /// 1 is just acceptable.
    judged: f64,
    /// Noise of the touches that it was fitted to, metres.
    noise: f64,
}

impl Judged {
    /// How many joints it knows, and limbs.
    fn known(&self) -> usize {
        self.start.known.iter().chain(&self.start.placed).filter(|&&known| known).count()
    }

    /// Whether it is the answer rather than that of a search that allowed for less noise.
    fn more(&self, other: &Judged) -> bool {
        self.start.accepted && (!other.start.accepted || self.known() > other.known())
    }

    fn better(&self, other: &Judged) -> bool {
        if self.start.accepted != other.start.accepted {
            return self.start.accepted;
        }
        if self.start.accepted && self.known() != other.known() {
            return self.known() > other.known();
        }
        let score = |judged: &Judged| judged.judged.max(1.0) * judged.noise.max(NARROWEST);
        if self.start.accepted { self.noise < other.noise } else { score(self) < score(other) }
    }
}

impl Learner for SecondOrder {
    fn touch(&mut self, touch: &Touch) {
        self.touches.push(touch.clone());
    }

    fn end_at(&mut self, deadline: Deadline) {
        self.deadline = deadline;
    }

    fn learn(&mut self) -> Learned {
        self.learn_in(STARTS)
    }
}

impl SecondOrder {
    /// Learns from all touches in so many starts at most.
    pub fn learn_in(&self, starts: usize) -> Learned {
        let fresh = self.touches.iter().enumerate().filter(|(i, _)| kept_back(*i)).map(|(_, touch)| touch);
        let fresh = self.prepare(fresh);
        let fitted = self.fitted();
        let touches = self.prepare(fitted.iter().copied());
        let borne_out = match self.evidence() {
            Evidence::Surfaces(_) => self.prepare(self.borne_out(&fitted).into_iter()),
            Evidence::Points { .. } => TouchSet::default(),
        };
        let solvable = match self.frames {
            LimbFrames::Joint => {
                let starved = self.nursery(self.evidence(), &touches, 0).starved();
                starved.iter().filter(|&&starved| !starved).count() + self.agent.creature().limbs().len()
            }
            LimbFrames::Limb => self.limb_nursery(&touches, 0).solvable(),
        };
        let mut initial_guesses = 0;
        let mut found: Option<Judged> = None;
        for search in self.searches(&touches, starts) {
            let SearchResult { best, initial_guesses: tried, settled } =
                self.search(&search, solvable, [&touches, &borne_out], &fresh);
            initial_guesses += tried;
            // Where starts agree on an answer that fresh touches do not bear out, more noise is no excuse.
            let done = settled || (best.start.accepted && best.known() >= solvable);
            if found.as_ref().is_none_or(|found| best.more(found)) {
                found = Some(best);
            }
            if done || self.deadline.has_passed() {
                break;
            }
        }
        self.conclude(found.expect("there is a search"), initial_guesses)
    }

    fn nursery<'t>(&'t self, evidence: Evidence<'t>, touches: &'t TouchSet, turn: usize) -> Nursery<'t> {
        let PriorKnowledge { prior, frozen, .. } = &self.known;
        Nursery { agent: &self.agent, touches, evidence, prior, frozen, turn, deadline: self.deadline }
    }

    fn limb_nursery<'t>(&'t self, touches: &'t TouchSet, turn: usize) -> LimbNursery<'t> {
        LimbNursery { creature: self.agent.creature(), touches, turn, deadline: self.deadline }
    }

    /// The searches to try one after the other until one finds an answer. There is one, but for points with
    /// noise of which nobody knows how much it is.
    fn searches(&self, touches: &TouchSet, starts: usize) -> Vec<StartSearch<'_>> {
        let evidence = self.evidence();
        if self.input != Input::Contact || self.frames == LimbFrames::Limb {
            return vec![StartSearch { evidence, noisy: !evidence.exact(), starts }];
        }
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(NOISE_STREAM);
        let noise = self.nursery(evidence, touches, 0).point_noise(&mut rng).unwrap_or(0.0);
        let most = MOST_NOISE / taken_deviation(touches);
        if noise <= VISIBLE_NOISE || noise > most {
            return vec![StartSearch { evidence, noisy: false, starts }];
        }
        let acceptances = WIDER.map(|wider| (wider * NOISE_MARGIN * noise).clamp(EXACT, most.max(EXACT)));
        let search = |acceptance| {
            let evidence = Evidence::Points { acceptance, patches: false };
            StartSearch { evidence, noisy: true, starts: starts.min(NOISY_STARTS) }
        };
        acceptances.into_iter().map(search).collect()
    }

    /// Makes the starts of a search, as many as it takes.
    fn search(
        &self,
        search: &StartSearch,
        solvable: usize,
        [touches, borne_out]: [&TouchSet; 2],
        fresh: &TouchSet,
    ) -> SearchResult {
        let dof = self.agent.creature().dof();
        let incomplete_starts = match self.frames {
            LimbFrames::Joint => INCOMPLETE_STARTS,
            LimbFrames::Limb => INCOMPLETE_LIMB_STARTS,
        };
        let make = |number: usize| {
            let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
            rng.set_stream(number as u64);
            let doubts = matches!(search.evidence, Evidence::Surfaces(_)) && number % 4 >= 2;
            let used = if doubts { borne_out } else { touches };
            let nursery = self.nursery(search.evidence, used, number);
            let mut start = match self.frames {
                LimbFrames::Joint => nursery.start(nursery.evidence.route(number, dof), &mut rng),
                LimbFrames::Limb => self.limb_nursery(touches, number).start(&mut rng),
            };
            let (judged, noise) = self.judge(search, touches, fresh, &start);
            start.accepted &= judged <= 1.0;
            Judged { start, judged, noise }
        };
        // All cores make starts; which one is taken does not depend on how many there are.
        let mut best: Option<Judged> = None;
        let (mut initial_guesses, mut settled) = (0, false);
        let mut noises: Vec<f64> = Vec::new();
        let points = self.input == Input::Contact;
        let metres = if points { taken_deviation(touches) } else { 1.0 };
        // Starts of a large body are long, and try several initial guesses for each part.
        let starts = if dof > WHOLE_DOF && !search.evidence.exact() {
            search.starts.min(LARGE_STARTS)
        } else {
            search.starts
        };
        let numbers: Vec<usize> = (0..starts).collect();
        'waves: for wave in numbers.chunks(rayon::current_num_threads()) {
            if best.is_some() && self.deadline.has_passed() {
                break;
            }
            let made: Vec<Judged> = wave.par_iter().map(|&number| make(number)).collect();
            for (trial, number) in made.into_iter().zip(wave) {
                initial_guesses += trial.start.initial_guesses;
                noises.push(trial.noise);
                if best.as_ref().is_none_or(|best| trial.better(best)) {
                    best = Some(trial);
                }
                let best = best.as_ref().expect("one was made");
                let agreeing =
                    noises.iter().filter(|&&noise| noise <= (1.0 + self.agreement()) * best.noise).count();
                let complete = best.known() >= solvable || *number + 1 >= incomplete_starts;
                if best.start.accepted && complete && (best.noise <= CERTAIN_NOISE || agreeing >= 2) {
                    break 'waves;
                }
                let blind = self.frames == LimbFrames::Limb && best.known() == 0;
                if blind && *number + 1 >= BLIND_LIMB_STARTS {
                    break 'waves;
                }
                // With points it is the least noise that starts have to agree on, whoever is best by other measures.
                let least =
                    if points { noises.iter().copied().fold(f64::INFINITY, f64::min) } else { best.noise };
                let agreeing =
                    noises.iter().filter(|&&noise| noise <= (1.0 + self.agreement()) * least).count();
                let plausible = CERTAIN_NOISE < least && metres * least < TANGLED;
                settled = plausible && agreeing >= HOPELESS_STARTS;
                if settled {
                    break 'waves;
                }
            }
        }
        let mut best = best.expect("at least one start is made");
        // Noise that no second start finds may be a wrong minimum as well.
        let agreeing = noises.iter().filter(|&&noise| noise <= (1.0 + self.agreement()) * best.noise).count();
        best.start.accepted &= best.noise <= CERTAIN_NOISE || agreeing >= 2;
        SearchResult { best, initial_guesses, settled }
    }

    /// Where gaps show noise, an answer that rests on few of the touches may be a chance among them; why it is refused then.
    fn few_tell(&self, account: &Account, deviation: f64) -> Option<Verdict> {
        if deviation <= CERTAIN_NOISE || !matches!(self.evidence(), Evidence::Surfaces(_)) {
            return None;
        }
        let receptors = &self.agent.skin().receptors;
        let told = self.touches.iter().filter(|touch| {
            let [a, b] = touch.ends.map(|end| receptors[end.receptor].limb);
            account.claims(a, b)
        });
        let (told, all) = (told.count(), self.touches.len());
        (account.claims_any() && (told as f64) < FEWEST_TELL * all as f64).then(|| {
            Verdict::Failed(format!(
                "in such noise only {told} of {all} touches are of limbs that could be placed, which may be chance: give more \
                 touches (--touches), or sharper ones"
            ))
        })
    }

    /// Whether all touches of each limb are so near one point that a body without size explains them as well.
    fn is_at_one_point(&self) -> bool {
        if !matches!(self.evidence(), Evidence::Points { .. }) {
            return false;
        }
        let touches = self.prepare(self.touches.iter());
        let from_joints =
            touches.touches().flat_map(|touch| touch.ends).map(|end| end.position.norm_squared());
        let size = (from_joints.sum::<f64>() / (2 * touches.len()).max(1) as f64).sqrt();
        extent(&touches) < ONE_POINT * size
    }

    /// Fits what was found to all touches, or says why nothing was.
    fn conclude(&self, found: Judged, initial_guesses: usize) -> Learned {
        let Judged { start, judged, .. } = found;
        if start.accepted {
            let (schema, account, deviation) = self.polish(&start);
            return Learned {
                schema,
                basis: self.basis(),
                verdict: self
                    .few_tell(&account, deviation)
                    .unwrap_or_else(|| account.verdict(self.agent.creature())),
                initial_guesses,
                fresh_rms: judged,
                account: Some(account),
                deviation: Some(deviation),
                changes: Vec::new(),
            };
        }
        let why = if initial_guesses == 0 && self.deadline.has_passed() {
            "the time was over before one random initial guess was tried to its end: give it more (--seconds)"
                .to_string()
        } else if initial_guesses == 0 {
            "no joint has as many touches as it has unknowns: give more touches".to_string()
        } else if self.is_at_one_point() {
            "all touches are at one point of each limb, and a body that is shrunk to a point explains that as well: touch other \
             places of a limb, or say what is known of joints (--known)"
                .to_string()
        } else {
            format!(
                "none of {initial_guesses} random initial guesses explains the touches that it was not fitted to; try more touches \
                 (--touches) or another seed (--seed){}",
                if self.known.is_given() { ", or check what is known (--known)" } else { "" }
            )
        };
        Learned {
            schema: self.with_frozen(&start.schema),
            basis: self.basis(),
            verdict: Verdict::Failed(why),
            initial_guesses,
            fresh_rms: judged,
            account: None,
            deviation: None,
            changes: Vec::new(),
        }
    }
}
