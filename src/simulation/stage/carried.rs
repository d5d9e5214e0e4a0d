//! A carried thing, and the limb or path that carries it.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::creature::Body;
use crate::geometry::wxyz;
use crate::mujoco::Data;
use crate::simulation::ProbePath;

/// A thing that does not move independently for now.
pub struct Carried {
    /// The model's body.
    pub body: usize,
    /// Where its coordinates and velocities start.
    pub qposadr: usize,
    pub dofadr: usize,
    pub by: Carrier,
}

/// What carries a thing.
pub enum Carrier {
    /// A limb that holds it.
    Limb(Grip),
    /// A path of its origin through the world, and its orientation.
    Path(ProbePath, UnitQuaternion<f64>),
}

/// How a limb holds a thing.
pub struct Grip {
    pub limb: usize,
    /// The receptor that it is held with.
    pub receptor: usize,
    /// `X_LT`.
    pub pose: Isometry3<f64>,
    /// `X_WT` of where a partner took it from who put it into the hand, and takes it back to; `None` if the limb took it.
    pub given_from: Option<Isometry3<f64>>,
}

impl Carried {
    /// The grip, where a limb holds it.
    pub fn grip(&self) -> Option<&Grip> {
        match &self.by {
            Carrier::Limb(grip) => Some(grip),
            Carrier::Path(..) => None,
        }
    }

    /// `X_WT` of where a partner took it from who put it into the hand.
    pub fn given_from(&self) -> Option<Isometry3<f64>> {
        self.grip()?.given_from
    }

    /// Puts it where it is carried to, at the end of a step from one time to another; `data` has the creature's poses of
    /// then.
    pub fn put(&self, body: &Body, data: &Data, [from, to]: [f64; 2], qpos: &mut [f64], qvel: &mut [f64]) {
        // What a limb holds goes with it; what goes by itself has a velocity of its own.
        let (pose, velocity) = match &self.by {
            Carrier::Limb(grip) => {
                (body.limb_pose(data, grip.limb).unwrap_or_default() * grip.pose, Vector3::zeros())
            }
            Carrier::Path(path, turn) => {
                let [before, now] = [from, to].map(|time| path.at(time).unwrap_or_default());
                (Isometry3::from_parts(Translation3::from(now), *turn), (now - before) / (to - from))
            }
        };
        self.put_at(&pose, &velocity, qpos, qvel);
    }

    /// Puts it to a pose `X_WT`, at a velocity.
    pub fn put_at(&self, pose: &Isometry3<f64>, velocity: &Vector3<f64>, qpos: &mut [f64], qvel: &mut [f64]) {
        let (q, v) = (self.qposadr, self.dofadr);
        qpos[q..q + 3].copy_from_slice(pose.translation.vector.as_slice());
        qpos[q + 3..q + 7].copy_from_slice(&wxyz(&pose.rotation));
        qvel[v..v + 3].copy_from_slice(velocity.as_slice());
        qvel[v + 3..v + 6].fill(0.0);
    }
}
