//! A robot from MJCF: its bodies and joints as quantities, its masses and its geoms, with the numbers that MuJoCo compiled.
//!
//! The pose of a body on its parent is `BODY.position`, then `BODY.orientation`, then what its joints do, one after the
//! other, each about its anchor. An encoder reads `qpos`: a joint's `offset` is −`ref`, for at `ref` the body is where the
//! file has it.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::{Matrix3, Vector3};

use super::{follow, moved, surface_name};
use crate::calibration::robot::{Element, Form, LinkMass, Robot, Value};
use crate::creature::{DofKind, body_name, joint_couplings, joint_name, largest, limits, matrix, span};
use crate::error::Error;
use crate::geometry::{Frame, Shape};
use crate::model_files::Following;
use crate::mujoco::{GeomKind, JointKind, Model};

/// Reads a robot from an MJCF file and what it includes, in its maker's frames, and tells what of the file is of no use here,
/// a sentence each. Of a model that stands on the world the world is the root; of one that a free joint carries the body
/// that it carries. A joint that an equality lets follow another by a straight line is a degree of freedom after all that do
/// not, with that one's coordinate.
///
/// # Errors
/// Where MuJoCo does not take it, or nothing in it can move.
pub fn read_mjcf(path: &Path) -> Result<(Robot, Vec<String>), Error> {
    let (model, left_out) = Model::read(path).map_err(Error::from).map_err(Error::of_model(path))?;
    let top = largest(&model).map_err(Error::of_model(path))?.root;
    let root = if is_free(&model, top) { top } else { 0 };
    let mut reader = Reader {
        model: &model,
        robot: Robot::new(model.model_name().unwrap_or("robot"), body_name(&model, root)),
        links: vec![None; model.nbody()],
        dofs: vec![None; model.njnt()],
        held: Vec::new(),
        followers: followers(&model),
        passed_over: left_out
            .in_words()
            .map(|what| format!("read without {what}, which MuJoCo does not accept"))
            .into_iter()
            .chain(left_out.notes)
            .collect(),
    };
    reader.links[root] = Some(0);
    reader.tree(root);
    reader.follow();
    reader.masses();
    reader.surfaces();
    let turned = if root == 0 { Matrix3::identity() } else { matrix(&model.body(root).quat) };
    reader.robot.gravity = turned.tr_mul(&model.gravity());
    Ok((reader.robot, reader.passed_over))
}

/// Whether a body flies freely.
fn is_free(model: &Model, body: usize) -> bool {
    model.body(body).joints.into_iter().any(|j| model.joint(j).kind == JointKind::Free)
}

/// Joints that equalities let follow others, counted from their references; none of those that follow by no straight line.
fn followers(model: &Model) -> BTreeMap<usize, Option<Following<usize>>> {
    let direct = joint_couplings(model);
    let following = |joint: usize| {
        let mut found = Following { leader: Some(joint), gain: 1.0, offset: 0.0 };
        // Who follows in a circle follows nobody.
        for _ in 0..=direct.len() {
            let Some((leader, [constant, slope, curved @ ..])) = found.leader.and_then(|on| direct.get(&on))
            else {
                return Some(found);
            };
            if leader.is_some() && *curved != [0.0; 3] {
                return None;
            }
            found.offset += found.gain * constant;
            found.gain *= if leader.is_some() { *slope } else { 0.0 };
            found.leader = *leader;
        }
        None
    };
    direct.keys().map(|joint| (*joint, following(*joint))).collect()
}

struct Reader<'a> {
    model: &'a Model,
    robot: Robot,
    /// Per body its link, where it is the robot's.
    links: Vec<Option<usize>>,
    /// Per joint its degree of freedom.
    dofs: Vec<Option<usize>>,
    /// Joints that follow others, and which element of which link they are to be.
    held: Vec<(usize, Following<usize>, [usize; 2])>,
    followers: BTreeMap<usize, Option<Following<usize>>>,
    passed_over: Vec<String>,
}

