//! Things that do not move by themselves: held by a limb, or sent along a path whatever they meet.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

use super::Stage;
use crate::creature::Body;
use crate::mujoco::Data;
use crate::simulation::ProbePath;

/// A thing that does not move by itself for now.
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
    /// `X_WT` of where a partner took it from who put it into the hand, and takes it back to; none where the limb took it.
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
        let turn: &Quaternion<f64> = pose.rotation.quaternion();
        qpos[q..q + 3].copy_from_slice(pose.translation.vector.as_slice());
        qpos[q + 3..q + 7].copy_from_slice(&[turn.w, turn.i, turn.j, turn.k]);
        qvel[v..v + 3].copy_from_slice(velocity.as_slice());
        qvel[v + 3..v + 6].fill(0.0);
    }
}

impl Stage {
    /// Lets a thing go along a path alone, whatever it meets.
    ///
    /// # Panics
    /// Where it is no thing that moves.
    pub fn send_thing(&self, thing: usize, path: ProbePath) {
        let core = &mut *self.core.borrow_mut();
        let (qposadr, dofadr) = core.free_joint(thing).expect("a thing that moves");
        let turn = core.data.body_pose(thing).rotation;
        core.carry(Carried { body: thing, qposadr, dofadr, by: Carrier::Path(path, turn) });
    }

    /// Welds the thing that a receptor's limb touches to that limb; whether there was one.
    pub(in crate::simulation) fn hold(&self, receptor: usize) -> bool {
        let core = &mut *self.core.borrow_mut();
        let limb = core.agent.skin().receptors[receptor].limb;
        let touched = core.data.contacts().find_map(|contact| {
            let [a, b] = contact.geoms.map(|g| (core.body.limb_of_geom(g), core.body.model.geom_body(g)));
            let thing = match (a, b) {
                ((Some(l), _), (None, thing)) | ((None, thing), (Some(l), _)) if l == limb => thing,
                _ => return None,
            };
            // What was put into a hand is held already.
            let given = |carried: &Carried| {
                carried.body == thing && carried.grip().is_some_and(|grip| grip.given_from.is_some())
            };
            let (q, v) = core.free_joint(thing).filter(|_| !core.carried.iter().any(given))?;
            Some((thing, q, v))
        });
        let Some((body, qposadr, dofadr)) = touched else { return false };
        let x_wl = core.body.limb_pose(&core.data, limb).unwrap_or_default();
        let pose = x_wl.inv_mul(&core.data.body_pose(body));
        let by = Carrier::Limb(Grip { limb, receptor, pose, given_from: None });
        core.carry(Carried { body, qposadr, dofadr, by });
        true
    }

    /// Lets go of all that it took hold of.
    pub(in crate::simulation) fn let_go(&self) {
        let taken = |carried: &Carried| carried.grip().is_some_and(|grip| grip.given_from.is_none());
        self.core.borrow_mut().carried.retain(|carried| !taken(carried));
    }
}
