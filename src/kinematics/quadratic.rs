//! The quadratic program behind inverse kinematics with conditions: the best change of some variables where conditions are
//! kept, or broken at a price.
//!
//! ```text
//! least  ½ xᵀ H x + g · x + Σ price_i |what condition i is missed by|
//! where  a_i · x ≥ b_i or = b_i, and low ≤ x ≤ high
//! ```
//!
//! It is solved by an interior-point method (Clarabel: Goulart and Chen 2024), with a variable more for each condition that may
//! be missed: the few variables make the normal equations of hundreds of conditions small.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use nalgebra::{DMatrix, DVector};

/// By how much a condition may be missed.
const TOLERANCE: f64 = 1e-7;
/// How exact the solver is.
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

impl Condition {
    /// By how much it is missed, below 0 where there is room.
    pub fn missed_by(&self, x: &DVector<f64>) -> f64 {
        let lacking = self.least - self.coefficients.dot(x);
        if self.exactly { lacking.abs() } else { lacking }
    }
}

/// `Σ entries · variables ≤ most`.
struct Row {
    entries: Vec<(usize, f64)>,
    most: f64,
}

impl QuadraticProgram {
    /// Its variables where they are best; `None` if the solver fails.
    pub fn solve(&self) -> Option<DVector<f64>> {
        let free = self.curvature.clone().cholesky()?.solve(&-&self.slope);
        let within = |(x, [low, high]): (&f64, &[f64; 2])| (low..=high).contains(&x);
        // Few conditions ever matter: those that are missed without them are asked for, until none is.
        let mut asked: Vec<usize> = Vec::new();
        let mut found = match free.iter().zip(&self.bounds).all(within) {
            true => free,
            false => self.solve_asking(&asked)?,
        };
        loop {
            let missed = |k: &usize| !asked.contains(k) && self.conditions[*k].missed_by(&found) > TOLERANCE;
            let news: Vec<usize> = (0..self.conditions.len()).filter(missed).collect();
            if news.is_empty() {
                return Some(found);
            }
            asked.extend(news);
            found = self.solve_asking(&asked)?;
        }
    }

    /// The same where no others are asked for than some of the conditions.
    fn solve_asking(&self, asked: &[usize]) -> Option<DVector<f64>> {
        let size = self.slope.len();
        let mut slope: Vec<f64> = self.slope.iter().copied().collect();
        let mut rows = Vec::new();
        for condition in asked.iter().map(|&k| &self.conditions[k]) {
            let signs = if condition.exactly { &[-1.0, 1.0][..] } else { &[-1.0] };
            let row = |sign: &f64| -> Row {
                let entries = condition.coefficients.iter().enumerate().map(|(i, a)| (i, sign * a));
                Row { entries: entries.collect(), most: sign * condition.least }
            };
            let mut own: Vec<Row> = signs.iter().map(row).collect();
            if condition.price.is_finite() {
                // By how much it is missed is a variable more.
                let missed = (slope.len(), -1.0);
                slope.push(condition.price);
                own.iter_mut().for_each(|row| row.entries.push(missed));
                own.push(Row { entries: vec![missed], most: 0.0 });
            }
            rows.extend(own);
        }
        for (k, [low, high]) in self.bounds.iter().enumerate() {
            rows.push(Row { entries: vec![(k, -1.0)], most: -low });
            rows.push(Row { entries: vec![(k, 1.0)], most: *high });
        }
        let cones = [SupportedConeT::NonnegativeConeT(rows.len())];
        // Of the curvature the upper triangle is wanted.
        let places = (0..size).flat_map(|j| (0..=j).map(move |i| (i, j, self.curvature[(j, i)])));
        let objective = sparse((slope.len(), slope.len()), places);
        let entries = rows.iter().enumerate();
        let entries = entries.flat_map(|(i, row)| row.entries.iter().map(move |&(j, a)| (i, j, a)));
        let matrix = sparse((rows.len(), slope.len()), entries);
        let limits: Vec<f64> = rows.iter().map(|row| row.most).collect();
        let settings = DefaultSettings {
            verbose: false,
            presolve_enable: false,
            tol_gap_abs: EXACT,
            tol_gap_rel: EXACT,
            tol_feas: EXACT,
            ..DefaultSettings::default()
        };
        let mut solver = DefaultSolver::new(&objective, &slope, &matrix, &limits, &cones, settings).ok()?;
        solver.solve();
        let solution = &solver.solution;
        if !matches!(solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved) {
            return None;
        }
        let within = solution.x.iter().zip(&self.bounds).map(|(x, [low, high])| x.clamp(*low, *high));
        Some(DVector::from_iterator(size, within))
    }
}

/// A matrix of so many rows and columns by its entries; a condition leaves most freedoms out, and what is zero is not stored.
fn sparse((rows, columns): (usize, usize), entries: impl Iterator<Item = (usize, usize, f64)>) -> CscMatrix {
    let (mut is, mut js, mut values) = (Vec::new(), Vec::new(), Vec::new());
    for (i, j, value) in entries.filter(|(.., value)| *value != 0.0) {
        is.push(i);
        js.push(j);
        values.push(value);
    }
    CscMatrix::new_from_triplets(rows, columns, is, js, values)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of two variables that are drawn to (1, 2): the nearest with what is asked of them.
    fn nearest(conditions: &[([f64; 2], f64, bool, f64)], high: f64) -> DVector<f64> {
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
        let is = |found: &DVector<f64>, x: [f64; 2]| (found - DVector::from_column_slice(&x)).amax() < 1e-6;
        assert!(is(&nearest(&[], 9.0), [1.0, 2.0]) && is(&nearest(&[], 1.5), [1.0, 1.5]));
        // A condition that is kept anyway changes nothing.
        let kept = nearest(&[([1.0, 0.0], 0.5, false, must)], 9.0);
        assert!(is(&kept, [1.0, 2.0]), "{kept:?}");
        let equal = nearest(&[([1.0, 1.0], 2.0, true, must)], 9.0);
        assert!(is(&equal, [0.5, 1.5]), "{equal:?}");
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
