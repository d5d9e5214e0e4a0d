//! From a random initial guess to the optimum where limbs have frames of their own.
//!
//! The tree is grown as in [`growing`](super::growing), from exact points alone, but more is unknown: besides
//! its joints a new limb brings its own pose on its joint. What makes this work from random initial guesses:
//!
//! 1. With rotations `Q` relaxed to any matrix a miss is linear in all positions and poses once the axes are
//!    given. So an initial guess is random axes and nothing else: the rest is solved for at once.
//! 2. A limb that a chain passed through before it was touched itself has a frame by convention. Its first
//!    touches with a limb whose place is known tell its own frame in closed form (Kabsch 1976).
//! 3. A pair of limbs is taken only when what it adds is tied to all that is known: both limbs are placed
//!    already or new, and no limb in between has a frame that nothing in the pair refers to.
//!
//! A limb is *placed* once touches of its own tell its frame, and *framed* once anything refers to its frame.

use nalgebra::{Matrix3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::creature::Creature;
use crate::deadline::Deadline;
use crate::geometry::Frame;
use crate::learning::growing::{EXACT, Start};
use crate::learning::initial_guess::randomize_joint;
use crate::learning::least_squares::{Stopping, levenberg_marquardt};
use crate::learning::observation::PointsMeet;
use crate::learning::touch_set::{PairTouches, TouchProblem, TouchSet};
use crate::learning::{AxisModel, Parameters};
use crate::schema::{BodySchema, nearest_rotation};

/// Initial guesses tried for one part of the body.
const GUESSES_PER_PART: usize = 16;
/// Parts that fail before a start grows no more, …
const MOST_FAILED: usize = 4;
/// … and where it knows nothing yet: long chains alone make none to grow on.
const HOPELESS_PARTS: usize = 2;
/// Misfit of a part below which no better initial guess is looked for: exact points leave far less.
const CERTAIN: f64 = 1e-2;
/// Equations that a part has to spare before it is solved, where there is a choice …
const SPARE: usize = 18;
/// … and at the least.
const LEAST_SPARE: usize = 9;
/// Touches that tell a limb's frame at the least.
const REGISTERED: usize = 5;
/// How far they must reach across the line that fits them best, metres (root mean square).
const BREADTH: f64 = 2e-3;
/// Root mean square of whitened misses that is as good as zero.
const ZERO: f64 = 1e-5;

/// The ground on which starts are made.
pub struct LimbNursery<'a> {
    /// The creature.
    pub creature: &'a Creature,
    /// The touches to explain.
    pub touches: &'a TouchSet,
    /// The number of the start: the first takes the easiest part each time, later ones vary.
    pub turn: usize,
    /// When a start ends with what it has.
    pub deadline: Deadline,
}

/// What is known on the way.
#[derive(Clone)]
struct Growth {
    schema: BodySchema,
    /// Per joint.
    known: Vec<bool>,
    /// Per limb.
    placed: Vec<bool>,
}

/// A part of the body that can be solved next.
struct LimbPart {
    /// Its unknown joints.
    joints: Vec<usize>,
    /// The touches that it closes.
    touches: TouchSet,
}

