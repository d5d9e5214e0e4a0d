//! A robot from URDF: its links and joints as quantities, its masses, and what of its collision geometry is no mesh.
//!
//! The pose of a joint's child is `JOINT.position`, then `JOINT.orientation`, then what the degree of freedom JOINT does.

use std::path::Path;

use nalgebra::Rotation3;

use crate::calibration::robot::{Element, Form, LinkMass, Robot, Unit, Value};
use crate::creature::{DofKind, UNLIMITED_SLIDE};
use crate::geometry::{Frame, Shape};
use crate::model_files::{
    Element as Tag, Origin, Refused, Source, UrdfFollowing, UrdfJoint, UrdfKind, UrdfTree, check_limits,
    check_values,
};

/// Reads a robot from a URDF file, in its maker's frames, and tells what of the file is of no use here, a sentence each. A
/// joint that mimics another is a degree of freedom after all that do not, with the coordinate of the one that it follows,
/// by its nominal gain and offset.
///
/// # Errors
/// Where it is no URDF, or describes no tree of hinges, slides and fixed joints.
pub fn read_urdf(path: &Path, bytes: &[u8]) -> Result<(Robot, Vec<String>), Refused> {
    let source = Source::of_bytes(path, bytes)?;
    if source.root.name != "robot" {
        let message = format!(
            "it is no URDF, but <{}>; give a URDF file, whose first element is <robot>",
            source.root.name
        );
        return Err(source.refused(&source.root, message));
    }
    check_limits(&source)?;
    check_values(&source)?;
    let tree = UrdfTree::new(&source)?;
    if let Some((origin, fault)) = tree.turn_faults().into_iter().next() {
        return Err(source.refused(origin, fault));
    }
    robot(&source, &tree)
}

