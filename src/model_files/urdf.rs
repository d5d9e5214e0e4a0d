//! URDF in MJCF's terms: links become bodies, joints become joints, and what mimics another joint follows it.
//!
//! MuJoCo reads URDF itself, but knows no mimics, no paths of packages and no floating base, and merges links that are
//! fixed to each other. The crate `urdf-rs` refuses robots without masses or greatest velocities, and knows no lines;
//! the tests compare with it.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};

use super::meshes::{MeshFolder, file_fault};
use super::pose::set_pose;
use super::reduce::Reduced;
use super::source::{LeftOut, Refused, Source};
use super::tree::{Element, element};
use super::urdf_tree::{Origin, UrdfJoint, UrdfKind, UrdfTree};
use super::write::exact;
use crate::geometry::z_onto;

/// The link that stands for the world where it is the root.
const WORLD: &str = "world";

/// A robot's tree in MJCF's terms.
///
/// # Errors
/// Where its links and joints make no tree.
pub(super) fn to_mjcf(source: &Source) -> Result<Reduced, Refused> {
    let tree = UrdfTree::new(source)?;
    let mut left_out = LeftOut { notes: tree.notes.clone(), ..LeftOut::default() };
    for (origin, fault) in tree.turn_faults() {
        let line = origin.place.as_ref().map_or(String::new(), |place| format!("line {}: ", place.line));
        left_out.notes.push(format!("{line}{fault}"));
    }
    for child in &source.root.children {
        if !matches!(child.name.as_str(), "link" | "joint") {
            left_out.spare(format!("<{}>", child.name));
        }
    }
    let folder = MeshFolder::of(source);
    let mut parts =
        Parts { source, tree: &tree, folder, meshes: BTreeMap::new(), followers: Vec::new(), left_out };
    let root = parts.body(tree.root, None)?;
    // The world is no body, and has no mass.
    let world = match tree.root {
        WORLD => root.children.into_iter().filter(|e| e.name != "inertial").collect(),
        _ => vec![root],
    };
    let Parts { meshes, followers, left_out, .. } = parts;
    let mut mujoco = Element::new("mujoco");
    if let Some(name) = source.root.get("name") {
        mujoco.set("model", name);
    }
    let compiler = element("compiler", &[("angle", "radian".into()), ("autolimits", "true".into())]);
    mujoco.children = vec![
        compiler,
        Element::holding("asset", meshes.into_values().collect()),
        Element::holding("worldbody", world),
        Element::holding("equality", followers),
    ];
    Ok(Reduced::plain(mujoco, left_out))
}

/// What a robot is made of, as it is read.
struct Parts<'a> {
    source: &'a Source,
    tree: &'a UrdfTree<'a>,
    folder: MeshFolder,
    /// The meshes by their names.
    meshes: BTreeMap<String, Element>,
    /// What follows other joints.
    followers: Vec<Element>,
    left_out: LeftOut,
}

