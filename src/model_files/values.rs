//! Checks on what a model's file says in numbers and words that are read here before, or in place of, the engine.
//!
//! The engine checks what it reads itself, but a file that it does not take as it is, is put in plain terms first: what is
//! wrong in it must not be read as if it were not there.

use super::pose::ORIENTATIONS;
use super::source::{Refused, Source};
use super::tree::Element;

/// Elements of a tree with places in it.
const PLACED: [&str; 6] = ["body", "frame", "replicate", "geom", "site", "inertial"];

/// What holds so many numbers: elements, their attribute, the count.
const COUNTED: [(&[&str], &str, usize); 33] = [
    (&PLACED, "pos", 3),
    (&PLACED, "quat", 4),
    (&PLACED, "axisangle", 4),
    (&PLACED, "xyaxes", 6),
    (&PLACED, "zaxis", 3),
    (&PLACED, "euler", 3),
    (&["replicate"], "offset", 3),
    (&["geom", "site"], "fromto", 6),
    (&["joint"], "pos", 3),
    (&["joint"], "axis", 3),
    (&["joint"], "range", 2),
    (&["joint"], "ref", 1),
    (&["joint"], "springref", 1),
    (&["mesh"], "refpos", 3),
    (&["mesh"], "refquat", 4),
    // Of URDF; the scale of a mesh is of both.
    (&["mesh"], "scale", 3),
    (&["mass"], "value", 1),
    (&["inertia"], "ixx", 1),
    (&["inertia"], "ixy", 1),
    (&["inertia"], "ixz", 1),
    (&["inertia"], "iyy", 1),
    (&["inertia"], "iyz", 1),
    (&["inertia"], "izz", 1),
    (&["origin"], "xyz", 3),
    (&["origin"], "rpy", 3),
    (&["axis"], "xyz", 3),
    (&["box"], "size", 3),
    (&["sphere", "cylinder", "capsule"], "radius", 1),
    (&["cylinder", "capsule"], "length", 1),
    (&["mimic"], "multiplier", 1),
    (&["mimic"], "offset", 1),
    (&["limit"], "lower", 1),
    (&["limit"], "upper", 1),
];

/// What else holds numbers, however many: the engine takes what is not finite, and physics comes to nothing with it.
const PHYSICAL: [&str; 30] = [
    "anchor",
    "armature",
    "boundinertia",
    "boundmass",
    "cutoff",
    "damping",
    "density",
    "diaginertia",
    "friction",
    "frictionloss",
    "fullinertia",
    "gravity",
    "ixx",
    "ixy",
    "ixz",
    "iyy",
    "iyz",
    "izz",
    "mass",
    "noise",
    "polycoef",
    "prm",
    "rgba",
    "settotalmass",
    "size",
    "stiffness",
    "timestep",
    "vertex",
    "viscosity",
    "wind",
];

/// What has one of these words: elements, their attribute, the words.
const WORDS: [(&[&str], &str, &[&str]); 6] = [
    (&["compiler"], "angle", &["degree", "radian"]),
    (&["compiler"], "autolimits", &["true", "false"]),
    (&["compiler"], "strippath", &["true", "false"]),
    (&["joint"], "limited", &["true", "false", "auto"]),
    (&["joint"], "type", &["free", "ball", "slide", "hinge"]),
    (
        &["geom"],
        "type",
        &["plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "sdf"],
    ),
];

/// Checks what a model's file and what it includes say of bodies.
///
/// # Errors
/// Where a number or word is none, or a direction is zero.
pub(crate) fn check(source: &Source) -> Result<(), Refused> {
    for section in source.root.children.iter() {
        let part = match section.name.as_str() {
            _ if source.root.name == "robot" => Part::Urdf,
            "worldbody" | "default" | "asset" | "compiler" => Part::Bodies,
            _ => Part::Other,
        };
        within(source, section, part)?;
    }
    Ok(())
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
    let children = element.children.iter();
    // What turns for ever has no limits, whatever it says of them.
    let unlimited = element.get("type") == Some("continuous");
    { children }
        .filter(|child| !(unlimited && child.name == "limit"))
        .try_for_each(|child| within(source, child, part))
}

/// What is wrong with an attribute, and the mend.
fn fault(element: &Element, name: &str, value: &str, part: Part) -> Option<String> {
    // Newer engines take an empty attribute for none.
    if value.trim().is_empty() {
        return None;
    }
    let of = |names: &&[&str]| names.contains(&element.name.as_str());
    let title = element.title();
    if part == Part::Bodies {
        let choice = WORDS.iter().find(|(names, word, _)| of(names) && *word == name);
        if let Some((_, _, words)) = choice.filter(|(_, _, words)| !words.contains(&value)) {
            let words = one_of(words);
            return Some(format!("{name}=\"{value}\" of {title} is no word of MJCF; give {words}"));
        }
        let axes = value.len() == 3 && value.chars().all(|axis| "xyzXYZ".contains(axis));
        if name == "eulerseq" && !axes {
            return Some(format!(
                "eulerseq=\"{value}\" is no order of axes; give three of x, y, z, X, Y and Z"
            ));
        }
    }
    let counted = COUNTED.iter().find(|(names, word, _)| of(names) && *word == name);
    let counted = counted.filter(|_| part != Part::Other);
    let physical = PHYSICAL.contains(&name);
    if counted.is_none() && !physical {
        return None;
    }
    let strict = counted.is_some() || part == Part::Bodies;
    let tokens: Vec<&str> = value.split_whitespace().collect();
    for token in &tokens {
        let mend = match token.parse::<f64>() {
            Ok(number) if number.is_finite() => continue,
            // A limit that is infinite is none.
            Ok(number) if !number.is_nan() && element.name == "limit" => continue,
            Ok(_) => return Some(format!("\"{token}\" in {name} of {title} is no finite number; give one")),
            Err(_) if !strict => continue,
            Err(_) if token.contains("${") => "write it out with `xacro FILE > robot.urdf`",
            Err(_) => "give one, with a point for decimals and spaces between numbers",
        };
        return Some(format!("\"{token}\" in {name} of {title} is no number; {mend}"));
    }
    let (_, _, count) = counted.filter(|(_, _, count)| *count != tokens.len())?;
    let numbers = if tokens.len() == 1 { "number" } else { "numbers" };
    Some(format!("{name} of {title} has {} {numbers}; give it {count}", tokens.len()))
}

/// What is wrong with the orientation that an element of the tree gives.
fn undirected(element: &Element) -> Option<String> {
    if !PLACED.contains(&element.name.as_str()) {
        return None;
    }
    let mut given = ORIENTATIONS
        .into_iter()
        .filter(|name| element.get(name).is_some_and(|value| !value.trim().is_empty()));
    let title = element.title();
    let first = given.next()?;
    if let Some(second) = given.next() {
        return Some(format!("{title} is turned by {first} and by {second}; remove one of them"));
    }
    super::pose::Angles::new(None, None)
        .orientation(element)
        .is_none()
        .then(|| format!("{first} of {title} gives no direction; give it numbers that make one"))
}

/// Words as a choice.
fn one_of(words: &[&str]) -> String {
    match words {
        [all @ .., last] if !all.is_empty() => format!("{} or {last}", all.join(", ")),
        _ => words.concat(),
    }
}