impl Reader<'_> {
    /// The bodies that the root carries, with all joints that do not follow others.
    fn tree(&mut self, root: usize) {
        let mut loose = Vec::new();
        for (i, body) in self.model.bodies().enumerate().skip(1) {
            let name = body_name(self.model, i);
            let Some(parent) = self.links[body.parent].filter(|_| i != root && !is_free(self.model, i))
            else {
                if i != root && body.parent == 0 {
                    loose.push(name);
                }
                continue;
            };
            let pose = Frame { rotation: matrix(&body.quat), origin: body.pos };
            let mut elements = self.robot.add_pose(&name, pose).to_vec();
            for j in body.joints {
                let joint = self.model.joint(j);
                let anchor = Frame { origin: joint.pos, ..Frame::identity() };
                // A slide has no anchor.
                let anchored = joint.kind != JointKind::Slide && joint.pos != Vector3::zeros();
                elements.extend(anchored.then_some(Element::Fixed(anchor)));
                let does = self.joint(j, [self.robot.links.len(), elements.len()]);
                elements.push(does);
                elements.extend(anchored.then_some(Element::Fixed(anchor.inverse())));
            }
            self.links[i] = Some(self.robot.add_link(name, parent, elements));
        }
        if !loose.is_empty() {
            let root = &self.robot.links[0].name;
            self.passed_over.push(format!(
                "{} {} not carried by {root}; touches of freely moving bodies are useless and ignored",
                loose.join(", "),
                if loose.len() == 1 { "is" } else { "are" }
            ));
        }
    }

    /// What a joint does, which is the element of a link; nothing yet where it follows another.
    fn joint(&mut self, j: usize, at: [usize; 2]) -> Element {
        let joint = self.model.joint(j);
        match self.followers.get(&j) {
            Some(Some(Following { leader: None, offset, .. })) => {
                return Element::Fixed(moved(joint.kind == JointKind::Slide, &joint.axis, *offset));
            }
            Some(Some(following)) => {
                self.held.push((j, *following, at));
                return Element::Fixed(Frame::identity());
            }
            Some(None) => {
                let name = joint_name(self.model, j);
                self.passed_over.push(format!(
                    "joint {name} follows another along a curve: the log needs a column {name}"
                ));
            }
            None => {}
        }
        Element::Dof(self.dof(j))
    }

    fn dof(&mut self, j: usize) -> usize {
        let joint = self.model.joint(j);
        let kind = match joint.kind {
            JointKind::Slide => DofKind::Slide,
            JointKind::Ball => DofKind::Ball,
            JointKind::Hinge | JointKind::Free => DofKind::Hinge,
        };
        let span = span(joint.kind);
        let reference = if kind == DofKind::Ball { 0.0 } else { self.model.qpos0()[joint.qposadr] };
        let range = match (kind, joint.limited) {
            (DofKind::Ball, limited) => [0.0, if limited { joint.range[1] } else { span }],
            _ => limits(&joint).unwrap_or([reference - span, reference + span]),
        };
        let dof = self.robot.add_dof(&joint_name(self.model, j), kind, range, joint.axis);
        if let Some(q) = self.robot.dofs[dof].quantities {
            self.robot.quantities[q.offset].nominal = Value::Number(0.0 - reference);
        }
        self.dofs[j] = Some(dof);
        dof
    }

    /// Joints that follow others, after those. What follows a joint that is not the robot's stands still.
    fn follow(&mut self) {
        for (j, Following { leader, gain, offset }, [link, element]) in std::mem::take(&mut self.held) {
            let Some(leader) = leader.and_then(|leader| self.dofs[leader]) else { continue };
            let dof = self.dof(j);
            follow(&mut self.robot, dof, leader, [gain, offset], [link, element]);
        }
    }

    fn masses(&mut self) {
        for (i, body) in self.model.bodies().enumerate().skip(1).filter(|(_, body)| body.mass > 0.0) {
            if let Some(link) = self.links[i] {
                self.robot.masses.push(LinkMass { link, mass: body.mass, centre: body.ipos });
            }
        }
    }

    /// Its geoms that may touch as surfaces: a geom without a name is called after its body, with a number where that has
    /// several.
    fn surfaces(&mut self) {
        let own: Vec<bool> = self
            .model
            .geoms()
            .map(|geom| {
                let known = geom.kind == GeomKind::Plane || Shape::is_of_kind(geom.kind);
                self.links[geom.body].is_some() && known
            })
            .collect();
        let touchable = self.model.surface_among(&own);
        for (g, geom) in self.model.geoms().enumerate().filter(|(g, _)| touchable[*g]) {
            let Some(link) = self.links[geom.body] else { continue };
            let name = geom_name(self.model, g);
            let pose = Frame { rotation: matrix(&geom.quat), origin: geom.pos };
            let form = match Shape::of_geom(self.model, g) {
                Some(Shape::Sphere { radius }) => {
                    self.robot.add_sphere(&name, link, pose, radius);
                    continue;
                }
                Some(shape) if shape.is_solid() => Form::Solid(shape),
                None if geom.kind == GeomKind::Plane => Form::Plane,
                _ => continue,
            };
            self.robot.add_surface(&name, link, pose, form);
        }
    }
}

/// A geom's name, or one made from its body's.
fn geom_name(model: &Model, geom: usize) -> String {
    let about = model.geom(geom);
    let geoms = model.body(about.body).geoms;
    let own = about.name.map(str::to_string);
    own.unwrap_or_else(|| surface_name(&body_name(model, about.body), geom - geoms.start, geoms.len()))
}
