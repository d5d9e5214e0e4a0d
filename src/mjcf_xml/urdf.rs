//! URDF in MJCF's terms: links become bodies, joints become joints, and what mimics another joint follows it.
//!
//! MuJoCo reads URDF itself, but knows no mimics, no paths of packages and no floating base, and merges links that are
//! fixed to each other. The crate `urdf-rs` refuses robots without masses or greatest velocities, and knows no lines;
//! the tests compare with it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use xmltree::{Element, XMLNode};

use super::left_out::LeftOut;
use super::pose::{numbers, set_pose, vector};
use super::reduce::Reduced;
use super::source::{Refused, Source, whole_folder_of};
use super::{attribute, element, exact};

/// The link that stands for the world where it is the root.
const WORLD: &str = "world";
/// Elements of a robot that are of no use here.
const UNNEEDED: [&str; 5] = ["material", "gazebo", "transmission", "mujoco", "ros2_control"];

/// A robot's tree in MJCF's terms.
///
/// # Errors
/// Where its links and joints make no tree.
pub(crate) fn to_mjcf(source: &Source) -> Result<Reduced, Refused> {
    let robot = Robot::new(source)?;
    let mut left_out = LeftOut::default();
    for child in source.root.children.iter().filter_map(XMLNode::as_element) {
        match child.name.as_str() {
            "link" | "joint" => {}
            name if UNNEEDED.contains(&name) => left_out.spare(format!("<{name}>")),
            name if name.starts_with("xacro:") => {
                let message =
                    format!("<{name}> is of Xacro, not URDF; write it out with `xacro FILE > robot.urdf`");
                return Err(robot.refused(child, message));
            }
            name => left_out.spare(format!("<{name}>")),
        }
    }
    let mut parts = Parts { robot: &robot, meshes: BTreeMap::new(), followers: Vec::new(), left_out };
    let mut seen = BTreeSet::new();
    let name = robot.root()?;
    let root = parts.body(name, None, &mut seen)?;
    // The world is no body, and has no mass.
    let world = match name {
        WORLD => super::take_children(root).into_iter().filter(|e| e.name != "inertial").collect(),
        _ => vec![root],
    };
    if let Some((name, link)) = robot.links.iter().find(|(name, _)| !seen.contains(*name)) {
        let message = format!("link {name} is carried by itself; correct the <parent> of one of its joints");
        return Err(robot.refused(link, message));
    }
    let Parts { meshes, followers, left_out, .. } = parts;
    let mut mujoco = Element::new("mujoco");
    if let Some(name) = attribute(&source.root, "name") {
        mujoco.attributes.insert("model".into(), name.into());
    }
    let compiler = element("compiler", &[("angle", "radian".into()), ("autolimits", "true".into())]);
    let section = |name: &str, children: Vec<Element>| Element {
        children: children.into_iter().map(XMLNode::Element).collect(),
        ..Element::new(name)
    };
    let sections = [
        compiler,
        section("asset", meshes.into_values().collect()),
        section("worldbody", world),
        section("equality", followers),
    ];
    mujoco.children = sections.into_iter().map(XMLNode::Element).collect();
    Ok(Reduced::plain(mujoco, left_out))
}

/// A robot's links and joints.
struct Robot<'a> {
    source: &'a Source,
    links: BTreeMap<&'a str, &'a Element>,
    joints: Vec<&'a Element>,
}

impl<'a> Robot<'a> {
    fn new(source: &'a Source) -> Result<Robot<'a>, Refused> {
        let mut robot = Robot { source, links: BTreeMap::new(), joints: Vec::new() };
        for child in source.root.children.iter().filter_map(XMLNode::as_element) {
            let name = || attribute(child, "name").unwrap_or_default();
            if child.name == "link" && robot.links.insert(name(), child).is_some() {
                return Err(robot.refused(child, format!("there are two links {}; rename one", name())));
            } else if child.name == "joint" {
                robot.joints.push(child);
            }
        }
        let mut carried = BTreeSet::new();
        for joint in &robot.joints {
            for end in ["parent", "child"] {
                let link = robot.end(joint, end)?;
                if end == "child" && !carried.insert(link) {
                    let message = format!("link {link} is carried by two joints; remove one of them");
                    return Err(robot.refused(joint, message));
                }
            }
        }
        Ok(robot)
    }

    fn refused(&self, element: &Element, message: impl Into<String>) -> Refused {
        self.source.files.refused(element, &self.source.path, message)
    }

    /// The link at an end of a joint.
    fn end(&self, joint: &Element, end: &str) -> Result<&'a str, Refused> {
        let name = attribute(joint, "name").unwrap_or_default();
        let link = joint.get_child(end).and_then(|end| attribute(end, "link")).ok_or_else(|| {
            self.refused(joint, format!("joint {name} has no <{end} link=\"…\"/>; give it one"))
        })?;
        self.links.get_key_value(link).map(|(link, _)| *link).ok_or_else(|| {
            self.refused(
                joint,
                format!("joint {name} names the link {link}, which is not there; correct it there"),
            )
        })
    }

