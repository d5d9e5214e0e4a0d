//! The links and joints of a URDF file, as read by every command.

use std::collections::BTreeSet;

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::source::{Refused, Source};
use super::tree::Element;
use crate::creature::UNLIMITED_SLIDE;
use crate::geometry::{Frame, Shape};
use crate::named::did_you_mean;
use crate::plausible::bounded;

/// Greatest angle of a roll, pitch or yaw that is taken for radians: a turn, and what rounding puts on top of it.
pub(crate) const GREATEST_TURN: f64 = std::f64::consts::TAU + 0.01;

/// Elements that URDF defines, by the element that they are in: a name close to one of these is likely a typo and would otherwise be
/// silently ignored.
const ELEMENTS: [(&str, &str); 7] = [
    ("robot", "link joint material gazebo transmission mujoco ros2_control plugin sensor"),
    ("link", "inertial visual collision contact sensor"),
    ("joint", "origin parent child axis calibration dynamics limit mimic safety_controller"),
    ("inertial", "origin mass inertia"),
    ("collision", "origin geometry material name verbose contact_coefficients surface"),
    ("visual", "origin geometry material name meterial plugin"),
    ("geometry", "box cylinder sphere mesh capsule plane cone ellipsoid heightmap"),
];
/// Attributes, by their element.
const ATTRIBUTES: [(&str, &str); 13] = [
    ("origin", "xyz rpy quat_xyzw rotation"),
    ("axis", "xyz rpy"),
    ("parent", "link joint"),
    ("child", "link joint"),
    ("limit", "lower upper effort velocity acceleration deceleration jerk"),
    ("mimic", "joint multiplier offset"),
    ("mass", "value"),
    ("box", "size"),
    ("sphere", "radius"),
    ("cylinder", "radius length"),
    ("capsule", "radius length"),
    ("mesh", "filename scale"),
    ("joint", "name type"),
];

/// What a joint lets its child do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum UrdfKind {
    Fixed,
    Revolute,
    Continuous,
    Prismatic,
    Floating,
    Planar,
}

impl UrdfKind {
    const NAMES: [(&'static str, UrdfKind); 6] = [
        ("fixed", UrdfKind::Fixed),
        ("revolute", UrdfKind::Revolute),
        ("continuous", UrdfKind::Continuous),
        ("prismatic", UrdfKind::Prismatic),
        ("floating", UrdfKind::Floating),
        ("planar", UrdfKind::Planar),
    ];

    /// Whether it is one coordinate about or along an axis.
    pub fn is_single(self) -> bool {
        matches!(self, UrdfKind::Revolute | UrdfKind::Continuous | UrdfKind::Prismatic)
    }
}

/// Where something is in the frame of its link or its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Origin {
    /// Metres.
    pub place: Vector3<f64>,
    /// Roll, pitch and yaw, radians: turns about axes that stand still, one after the other.
    pub turns: [f64; 3],
}

impl Origin {
    /// The `<origin>` in an element; zero where there is none.
    pub fn of(element: &Element) -> Origin {
        let vector = |name: &str| element.child("origin")?.vector(name);
        let turns = vector("rpy").unwrap_or_default();
        Origin { place: vector("xyz").unwrap_or_default(), turns: turns.into() }
    }

    /// The rotation by its turns.
    pub fn rotation(&self) -> Matrix3<f64> {
        let [roll, pitch, yaw] = self.turns;
        Rotation3::from_euler_angles(roll, pitch, yaw).into_inner()
    }

    /// The pose that it is.
    pub fn frame(&self) -> Frame {
        Frame { rotation: self.rotation(), origin: self.place }
    }
}

/// How a joint goes along with another: its coordinate is gain × the leader's + offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Following<J> {
    /// The joint that it follows in the end; `None` if that stands still.
    pub leader: Option<J>,
    pub gain: f64,
    pub offset: f64,
}

/// A joint as its file has it.
#[derive(Clone, Debug)]
pub(crate) struct UrdfJoint<'a> {
    pub element: &'a Element,
    pub name: &'a str,
    pub parent: &'a str,
    pub child: &'a str,
    pub kind: UrdfKind,
    /// Of any length above zero.
    pub axis: Vector3<f64>,
    /// Least and greatest coordinate, radians or metres; `None` if it has no limits.
    pub limits: Option<[f64; 2]>,
    pub follows: Option<Following<&'a str>>,
}

/// A robot's links and joints, which make a tree.
#[derive(Clone, Debug)]
pub(crate) struct UrdfTree<'a> {
    source: &'a Source,
    /// The link that no joint carries.
    pub root: &'a str,
    /// In the file's order.
    pub links: Vec<(&'a str, &'a Element)>,
    /// Every joint after those that carry it; those of one link in the file's order.
    pub joints: Vec<UrdfJoint<'a>>,
    /// What is read otherwise than it stands in the file, or looks odd, a sentence each.
    pub notes: Vec<String>,
}

