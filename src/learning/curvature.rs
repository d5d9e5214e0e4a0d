//! What gaps tell of directions that they do not feel at first.
//!
//! Where a body moves in a plane, all of its touches are in that plane. A joint that is a little beside it, or an axis a
//! little aslant, changes no gap to first order: the normal equations leave all of that open. But round limbs beside one
//! another are a little farther apart, by `d²/2r`: exact touches feel a millimetre as ten micrometres.
//!
//! Along the directions `s` that are known badly at first order the gaps are `L s + ½ sᵀ H s`, less what the well-known
//! directions take up. That skin might be off by `d` though touches are explained as well asks for the least sum of these
//! gaps' squares with the skin displaced so: of so many unknowns and no touch any more, a small problem. It falls with the
//! fourth power of `d`, so one such minimum tells how far off the skin may be. Exact slides along an axis, which no order
//! feels, have a minimum of nothing.
//!
//! Curvature is asked of round surfaces alone; a box that tilts has kinks where these have curvature.

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use super::Account;
use super::least_squares::{LeastSquares, Linearization, Stopping, levenberg_marquardt};
use super::observability::Observability;
use super::placement::{LimbTwists, Z95, far_apart, shifts};
use super::prediction::GapRow;
use super::touch_set::{PreparedTouch, TouchSet};
use crate::agent::Agent;
use crate::creature::Posture;
use crate::geometry::tangent_basis;
use crate::kinematics::Chain;
use crate::schema::BodySchema;

/// Directions known no better than this at first order are looked at, radians or characteristic lengths.
const BADLY_KNOWN: f64 = 1e-3;
/// … as long as there are no more of them.
const MOST_DIRECTIONS: usize = 24;
/// Step of the differences, in the same units: as far as skin may be off that is placed.
const STEP: f64 = 5e-3;
/// Touches that are looked at, in units of the numbers that describe the gaps.
const TOUCHES: usize = 2;
/// Points of a limb that stand for its skin.
const POINTS: usize = 2;
/// Pairs of limbs that are looked at, those nearest in the tree first.
const MOST_PAIRS: usize = 30;
/// Initial guesses of each minimum, and its steps.
const STARTS: usize = 3;
const ITERATIONS: usize = 25;
/// How exactly the skin is displaced, as a share.
const DISPLACED: f64 = 1e-2;
/// The seed of the posture in which skin is looked at, and of initial guesses.
const SEED: u64 = 0;

/// How far off skin may be between each two limbs of an account, metres at 95 %: as the account has it or, where that is more
/// than what is placed, by exact touches that leave gaps of one `deviation`, metres. The account is by the same touches.
pub(super) fn distances_by_curvature(
    agent: &Agent,
    schema: &BodySchema,
    account: &Account,
    touches: &TouchSet,
    deviation: f64,
) -> DMatrix<f64> {
    let (found, limbs, limit) = (&account.observability, account.limbs(), account.limit());
    let first = account.distances();
    let mut distances = first.clone();
    let [well, badly] = found.directions(BADLY_KNOWN);
    if badly.ncols() == 0 || badly.ncols() > MOST_DIRECTIONS {
        return distances;
    }
    let Some(gaps) = CurvedGaps::new(agent, schema, found, touches, [&well, &badly], deviation) else {
        return distances;
    };
    let shifts = Shifts::new(agent, schema, found, &badly);
    let chain = |a: usize, b: usize| Chain::between(agent.creature(), limbs[a], limbs[b]);
    let is_known = |a: usize, b: usize| {
        let placed = found.placed()[limbs[a]] && found.placed()[limbs[b]];
        placed && !chain(a, b).joints().any(|joint| found.untouched(joint))
    };
    let mut pairs: Vec<[usize; 2]> = (0..limbs.len())
        .flat_map(|a| (a + 1..limbs.len()).map(move |b| [a, b]))
        .filter(|&[a, b]| first[(a, b)] > limit && is_known(a, b))
        .collect();
    pairs.sort_by_key(|&[a, b]| chain(a, b).joints().count());
    pairs.truncate(MOST_PAIRS);
    let found: Vec<f64> =
        pairs.par_iter().map(|&[a, b]| gaps.distance(&shifts, [limbs[a], limbs[b]], limit)).collect();
    for ([a, b], distance) in pairs.into_iter().zip(found) {
        let least = distance.min(first[(a, b)]);
        (distances[(a, b)], distances[(b, a)]) = (least, least);
    }
    distances
}

/// The gaps of touches over badly known directions, in units of their deviation, as an upper triangle over the directions
/// and their products.
struct CurvedGaps {
    directions: usize,
    triangle: DMatrix<f64>,
}

