//! A drawn body as MJCF.

use nalgebra::{UnitQuaternion, Vector3};

use super::draw::rounded;
use super::joints::{Freedom, Moves};
use super::limb::Shape;
use super::tree::{Limb, Tree};

/// Share of bodies that are fixed to the world; the others are carried by a free joint.
const FIXED: f64 = 0.4;
/// Share of bodies that have touch sensors of their own, …
const FEELING: f64 = 0.2;
/// … so many a limb.
const SENSORS: [usize; 2] = [4, 12];

/// Text that grows line by line, indented by two spaces for every element that is open.
#[derive(Default)]
struct Lines {
    text: String,
    depth: usize,
}

impl Lines {
    fn add(&mut self, line: &str) {
        self.text.extend(std::iter::repeat_n("  ", self.depth).chain([line, "\n"]));
    }

    /// An element and what is in it, written by `inside`.
    fn within(&mut self, name: &str, attributes: &str, inside: impl FnOnce(&mut Lines)) {
        self.add(&format!("<{name}{attributes}>"));
        self.depth += 1;
        inside(self);
        self.depth -= 1;
        self.add(&format!("</{name}>"));
    }

    /// A section of some lines; a section of none is left out.
    fn section(&mut self, name: &str, lines: &[String]) {
        if !lines.is_empty() {
            self.within(name, "", |text| lines.iter().for_each(|line| text.add(line)));
        }
    }
}

/// The text of a model called `name`, headed by a line of what it is.
pub fn text(tree: &mut Tree, name: &str, about: &str) -> String {
    let (fixed, feeling) = (tree.draw.chance(FIXED), tree.draw.chance(FEELING));
    let count = tree.limbs.len();
    let sites: Vec<Vec<String>> =
        (0..count).map(|limb| if feeling { sites(tree, limb) } else { Vec::new() }).collect();
    let limbs = &tree.limbs;
    let names = (0..count).flat_map(|limb| (1..=sites[limb].len()).map(move |k| site_name(&limbs[limb], k)));
    let sensors = names.map(|name| format!("<touch name=\"{name}_touch\" site=\"{name}\"/>"));
    let mut lines = Lines::default();
    lines.within("mujoco", &format!(" model=\"{name}\""), |lines| {
        lines.add(&format!("<!-- {about} -->"));
        lines.add("<compiler angle=\"degree\" autolimits=\"true\"/>");
        lines.section("default", &["<geom density=\"500\" rgba=\"0.55 0.5 0.45 1\"/>".into()]);
        lines.within("worldbody", "", |lines| body(lines, limbs, &sites, 0, fixed));
        lines.section("equality", &couplings(limbs));
        lines.section("sensor", &sensors.collect::<Vec<_>>());
    });
    lines.text
}

fn body(lines: &mut Lines, limbs: &[Limb], sites: &[Vec<String>], number: usize, fixed: bool) {
    let limb = &limbs[number];
    let pose = limb.parent.map(|_| {
        let (pos, quat) = (vector(&limb.pose.translation.vector), turn(&limb.pose.rotation));
        format!(" pos=\"{pos}\" quat=\"{quat}\"")
    });
    let attributes = format!(" name=\"{}\"{}", limb.name, pose.unwrap_or_default());
    lines.within("body", &attributes, |lines| {
        if limb.parent.is_none() && !fixed {
            lines.add("<freejoint name=\"free\"/>");
        }
        for (k, freedom) in limb.freedoms.iter().enumerate() {
            lines.add(&joint(&freedom_name(limb, k), freedom));
        }
        limb.shapes.iter().for_each(|shape| lines.add(&geom(shape)));
        sites[number].iter().for_each(|site| lines.add(site));
        for child in (0..limbs.len()).filter(|&child| limbs[child].parent == Some(number)) {
            body(lines, limbs, sites, child, fixed);
        }
    });
}

/// The name of a limb's degree of freedom.
fn freedom_name(limb: &Limb, number: usize) -> String {
    match limb.freedoms.len() {
        1 => limb.name.clone(),
        _ => format!("{}_{}", limb.name, ["a", "b", "c"][number]),
    }
}

fn site_name(limb: &Limb, number: usize) -> String {
    format!("{}_{number}", limb.name)
}

fn joint(name: &str, freedom: &Freedom) -> String {
    let kind = match freedom.moves {
        Moves::Hinge => "hinge",
        Moves::Slide => "slide",
        Moves::Ball => "ball",
    };
    let mut text = format!("<joint name=\"{name}\" type=\"{kind}\"");
    if freedom.anchor != Vector3::zeros() {
        text += &format!(" pos=\"{}\"", vector(&freedom.anchor));
    }
    if freedom.moves != Moves::Ball {
        text += &format!(" axis=\"{}\"", vector(&freedom.axis));
    }
    text + &format!(" range=\"{}\"/>", numbers(&freedom.range))
}

fn geom(shape: &Shape) -> String {
    let Shape { kind, size, centre, turned } = shape;
    let (size, pos, quat) = (numbers(size), vector(centre), turn(turned));
    format!("<geom type=\"{}\" size=\"{size}\" pos=\"{pos}\" quat=\"{quat}\"/>", kind.name())
}

/// Touch sensors' sites on a limb: each stands for the skin next to it.
fn sites(tree: &mut Tree, limb: usize) -> Vec<String> {
    let limb = &tree.limbs[limb];
    let count = tree.draw.count(SENSORS[0], SENSORS[1]);
    let site = |k: usize| {
        let shape = &limb.shapes[tree.draw.count(0, limb.shapes.len() - 1)];
        let longest = shape.size.iter().copied().fold(0.0, f64::max);
        let thinnest = shape.size.iter().copied().fold(f64::INFINITY, f64::min);
        let along = shape.turned * Vector3::z() * (longest * tree.draw.between(-0.9, 0.9));
        let at = shape.centre + along + tree.draw.direction() * thinnest;
        let (name, pos, size) = (site_name(limb, k), vector(&at), numbers(&[0.4 * thinnest]));
        format!("<site name=\"{name}\" pos=\"{pos}\" size=\"{size}\"/>")
    };
    (1..=count).map(site).collect()
}

/// What follows what.
fn couplings(limbs: &[Limb]) -> Vec<String> {
    let mut lines = Vec::new();
    for limb in limbs {
        let Some(before) = limb.parent.map(|parent| &limbs[parent]) else { continue };
        for (k, freedom) in limb.freedoms.iter().enumerate() {
            let Some(times) = freedom.follows.filter(|_| !before.freedoms.is_empty()) else { continue };
            let (name, leader) = (freedom_name(limb, k), freedom_name(before, before.freedoms.len() - 1));
            let polynomial = numbers(&[0.0, times, 0.0, 0.0, 0.0]);
            lines.push(format!("<joint joint1=\"{name}\" joint2=\"{leader}\" polycoef=\"{polynomial}\"/>"));
        }
    }
    lines
}

fn vector(v: &Vector3<f64>) -> String {
    numbers(v.as_slice())
}

fn turn(turn: &UnitQuaternion<f64>) -> String {
    numbers(&[turn.w, turn.i, turn.j, turn.k])
}

fn numbers(values: &[f64]) -> String {
    // Adding zero turns -0 into 0.
    values.iter().map(|&value| (rounded(value) + 0.0).to_string()).collect::<Vec<_>>().join(" ")
}
