//! A learned body as URDF, the robot description that ROS, Gazebo, PyBullet, Drake and MuJoCo read.
//!
//! URDF knows less than MJCF. A link is carried by one degree of freedom, so a joint of several becomes a chain of
//! links without geometry. It has no ball: three hinges about x, y and z in turn stand for one, with which every
//! orientation can be reached, if not from everywhere. It has no capsule and no ellipsoid: a cylinder between two
//! spheres is the one exactly, a mesh of a sphere, scaled, is nearly the other. And it cannot say which links may
//! overlap, so neighbouring limbs may be seen to collide.

use std::collections::HashSet;
use std::f64::consts::PI;
use std::path::Path;

use nalgebra::{Rotation3, Vector3};

use super::mjcf::tile_box;
use super::{ExportedFile, limb_pose};
use crate::agent::Agent;
use crate::creature::{Creature, Dof, DofKind};
use crate::geometry::{Frame, Shape, UrdfGeometry};
use crate::model_files::{Element, element, exact, write};
use crate::schema::BodySchema;
use crate::skin::{Skin, Surface};

/// Mass and inertia of every link, kilograms and kg m²: stand-ins, for simulators refuse links without.
const MASS: f64 = 0.1;
const INERTIA: f64 = 1e-3;
/// Of links between the degrees of freedom of one joint.
const MASS_BETWEEN: f64 = 1e-3;
const INERTIA_BETWEEN: f64 = 1e-6;
/// What joints may exert, newtons or newton metres, and how fast they may be, radians or metres a second: URDF
/// asks for limits, and nothing is known of them.
const EFFORT: &str = "1000";
const VELOCITY: &str = "10";
/// Stripes of the sphere of the mesh from pole to pole, and parts of each.
const STRIPES: usize = 32;

/// A robot description and the mesh that it refers to.
#[derive(Clone, Debug, PartialEq)]
pub struct Urdf {
    /// The description.
    pub xml: String,
    /// A sphere of radius 1 as binary STL, for the file that `mesh_name` names beside the description; `None` if
    /// no limb is an ellipsoid.
    pub mesh: Option<Vec<u8>>,
}

/// The body as it was learned as URDF; `mesh_name` is the file name that ellipsoids shall refer to.
///
/// The root limb is the root link; every other limb is a link of its name, with its origin at `l_P`. Links between
/// the degrees of freedom of one joint are called after the limb and the degree of freedom. A degree of freedom keeps
/// its name, a ball's three are it with `_x`, `_y` and `_z`: the ball's rotation is the product of theirs in this
/// order. Hinges that may turn all the way are `continuous`, others `revolute`, slides `prismatic`. A surface known
/// only by its receptors becomes a thin box for each. `schema` must fit the creature.
pub fn to_urdf(agent: &Agent, schema: &BodySchema, mesh_name: &str) -> Urdf {
    let creature = agent.creature();
    let note = " Learned from self-touch. Masses, efforts and velocities are placeholders. ";
    // MuJoCo's own settings, which other readers pass over: keep the root link, and paths as they are.
    let kept = element("compiler", &[("fusestatic", "false".into()), ("discardvisual", "true".into())]);
    let settings = Element { comments: vec![note.into()], ..Element::holding("mujoco", vec![kept]) };
    let mut robot = element("robot", &[("name", creature.name().into())]);
    robot.children.push(settings);
    let mut links: HashSet<String> = creature.limbs().iter().cloned().collect();
    for (limb, name) in creature.limbs().iter().enumerate() {
        if let Some(joint) = creature.joint_of(limb) {
            add_joint(&mut robot, creature, schema, joint, &mut links);
        }
        // A root with an inertia is more than some readers take.
        let mut link = named("link", name, (limb > 0).then(|| inertial(MASS, INERTIA)).into_iter().collect());
        let pose = limb_pose(creature, schema, limb);
        for (at, geometry) in pieces(agent.skin(), limb, mesh_name) {
            let geometry = Element::holding("geometry", vec![geometry]);
            let described = vec![origin(&(pose * at)), geometry];
            link.children
                .extend(["visual", "collision"].map(|role| Element::holding(role, described.clone())));
        }
        robot.children.push(link);
    }
    let scaled = |surface: &Surface| matches!(surface.shape, Shape::Ellipsoid { .. });
    let xml = write(&robot);
    Urdf { xml, mesh: agent.skin().surfaces.iter().any(scaled).then(sphere_stl) }
}