impl LimbNursery<'_> {
    /// One start from a random initial guess.
    pub fn start(&self, rng: &mut ChaCha8Rng) -> Start {
        let (joints, limbs) = (self.creature.joints().len(), self.creature.limbs().len());
        let mut schema = BodySchema::zero(self.creature).with_limb_poses();
        (0..joints).for_each(|joint| randomize_joint(self.creature, &mut schema, joint, rng));
        let mut growth = Growth { schema, known: vec![false; joints], placed: vec![false; limbs] };
        let mut initial_guesses = 0;
        // Limbs and parts that no way was found to fit.
        let mut misfits = vec![false; limbs];
        let mut failed: Vec<Vec<usize>> = Vec::new();
        loop {
            if let Some((limb, frame)) = self.registration(&growth, &misfits) {
                let mut trial = growth.clone();
                trial.schema.reframe(self.creature, limb, &frame);
                trial.placed[limb] = true;
                match self.release(trial) {
                    Some(settled) => growth = settled,
                    None => misfits[limb] = true,
                }
                continue;
            }
            let Some(part) = self.next_part(&growth, &failed, rng) else { break };
            let solved = self.solve_part(&growth, &part, rng, &mut initial_guesses);
            match solved.and_then(|solved| self.release(solved)) {
                Some(settled) => growth = settled,
                None => failed.push(part.joints),
            }
            let most = if growth.known.contains(&true) { MOST_FAILED } else { HOPELESS_PARTS };
            if failed.len() >= most || self.deadline.has_passed() {
                break;
            }
        }
        let accepted = growth.known.contains(&true);
        let Growth { schema, known, placed } = growth;
        Start { schema, known, placed, accepted, initial_guesses }
    }

    /// How many joints and limbs have touches enough to be known.
    pub fn solvable(&self) -> usize {
        let touches = self.telling(self.touches, &vec![false; self.creature.limbs().len()]);
        touches.joints().len() + touches.limbs().len()
    }

    /// The touches without those of limbs, not placed, that have too few of them to be.
    fn telling(&self, touches: &TouchSet, placed: &[bool]) -> TouchSet {
        let mut left = touches.clone();
        loop {
            let mut counts = vec![0; placed.len()];
            for pair in &left.pairs {
                pair.limbs.iter().for_each(|&limb| counts[limb] += pair.touches.len());
            }
            let before = left.pairs.len();
            left.pairs
                .retain(|pair| pair.limbs.iter().all(|&limb| placed[limb] || counts[limb] >= REGISTERED));
            if left.pairs.len() == before {
                return left;
            }
        }
    }

    /// Whether anything known refers to a limb's frame.
    fn framed(&self, growth: &Growth, limb: usize) -> bool {
        let joints = self.creature.joints().iter().enumerate();
        growth.placed[limb]
            || joints.clone().any(|(j, joint)| growth.known[j] && (joint.parent == limb || j + 1 == limb))
    }

    /// A limb that is framed and not placed yet, and the pose of its own frame in the frame that it has by
    /// convention, where touches with placed limbs tell it.
    fn registration(&self, growth: &Growth, misfits: &[bool]) -> Option<(usize, Frame)> {
        let waiting = |limb: usize| !growth.placed[limb] && !misfits[limb];
        (0..growth.placed.len()).filter(|&limb| waiting(limb)).find_map(|limb| {
            let mut places: Vec<[Vector3<f64>; 2]> = Vec::new();
            for pair in &self.touches.pairs {
                let Some(own) = pair.limbs.iter().position(|&end| end == limb) else { continue };
                if !growth.placed[pair.limbs[1 - own]] || pair.chain.joints().any(|j| !growth.known[j]) {
                    continue;
                }
                places.extend(pair.touches.iter().map(|touch| {
                    let frames = touch.frames(&growth.schema);
                    let there = frames[1 - own].point(&touch.ends[1 - own].position);
                    [touch.ends[own].position, frames[own].inverse_point(&there)]
                }));
            }
            register(&places).map(|frame| (limb, frame))
        })
    }

    /// The part to solve next; none where no touch brings a new joint that can be solved.
    fn next_part(&self, growth: &Growth, failed: &[Vec<usize>], rng: &mut ChaCha8Rng) -> Option<LimbPart> {
        let framed: Vec<bool> = (0..growth.placed.len()).map(|limb| self.framed(growth, limb)).collect();
        let open: Vec<(&PairTouches, Vec<usize>)> = self
            .touches
            .pairs
            .iter()
            .filter(|pair| self.tied(pair, growth, &framed))
            .map(|pair| {
                let mut unknown: Vec<usize> = pair.chain.joints().filter(|&j| !growth.known[j]).collect();
                unknown.sort_unstable();
                (pair, unknown)
            })
            .filter(|(_, unknown)| !unknown.is_empty())
            .collect();
        let mut best: Option<(bool, f64, LimbPart)> = None;
        let mut tried: Vec<&Vec<usize>> = failed.iter().collect();
        for (_, joints) in &open {
            if tried.contains(&joints) {
                continue;
            }
            tried.push(joints);
            let within = |other: &[usize]| other.iter().all(|joint| joints.contains(joint));
            let closed = open.iter().filter(|(_, other)| within(other)).map(|(pair, _)| (*pair).clone());
            let closed = TouchSet { pairs: closed.collect() };
            let part = LimbPart { joints: joints.clone(), touches: self.telling(&closed, &growth.placed) };
            // All of its joints must be in what is left.
            if !joints.iter().all(|joint| part.touches.joints().contains(joint)) {
                continue;
            }
            let poses = self.free_poses(growth, &part).iter().filter(|&&free| free).count();
            let dof: usize = joints.iter().map(|&joint| self.creature.joints()[joint].dofs.len()).sum();
            let (equations, unknowns) = (3 * part.touches.len(), 3 * joints.len() + 2 * dof + 6 * poses);
            if equations < unknowns + LEAST_SPARE {
                continue;
            }
            let poor = equations < unknowns + 6 * poses + SPARE;
            let variety = if self.turn == 0 { 0.0 } else { rng.random_range(0.0..3.0) };
            // Of parts as hard, the one with more touches.
            let hardness = (dof + poses) as f64 + variety - 1e-4 * equations as f64;
            if best.as_ref().is_none_or(|(other, least, _)| (poor, hardness) < (*other, *least)) {
                best = Some((poor, hardness, part));
            }
        }
        best.map(|(_, _, part)| part)
    }

    /// Whether solving a pair's unknown joints would tie its limbs to all that is known of the body between.
    fn tied(&self, pair: &PairTouches, growth: &Growth, framed: &[bool]) -> bool {
        let ends = pair.limbs.iter().all(|&limb| growth.placed[limb] || !framed[limb]);
        // A limb in between, with its joints in the chain: one that has a frame needs one of them known.
        let inner = |limb: usize| !pair.limbs.contains(&limb);
        let unknown_at = |limb: usize| {
            let at = |&j: &usize| j + 1 == limb || self.creature.joints()[j].parent == limb;
            pair.chain.joints().filter(at).all(|j| !growth.known[j])
        };
        let limbs = pair.chain.joints().map(|j| j + 1).chain([pair.chain.ancestor]);
        ends && limbs.filter(|&limb| inner(limb) && framed[limb]).all(|limb| !unknown_at(limb))
    }

    /// Per joint, whether it belongs to the part and its limb has a frame that the part must find the pose of.
    fn free_poses(&self, growth: &Growth, part: &LimbPart) -> Vec<bool> {
        let touched = |limb: usize| part.touches.pairs.iter().any(|pair| pair.limbs.contains(&limb));
        let free = |j: usize| part.joints.contains(&j) && (touched(j + 1) || self.framed(growth, j + 1));
        (0..growth.known.len()).map(free).collect()
    }

    /// The joint whose limb's rotation is gauge freedom in a part: where two new branches meet in a
    /// limb without a frame, one of them may be turned at will.
    fn held_rotation(&self, growth: &Growth, part: &LimbPart, free: &[bool]) -> Option<usize> {
        part.touches.pairs.iter().find_map(|pair| {
            let meeting = pair.chain.ancestor;
            let carried = self.creature.joint_of(meeting).is_some_and(|joint| part.joints.contains(&joint));
            let touched = part.touches.pairs.iter().any(|other| other.limbs.contains(&meeting));
            if carried || touched || self.framed(growth, meeting) {
                return None;
            }
            pair.chain.sides[0].iter().copied().find(|&joint| free[joint])
        })
    }

    /// Solves the joints and limbs of a part by the touches that it closes, all others held; none where no
    /// initial guess leads to an answer.
    fn solve_part(
        &self,
        growth: &Growth,
        part: &LimbPart,
        rng: &mut ChaCha8Rng,
        initial_guesses: &mut usize,
    ) -> Option<Growth> {
        let in_part = |joint: usize| part.joints.contains(&joint);
        let free = self.free_poses(growth, part);
        let held = self.held_rotation(growth, part, &free);
        let with_poses = |parameters: Parameters| parameters.with_limb_poses(|joint| free[joint], held);
        let linear = with_poses(Parameters::positions(self.creature, AxisModel::Relaxed, in_part));
        let relaxed = with_poses(Parameters::new(self.creature, AxisModel::Relaxed, in_part));
        let unit = with_poses(Parameters::new(self.creature, AxisModel::Unit, in_part));
        // Three equations a touch: three times as many as unknowns tell a wrong answer from a right one.
        let few = thinned(&part.touches, relaxed.len());
        let mut best = (growth.schema.clone(), EXACT);
        for _ in 0..GUESSES_PER_PART {
            *initial_guesses += 1;
            let mut trial = growth.schema.clone();
            for &joint in &part.joints {
                randomize_joint(self.creature, &mut trial, joint, rng);
                trial.limb_poses[joint] = Frame::identity();
            }
            let (trial, _) = self.solve(&few, &linear, trial, 6);
            let (mut trial, _) = self.solve(&few, &relaxed, trial, 100);
            trial.normalize_axes(self.creature);
            trial.normalize_limb_poses();
            let (trial, misfit) = self.solve(&few, &unit, trial, 60);
            if misfit > EXACT {
                continue;
            }
            let (schema, misfit) = self.solve(&part.touches, &unit, trial, 60);
            if misfit <= best.1 {
                best = (schema, misfit);
            }
            if best.1 <= CERTAIN {
                break;
            }
        }
        let (schema, misfit) = best;
        if misfit >= EXACT {
            return None;
        }
        let mut grown = Growth { schema, ..growth.clone() };
        part.joints.iter().for_each(|&joint| grown.known[joint] = true);
        part.touches.limbs().into_iter().for_each(|limb| grown.placed[limb] = true);
        Some(grown)
    }

    /// Fits all that is known to all touches that are in reach; none where that leaves too much.
    fn release(&self, growth: Growth) -> Option<Growth> {
        let used = self.touches.filter(|pair| {
            pair.limbs.iter().all(|&limb| growth.placed[limb]) && pair.chain.joints().all(|j| growth.known[j])
        });
        let parameters = Parameters::new(self.creature, AxisModel::Unit, |joint| growth.known[joint])
            .with_limb_poses(|joint| growth.known[joint] && growth.placed[joint + 1], None);
        let (schema, misfit) = self.solve(&used, &parameters, growth.schema, 60);
        (misfit <= EXACT).then_some(Growth { schema, ..growth })
    }

    /// One least-squares solve; the schema and the root mean square of its whitened misses.
    fn solve(
        &self,
        touches: &TouchSet,
        parameters: &Parameters,
        start: BodySchema,
        iterations: usize,
    ) -> (BodySchema, f64) {
        let count = (3 * touches.len()).max(1) as f64;
        let mut problem = TouchProblem::new(self.creature, touches, parameters, PointsMeet::Anyhow);
        let stopping = Stopping {
            iterations,
            relative_cost: 1e-4,
            cost: 0.5 * count * ZERO * ZERO,
            deadline: self.deadline,
        };
        let solution = levenberg_marquardt(&mut problem, start, stopping);
        (solution.state, (2.0 * solution.cost / count).sqrt())
    }
}