    /// The one link that no joint carries.
    fn root(&self) -> Result<&'a str, Refused> {
        let carried: BTreeSet<&str> =
            self.joints.iter().filter_map(|joint| self.end(joint, "child").ok()).collect();
        let mut roots = self.links.keys().filter(|link| !carried.contains(**link));
        match (roots.next(), roots.next()) {
            (Some(root), None) => Ok(root),
            (None, _) if self.links.is_empty() => {
                Err(Refused::file(&self.source.path, "it has no <link>; give a robot with links and joints"))
            }
            (None, _) => Err(Refused::file(
                &self.source.path,
                "its links carry each other in a circle; correct the <parent> of one of its joints",
            )),
            (Some(first), Some(second)) => Err(self.refused(
                self.links[second],
                format!("links {first} and {second} are not carried by any joint; join them with a <joint>"),
            )),
        }
    }
}

/// What a robot is made of, as it is read.
struct Parts<'a> {
    robot: &'a Robot<'a>,
    /// The meshes by their names.
    meshes: BTreeMap<String, Element>,
    /// What follows other joints.
    followers: Vec<Element>,
    left_out: LeftOut,
}

impl<'a> Parts<'a> {
    /// A link and all that it carries.
    fn body(
        &mut self,
        link: &'a str,
        by: Option<&'a Element>,
        seen: &mut BTreeSet<&'a str>,
    ) -> Result<Element, Refused> {
        seen.insert(link);
        let described = self.robot.links[link];
        let mut body =
            Element { namespace: described.namespace.clone(), ..element("body", &[("name", link.into())]) };
        let mut parts = Vec::new();
        if let Some(joint) = by {
            set_pose(&mut body, &origin(joint));
            parts.extend(self.joint(joint)?);
        }
        parts.extend(inertial(described));
        let geometry = |kind: &str| {
            let of_kind =
                described.children.iter().filter_map(XMLNode::as_element).filter(|e| e.name == kind);
            of_kind.collect::<Vec<_>>()
        };
        let mut geoms: Vec<Element> =
            geometry("collision").into_iter().filter_map(|e| self.geom(e)).collect();
        if geoms.is_empty() {
            geoms = geometry("visual").into_iter().filter_map(|e| self.geom(e)).collect();
        }
        parts.extend(geoms);
        let robot = self.robot;
        for joint in &robot.joints {
            if robot.end(joint, "parent")? == link {
                parts.push(self.body(robot.end(joint, "child")?, Some(joint), seen)?);
            }
        }
        body.children = parts.into_iter().map(XMLNode::Element).collect();
        Ok(body)
    }

