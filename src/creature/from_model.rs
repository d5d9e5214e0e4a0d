//! Reading a creature from a MuJoCo model.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::coupling::couple;
use super::selection::{JointSelection, Tree, select};
use super::surface::surface;
use super::{AuraLimb, Creature, CreatureError, Dof, DofKind, Joint};
use crate::creature::Posture;
use crate::geometry::Frame;
use crate::mujoco::{self, Data, JointKind, Model, ObjectKind};

/// Tuples of a model whose name starts with this list the bodies of one aura limb.
pub(crate) const LIMB_TUPLE: &str = "limb/";
/// Anchors closer than this share a position, metres.
const SAME_ANCHOR: f64 = 1e-9;
/// Half the span of postures for a slide without limits, metres.
pub(crate) const UNLIMITED_SLIDE: f64 = 0.5;

/// Why a model has no creature that can learn.
#[derive(Debug, thiserror::Error)]
pub enum BodyError {
    /// The engine failed.
    #[error(transparent)]
    Engine(#[from] mujoco::Error),
    /// Nothing can move.
    #[error("the model has no hinge, slide or ball joint: give a creature that can move")]
    NoJoints,
    /// `--joints` names what is not there.
    #[error("the model has no joint and no joint set named {name}; it has the sets {sets}")]
    UnknownJoint {
        /// The name asked for.
        name: String,
        /// The sets there are.
        sets: String,
    },
    /// `--root` names what is not there.
    #[error("the model has no body named {name}; its trees begin at {roots}")]
    UnknownRoot {
        /// The name asked for.
        name: String,
        /// The first body of every tree.
        roots: String,
    },
    /// The tree could not be put together.
    #[error("the model's tree cannot be read: {0}")]
    Tree(#[from] CreatureError),
}

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
    surface: Vec<bool>,
    /// Per joint of the creature, the MuJoCo joints it is made of.
    pub segments: Vec<Segment>,
    /// Per MuJoCo body, the limb it belongs to; none for what is not the creature's.
    pub limb_of_body: Vec<Option<usize>>,
    /// Per MuJoCo body, `X_LB`: its pose in its limb's frame.
    pub pose_in_limb: Vec<Isometry3<f64>>,
    /// The MuJoCo body that is the root limb (0 where the creature is mounted on the world).
    pub root: usize,
    /// `qpos` of the reference posture; joints that do not move keep these coordinates.
    base: Vec<f64>,
    /// Per posture coordinate, its place in `qpos` and what `qpos` is at coordinate zero.
    addresses: Vec<(usize, f64)>,
    /// Per ball joint, the place of its quaternion in `qpos` and `R_LB`: MuJoCo's coordinates turn about
    /// the body's axes as the ball finds them, a posture's about the limb's.
    balls: Vec<(usize, UnitQuaternion<f64>)>,
}

impl Body {
    /// Reads the creature that moves the selected joints; of several kinematic trees in a model the one with
    /// most joints.
    ///
    /// # Errors
    /// See [`BodyError`].
    pub fn new(model: Arc<Model>, selection: &JointSelection) -> Result<Body, BodyError> {
        Body::rooted(model, selection, None)
    }

