//! Reaching as one optimisation: of all postures that keep clear and have a place of the body as it is to be, the one that
//! has it farthest along a direction.
//!
//! ```text
//! most   a · p(q)                             p: the place, in the root's frame
//! where  a_k · p(q) = h_k                     levels: a height that it keeps, or all of where it is to be
//!        R(q) u ∥ v                           a direction of its limb that is to lead along one of space
//!        gap_i(q) ≥ margin                    limbs from each other and from what is known to be there
//!        ranges of the joints
//! ```
//!
//! Successive linear programming with an ℓ1 merit function and a trust region (Fletcher and Sainz de la Maza 1989; Nocedal and
//! Wright 2006, section 18.5), each step a little curved so that it has one best end: what it cannot keep it breaks at a price.
//! With exact second derivatives a program takes fewer steps and comes to the same postures within a fifth of a millimetre. What
//! it finds is the best near where it begins: what a single start leads to may be a fifth short of the farthest. So it is begun from
//! many postures, and anew from near the best, for small changes of a good one lead to better ones (basin hopping, Wales and Doye
//! 1997).

use nalgebra::{DMatrix, DVector, Vector3};
use rand::{Rng, RngExt};

use super::collision::{CollisionChecker, Nearness};
use super::own_body::OwnBody;
use super::path::distance;
use crate::creature::Posture;
use crate::geometry::tangent_basis;
use crate::kinematics::{Condition, Feature, FreeMotions, Freedoms, Place, QuadraticProgram};

/// What a radian that a direction is off counts as, metres: an arm's half.
const DIRECTION_LENGTH: f64 = 0.3;
/// Nearer to a right angle a direction counts as if its cosine were this.
const UPSIDE: f64 = 0.3;
/// What a metre of what is not kept costs in metres of reach: more than any multiplier away from a straight arm.
const PRICE: f64 = 20.0;
/// The farthest that a freedom goes in one step, radians or metres: at first, …
const FIRST_STEP: f64 = 0.3;
/// … at most, …
const LONGEST_STEP: f64 = 0.5;
/// … and where it ends.
const SHORTEST_STEP: f64 = 1e-5;
/// Gaps up to this are looked after in a step, metres for each radian or metre that it may go.
const OUTLOOK: f64 = 0.15;
/// Steps at most.
const STEPS: usize = 50;
/// The least gain for which another step is made, metres.
const GAIN: f64 = 2e-5;
/// The curvature that a step counts with, metres a squared radian: of steps that promise the same, the shortest is gone.
const CURVATURE: f64 = 1e-3;
/// How often a step is corrected at most.
const CORRECTIONS: usize = 3;
/// What is off by less than this is not corrected, metres.
const EXACT: f64 = 1e-7;
/// How far what is to be kept may be off in a posture that keeps it, metres.
pub const KEPT: f64 = 2e-4;

/// Steps of a first look from a start.
const FIRST_LOOK: usize = 25;
/// Rounds in which the best are begun from anew, …
const HOPS: usize = 3;
/// … so many of them, …
const HOPPING: usize = 3;
/// … from where their joints are these shares of the way to a random posture.
const CHANGES: [f64; 4] = [0.05, 0.12, 0.25, 0.4];
/// Postures that are told at most, …
const TOLD: usize = 8;
/// … which differ by this much, in radians.
const DIFFERENT: f64 = 0.1;

/// What a posture is to be like.
#[derive(Clone, Debug)]
pub struct PostureProgram<'a> {
    own: &'a OwnBody,
    clearance: CollisionChecker,
    freedoms: Freedoms<'a>,
    place: Place,
    along: Vector3<f64>,
    levels: Vec<(Vector3<f64>, f64)>,
    /// A direction of space along which the place's is to lead, and two across it.
    parallel: Option<[Vector3<f64>; 3]>,
    margin: f64,
}

