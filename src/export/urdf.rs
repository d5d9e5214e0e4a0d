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

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::mjcf::tile_box;
use super::{ExportedFile, add, limb_pose};
use crate::agent::Agent;
use crate::creature::{Creature, Dof, DofKind};
use crate::geometry::{Frame, UrdfGeometry};
use crate::model_files::{Element, element, exact, write};
use crate::schema::BodySchema;
use crate::skin::{Receptor, Skin, Surface};

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
/// Times that the octahedron's faces are divided into four to make the sphere of the mesh.
const DIVISIONS: usize = 4;

/// A robot description and the mesh that it refers to.
#[derive(Clone, Debug, PartialEq)]
pub struct Urdf {
    /// The description.
    pub xml: String,
    /// A sphere of radius 1 as binary STL, for the file that `mesh_name` names beside the description; none where
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
    let mut robot = element("robot", &[("name", creature.name().into())]);
    let note = " As learned from self-touch: masses, efforts and velocities are stand-ins. ";
    // MuJoCo's own settings, which other readers pass over: keep the root link, and paths as they are.
    let mut settings = Element { comments: vec![note.into()], ..Element::new("mujoco") };
    add(
        &mut settings,
        element("compiler", &[("fusestatic", "false".into()), ("discardvisual", "true".into())]),
    );
    add(&mut robot, settings);
    let mut links: HashSet<String> = creature.limbs().iter().cloned().collect();
    for (limb, name) in creature.limbs().iter().enumerate() {
        if let Some(joint) = creature.joint_of(limb) {
            add_joint(&mut robot, creature, schema, joint, &mut links);
        }
        let mut link = element("link", &[("name", name.clone())]);
        // A root with an inertia is more than some readers take.
        if limb > 0 {
            add(&mut link, inertial(MASS, INERTIA));
        }
        let pose = limb_pose(creature, schema, limb);
        for piece in pieces(agent.skin(), limb, mesh_name) {
            let (at, rotation) = (pose.point(&piece.origin), pose.rotation * piece.rotation);
            for role in ["visual", "collision"] {
                let mut shown = element(role, &[]);
                add(&mut shown, origin(&at, &rotation));
                let mut geometry = element("geometry", &[]);
                add(&mut geometry, piece.geometry.clone());
                add(&mut shown, geometry);
                add(&mut link, shown);
            }
        }
        add(&mut robot, link);
    }
    let scaled = |surface: &Surface| {
        surface.shape.urdf().is_some_and(|parts| parts.iter().any(|part| part.element == "mesh"))
    };
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
            let mut link = element("link", &[("name", child.clone())]);
            add(&mut link, inertial(MASS_BETWEEN, INERTIA_BETWEEN));
            add(robot, link);
        }
        // A link's frame is at its joint, whatever frame of its own the limb has.
        let pose = if i == 0 { limb_pose(creature, schema, described.parent) } else { Frame::identity() };
        let at = if i == 0 { schema.positions[joint] } else { Vector3::zeros() };
        let at = Frame { rotation: pose.rotation, origin: pose.point(&at) };
        let mut element = joint_element(dof, axis, &at, &parent, &child);
        if let Some(coupling) = dof.follows
            && let Some(leader) = creature.dofs().nth(coupling.leader)
        {
            // URDF has followers in proportion alone.
            let [offset, multiplier, ..] = coupling.polynomial.map(|number| exact(&[number]));
            let mimic = [("joint", leader.name.clone()), ("multiplier", multiplier), ("offset", offset)];
            add(&mut element, self::element("mimic", &mimic));
        }
        add(robot, element);
        parent = child;
    }
}

fn joint_element(dof: &Dof, axis: &Vector3<f64>, at: &Frame, parent: &str, child: &str) -> Element {
    let kind = match dof.kind {
        DofKind::Slide => "prismatic",
        _ if dof.range == [-PI, PI] => "continuous",
        _ => "revolute",
    };
    let mut joint = element("joint", &[("name", dof.name.clone()), ("type", kind.into())]);
    add(&mut joint, element("parent", &[("link", parent.into())]));
    add(&mut joint, element("child", &[("link", child.into())]));
    add(&mut joint, origin(&at.origin, &at.rotation));
    let axis = if axis.norm() > 1e-12 { *axis } else { Vector3::z() };
    add(&mut joint, element("axis", &[("xyz", exact(&axis))]));
    let [low, high] = dof.range;
    let mut limit = element("limit", &[("effort", EFFORT.into()), ("velocity", VELOCITY.into())]);
    if kind != "continuous" {
        limit.set("lower", exact(&[low]));
        limit.set("upper", exact(&[high]));
    }
    add(&mut joint, limit);
    joint
}

