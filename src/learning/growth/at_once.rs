//! All that is not known learned as one part, and what a touch that is only imagined would tell of it.
//!
//! Touches in which everything moves tell most: of few unknowns all are learned from little more touches than there are unknowns.
//! Random initial guesses of so many seldom find their answer. So the best answer so far is kept, right or not, and made better as
//! touches come: it goes on from where it was, and from where it was but for those joints whose touches it leaves widest
//! apart, which are drawn anew; one start begins with nothing of it. By such an answer it can be foretold what a motion will touch,
//! and what that would tell.

use nalgebra::DMatrix;
use rand::SeedableRng;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

use super::Growth;
use super::solving::{AT_ONCE, PartProblem, Solved};
use crate::deadline::in_parallel;
use crate::kinematics::limb_frames;
use crate::learning::annealing::{HOPELESS, NARROWEST, gaps, quantile, usual_miss};
use crate::learning::initial_guess::randomize_joint;
use crate::learning::prediction::{GapRow, add_row, information_inverse};
use crate::learning::touch_set::LimbTouch;
use crate::learning::{AxisModel, Parameters};
use crate::schema::BodySchema;

/// The most unknowns of a body that is learned at once.
const WIDEST: usize = 160;
/// Touches, in units of the unknowns, without anything learned from them after which no more is learned at once.
const MOST_TOUCHES: f64 = 2.5;
/// Touches from which on all is tried at once, in units of the unknowns; and from which on it is tried whenever that is due, for now
/// there may be enough of them.
const FEWEST: f64 = 0.4;
const NEARLY_ENOUGH: f64 = 0.9;
/// Where there are fewer, it is tried again after so many times as many touches.
const AGAIN: f64 = 1.15;
/// An answer whose receptors are so many times as far apart as those of the best so far is no better.
const NO_BETTER: f64 = 1.1;
/// Answers are compared by gaps in units of this, metres, and by how far apart receptors are that touched, in units of that.
const GAP: f64 = 3e-3;
const APART: f64 = 3e-2;
/// Deviation of the gap of an imagined touch, metres, and of a position that nothing tells of: together they say which directions
/// are open, not how far.
const TOLD: f64 = 1e-3;
const UNTOLD: f64 = 0.3;

/// What is believed of a whole body, and how surely.
pub struct Outlook {
    /// The schema.
    pub schema: BodySchema,
    parameters: Parameters,
    covariance: DMatrix<f64>,
}

impl Growth {
    /// Whether all that is not known is learned as one part: not where that is too much, or was in vain for long.
    pub fn learns_at_once(&self) -> bool {
        let open: Vec<usize> = (0..self.resolved.len()).filter(|&joint| !self.resolved[joint]).collect();
        let most = MOST_TOUCHES * self.width(&open).max(super::FEWEST_UNKNOWNS) as f64;
        self.width_of_all() <= WIDEST && ((self.touches.len() - self.learned_after) as f64) < most
    }

    /// Tries to learn all at once, where there are touches enough more than the last time; whether anything was learned.
    pub(super) fn grow_at_once(&mut self) -> bool {
        if !self.learns_at_once() || self.touches.len() < self.next_at_once {
            return false;
        }
        let part = self.all_lacking();
        let Some(problem) = self.part_problem(&part) else { return false };
        let share = problem.numbers.len() as f64 / problem.unit.len() as f64;
        if share < FEWEST {
            return false;
        }
        let known = self.known();
        let solved = self.improved(&problem);
        let grown = self.is_answer(&problem, &solved) && self.known() > known;
        if !grown {
            let more = if share < NEARLY_ENOUGH { AGAIN } else { 1.0 };
            self.next_at_once = (more * self.touches.len() as f64) as usize;
        }
        grown
    }

    /// A better answer for a part than the best so far: from where that was, or from there but for some joints. Receptors that meet
    /// lead to where all of them do; surfaces that close keep what of an answer is right already.
    fn improved(&mut self, problem: &PartProblem) -> Solved {
        self.solves += 1;
        let mut best = self.gone_on(problem, problem.base.clone());
        if !best.closes_all() && !self.deadline.has_passed() {
            let (mut left, blame) = (self.apart(problem, &best.schema), self.blame(problem, &best.schema));
            let hopeless = HOPELESS.min(NO_BETTER * usual_miss(&problem.touches, &best.schema));
            let made: Vec<Solved> = in_parallel((0..2 * AT_ONCE).collect(), |number| {
                let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
                rng.set_stream((self.solves << 16) + number as u64);
                let mut redrawn = |many| self.redrawn(problem, &best.schema, &blame, many, &mut rng);
                match number.checked_sub(AT_ONCE) {
                    None => self.start_from(problem, redrawn(number), number, hopeless),
                    // What the best answer has wrong may be all of it.
                    Some(beyond) if beyond + 1 == AT_ONCE => self.start(problem, number, hopeless),
                    Some(beyond) => self.gone_on(problem, redrawn(beyond + 1)),
                }
            });
            self.starts += made.len();
            for other in made {
                let of_other = self.apart(problem, &other.schema);
                // One that closes all may have receptors a little farther apart.
                let [closes, before] = [&other, &best].map(Solved::closes_all);
                if closes && !before || closes == before && of_other < left {
                    (left, best) = (of_other, other);
                }
            }
        }
        self.guess = best.schema.clone();
        best.schema = self.carried(problem, &best.schema);
        best
    }