/// A posture that a program found.
#[derive(Clone, Debug, PartialEq)]
pub struct PosedPlace {
    /// The posture.
    pub posture: Posture,
    /// How far the place is along the direction, metres.
    pub along: f64,
    /// What is not kept, all in all, metres.
    pub broken: f64,
}

impl PosedPlace {
    /// Whether all is kept that is to be.
    pub fn kept(&self) -> bool {
        self.broken <= KEPT
    }
}

/// How far a direction is off in two directions across it, metres, and along what of space that grows with the direction.
struct Tilt {
    values: [f64; 2],
    across: [Vector3<f64>; 2],
}

impl<'a> PostureProgram<'a> {
    /// The farthest that a place gets along a unit direction of the root's frame, moving some joints, where limbs keep
    /// `margin` metres clear of each other and of what is known to be there.
    pub fn farthest(
        own: &'a OwnBody,
        clearance: &CollisionChecker,
        joints: &[usize],
        place: Place,
        along: Vector3<f64>,
        margin: f64,
    ) -> PostureProgram<'a> {
        PostureProgram {
            own,
            clearance: clearance.moved_by(own, joints),
            freedoms: Freedoms::new(own.creature(), &own.schema, joints),
            place,
            along,
            levels: Vec::new(),
            parallel: None,
            margin,
        }
    }

    /// The same where the place keeps at a level along a unit direction of the root's frame, metres.
    pub fn at_level(mut self, direction: Vector3<f64>, level: f64) -> Self {
        self.levels.push((direction, level));
        self
    }

    /// The same where the place's direction is to lead along a unit direction of the root's frame.
    pub fn parallel_to(mut self, direction: Vector3<f64>) -> Self {
        let across = tangent_basis(&direction);
        self.parallel = Some([direction, across.column(0).into_owned(), across.column(1).into_owned()]);
        self
    }

    /// The best posture that steps from a start lead to; joints that do not move stay as they are there.
    pub fn solve(&self, start: &[f64]) -> PosedPlace {
        self.solve_within(start, STEPS)
    }

    /// The same with so many steps at most.
    pub fn solve_within(&self, start: &[f64], most_steps: usize) -> PosedPlace {
        let mut posture = self.freedoms.changed(start, &vec![0.0; self.freedoms.count()]);
        let mut merit = self.merit(&posture);
        let mut reach = FIRST_STEP;
        for _ in 0..most_steps {
            if reach <= SHORTEST_STEP {
                break;
            }
            let Some((change, gain)) = self.step(&posture, reach) else {
                reach *= 0.25;
                continue;
            };
            if gain < GAIN {
                break;
            }
            let (trial, after) = self.drawn_back(self.freedoms.changed(&posture, &change));
            let share = (merit - after) / gain;
            let longest = change.iter().fold(0.0f64, |most, x| most.max(x.abs()));
            if share > 0.05 {
                (posture, merit) = (trial, after);
            }
            if share < 0.25 {
                reach = 0.35 * reach.min(longest);
            } else if share > 0.7 {
                reach = (2.0 * reach).min(LONGEST_STEP);
            }
        }
        let (along, broken) = self.measured(&posture);
        PosedPlace { posture, along, broken }
    }

    /// How far the place is along the direction, and all that is not kept, metres.
    fn measured(&self, posture: &[f64]) -> (f64, f64) {
        let body = self.own.frames(posture);
        let frame = &body[self.place.limb];
        let point = frame.point(&self.place.point);
        let levels = self.levels.iter().map(|(direction, level)| (direction.dot(&point) - level).abs());
        let direction = frame.rotation * self.place.direction;
        let tilt = self.tilt(&direction);
        let tilts = tilt.iter().flat_map(|tilt| tilt.values).map(f64::abs);
        let near = self.clearance.near_places(&body, self.margin);
        let gaps = near.iter().map(|near| (self.asked(near) - near.gap.distance).max(0.0));
        (point.dot(&self.along), levels.chain(tilts).chain(gaps).sum())
    }

    /// The gap that is asked for, metres: a little more than what must be, where that is less than the margin.
    fn asked(&self, near: &Nearness) -> f64 {
        self.margin.min(near.most + KEPT)
    }

    fn merit(&self, posture: &[f64]) -> f64 {
        let (along, broken) = self.measured(posture);
        PRICE * broken - along
    }

    /// How far the place's direction leads away from where it is to, by the angle between them.
    fn tilt(&self, leading: &Vector3<f64>) -> Option<Tilt> {
        let [direction, across @ ..] = self.parallel.as_ref()?;
        let cosine = leading.dot(direction);
        let [a, b] = [0, 1].map(|k| across[k].dot(leading));
        let sine = a.hypot(b);
        let angle = sine.atan2(cosine);
        // Against its direction it may turn any way.
        let [a, b] = if sine > 1e-9 { [a / sine, b / sine] } else { [1.0, 0.0] };
        // Beyond a right angle what is across grows as the angle shrinks.
        let grows = if cosine.abs() < UPSIDE { UPSIDE.copysign(cosine) } else { cosine };
        Some(Tilt {
            values: [a, b].map(|part| DIRECTION_LENGTH * angle * part),
            across: [0, 1].map(|k| across[k] * (DIRECTION_LENGTH / grows)),
        })
    }

    /// That so much is to change by the freedoms, as fast as `rates` tells.
    fn condition(&self, least: f64, exactly: bool, rates: impl FnOnce(&mut [f64])) -> Condition {
        let mut coefficients = DVector::zeros(self.freedoms.count());
        rates(coefficients.as_mut_slice());
        Condition { coefficients, least, exactly, price: PRICE }
    }

    /// What is to be zero: levels, and how far the direction is off.
    fn equalities(&self, body: &FreeMotions) -> Vec<Condition> {
        let (limb, frame) = (self.place.limb, &body.frames[self.place.limb]);
        let point = frame.point(&self.place.point);
        let leading = frame.rotation * self.place.direction;
        let levels = self.levels.iter().map(|(direction, level)| {
            let rates = |rates: &mut [f64]| body.add_rates(limb, Feature::Point(point), direction, rates);
            self.condition(level - direction.dot(&point), true, rates)
        });
        let tilt = self.tilt(&leading);
        let tilts =
            tilt.iter().flat_map(|tilt| tilt.values.into_iter().zip(&tilt.across)).map(|(value, across)| {
                let rates =
                    |rates: &mut [f64]| body.add_rates(limb, Feature::Direction(leading), across, rates);
                self.condition(-value, true, rates)
            });
        levels.chain(tilts).collect()
    }

    /// That a gap is to be as wide as is asked.
    fn apart(&self, body: &FreeMotions, near: &Nearness) -> Condition {
        self.condition(self.asked(near) - near.gap.distance, false, |rates| {
            body.add_gap_rates([Some(near.limb), near.other], &near.gap.points, &near.gap.normal, rates);
        })
    }

    /// A posture drawn back by a least change to where what is to be zero is so and gaps are as wide as is asked, as their
    /// slopes tell: what a step along bent surfaces leaves them by (a second-order correction). Where that betters it; and
    /// its merit.
    fn drawn_back(&self, posture: Posture) -> (Posture, f64) {
        let merit = self.merit(&posture);
        let mut best = (posture, merit);
        for _ in 0..CORRECTIONS {
            let body = self.freedoms.at(&best.0);
            let near = self.clearance.near_places(&body.frames, self.margin);
            let lacking = near.iter().filter(|near| self.asked(near) > near.gap.distance);
            let mut rows = self.equalities(&body);
            rows.extend(lacking.map(|near| self.apart(&body, near)));
            if rows.iter().all(|row| row.least.abs() < EXACT) {
                break;
            }
            let count = rows.len();
            let matrix = DMatrix::from_fn(count, self.freedoms.count(), |i, k| rows[i].coefficients[k]);
            let values = DVector::from_iterator(count, rows.iter().map(|row| row.least));
            let normal = &matrix * matrix.transpose() + DMatrix::identity(count, count) * 1e-6;
            let Some(factor) = normal.cholesky() else { break };
            let change = matrix.transpose() * factor.solve(&values);
            let corrected = self.freedoms.changed(&best.0, change.as_slice());
            let merit = self.merit(&corrected);
            if merit >= best.1 {
                break;
            }
            best = (corrected, merit);
        }
        best
    }

    /// The step from a posture that promises most, of which no freedom goes farther than `reach`, and what it promises in merit.
    fn step(&self, posture: &[f64], reach: f64) -> Option<(Vec<f64>, f64)> {
        let body = self.freedoms.at(posture);
        let near = self.clearance.near_places(&body.frames, self.margin + OUTLOOK * reach);
        let n = self.freedoms.count();
        let limb = self.place.limb;
        let point = body.frames[limb].point(&self.place.point);
        let mut slope = DVector::zeros(n);
        body.add_rates(limb, Feature::Point(point), &-self.along, slope.as_mut_slice());
        let gaps = near.iter().map(|near| self.apart(&body, near));
        let program = QuadraticProgram {
            curvature: DMatrix::from_diagonal_element(n, n, CURVATURE),
            slope,
            bounds: (0..n).map(|freedom| self.freedoms.bounds(freedom, posture, reach)).collect(),
            conditions: self.equalities(&body).into_iter().chain(gaps).collect(),
        };
        let found = program.solve()?;
        // What is not kept now and would not be by the planes, against what is won.
        let broken = |x: &DVector<f64>| {
            program.conditions.iter().map(|condition| condition.missed_by(x).max(0.0)).sum::<f64>()
        };
        let won = -0.5 * CURVATURE * found.norm_squared() - program.slope.dot(&found);
        let promised = won + PRICE * (broken(&DVector::zeros(n)) - broken(&found));
        Some((found.as_slice().to_vec(), promised))
    }
}

