//! How joints are to turn at an instant so that limbs keep clear, a place goes where it is wanted, and all else keeps
//! still as far as it can: one quadratic program over the joints' velocities.
//!
//! Minimised is, over velocities `v` of the joints that may move,
//!
//! ```text
//! ½ ε |v|² + ½ Σ_places w |J_p v − u|² + ½ Σ_joints w (v − u)² + λ s + ½ μ s²
//! ```
//!
//! where every barrier asks that a gap `h` changes by at least some rate, `n·(J_a − J_b) v + s ≥ r − ∂h/∂t`, joints stay in
//! their ranges and below their greatest speed, and `s ≥ 0` is by how much the barriers that may be given up are given up
//! where they cannot all be kept; the others have no `s`. Such barriers keep `h ≥ 0` where the rate asked for is `−γ h` (control barrier functions: Ames et al. 2017);
//! the program is differential inverse kinematics with constraints (Kanoun et al. 2011). Its dual is solved,
//! of as many variables as there are constraints that matter, mostly few or none, by an interior-point method (Clarabel:
//! Goulart and Chen 2024).

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use nalgebra::{DMatrix, DVector, Vector3};

use super::own_body::OwnBody;
use crate::creature::{DofKind, Posture};
use crate::geometry::Frame;
use crate::kinematics::axis_directions;

/// What a joint's own velocity costs, so that what does nothing does not move: (m/s)² per (rad/s)².
const IDLE: f64 = 1e-3;
/// What giving up a barrier costs, per m/s and per (m/s)²: more than any motion is worth.
const GIVEN_UP: [f64; 2] = [300.0, 300.0];
/// By how much a constraint may be missed, metres or radians a second, and how exact the dual program is.
const TOLERANCE: f64 = 1e-5;
const EXACT: f64 = 1e-9;

/// A place of a limb that is to go somewhere.
#[derive(Clone, Copy, Debug)]
pub struct PlaceVelocity {
    /// The limb.
    pub limb: usize,
    /// The point, in the root's frame, metres.
    pub point: Vector3<f64>,
    /// How fast it is to go, in the root's frame, metres a second.
    pub velocity: Vector3<f64>,
    /// What it is worth.
    pub weight: f64,
}

/// A gap that is to change by at least some rate.
#[derive(Clone, Copy, Debug)]
pub struct Barrier {
    /// The limb.
    pub limb: usize,
    /// Its point, in the root's frame, metres.
    pub point: Vector3<f64>,
    /// The other limb, and its point; none where the other moves by itself or not at all.
    pub other: Option<(usize, Vector3<f64>)>,
    /// The unit direction from the other to the limb.
    pub normal: Vector3<f64>,
    /// The least rate at which the gap is to grow by the body's own motion, metres a second; below 0 it may shrink.
    pub rate: f64,
    /// Whether it is given up where it cannot be kept with all others. One that asks for no more than that the gap grows no
    /// smaller is kept by who stands still, and need not be.
    pub yields: bool,
}

/// How joints turn.
#[derive(Clone, Debug)]
pub struct JointVelocity {
    /// Per coordinate of the posture, radians or metres a second.
    pub coordinates: Vec<f64>,
    /// By how much the barrier that is kept least is missed, metres a second.
    pub given_up: f64,
}

/// What turns together with a coordinate that moves by itself: the coordinate, its joint, how it moves what it carries,
/// and how fast for each unit of the leader's.
#[derive(Clone, Copy, Debug)]
struct Mover {
    coordinate: usize,
    joint: usize,
    axis: Vector3<f64>,
    /// A point on the axis; none for a slide.
    origin: Option<Vector3<f64>>,
    ratio: f64,
}

/// One variable of the program.
#[derive(Clone, Debug)]
struct Column {
    movers: Vec<Mover>,
    /// The least and the greatest velocity.
    bounds: [f64; 2],
}

/// The program at an instant.
#[derive(Clone, Debug)]
pub struct VelocityProgram<'a> {
    own: &'a OwnBody,
    posture: &'a [f64],
    columns: Vec<Column>,
    /// Per joint, whether it carries a limb: an index of `joint * limbs + limb`.
    carries: Vec<bool>,
    objective: DMatrix<f64>,
    linear: DVector<f64>,
    barriers: Vec<Barrier>,
}