impl CurvedGaps {
    /// None where round limbs have too few touches.
    fn new(
        agent: &Agent,
        schema: &BodySchema,
        found: &Observability,
        touches: &TouchSet,
        [well, badly]: [&DMatrix<f64>; 2],
        deviation: f64,
    ) -> Option<CurvedGaps> {
        let k = badly.ncols();
        let numbers = k + k * (k + 1) / 2;
        let is_round =
            |touch: &&PreparedTouch| agent.skin().all_round(touch.ends.iter().map(|end| end.receptor));
        let all: Vec<&PreparedTouch> = touches.touches().filter(is_round).collect();
        let wanted = TOUCHES * (numbers + well.ncols());
        let every = (all.len() / wanted).max(1);
        let told: Vec<&PreparedTouch> = all.into_iter().step_by(every).collect();
        if told.len() < k + well.ncols() {
            return None;
        }
        let steps: Vec<DVector<f64>> = badly.column_iter().map(|column| column * STEP).collect();
        let displaced: Vec<[BodySchema; 2]> = steps
            .iter()
            .map(|step| [1.0, -1.0].map(|sign| found.parameters.step(schema, &(step * sign))))
            .collect();
        let slope = |row: &mut GapRow, there: &BodySchema, touch: &PreparedTouch| {
            row.set(agent.skin(), &found.parameters, there, touch);
            let mut slope = DVector::zeros(found.parameters.len());
            row.entries.iter().for_each(|&(place, by)| slope[place] += by);
            // The present basis of an axis may not be the one at the schema.
            for (axis, offset) in found.parameters.axes.iter().enumerate() {
                let Some(offset) = *offset else { continue };
                let turn = tangent_basis(&schema.axes[axis]).tr_mul(&tangent_basis(&there.axes[axis]));
                let turned = turn * slope.fixed_rows::<2>(offset);
                slope.fixed_rows_mut::<2>(offset).copy_from(&turned);
            }
            slope
        };
        let rows: Vec<[DVector<f64>; 2]> = told
            .par_iter()
            .map(|touch| {
                let mut row = GapRow::default();
                let here = slope(&mut row, schema, touch);
                let mut numbers_of_it = DVector::zeros(numbers);
                numbers_of_it.rows_mut(0, k).copy_from(&badly.tr_mul(&here));
                let bends: Vec<DVector<f64>> = displaced
                    .iter()
                    .map(|[plus, minus]| {
                        let change = slope(&mut row, plus, touch) - slope(&mut row, minus, touch);
                        badly.tr_mul(&change) / (2.0 * STEP)
                    })
                    .collect();
                for (at, (i, j)) in products(k).enumerate() {
                    let bend = 0.5 * (bends[i][j] + bends[j][i]);
                    // Half of it stands twice beside the diagonal.
                    numbers_of_it[k + at] = if i == j { 0.5 * bend } else { bend };
                }
                [well.tr_mul(&here), numbers_of_it / deviation]
            })
            .collect();
        let strong = DMatrix::from_fn(rows.len(), well.ncols(), |i, j| rows[i][0][j]);
        let mut all = DMatrix::from_fn(rows.len(), numbers, |i, j| rows[i][1][j]);
        if well.ncols() > 0 {
            // What the well-known directions take up.
            let taken = strong.qr().q();
            let shares = taken.tr_mul(&all);
            all -= taken * shares;
        }
        Some(CurvedGaps { directions: k, triangle: all.qr().r() })
    }

    /// How far off any skin of either limb may be in the other's frame, metres at 95 %.
    fn distance(&self, shifts: &Shifts, limbs: [usize; 2], limit: f64) -> f64 {
        let mut worst: f64 = 0.0;
        for map in shifts.of(limbs) {
            let mut squares = 0.0;
            for along in map.row_iter() {
                let along = along.transpose();
                // Nothing moves it.
                if along.norm() * STEP < limit * 1e-6 {
                    continue;
                }
                let least = self.least_cost(&along, limit);
                // The cost grows with the fourth power.
                let may_be = limit * (Z95 * Z95 / least.max(f64::MIN_POSITIVE)).powf(0.25);
                squares += may_be * may_be;
            }
            worst = worst.max(squares.sqrt());
            // It is not placed: how badly is of no matter.
            if worst > limit {
                break;
            }
        }
        worst
    }

    /// The least sum of squared gaps, in units of their variance, with a displacement along a direction.
    fn least_cost(&self, along: &DVector<f64>, displacement: f64) -> f64 {
        let mut rng = ChaCha8Rng::seed_from_u64(SEED);
        let nearest = along * (displacement / along.norm_squared());
        let starts = (0..STARTS).map(|start| {
            let size = if start == 0 { 0.0 } else { nearest.norm() };
            let aside = DVector::from_fn(self.directions, |_, _| {
                let standard: f64 = StandardNormal.sample(&mut rng);
                standard * size / (self.directions as f64).sqrt()
            });
            &nearest + aside
        });
        let starts: Vec<DVector<f64>> = starts.collect();
        starts
            .into_iter()
            .map(|start| self.descended(start, along, displacement))
            .fold(f64::INFINITY, f64::min)
    }

