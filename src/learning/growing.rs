//! From a random onset to the optimum: growing the tree limb pair by limb pair.
//!
//! Solving all joints at once from random axes ends in a wrong minimum more often than not. A pair of
//! limbs with few joints between them is easy; with those joints known, another pair has few unknown
//! ones left. So: take the pair that brings the fewest unknown degrees of freedom and has touches enough,
//! solve the new part with relaxed axes from a few onsets, polish it on the sphere, accept it on its
//! residual; release everything known so far on all touches used; repeat.

use rand_chacha::ChaCha8Rng;

use crate::creature::Creature;
use crate::learning::least_squares::{Stopping, levenberg_marquardt};
use crate::learning::observation::ObservationModel;
use crate::learning::onset::randomize_joint;
use crate::learning::split::SplitCreature;
use crate::learning::touch_set::{PairTouches, TouchProblem, TouchSet};
use crate::learning::{AxisModel, Parameters};
use crate::schema::BodySchema;

/// Onsets tried for one part of the body before the whole start is given up.
const ONSETS_PER_PART: usize = 6;

/// Touches a part needs: this many, and as many again per unknown degree of freedom.
const TOUCHES_PER_PART: usize = 8;
const TOUCHES_PER_DOF: usize = 2;

/// How a start goes about the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Route {
    /// Limb pair by limb pair.
    Grown,
    /// All joints at once.
    Whole,
}

/// What one start came to.
pub struct Start {
    /// The schema it reached.
    pub schema: BodySchema,
    /// Per joint, whether any touch with it entered the fit.
    pub known: Vec<bool>,
    /// Root mean square of the whitened residuals over the touches used.
    pub rms: f64,
    /// Whether every part was accepted.
    pub accepted: bool,
}

/// The ground on which starts are made.
pub struct Nursery<'a, M> {
    /// The creature.
    pub creature: &'a Creature,
    /// The creature with its joints split.
    pub split: &'a SplitCreature,
    /// The touches to explain, for the creature …
    pub touches: &'a TouchSet,
    /// … and for its split counterpart, in the same order.
    pub split_touches: &'a TouchSet,
    /// What the touches say.
    pub model: M,
    /// The greatest root mean square of whitened residuals that a right answer can have.
    pub acceptance: f64,
}