impl<'a> UrdfTree<'a> {
    /// Reads a file's tree.
    ///
    /// # Errors
    /// Where its links and joints make none.
    pub fn new(source: &'a Source) -> Result<UrdfTree<'a>, Refused> {
        check_names(source, &source.root)?;
        let children = || source.root.children.iter();
        if let Some(of_xacro) = children().find(|child| child.name.starts_with("xacro:")) {
            let message =
                format!("<{}> is Xacro, not URDF; expand it with `xacro FILE > robot.urdf`", of_xacro.name);
            return Err(source.refused(of_xacro, message));
        }
        let mut tree =
            UrdfTree { source, root: "", links: Vec::new(), joints: Vec::new(), notes: Vec::new() };
        for link in children().filter(|child| child.name == "link") {
            let name = link.get("name").unwrap_or_default();
            if name.trim().is_empty() {
                return Err(source.refused(link, "<link> has no name; give it name=\"…\""));
            }
            if tree.link(name).is_some() {
                return Err(source.refused(link, format!("two links are called {name}; rename one")));
            }
            tree.links.push((name, link));
        }
        let mut joints: Vec<UrdfJoint> = Vec::new();
        for element in children().filter(|child| child.name == "joint") {
            let joint = tree.joint(element)?;
            let same = |other: &&UrdfJoint| !joint.name.is_empty() && other.name == joint.name;
            if let Some(other) = joints.iter().find(same) {
                return Err(
                    source.refused(element, format!("two joints are called {}; rename one", other.name))
                );
            }
            if joints.iter().any(|other| other.child == joint.child) {
                let message = format!("link {} has two parent joints; remove one of them", joint.child);
                return Err(source.refused(element, message));
            }
            joints.push(joint);
        }
        for k in 0..joints.len() {
            joints[k].follows = tree.following(&joints, &joints[k])?;
        }
        tree.root = tree.root_of(&joints)?;
        tree.joints = tree.in_order(joints)?;
        Ok(tree)
    }

    /// A link's element.
    pub fn link(&self, name: &str) -> Option<&'a Element> {
        self.links.iter().find(|(other, _)| *other == name).map(|(_, link)| *link)
    }

    /// What a shape of a link is, metres; `None` for a mesh and what is none of URDF.
    ///
    /// # Errors
    /// Where a length is not above 0.
    pub fn shape(&self, link: &str, described: &Element) -> Result<Option<Shape>, Refused> {
        let lengths = |name: &str| {
            let lengths = Some(described.numbers(name)).filter(|lengths| !lengths.is_empty());
            lengths.filter(|lengths| lengths.iter().all(|&length| length > 0.0)).ok_or_else(|| {
                let title = &described.name;
                let message = format!(
                    "<{title}> of link {link} needs {name}=\"…\" above 0; give it metres, numbers above 0"
                );
                self.source.refused(described, message)
            })
        };
        let round = || Ok::<_, Refused>((lengths("radius")?[0], 0.5 * lengths("length")?[0]));
        Ok(Some(match described.name.as_str() {
            "box" => {
                let size = lengths("size")?;
                Shape::Box { half_extents: [0, 1, 2].map(|i| 0.5 * size[i.min(size.len() - 1)]) }
            }
            "sphere" => Shape::Sphere { radius: lengths("radius")?[0] },
            "cylinder" => round().map(|(radius, half_length)| Shape::Cylinder { radius, half_length })?,
            "capsule" => round().map(|(radius, half_length)| Shape::Capsule { radius, half_length })?,
            _ => return Ok(None),
        }))
    }