    /// An answer with some joints of a part drawn anew, those most likely that are to blame most; their positions stay.
    fn redrawn(
        &self,
        problem: &PartProblem,
        schema: &BodySchema,
        blame: &[f64],
        many: usize,
        rng: &mut ChaCha8Rng,
    ) -> BodySchema {
        let mut redrawn = schema.clone();
        let joints = &problem.part.joints;
        for _ in 0..many {
            let Ok(&joint) = joints.choose_weighted(rng, |&joint| blame[joint]) else { break };
            randomize_joint(self.agent.creature(), &mut redrawn, joint, rng);
            redrawn.positions[joint] = schema.positions[joint];
        }
        redrawn
    }

    /// How far apart a schema leaves the touches that a part is solved by: the gap of the surfaces, and how far receptors are from each
    /// other. What is false or far off counts little more than others.
    fn apart(&self, problem: &PartProblem, schema: &BodySchema) -> f64 {
        let of = |&number: &usize| {
            let touch = &self.touches[number].told.prepared;
            let gap = touch.gap(self.agent.skin(), schema).distance;
            (gap / GAP).powi(2).ln_1p() + (touch.miss(schema).norm() / APART).powi(2).ln_1p()
        };
        problem.solved_by.iter().map(of).sum()
    }

    /// Per joint, how wide a schema leaves the gaps of a part's touches in which it moved, on average, beside half of all gaps.
    fn blame(&self, problem: &PartProblem, schema: &BodySchema) -> Vec<f64> {
        let skin = self.agent.skin();
        let usual = quantile(&gaps(skin, &problem.touches, schema), 0.5).clamp(NARROWEST, GAP);
        let mut blame = vec![(0.0, f64::MIN_POSITIVE); self.resolved.len()];
        for touch in problem.solved_by.iter().map(|&number| &self.touches[number].told) {
            let gap = touch.prepared.gap(skin, schema).distance;
            for &joint in &touch.moving {
                let (sum, count) = &mut blame[joint];
                *sum += (gap / usual).powi(2).ln_1p();
                *count += 1.0;
            }
        }
        blame.into_iter().map(|(sum, count)| sum / count).collect()
    }

    /// What is believed now of the whole body, known or guessed; none where rounding forbids.
    pub fn outlook(&self) -> Option<Outlook> {
        let (creature, schema) = (self.agent.creature(), self.believed());
        let parameters = Parameters::of(creature, AxisModel::Unit, |_| true, |_, _| true);
        let mut information = DMatrix::zeros(parameters.len(), parameters.len());
        for offset in parameters.positions.iter().flatten() {
            (0..3).for_each(|i| information[(offset + i, offset + i)] = UNTOLD.powi(-2));
        }
        let mut row = GapRow::default();
        for touch in self.touches.iter().filter(|touch| !touch.spare) {
            row.set(self.agent.skin(), &parameters, &schema, &touch.told.prepared);
            add_row(&mut information, &row.entries, TOLD.powi(-2));
        }
        let covariance = information_inverse(information, &parameters)?;
        Some(Outlook { schema, parameters, covariance })
    }

    /// How much it would tell if two limbs touched in a posture where they are nearest to each other: the variance of the gap
    /// that is expected of it, m².
    pub fn gain(&self, outlook: &Outlook, [a, b]: [usize; 2], posture: &[f64]) -> f64 {
        let (creature, skin) = (self.agent.creature(), self.agent.skin());
        let frames = limb_frames(creature, &outlook.schema, posture);
        let place = |limb: usize, receptor: usize| frames[limb].point(&skin.receptors[receptor].position);
        let pairs = skin.receptors_on(a).flat_map(|p| skin.receptors_on(b).map(move |q| [p, q]));
        let apart = |&[p, q]: &[usize; 2]| (place(a, p) - place(b, q)).norm_squared();
        let nearest = pairs.map(|pair| (apart(&pair), pair)).min_by(|one, other| one.0.total_cmp(&other.0));
        let Some((_, nearest)) = nearest else { return 0.0 };
        let (_, touch) = LimbTouch::of_receptors(skin, nearest, posture).prepare(creature);
        let mut row = GapRow::default();
        row.set(skin, &outlook.parameters, &outlook.schema, &touch);
        row.variance(&outlook.covariance)
    }
}