/// At most so many touches, taken evenly from all.
fn thinned(touches: &TouchSet, most: usize) -> TouchSet {
    let (all, mut seen) = (touches.len().max(1), 0);
    let mut few = touches.clone();
    for pair in &mut few.pairs {
        pair.touches.retain(|_| {
            seen += 1;
            seen * most / all > (seen - 1) * most / all
        });
    }
    few
}

/// The pose that carries the first of each two places to the second with the least sum of squares (Kabsch
/// 1976); none where the places do not tell it.
fn register(places: &[[Vector3<f64>; 2]]) -> Option<Frame> {
    if places.len() < REGISTERED {
        return None;
    }
    let count = places.len() as f64;
    let middle = |k: usize| places.iter().map(|place| place[k]).sum::<Vector3<f64>>() / count;
    let middles = [middle(0), middle(1)];
    let mut spread = Matrix3::zeros();
    for place in places {
        spread += (place[1] - middles[1]) * (place[0] - middles[0]).transpose() / count;
    }
    let mut across = spread.svd(false, false).singular_values;
    across.as_mut_slice().sort_by(|a, b| b.total_cmp(a));
    if across[1].is_nan() || across[1] <= BREADTH * BREADTH {
        return None;
    }
    let rotation = nearest_rotation(&spread);
    Some(Frame { rotation, origin: middles[1] - rotation * middles[0] })
}
