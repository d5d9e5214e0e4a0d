//! A robot from URDF: its links and joints as quantities, its masses, and what of its collision geometry is no mesh.
//!
//! The pose of a joint's child is `JOINT.position`, then `JOINT.orientation`, then what the degree of freedom JOINT does.

use std::path::Path;

use super::{follow, moved, surface_name};
use crate::calibration::robot::{Element, Form, LinkMass, Robot};
use crate::creature::{DofKind, UNLIMITED_SLIDE};
use crate::geometry::{Frame, Shape};
use crate::model_files::{
    Element as Tag, Following, Origin, Refused, Source, UrdfJoint, UrdfKind, UrdfTree, check_source,
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
            "it is not URDF, but <{}>; give a URDF file, whose first element is <robot>",
            source.root.name
        );
        return Err(source.refused(&source.root, message));
    }
    check_source(&source)?;
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
                        "joint {name} is {about}, which has no encoder; make it fixed, or a chain of hinges and slides"
                    );
                    return Err(source.refused(element, message));
                }
                passed_over.push(format!(
                    "joint {name} is {about} and at the root: link {child} is assumed fixed to link {parent}"
                ));
                robot.add_link(child, parent_link, vec![Element::Fixed(origin.frame())]);
                continue;
            }
        };
        let mut elements = robot.add_pose(name, origin.frame()).to_vec();
        if let Some(kind) = kind {
            let span = if kind == DofKind::Slide { UNLIMITED_SLIDE } else { std::f64::consts::PI };
            let range = joint.limits.unwrap_or([-span, span]);
            let axis = axis.normalize();
            match joint.follows {
                Some(Following { leader: Some(leader), gain, offset }) => {
                    let at = [robot.links.len(), elements.len()];
                    elements.push(Element::Fixed(Frame::identity()));
                    followers.push((leader, [gain, offset], at, (name, kind, range, axis)));
                }
                // It stands where its leader, which is fixed, holds it.
                Some(Following { offset, .. }) => {
                    elements.push(Element::Fixed(moved(kind == DofKind::Slide, &axis, offset)));
                }
                None => elements.push(Element::Dof(robot.add_dof(name, kind, range, axis))),
            }
        }
        robot.add_link(child, parent_link, elements);
    }
    for (leader, by, at, (name, kind, range, axis)) in followers {
        if let Some(leader) = robot.dof(leader) {
            let dof = robot.add_dof(name, kind, range, axis);
            follow(&mut robot, dof, leader, by, at);
        }
    }
    let mut meshed = Vec::new();
    for (name, element) in &tree.links {
        let link = robot.link(name).unwrap_or_default();
        add_mass(&mut robot, link, source, element)?;
        add_surfaces(&mut robot, link, tree, element)?;
        let is_mesh = |c: &Tag| c.child("geometry").and_then(|geometry| geometry.child("mesh")).is_some();
        if element.all("collision").any(is_mesh) {
            meshed.push(*name);
        }
    }
    if !meshed.is_empty() {
        let links = meshed.join(", ");
        passed_over.push(format!(
            "the meshes of {links} are ignored: only spheres, cylinders, capsules and boxes can be surfaces"
        ));
    }
    Ok((robot, passed_over))
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
fn add_surfaces(robot: &mut Robot, link: usize, tree: &UrdfTree, element: &Tag) -> Result<(), Refused> {
    let of = robot.links[link].name.clone();
    for (name, collision, shape) in shapes(&of, element) {
        let pose = Origin::of(collision).frame();
        match tree.shape(&of, shape)? {
            Some(Shape::Sphere { radius }) => robot.add_sphere(&name, link, pose, radius),
            Some(shape) => robot.add_surface(&name, link, pose, Form::Solid(shape)),
            None => continue,
        };
    }
    Ok(())
}

/// The shapes of a link's collision geometry that are no meshes: a surface's name, the `<collision>` and the shape.
pub(super) fn shapes<'a>(link: &str, element: &'a Tag) -> Vec<(String, &'a Tag, &'a Tag)> {
    let known = |shape: &&Tag| ["sphere", "cylinder", "capsule", "box"].contains(&shape.name.as_str());
    let found: Vec<(&Tag, &Tag)> = element
        .all("collision")
        .filter_map(|collision| Some((collision, collision.child("geometry")?.children.iter().find(known)?)))
        .collect();
    let count = found.len();
    let named = |(i, (collision, shape))| (surface_name(link, i, count), collision, shape);
    found.into_iter().enumerate().map(named).collect()
}