    /// The degrees of freedom of a joint, at the origin of the link that it carries.
    fn joint(&mut self, joint: &Element) -> Result<Vec<Element>, Refused> {
        let name = attribute(joint, "name").unwrap_or_default();
        let axis =
            joint.get_child("axis").and_then(|axis| vector(attribute(axis, "xyz")?)).unwrap_or(Vector3::x());
        let made = |kind: &str, name: String, axis: &Vector3<f64>| Element {
            namespace: joint.namespace.clone(),
            ..element("joint", &[("name", name), ("type", kind.into()), ("axis", exact(axis.iter()))])
        };
        let kind = attribute(joint, "type").unwrap_or_default();
        if matches!(kind, "revolute" | "continuous" | "prismatic") && axis.norm() < f64::EPSILON {
            let message =
                format!("the axis of joint {name} has no direction; give it one in <axis xyz=\"…\"/>");
            return Err(self.robot.refused(joint, message));
        }
        let mut moved = match kind {
            "fixed" => return Ok(Vec::new()),
            "revolute" | "continuous" => made("hinge", name.into(), &axis),
            "prismatic" => made("slide", name.into(), &axis),
            "floating" => {
                let parent = self.robot.end(joint, "parent")?;
                if parent == WORLD {
                    return Ok(vec![element("freejoint", &[("name", name.into())])]);
                }
                // A free joint is for children of the world; this link hangs on a body that stands still.
                let slides = ["x", "y", "z"].into_iter().zip([Vector3::x(), Vector3::y(), Vector3::z()]);
                let mut all: Vec<Element> =
                    slides.map(|(along, axis)| made("slide", format!("{name}_{along}"), &axis)).collect();
                all.push(made("ball", format!("{name}_turn"), &Vector3::z()));
                return Ok(all);
            }
            "planar" => {
                let normal = axis.try_normalize(0.0).unwrap_or(Vector3::x());
                let turn = UnitQuaternion::rotation_between(&Vector3::z(), &normal);
                let turn = turn.unwrap_or_else(|| {
                    UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
                });
                return Ok(vec![
                    made("slide", format!("{name}_x"), &(turn * Vector3::x())),
                    made("slide", format!("{name}_y"), &(turn * Vector3::y())),
                    made("hinge", format!("{name}_turn"), &normal),
                ]);
            }
            other => {
                let message = format!(
                    "joint {name} is of the type \"{other}\"; give revolute, continuous, prismatic, fixed, floating or \
                     planar"
                );
                return Err(self.robot.refused(joint, message));
            }
        };
        let bound = |end: &str| {
            let text = attribute(joint.get_child("limit")?, end)?;
            numbers(text).first().copied()
        };
        if let Some(mimic) = joint.get_child("mimic") {
            let leader = attribute(mimic, "joint").unwrap_or_default();
            if !self.robot.joints.iter().any(|joint| attribute(joint, "name") == Some(leader)) {
                let message = format!("joint {name} mimics {leader}, which is not there; correct it there");
                return Err(self.robot.refused(mimic, message));
            }
            let number = |name: &str, default: f64| {
                attribute(mimic, name).and_then(|text| numbers(text).first().copied()).unwrap_or(default)
            };
            let polynomial = [number("offset", 0.0), number("multiplier", 1.0), 0.0, 0.0, 0.0];
            let follows = [
                ("joint1", name.to_string()),
                ("joint2", leader.to_string()),
                ("polycoef", exact(&polynomial)),
            ];
            self.followers.push(Element { namespace: mimic.namespace.clone(), ..element("joint", &follows) });
        }
        // Limits of zero are none, as MuJoCo has it.
        let ends = [bound("lower").unwrap_or(0.0), bound("upper").unwrap_or(0.0)];
        if kind != "continuous" && ends != [0.0, 0.0] {
            if ends[0] >= ends[1] {
                let message =
                    format!("the limits of joint {name} leave it no room; give a lower one below the upper");
                return Err(self.robot.refused(joint, message));
            }
            moved.attributes.insert("range".into(), exact(&ends));
            moved.attributes.insert("limited".into(), "true".into());
        }
        Ok(vec![moved])
    }

    /// The geom of a `<collision>` or `<visual>`.
    fn geom(&mut self, described: &Element) -> Option<Element> {
        let shape = described.get_child("geometry")?.children.iter().find_map(XMLNode::as_element)?;
        let number = |name: &str| numbers(attribute(shape, name)?).first().copied();
        let half = |length: Option<f64>| length.map(|length| 0.5 * length);
        let given = match shape.name.as_str() {
            "box" => vector(attribute(shape, "size")?)
                .map(|size| ("box", vec![0.5 * size.x, 0.5 * size.y, 0.5 * size.z])),
            "sphere" => number("radius").map(|radius| ("sphere", vec![radius])),
            "cylinder" => number("radius").zip(half(number("length"))).map(|(r, l)| ("cylinder", vec![r, l])),
            "capsule" => number("radius").zip(half(number("length"))).map(|(r, l)| ("capsule", vec![r, l])),
            "mesh" => {
                let mesh = self.mesh(shape)?;
                let geom = element("geom", &[("type", "mesh".into()), ("mesh", mesh)]);
                return Some(placed(geom, described));
            }
            _ => None,
        };
        let Some((kind, size)) = given else {
            self.left_out.lose(format!("geometry <{}>", shape.name), 1);
            return None;
        };
        Some(placed(element("geom", &[("type", kind.into()), ("size", exact(&size))]), described))
    }

