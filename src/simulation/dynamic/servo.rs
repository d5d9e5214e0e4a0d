//! Position servos: the torques that carry a body along a way through its postures.
//!
//! Computed-torque control: what the wanted acceleration costs with the body's inertia, and what gravity, Coriolis and
//! passive forces ask for besides. What lags behind its way is drawn after it like a critically damped spring, which
//! yields where something is in the path.

use std::sync::Arc;

use nalgebra::{UnitQuaternion, Vector3};

use crate::creature::{Body, ball};
use crate::error::Result;
use crate::mujoco::{Data, JointKind, LONGEST_STEP, Model};

/// How many steps of the next finer kind are in one.
pub(super) const FINER: f64 = 16.0;
/// Kinds of steps.
const LEVELS: i32 = 3;
/// How fast a servo makes up for what it lags behind, radians per second.
const STIFFNESS: f64 = 25.0;
/// The most that a servo pulls for: a joint that is held up lags behind further, but no harder; radians …
const YIELD_ANGLE: f64 = 0.1;
/// … and metres.
const YIELD_SHIFT: f64 = 0.02;
/// The fastest that a hinge or a ball turns on its way, radians per second …
const TURNING: f64 = 2.0;
/// … and a slide shifts, metres per second.
const SHIFTING: f64 = 0.3;
/// The least time for a way, seconds.
const SHORTEST: f64 = 0.3;
/// Peak speed of a minimum-jerk way, in its mean speeds.
const PEAK: f64 = 1.875;

/// One joint of the model that the creature moves.
struct Drive {
    kind: JointKind,
    /// The place of its first coordinate in `qpos`.
    coordinate: usize,
    /// The place of its first velocity in `qvel`.
    velocity: usize,
}

/// The servos of a body, and its model in the steps that they work in: what its simulations share.
pub struct Servo {
    /// The body's model in ever finer steps.
    pub levels: Vec<Arc<Model>>,
    drives: Vec<Drive>,
    /// Per number of `qpos`, whether a servo moves it.
    moved: Vec<bool>,
    /// Per number of `qvel`, whether it stays where it is.
    rigid: Vec<bool>,
}

/// A way between two vectors `qpos`: minimum jerk, every joint straight, all of them at the same pace.
pub struct ServoPath {
    start: Vec<f64>,
    /// Per number of `qvel`, how far it goes; balls in the frame that they turn.
    length: Vec<f64>,
    /// When it begins, and how long it takes, seconds.
    pub began: f64,
    duration: f64,
}

impl ServoPath {
    /// When it ends, seconds.
    pub fn end(&self) -> f64 {
        self.began + self.duration
    }

    /// The share of the way at a time, its rate and the rate of that.
    fn pace(&self, time: f64) -> [f64; 3] {
        let u = ((time - self.began) / self.duration).clamp(0.0, 1.0);
        let (rate, t) = (1.0 / self.duration, 1.0 - u);
        [
            u * u * u * (10.0 - 15.0 * u + 6.0 * u * u),
            30.0 * u * u * t * t * rate,
            60.0 * u * t * (1.0 - 2.0 * u) * rate * rate,
        ]
    }
}