/// The files of a body: the mesh that the description refers to, where it does, and the description.
pub(super) fn files(agent: &Agent, schema: &BodySchema, path: &Path) -> Vec<ExportedFile> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let mesh_name = format!("{stem}_ellipsoid.stl");
    let Urdf { xml, mesh } = to_urdf(agent, schema, &mesh_name);
    let mesh = mesh.map(|mesh| (path.with_file_name(&mesh_name), mesh));
    mesh.into_iter().chain([(path.to_path_buf(), xml.into_bytes())]).collect()
}

/// A joint's degrees of freedom in a chain, with the links between them.
fn add_joint(
    robot: &mut Element,
    creature: &Creature,
    schema: &BodySchema,
    joint: usize,
    links: &mut HashSet<String>,
) {
    let described = &creature.joints()[joint];
    let mut hinges = Vec::new();
    for (k, dof) in described.dof_indices().zip(&described.dofs) {
        if dof.kind == DofKind::Ball {
            let turns = [("x", Vector3::x()), ("y", Vector3::y()), ("z", Vector3::z())];
            hinges.extend(turns.map(|(axis, direction)| {
                let name = format!("{}_{axis}", dof.name);
                (Dof { name, kind: DofKind::Hinge, range: [-PI, PI], follows: None }, direction)
            }));
        } else {
            hinges.push((dof.clone(), schema.axes[k]));
        }
    }
    let limb = &creature.limbs()[joint + 1];
    let mut parent = creature.limbs()[described.parent].clone();
    for (i, (dof, axis)) in hinges.iter().enumerate() {
        let last = i + 1 == hinges.len();
        let child = if last { limb.clone() } else { free_name(format!("{limb}_{}", dof.name), links) };
        if !last {
            robot.children.push(named("link", &child, vec![inertial(MASS_BETWEEN, INERTIA_BETWEEN)]));
        }
        // A link's frame is at its joint, whatever frame of its own the limb has.
        let at = match i {
            0 => {
                let pose = limb_pose(creature, schema, described.parent);
                Frame { origin: pose.point(&schema.positions[joint]), ..pose }
            }
            _ => Frame::identity(),
        };
        let mut element = joint_element(dof, axis, &at, &parent, &child);
        if let Some(coupling) = dof.follows
            && let Some(leader) = creature.dofs().nth(coupling.leader)
        {
            // URDF has followers in proportion alone.
            let [offset, multiplier, ..] = coupling.polynomial.map(|number| exact(&[number]));
            let mimic = [("joint", leader.name.clone()), ("multiplier", multiplier), ("offset", offset)];
            element.children.push(self::element("mimic", &mimic));
        }
        robot.children.push(element);
        parent = child;
    }
}

fn joint_element(dof: &Dof, axis: &Vector3<f64>, at: &Frame, parent: &str, child: &str) -> Element {
    let kind = match dof.kind {
        DofKind::Slide => "prismatic",
        _ if dof.range == [-PI, PI] => "continuous",
        _ => "revolute",
    };
    let axis = if axis.norm() > 1e-12 { *axis } else { Vector3::z() };
    let mut limit = element("limit", &[("effort", EFFORT.into()), ("velocity", VELOCITY.into())]);
    if kind != "continuous" {
        let [low, high] = dof.range;
        limit.set("lower", exact(&[low]));
        limit.set("upper", exact(&[high]));
    }
    let parts = vec![
        element("parent", &[("link", parent.into())]),
        element("child", &[("link", child.into())]),
        origin(at),
        element("axis", &[("xyz", exact(&axis))]),
        limit,
    ];
    let mut joint = named("joint", &dof.name, parts);
    joint.set("type", kind);
    joint
}

