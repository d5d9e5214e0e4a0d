//! A drawn body as MJCF.

use nalgebra::{Isometry3, Vector3};

use super::draw::rounded;
use super::joints::Freedom;
use super::limb::LimbPart;
use super::tree::{Limb, Tree};
use crate::creature::DofKind;
use crate::model_files::{Element, element, write};

/// Share of bodies that are fixed to the world; the others are carried by a free joint.
const FIXED: f64 = 0.4;
/// Share of bodies that have touch sensors of their own, …
const FEELING: f64 = 0.2;
/// … so many a limb.
const SENSORS: [usize; 2] = [4, 12];

/// The text of a model called `name`, headed by a line of what it is.
pub fn text(tree: &mut Tree, name: &str, about: &str) -> String {
    let (fixed, feeling) = (tree.draw.chance(FIXED), tree.draw.chance(FEELING));
    let sites: Vec<Vec<Element>> =
        (0..tree.limbs.len()).map(|limb| if feeling { sites(tree, limb) } else { Vec::new() }).collect();
    let sensors = sites
        .iter()
        .flatten()
        .filter_map(|site| site.get("name"))
        .map(|name| element("touch", &[("name", format!("{name}_touch")), ("site", name.into())]));
    let geom = element("geom", &[("density", "500".into()), ("rgba", "0.55 0.5 0.45 1".into())]);
    let mut compiler = element("compiler", &[("angle", "degree".into()), ("autolimits", "true".into())]);
    compiler.comments = vec![format!(" {about} ")];
    let sections = [
        Element::holding("default", vec![geom]),
        Element::holding("worldbody", vec![body(&tree.limbs, &sites, 0, fixed)]),
        Element::holding("equality", couplings(&tree.limbs)),
        Element::holding("sensor", sensors.collect()),
    ];
    let sections = sections.into_iter().filter(|section| !section.children.is_empty());
    let mut root = element("mujoco", &[("model", name.into())]);
    root.children = std::iter::once(compiler).chain(sections).collect();
    write(&root)
}

fn body(limbs: &[Limb], sites: &[Vec<Element>], number: usize, fixed: bool) -> Element {
    let limb = &limbs[number];
    let mut body = element("body", &[("name", limb.name.clone())]);
    match limb.parent {
        Some(_) => place(&mut body, &limb.pose),
        None if fixed => {}
        None => body.children.push(element("freejoint", &[("name", "free".into())])),
    }
    let joints = limb.freedoms.iter().enumerate().map(|(k, freedom)| joint(freedom_name(limb, k), freedom));
    let children = (0..limbs.len()).filter(|&child| limbs[child].parent == Some(number));
    body.children.extend(joints);
    body.children.extend(limb.shapes.iter().map(geom));
    body.children.extend_from_slice(&sites[number]);
    body.children.extend(children.map(|child| self::body(limbs, sites, child, fixed)));
    body
}

/// The name of a limb's degree of freedom.
fn freedom_name(limb: &Limb, number: usize) -> String {
    match limb.freedoms.len() {
        1 => limb.name.clone(),
        _ => format!("{}_{}", limb.name, ["a", "b", "c"][number]),
    }
}

fn joint(name: String, freedom: &Freedom) -> Element {
    let kind = match freedom.kind {
        DofKind::Hinge => "hinge",
        DofKind::Slide => "slide",
        DofKind::Ball => "ball",
    };
    let mut joint = element("joint", &[("name", name), ("type", kind.into())]);
    if freedom.anchor != Vector3::zeros() {
        joint.set("pos", numbers(freedom.anchor.as_slice()));
    }
    if freedom.kind != DofKind::Ball {
        joint.set("axis", numbers(freedom.axis.as_slice()));
    }
    joint.set("range", numbers(&freedom.range));
    joint
}

fn geom(part: &LimbPart) -> Element {
    let (kind, size) = part.shape.mjcf().unwrap_or_default();
    let mut geom = element("geom", &[("type", kind.into()), ("size", numbers(&size))]);
    place(&mut geom, &part.pose);
    geom
}

/// Gives an element its pose.
fn place(element: &mut Element, pose: &Isometry3<f64>) {
    let turn = pose.rotation;
    element.set("pos", numbers(pose.translation.vector.as_slice()));
    element.set("quat", numbers(&[turn.w, turn.i, turn.j, turn.k]));
}

/// Touch sensors' sites on a limb: each stands for the skin next to it.
fn sites(tree: &mut Tree, limb: usize) -> Vec<Element> {
    let limb = &tree.limbs[limb];
    let count = tree.draw.count(SENSORS[0], SENSORS[1]);
    let site = |k: usize| {
        let part = &limb.shapes[tree.draw.count(0, limb.shapes.len() - 1)];
        let (_, size) = part.shape.mjcf().unwrap_or_default();
        let longest = size.iter().copied().fold(0.0, f64::max);
        let thinnest = size.iter().copied().fold(f64::INFINITY, f64::min);
        let along = part.pose.rotation * Vector3::z() * (longest * tree.draw.between(-0.9, 0.9));
        let at = part.pose.translation.vector + along + tree.draw.direction() * thinnest;
        let (name, pos) = (format!("{}_{k}", limb.name), numbers(at.as_slice()));
        element("site", &[("name", name), ("pos", pos), ("size", numbers(&[0.4 * thinnest]))])
    };
    (1..=count).map(site).collect()
}

/// What follows what.
fn couplings(limbs: &[Limb]) -> Vec<Element> {
    let mut couplings = Vec::new();
    for limb in limbs {
        let Some(before) = limb.parent.map(|parent| &limbs[parent]) else { continue };
        for (k, freedom) in limb.freedoms.iter().enumerate() {
            let Some(times) = freedom.follows.filter(|_| !before.freedoms.is_empty()) else { continue };
            let (name, leader) = (freedom_name(limb, k), freedom_name(before, before.freedoms.len() - 1));
            let polynomial = numbers(&[0.0, times, 0.0, 0.0, 0.0]);
            couplings
                .push(element("joint", &[("joint1", name), ("joint2", leader), ("polycoef", polynomial)]));
        }
    }
    couplings
}

fn numbers(values: &[f64]) -> String {
    // Adding zero turns -0 into 0.
    values.iter().map(|&value| (rounded(value) + 0.0).to_string()).collect::<Vec<_>>().join(" ")
}
