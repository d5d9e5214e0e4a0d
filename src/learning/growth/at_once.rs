//! All that is not known learned as one part, and what a touch that is only imagined would tell of it.
//!
//! Touches in which everything moves tell most: of few unknowns all are learned from little more touches than there are unknowns.
//! Random initial guesses of so many seldom find their answer. So the best answer so far is kept, right or not, and made better as
//! touches come: it goes on from where it was, and from where it was but for those joints whose touches it leaves farthest
//! apart, which are drawn anew. By such an answer it can be foretold what a motion will touch, and what that would tell.

use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::Growth;
use super::solving::{AT_ONCE, PartProblem, Solved};
use crate::deadline::in_parallel;
use crate::kinematics::limb_frames;
use crate::learning::annealing::{HOPELESS, usual_miss};
use crate::learning::initial_guess::randomize_joint;
use crate::learning::prediction::{GapRow, add_row, information_inverse};
use crate::learning::surface_gap::SurfaceGap;
use crate::learning::touch_set::LimbTouch;
use crate::learning::{AxisModel, Parameters};
use crate::schema::BodySchema;

/// The most unknowns of a body that is learned at once.
const WIDEST: usize = 160;
/// Touches, in units of the unknowns, without anything learned from them after which no more is learned at once.
const MOST_TOUCHES: f64 = 2.5;
/// Touches from which on all is tried at once, in units of the unknowns; and from which on much is tried, for now there may be
/// enough of them.
const FEWEST: f64 = 0.4;
const NEARLY_ENOUGH: f64 = 0.9;
/// Touches more, as a share of all, after which it is tried again.
const AGAIN: f64 = 0.15;
/// Starts beside the one that goes on: few, and much.
const FEW_STARTS: usize = AT_ONCE;
const MANY_STARTS: usize = 2 * AT_ONCE;
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

    /// Tries to learn all at once, if there are touches more than the last time; whether anything was learned.
    pub(super) fn grow_at_once(&mut self) -> bool {
        if self.touches.len() < self.next_at_once {
            return false;
        }
        let part = self.all_lacking();
        let Some(problem) = self.part_problem(&part) else { return false };
        let share = problem.numbers.len() as f64 / problem.unit.len() as f64;
        if share < FEWEST {
            return false;
        }
        let known = self.known();
        let starts = if share < NEARLY_ENOUGH { FEW_STARTS } else { MANY_STARTS };
        let solved = self.improved(&problem, starts);
        let grown = solved.is_some_and(|solved| self.is_answer(&problem, &solved)) && self.known() > known;
        if !grown {
            let more = if share < NEARLY_ENOUGH { AGAIN * self.touches.len() as f64 } else { 0.0 };
            self.next_at_once = self.touches.len() + more as usize;
        }
        grown
    }

    /// A better answer for a part than the best so far.
    fn improved(&mut self, problem: &PartProblem, starts: usize) -> Option<Solved> {
        self.solves += 1;
        let from = self.guess_for(problem);
        let mut best = self.gone_on(problem, from);
        for wave in (0..starts).collect::<Vec<usize>>().chunks(AT_ONCE) {
            if best.closes_all() || self.deadline.has_passed() {
                break;
            }
            let blame = self.blame(problem, &best.schema);
            let hopeless = NO_BETTER * usual_miss(&problem.touches, &best.schema);
            let made: Vec<Solved> = in_parallel(wave.to_vec(), |number| {
                let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
                rng.set_stream((self.solves << 16) + number as u64);
                let redrawn = self.redrawn(problem, &best.schema, &blame, number % AT_ONCE, &mut rng);
                self.start_from(problem, redrawn, number, hopeless.min(HOPELESS))
            });
            self.starts += made.len();
            let misfit = |solved: &Solved| self.misfit(problem, &solved.schema);
            best = made.into_iter().chain([best]).min_by(|a, b| misfit(a).total_cmp(&misfit(b)))?;
        }
        self.keep_guess(problem, &best.schema);
        best.schema = self.carried(problem, &best.schema);
        Some(best)
    }

    /// What is believed of a part, known or guessed.
    fn guess_for(&self, problem: &PartProblem) -> BodySchema {
        let mut from = problem.base.clone();
        for &joint in &problem.part.joints {
            from.positions[joint] = self.guess.positions[joint];
            for dof in self.agent.creature().joints()[joint].dof_indices() {
                from.axes[dof] = self.guess.axes[dof];
            }
        }
        from
    }

    fn keep_guess(&mut self, problem: &PartProblem, schema: &BodySchema) {
        for &joint in &problem.part.joints {
            self.guess.positions[joint] = schema.positions[joint];
            for dof in self.agent.creature().joints()[joint].dof_indices() {
                self.guess.axes[dof] = schema.axes[dof];
            }
        }
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
            let mut left = rng.random::<f64>() * joints.iter().map(|&joint| blame[joint]).sum::<f64>();
            let drawn = joints.iter().find(|&&joint| {
                left -= blame[joint];
                left <= 0.0
            });
            let Some(&joint) = drawn.or(joints.first()) else { break };
            randomize_joint(self.agent.creature(), &mut redrawn, joint, rng);
            redrawn.positions[joint] = schema.positions[joint];
        }
        redrawn
    }

    /// How far apart a schema leaves a touch: the gap of the surfaces, and how far receptors are from each other, metres.
    fn apart(&self, number: usize, schema: &BodySchema) -> [f64; 2] {
        let touch = &self.touches[number].told.prepared;
        let model = SurfaceGap::new(self.agent.skin(), 1.0);
        [model.gap(&touch.ends, &touch.frames(schema)).distance.abs(), touch.miss(schema).norm()]
    }

    /// How badly a schema explains the touches of a part: false ones and those that are far off count little more than others.
    fn misfit(&self, problem: &PartProblem, schema: &BodySchema) -> f64 {
        let of = |&number: &usize| {
            let [gap, apart] = self.apart(number, schema);
            (gap / GAP).powi(2).ln_1p() + (apart / APART).powi(2).ln_1p()
        };
        problem.solved_by.iter().map(of).sum()
    }

    /// Per joint, how far apart a schema leaves the touches of a part in which it moved, on average, in units of [`GAP`].
    fn blame(&self, problem: &PartProblem, schema: &BodySchema) -> Vec<f64> {
        let joints = self.resolved.len();
        let (mut sum, mut count) = (vec![0.0; joints], vec![f64::MIN_POSITIVE; joints]);
        for &number in &problem.solved_by {
            let [gap, apart] = self.apart(number, schema);
            let far = (gap / GAP).ln_1p() + (apart / APART).ln_1p();
            for &joint in &self.touches[number].told.moving {
                sum[joint] += far;
                count[joint] += 1.0;
            }
        }
        sum.iter().zip(&count).map(|(sum, count)| sum / count).collect()
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
    pub fn gain(&self, outlook: &Outlook, limbs: [usize; 2], posture: &[f64]) -> f64 {
        let (creature, skin) = (self.agent.creature(), self.agent.skin());
        let frames = limb_frames(creature, &outlook.schema, posture);
        let [first, second] = limbs.map(|limb| {
            let on_limb =
                skin.receptors.iter().enumerate().filter(move |(_, receptor)| receptor.limb == limb);
            on_limb
                .map(|(number, receptor)| (number, frames[limb].point(&receptor.position)))
                .collect::<Vec<_>>()
        });
        let pairs = first.iter().flat_map(|a| second.iter().map(move |b| (a, b)));
        let apart = |((_, a), (_, b)): &(&(usize, _), &(usize, _))| -> f64 {
            let (a, b): (&nalgebra::Vector3<f64>, &nalgebra::Vector3<f64>) = (a, b);
            (a - b).norm_squared()
        };
        let Some(((a, _), (b, _))) = pairs.min_by(|x, y| apart(x).total_cmp(&apart(y))) else { return 0.0 };
        let (_, touch) = LimbTouch::of_receptors(skin, [*a, *b], posture).prepare(creature);
        let mut row = GapRow::default();
        row.set(skin, &outlook.parameters, &outlook.schema, &touch);
        row.variance(&outlook.covariance)
    }
}
