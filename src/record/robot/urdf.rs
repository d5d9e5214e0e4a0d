//! A robot from URDF: its links and joints as quantities, its masses, and what of its collision geometry is no mesh.
//!
//! The pose of a joint's child is `JOINT.position`, then `JOINT.orientation`, then what the degree of freedom JOINT does.
//! The crate `urdf-rs` refuses limits without a greatest velocity and masses without an inertia, and keeps neither lines
//! nor bytes, without which a file could not be written back as it was.

use std::path::Path;

use nalgebra::Rotation3;

use super::edits::first_byte;
use super::tags::{Fault, Tag, parse};
use super::urdf_elements::{Origin, number, rotation, shapes, unit, vector};
use crate::calibration::robot::{Element, Form, LinkMass, Robot, Unit, Value};
use crate::creature::{DofKind, UNLIMITED_SLIDE};
use crate::geometry::{Frame, Shape};
use crate::mjcf_xml::{
    Refused, Source, UrdfFollowing, UrdfJoint, UrdfKind, UrdfTree, check_limits, check_values,
};
use crate::session::RecordError;

/// A robot of a URDF file.
#[derive(Clone, Debug, PartialEq)]
pub struct UrdfRobot {
    /// The robot, in its maker's frames. A joint that mimics another is a degree of freedom after all that do not, with the
    /// coordinate of the one that it follows, by its nominal gain and offset.
    pub robot: Robot,
    /// What of the file is of no use here, a sentence each.
    pub passed_over: Vec<String>,
}

/// Reads a robot from the bytes of a URDF file, which is called `path` in messages.
///
/// # Errors
/// Where it is no URDF, or describes no tree of hinges, slides and fixed joints; [`RecordError`] names the
/// line.
pub fn read_urdf(path: &Path, bytes: &[u8]) -> Result<UrdfRobot, RecordError> {
    let at = |(line, message): Fault| RecordError::format(path, Some(line), message);
    let refused = |refused: Refused| RecordError::format(path, refused.line, refused.message);
    let tags = root(bytes).map_err(at)?;
    let source = Source::of_text(path, &String::from_utf8_lossy(bytes)).map_err(refused)?;
    check_limits(&source).and_then(|()| check_values(&source)).map_err(refused)?;
    let tree = UrdfTree::new(&source).map_err(refused)?;
    robot(&tags, &tree).map_err(at)
}

/// The element `<robot>` of a file.
pub(super) fn root(bytes: &[u8]) -> Result<Tag, Fault> {
    let refused = |message: &str| Err((1, message.to_string()));
    match first_byte(bytes) {
        Some(b'{' | b'[') => {
            return refused(
                "it is JSON where URDF is expected: give it with the ending .json, or give a URDF file",
            );
        }
        Some(b'<') => {}
        Some(0xff | 0xfe) => return refused("it is in UTF-16: save it in UTF-8"),
        None => return refused("it is empty: give a URDF file"),
        Some(_) => return refused("it is no XML: give a URDF file, whose first element is <robot>"),
    }
    let root = parse(bytes)?;
    match root.name.as_str() {
        "robot" => Ok(root),
        name => {
            let message =
                format!("it is no URDF, but <{name}>: give a URDF file, whose first element is <robot>");
            Err((root.line, message))
        }
    }
}