impl Servo {
    /// Servos for what the creature moves; all other joints of the model stay where they are.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn new(body: &Body) -> Result<Servo> {
        let model = &body.model;
        let (mut moved, mut rigid) = (vec![false; model.nq()], vec![true; model.nv()]);
        let joints = body.segments.iter().flat_map(|segment| &segment.joints);
        let drive = |&j: &usize| {
            let joint = model.joint(j);
            moved[joint.qposadr..][..joint.kind.nq()].fill(true);
            rigid[joint.dofadr..][..joint.kind.nv()].fill(false);
            Drive { kind: joint.kind, coordinate: joint.qposadr, velocity: joint.dofadr }
        };
        let drives = joints.map(drive).collect();
        let first = model.timestep().min(LONGEST_STEP);
        let level = |level: i32| {
            // From the model as it was declared: the engine cannot copy one whose excludes are gone.
            let simulated = body.declared.simulated(first / FINER.powi(level), &rigid, false)?;
            Ok(Arc::new(simulated.touching_with(body.surface())?))
        };
        let levels = (0..LEVELS).map(level).collect::<Result<_>>()?;
        Ok(Servo { levels, drives, moved, rigid })
    }

    /// The way from one `qpos` to another, from a time on.
    pub fn path(&self, start: &[f64], target: &[f64], began: f64) -> ServoPath {
        let mut length = vec![0.0; self.rigid.len()];
        let mut duration = SHORTEST;
        for drive in &self.drives {
            let (from, to) = (&start[drive.coordinate..], &target[drive.coordinate..]);
            if drive.kind == JointKind::Ball {
                let turn = (ball(from).inverse() * ball(to)).scaled_axis();
                length[drive.velocity..][..3].copy_from_slice(turn.as_slice());
                duration = f64::max(duration, PEAK * turn.norm() / TURNING);
            } else {
                let speed = if drive.kind == JointKind::Slide { SHIFTING } else { TURNING };
                length[drive.velocity] = to[0] - from[0];
                duration = f64::max(duration, PEAK * length[drive.velocity].abs() / speed);
            }
        }
        ServoPath { start: start.to_vec(), length, began, duration }
    }

    /// How far the body is from its way at a time: per number of `qvel`, radians and metres.
    pub fn lag(&self, path: &ServoPath, time: f64, qpos: &[f64]) -> Vec<f64> {
        let [share, ..] = path.pace(time);
        let mut lag = vec![0.0; self.rigid.len()];
        for drive in &self.drives {
            let (q, v) = (drive.coordinate, drive.velocity);
            if drive.kind == JointKind::Ball {
                let turned = UnitQuaternion::from_scaled_axis(
                    Vector3::from_column_slice(&path.length[v..v + 3]) * share,
                );
                let behind = (ball(&qpos[q..]).inverse() * ball(&path.start[q..]) * turned).scaled_axis();
                lag[v..v + 3].copy_from_slice(behind.as_slice());
            } else {
                lag[v] = path.start[q] + share * path.length[v] - qpos[q];
            }
        }
        lag
    }

    /// The forces on all degrees of freedom at a time of the way, newtons and newton metres; after
    /// [`Data::step1`].
    pub fn forces(&self, path: &ServoPath, time: f64, data: &Data) -> Vec<f64> {
        let [_, rate, change] = path.pace(time);
        let mut wanted = vec![0.0; self.rigid.len()];
        let lag = self.lag(path, time, data.qpos());
        for drive in &self.drives {
            let v = drive.velocity..drive.velocity + drive.kind.nv();
            let most = if drive.kind == JointKind::Slide { YIELD_SHIFT } else { YIELD_ANGLE };
            let behind = lag[v.clone()].iter().map(|x| x * x).sum::<f64>().sqrt();
            let pull = if behind > most { most / behind } else { 1.0 };
            for k in v {
                let slow = rate * path.length[k] - data.qvel()[k];
                wanted[k] =
                    change * path.length[k] + 2.0 * STIFFNESS * slow + STIFFNESS * STIFFNESS * pull * lag[k];
            }
        }
        let mut forces = data.mul_inertia(&wanted);
        for ((force, bias), passive) in forces.iter_mut().zip(data.qfrc_bias()).zip(data.qfrc_passive()) {
            *force += bias - passive;
        }
        forces
    }

    /// Puts what no servo moves back to where it was: `held` is a vector `qpos`.
    pub fn hold(&self, held: &[f64], qpos: &mut [f64], qvel: &mut [f64]) {
        for ((q, held), _) in qpos.iter_mut().zip(held).zip(&self.moved).filter(|(_, moved)| !**moved) {
            *q = *held;
        }
        for (v, _) in qvel.iter_mut().zip(&self.rigid).filter(|(_, rigid)| **rigid) {
            *v = 0.0;
        }
    }
}
