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
use super::urdf_names::{attribute_meant, element_meant, is_known};
use super::{attribute, element, exact, titled};

/// The link that stands for the world where it is the root.
const WORLD: &str = "world";
/// Elements of a robot that are of no use here.
const UNNEEDED: [&str; 5] = ["material", "gazebo", "transmission", "mujoco", "ros2_control"];

/// A robot's tree in MJCF's terms.
///
/// # Errors
/// Where its links and joints make no tree.
pub(crate) fn to_mjcf(source: &Source) -> Result<Reduced, Refused> {
    check_names(source, &source.root)?;
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

/// Refuses names that are nearly some of URDF.
fn check_names(source: &Source, element: &Element) -> Result<(), Refused> {
    let slip = element.attributes.keys().find_map(|name| Some((name, attribute_meant(&element.name, name)?)));
    if let Some((name, meant)) = slip {
        let message =
            format!("{name}=\"…\" of {} is none of URDF; correct it, if {meant} is meant", titled(element));
        return Err(source.refused(element, message));
    }
    if !is_known(&element.name) {
        return Ok(());
    }
    element.children.iter().filter_map(XMLNode::as_element).try_for_each(|child| {
        match element_meant(&element.name, &child.name) {
            Some(meant) => {
                let message = format!("<{}> is none of URDF; correct it, if <{meant}> is meant", child.name);
                Err(source.refused(child, message))
            }
            None => check_names(source, child),
        }
    })
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
            if child.name == "link" && name().is_empty() {
                return Err(robot.refused(child, "<link> has no name; give it name=\"…\""));
            }
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
        self.source.refused(element, message)
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
        let mut geoms = self.geoms(described, "collision")?;
        if geoms.is_empty() {
            geoms = self.geoms(described, "visual")?;
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
            let leader = self.leader(name, mimic)?;
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

    /// The joint that another mimics.
    fn leader<'e>(&self, name: &str, mimic: &'e Element) -> Result<&'e str, Refused> {
        let refused = |message: String| Err(self.robot.refused(mimic, message));
        let Some(leader) = attribute(mimic, "joint").filter(|leader| !leader.is_empty()) else {
            return refused(format!("<mimic> of joint {name} names no joint; give it joint=\"…\""));
        };
        let joint =
            |name: &str| self.robot.joints.iter().find(|joint| attribute(joint, "name") == Some(name));
        if joint(leader).is_none() {
            return refused(format!("joint {name} mimics {leader}, which is not there; correct it there"));
        }
        let next = |of: &&str| attribute(joint(of)?.get_child("mimic")?, "joint");
        let mut followed = std::iter::successors(Some(leader), next).take(self.robot.joints.len());
        if followed.any(|followed| followed == name) {
            let way = if leader == name { String::new() } else { format!(" by way of {leader}") };
            return refused(format!("joint {name} mimics itself{way}; remove one <mimic>"));
        }
        Ok(leader)
    }

    /// The geom of a `<collision>` or `<visual>`; none where it has a shape that cannot be read.
    fn geom(&mut self, described: &Element) -> Result<Option<Element>, Refused> {
        let shape =
            described.get_child("geometry").and_then(|e| e.children.iter().find_map(XMLNode::as_element));
        let Some(shape) = shape else {
            self.left_out.lose(format!("<{}> without geometry", described.name), 1);
            return Ok(None);
        };
        let lengths = |name: &str| {
            let lengths = attribute(shape, name).map(numbers).filter(|lengths| !lengths.is_empty());
            lengths.filter(|lengths| lengths.iter().all(|&length| length > 0.0)).ok_or_else(|| {
                let message = format!("<{}> needs {name}=\"…\" of numbers above 0; give it that", shape.name);
                self.robot.refused(shape, message)
            })
        };
        let round = || Ok::<_, Refused>(vec![lengths("radius")?[0], 0.5 * lengths("length")?[0]]);
        let (kind, size) = match shape.name.as_str() {
            "box" => ("box", lengths("size")?.into_iter().map(|size| 0.5 * size).collect()),
            "sphere" => ("sphere", lengths("radius")?),
            "cylinder" => ("cylinder", round()?),
            "capsule" => ("capsule", round()?),
            "mesh" => {
                let mesh = self.mesh(shape)?;
                let geom = element("geom", &[("type", "mesh".into()), ("mesh", mesh)]);
                return Ok(Some(placed(geom, described)));
            }
            other => {
                self.left_out.lose(format!("geometry <{other}>"), 1);
                return Ok(None);
            }
        };
        Ok(Some(placed(element("geom", &[("type", kind.into()), ("size", exact(&size))]), described)))
    }

    /// The geoms of all descriptions of a kind.
    fn geoms(&mut self, link: &Element, kind: &str) -> Result<Vec<Element>, Refused> {
        let mut geoms = Vec::new();
        for described in link.children.iter().filter_map(XMLNode::as_element).filter(|e| e.name == kind) {
            geoms.extend(self.geom(described)?);
        }
        Ok(geoms)
    }

    /// The name of a mesh, which is read with its scale.
    fn mesh(&mut self, shape: &Element) -> Result<String, Refused> {
        let file = attribute(shape, "filename").filter(|file| !file.trim().is_empty());
        let file =
            file.ok_or_else(|| self.robot.refused(shape, "<mesh> names no file; give it filename=\"…\""))?;
        let file = self.file(file);
        let scale = attribute(shape, "scale").and_then(vector).unwrap_or(Vector3::repeat(1.0));
        let stem = file.file_stem().and_then(|stem| stem.to_str()).unwrap_or("mesh").to_string();
        let (file, scale) = (file.display().to_string(), exact(scale.iter()));
        let same = |mesh: &Element| {
            attribute(mesh, "file") == Some(&file) && attribute(mesh, "scale") == Some(&scale)
        };
        let mut name = stem.clone();
        for number in 2.. {
            if self.meshes.get(&name).is_none_or(same) {
                break;
            }
            name = format!("{stem}_{number}");
        }
        let mesh = [("name", name.clone()), ("file", file.clone()), ("scale", scale.clone())];
        let mesh = Element { namespace: shape.namespace.clone(), ..element("mesh", &mesh) };
        self.meshes.insert(name.clone(), mesh);
        Ok(name)
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