/// The robot of a file's tree; `tags` are the same elements with the bytes that they stand in.
fn robot(tags: &Tag, tree: &UrdfTree) -> Result<UrdfRobot, Fault> {
    let mut robot = Robot::new(tags.value("name").unwrap_or("robot"), tree.root);
    let mut passed_over = tree.notes.clone();
    let mut followers = Vec::new();
    for joint in &tree.joints {
        let UrdfJoint { name, parent, child, axis, .. } = *joint;
        let tag = tags
            .children_of("joint")
            .find(|tag| tag.child("child").and_then(|c| c.value("link")) == Some(child));
        let tag = tag.unwrap_or(tags);
        if name.is_empty() {
            return Err((tag.line, "<joint> has no name: give it name=\"…\"".into()));
        }
        let Origin { place, turns } = Origin::of(tag, &format!("joint {name}"))?;
        let parent_link = robot.link(parent).unwrap_or_default();
        let kind = match joint.kind {
            UrdfKind::Fixed => None,
            UrdfKind::Revolute | UrdfKind::Continuous => Some(DofKind::Hinge),
            UrdfKind::Prismatic => Some(DofKind::Slide),
            UrdfKind::Floating | UrdfKind::Planar => {
                let about = tag.value("type").unwrap_or_default();
                if parent != tree.root {
                    let message = format!(
                        "joint {name} is {about}, which an encoder does not read: make it fixed, or hinges and slides \
                         one after the other"
                    );
                    return Err((tag.line, message));
                }
                passed_over.push(format!(
                    "joint {name} is {about} and at the root: link {child} is taken to stand still in link {parent}"
                ));
                let pose = Frame { rotation: rotation(turns), origin: place };
                robot.add_link(child, parent_link, vec![Element::Fixed(pose)]);
                continue;
            }
        };
        let shift = robot.add_quantity(format!("{name}.position"), Unit::Metre, Value::Position(place));
        let turn = Value::Orientation(rotation(turns));
        let turn = robot.add_quantity(format!("{name}.orientation"), Unit::Radian, turn);
        let mut elements = vec![Element::Shift(shift), Element::Turn(turn)];
        if let Some(kind) = kind {
            let span = if kind == DofKind::Slide { UNLIMITED_SLIDE } else { std::f64::consts::PI };
            let range = joint.limits.unwrap_or([-span, span]);
            let axis = unit(&axis);
            match joint.follows {
                Some(UrdfFollowing { leader: Some(leader), gain, offset }) => {
                    followers.push((name, leader, [gain, offset], kind, range, axis, robot.links.len()));
                }
                // It stands where its leader, which is fixed, holds it.
                Some(UrdfFollowing { offset, .. }) => elements.push(Element::Fixed(match kind {
                    DofKind::Slide => Frame { origin: axis * offset, ..Frame::identity() },
                    _ => Frame { rotation: Rotation3::new(axis * offset).into_inner(), ..Frame::identity() },
                })),
                None => elements.push(Element::Dof(robot.add_dof(name, kind, range, axis))),
            }
        }
        robot.add_link(child, parent_link, elements);
    }
    for (name, leader, [gain, offset], kind, range, axis, link) in followers {
        let Some(coordinate) = robot.dof(leader).map(|leader| robot.dofs[leader].coordinate) else {
            continue;
        };
        let dof = robot.add_dof(name, kind, range, axis);
        robot.dofs[dof].coordinate = coordinate;
        if let Some(q) = robot.dofs[dof].quantities {
            robot.quantities[q.gain].nominal = Value::Number(gain);
            robot.quantities[q.offset].nominal = Value::Number(offset);
        }
        robot.links[link].elements.push(Element::Dof(dof));
    }
    let mut meshed = Vec::new();
    for tag in tags.children_of("link") {
        let name = tag.value("name").unwrap_or_default();
        let link = robot.link(name).unwrap_or_default();
        add_mass(&mut robot, link, tag)?;
        add_surfaces(&mut robot, link, tag)?;
        let mesh = |c: &Tag| c.child("geometry").and_then(|g| g.child("mesh")).is_some();
        if tag.children_of("collision").any(mesh) {
            meshed.push(name);
        }
    }
    if !meshed.is_empty() {
        let links = meshed.join(", ");
        passed_over.push(format!(
            "the meshes of {links} are passed over: only spheres, cylinders, capsules and boxes are surfaces here"
        ));
    }
    Ok(UrdfRobot { robot, passed_over })
}

/// What a link weighs, where it weighs anything.
fn add_mass(robot: &mut Robot, link: usize, tag: &Tag) -> Result<(), Fault> {
    let Some(inertial) = tag.child("inertial") else { return Ok(()) };
    let of = format!("link {}", robot.links[link].name);
    let Some(mass) = inertial.child("mass") else { return Ok(()) };
    let kilograms = number(mass, "value", &of)?.unwrap_or(0.0);
    if kilograms < 0.0 {
        return Err((mass.line, format!("the mass of {of} is negative: give kilograms")));
    }
    if kilograms > 0.0 {
        let centre = Origin::of(inertial, &of)?.place;
        robot.masses.push(LinkMass { link, mass: kilograms, centre });
    }
    Ok(())
}

