//! The true farthest that a grip gets, by a search that has nothing in common with the creature's: no slopes, no
//! quadratic programs, no starts of its choosing.
//!
//! A population of random postures, drawn to where the grip has its height and is upright, evolves by differences of its
//! members (differential evolution, Storn and Price 1997): it knows of a posture how far it is and how far limbs are in
//! each other or in the table, nothing else. Then random steps better the best until none does. All is done several times from nothing; that
//! they agree, and what the second half of them adds to the first, tells how much may be missing.

use nalgebra::{DMatrix, DVector, Vector3};
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;

use crate::creature::Posture;
use crate::kinematics::{Freedoms, Place, tangent_basis};
use crate::peripersonal::{CollisionChecker, OwnBody};

/// Members of a population for each degree of freedom …
const MEMBERS: usize = 4;
/// … and generations.
const GENERATIONS: usize = 160;
/// How much of a difference of two members is gone, the least and the most.
const DIFFERENCES: [f64; 2] = [0.3, 0.9];
/// The share of the degrees of freedom that change at once.
const CROSSED: f64 = 0.8;
/// How often a member goes towards the best one.
const GREEDY: f64 = 0.4;
/// Random steps at the end.
const STEPS: usize = 1500;
/// The length of the first of them, radians, and that of the last.
const STEP: [f64; 2] = [0.05, 2e-4];
/// How clear limbs are of each other and of the table, metres.
const MARGIN: f64 = 0.002;
/// What a metre costs that limbs are in each other, metres of reach.
const PRICE: f64 = 6.0;
/// How exactly a grip has its height and is upright, metres and radians.
const EXACT: f64 = 2e-4;

/// What is asked for: how a grip is to be, moving some joints.
pub struct GripProblem<'a> {
    /// The body, by its true kinematics.
    pub own: &'a OwnBody,
    /// Its surfaces and what is about them.
    pub clearance: CollisionChecker,
    /// The joints that move.
    pub joints: &'a [usize],
    /// The grip; its direction is to be up.
    pub place: Place,
    /// Against gravity, and to the front, in the root's frame.
    pub up: Vector3<f64>,
    /// To the front.
    pub front: Vector3<f64>,
    /// The grip's height along `up`, metres.
    pub height: f64,
    /// The posture of all other joints.
    pub from: Posture,
}

/// What an exhaustive search found.
pub struct FarthestGrip {
    /// The farthest posture; the one that it began with where none was found.
    pub posture: Posture,
    /// How far the grip is in front, metres.
    pub forward: f64,
    /// The same by the first half of the runs.
    pub half: f64,
    /// Postures that were looked at.
    pub looked_at: usize,
}

/// A posture and what it is worth.
#[derive(Clone)]
struct Member {
    posture: Posture,
    worth: f64,
    /// How far the grip is in front where all is kept.
    forward: Option<f64>,
}

