//! Checks on what a model's file says in numbers and words, before, or in place of, the engine.
//!
//! The engine checks what it reads itself, but a file that it does not take as it is, is put in plain terms first: what is
//! wrong in it must not be read as if it were not there. And of 5,000 mutated files MuJoCo 2.2.2 crashed on some sizes and never
//! returned from others: numbers of that order are refused.

use std::path::PathBuf;

use super::pose::{Angles, ORIENTATIONS};
use super::source::{Refused, Source, whole_folder_of, with_slashes};
use super::tree::{Element, is_of};

/// Least and greatest length, coordinate or scale accepted, in metres: a thousand kilometres.
const LENGTHS: [f64; 2] = [-1e6, 1e6];

/// Time steps accepted, seconds: a second of shorter ones takes longer than a minute, and in longer ones nothing that moves can be
/// followed.
const TIME_STEPS: [f64; 2] = [1e-6, 1.0];

/// Numbers of iterations accepted of any of the engine's solvers, each step; its own is 100 at the most.
const ITERATIONS: [f64; 2] = [0.0, 1e4];

/// Elements of a model at the most, by kind: what the engine's compiler does with more takes longer than it is given.
const GREATEST_NUMBERS: [(&str, usize); 5] =
    [("body", 10_000), ("link", 10_000), ("joint", 10_000), ("geom", 50_000), ("site", 50_000)];

/// All numbers that are finite.
const FINITE: [f64; 2] = [f64::MIN, f64::MAX];

/// Counts: the engine takes one below zero for its own choice.
const fn up_to(greatest: f64) -> [f64; 2] {
    [-greatest, greatest]
}

/// Elements of a tree with places in it.
const PLACED: &str = "body frame replicate geom site inertial";

/// What holds numbers: elements, `*` for any, their attributes, how many numbers, 0 for any, and the least and greatest accepted: of
/// lengths, coordinates and scales, of counts of what the engine makes, and of all else, for the engine takes what is not finite,
/// and physics comes to nothing with it. The first that fits counts.
const NUMBERS: [(&str, &str, usize, [f64; 2]); 30] = [
    (PLACED, "pos zaxis euler", 3, LENGTHS),
    (PLACED, "quat axisangle", 4, LENGTHS),
    (PLACED, "xyaxes", 6, LENGTHS),
    ("replicate", "offset", 3, LENGTHS),
    ("geom site", "fromto", 6, LENGTHS),
    ("joint", "pos axis", 3, LENGTHS),
    ("joint", "range", 2, FINITE),
    ("joint", "ref springref", 1, FINITE),
    ("mesh", "refquat", 4, FINITE),
    // The scale of a mesh is of URDF as well; what follows is of URDF alone, where a limit that is infinite is none.
    ("mesh", "refpos scale", 3, LENGTHS),
    ("limit", "lower upper", 1, [f64::NEG_INFINITY, f64::INFINITY]),
    ("origin", "xyz rpy", 3, LENGTHS),
    ("axis", "xyz", 3, LENGTHS),
    ("box", "size", 3, LENGTHS),
    ("sphere cylinder capsule", "radius length", 1, LENGTHS),
    ("mass inertia mimic", "value ixx ixy ixz iyy iyz izz multiplier offset", 1, FINITE),
    ("texture", "width height", 0, up_to(16384.0)),
    ("texture", "gridsize", 0, up_to(4096.0)),
    ("hfield", "nrow ncol", 0, up_to(8192.0)),
    ("composite flexcomp replicate", "count", 0, up_to(10_000.0)),
    ("size", "njmax nconmax", 0, up_to(100_000.0)),
    ("size", "nstack", 0, up_to(1e8)),
    ("size", "nuserdata nkey", 0, up_to(1e6)),
    (
        "size",
        "nuser_body nuser_jnt nuser_geom nuser_site nuser_cam nuser_tendon nuser_actuator nuser_sensor",
        0,
        up_to(1e6),
    ),
    ("quality global", "shadowsize offwidth offheight", 0, up_to(65536.0)),
    ("quality", "offsamples", 0, up_to(1024.0)),
    ("option", "timestep", 0, TIME_STEPS),
    (
        "option",
        "iterations noslip_iterations mpr_iterations ls_iterations ccd_iterations sdf_iterations sdf_initpoints",
        0,
        ITERATIONS,
    ),
    (
        "*",
        "size pos fromto scale refpos vertex spacing margin gap axis quat euler axisangle xyaxes zaxis center offset xyz rpy \
         radius length maxhullvert",
        0,
        LENGTHS,
    ),
    (
        "*",
        "anchor armature boundinertia boundmass cutoff damping density diaginertia friction frictionloss fullinertia gravity ixx \
         ixy ixz iyy iyz izz mass noise polycoef prm rgba settotalmass stiffness viscosity wind",
        0,
        FINITE,
    ),
];