/// A link's collision geometry as surfaces: called LINK where there is one, else LINK.1, LINK.2 and so on.
fn add_surfaces(robot: &mut Robot, link: usize, tag: &Tag) -> Result<(), Fault> {
    let of = format!("link {}", robot.links[link].name);
    for (name, collision, shape) in shapes(&robot.links[link].name.clone(), tag) {
        let Origin { place, turns } = Origin::of(collision, &of)?;
        let pose = Frame { rotation: rotation(turns), origin: place };
        let length = |attribute: &str| {
            number(shape, attribute, &of)?.filter(|length| *length > 0.0).ok_or_else(|| {
                let message =
                    format!("<{}> of {of} needs {attribute}=\"…\" above 0: give metres", shape.name);
                (shape.line, message)
            })
        };
        let form = match shape.name.as_str() {
            "sphere" => {
                robot.add_sphere(&name, link, pose, length("radius")?);
                continue;
            }
            "cylinder" => Shape::Cylinder { radius: length("radius")?, half_length: 0.5 * length("length")? },
            "capsule" => Shape::Capsule { radius: length("radius")?, half_length: 0.5 * length("length")? },
            _ => {
                let size = vector(shape, "size", &of)?.filter(|size| size.min() > 0.0).ok_or_else(|| {
                    (shape.line, format!("<box> of {of} needs size=\"…\" above 0: give metres"))
                })?;
                Shape::Box { half_extents: (0.5 * size).into() }
            }
        };
        robot.add_surface(&name, link, pose, Form::Solid(form));
    }
    Ok(())
}

#[cfg(test)]
pub(super) mod tests {
    use nalgebra::{Matrix3, Vector3};

    use super::*;
    use crate::calibration::robot::Posed;

    pub const ARM: &str = r#"<?xml version="1.0"?>
<!-- An arm, as its maker has it. -->
<robot name="arm">
  <link name="base"><collision><geometry><sphere   radius='0.05'/></geometry></collision></link>
  <link name="upper">
    <inertial><origin xyz="0 0 0.1"/><mass value="1.5"/></inertial>
    <collision><geometry><mesh filename="x.stl"/></geometry></collision>
    <collision><origin xyz="0 0 0.1" rpy="0 0 0.5"/><geometry><cylinder radius="0.03" length="0.2"/></geometry></collision>
    <collision><geometry><sphere radius="0.04"/></geometry></collision>
  </link>
  <joint name="shoulder" type="revolute">
    <!-- odd, but so it is -->
    <origin rpy="1.55 -0.3 3.12"   xyz="0.1 0 0.30"/>
    <parent link="base"/><child link="upper"/>
    <axis xyz="0 0 2"/><limit lower="-1.0" upper="2" effort="5"/>
  </joint>
  <link name="fore"/>
  <joint name="elbow" type="continuous">
    <parent link="upper"/> <child link="fore"/>
  </joint>
  <joint type="fixed" name="wrist"><origin xyz="0 0.2 0"/><parent link="fore"/><child link="hand"/></joint>
  <link name="hand"/>
  <joint name="finger" type="prismatic">
    <parent link="hand"/><child link="tip"/> <origin xyz="0 0 0.1" rpy="0 1.5707963267948966 0"/>
    <axis xyz="0.6 0 0.8"/> <limit lower="0" upper="0.04" effort="1" velocity="1"/>
  </joint>
  <joint name="thumb" type="prismatic">
    <parent link="hand"/><child link="other_tip"/>
    <axis xyz="0 -1 0"/> <mimic joint="finger" multiplier="-0.5"/>
  </joint>
  <link name="tip"/><link name="other_tip"/>
</robot>
"#;

    pub fn read(text: &str) -> Result<UrdfRobot, String> {
        let read = read_urdf(Path::new("arm.urdf"), text.as_bytes());
        read.map_err(|error| error.to_string())
    }

    pub fn about(axis: usize, angle: f64) -> Frame {
        let turn = Rotation3::new(Vector3::ith(axis, angle)).into_inner();
        Frame { rotation: turn, origin: Vector3::zeros() }
    }

    fn at(x: f64, y: f64, z: f64) -> Frame {
        Frame { rotation: Matrix3::identity(), origin: Vector3::new(x, y, z) }
    }

    pub fn assert_near(a: &Frame, b: &Frame, what: &str) {
        let far = (a.rotation - b.rotation).norm().max((a.origin - b.origin).norm());
        assert!(far < 1e-12, "{what}: {far}");
    }