    /// The joints that a link carries.
    pub fn carried_by<'t>(&'t self, link: &'t str) -> impl Iterator<Item = &'t UrdfJoint<'a>> {
        self.joints.iter().filter(move |joint| joint.parent == link)
    }

    fn joint(&mut self, element: &'a Element) -> Result<UrdfJoint<'a>, Refused> {
        let name = element.get("name").unwrap_or_default();
        let [parent, child] = [self.end(element, "parent")?, self.end(element, "child")?];
        let given = element.get("type").unwrap_or_default();
        let Some((_, kind)) = UrdfKind::NAMES.into_iter().find(|(name, _)| *name == given) else {
            let message = format!(
                "joint {name} has type \"{given}\"; give revolute, continuous, prismatic, fixed, floating or planar"
            );
            return Err(self.source.refused(element, message));
        };
        let axis = element.child("axis").and_then(|axis| axis.vector("xyz"));
        let axis = axis.unwrap_or(Vector3::x());
        if kind.is_single() && axis.norm() < f64::EPSILON {
            let message =
                format!("the axis of joint {name} has no direction; give it one in <axis xyz=\"…\"/>");
            return Err(self.source.refused(element, message));
        }
        let limits = self.limits(element, name, kind);
        Ok(UrdfJoint { element, name, parent, child, kind, axis, limits, follows: None })
    }

    /// The link at an end of a joint.
    fn end(&self, joint: &Element, end: &str) -> Result<&'a str, Refused> {
        let name = joint.get("name").unwrap_or_default();
        let refused = |message: String| self.source.refused(joint, message);
        let link = joint.child(end).and_then(|end| end.get("link"));
        let link =
            link.ok_or_else(|| refused(format!("joint {name} has no <{end} link=\"…\"/>; give it one")))?;
        let known = self.links.iter().find(|(known, _)| *known == link);
        known.map(|(known, _)| *known).ok_or_else(|| {
            refused(format!("joint {name} names the link {link}, which does not exist; correct it there"))
        })
    }

    /// The limits of a joint. Limits that leave no room are none, as MuJoCo has it, and so are those beyond all that can be,
    /// by which other programs say that there are none.
    fn limits(&mut self, joint: &Element, name: &str, kind: UrdfKind) -> Option<[f64; 2]> {
        let limit = joint.child("limit").filter(|_| kind.is_single() && kind != UrdfKind::Continuous)?;
        let given = ["lower", "upper"].map(|end| limit.number(end));
        let [lower, upper] = given.map(Option::unwrap_or_default);
        let span = if kind == UrdfKind::Prismatic { UNLIMITED_SLIDE } else { std::f64::consts::PI };
        let limits = bounded([lower, upper], span).filter(|_| lower < upper);
        if limits != Some([lower, upper]) && given != [None; 2] {
            let read =
                limits.map_or("ignored".into(), |[lower, upper]| format!("read as {lower:.3} to {upper:.3}"));
            self.notes.push(format!("the limits of joint {name}, {lower:?} to {upper:?}, are {read}"));
        }
        limits
    }

    /// What a joint follows, through all that follow others themselves.
    fn following(
        &mut self,
        joints: &[UrdfJoint<'a>],
        joint: &UrdfJoint<'a>,
    ) -> Result<Option<Following<&'a str>>, Refused> {
        let Some(own) = mimic_of(joint) else { return Ok(None) };
        let mut found = Following { leader: Some(joint.name), gain: 1.0, offset: 0.0 };
        let (mut on, mut next) = (joint, Some(own));
        for _ in 0..=joints.len() {
            let Some(mimic) = next else { return Ok(Some(found)) };
            let refused = |message: String| Err(self.source.refused(mimic, message));
            let Some(leader) = mimic.get("joint").filter(|leader| !leader.is_empty()) else {
                return refused(format!("<mimic> of joint {} names no joint; give it joint=\"…\"", on.name));
            };
            let Some(leader) = joints.iter().find(|other| other.name == leader) else {
                let message =
                    format!("joint {} mimics {leader}, which does not exist; correct it there", on.name);
                return refused(message);
            };
            if leader.name == joint.name {
                let way =
                    if on.name == joint.name { String::new() } else { format!(" by way of {}", on.name) };
                let message = format!("joint {} mimics itself{way}; remove one <mimic>", joint.name);
                return Err(self.source.refused(own, message));
            }
            let number = |name: &str, default: f64| mimic.number(name).unwrap_or(default);
            found.offset += found.gain * number("offset", 0.0);
            found.gain *= number("multiplier", 1.0);
            (found.leader, on, next) = (Some(leader.name), leader, mimic_of(leader));
            if leader.kind == UrdfKind::Fixed {
                found.leader = None;
                return Ok(Some(found));
            }
            if !leader.kind.is_single() {
                self.notes.push(format!(
                    "joint {} mimics {}, which has no single coordinate; it moves independently here",
                    joint.name, leader.name
                ));
                return Ok(None);
            }
        }
        // Others go round in a circle that it is not in.
        let message = format!("joint {} mimics joints that mimic each other; remove one <mimic>", joint.name);
        Err(self.source.refused(own, message))
    }

    /// The one link that no joint carries.
    fn root_of(&self, joints: &[UrdfJoint]) -> Result<&'a str, Refused> {
        let path = &self.source.path;
        let mut roots = self.links.iter().filter(|(name, _)| joints.iter().all(|joint| joint.child != *name));
        match (roots.next(), roots.next()) {
            (Some((root, _)), None) => Ok(root),
            (None, _) if self.links.is_empty() => {
                Err(Refused::file(path, "it has no <link>; give a robot with links and joints"))
            }
            (None, _) => {
                Err(Refused::file(path, "its links form a loop; correct the <parent> of one of its joints"))
            }
            (Some((first, _)), Some((second, link))) => Err(self.source.refused(
                link,
                format!("links {first} and {second} are not carried by any joint; join them with a <joint>"),
            )),
        }
    }

    /// The joints, every one after those that carry it.
    fn in_order(&self, joints: Vec<UrdfJoint<'a>>) -> Result<Vec<UrdfJoint<'a>>, Refused> {
        let mut order: Vec<UrdfJoint> = Vec::new();
        let mut reached = BTreeSet::from([self.root]);
        let mut due = vec![self.root];
        while let Some(link) = due.pop() {
            order.extend(joints.iter().find(|joint| joint.child == link).cloned());
            // The first of them is the next to be looked at.
            for joint in joints.iter().rev().filter(|joint| joint.parent == link) {
                reached.insert(joint.child);
                due.push(joint.child);
            }
        }
        match self.links.iter().find(|(name, _)| !reached.contains(name)) {
            None => Ok(order),
            Some((name, link)) => {
                let message =
                    format!("link {name} is its own parent; correct the <parent> of one of its joints");
                Err(self.source.refused(link, message))
            }
        }
    }

    /// Every `<origin>` whose turns look like degrees, with what is wrong.
    pub fn turn_faults(&self) -> Vec<(&'a Element, String)> {
        let of_joints = self.joints.iter().map(|joint| (joint.element, format!("joint {}", joint.name)));
        let of_links = self.links.iter().flat_map(|(name, link)| {
            let parts = ["inertial", "visual", "collision"];
            let placed = link.children.iter().filter(move |child| parts.contains(&child.name.as_str()));
            placed.map(move |child| (child, format!("link {name}")))
        });
        let faults = of_joints.chain(of_links).filter_map(|(of, title)| {
            let origin = of.child("origin")?;
            let (rpy, turns) = (origin.get("rpy")?, origin.vector("rpy")?);
            let fault = format!("rpy=\"{rpy}\" of {title} is more than a turn: give radians, not degrees");
            (turns.amax() > GREATEST_TURN).then_some((origin, fault))
        });
        faults.collect()
    }
}