/// The robot of a file's tree.
fn robot(source: &Source, tree: &UrdfTree) -> Result<(Robot, Vec<String>), Refused> {
    let mut robot = Robot::new(source.root.get("name").unwrap_or("robot"), tree.root);
    let mut passed_over = tree.notes.clone();
    let mut followers = Vec::new();
    for joint in &tree.joints {
        let UrdfJoint { name, parent, child, axis, element, .. } = *joint;
        if name.is_empty() {
            return Err(source.refused(element, "<joint> has no name; give it name=\"…\""));
        }
        let origin = Origin::of(element);
        let parent_link = robot.link(parent).unwrap_or_default();
        let kind = match joint.kind {
            UrdfKind::Fixed => None,
            UrdfKind::Revolute | UrdfKind::Continuous => Some(DofKind::Hinge),
            UrdfKind::Prismatic => Some(DofKind::Slide),
            UrdfKind::Floating | UrdfKind::Planar => {
                let about = element.get("type").unwrap_or_default();
                if parent != tree.root {
                    let message = format!(
                        "joint {name} is {about}, which an encoder does not read; make it fixed, or hinges and slides \
                         one after the other"
                    );
                    return Err(source.refused(element, message));
                }
                passed_over.push(format!(
                    "joint {name} is {about} and at the root: link {child} is taken to stand still in link {parent}"
                ));
                robot.add_link(child, parent_link, vec![Element::Fixed(frame(&origin))]);
                continue;
            }
        };
        let shift = Value::Position(origin.place);
        let shift = robot.add_quantity(format!("{name}.position"), Unit::Metre, shift);
        let turn = Value::Orientation(origin.rotation());
        let turn = robot.add_quantity(format!("{name}.orientation"), Unit::Radian, turn);
        let mut elements = vec![Element::Shift(shift), Element::Turn(turn)];
        if let Some(kind) = kind {
            let span = if kind == DofKind::Slide { UNLIMITED_SLIDE } else { std::f64::consts::PI };
            let range = joint.limits.unwrap_or([-span, span]);
            let axis = axis.normalize();
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
    for (name, element) in &tree.links {
        let link = robot.link(name).unwrap_or_default();
        add_mass(&mut robot, link, source, element)?;
        add_surfaces(&mut robot, link, source, element)?;
        let is_mesh = |c: &Tag| c.child("geometry").and_then(|geometry| geometry.child("mesh")).is_some();
        if element.all("collision").any(is_mesh) {
            meshed.push(*name);
        }
    }
    if !meshed.is_empty() {
        let links = meshed.join(", ");
        passed_over.push(format!(
            "the meshes of {links} are passed over: only spheres, cylinders, capsules and boxes are surfaces here"
        ));
    }
    Ok((robot, passed_over))
}

fn frame(origin: &Origin) -> Frame {
    Frame { rotation: origin.rotation(), origin: origin.place }
}

/// What a link weighs, where it weighs anything.
fn add_mass(robot: &mut Robot, link: usize, source: &Source, element: &Tag) -> Result<(), Refused> {
    let Some(inertial) = element.child("inertial") else { return Ok(()) };
    let Some(mass) = inertial.child("mass") else { return Ok(()) };
    let kilograms = mass.number("value").unwrap_or(0.0);
    if kilograms < 0.0 {
        let message = format!("the mass of link {} is negative; give kilograms", robot.links[link].name);
        return Err(source.refused(mass, message));
    }
    if kilograms > 0.0 {
        robot.masses.push(LinkMass { link, mass: kilograms, centre: Origin::of(inertial).place });
    }
    Ok(())
}

/// A link's collision geometry as surfaces: called LINK where there is one, else LINK.1, LINK.2 and so on.
fn add_surfaces(robot: &mut Robot, link: usize, source: &Source, element: &Tag) -> Result<(), Refused> {
    let of = robot.links[link].name.clone();
    for (name, collision, shape) in shapes(&of, element) {
        let pose = frame(&Origin::of(collision));
        let needs = |attribute: &str| {
            let message =
                format!("<{}> of link {of} needs {attribute}=\"…\" above 0; give metres", shape.name);
            source.refused(shape, message)
        };
        let length = |attribute: &str| {
            shape.number(attribute).filter(|length| *length > 0.0).ok_or_else(|| needs(attribute))
        };
        let form = match shape.name.as_str() {
            "sphere" => {
                robot.add_sphere(&name, link, pose, length("radius")?);
                continue;
            }
            "cylinder" => Shape::Cylinder { radius: length("radius")?, half_length: 0.5 * length("length")? },
            "capsule" => Shape::Capsule { radius: length("radius")?, half_length: 0.5 * length("length")? },
            _ => {
                let size = shape.vector("size").filter(|size| size.min() > 0.0);
                Shape::Box { half_extents: (0.5 * size.ok_or_else(|| needs("size"))?).into() }
            }
        };
        robot.add_surface(&name, link, pose, Form::Solid(form));
    }
    Ok(())
}

/// The shapes of a link's collision geometry that are no meshes: a surface's name, the `<collision>` and the shape.
pub(super) fn shapes<'a>(link: &str, element: &'a Tag) -> Vec<(String, &'a Tag, &'a Tag)> {
    let known = |shape: &&Tag| ["sphere", "cylinder", "capsule", "box"].contains(&shape.name.as_str());
    let found: Vec<(&Tag, &Tag)> = element
        .children
        .iter()
        .filter(|child| child.name == "collision")
        .filter_map(|collision| Some((collision, collision.child("geometry")?.children.iter().find(known)?)))
        .collect();
    let alone = found.len() == 1;
    let called = |i: usize| if alone { link.to_string() } else { format!("{link}.{}", i + 1) };
    found.into_iter().enumerate().map(|(i, (collision, shape))| (called(i), collision, shape)).collect()
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

    pub fn read(text: &str) -> Result<(Robot, Vec<String>), String> {
        let read = read_urdf(Path::new("arm.urdf"), text.as_bytes());
        read.map_err(|refused| format!("line {}: {}", refused.line.unwrap_or_default(), refused.message))
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
        let (robot, passed_over) = read(ARM).unwrap();
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
            (read("<mujoco/>").unwrap_err(), "line 1: it is no URDF, but <mujoco>; "),
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
                "joint elbow is floating, which an encoder does not read; ",
            ),
            (
                with("parent link=\"hand\"", "parent link=\"palm\""),
                "joint finger names the link palm, which is not there",
            ),
            (with("parent link=\"base\"", "parent link=\"hand\""), "link upper is carried by itself; "),
            (with("joint=\"finger\"", "joint=\"thumb\""), "joint thumb mimics itself"),
            (with("name=\"elbow\"", "name=\"wrist\""), "line 21: there are two joints wrist; "),
            (with("0.6 0 0.8", "0 0 0"), "the axis of joint finger has no direction"),
            (with("'0.05'", "'0'"), "line 4: <sphere> of link base needs radius=\"…\" above 0; "),
        ];
        for (message, expected) in cases {
            assert!(message.contains(expected) && message.contains([':', ';']), "{message} != {expected}");
        }
    }
}