    #[test]
    fn links_are_where_urdf_has_them() {
        let UrdfRobot { robot, passed_over } = read(ARM).unwrap();
        assert_eq!(robot.coordinates(), 3);
        let names: Vec<&str> = robot.dofs.iter().map(|dof| dof.name.as_str()).collect();
        assert_eq!(names, ["shoulder", "elbow", "finger", "thumb"]);
        let pi = std::f64::consts::PI;
        assert_eq!(robot.dofs[0].range, [-1.0, 2.0]);
        assert_eq!(robot.dofs[1].range, [-pi, pi]);
        let surfaces: Vec<&str> = robot.surfaces.iter().map(|surface| surface.name.as_str()).collect();
        assert_eq!(surfaces, ["base", "upper.1", "upper.2"]);
        assert!(robot.quantity("upper.2.radius").is_some());
        assert_eq!((robot.masses.len(), robot.masses[0].centre), (1, Vector3::new(0.0, 0.0, 0.1)));
        assert_eq!(passed_over.len(), 1, "{passed_over:?}");
        let [q, e, f] = [0.4, -1.1, 0.02];
        let nominal = robot.nominal();
        let frames = Posed::new(&robot, &nominal, &[q, e, f]).frames();
        let frame = |name: &str| frames[robot.link(name).unwrap()];
        let upper = at(0.1, 0.0, 0.3) * about(2, 3.12) * about(1, -0.3) * about(0, 1.55) * about(2, q);
        let hand = upper * about(0, e) * at(0.0, 0.2, 0.0);
        let tip = hand * at(0.0, 0.0, 0.1) * about(1, 0.5 * pi) * at(0.6 * f, 0.0, 0.8 * f);
        assert_near(&frame("upper"), &upper, "upper");
        assert_near(&frame("hand"), &hand, "hand");
        assert_near(&frame("tip"), &tip, "tip");
        assert_near(&frame("other_tip"), &(hand * at(0.0, 0.5 * f, 0.0)), "other_tip");
    }

    #[test]
    fn mistakes_get_a_sentence() {
        let with = |from: &str, to: &str| {
            assert!(ARM.contains(from), "{from}");
            read(&ARM.replacen(from, to, 1)).unwrap_err()
        };
        let cases = [
            (read("{\"joints\": []}").unwrap_err(), "line 1: it is JSON where URDF is expected: "),
            (read("<mujoco/>").unwrap_err(), "line 1: it is no URDF, but <mujoco>: "),
            (read("joint,a,d").unwrap_err(), "line 1: it is no XML: "),
            (with("<link name=\"hand\"/>", "<xacro:hand/>"), "line 22: <xacro:hand> is of Xacro, not URDF; "),
            (
                with("0 0.2 0", "0 ${length} 0"),
                "line 21: \"${length}\" in xyz of <origin> is no number; write it out",
            ),
            (with("0 0.2 0", "0 0.2"), "line 21: xyz of <origin> has 2 numbers; give it 3"),
            (with("0 0.2 0", "0,0.2,0"), "line 21: \"0,0.2,0\" in xyz of <origin> is no number; give one"),
            (
                with("rpy=\"1.55", "rpy=\"90"),
                "line 13: rpy=\"90 -0.3 3.12\" of joint shoulder is more than a turn: ",
            ),
            (with("\"continuous\"", "\"hinge\""), "joint elbow is of the type \"hinge\"; "),
            (
                with("\"continuous\"", "\"floating\""),
                "joint elbow is floating, which an encoder does not read: ",
            ),
            (
                with("parent link=\"hand\"", "parent link=\"palm\""),
                "joint finger names the link palm, which is not there",
            ),
            (with("parent link=\"base\"", "parent link=\"hand\""), "link upper is carried by itself; "),
            (with("joint=\"finger\"", "joint=\"thumb\""), "joint thumb mimics itself"),
            (with("name=\"elbow\"", "name=\"wrist\""), "line 21: there are two joints wrist; "),
            (with("0.6 0 0.8", "0 0 0"), "the axis of joint finger has no direction"),
            (with("'0.05'", "'0'"), "line 4: <sphere> of link base needs radius=\"…\" above 0: "),
        ];
        for (message, expected) in cases {
            assert!(message.contains(expected) && message.contains([':', ';']), "{message} != {expected}");
        }
    }
}
