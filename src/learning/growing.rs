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
//!
//! Where limbs have frames of their own, a new limb brings its pose on its joint besides, and
//!
//! 1. with rotations `Q` relaxed to any matrix a residual is linear in all positions and poses once the axes are
//!    given. So an initial guess is random axes and nothing else: the rest is solved for at once.
//! 2. A limb that a chain passed through before it was touched itself has a frame by convention. Its first
//!    touches with a limb whose place is known determine its own frame in closed form (Kabsch 1976).
//! 3. A pair of limbs is taken only when what it adds is tied to all that is known: both limbs are placed
//!    already or new, and no limb in between has a frame that nothing in the pair refers to.
//!
//! A limb is *placed* once touches of its own determine its frame, and *framed* once anything refers to its frame.

use std::collections::BTreeSet;

use nalgebra::{Matrix3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::agent::Agent;
use crate::deadline::Deadline;
use crate::geometry::Frame;
use crate::learning::annealing::{
    AnnealingLimits, HOPELESS, NARROWEST, POINT_FITS, WIDEST, anneal, gaps, meet, quantile, usual_miss,
};
use crate::learning::least_squares::{Stopping, levenberg_marquardt};
use crate::learning::observation::PointsMeet;
use crate::learning::open_gaps::OpenGaps;
use crate::learning::touch_set::{PairTouches, PreparedTouch, TouchProblem, TouchSet};
use crate::learning::{AxisModel, LimbFrames, Parameters, Prior};
use crate::schema::{BodySchema, nearest_rotation};
use crate::skin::Skin;

/// Root mean square of whitened residuals that contact points without noise can have.
const EXACT: f64 = 1.0;
/// The same for receptor centres: they have a bias, the bulge of the limb.
const BIASED: f64 = 1.5;
/// The same for points in the noise that the part that is solved first shows: others are solved on joints that are held where noise
/// left them.
const NOISE_MARGIN: f64 = 3.0;
/// Root mean square of whitened residuals that is as good as zero: no noise is so small.
const ZERO: f64 = 1e-5;
/// Initial guesses tried for one part of the body.
const GUESSES_PER_PART: usize = 16;
/// Parts that fail before a start grows no more.
const MOST_FAILED: usize = 4;
/// The same where a start knows nothing yet: long chains alone make none to grow on.
const HOPELESS_PARTS: usize = 2;
/// Misfit of an answer that is just right, in units of what the evidence allows.
const ACCEPTABLE: f64 = 1.0;
/// Misfit of a part below which no better initial guess is looked for, where limbs' poses take up more than joints do: exact points
/// leave far less.
const CERTAIN: f64 = 1e-2;
/// How much harder a part may be than the easiest and be taken first, degrees of freedom: later starts differ in that.
const VARIETY: f64 = 3.0;
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
/// Equations that a part has to spare at the least.
const PART_SPARE: usize = 9;
/// Of so many joints one may be given up.
const MOST_GIVEN_UP: usize = 4;
/// Touches that fix where a limb is on the joints about it.
const FIXED_BY: usize = 4;
/// Touches that determine a limb's own frame at the least.
const REGISTERED: usize = 5;
/// How far they must reach across the line that fits them best, metres (root mean square).
const BREADTH: f64 = 2e-3;
/// Sizes of parts that starts in noise begin with, each of twice as many touches as the one before; the last is the whole body, as
/// every fourth start is.
const NOISY_SIZES: usize = 4;

/// What one start came to.
#[derive(Clone)]
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

/// A part of the body that can be solved next.
#[derive(Default)]
struct Part {
    /// Its unknown joints.
    joints: Vec<usize>,
    /// Known joints that it moves besides.
    released: Vec<usize>,
    /// The touches that it closes.
    touches: TouchSet,
}

impl Part {
    fn moves(&self, joint: usize) -> bool {
        self.joints.contains(&joint) || self.released.contains(&joint)
    }
}

/// What starts are made from.
pub struct MultiStart<'a> {
    /// The agent.
    pub agent: &'a Agent,
    /// The touches to explain.
    pub touches: &'a TouchSet,
    /// What the touches say.
    pub evidence: Evidence<'a>,
    /// The frames that points on limbs are given in; those of the limbs' own need exact points.
    pub frames: LimbFrames,
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
    Points,
    /// They are, but for noise.
    NoisyPoints(PointNoise),
    /// They are the centres of patches, which have a bias.
    Centres,
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
        matches!(self, Evidence::Points | Evidence::NoisyPoints(_))
    }

    /// What the root mean square of the whitened residuals of points stays below.
    pub fn acceptance(&self) -> f64 {
        match self {
            Evidence::NoisyPoints(_) => NOISE_MARGIN,
            Evidence::Centres => BIASED,
            Evidence::Points | Evidence::Surfaces(_) => EXACT,
        }
    }

    /// Whether there may be noise, of which two starts must agree how much it is.
    pub fn may_be_noisy(&self) -> bool {
        !matches!(self, Evidence::Points)
    }

    /// Touches of points that a part needs before it is solved, where there is a choice: some, and some more per unknown degree of
    /// freedom and limb's pose. In noise a wrong answer may explain few touches, and how many are few depends on the body: starts
    /// differ in that.
    fn enough(&self, dof: usize, poses: usize, start: usize) -> usize {
        let enough = 8 + 2 * dof + 4 * poses;
        match self {
            Evidence::NoisyPoints(_) => enough << (start % NOISY_SIZES),
            _ => enough,
        }
    }
}

