//! The quadratic program behind inverse kinematics with conditions: the best change of some variables where conditions are
//! kept, or broken at a price.
//!
//! ```text
//! least  ½ xᵀ H x + g · x + Σ price_i |what condition i is missed by|
//! where  a_i · x ≥ b_i or = b_i, and low ≤ x ≤ high
//! ```
//!
//! Its dual is solved by an interior-point method (Clarabel: Goulart and Chen 2024). It has as many variables as there are
//! conditions that matter, mostly few or none, each between 0 and the condition's price.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use nalgebra::{DMatrix, DVector};

/// By how much a condition may be missed.
const TOLERANCE: f64 = 1e-7;
/// How exact the dual program is.
const EXACT: f64 = 1e-9;

/// A weighted sum of the variables that is to be so much at least, or exactly so much.
#[derive(Clone, Debug)]
pub struct Condition {
    /// The weights.
    pub coefficients: DVector<f64>,
    /// What it is to be.
    pub least: f64,
    /// Whether it must not be more, either.
    pub exactly: bool,
    /// What missing it by 1 costs; infinite where it must be kept.
    pub price: f64,
}

/// The program.
#[derive(Clone, Debug)]
pub struct QuadraticProgram {
    /// `H`, positive definite; the lower triangle counts.
    pub curvature: DMatrix<f64>,
    /// `g`.
    pub slope: DVector<f64>,
    /// The least and the greatest of each variable.
    pub bounds: Vec<[f64; 2]>,
    /// The conditions.
    pub conditions: Vec<Condition>,
}

/// Its solution.
#[derive(Clone, Debug)]
pub struct Optimum {
    /// The variables.
    pub x: DVector<f64>,
    /// Per condition, how hard it pushes: its multiplier.
    pub multipliers: Vec<f64>,
}

impl Condition {
    /// By how much it is missed, below 0 where there is room.
    pub fn missed_by(&self, x: &DVector<f64>) -> f64 {
        let lacking = self.least - self.coefficients.dot(x);
        if self.exactly { lacking.abs() } else { lacking }
    }
}

impl QuadraticProgram {
    /// Solves it; `None` if the solver fails.
    pub fn solve(&self) -> Option<Optimum> {
        let size = self.slope.len();
        let factor = self.curvature.clone().cholesky()?;
        let free = factor.solve(&-&self.slope);
        let bound = |k: usize, sign: f64, least: f64| {
            let mut coefficients = DVector::zeros(size);
            coefficients[k] = sign;
            Condition { coefficients, least, exactly: false, price: f64::INFINITY }
        };
        let bounds = self.bounds.iter().enumerate();
        let bounds: Vec<Condition> =
            bounds.flat_map(|(k, [low, high])| [bound(k, 1.0, *low), bound(k, -1.0, -high)]).collect();
        let rows: Vec<&Condition> = self.conditions.iter().chain(&bounds).collect();
        // Few conditions ever matter: those that are missed without them are asked for, until none is.
        let mut asked: Vec<usize> = Vec::new();
        let mut pushes = DMatrix::zeros(size, 0);
        let (mut x, mut forces) = (free.clone(), DVector::zeros(0));
        loop {
            let known = asked.len();
            let missed = |row: &usize| !asked.contains(row) && rows[*row].missed_by(&x) > TOLERANCE;
            let news: Vec<usize> = (0..rows.len()).filter(missed).collect();
            asked.extend(news);
            if asked.len() == known {
                break;
            }
            pushes = pushes.resize_horizontally(asked.len(), 0.0);
            for (k, &row) in asked.iter().enumerate().skip(known) {
                pushes.set_column(k, &factor.solve(&rows[row].coefficients));
            }
            let of: Vec<&Condition> = asked.iter().map(|&row| rows[row]).collect();
            forces = dual(&of, &pushes, &free)?;
            x = &free + &pushes * &forces;
        }
        let mut multipliers = vec![0.0; rows.len()];
        asked.iter().zip(forces.iter()).for_each(|(&row, force)| multipliers[row] = *force);
        multipliers.truncate(self.conditions.len());
        for (x, [low, high]) in x.iter_mut().zip(&self.bounds) {
            *x = x.clamp(*low, *high);
        }
        Some(Optimum { x, multipliers })
    }
}