impl<'a> VelocityProgram<'a> {
    /// A program in which some joints may move, at most so many radians (or metres) a second, so that after `seconds` they
    /// are still in their ranges. `frames` are the limbs' in `posture`.
    pub fn new(
        own: &'a OwnBody,
        posture: &'a [f64],
        frames: &[Frame],
        joints: &[usize],
        fastest: f64,
        seconds: f64,
    ) -> VelocityProgram<'a> {
        let creature = own.creature();
        let limbs = creature.limbs().len();
        let mut carries = vec![false; creature.joints().len() * limbs];
        for limb in 0..limbs {
            let mut carried = limb;
            while carried > 0 {
                carries[(carried - 1) * limbs + limb] = true;
                carried = creature.joints()[carried - 1].parent;
            }
        }
        let mut directions = axis_directions(creature, &own.schema, posture, frames).into_iter();
        let elements: Vec<_> = creature.elements().collect();
        // Where each element's column is, for what follows it.
        let mut column_of = vec![None; elements.len()];
        let mut columns: Vec<Column> = Vec::new();
        let owners =
            creature.joints().iter().enumerate().flat_map(|(j, joint)| joint.elements().map(move |_| j));
        let mut followers = Vec::new();
        for (k, (at, joint)) in elements.iter().zip(owners).enumerate() {
            if at.is_ball() {
                continue;
            }
            let Some((_, axis)) = directions.next() else { break };
            let hinge = at.kind == DofKind::Hinge;
            // All degrees of freedom of a joint share its position.
            let parent = &frames[creature.joints()[joint].parent];
            let origin = hinge.then(|| parent.point(&own.schema.positions[joint]));
            let mover = Mover { coordinate: at.coordinate(), joint, axis, origin, ratio: 1.0 };
            match &at.follows {
                Some(coupling) => followers.push((coupling, mover)),
                None if joints.contains(&joint) => {
                    let q = posture[at.coordinate()];
                    let [low, high] = at.range.map(|end| ((end - q) / seconds).clamp(-fastest, fastest));
                    column_of[k] = Some(columns.len());
                    columns.push(Column { movers: vec![mover], bounds: [low.min(0.0), high.max(0.0)] });
                }
                None => {}
            }
        }
        for (coupling, mover) in followers {
            const SMALL: f64 = 1e-4;
            if let Some(column) = column_of[coupling.leader] {
                let at = posture[elements[coupling.leader].coordinate()];
                let ratio = (coupling.follow(at + SMALL) - coupling.follow(at - SMALL)) / (2.0 * SMALL);
                columns[column].movers.push(Mover { ratio, ..mover });
            }
        }
        let size = columns.len();
        let objective = DMatrix::from_diagonal_element(size, size, IDLE);
        let linear = DVector::zeros(size);
        VelocityProgram { own, posture, columns, carries, objective, linear, barriers: Vec::new() }
    }

    /// How a point of a limb, in the root's frame, moves with each variable, metres a second for each unit.
    fn jacobian(&self, limb: usize, point: &Vector3<f64>) -> impl Iterator<Item = Vector3<f64>> {
        let limbs = self.own.creature().limbs().len();
        let point = *point;
        self.columns.iter().map(move |column| {
            let moves = column.movers.iter().filter(|mover| self.carries[mover.joint * limbs + limb]);
            let velocity = moves.map(|mover| match mover.origin {
                Some(origin) => mover.axis.cross(&(point - origin)) * mover.ratio,
                None => mover.axis * mover.ratio,
            });
            velocity.sum()
        })
    }

    /// Wants a place to go somewhere, or to stay where it is.
    pub fn want(&mut self, wanted: &PlaceVelocity) {
        let jacobian: Vec<Vector3<f64>> = self.jacobian(wanted.limb, &wanted.point).collect();
        for (i, a) in jacobian.iter().enumerate() {
            let scaled = a * wanted.weight;
            self.linear[i] -= scaled.dot(&wanted.velocity);
            for (j, b) in jacobian.iter().enumerate().take(i + 1) {
                self.objective[(j, i)] += scaled.dot(b);
            }
        }
    }

    /// Wants a coordinate to change so fast, radians or metres a second. One that does not move by itself is passed over.
    pub fn want_joint(&mut self, coordinate: usize, velocity: f64, weight: f64) {
        if let Some(k) = self.columns.iter().position(|column| column.movers[0].coordinate == coordinate) {
            self.objective[(k, k)] += weight;
            self.linear[k] -= weight * velocity;
        }
    }

    /// Asks for a gap to be kept.
    pub fn keep(&mut self, barrier: Barrier) {
        self.barriers.push(barrier);
    }

    /// Solves it; none where no joint may move or the solver fails.
    pub fn solve(&self) -> Option<JointVelocity> {
        let size = self.columns.len();
        if size == 0 {
            return None;
        }
        // The last variable is by how much barriers are given up.
        let mut objective = DMatrix::zeros(size + 1, size + 1);
        objective.view_mut((0, 0), (size, size)).copy_from(&self.objective);
        objective[(size, size)] = GIVEN_UP[1];
        objective.fill_lower_triangle_with_upper_triangle();
        let factor = objective.cholesky()?;
        let free = factor.solve(&-self.linear.clone().insert_row(size, GIVEN_UP[0]));
        let rows = self.constraints();
        // Few constraints ever matter: those that are broken without them are asked for, until none is.
        let mut asked: Vec<usize> = Vec::new();
        let mut pushes = DMatrix::zeros(size + 1, 0);
        let mut solution = free.clone();
        // Nothing is given up as long as no barrier asks for it.
        solution[size] = 0.0;
        let given_up = self.barriers.len();
        loop {
            let known = asked.len();
            let broken = |row: &usize| !asked.contains(row) && rows[*row].missed_by(&solution) > TOLERANCE;
            let news: Vec<usize> = (0..rows.len()).filter(broken).collect();
            asked.extend(news);
            if asked.len() == known {
                break;
            }
            if !asked.contains(&given_up) && asked.iter().any(|&row| rows[row].coefficients[size] > 0.0) {
                asked.push(given_up);
            }
            pushes = pushes.resize_horizontally(asked.len(), 0.0);
            for (k, &row) in asked.iter().enumerate().skip(known) {
                pushes.set_column(k, &factor.solve(&rows[row].coefficients));
            }
            let of: Vec<&Constraint> = asked.iter().map(|&row| &rows[row]).collect();
            solution = &free + &pushes * forces(&of, &pushes, &free)?;
            solution[size] = solution[size].max(0.0);
        }
        let mut coordinates = vec![0.0; self.posture.len()];
        for (column, velocity) in self.columns.iter().zip(solution.iter()) {
            for mover in &column.movers {
                coordinates[mover.coordinate] =
                    mover.ratio * velocity.clamp(column.bounds[0], column.bounds[1]);
            }
        }
        Some(JointVelocity { coordinates, given_up: solution[size] })
    }

    /// All constraints: of the barriers, of what is given up, and of each variable's bounds.
    fn constraints(&self) -> Vec<Constraint> {
        let size = self.columns.len();
        let mut rows = Vec::with_capacity(self.barriers.len() + 1 + 2 * size);
        for barrier in &self.barriers {
            let mut coefficients = DVector::zeros(size + 1);
            for (k, own) in self.jacobian(barrier.limb, &barrier.point).enumerate() {
                coefficients[k] = barrier.normal.dot(&own);
            }
            if let Some((limb, point)) = barrier.other {
                for (k, other) in self.jacobian(limb, &point).enumerate() {
                    coefficients[k] -= barrier.normal.dot(&other);
                }
            }
            coefficients[size] = f64::from(u8::from(barrier.yields));
            rows.push(Constraint { coefficients, least: barrier.rate });
        }
        let mut one = |k: usize, sign: f64, least: f64| {
            let mut coefficients = DVector::zeros(size + 1);
            coefficients[k] = sign;
            rows.push(Constraint { coefficients, least });
        };
        one(size, 1.0, 0.0);
        for (k, column) in self.columns.iter().enumerate() {
            one(k, 1.0, column.bounds[0]);
            one(k, -1.0, -column.bounds[1]);
        }
        rows
    }
}