/// A name that no link has yet; it is one from now on.
fn free_name(mut name: String, links: &mut HashSet<String>) -> String {
    while !links.insert(name.clone()) {
        name.push('_');
    }
    name
}

fn inertial(mass: f64, inertia: f64) -> Element {
    let mut inertial = element("inertial", &[]);
    add(&mut inertial, element("mass", &[("value", mass.to_string())]));
    let i = inertia.to_string();
    let zero = || "0".to_string();
    let moments = [
        ("ixx", i.clone()),
        ("ixy", zero()),
        ("ixz", zero()),
        ("iyy", i.clone()),
        ("iyz", zero()),
        ("izz", i),
    ];
    add(&mut inertial, element("inertia", &moments));
    inertial
}

/// A piece of a limb.
struct LinkPiece {
    origin: Vector3<f64>,
    rotation: Matrix3<f64>,
    geometry: Element,
}

/// What a limb is made of, in shapes that URDF has.
fn pieces(skin: &Skin, limb: usize, mesh_name: &str) -> Vec<LinkPiece> {
    let mut pieces = Vec::new();
    for (s, surface) in skin.surfaces.iter().enumerate().filter(|(_, surface)| surface.limb == limb) {
        let Some(geometries) = surface.shape.urdf() else {
            let receptors = skin.receptors.iter().filter(|r| r.limb == limb && r.surface == Some(s));
            pieces.extend(receptors.map(tile));
            continue;
        };
        for UrdfGeometry { element: name, attributes, height } in geometries {
            let mut geometry = element(name, &[]);
            if name == "mesh" {
                geometry.set("filename", mesh_name);
            }
            for (attribute, values) in attributes {
                geometry.set(attribute, exact(&values));
            }
            let origin = surface.origin + surface.rotation * Vector3::new(0.0, 0.0, height);
            pieces.push(LinkPiece { origin, rotation: surface.rotation, geometry });
        }
    }
    pieces
}

/// A thin box below a receptor, its outer face where the skin is.
fn tile(receptor: &Receptor) -> LinkPiece {
    let (Frame { origin, rotation }, size) = tile_box(receptor);
    let geometry = element("box", &[("size", exact(&size.map(|half| 2.0 * half)))]);
    LinkPiece { origin, rotation, geometry }
}

/// A pose: rotations about the fixed axes x, y, z in this order.
fn origin(at: &Vector3<f64>, rotation: &Matrix3<f64>) -> Element {
    let (roll, pitch, yaw) = Rotation3::from_matrix_unchecked(*rotation).euler_angles();
    element("origin", &[("xyz", exact(at)), ("rpy", exact(&[roll, pitch, yaw]))])
}

/// A sphere of radius 1 as binary STL: an octahedron whose faces are divided and put on the sphere.
fn sphere_stl() -> Vec<u8> {
    let mut faces: Vec<[Vector3<f64>; 3]> = Vec::new();
    for (x, y, z) in [(1, 1, 1), (-1, 1, 1), (-1, -1, 1), (1, -1, 1)]
        .into_iter()
        .flat_map(|(x, y, z)| [(x, y, z), (x, y, -z)])
    {
        let [x, y, z] = [x, y, z].map(f64::from);
        let corners = [Vector3::x() * x, Vector3::y() * y, Vector3::z() * z];
        // Counter-clockwise from outside.
        faces.push(if x * y * z > 0.0 { corners } else { [corners[0], corners[2], corners[1]] });
    }
    for _ in 0..DIVISIONS {
        let divide = |[a, b, c]: [Vector3<f64>; 3]| {
            let [ab, bc, ca] = [(a + b).normalize(), (b + c).normalize(), (c + a).normalize()];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        faces = faces.into_iter().flat_map(divide).collect();
    }
    let mut stl = vec![b' '; 80];
    stl.extend((faces.len() as u32).to_le_bytes());
    for [a, b, c] in faces {
        let normal = (b - a).cross(&(c - a)).normalize();
        for vector in [normal, a, b, c] {
            vector.iter().for_each(|&x| stl.extend((x as f32).to_le_bytes()));
        }
        stl.extend([0; 2]);
    }
    stl
}