    /// Reads the creature below the body called `root`, or of the tree with most joints.
    ///
    /// Its root limb is that body, or the world where that body itself is hinged to the world; a free joint
    /// there carries the whole body and is no part of the schema. The body's model is a copy of `declared` in
    /// which the creature's own surface can touch itself, whatever the file's contact filters say.
    ///
    /// # Errors
    /// See [`BodyError`].
    pub fn rooted(
        declared: Arc<Model>,
        selection: &JointSelection,
        root: Option<&str>,
    ) -> Result<Body, BodyError> {
        let Tree { root, holds } = Tree::new(&declared, root)?;
        let surface = surface(&declared, &holds);
        let model = Arc::new(declared.touching_with(&surface)?);
        let selected = select(&model, selection)?;
        let chosen = |j: usize| {
            let joint = model.joint(j);
            joint.kind != JointKind::Free && holds[joint.body] && joint.body != root && selected[j]
        };

        let mut limb_of_body = vec![None; model.nbody()];
        limb_of_body[root] = Some(0);
        let mut limbs = vec![body_name(&model, root)];
        let mut segments: Vec<Segment> = Vec::new();
        for body in 1..model.nbody() {
            if !holds[body] || body == root {
                continue;
            }
            let info = model.body(body);
            let parent = if info.parent == 0 { Some(0) } else { limb_of_body[info.parent] };
            let mut limb =
                parent.ok_or_else(|| BodyError::Tree(CreatureError::BodyOrder(body_name(&model, body))))?;
            let groups = group_by_anchor(&model, info.joints.filter(|&j| chosen(j)));
            let count = groups.len();
            for (k, joints) in groups.into_iter().enumerate() {
                segments.push(Segment { body, joints, last: k + 1 == count, parent: limb });
                limb = segments.len();
                let name = body_name(&model, body);
                limbs.push(if k + 1 == count { name } else { format!("{name}/{k}") });
            }
            limb_of_body[body] = Some(limb);
        }
        if segments.is_empty() {
            return Err(BodyError::NoJoints);
        }

        let mut addresses = Vec::new();
        let mut base = model.qpos0().to_vec();
        for (j, joint) in model.joints().enumerate() {
            if joint.limited && matches!(joint.kind, JointKind::Hinge | JointKind::Slide) && !chosen(j) {
                base[joint.qposadr] = base[joint.qposadr].clamp(joint.range[0], joint.range[1]);
            }
        }
        let mut joints = Vec::new();
        let mut dof_of_joint = vec![None; model.njnt()];
        for (element, &j) in segments.iter().flat_map(|segment| &segment.joints).enumerate() {
            dof_of_joint[j] = Some(element);
        }
        for segment in &segments {
            let dofs: Vec<Dof> = segment.joints.iter().map(|&j| dof(&model, j)).collect();
            for &j in &segment.joints {
                let joint = model.joint(j);
                let zero = |k: usize| if joint.kind == JointKind::Ball { 0.0 } else { base[k] };
                addresses.extend((joint.qposadr..).take(joint.kind.nq()).map(|k| (k, zero(k))));
            }
            let name = common_name(&dofs).unwrap_or_else(|| body_name(&model, segment.body));
            joints.push(Joint::new(unused(name, &joints), segment.parent, dofs));
        }
        let mut dofs: Vec<&mut Dof> = joints.iter_mut().flat_map(|joint| &mut joint.dofs).collect();
        couple(&model, &mut dofs, &dof_of_joint, |j| {
            let address = model.joint(j).qposadr;
            base[address] - model.qpos0()[address]
        });
        let auras = aura_limbs(&model, &limbs, &limb_of_body);
        let name = model.model_name().unwrap_or("creature").to_string();
        let creature = Creature::new(name, limbs, joints, auras).map_err(BodyError::Tree)?;
        let pose_in_limb = vec![Isometry3::identity(); model.nbody()];
        let balls = Vec::new();
        let mut body = Body {
            creature,
            model,
            declared,
            surface,
            segments,
            limb_of_body,
            pose_in_limb,
            root,
            base,
            addresses,
            balls,
        };
        body.pose_in_limb = body.place_bodies()?;
        body.balls = body.place_balls();
        Ok(body)
    }

    /// See [`Body::balls`]; after the bodies are placed.
    fn place_balls(&self) -> Vec<(usize, UnitQuaternion<f64>)> {
        let of_segments = self.segments.iter().flat_map(|segment| &segment.joints);
        let balls = of_segments.filter(|&&j| self.model.joint(j).kind == JointKind::Ball);
        balls
            .map(|&ball| {
                let joint = self.model.joint(ball);
                // Joints after the ball on its body turn the body further where they are held off zero.
                let turned = (ball + 1..self.model.body(joint.body).joints.end)
                    .map(|j| self.model.joint(j))
                    .filter(|later| later.kind == JointKind::Hinge)
                    .map(|later| {
                        let angle = self.base[later.qposadr] - self.model.qpos0()[later.qposadr];
                        UnitQuaternion::from_scaled_axis(later.axis * angle)
                    })
                    .fold(UnitQuaternion::identity(), |before, turn| before * turn);
                (joint.qposadr, self.pose_in_limb[joint.body].rotation * turned.inverse())
            })
            .collect()
    }

    /// Data of the model at the reference posture, poses computed.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn reference_data(&self) -> mujoco::Result<Data> {
        let mut data = Data::new(self.model.clone())?;
        data.set_qpos(&self.base)?;
        data.kinematics()?;
        Ok(data)
    }

    /// `X_WL` of every limb at the reference posture: its joint's anchor, the root's orientation.
    ///
    /// # Errors
    /// Where the engine fails.
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

    fn place_bodies(&self) -> mujoco::Result<Vec<Isometry3<f64>>> {
        let data = self.reference_data()?;
        let frames = self.reference_frames(&data);
        let place = |(body, limb): (usize, &Option<usize>)| match limb {
            Some(limb) => frames[*limb].inv_mul(&data.body_pose(body)),
            None => Isometry3::identity(),
        };
        Ok(self.limb_of_body.iter().enumerate().map(place).collect())
    }

    /// Writes a posture of the creature into a `qpos` vector.
    pub fn write_qpos(&self, posture: &[f64], qpos: &mut [f64]) {
        qpos.copy_from_slice(&self.base);
        for (&(address, zero), coordinate) in self.addresses.iter().zip(posture) {
            qpos[address] = zero + coordinate;
        }
        for (address, orientation) in &self.balls {
            let axis = &mut qpos[address + 1..address + 4];
            let turned = orientation.inverse_transform_vector(&Vector3::from_column_slice(axis));
            axis.copy_from_slice(turned.as_slice());
        }
    }

    /// The posture of the creature in a `qpos` vector: the inverse of [`Body::write_qpos`].
    pub fn read_posture(&self, qpos: &[f64]) -> Posture {
        let mut qpos = qpos.to_vec();
        for (address, orientation) in &self.balls {
            let axis = &mut qpos[address + 1..address + 4];
            let turned = orientation.transform_vector(&Vector3::from_column_slice(axis));
            axis.copy_from_slice(turned.as_slice());
        }
        self.addresses.iter().map(|&(address, zero)| qpos[address] - zero).collect()
    }

