//! A learned body as a MuJoCo model of its own.
//!
//! It is made of what the agent knows and nothing else: joints where the schema has them, ranges and limbs
//! as they were given, surfaces and receptors as the skin feels them. Masses, springs and looks of the
//! original are not known, so the model is for kinematics and collision; gravity is off.

use std::f64::consts::PI;
use std::path::Path;

use nalgebra::{Matrix3, Vector3};

use super::{ExportedFile, add, limb_pose};
use crate::agent::Agent;
use crate::creature::{Creature, Dof, DofKind, LIMB_TUPLE};
use crate::geometry::Frame;
use crate::model_files::{Element, HALF_THICKNESS, add_receptor_class, element, exact, write};
use crate::schema::BodySchema;
use crate::skin::{Receptor, Surface};

/// Least mass and inertia of a body: a limb without geoms would weigh nothing, which MuJoCo refuses.
const LEAST_MASS: f64 = 1e-3;
const LEAST_INERTIA: f64 = 1e-6;
/// A receptor's site is at most this share of its smaller side thick, to be known for a flat patch.
const THINNESS: f64 = 0.25;
/// Half the sides of the site of a receptor without extent, metres.
const MARK: f64 = 2e-3;
/// MuJoCo wants a limited joint to have some play, radians or metres.
const LEAST_PLAY: f64 = 1e-9;

/// A standalone MJCF model of the body as it was learned.
///
/// The root limb is fixed in the world; every other limb is a body of its name at `l_P`, oriented as its
/// parent, or at its own frame where limbs have such. What follows another joint does so. `schema` must fit the creature. Read back with all joints, the model's ground truth is the
/// schema, and its skin is the skin; a surface known only by its receptors becomes a thin box for each.
pub fn to_mjcf(agent: &Agent, schema: &BodySchema) -> String {
    let creature = agent.creature();
    let names = limb_names(creature);
    let mut root = element("mujoco", &[("model", creature.name().into())]);
    add_receptor_class(&mut root, "receptor");
    let compiler = [
        ("angle", "radian".into()),
        ("boundmass", LEAST_MASS.to_string()),
        ("boundinertia", LEAST_INERTIA.to_string()),
    ];
    let note = " Learned from self-touch. Masses are placeholders, gravity is off. ";
    let head = [
        Element { comments: vec![note.into()], ..element("compiler", &compiler) },
        element("option", &[("gravity", "0 0 0".into())]),
    ];
    root.children.splice(0..0, head);
    for (s, surface) in agent.skin().surfaces.iter().enumerate() {
        if let Some(hull) = surface.shape.hull() {
            let mesh = [("name", hull_name(s)), ("vertex", exact(hull.vertices().iter().flatten()))];
            add(root.section("asset"), element("mesh", &mesh));
        }
    }
    add(root.section("worldbody"), body(agent, schema, &names, 0));
    for [a, b] in excluded(agent) {
        let pair = [("body1", names[a].clone()), ("body2", names[b].clone())];
        add(root.section("contact"), element("exclude", &pair));
    }
    let dofs: Vec<&Dof> = creature.dofs().collect();
    for (dof, coupling) in dofs.iter().filter_map(|dof| Some((dof, dof.follows?))) {
        let coupled = [
            ("joint1", dof.name.clone()),
            ("joint2", dofs[coupling.leader].name.clone()),
            ("polycoef", exact(&coupling.polynomial)),
        ];
        add(root.section("equality"), element("joint", &coupled));
    }
    for dof in creature.dofs() {
        // A ball's angles are a quaternion, which has a sensor of its own.
        let kind = if dof.kind == DofKind::Ball { "ballquat" } else { "jointpos" };
        let sensor = [("name", format!("{}_pos", dof.name)), ("joint", dof.name.clone())];
        add(root.section("sensor"), element(kind, &sensor));
    }
    for receptor in &agent.skin().receptors {
        let sensor = [("name", format!("{}_touch", receptor.id)), ("site", receptor.id.clone())];
        add(root.section("sensor"), element("touch", &sensor));
    }
    for aura in creature.aura_limbs().iter().filter(|aura| !aura.limbs.is_empty()) {
        let mut tuple = element("tuple", &[("name", format!("{LIMB_TUPLE}{}", aura.name))]);
        for &limb in &aura.limbs {
            let member = [("objtype", "body".into()), ("objname", names[limb].clone())];
            add(&mut tuple, element("element", &member));
        }
        add(root.section("custom"), tuple);
    }
    write(&root)
}

/// The file of a body.
pub(super) fn files(agent: &Agent, schema: &BodySchema, path: &Path) -> Vec<ExportedFile> {
    vec![(path.to_path_buf(), to_mjcf(agent, schema).into_bytes())]
}

/// The bodies' names: those of the limbs, but no body may be called as the world is.
fn limb_names(creature: &Creature) -> Vec<String> {
    let mut names = creature.limbs().to_vec();
    if names[0] == "world" {
        let taken = |name: &String| creature.limbs().contains(name);
        names[0] = "root".into();
        while taken(&names[0]) {
            names[0].push('_');
        }
    }
    names
}

