//! A drawn body as MJCF.

use nalgebra::{UnitQuaternion, Vector3};

use super::draw::{Draw, rounded};
use super::joints::{Freedom, Moves};
use super::limb::Shape;
use super::tree::{Limb, Tree};
use crate::model_files::{Element, element, exact, write};

/// Share of bodies that are fixed to the world; the others are carried by a free joint.
const FIXED: f64 = 0.4;
/// Share of bodies that have touch sensors of their own, …
const FEELING: f64 = 0.2;
/// … so many a limb.
const SENSORS: [usize; 2] = [4, 12];

/// The text of a model called `name`, headed by a line of what it is.
pub fn text(tree: &mut Tree, name: &str, about: &str) -> String {
    let mut root = element("mujoco", &[("model", name.into())]);
    let compiler = element("compiler", &[("angle", "degree".into()), ("autolimits", "true".into())]);
    push(&mut root, Element { comments: vec![format!(" {about} ")], ..compiler });
    let mut defaults = element("default", &[]);
    push(&mut defaults, element("geom", &[("density", "500".into()), ("rgba", "0.55 0.5 0.45 1".into())]));
    push(&mut root, defaults);
    let (fixed, feeling) = (tree.draw.chance(FIXED), tree.draw.chance(FEELING));
    let sites: Vec<Vec<Element>> =
        (0..tree.limbs.len()).map(|limb| if feeling { sites(tree, limb) } else { Vec::new() }).collect();
    let mut world = element("worldbody", &[]);
    push(&mut world, body(&tree.limbs, &sites, 0, fixed));
    push(&mut root, world);
    push(&mut root, couplings(&tree.limbs));
    let mut sensors = element("sensor", &[]);
    for site in sites.iter().flatten() {
        let name = site.get("name").map(str::to_string).unwrap_or_default();
        push(&mut sensors, element("touch", &[("name", format!("{name}_touch")), ("site", name)]));
    }
    push(&mut root, sensors);
    // A section of nothing is none.
    root.children.retain(|child| !child.children.is_empty() || child.name == "compiler");
    write(&root)
}

/// The name of a limb's degree of freedom.
pub fn freedom_name(limb: &Limb, number: usize) -> String {
    if limb.freedoms.len() == 1 {
        limb.name.clone()
    } else {
        format!("{}_{}", limb.name, ["a", "b", "c"][number])
    }
}

fn push(parent: &mut Element, child: Element) {
    parent.children.push(child);
}

fn body(limbs: &[Limb], sites: &[Vec<Element>], number: usize, fixed: bool) -> Element {
    let limb = &limbs[number];
    let mut body = element("body", &[("name", limb.name.clone())]);
    if limb.parent.is_some() {
        body.set("pos", vector(&limb.pose.translation.vector));
        body.set("quat", turn(&limb.pose.rotation));
    } else if !fixed {
        push(&mut body, element("freejoint", &[("name", "free".into())]));
    }
    for (k, freedom) in limb.freedoms.iter().enumerate() {
        push(&mut body, joint(&freedom_name(limb, k), freedom));
    }
    limb.shapes.iter().for_each(|shape| push(&mut body, geom(shape)));
    sites[number].iter().for_each(|site| push(&mut body, site.clone()));
    for child in (0..limbs.len()).filter(|&child| limbs[child].parent == Some(number)) {
        push(&mut body, self::body(limbs, sites, child, fixed));
    }
    body
}

fn joint(name: &str, freedom: &Freedom) -> Element {
    let kind = match freedom.moves {
        Moves::Hinge => "hinge",
        Moves::Slide => "slide",
        Moves::Ball => "ball",
    };
    let mut joint = element("joint", &[("name", name.into()), ("type", kind.into())]);
    if freedom.anchor != Vector3::zeros() {
        joint.set("pos", vector(&freedom.anchor));
    }
    if freedom.moves != Moves::Ball {
        joint.set("axis", vector(&freedom.axis));
    }
    joint.set("range", numbers(&freedom.range));
    joint
}

fn geom(shape: &Shape) -> Element {
    element(
        "geom",
        &[
            ("type", shape.kind.name().into()),
            ("size", numbers(&shape.size)),
            ("pos", vector(&shape.centre)),
            ("quat", turn(&shape.turned)),
        ],
    )
}

/// Touch sensors' sites on a limb: each stands for the skin next to it.
fn sites(tree: &mut Tree, limb: usize) -> Vec<Element> {
    let shapes = tree.limbs[limb].shapes.clone();
    let count = tree.draw.count(SENSORS[0], SENSORS[1]);
    let name = tree.limbs[limb].name.clone();
    let site = |k: usize, draw: &mut Draw| {
        let shape = &shapes[draw.count(0, shapes.len() - 1)];
        let longest = shape.size.iter().copied().fold(0.0, f64::max);
        let thinnest = shape.size.iter().copied().fold(f64::INFINITY, f64::min);
        let along = shape.turned * Vector3::z() * (longest * draw.between(-0.9, 0.9));
        let at = shape.centre + along + draw.direction() * thinnest;
        element(
            "site",
            &[
                ("name", format!("{name}_{}", k + 1)),
                ("pos", vector(&at)),
                ("size", numbers(&[0.4 * thinnest])),
            ],
        )
    };
    (0..count).map(|k| site(k, &mut tree.draw)).collect()
}

/// What follows what.
fn couplings(limbs: &[Limb]) -> Element {
    let mut equality = element("equality", &[]);
    for limb in limbs {
        let Some(before) = limb.parent.map(|parent| &limbs[parent]) else { continue };
        for (k, freedom) in limb.freedoms.iter().enumerate() {
            let Some(times) = freedom.follows.filter(|_| !before.freedoms.is_empty()) else { continue };
            let leader = freedom_name(before, before.freedoms.len() - 1);
            let names = [("joint1", freedom_name(limb, k)), ("joint2", leader)];
            let mut joint = element("joint", &names);
            joint.set("polycoef", numbers(&[0.0, times, 0.0, 0.0, 0.0]));
            push(&mut equality, joint);
        }
    }
    equality
}

fn vector(v: &Vector3<f64>) -> String {
    numbers(v.as_slice())
}

fn turn(turn: &UnitQuaternion<f64>) -> String {
    numbers(&[turn.w, turn.i, turn.j, turn.k])
}

fn numbers(values: &[f64]) -> String {
    let rounded: Vec<f64> = values.iter().map(|&value| rounded(value)).collect();
    exact(&rounded)
}
