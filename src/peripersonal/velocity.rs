//! How joints are to turn at an instant so that limbs keep clear, a place goes where it is wanted, and all else keeps
//! still as far as it can: one quadratic program over the joints' velocities.
//!
//! Minimised is, over velocities `v` of the joints that may move,
//!
//! ```text
//! ½ ε |v|² + ½ Σ_places w |J_p v − u|² + ½ Σ_joints w (v − u)² + λ Σ_barriers (what it is missed by)
//! ```
//!
//! where every barrier asks that a gap `h` changes by at least some rate, `n·(J_a − J_b) v ≥ r − ∂h/∂t`, and joints stay in
//! their ranges and below their greatest speed. Barriers that do not yield are never missed. They keep `h ≥ 0` where the
//! rate asked for is `−γ h` (control barrier functions: Ames et al. 2017); the program is differential inverse kinematics
//! with constraints (Kanoun et al. 2011).

use nalgebra::{DMatrix, DVector, Vector3};

use super::own_body::OwnBody;
use crate::creature::Posture;
use crate::geometry::Frame;
use crate::kinematics::{Condition, Feature, FreeMotions, Freedoms, QuadraticProgram};

/// What a joint's own velocity costs, so that what does nothing does not move: (m/s)² per (rad/s)².
const IDLE: f64 = 1e-3;
/// What missing a barrier that yields costs, per m/s: more than any motion is worth.
const GIVEN_UP: f64 = 1000.0;

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
    /// The other limb; `None` if the other moves independently or not at all.
    pub other: Option<usize>,
    /// The point of either, in the root's frame, metres.
    pub points: [Vector3<f64>; 2],
    /// The unit direction from the other to the limb.
    pub normal: Vector3<f64>,
    /// The least rate at which the gap is to grow by the body's own motion, metres a second; below 0 it may shrink.
    pub rate: f64,
    /// Whether it is given up where it cannot be kept with all others. One that asks for no more than that the gap grows no
    /// smaller is kept by who stands still, and need not be.
    pub yields: bool,
}

/// Where joints get to in a step.
#[derive(Clone, Debug)]
pub struct SteppedPosture {
    /// The posture after it, within the joints' ranges.
    pub posture: Posture,
    /// By how much the barrier that is kept least is missed, metres a second.
    pub given_up: f64,
}

/// The program at an instant.
#[derive(Clone, Debug)]
pub struct VelocityProgram<'a> {
    posture: &'a [f64],
    seconds: f64,
    freedoms: Freedoms<'a>,
    motions: FreeMotions,
    program: QuadraticProgram,
}

impl<'a> VelocityProgram<'a> {
    /// A program in which some joints may move, at most so many radians (or metres) a second, so that after `seconds` they
    /// are still in their ranges; `frames` is where the posture has the limbs.
    pub fn new(
        own: &'a OwnBody,
        posture: &'a [f64],
        frames: &[Frame],
        joints: &[usize],
        fastest: f64,
        seconds: f64,
    ) -> VelocityProgram<'a> {
        let freedoms = Freedoms::new(own.creature(), &own.schema, joints);
        let motions = freedoms.at_frames(posture, frames.to_vec());
        let size = freedoms.count();
        let bounds = |k: usize| freedoms.bounds(k, posture, fastest * seconds).map(|most| most / seconds);
        let program = QuadraticProgram {
            curvature: DMatrix::from_diagonal_element(size, size, IDLE),
            slope: DVector::zeros(size),
            bounds: (0..size).map(bounds).collect(),
            conditions: Vec::new(),
        };
        VelocityProgram { posture, seconds, freedoms, motions, program }
    }

    /// Wants a place to go somewhere, or to stay where it is.
    pub fn want(&mut self, wanted: &PlaceVelocity) {
        for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
            let mut rates = DVector::zeros(self.freedoms.count());
            self.motions.add_rates(wanted.limb, Feature::Point(wanted.point), &axis, rates.as_mut_slice());
            self.program.curvature.ger(wanted.weight, &rates, &rates, 1.0);
            self.program.slope.axpy(-wanted.weight * wanted.velocity.dot(&axis), &rates, 1.0);
        }
    }

    /// Wants a coordinate to change so fast, radians or metres a second. One that follows another is ignored.
    pub fn want_joint(&mut self, coordinate: usize, velocity: f64, weight: f64) {
        if let Some(k) = self.freedoms.of_coordinate(coordinate) {
            self.program.curvature[(k, k)] += weight;
            self.program.slope[k] -= weight * velocity;
        }
    }

    /// Asks for a gap to be kept.
    pub fn keep(&mut self, barrier: &Barrier) {
        let mut coefficients = DVector::zeros(self.freedoms.count());
        let (limbs, rates) = ([Some(barrier.limb), barrier.other], coefficients.as_mut_slice());
        self.motions.add_gap_rates(limbs, &barrier.points, &barrier.normal, rates);
        let price = if barrier.yields { GIVEN_UP } else { f64::INFINITY };
        let condition = Condition { coefficients, least: barrier.rate, exactly: false, price };
        self.program.conditions.push(condition);
    }

    /// Solves it; `None` if no joint may move or the solver fails.
    pub fn solve(&self) -> Option<SteppedPosture> {
        let velocities = (self.freedoms.count() > 0).then(|| self.program.solve())??;
        let missed = self.program.conditions.iter().map(|condition| condition.missed_by(&velocities));
        let given_up = missed.fold(0.0, f64::max);
        let change = velocities * self.seconds;
        Some(SteppedPosture { posture: self.freedoms.changed(self.posture, change.as_slice()), given_up })
    }
}