impl Parts<'_> {
    /// A link and all that it carries.
    fn body(&mut self, link: &str, by: Option<&UrdfJoint>) -> Result<Element, Refused> {
        let tree = self.tree;
        let described = tree.link(link).expect("a link of the tree");
        let mut body = element("body", &[("name", link.into())]).placed_as(described);
        let mut parts = Vec::new();
        if let Some(joint) = by {
            set_pose(&mut body, &origin(joint.element));
            parts.extend(self.joint(joint));
        }
        parts.extend(inertial(described));
        let mut geoms = self.geoms(described, "collision")?;
        if geoms.is_empty() {
            geoms = self.geoms(described, "visual")?;
            if !geoms.is_empty() && described.child("collision").is_some() {
                self.left_out.notes.push(format!(
                    "link {link} uses its visual shape, because its collision shape cannot be read"
                ));
            }
        }
        parts.extend(geoms);
        for joint in tree.carried_by(link) {
            parts.push(self.body(joint.child, Some(joint))?);
        }
        body.children = parts;
        Ok(body)
    }

    /// The degrees of freedom of a joint, at the origin of the link that it carries.
    fn joint(&mut self, joint: &UrdfJoint) -> Vec<Element> {
        let UrdfJoint { element: described, name, axis, .. } = joint;
        let made = |kind: &str, name: String, axis: &Vector3<f64>| {
            let attributes = [("name", name), ("type", kind.into()), ("axis", exact(axis.iter()))];
            element("joint", &attributes).placed_as(described)
        };
        let mut moved = match joint.kind {
            UrdfKind::Fixed => return Vec::new(),
            UrdfKind::Revolute | UrdfKind::Continuous => made("hinge", name.to_string(), axis),
            UrdfKind::Prismatic => made("slide", name.to_string(), axis),
            UrdfKind::Floating => {
                if joint.parent == WORLD {
                    return vec![element("freejoint", &[("name", name.to_string())])];
                }
                // A free joint is for children of the world; this link hangs on a body that stands still.
                let slides = ["x", "y", "z"].into_iter().zip([Vector3::x(), Vector3::y(), Vector3::z()]);
                let mut all: Vec<Element> =
                    slides.map(|(along, axis)| made("slide", format!("{name}_{along}"), &axis)).collect();
                all.push(made("ball", format!("{name}_turn"), &Vector3::z()));
                return all;
            }
            UrdfKind::Planar => {
                let normal = axis.try_normalize(0.0).unwrap_or(Vector3::x());
                let turn = z_onto(&normal);
                return vec![
                    made("slide", format!("{name}_x"), &(turn * Vector3::x())),
                    made("slide", format!("{name}_y"), &(turn * Vector3::y())),
                    made("hinge", format!("{name}_turn"), &normal),
                ];
            }
        };
        if let Some(follows) = joint.follows {
            let mut follower = element("joint", &[("joint1", name.to_string())]);
            let leader = follows.leader.map(|leader| ("joint2".to_string(), leader.to_string()));
            follower.attributes.extend(leader);
            let polynomial = exact(&[follows.offset, follows.gain, 0.0, 0.0, 0.0]);
            follower.set("polycoef", polynomial);
            follower.place = described.child("mimic").and_then(|mimic| mimic.place.clone());
            self.followers.push(follower);
        }
        if let Some(limits) = joint.limits {
            moved.set("range", exact(&limits));
        }
        moved.set("limited", joint.limits.is_some().to_string());
        vec![moved]
    }

    /// The geom of a `<collision>` or `<visual>`; `None` if it has a shape that cannot be read.
    fn geom(&mut self, link: &str, described: &Element) -> Result<Option<Element>, Refused> {
        let shape = described.child("geometry").and_then(|e| e.children.first());
        let Some(shape) = shape else {
            self.left_out.lose(format!("<{}> without geometry", described.name), 1);
            return Ok(None);
        };
        let geom = match (shape.name.as_str(), self.tree.shape(link, shape)?.and_then(|shape| shape.mjcf())) {
            ("mesh", _) => {
                let Some(mesh) = self.mesh(shape)? else { return Ok(None) };
                element("geom", &[("type", "mesh".into()), ("mesh", mesh)])
            }
            (_, Some((kind, size))) => element("geom", &[("type", kind.into()), ("size", exact(&size))]),
            (other, None) => {
                self.left_out.lose(format!("geometry <{other}>"), 1);
                return Ok(None);
            }
        };
        let mut geom = geom.placed_as(described);
        set_pose(&mut geom, &origin(described));
        Ok(Some(geom))
    }

    /// The geoms of all descriptions of a kind.
    fn geoms(&mut self, link: &Element, kind: &str) -> Result<Vec<Element>, Refused> {
        let mut geoms = Vec::new();
        for described in link.children.iter().filter(|e| e.name == kind) {
            geoms.extend(self.geom(link.get("name").unwrap_or_default(), described)?);
        }
        Ok(geoms)
    }

    /// The name of a mesh, which is read with its scale; `None` if its file cannot be read.
    fn mesh(&mut self, shape: &Element) -> Result<Option<String>, Refused> {
        let file = shape.get("filename").filter(|file| !file.trim().is_empty());
        let written =
            file.ok_or_else(|| self.source.refused(shape, "<mesh> names no file; give it filename=\"…\""))?;
        let file = self.folder.find(written);
        if let Some(fault) = file_fault(&file) {
            self.left_out.lose(format!("geom of the mesh {written}: {fault}"), 1);
            return Ok(None);
        }
        let scale = shape.vector("scale").unwrap_or(Vector3::repeat(1.0));
        let stem = file.file_stem().and_then(|stem| stem.to_str()).unwrap_or("mesh").to_string();
        let (file, scale) = (file.display().to_string(), exact(scale.iter()));
        let same = |mesh: &Element| mesh.get("file") == Some(&file) && mesh.get("scale") == Some(&scale);
        let mut name = stem.clone();
        for number in 2.. {
            if self.meshes.get(&name).is_none_or(same) {
                break;
            }
            name = format!("{stem}_{number}");
        }
        let mesh = [("name", name.clone()), ("file", file.clone()), ("scale", scale.clone())];
        let mesh = element("mesh", &mesh).placed_as(shape);
        self.meshes.insert(name.clone(), mesh);
        Ok(Some(name))
    }
}

/// The pose in an `<origin>`.
fn origin(of: &Element) -> Isometry3<f64> {
    let Origin { place, turns: [roll, pitch, yaw] } = Origin::of(of);
    Isometry3::from_parts(Translation3::from(place), UnitQuaternion::from_euler_angles(roll, pitch, yaw))
}

/// The mass and inertia of a link, where they are those of a body that there can be.
fn inertial(link: &Element) -> Option<Element> {
    let described = link.child("inertial")?;
    let number = |child: &str, name: &str| described.child(child)?.number(name);
    let mass = number("mass", "value").filter(|mass| *mass > 0.0)?;
    let [xx, yy, zz, xy, xz, yz] =
        ["ixx", "iyy", "izz", "ixy", "ixz", "iyz"].map(|name| number("inertia", name).unwrap_or(0.0));
    let pose = origin(described);
    let turn = pose.rotation.to_rotation_matrix().into_inner();
    let inertia = turn * Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) * turn.transpose();
    let principal = inertia.symmetric_eigenvalues();
    if principal.min() <= 0.0 || 2.0 * principal.max() > principal.sum() * (1.0 + 1e-9) {
        return None;
    }
    let full = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|at| inertia[at]);
    Some(element(
        "inertial",
        &[
            ("pos", exact(pose.translation.vector.iter())),
            ("mass", exact(&[mass])),
            ("fullinertia", exact(&full)),
        ],
    ))
}