    /// The sum of squared gaps where Levenberg's and Marquardt's steps lead, with the displacement held.
    fn descended(&self, start: DVector<f64>, along: &DVector<f64>, displacement: f64) -> f64 {
        let stopping = Stopping { iterations: ITERATIONS, relative_cost: 1e-4, ..Stopping::default() };
        let mut problem = Displaced { gaps: self, along, displacement };
        let s = levenberg_marquardt(&mut problem, start, stopping).state;
        // A displacement that was not reached counts as if it had been.
        let reached = along.dot(&s).abs().max(DISPLACED * displacement);
        self.gaps(&s).norm_squared() * (displacement / reached).powi(4)
    }

    fn gaps(&self, s: &DVector<f64>) -> DVector<f64> {
        let mut numbers = DVector::zeros(self.triangle.ncols());
        numbers.rows_mut(0, self.directions).copy_from(s);
        for (at, (i, j)) in products(self.directions).enumerate() {
            numbers[self.directions + at] = s[i] * s[j];
        }
        &self.triangle * numbers
    }

    fn slopes(&self, s: &DVector<f64>) -> DMatrix<f64> {
        let k = self.directions;
        let mut slopes = self.triangle.columns(0, k).into_owned();
        for (at, (i, j)) in products(k).enumerate() {
            let column = self.triangle.column(k + at);
            slopes.column_mut(i).axpy(s[j], &column, 1.0);
            slopes.column_mut(j).axpy(s[i], &column, 1.0);
        }
        slopes
    }
}

/// The products of two of so many numbers.
fn products(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |i| (i..count).map(move |j| (i, j)))
}

/// How skin shifts with the badly known directions, in one posture.
struct Shifts<'a> {
    agent: &'a Agent,
    twists: LimbTwists,
}

impl<'a> Shifts<'a> {
    fn new(agent: &'a Agent, schema: &BodySchema, found: &Observability, badly: &DMatrix<f64>) -> Shifts<'a> {
        let posture = Posture::random(agent.creature(), &mut ChaCha8Rng::seed_from_u64(SEED));
        let steps = badly.transpose();
        let twists = LimbTwists::new(agent.creature(), schema, &found.parameters, &steps, &posture);
        Shifts { agent, twists }
    }

    /// The derivative of where points of either limb are in the other's frame, per point 3 rows (m) along the axes of the root: of a
    /// plane's body two of them are nothing.
    fn of(&self, [a, b]: [usize; 2]) -> Vec<DMatrix<f64>> {
        let of_limb = |[limb, other]: [usize; 2]| {
            let twists = self.twists.between(limb, other);
            let points = far_apart(self.agent.skin(), limb, POINTS).into_iter();
            points.map(move |point| shifts(&twists, &self.twists.frames[limb].point(&point)))
        };
        [[a, b], [b, a]].into_iter().flat_map(of_limb).collect()
    }
}

/// The least-squares problem of gaps where skin is displaced along a direction.
struct Displaced<'a> {
    gaps: &'a CurvedGaps,
    along: &'a DVector<f64>,
    displacement: f64,
}

impl Displaced<'_> {
    /// The displacement's miss, in units of how exact it is to be; and its slope by a shift along the direction.
    fn miss(&self, s: &DVector<f64>) -> (f64, f64) {
        let tight = 1.0 / (DISPLACED * self.displacement);
        ((self.along.dot(s) - self.displacement) * tight, tight)
    }
}

impl LeastSquares for Displaced<'_> {
    type State = DVector<f64>;

    fn linearize(&mut self, s: &DVector<f64>) -> Linearization {
        let slopes = self.gaps.slopes(s);
        let (miss, tight) = self.miss(s);
        let mut hessian = slopes.tr_mul(&slopes);
        hessian.ger(tight * tight, self.along, self.along, 1.0);
        let mut gradient = slopes.tr_mul(&self.gaps.gaps(s));
        gradient.axpy(tight * miss, self.along, 1.0);
        Linearization { scale: hessian.diagonal(), hessian, gradient, cost: self.cost(s) }
    }

    fn cost(&self, s: &DVector<f64>) -> f64 {
        0.5 * (self.gaps.gaps(s).norm_squared() + self.miss(s).0.powi(2))
    }

    fn step(&self, s: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        s + step
    }
}