/// The postures in which a place is farthest, as a program has it, the farthest first; joints that do not move are as in
/// all `starts`. What is drawn is drawn by `rng`.
pub fn farthest_postures(
    own: &OwnBody,
    program: &PostureProgram,
    joints: &[usize],
    starts: &[Posture],
    rng: &mut impl Rng,
) -> Vec<PosedPlace> {
    let mut found: Vec<PosedPlace> =
        starts.iter().map(|start| program.solve_within(start, FIRST_LOOK)).collect();
    for _ in 0..HOPS {
        sort(&mut found, HOPPING);
        let mut hops = Vec::new();
        for best in &found {
            for share in CHANGES {
                // Some joints go far, others hardly.
                let other = own.random_posture(&best.posture, joints, rng);
                let mut start = best.posture.clone();
                for (at, other) in start.iter_mut().zip(other.iter()) {
                    let far: f64 = rng.random_range(0.0..2.0);
                    *at += far.min(1.0) * share * (other - *at);
                }
                own.creature().couple(&mut start);
                hops.push(program.solve_within(&start, FIRST_LOOK));
            }
        }
        found.append(&mut hops);
    }
    sort(&mut found, TOLD);
    let mut last: Vec<PosedPlace> = found.iter().map(|best| program.solve(&best.posture)).collect();
    last.retain(PosedPlace::kept);
    sort(&mut last, TOLD);
    last
}

/// Keeps the best that differ, those that keep everything before those that do not.
fn sort(found: &mut Vec<PosedPlace>, most: usize) {
    found.sort_by(|a, b| b.kept().cmp(&a.kept()).then(b.along.total_cmp(&a.along)));
    let mut kept: Vec<PosedPlace> = Vec::new();
    for posed in found.drain(..) {
        let differs = |other: &PosedPlace| distance(&other.posture, &posed.posture) > DIFFERENT;
        if kept.len() < most && kept.iter().all(differs) {
            kept.push(posed);
        }
    }
    *found = kept;
}