impl GripProblem<'_> {
    /// The farthest of so many runs.
    pub fn search(&self, runs: usize, rng: &mut impl Rng) -> FarthestGrip {
        let freedoms = Freedoms::new(self.own.creature(), &self.own.schema, self.joints);
        let mut found = FarthestGrip {
            posture: self.from.clone(),
            forward: f64::NEG_INFINITY,
            half: f64::NEG_INFINITY,
            looked_at: 0,
        };
        for run in 0..runs {
            let mut population: Vec<Member> = (0..MEMBERS * freedoms.count())
                .map(|_| self.judged(&freedoms, self.own.random_posture(&self.from, self.joints, rng)))
                .collect();
            for _ in 0..GENERATIONS {
                self.evolve(&freedoms, &mut population, rng);
            }
            let best = population.into_iter().max_by(|a, b| a.worth.total_cmp(&b.worth));
            let Some(best) = best.map(|best| self.bettered(&freedoms, best, rng)) else { continue };
            found.looked_at += MEMBERS * freedoms.count() * (GENERATIONS + 1) + STEPS;
            if let Some(forward) = best.forward.filter(|forward| *forward > found.forward) {
                (found.posture, found.forward) = (best.posture, forward);
            }
            if run < runs.div_ceil(2) {
                found.half = found.forward;
            }
        }
        found
    }

    fn evolve(&self, freedoms: &Freedoms, population: &mut [Member], rng: &mut impl Rng) {
        let count = population.len();
        let best =
            (0..count).max_by(|&a, &b| population[a].worth.total_cmp(&population[b].worth)).unwrap_or(0);
        for i in 0..count {
            let [a, b, c] = std::array::from_fn(|_| rng.random_range(0..count));
            let base = if rng.random_bool(GREEDY) { best } else { a };
            let far = rng.random_range(DIFFERENCES[0]..DIFFERENCES[1]);
            let mut trial = population[i].posture.clone();
            for q in 0..trial.len() {
                if rng.random_bool(CROSSED) {
                    let difference = population[b].posture[q] - population[c].posture[q];
                    trial[q] = population[base].posture[q] + far * difference;
                }
            }
            let trial = self.judged(freedoms, trial);
            if trial.worth >= population[i].worth {
                population[i] = trial;
            }
        }
    }

    /// The best that random steps lead to, shorter and shorter ones.
    fn bettered(&self, freedoms: &Freedoms, mut best: Member, rng: &mut impl Rng) -> Member {
        let mut length = STEP[0];
        let mut last: Option<Vec<f64>> = None;
        for _ in 0..STEPS {
            if length < STEP[1] {
                break;
            }
            // What went well is gone on with.
            let step = last.take().unwrap_or_else(|| {
                (0..freedoms.count()).map(|_| length * rng.sample::<f64, _>(StandardNormal)).collect()
            });
            let trial = self.judged(freedoms, freedoms.changed(&best.posture, &step));
            if trial.worth > best.worth {
                best = trial;
                length *= 1.3;
                last = Some(step);
            } else {
                length *= 0.97;
            }
        }
        best
    }

    /// A posture drawn to where the grip is as it is to be, and what it is worth.
    fn judged(&self, freedoms: &Freedoms, posture: Posture) -> Member {
        let across = tangent_basis(&self.up);
        // Where a chance difference left the ranges.
        let mut posture = freedoms.changed(&posture, &vec![0.0; freedoms.count()]);
        let limb = self.place.limb;
        let mut off = f64::INFINITY;
        for _ in 0..6 {
            let body = freedoms.at(&posture);
            let point = body.frames[limb].point(&self.place.point);
            let direction = body.frames[limb].rotation * self.place.direction;
            let values = DVector::from_vec(vec![
                point.dot(&self.up) - self.height,
                direction.dot(&across.column(0)),
                direction.dot(&across.column(1)),
            ]);
            off = values.amax();
            // Upside down is across as well.
            if direction.dot(&self.up) < 0.0 {
                off = 1.0;
            }
            if off < 0.5 * EXACT {
                break;
            }
            let mut rows = vec![vec![0.0; freedoms.count()]; 3];
            body.add_point_rates(limb, &point, &self.up, &mut rows[0]);
            for k in 0..2 {
                body.add_direction_rates(limb, &direction, &across.column(k).into_owned(), &mut rows[k + 1]);
            }
            // What is at the end of its range does not help.
            for column in 0..freedoms.count() {
                let [low, high] = freedoms.bounds(column, &posture, 1.0);
                if low > -1e-9 || high < 1e-9 {
                    rows.iter_mut().for_each(|row| row[column] *= 0.1);
                }
            }
            let matrix = DMatrix::from_fn(3, freedoms.count(), |i, k| rows[i][k]);
            let normal = &matrix * matrix.transpose() + DMatrix::identity(3, 3) * 1e-6;
            let Some(factor) = normal.cholesky() else { break };
            let mut change = -(matrix.transpose() * factor.solve(&values));
            let longest = change.amax();
            change *= (0.5 / longest.max(0.5)).min(1.0);
            posture = freedoms.changed(&posture, change.as_slice());
        }
        let frames = self.own.frames(&posture);
        let forward = frames[limb].point(&self.place.point).dot(&self.front);
        if off > EXACT {
            return Member { posture, worth: forward.min(0.0) - 2.0 - off, forward: None };
        }
        let lacking = MARGIN - self.clearance.least(&frames, MARGIN);
        let kept = lacking <= 0.0 && self.clearance.free(&frames, MARGIN);
        Member { worth: forward - PRICE * lacking.max(0.0), forward: kept.then_some(forward), posture }
    }
}