/// What has one of these words: elements, their attribute, the words.
const WORDS: [(&str, &str, &str); 5] = [
    ("compiler", "angle", "degree radian"),
    ("compiler", "autolimits strippath", "true false"),
    ("joint", "limited", "true false auto"),
    ("joint", "type", "free ball slide hinge"),
    ("geom", "type", "plane hfield sphere capsule ellipsoid cylinder box mesh sdf"),
];

/// Checks what a model's file and what it includes say.
///
/// # Errors
/// Where a number or word is none or out of bounds, a direction is zero, there is too much of anything, or a file is none.
pub(crate) fn check(source: &Source) -> Result<(), Refused> {
    check_numbers(source, &source.root)?;
    within(source, &source.root, Part::Other)?;
    check_files(source)
}

/// Checks that no file of a mesh, a height field or a texture is a pipe or a device: the engine opens them itself, and would
/// wait for ever.
fn check_files(source: &Source) -> Result<(), Refused> {
    let folder = whole_folder_of(&source.path);
    let set = ["meshdir", "texturedir", "assetdir"].map(|name| source.root.setting("compiler", name));
    let folders: Vec<_> =
        set.into_iter().flatten().chain([""]).map(|own| folder.join(with_slashes(own))).collect();
    let endless = |name: &str| {
        let about = |folder: &PathBuf| std::fs::metadata(folder.join(with_slashes(name)));
        { folders.iter() }.any(|folder| about(folder).is_ok_and(|file| !file.is_file() && !file.is_dir()))
    };
    for element in source.root.descendants() {
        let files =
            element.attributes.iter().filter(|(name, file)| name.starts_with("file") && !file.is_empty());
        if let Some((_, file)) = { files }.find(|(_, file)| endless(file)) {
            let title = element.title();
            let message =
                format!("{title} is in {file}, which is a pipe or a device; give it a regular file");
            return Err(source.refused(element, message));
        }
    }
    Ok(())
}

/// Checks how many elements a tree has.
///
/// # Errors
/// Where the engine would not come to an end with them.
pub(crate) fn check_numbers(source: &Source, root: &Element) -> Result<(), Refused> {
    let count = |name: &str| root.descendants().filter(|element| element.name == name).count();
    let numbers = GREATEST_NUMBERS.iter().map(|(name, greatest)| (name, *greatest, count(name)));
    match { numbers }.find(|(_, greatest, number)| number > greatest) {
        None => Ok(()),
        Some((name, greatest, number)) => Err(source.refused(
            root,
            format!("it has {number} elements <{name}>, more than the {greatest} that MuJoCo can handle; remove some"),
        )),
    }
}

/// What part of a model an element is in: joints of URDF and of couplings are others than those of bodies.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    Urdf,
    Bodies,
    Other,
}

fn within(source: &Source, element: &Element, part: Part) -> Result<(), Refused> {
    let wrong = element.attributes.iter().find_map(|(name, value)| fault(element, name, value, part));
    let wrong = wrong.or_else(|| undirected(element).filter(|_| part == Part::Bodies));
    if let Some(message) = wrong {
        return Err(source.refused(element, message));
    }
    // What turns for ever has no limits, whatever it says of them.
    let unlimited = element.get("type") == Some("continuous");
    let children = element.children.iter().filter(|child| !(unlimited && child.name == "limit"));
    { children }.try_for_each(|child| {
        let part = match (element.name.as_str(), child.name.as_str()) {
            ("robot", _) => Part::Urdf,
            ("mujoco", "worldbody" | "default" | "asset" | "compiler") => Part::Bodies,
            _ => part,
        };
        within(source, child, part)
    })
}