    /// The name of the first body of the creature; none where it has none.
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

    /// The limb that a geom belongs to.
    pub fn limb_of_geom(&self, geom: usize) -> Option<usize> {
        self.limb_of_body[self.model.geom_body(geom)]
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
}

/// Splits a body's joints where the anchor changes; a slide has no anchor and joins any group.
fn group_by_anchor(model: &Model, joints: impl Iterator<Item = usize>) -> Vec<Vec<usize>> {
    let mut groups: Vec<(Option<Vector3<f64>>, Vec<usize>)> = Vec::new();
    for j in joints {
        let joint = model.joint(j);
        let anchor = (joint.kind != JointKind::Slide).then_some(joint.pos);
        match groups.last_mut() {
            Some((shared, group)) if shared.zip(anchor).is_none_or(|(a, b)| (a - b).norm() < SAME_ANCHOR) => {
                *shared = shared.or(anchor);
                group.push(j);
            }
            _ => groups.push((anchor, vec![j])),
        }
    }
    groups.into_iter().map(|(_, group)| group).collect()
}

/// One MuJoCo joint as the agent knows it: coordinates count from the reference posture.
fn dof(model: &Model, j: usize) -> Dof {
    let joint = model.joint(j);
    let name = joint.name.map_or_else(|| format!("joint{j}"), str::to_string);
    let reference = model.qpos0()[joint.qposadr];
    let (kind, range) = match joint.kind {
        JointKind::Ball => {
            let angle = if joint.limited { joint.range[1] } else { std::f64::consts::PI };
            (DofKind::Ball, [0.0, angle])
        }
        kind => {
            let slide = kind == JointKind::Slide;
            let span = if slide { UNLIMITED_SLIDE } else { std::f64::consts::PI };
            let range = match joint.limited {
                true => [joint.range[0] - reference, joint.range[1] - reference],
                false => [-span, span],
            };
            (if slide { DofKind::Slide } else { DofKind::Hinge }, range)
        }
    };
    Dof { name, kind, range, follows: None }
}

/// What the names of a joint's degrees of freedom have in common: `left_hip` of `left_hip_flexion` and
/// `left_hip_rotation`.
fn common_name(dofs: &[Dof]) -> Option<String> {
    let [first, rest @ ..] = dofs else { return None };
    if rest.is_empty() {
        return Some(first.name.clone());
    }
    let words = |name: &str| name.split('_').map(str::to_string).collect::<Vec<_>>();
    let mut common = words(&first.name);
    for dof in rest {
        let other = words(&dof.name);
        let same = common.iter().zip(&other).take_while(|(a, b)| a == b).count();
        common.truncate(same);
    }
    (!common.is_empty()).then(|| common.join("_"))
}

/// A name that no joint has yet: numbered where it is taken.
fn unused(name: String, joints: &[Joint]) -> String {
    let taken = |name: &str| joints.iter().any(|joint| joint.name == name);
    if !taken(&name) {
        return name;
    }
    (2..).map(|k| format!("{name}_{k}")).find(|name| !taken(name)).expect("some number is free")
}

/// A body's name, or one made from its number.
pub(crate) fn body_name(model: &Model, body: usize) -> String {
    model.body(body).name.map_or_else(|| format!("body{body}"), str::to_string)
}

/// The aura limbs that the model's tuples define; each limb by itself where it defines none.
fn aura_limbs(model: &Model, limbs: &[String], limb_of_body: &[Option<usize>]) -> Vec<AuraLimb> {
    let mut auras = Vec::new();
    let mut taken: BTreeMap<usize, usize> = BTreeMap::new();
    for tuple in model.tuples() {
        let Some(name) = tuple.name.and_then(|name| name.strip_prefix(LIMB_TUPLE)) else { continue };
        let mut members = Vec::new();
        for entry in tuple.entries.iter().filter(|entry| entry.object == ObjectKind::Body) {
            let Some(limb) = limb_of_body[entry.id] else { continue };
            // With joints held, several aura limbs can be one limb: it goes to the first that names it.
            if taken.insert(limb, auras.len()).is_none() {
                members.push(limb);
            }
        }
        if !members.is_empty() {
            auras.push(AuraLimb { name: name.to_string(), limbs: members });
        }
    }
    for (limb, name) in limbs.iter().enumerate() {
        let bears_geoms = model
            .bodies()
            .enumerate()
            .any(|(body, info)| limb_of_body[body] == Some(limb) && !info.geoms.is_empty());
        if !taken.contains_key(&limb) && bears_geoms {
            auras.push(AuraLimb { name: name.clone(), limbs: vec![limb] });
        }
    }
    auras
}

/// The orientation part of a pose as a matrix.
pub(crate) fn matrix(rotation: &UnitQuaternion<f64>) -> nalgebra::Matrix3<f64> {
    rotation.to_rotation_matrix().into_inner()
}