    /// The name of a mesh, which is read with its scale.
    fn mesh(&mut self, shape: &Element) -> Option<String> {
        let file = self.file(attribute(shape, "filename")?);
        let scale = attribute(shape, "scale").and_then(vector).unwrap_or(Vector3::repeat(1.0));
        let stem = file.file_stem().and_then(|stem| stem.to_str()).unwrap_or("mesh").to_string();
        let (file, scale) = (file.display().to_string(), exact(scale.iter()));
        let same = |mesh: &Element| {
            attribute(mesh, "file") == Some(&file) && attribute(mesh, "scale") == Some(&scale)
        };
        let numbered = std::iter::once(stem.clone()).chain((2..).map(|k| format!("{stem}_{k}")));
        let name = { numbered }.find(|name| self.meshes.get(name).is_none_or(same))?;
        let mesh = [("name", name.clone()), ("file", file.clone()), ("scale", scale.clone())];
        let mesh = Element { namespace: shape.namespace.clone(), ..element("mesh", &mesh) };
        self.meshes.insert(name.clone(), mesh);
        Some(name)
    }

    /// Where a mesh's file is: of a package it is sought in the folders above the robot's.
    fn file(&self, name: &str) -> PathBuf {
        let folder = whole_folder_of(&self.robot.source.path);
        let path = name.strip_prefix("file://").unwrap_or(name);
        let mut candidates: Vec<PathBuf> = Vec::new();
        if let Some(packaged) = ["package://", "model://"].iter().find_map(|scheme| path.strip_prefix(scheme))
        {
            let inside = packaged.split_once('/').map_or(packaged, |(_, inside)| inside);
            for above in folder.ancestors() {
                candidates.extend([above.join(packaged), above.join(inside)]);
            }
        } else {
            candidates.push(folder.join(path));
            let compiler =
                self.robot.source.root.get_child("mujoco").and_then(|own| own.get_child("compiler"));
            if let Some(own) = compiler.and_then(|compiler| attribute(compiler, "meshdir")) {
                candidates.push(folder.join(own).join(path));
                let bare = Path::new(path).file_name().unwrap_or_default();
                candidates.push(folder.join(own).join(bare));
            }
        }
        let found = candidates.iter().find(|candidate| candidate.is_file());
        found.or(candidates.first()).cloned().unwrap_or_default()
    }
}

/// The pose in an `<origin>`: a place, and turns about axes that stand still.
fn origin(of: &Element) -> Isometry3<f64> {
    let Some(origin) = of.get_child("origin") else { return Isometry3::identity() };
    let place = attribute(origin, "xyz").and_then(vector).unwrap_or_default();
    let turns = attribute(origin, "rpy").and_then(vector).unwrap_or_default();
    let turn = UnitQuaternion::from_euler_angles(turns.x, turns.y, turns.z);
    Isometry3::from_parts(Translation3::from(place), turn)
}

/// A geom where its description has it.
fn placed(mut geom: Element, described: &Element) -> Element {
    geom.namespace.clone_from(&described.namespace);
    set_pose(&mut geom, &origin(described));
    geom
}

/// The mass and inertia of a link, where they are those of a body that there can be.
fn inertial(link: &Element) -> Option<Element> {
    let described = link.get_child("inertial")?;
    let number =
        |child: &str, name: &str| numbers(attribute(described.get_child(child)?, name)?).first().copied();
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
    let full = [
        inertia[(0, 0)],
        inertia[(1, 1)],
        inertia[(2, 2)],
        inertia[(0, 1)],
        inertia[(0, 2)],
        inertia[(1, 2)],
    ];
    Some(element(
        "inertial",
        &[
            ("pos", exact(pose.translation.vector.iter())),
            ("mass", exact(&[mass])),
            ("fullinertia", exact(&full)),
        ],
    ))
}