/// The `<mimic>` of a joint that can go along with another.
fn mimic_of<'a>(joint: &UrdfJoint<'a>) -> Option<&'a Element> {
    joint.element.child("mimic").filter(|_| joint.kind.is_single())
}

/// Refuses names that are nearly some of URDF.
fn check_names(source: &Source, element: &Element) -> Result<(), Refused> {
    let slip =
        element.attributes.iter().find_map(|(name, _)| Some((name, attribute_meant(&element.name, name)?)));
    if let Some((name, meant)) = slip {
        let message =
            format!("{name}=\"…\" of {} is none of URDF; correct it, if {meant} is meant", element.title());
        return Err(source.refused(element, message));
    }
    if !is_known(&element.name) {
        return Ok(());
    }
    element.children.iter().try_for_each(|child| match element_meant(&element.name, &child.name) {
        Some(meant) => {
            let message = format!("<{}> is none of URDF; correct it, if <{meant}> is meant", child.name);
            Err(source.refused(child, message))
        }
        None => check_names(source, child),
    })
}

/// The element that is meant by one in an element called `parent`, where it is misspelt.
fn element_meant(parent: &str, name: &str) -> Option<&'static str> {
    meant(&ELEMENTS, parent, name)
}

/// The attribute that is meant by one of an element, where it is misspelt.
fn attribute_meant(element: &str, name: &str) -> Option<&'static str> {
    meant(&ATTRIBUTES, element, name)
}

/// Whether what is in an element is known here: what others have put in, is theirs.
fn is_known(element: &str) -> bool {
    ELEMENTS.iter().any(|(parent, _)| *parent == element)
}

fn meant(of: &[(&str, &'static str)], within: &str, name: &str) -> Option<&'static str> {
    let (_, known) = of.iter().find(|(parent, _)| *parent == within)?;
    let mut known = known.split(' ');
    if known.clone().any(|known| known == name) { None } else { did_you_mean(name, &mut known) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_told_from_names_of_others() {
        assert_eq!(element_meant("joint", "limi"), Some("limit"));
        assert_eq!(element_meant("inertial", "orkgin"), Some("origin"));
        assert_eq!(attribute_meant("origin", "xy"), Some("xyz"));
        assert_eq!(attribute_meant("limit", "Lower"), Some("lower"));
        for (parent, name) in
            [("joint", "limit"), ("joint", "gazebo"), ("geometry", "octomap"), ("drake", "limi")]
        {
            assert_eq!(element_meant(parent, name), None, "{name}");
        }
        assert_eq!(attribute_meant("origin", "id"), None);
    }
}
