//! Levenberg-Marquardt, whatever is stepped: a body schema, or the quantities of a robot.
//!
//! The problem supplies normal equations and a cost; here are only the damping (Marquardt's scaling with
//! Nielsen's update, "Damping parameter in Marquardt's method", 1999) and the reasons to stop.

use nalgebra::{DMatrix, DVector};

use crate::deadline::Deadline;

/// The Gauss-Newton model of a cost about one state.
pub struct Linearization {
    /// `JᵀWJ`; only the lower triangle is read.
    pub hessian: DMatrix<f64>,
    /// `JᵀWe`.
    pub gradient: DVector<f64>,
    /// `½ eᵀWe`.
    pub cost: f64,
    /// What steps are damped by: the diagonal of the Hessian, but of what is known from before the inverse of each
    /// parameter's own variance. Parameters that are known well only together would else hardly move.
    pub scale: DVector<f64>,
}

impl Linearization {
    /// Of a cost that is zero whatever so many parameters are.
    pub fn nothing(parameters: usize) -> Linearization {
        Linearization {
            hessian: DMatrix::zeros(parameters, parameters),
            gradient: DVector::zeros(parameters),
            cost: 0.0,
            scale: DVector::zeros(parameters),
        }
    }
}

/// A least-squares problem.
pub trait LeastSquares {
    /// What is looked for.
    type State: Clone;
    /// Normal equations at `state`. May fix weights (covariances, robust weights) that
    /// [`LeastSquares::cost`] uses until the next linearization.
    fn linearize(&mut self, state: &Self::State) -> Linearization;
    /// The cost at `state` under the weights of the last linearization.
    fn cost(&self, state: &Self::State) -> f64;
    /// `state` after a step, a number for each parameter of the normal equations.
    fn step(&self, state: &Self::State, step: &DVector<f64>) -> Self::State;
}

/// When to stop.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stopping {
    /// Most linearizations.
    pub iterations: usize,
    /// Least relative fall of the cost that counts as progress.
    pub relative_cost: f64,
    /// A cost that is as good as zero.
    pub cost: f64,
    /// When it ends wherever it is.
    pub deadline: Deadline,
}

/// How much the first step is damped, in units of the curvature along each parameter.
pub const FIRST_DAMPING: f64 = 1e-3;

/// Columns of a block of a matrix that is factorized.
const BLOCK: usize = 32;

/// Where the iteration stopped.
#[derive(Clone, Debug)]
pub struct Solution<S> {
    /// The state of least cost.
    pub state: S,
    /// Its cost under the last weights.
    pub cost: f64,
}

/// Minimises the problem's cost from `start`.
pub fn levenberg_marquardt<P: LeastSquares>(
    problem: &mut P,
    start: P::State,
    stopping: Stopping,
) -> Solution<P::State> {
    let mut damping = FIRST_DAMPING;
    damped_from(&mut damping, problem, start, stopping)
}

/// The same with the damping that the fit before, of nearly the same problem, ended with: in few steps from the first damping no
/// answer moves far along what the problem hardly feels.
pub fn damped_from<P: LeastSquares>(
    damping: &mut f64,
    problem: &mut P,
    start: P::State,
    stopping: Stopping,
) -> Solution<P::State> {
    let mut state = start;
    let mut growth = 2.0;
    let mut cost = f64::INFINITY;
    let mut small_steps = 0;
    for _ in 0..stopping.iterations {
        if stopping.deadline.has_passed() {
            break;
        }
        let model = problem.linearize(&state);
        cost = model.cost;
        if !cost.is_finite() || cost <= stopping.cost || model.gradient.is_empty() {
            return Solution { state, cost };
        }
        let floor = 1e-9 * model.scale.amax().max(f64::MIN_POSITIVE);
        loop {
            let mut damped = model.hessian.clone();
            for i in 0..damped.nrows() {
                damped[(i, i)] += *damping * model.scale[i].max(floor);
            }
            let step = solve_symmetric(damped, -&model.gradient);
            if let Some(step) = step {
                let trial = problem.step(&state, &step);
                let trial_cost = problem.cost(&trial);
                if trial_cost < cost {
                    let predicted = -model.gradient.dot(&step) - 0.5 * quadratic(&model.hessian, &step);
                    let ratio = (cost - trial_cost) / predicted.max(f64::MIN_POSITIVE);
                    *damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).clamp(1.0 / 10.0, 2.0);
                    *damping = damping.max(1e-12);
                    growth = 2.0;
                    let fall = (cost - trial_cost) / cost;
                    state = trial;
                    cost = trial_cost;
                    small_steps = if fall < stopping.relative_cost { small_steps + 1 } else { 0 };
                    break;
                }
            }
            *damping *= growth;
            growth *= 2.0;
            // No damping gives a lower cost: a minimum to rounding, which tells nothing of the next fit.
            if *damping > 1e12 {
                *damping = FIRST_DAMPING;
                return Solution { state, cost };
            }
        }
        if small_steps >= 2 {
            break;
        }
    }
    Solution { state, cost }
}

/// `A⁻¹ b` of a symmetric matrix given by its lower triangle; none where it is not positive definite. Its Cholesky factor is made
/// block by block (Golub and Van Loan, "Matrix Computations", 4.2.6): nearly all of the work is products of matrices.
fn solve_symmetric(mut a: DMatrix<f64>, mut b: DVector<f64>) -> Option<DVector<f64>> {
    let n = a.nrows();
    for start in (0..n).step_by(BLOCK) {
        let (size, next) = (BLOCK.min(n - start), n.min(start + BLOCK));
        let factor = a.view((start, start), (size, size)).clone_owned().cholesky()?.unpack();
        a.view_mut((start, start), (size, size)).copy_from(&factor);
        let inverse = factor.solve_lower_triangular(&DMatrix::identity(size, size))?;
        let below = a.view((next, start), (n - next, size)) * inverse.transpose();
        a.view_mut((next, start), (n - next, size)).copy_from(&below);
        let beside = below.transpose();
        for column in (next..n).step_by(BLOCK) {
            let (from, width) = (column - next, BLOCK.min(n - column));
            let mut left = a.view_mut((column, column), (n - column, width));
            left.gemm(-1.0, &below.rows(from, n - column), &beside.columns(from, width), 1.0);
        }
    }
    a.solve_lower_triangular_mut(&mut b);
    a.ad_solve_lower_triangular_mut(&mut b);
    Some(b)
}

/// `xᵀ A x` of a symmetric matrix given by its lower triangle.
fn quadratic(a: &DMatrix<f64>, x: &DVector<f64>) -> f64 {
    let mut sum = 0.0;
    for j in 0..a.ncols() {
        let column = a.column(j);
        let below: f64 = (j + 1..a.nrows()).map(|i| column[i] * x[i]).sum();
        sum += x[j] * (column[j] * x[j] + 2.0 * below);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symmetric_equations_of_any_size_are_solved_or_refused() {
        for n in [0, 1, 31, 32, 33, 64, 100] {
            let root = DMatrix::from_fn(n, n, |i, j| ((7 * i + 13 * j + i * j) as f64).sin());
            let a = &root * root.transpose() + DMatrix::identity(n, n);
            let x = DVector::from_fn(n, |i, _| (i as f64).cos());
            let found = solve_symmetric(a.lower_triangle(), &a * &x).unwrap();
            assert!((found - x).amax() < 1e-9, "{n}");
            let mut indefinite = a;
            if n > 0 {
                indefinite[(n - 1, n - 1)] = -1.0;
                assert!(solve_symmetric(indefinite, DVector::zeros(n)).is_none());
            }
        }
    }
}