/// A name that no link has yet; it is one from now on.
fn free_name(mut name: String, links: &mut HashSet<String>) -> String {
    while !links.insert(name.clone()) {
        name.push('_');
    }
    name
}

/// An element with a name and others in it.
fn named(tag: &str, name: &str, children: Vec<Element>) -> Element {
    Element { children, ..element(tag, &[("name", name.into())]) }
}

fn inertial(mass: f64, inertia: f64) -> Element {
    let moment = |name| (name, if matches!(name, "ixx" | "iyy" | "izz") { inertia } else { 0.0 }.to_string());
    let moments = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"].map(moment);
    let mass = element("mass", &[("value", mass.to_string())]);
    Element::holding("inertial", vec![mass, element("inertia", &moments)])
}

/// What a limb is made of, in shapes that URDF has: poses in the limb's frame, and geometry.
fn pieces(skin: &Skin, limb: usize, mesh_name: &str) -> Vec<(Frame, Element)> {
    let mut pieces = Vec::new();
    for (s, surface) in skin.surfaces.iter().enumerate().filter(|(_, surface)| surface.limb == limb) {
        let Some(geometries) = surface.shape.urdf() else {
            let receptors = skin.receptors.iter().filter(|r| r.limb == limb && r.surface == Some(s));
            // A thin box below a receptor, its outer face where the skin is.
            pieces.extend(receptors.map(|receptor| {
                let (pose, size) = tile_box(receptor);
                (pose, element("box", &[("size", exact(&size.map(|half| 2.0 * half)))]))
            }));
            continue;
        };
        for UrdfGeometry { element: name, attributes, height } in geometries {
            let mut geometry = Element::new(name);
            if name == "mesh" {
                geometry.set("filename", mesh_name);
            }
            attributes.iter().for_each(|(attribute, values)| geometry.set(attribute, exact(values)));
            let raised = Frame { origin: Vector3::new(0.0, 0.0, height), ..Frame::identity() };
            pieces.push((surface.pose() * raised, geometry));
        }
    }
    pieces
}

/// A pose: rotations about the fixed axes x, y, z in this order.
fn origin(pose: &Frame) -> Element {
    let (roll, pitch, yaw) = Rotation3::from_matrix_unchecked(pose.rotation).euler_angles();
    element("origin", &[("xyz", exact(&pose.origin)), ("rpy", exact(&[roll, pitch, yaw]))])
}

/// A sphere of radius 1 as binary STL: stripes between the poles in quadrangles, each in two triangles, at the poles in one.
fn sphere_stl() -> Vec<u8> {
    let at = |stripe: usize, part: usize| {
        let [down, around] =
            [(stripe, STRIPES), (2 * part, STRIPES)].map(|(k, of)| PI * k as f64 / of as f64);
        let corner = Vector3::new(down.sin() * around.cos(), down.sin() * around.sin(), down.cos());
        // Rounded, corners of several triangles are the very same.
        corner.map(|x| (1e6 * x).round() / 1e6 + 0.0)
    };
    let mut triangles = Vec::new();
    for (stripe, part) in (0..STRIPES).flat_map(|stripe| (0..STRIPES).map(move |part| (stripe, part))) {
        let [a, b] = [part, part + 1].map(|part| at(stripe, part));
        let [c, d] = [part, part + 1].map(|part| at(stripe + 1, part));
        // Counter-clockwise from outside.
        triangles.extend((stripe + 1 < STRIPES).then_some([a, c, d]));
        triangles.extend((stripe > 0).then_some([a, d, b]));
    }
    let mut stl = vec![b' '; 80];
    stl.extend((triangles.len() as u32).to_le_bytes());
    for [a, b, c] in triangles {
        let normal = (b - a).cross(&(c - a)).normalize();
        stl.extend([normal, a, b, c].iter().flatten().flat_map(|&x| (x as f32).to_le_bytes()));
        stl.extend([0; 2]);
    }
    stl
}
