//! A creature in its model: the mapping between the engine's elements and the creature's.

use std::sync::Arc;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::{Creature, Posture};
use crate::error::Result;
use crate::geometry::Frame;
use crate::mujoco::{Data, Equality, Geom, JointKind, Model};

/// One joint of the creature in the model: consecutive MuJoCo joints of a body that share an anchor.
#[derive(Clone, Debug)]
pub struct Segment {
    /// The MuJoCo body that it moves.
    pub body: usize,
    /// Its MuJoCo joints, each one degree of freedom (a ball: three).
    pub joints: Vec<usize>,
    /// Whether it is the last of its body, so that the limb it carries bears the body's geoms.
    pub last: bool,
    /// The limb it is mounted on.
    pub parent: usize,
}

/// A creature in its model: what moves what, and where the limbs' frames are on MuJoCo's bodies.
#[derive(Clone, Debug)]
pub struct Body {
    /// What the agent is given.
    pub creature: Creature,
    /// The model, in which the creature's surface can touch itself and nothing else collides.
    pub model: Arc<Model>,
    /// The model as its file has it.
    pub declared: Arc<Model>,
    /// Per geom, whether it is surface that can be touched.
    pub(super) surface: Vec<bool>,
    /// Per joint of the creature, the MuJoCo joints it is made of.
    pub segments: Vec<Segment>,
    /// Per MuJoCo body, the limb it belongs to; none for what is not the creature's.
    pub limb_of_body: Vec<Option<usize>>,
    /// Per MuJoCo body, `X_LB`: its pose in its limb's frame.
    pub pose_in_limb: Vec<Isometry3<f64>>,
    /// The MuJoCo body that is the root limb (0 where the creature is mounted on the world).
    pub root: usize,
    /// `qpos` of the reference posture; joints that do not move keep these coordinates.
    pub(super) base: Vec<f64>,
    /// Per posture coordinate, its place in `qpos` and what `qpos` is at coordinate zero.
    pub(super) addresses: Vec<(usize, f64)>,
    /// Per ball joint, the place of its quaternion in `qpos` and `R_LB`: MuJoCo's coordinates turn about
    /// the body's axes as the ball finds them, a posture's about the limb's.
    pub(super) balls: Vec<(usize, UnitQuaternion<f64>)>,
}

impl Body {
    /// Data of the model at the reference posture, poses computed.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn reference_data(&self) -> Result<Data> {
        let mut data = Data::new(self.model.clone())?;
        data.set_qpos(&self.base)?;
        data.kinematics()?;
        Ok(data)
    }

    /// Puts the creature into a posture and all else where it was at first, poses computed.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn put(&self, posture: &[f64], data: &mut Data) -> Result<()> {
        data.set_qpos(&self.qpos(posture))?;
        Ok(data.kinematics()?)
    }

    /// `X_WL` of every limb at the reference posture: its joint's anchor, the root's orientation.
    pub fn reference_frames(&self, data: &Data) -> Vec<Isometry3<f64>> {
        let root = data.body_pose(self.root);
        let mut frames = vec![root];
        for segment in &self.segments {
            let turning = segment.joints.iter().find(|&&j| self.model.joint(j).kind != JointKind::Slide);
            let anchor = data.joint_anchor(*turning.unwrap_or(&segment.joints[0]));
            frames.push(Isometry3::from_parts(Translation3::from(anchor.coords), root.rotation));
        }
        frames
    }

    /// A posture of the creature as the engine's `qpos`.
    pub fn qpos(&self, posture: &[f64]) -> Vec<f64> {
        let mut qpos = self.base.clone();
        for (&(address, zero), coordinate) in self.addresses.iter().zip(posture) {
            qpos[address] = zero + coordinate;
        }
        for (address, orientation) in &self.balls {
            let axis = &mut qpos[address + 1..address + 4];
            let turned = orientation.inverse_transform_vector(&Vector3::from_column_slice(axis));
            axis.copy_from_slice(turned.as_slice());
        }
        qpos
    }

    /// The posture of the creature in a `qpos` vector: the inverse of [`Body::qpos`].
    pub fn read_posture(&self, qpos: &[f64]) -> Posture {
        let mut qpos = qpos.to_vec();
        for (address, orientation) in &self.balls {
            let axis = &mut qpos[address + 1..address + 4];
            let turned = orientation.transform_vector(&Vector3::from_column_slice(axis));
            axis.copy_from_slice(turned.as_slice());
        }
        self.addresses.iter().map(|&(address, zero)| qpos[address] - zero).collect()
    }

    /// The name of the first body of the creature; `None` if it has none.
    pub fn root_name(&self) -> Option<&str> {
        let first = || self.limb_of_body.iter().position(|limb| limb.is_some_and(|limb| limb > 0));
        let root = if self.root > 0 { Some(self.root) } else { first() };
        root.and_then(|body| self.model.body(body).name)
    }

    /// Where a coordinate of a posture is in the engine's `qpos`.
    pub fn qpos_address(&self, coordinate: usize) -> usize {
        self.addresses[coordinate].0
    }

    /// Whether a geom is surface that can be touched: one of the creature that collides with anything or that
    /// belongs to a rigid part of which nothing does.
    pub fn feels(&self, geom: usize) -> bool {
        self.surface[geom]
    }

    /// Per geom, whether [`Body::feels`] holds.
    pub(crate) fn surface(&self) -> &[bool] {
        &self.surface
    }

    /// The limb that a geom belongs to.
    pub fn limb_of_geom(&self, geom: usize) -> Option<usize> {
        self.limb_of_body[self.model.geom_body(geom)]
    }

    /// `X_LG`: the pose of a geom in the frame of its body's limb.
    pub fn geom_in_limb(&self, geom: &Geom) -> Isometry3<f64> {
        self.pose_in_limb[geom.body] * Isometry3::from_parts(geom.pos.into(), geom.quat)
    }

    /// `X_WL` of every limb, given data with poses computed.
    pub fn limb_frames(&self, data: &Data) -> Vec<Frame> {
        let frame = |limb: usize| Frame::from(self.limb_pose(data, limb).unwrap_or_default());
        (0..self.creature.limbs().len()).map(frame).collect()
    }

    /// The pose of a limb in the world, given data with poses computed.
    pub fn limb_pose(&self, data: &Data, limb: usize) -> Option<Isometry3<f64>> {
        let body = self.limb_of_body.iter().position(|l| *l == Some(limb))?;
        Some(data.body_pose(body) * self.pose_in_limb[body].inverse())
    }

    /// The number of the model's constraints that no posture keeps: loops that it closes, tendons that it couples.
    pub fn constraints_not_heeded(&self) -> usize {
        self.model.equalities().iter().filter(|equality| **equality == Equality::Other).count()
    }
}