impl<M: ObservationModel + Copy> Nursery<'_, M> {
    /// One start from a random onset.
    pub fn start(&self, route: Route, rng: &mut ChaCha8Rng) -> Start {
        let joints = self.creature.joints().len();
        let mut schema = BodySchema::zero(self.creature);
        for joint in 0..joints {
            randomize_joint(self.creature, &mut schema, joint, rng);
        }
        let mut known = vec![false; joints];
        let mut rms = f64::INFINITY;
        let mut accepted = true;
        while let Some(part) = self.next_part(route, &known) {
            let (solved, part_rms) = self.solve_part(&schema, &part, &known, rng);
            schema = solved;
            accepted &= part_rms <= self.acceptance;
            part.iter().for_each(|&joint| known[joint] = true);
            let used = self.touches.filter(|pair| pair.chain.joints().all(|joint| known[joint]));
            let parameters = Parameters::new(self.creature, AxisModel::Unit, |joint| known[joint]);
            (schema, rms) = self.solve(self.creature, &used, &parameters, schema, 30);
            accepted &= rms <= self.acceptance;
            if !accepted {
                break;
            }
        }
        Start { schema, known, rms, accepted }
    }

    /// The unknown joints of the part to solve next; none when no touch brings a new joint.
    fn next_part(&self, route: Route, known: &[bool]) -> Option<Vec<usize>> {
        let unknown_of = |pair: &PairTouches| -> Vec<usize> {
            let mut unknown: Vec<usize> = pair.chain.joints().filter(|&j| !known[j]).collect();
            unknown.sort_unstable();
            unknown
        };
        let parts: Vec<(Vec<usize>, usize)> =
            self.touches.pairs.iter().map(|pair| (unknown_of(pair), pair.touches.len())).collect();
        if route == Route::Whole {
            let mut all: Vec<usize> = parts.into_iter().flat_map(|(part, _)| part).collect();
            all.sort_unstable();
            all.dedup();
            return (!all.is_empty()).then_some(all);
        }
        let dof = |part: &[usize]| -> usize {
            part.iter().map(|&j| self.creature.joints()[j].dofs.len()).sum()
        };
        let touches_of = |part: &[usize]| -> usize {
            let closed = parts.iter().filter(|(other, _)| {
                !other.is_empty() && other.iter().all(|joint| part.contains(joint))
            });
            closed.map(|(_, touches)| touches).sum()
        };
        let candidates = || parts.iter().map(|(part, _)| part).filter(|part| !part.is_empty());
        let rich = candidates()
            .filter(|part| touches_of(part) >= TOUCHES_PER_PART + TOUCHES_PER_DOF * dof(part))
            .min_by_key(|part| (dof(part), std::cmp::Reverse(touches_of(part))));
        // Where no pair has touches enough, take the one that has the most for its size.
        let poor = || candidates().max_by_key(|part| (1000 * touches_of(part)) / dof(part).max(1));
        rich.or_else(poor).cloned()
    }

    /// Solves the joints of `part` from several onsets, all others held; the best schema and its residual.
    fn solve_part(
        &self,
        schema: &BodySchema,
        part: &[usize],
        known: &[bool],
        rng: &mut ChaCha8Rng,
    ) -> (BodySchema, f64) {
        let in_part = |joint: usize| part.contains(&joint);
        let split_joint = |joint: usize| self.split.joint_of[joint];
        // The pairs that the part closes: they need it, and nothing else that is unknown.
        let closed = |touches: &TouchSet, joint_of: &dyn Fn(usize) -> usize| {
            touches.filter(|pair| {
                let mut joints = pair.chain.joints().map(joint_of);
                joints.clone().any(in_part) && joints.all(|joint| known[joint] || in_part(joint))
            })
        };
        let touches = closed(self.touches, &|joint| joint);
        let split_touches = closed(self.split_touches, &split_joint);

        let relaxed = Parameters::new(self.creature, AxisModel::Relaxed, in_part);
        let unit = Parameters::new(self.creature, AxisModel::Unit, in_part);
        let split_relaxed =
            Parameters::new(&self.split.creature, AxisModel::Relaxed, |joint| in_part(split_joint(joint)));
        let mut best: Option<(BodySchema, f64)> = None;
        for onset in 0..ONSETS_PER_PART {
            let mut trial = schema.clone();
            part.iter().for_each(|&joint| randomize_joint(self.creature, &mut trial, joint, rng));
            if onset % 2 == 0 {
                let unfolded = self.split.unfold(&trial);
                let (solved, _) =
                    self.solve(&self.split.creature, &split_touches, &split_relaxed, unfolded, 100);
                trial = self.split.fold(&solved);
            }
            (trial, _) = self.solve(self.creature, &touches, &relaxed, trial, 100);
            trial.normalize_axes(self.creature);
            let (trial, rms) = self.solve(self.creature, &touches, &unit, trial, 60);
            if best.as_ref().is_none_or(|(_, least)| rms < *least) {
                best = Some((trial, rms));
            }
            if rms <= self.acceptance {
                break;
            }
        }
        best.expect("at least one onset is tried")
    }

    /// One least-squares solve; the schema and the root mean square of its whitened residuals.
    fn solve(
        &self,
        creature: &Creature,
        touches: &TouchSet,
        parameters: &Parameters,
        start: BodySchema,
        iterations: usize,
    ) -> (BodySchema, f64) {
        let count = (3 * touches.len()).max(1) as f64;
        let mut problem = TouchProblem::new(creature, touches, parameters, self.model);
        // Far below the acceptance there is nothing left to gain here.
        let cost = 0.5 * count * (1e-3 * self.acceptance).powi(2);
        let stopping = Stopping { iterations, relative_cost: 1e-4, cost };
        let solution = levenberg_marquardt(&mut problem, parameters, start, stopping);
        (solution.schema, (2.0 * solution.cost / count).sqrt())
    }
}