/// The number that `token` begins with, as C reads it.
fn number(token: &str) -> Option<f64> {
    let ends = token.char_indices().map(|(at, mark)| at + mark.len_utf8());
    ends.rev().take(64).find_map(|end| token[..end].parse().ok())
}

/// What is wrong with an attribute, and the fix.
fn fault(element: &Element, name: &str, value: &str, part: Part) -> Option<String> {
    // Newer engines take an empty attribute for none.
    if value.trim().is_empty() {
        return None;
    }
    let title = element.title();
    if part == Part::Bodies {
        let choice = WORDS.iter().find(|(of, word, _)| *of == element.name && is_of(word, name));
        if let Some((_, _, words)) = choice.filter(|(_, _, words)| !is_of(words, value)) {
            let words = words
                .rsplit_once(' ')
                .map_or(String::new(), |(others, last)| format!("{} or {last}", others.replace(' ', ", ")));
            return Some(format!("{name}=\"{value}\" of {title} is not an MJCF keyword; give {words}"));
        }
        let axes = value.len() == 3 && value.chars().all(|axis| "xyzXYZ".contains(axis));
        if name == "eulerseq" && !axes {
            return Some(format!(
                "eulerseq=\"{value}\" is not an order of axes; give three of x, y, z, X, Y and Z"
            ));
        }
    }
    let of = |elements: &str| elements == "*" || is_of(elements, &element.name);
    let &(_, _, count, [least, greatest]) =
        NUMBERS.iter().find(|(elements, attributes, ..)| of(elements) && is_of(attributes, name))?;
    // Elsewhere the same words may mean something else, and the engine reads what begins with a number.
    let count = if part == Part::Other { 0 } else { count };
    let strict = count > 0 || part == Part::Bodies;
    let tokens: Vec<&str> = value.split_whitespace().collect();
    for token in &tokens {
        let fault = match (number(token), token.parse::<f64>()) {
            (Some(x), _) if !x.is_finite() && (x.is_nan() || greatest.is_finite()) => {
                "is not a finite number; give one"
            }
            (Some(x), _) if !(least..=greatest).contains(&x) => {
                let (bound, mend) = if x > greatest { (greatest, "smaller") } else { (least, "greater") };
                return Some(format!(
                    "{name}=\"{token}\" of {title} is beyond {bound}, the limit that MuJoCo handles safely; give \
                     a {mend} number"
                ));
            }
            (_, Err(_)) if strict && token.contains("${") => {
                "is not a number; expand it with `xacro FILE > robot.urdf`"
            }
            (_, Err(_)) if strict => "is not a number; use decimal points, and spaces between numbers",
            _ => continue,
        };
        return Some(format!("\"{token}\" in {name} of {title} {fault}"));
    }
    let numbers = if tokens.len() == 1 { "number" } else { "numbers" };
    (count > 0 && count != tokens.len())
        .then(|| format!("{name} of {title} has {} {numbers}; give it {count}", tokens.len()))
}

/// What is wrong with the orientation that an element of the tree gives.
fn undirected(element: &Element) -> Option<String> {
    if !is_of(PLACED, &element.name) {
        return None;
    }
    let mut given = ORIENTATIONS
        .into_iter()
        .filter(|name| element.get(name).is_some_and(|value| !value.trim().is_empty()));
    let title = element.title();
    let first = given.next()?;
    if let Some(second) = given.next() {
        return Some(format!("{title} is rotated by both {first} and {second}; remove one of them"));
    }
    Angles::new(None, None)
        .orientation(element)
        .is_none()
        .then(|| format!("{first} of {title} gives no direction; correct its numbers"))
}