impl MultiStart<'_> {
    /// One start from a random initial guess.
    pub fn start(&self, rng: &mut ChaCha8Rng) -> Start {
        let mut start = self.nothing();
        for joint in (0..self.frozen.len()).filter(|&joint| !self.frozen[joint]) {
            self.prior.randomize_joint(self.agent.creature(), &mut start.schema, joint, rng);
        }
        let touches = self.usable();
        // Points are sharp enough to grow on, every fourth start is whole for safety; receptors are coarse.
        let grows = self.frames == LimbFrames::Limb || self.turn % 4 < 3;
        if self.evidence.exact() && grows {
            self.grown(&touches, start, rng)
        } else {
            self.whole(touches, start, rng)
        }
    }

    /// How many joints and limbs can be known: they are before the first touch, or have touches enough.
    pub fn solvable(&self) -> usize {
        let touches = self.usable();
        let joints = touches.joints();
        let joints = (0..self.frozen.len()).filter(|joint| self.frozen[*joint] || joints.contains(joint));
        let limbs = match self.frames {
            LimbFrames::Joint => self.agent.creature().limbs().len(),
            LimbFrames::Limb => touches.limbs().len(),
        };
        joints.count() + limbs
    }

    /// The touches between limbs with enough of them, across joints with enough of them.
    fn usable(&self) -> TouchSet {
        let touches = self.without(&self.underdetermined());
        set_of(self.placing(touches.pairs.iter().collect(), &self.nothing().placed))
    }

    /// All joints at once; of surfaces without those whose touches stay open.
    fn whole(&self, touches: TouchSet, mut start: Start, rng: &mut ChaCha8Rng) -> Start {
        let joints = unknown_joints(&touches.pairs, &start.known);
        if joints.is_empty() || self.deadline.has_passed() {
            return start;
        }
        let part = Part { joints, released: Vec::new(), touches };
        let (schema, mut misfit) = self.solve_once(&part, &start, rng);
        start.schema = schema;
        start.initial_guesses += 1;
        part.joints.iter().for_each(|&joint| start.known[joint] = true);
        if misfit <= ACCEPTABLE {
            misfit = self.settle_known(&part.touches, &mut start);
        }
        start.accepted = misfit <= ACCEPTABLE;
        if let Evidence::Surfaces(_) = self.evidence {
            if start.accepted {
                self.give_up(&part.touches, &mut start);
            }
            // Whether what is open still may be is for all touches to say.
            start.accepted = misfit <= NOISY_GAP / PART_GAP;
        }
        start
    }

    /// Part by part: what no initial guess solves is left out.
    fn grown(&self, touches: &TouchSet, mut start: Start, rng: &mut ChaCha8Rng) -> Start {
        // Limbs and parts that no way was found to fit.
        let mut misfits = vec![false; start.placed.len()];
        let mut failed: Vec<Vec<usize>> = Vec::new();
        loop {
            if let Some((limb, frame)) = self.registration(touches, &start, &misfits) {
                let mut placed = start.clone();
                placed.schema.reframe(self.agent.creature(), limb, &frame);
                placed.placed[limb] = true;
                match self.settle_known(touches, &mut placed) <= ACCEPTABLE {
                    true => start = placed,
                    false => misfits[limb] = true,
                }
                continue;
            }
            let most = if start.known.contains(&true) { MOST_FAILED } else { HOPELESS_PARTS };
            if failed.len() >= most || self.deadline.has_passed() {
                return start;
            }
            let Some(part) = self.next_part(touches, &start, &failed, rng) else { return start };
            let mut grown = start.clone();
            let is_solved = self.solve_part(&part, &mut grown, rng) <= ACCEPTABLE;
            if is_solved && self.settle_known(touches, &mut grown) <= ACCEPTABLE {
                start = Start { accepted: true, ..grown };
            } else {
                start.initial_guesses = grown.initial_guesses;
                failed.push(part.joints);
            }
        }
    }

    /// A start of which nothing is known but what was before; that is right, if it is anything.
    fn nothing(&self) -> Start {
        let limbs = self.agent.creature().limbs().len();
        let schema = self.prior.mean.clone();
        let (schema, placed) = match self.frames {
            LimbFrames::Joint => (schema, vec![true; limbs]),
            LimbFrames::Limb => (schema.with_limb_poses(), vec![false; limbs]),
        };
        let accepted = self.frozen.contains(&true);
        Start { schema, known: self.frozen.to_vec(), placed, accepted, initial_guesses: 0 }
    }

    /// Fits all that is known of a start to its touches.
    fn settle_known(&self, touches: &TouchSet, start: &mut Start) -> f64 {
        let used = touches.filter(|pair| start.covers(pair));
        let parameters = self.parameters(AxisModel::Unit, &|joint| start.known[joint]);
        let has_pose =
            |joint: usize| self.frames == LimbFrames::Limb && start.known[joint] && start.placed[joint + 1];
        let parameters = parameters.with_limb_poses(has_pose, None);
        let (schema, misfit) = self.settle(&used, &parameters, start.schema.clone());
        start.schema = schema;
        misfit
    }

    /// The noise of points: root mean square of the whitened residuals of the part that is solved first, in units
    /// of one standard deviation each; parameters take up some of it, which is counted in. No acceptance is asked for, so that a
    /// wrong minimum of all initial guesses makes it too large.
    pub fn point_noise(&self, rng: &mut ChaCha8Rng) -> Option<PointNoise> {
        let mut start = self.nothing();
        let part = self.next_part(&self.usable(), &start, &[], rng)?;
        let misfit = self.solve_part(&part, &mut start, rng);
        let unknowns = part.joints.iter().map(|&joint| self.unknowns(joint)).sum::<usize>();
        let rows = 3 * part.touches.len();
        // Misfits are told in units of what is accepted.
        let rms = EXACT * misfit * (rows as f64 / rows.saturating_sub(unknowns).max(1) as f64).sqrt();
        Some(PointNoise { of_points: rms, of_joints: rms / lever(&part.touches, &start.schema) })
    }

    /// The joints with too few touches to solve them: each touch closes one gap, or brings a point together.
    fn underdetermined(&self) -> Vec<bool> {
        let mut starved = vec![false; self.agent.creature().joints().len()];
        loop {
            let mut counts = vec![0; starved.len()];
            for pair in self.without(&starved).pairs {
                pair.chain.joints().for_each(|joint| counts[joint] += pair.touches.len());
            }
            let least = |joint: usize| match self.evidence {
                Evidence::Surfaces(_) => self.unknowns(joint) + SPARE,
                _ => self.unknowns(joint) / 2 + SPARE,
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

    /// The pairs without those of limbs, not placed, that have too few touches in them to be.
    fn placing<'p>(&self, mut pairs: Vec<&'p PairTouches>, placed: &[bool]) -> Vec<&'p PairTouches> {
        loop {
            let mut counts = vec![0; placed.len()];
            for pair in &pairs {
                pair.limbs.iter().for_each(|&limb| counts[limb] += pair.touches.len());
            }
            let before = pairs.len();
            pairs.retain(|pair| pair.limbs.iter().all(|&limb| placed[limb] || counts[limb] >= REGISTERED));
            if pairs.len() == before {
                return pairs;
            }
        }
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
        let annealed = anneal(limits, self.agent, touches, parameters, self.prior, start);
        let mut schema = annealed.schema;
        schema.normalize_axes(self.agent.creature());
        (schema, annealed.p80_gap)
    }

    /// The part to solve next, the unknown joints of one pair of limbs: of those with touches enough the one with fewest
    /// unknowns, of others the one that has most touches for its size; `None` if no touch brings a new joint that can be solved.
    fn next_part(
        &self,
        touches: &TouchSet,
        start: &Start,
        failed: &[Vec<usize>],
        rng: &mut ChaCha8Rng,
    ) -> Option<Part> {
        let tied = || touches.pairs.iter().filter(|pair| self.tied(pair, start));
        let (mut best, mut least) = (None, (true, f64::INFINITY));
        let mut tried: BTreeSet<Vec<usize>> = failed.iter().cloned().collect();
        for pair in tied() {
            let joints = unknown_joints([pair], &start.known);
            if joints.is_empty() || !tried.insert(joints.clone()) {
                continue;
            }
            let closed = tied().filter(|pair| closes(pair, &start.known, |joint| joints.contains(&joint)));
            let closed = self.placing(closed.collect(), &start.placed);
            // All of its joints must be in what is left.
            let is_in = |joint: &usize| closed.iter().any(|pair| pair.chain.joints().any(|j| j == *joint));
            if !joints.iter().all(is_in) {
                continue;
            }
            let limbs = closed.iter().flat_map(|pair| pair.limbs).collect();
            let poses = self.free_poses(start, &joints, &limbs).iter().filter(|&&free| free).count();
            let dof: usize =
                joints.iter().map(|&joint| self.agent.creature().joints()[joint].dofs.len()).sum();
            let unknowns = joints.iter().map(|&joint| self.unknowns(joint)).sum::<usize>() + 6 * poses;
            let count: usize = closed.iter().map(|pair| pair.touches.len()).sum();
            if 3 * count < unknowns + PART_SPARE {
                continue;
            }
            let variety = if self.turn == 0 { 0.0 } else { rng.random_range(0.0..VARIETY) };
            let size = (dof + poses) as f64;
            let is_poor = count < self.evidence.enough(dof, poses, self.turn);
            // Of parts as hard, the one with more touches.
            let hardness =
                if is_poor { -(count as f64) / size.max(1.0) } else { size + variety - 3e-4 * count as f64 };
            if (is_poor, hardness) < least {
                least = (is_poor, hardness);
                best = Some((joints, closed));
            }
        }
        let (joints, closed) = best?;
        if self.frames == LimbFrames::Limb {
            return Some(Part { joints, released: Vec::new(), touches: set_of(closed) });
        }
        let mut part =
            Part { released: self.released(touches, &start.known, &joints), joints, ..Part::default() };
        part.touches = touches.filter(|pair| closes(pair, &start.known, |joint| part.moves(joint)));
        Some(part)
    }

    /// The known joints on limbs that a part is the first to touch. Nothing told so far where an untouched limb is
    /// along the axes of the joints on it: what was found there is gauge freedom, and is to be found now.
    fn released(&self, touches: &TouchSet, known: &[bool], part: &[usize]) -> Vec<usize> {
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

    /// Whether solving a pair's unknown joints would tie its limbs to all that is known of the body between.
    fn tied(&self, pair: &PairTouches, start: &Start) -> bool {
        if self.frames == LimbFrames::Joint {
            return true;
        }
        let ends = pair.limbs.iter().all(|&limb| start.placed[limb] || !self.framed(start, limb));
        // A limb in between, with its joints in the chain: one that has a frame needs one of them known.
        let is_known_at = |limb: usize| {
            let at = |&j: &usize| j + 1 == limb || self.agent.creature().joints()[j].parent == limb;
            pair.chain.joints().filter(at).any(|j| start.known[j])
        };
        let limbs = pair.chain.joints().map(|j| j + 1).chain([pair.chain.ancestor]);
        let mut inner = limbs.filter(|limb| !pair.limbs.contains(limb));
        ends && inner.all(|limb| !self.framed(start, limb) || is_known_at(limb))
    }

    /// Whether anything known refers to a limb's frame.
    fn framed(&self, start: &Start, limb: usize) -> bool {
        let mut joints = self.agent.creature().joints().iter().enumerate();
        start.placed[limb]
            || joints.any(|(j, joint)| start.known[j] && (joint.parent == limb || j + 1 == limb))
    }

    /// A limb that is not placed yet, and the pose of its own frame in the frame that it has by convention, where touches with
    /// placed limbs determine it.
    fn registration(&self, touches: &TouchSet, start: &Start, misfits: &[bool]) -> Option<(usize, Frame)> {
        let waiting = |limb: &usize| !start.placed[*limb] && !misfits[*limb];
        (0..start.placed.len()).filter(waiting).find_map(|limb| {
            let mut places: Vec<[Vector3<f64>; 2]> = Vec::new();
            for pair in &touches.pairs {
                let Some(own) = pair.limbs.iter().position(|&end| end == limb) else { continue };
                if !start.placed[pair.limbs[1 - own]] || pair.chain.joints().any(|j| !start.known[j]) {
                    continue;
                }
                places.extend(pair.touches.iter().map(|touch| {
                    let frames = touch.frames(&start.schema);
                    let there = frames[1 - own].point(&touch.ends[1 - own].position);
                    [touch.ends[own].position, frames[own].inverse_point(&there)]
                }));
            }
            register(&places).map(|frame| (limb, frame))
        })
    }

    /// Per joint, whether it is one of a part's `joints` and its limb has a frame that the part, by touches of some limbs, must find
    /// the pose of.
    fn free_poses(&self, start: &Start, joints: &[usize], touched: &BTreeSet<usize>) -> Vec<bool> {
        let has_frame = |limb: usize| touched.contains(&limb) || self.framed(start, limb);
        let is_free =
            |joint: usize| self.frames == LimbFrames::Limb && joints.contains(&joint) && has_frame(joint + 1);
        (0..start.known.len()).map(is_free).collect()
    }

    /// The joint whose limb's rotation is gauge freedom in a part: where two new branches meet in a
    /// limb without a frame, one of them may be turned at will.
    fn held_rotation(&self, start: &Start, part: &Part, poses: &[bool]) -> Option<usize> {
        part.touches.pairs.iter().find_map(|pair| {
            let meeting = pair.chain.ancestor;
            let joint = self.agent.creature().joint_of(meeting);
            let is_carried = joint.is_some_and(|joint| part.joints.contains(&joint));
            if is_carried || part.touches.limbs().contains(&meeting) || self.framed(start, meeting) {
                return None;
            }
            pair.chain.sides[0].iter().copied().find(|&joint| poses[joint])
        })
    }

    /// Solves a part from several initial guesses, all that it does not move held: the best answer, right or not, is taken into a
    /// start.
    fn solve_part(&self, part: &Part, start: &mut Start, rng: &mut ChaCha8Rng) -> f64 {
        let enough = if self.frames == LimbFrames::Limb { CERTAIN } else { ACCEPTABLE };
        let mut best = self.solve_once(part, start, rng);
        start.initial_guesses += 1;
        for _ in 1..GUESSES_PER_PART {
            if best.1 <= enough || self.deadline.has_passed() {
                break;
            }
            let trial = self.solve_once(part, start, rng);
            start.initial_guesses += 1;
            if trial.1 < best.1 {
                best = trial;
            }
        }
        let (schema, misfit) = best;
        start.schema = schema;
        part.joints.iter().for_each(|&joint| start.known[joint] = true);
        part.touches.limbs().into_iter().for_each(|limb| start.placed[limb] = true);
        misfit
    }

    /// The same from one initial guess.
    fn solve_once(&self, part: &Part, start: &Start, rng: &mut ChaCha8Rng) -> (BodySchema, f64) {
        let (creature, touches) = (self.agent.creature(), &part.touches);
        let poses = self.free_poses(start, &part.joints, &touches.limbs());
        let held = self.held_rotation(start, part, &poses);
        let with_poses = |parameters: Parameters| parameters.with_limb_poses(|joint| poses[joint], held);
        let relaxed = with_poses(self.parameters(AxisModel::Relaxed, &|joint| part.moves(joint)));
        let unit = with_poses(self.parameters(AxisModel::Unit, &|joint| part.moves(joint)));
        let mut trial = start.schema.clone();
        for &joint in &part.joints {
            self.prior.randomize_joint(creature, &mut trial, joint, rng);
            if let Some(pose) = trial.limb_poses.get_mut(joint) {
                *pose = Frame::identity();
            }
        }
        let meet = |parameters: &Parameters, schema: BodySchema, fits: usize| {
            meet(creature, touches, parameters, self.prior, schema, (fits, self.deadline))
        };
        if self.frames == LimbFrames::Limb {
            let positions = Parameters::positions(creature, AxisModel::Relaxed, |joint| part.moves(joint));
            (trial, _) = self.solve(touches, &with_poses(positions), trial, 6);
        } else {
            trial = meet(&relaxed, trial, POINT_FITS);
        }
        if self.evidence.exact() {
            (trial, _) = self.solve(touches, &relaxed, trial, 100);
        }
        trial.normalize_axes(creature);
        trial.normalize_limb_poses();
        if !matches!(self.evidence, Evidence::Surfaces(_)) {
            return self.settle(touches, &unit, trial);
        }
        let trial = meet(&unit, trial, POINT_FITS / 2);
        let miss = usual_miss(touches, &trial);
        match miss > HOPELESS {
            true => (trial, HOPELESS_MISFIT * miss),
            false => self.close_both(touches, &unit, trial),
        }
    }

    /// Fits unit axes to points, then to surfaces where these are known.
    fn settle(&self, touches: &TouchSet, parameters: &Parameters, start: BodySchema) -> (BodySchema, f64) {
        let Evidence::Surfaces(skin) = self.evidence else {
            let (schema, rms) = self.solve(touches, parameters, start, 60);
            return (schema, rms / self.evidence.acceptance());
        };
        if quantile(&gaps(skin, touches, &start), 0.8) > PART_GAP {
            return self.close_both(touches, parameters, start);
        }
        let (schema, p80_gap) = self.close(touches, parameters, start);
        (schema, p80_gap / PART_GAP)
    }

    /// Closes the gaps with relaxed axes, then on the sphere.
    fn close_both(&self, touches: &TouchSet, unit: &Parameters, start: BodySchema) -> (BodySchema, f64) {
        let relaxed = self.parameters(AxisModel::Relaxed, &|joint| unit.positions[joint].is_some());
        let (schema, _) = self.close(touches, &relaxed, start);
        let (schema, p80_gap) = self.close(touches, unit, schema);
        (schema, p80_gap / PART_GAP)
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
            (Evidence::Surfaces(_), _) | (_, AxisModel::Relaxed) => PointsMeet::Anyhow,
            _ => PointsMeet::Shaped,
        };
        let weighed;
        let touches = match self.evidence {
            Evidence::NoisyPoints(noise) => {
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
        let cost = 0.5 * count * ZERO * ZERO;
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

/// Whether a part, of the joints that it moves, closes the touches of a pair: they need it, and nothing else that is unknown.
fn closes(pair: &PairTouches, known: &[bool], moves: impl Fn(usize) -> bool) -> bool {
    let mut joints = pair.chain.joints();
    joints.clone().any(&moves) && joints.all(|joint| known[joint] || moves(joint))
}

fn set_of(pairs: Vec<&PairTouches>) -> TouchSet {
    TouchSet { pairs: pairs.into_iter().cloned().collect() }
}

/// The pose that carries the first of each two places to the second with the least sum of squares (Kabsch
/// 1976); `None` if the places do not determine it.
fn register(places: &[[Vector3<f64>; 2]]) -> Option<Frame> {
    if places.len() < REGISTERED {
        return None;
    }
    let count = places.len() as f64;
    let middles = [0, 1].map(|k| places.iter().map(|place| place[k]).sum::<Vector3<f64>>() / count);
    let spread: Matrix3<f64> = places
        .iter()
        .map(|place| (place[1] - middles[1]) * (place[0] - middles[0]).transpose() / count)
        .sum();
    let mut across = spread.svd(false, false).singular_values;
    across.as_mut_slice().sort_by(|a, b| b.total_cmp(a));
    if across[1].is_nan() || across[1] <= BREADTH * BREADTH {
        return None;
    }
    let rotation = nearest_rotation(&spread);
    Some(Frame { rotation, origin: middles[1] - rotation * middles[0] })
}