/// The variables' sum by some coefficients is to be so much at least.
struct Constraint {
    coefficients: DVector<f64>,
    least: f64,
}

impl Constraint {
    fn missed_by(&self, solution: &DVector<f64>) -> f64 {
        self.least - self.coefficients.dot(solution)
    }
}

/// How hard each of some constraints has to push from the least of the objective, `free`: the dual program, of as many
/// variables as there are constraints. `pushes` has in its columns where the variables go by a unit's push of each.
fn forces(rows: &[&Constraint], pushes: &DMatrix<f64>, free: &DVector<f64>) -> Option<DVector<f64>> {
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
    let linear: Vec<f64> = rows.iter().map(|row| -row.missed_by(free)).collect();
    let constraints = CscMatrix::new(size, size, (0..=size).collect(), (0..size).collect(), vec![-1.0; size]);
    let settings = DefaultSettings {
        verbose: false,
        presolve_enable: false,
        tol_gap_abs: EXACT,
        tol_gap_rel: EXACT,
        tol_feas: EXACT,
        ..DefaultSettings::default()
    };
    let cones = [SupportedConeT::NonnegativeConeT(size)];
    let mut solver =
        DefaultSolver::new(&objective, &linear, &constraints, &vec![0.0; size], &cones, settings).ok()?;
    solver.solve();
    let solved = matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved);
    solved.then(|| DVector::from_iterator(size, solver.solution.x.iter().map(|force| force.max(0.0))))
}

impl JointVelocity {
    /// The posture after so many seconds, within the joints' ranges.
    pub fn after(&self, own: &OwnBody, posture: &[f64], seconds: f64) -> Posture {
        let mut next = Posture::from(posture);
        for at in own.creature().elements().filter(|at| !at.is_ball()) {
            let q = at.coordinate();
            if self.coordinates[q] != 0.0 {
                next[q] = (next[q] + self.coordinates[q] * seconds).clamp(at.range[0], at.range[1]);
            }
        }
        own.creature().couple(&mut next);
        next
    }
}
