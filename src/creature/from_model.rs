//! Reading a creature from a MuJoCo model.

use std::collections::BTreeSet;
use std::sync::Arc;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::coupling::couple;
use super::names::{body_name, free_name, joint_name};
use super::selection::{JointSelection, Tree, select};
use super::{AuraLimb, Body, Creature, Dof, DofKind, Joint, Segment, no_joints};
use crate::error::{Error, Result};
use crate::geometry::Shape;
use crate::mujoco::{JointKind, Model, ModelJoint, ObjectKind};
use crate::plausible::bounded;

/// Tuples of a model whose name starts with this list the bodies of one aura limb.
pub(crate) const LIMB_TUPLE: &str = "limb/";
/// Anchors closer than this share a position, metres.
const SAME_ANCHOR: f64 = 1e-9;
/// Half the span of postures for a slide without limits, metres.
pub(crate) const UNLIMITED_SLIDE: f64 = 0.5;

impl Body {
    /// Reads the creature that moves the selected joints; of several kinematic trees in a model the one with
    /// most joints.
    ///
    /// # Errors
    /// If nothing in the model can move, or the model or what is asked of it is unsuitable.
    pub fn new(model: Arc<Model>, selection: &JointSelection) -> Result<Body, Error> {
        Body::rooted(model, selection, None)
    }

    /// Reads the creature below the body called `root`, or of the tree with most joints.
    ///
    /// Its root limb is that body, or the world where that body itself is hinged to the world; a free joint
    /// there carries the whole body and is no part of the schema. The body's model is a copy of `declared` in
    /// which the creature's own surface can touch itself, whatever the file's contact filters say.
    ///
    /// # Errors
    /// If nothing in the model can move, or the model or what is asked of it is unsuitable.
    pub fn rooted(
        declared: Arc<Model>,
        selection: &JointSelection,
        root: Option<&str>,
    ) -> Result<Body, Error> {
        let Tree { root, holds } = Tree::new(&declared, root)?;
        // What of the creature can be touched, whichever joints are selected.
        let own: Vec<bool> =
            declared.geoms().map(|geom| holds[geom.body] && Shape::is_of_kind(geom.kind)).collect();
        let surface = declared.surface_among(&own);
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
            let mut limb = parent.ok_or_else(|| {
                Error::model(format!(
                    "the model's tree cannot be read: body {} comes before its parent",
                    body_name(&model, body)
                ))
            })?;
            let groups = group_by_anchor(&model, info.joints.filter(|&j| chosen(j)));
            let count = groups.len();
            for (k, joints) in groups.into_iter().enumerate() {
                segments.push(Segment { body, joints, last: k + 1 == count, parent: limb });
                limb = segments.len();
                let mut name = body_name(&model, body);
                if k + 1 < count {
                    name = free_name(&model, ObjectKind::Body, format!("{name}/{k}"));
                }
                limbs.push(name);
            }
            limb_of_body[body] = Some(limb);
        }
        if segments.is_empty() {
            return Err(no_joints());
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
        })?;
        let auras = aura_limbs(&model, &limbs, &limb_of_body);
        let name = model.model_name().unwrap_or("creature").to_string();
        let creature = Creature::new(name, limbs, joints, auras)
            .map_err(|error| Error::model(format!("the model's tree cannot be read: {error}")))?;
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

    fn place_bodies(&self) -> Result<Vec<Isometry3<f64>>> {
        let data = self.reference_data()?;
        let frames = self.reference_frames(&data);
        let place = |(body, limb): (usize, &Option<usize>)| match limb {
            Some(limb) => frames[*limb].inv_mul(&data.body_pose(body)),
            None => Isometry3::identity(),
        };
        Ok(self.limb_of_body.iter().enumerate().map(place).collect())
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
    let name = joint_name(model, j);
    let reference = model.qpos0()[joint.qposadr];
    let (kind, range) = match joint.kind {
        JointKind::Ball => {
            let angle = if joint.limited { joint.range[1] } else { std::f64::consts::PI };
            (DofKind::Ball, [0.0, angle])
        }
        kind => {
            let slide = kind == JointKind::Slide;
            let span = span(kind);
            let range = limits(&joint).map_or([-span, span], |limits| limits.map(|end| end - reference));
            (if slide { DofKind::Slide } else { DofKind::Hinge }, range)
        }
    };
    Dof { name, kind, range, follows: None }
}

/// Half of what a hinge or slide without limits moves through, radians or metres.
pub(crate) fn span(kind: JointKind) -> f64 {
    if kind == JointKind::Slide { UNLIMITED_SLIDE } else { std::f64::consts::PI }
}

/// Least and greatest coordinate of a hinge or slide as its file counts; `None` if it has no limits.
pub(crate) fn limits(joint: &ModelJoint) -> Option<[f64; 2]> {
    joint.limited.then_some(joint.range).and_then(|range| bounded(range, span(joint.kind)))
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

/// The bodies that the model's tuples put into aura limbs, in the model's order: the limb's name, the body, and the number that the
/// tuple attaches to it.
pub(crate) fn limb_bodies(model: &Model) -> Vec<(&str, usize, f64)> {
    let tuples = model.tuples().into_iter();
    let named = tuples.filter_map(|tuple| Some((tuple.name?.strip_prefix(LIMB_TUPLE)?, tuple.entries)));
    let bodies = named.flat_map(|(name, entries)| entries.into_iter().map(move |entry| (name, entry)));
    let bodies = bodies.filter(|(_, entry)| entry.object == ObjectKind::Body);
    bodies.map(|(name, entry)| (name, entry.id, entry.prm)).collect()
}

/// The aura limbs that the model's tuples define; each limb by itself where it defines none.
fn aura_limbs(model: &Model, limbs: &[String], limb_of_body: &[Option<usize>]) -> Vec<AuraLimb> {
    let mut auras: Vec<AuraLimb> = Vec::new();
    let mut taken = BTreeSet::new();
    for (name, body, _) in limb_bodies(model) {
        // With joints held, several aura limbs can be one limb: it goes to the first that names it.
        let Some(limb) = limb_of_body[body].filter(|limb| taken.insert(*limb)) else { continue };
        match auras.last_mut().filter(|aura| aura.name == name) {
            Some(aura) => aura.limbs.push(limb),
            None => auras.push(AuraLimb { name: name.to_string(), limbs: vec![limb] }),
        }
    }
    for (limb, name) in limbs.iter().enumerate() {
        let bears_geoms = model
            .bodies()
            .enumerate()
            .any(|(body, info)| limb_of_body[body] == Some(limb) && !info.geoms.is_empty());
        if !taken.contains(&limb) && bears_geoms {
            let mut name = name.clone();
            while auras.iter().any(|aura| aura.name == name) {
                name.push('_');
            }
            auras.push(AuraLimb { name, limbs: vec![limb] });
        }
    }
    auras
}

/// The orientation part of a pose as a matrix.
pub(crate) fn matrix(rotation: &UnitQuaternion<f64>) -> nalgebra::Matrix3<f64> {
    rotation.to_rotation_matrix().into_inner()
}