/// One limb and all that it carries: its joints, geoms and receptors, then the limbs on it.
fn body(agent: &Agent, schema: &BodySchema, names: &[String], limb: usize) -> Element {
    let skin = agent.skin();
    let creature = agent.creature();
    let mut body = element("body", &[("name", names[limb].clone())]);
    if let Some(j) = creature.joint_of(limb) {
        // A limb's own frame is the body's: at (Q, c) on the joint, which is seen from there.
        let pose = limb_pose(creature, schema, limb);
        body.set("pos", exact(&(schema.positions[j] + pose.origin)));
        let joint = &creature.joints()[j];
        for (k, dof) in joint.dof_indices().zip(&joint.dofs) {
            let mut element = joint_element(dof, &pose.rotation.tr_mul(&schema.axes[k]));
            if pose != Frame::identity() {
                element.set("pos", exact(&pose.inverse().origin));
            }
            add(&mut body, element);
        }
        if pose != Frame::identity() {
            body.set("quat", exact(&pose.wxyz()));
        }
    }
    for (s, surface) in skin.surfaces.iter().enumerate().filter(|(_, surface)| surface.limb == limb) {
        let of_surface = skin.receptors.iter().filter(|r| r.limb == limb && r.surface == Some(s));
        match geom(s, surface) {
            Some(geom) => add(&mut body, geom),
            None => of_surface.for_each(|receptor| {
                let (pose, size) = tile_box(receptor);
                add(&mut body, placed(element("geom", &[("type", "box".into())]), &size, &pose));
            }),
        }
    }
    for receptor in skin.receptors.iter().filter(|receptor| receptor.limb == limb) {
        let (pose, size) = receptor_box(receptor);
        let site = element("site", &[("class", "receptor".into()), ("name", receptor.id.clone())]);
        add(&mut body, placed(site, &size, &pose));
    }
    for child in (limb + 1..names.len()).filter(|&child| creature.parent_of(child) == Some(limb)) {
        add(&mut body, self::body(agent, schema, names, child));
    }
    body
}

/// A degree of freedom about or along its learned axis, through the limb's origin.
fn joint_element(dof: &Dof, axis: &Vector3<f64>) -> Element {
    let [low, high] = dof.range;
    let (kind, limited, low) = match dof.kind {
        DofKind::Hinge => ("hinge", [low, high] != [-PI, PI], low),
        DofKind::Slide => ("slide", true, low),
        DofKind::Ball => ("ball", high < PI, 0.0),
    };
    let mut joint = element("joint", &[("name", dof.name.clone()), ("type", kind.into())]);
    let mut set = |name: &str, value: String| joint.set(name, value);
    if dof.kind != DofKind::Ball {
        let axis = if axis.norm() > 1e-12 { *axis } else { Vector3::z() };
        set("axis", exact(&axis));
    }
    set("limited", limited.to_string());
    if limited {
        set("range", exact(&[low, high.max(low + LEAST_PLAY)]));
    }
    joint
}

/// A surface as a geom; none for one that only its receptors tell of.
fn geom(s: usize, surface: &Surface) -> Option<Element> {
    let (kind, size) = surface.shape.mjcf()?;
    let mut geom = placed(element("geom", &[("type", kind.into())]), &size, &surface.pose());
    if kind == "mesh" {
        geom.remove("size");
        geom.set("mesh", hull_name(s));
    }
    Some(geom)
}

/// The name of a surface's hull among the meshes.
fn hull_name(s: usize) -> String {
    format!("hull_{s}")
}

/// A thin box at a receptor: its pose and half sides. A receptor without extent, as limbs have that no skin is known of, is marked
/// by a small one.
fn receptor_box(receptor: &Receptor) -> (Frame, [f64; 3]) {
    let [u, v] = if receptor.half_extents == [0.0; 2] { [MARK; 2] } else { receptor.half_extents };
    let rotation = Matrix3::from_columns(&[receptor.tangent, receptor.bitangent(), receptor.normal]);
    (Frame { rotation, origin: receptor.position }, [u, v, HALF_THICKNESS.min(THINNESS * u.min(v))])
}

/// The same below the receptor, its outer face where the skin is.
pub(super) fn tile_box(receptor: &Receptor) -> (Frame, [f64; 3]) {
    let (pose, size) = receptor_box(receptor);
    (Frame { origin: pose.origin - receptor.normal * size[2], ..pose }, size)
}

/// A geom or site put at a pose in its limb's frame.
fn placed(mut element: Element, size: &[f64], pose: &Frame) -> Element {
    element.set("pos", exact(&pose.origin));
    element.set("quat", exact(&pose.wxyz()));
    element.set("size", exact(size));
    element
}

/// Neighbouring limbs that must not collide though MuJoCo would let them.
///
/// It leaves out a body and its parent by itself, unless the parent is fixed in the world or limbs without
/// a surface, such as those between joints in series, come between the two.
fn excluded(agent: &Agent) -> Vec<[usize; 2]> {
    let (creature, skin) = (agent.creature(), agent.skin());
    let solid = |limb: usize| skin.surfaces.iter().any(|surface| surface.limb == limb);
    let mut pairs = Vec::new();
    for limb in (1..creature.limbs().len()).filter(|&limb| solid(limb)) {
        let mut above = creature.parent_of(limb);
        while let Some(bare) = above.filter(|&parent| !solid(parent)) {
            above = creature.parent_of(bare);
        }
        if let Some(parent) = above
            && (parent == 0 || creature.parent_of(limb) != Some(parent))
        {
            pairs.push([parent, limb]);
        }
    }
    pairs
}