/// How hard each of some conditions has to push from the least of the objective, `free`. `pushes` has in its columns where
/// the variables go by a unit's push of each.
fn dual(rows: &[&Condition], pushes: &DMatrix<f64>, free: &DVector<f64>) -> Option<DVector<f64>> {
    let size = rows.len();
    let (mut starts, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
    for j in 0..size {
        for (i, row) in rows.iter().enumerate().take(j + 1) {
            indices.push(i);
            values.push(row.coefficients.dot(&pushes.column(j)));
        }
        starts.push(indices.len());
    }
    let objective = CscMatrix::new(size, size, starts, indices, values);
    let linear: Vec<f64> = rows.iter().map(|row| row.coefficients.dot(free) - row.least).collect();
    // Forces lie between 0, or less the price, and the price.
    let (mut starts, mut indices, mut values, mut limits) = (vec![0], Vec::new(), Vec::new(), Vec::new());
    for row in rows {
        let low = if row.exactly { -row.price } else { 0.0 };
        for (sign, limit) in [(-1.0, -low), (1.0, row.price)] {
            if limit.is_finite() {
                indices.push(limits.len());
                values.push(sign);
                limits.push(limit);
            }
        }
        starts.push(indices.len());
    }
    let constraints = CscMatrix::new(limits.len(), size, starts, indices, values);
    let settings = DefaultSettings {
        verbose: false,
        presolve_enable: false,
        tol_gap_abs: EXACT,
        tol_gap_rel: EXACT,
        tol_feas: EXACT,
        ..DefaultSettings::default()
    };
    let cones = [SupportedConeT::NonnegativeConeT(limits.len())];
    let mut solver = DefaultSolver::new(&objective, &linear, &constraints, &limits, &cones, settings).ok()?;
    solver.solve();
    let solved = matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved);
    let within = |(force, row): (&f64, &&Condition)| {
        force.clamp(if row.exactly { -row.price } else { 0.0 }, row.price)
    };
    solved.then(|| DVector::from_iterator(size, solver.solution.x.iter().zip(rows).map(within)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of two variables that are drawn to (1, 2): the nearest with what is asked of them.
    fn nearest(conditions: &[([f64; 2], f64, bool, f64)], high: f64) -> Optimum {
        let condition = |&(coefficients, least, exactly, price): &([f64; 2], f64, bool, f64)| Condition {
            coefficients: DVector::from_column_slice(&coefficients),
            least,
            exactly,
            price,
        };
        let program = QuadraticProgram {
            curvature: DMatrix::identity(2, 2),
            slope: DVector::from_vec(vec![-1.0, -2.0]),
            bounds: vec![[-high, high]; 2],
            conditions: conditions.iter().map(condition).collect(),
        };
        program.solve().unwrap()
    }

    #[test]
    fn conditions_are_kept_or_broken_at_their_price() {
        let must = f64::INFINITY;
        let is = |found: &Optimum, x: [f64; 2]| (&found.x - DVector::from_column_slice(&x)).amax() < 1e-6;
        assert!(is(&nearest(&[], 9.0), [1.0, 2.0]) && is(&nearest(&[], 1.5), [1.0, 1.5]));
        // A condition that is kept anyway does not push.
        let kept = nearest(&[([1.0, 0.0], 0.5, false, must)], 9.0);
        assert!(is(&kept, [1.0, 2.0]) && kept.multipliers == [0.0]);
        let equal = nearest(&[([1.0, 1.0], 2.0, true, must)], 9.0);
        assert!(is(&equal, [0.5, 1.5]) && (equal.multipliers[0] + 0.5).abs() < 1e-6, "{equal:?}");
        // To have the first at 4 costs 3 at the end: whoever pays but 1 gets it as far as 2.
        for (price, x) in [(5.0, 4.0), (1.0, 2.0)] {
            let found = nearest(&[([1.0, 0.0], 4.0, false, price)], 9.0);
            assert!(is(&found, [x, 2.0]), "{found:?}");
        }
        // What must be kept is kept against what has a price.
        let torn = [([1.0, 0.0], 4.0, false, 100.0), ([-1.0, 0.0], -2.0, false, must)];
        assert!(is(&nearest(&torn, 9.0), [2.0, 2.0]));
    }
}
