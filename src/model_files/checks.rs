//! Checks on what a model's file says in numbers and words, before, or in place of, the engine.
//!
//! The engine checks what it reads itself, but a file that it does not take as it is, is put in plain terms first: what is
//! wrong in it must not be read as if it were not there. And of 5,000 mutated files MuJoCo 2.2.2 crashed on some sizes and never
//! returned from others: numbers of that order are refused.

use super::pose::{Angles, ORIENTATIONS};
use super::source::{Refused, Source};
use super::tree::Element;

/// Greatest length, coordinate or scale accepted, in metres: a thousand kilometres.
const GREATEST_LENGTH: f64 = 1e6;

/// Least and greatest time step accepted, seconds: a second of shorter ones takes longer than a minute, and in longer ones
/// nothing that moves can be followed.
const TIME_STEPS: [f64; 2] = [1e-6, 1.0];

/// Greatest number of iterations accepted of any of the engine's solvers, each step; its own is 100 at the most.
const GREATEST_ITERATIONS: f64 = 1e4;

/// Elements of a model at the most, by kind: what the engine's compiler does with more takes longer than it is given.
const GREATEST_NUMBERS: [(&str, usize); 5] =
    [("body", 10_000), ("link", 10_000), ("joint", 10_000), ("geom", 50_000), ("site", 50_000)];

/// Attributes that hold lengths, coordinates or scales, in any element.
const LENGTHS: [&str; 21] = [
    "size",
    "pos",
    "fromto",
    "scale",
    "refpos",
    "vertex",
    "spacing",
    "margin",
    "gap",
    "axis",
    "quat",
    "euler",
    "axisangle",
    "xyaxes",
    "zaxis",
    "center",
    "offset",
    "xyz",
    "rpy",
    "radius",
    "length",
];

/// Attributes that hold a count of things the engine makes, with the greatest count accepted; an
/// element of `*` stands for any.
const COUNTS: [(&str, &str, f64); 19] = [
    ("texture", "width", 16384.0),
    ("texture", "height", 16384.0),
    ("texture", "gridsize", 4096.0),
    ("hfield", "nrow", 8192.0),
    ("hfield", "ncol", 8192.0),
    ("composite", "count", 10_000.0),
    ("flexcomp", "count", 10_000.0),
    ("replicate", "count", 10_000.0),
    ("size", "njmax", 100_000.0),
    ("size", "nconmax", 100_000.0),
    ("size", "nstack", 1e8),
    ("size", "nuserdata", 1e6),
    ("size", "nkey", 1e6),
    ("*", "nuser_", 1e6),
    ("quality", "shadowsize", 65536.0),
    ("quality", "offsamples", 1024.0),
    ("global", "offwidth", 65536.0),
    ("global", "offheight", 65536.0),
    ("mesh", "maxhullvert", 1e6),
];

/// Elements of a tree with places in it.
const PLACED: [&str; 6] = ["body", "frame", "replicate", "geom", "site", "inertial"];

/// What holds so many numbers: elements, their attributes, the count.
const COUNTED: [(&[&str], &[&str], usize); 19] = [
    (&PLACED, &["pos", "zaxis", "euler"], 3),
    (&PLACED, &["quat", "axisangle"], 4),
    (&PLACED, &["xyaxes"], 6),
    (&["replicate"], &["offset"], 3),
    (&["geom", "site"], &["fromto"], 6),
    (&["joint"], &["pos", "axis"], 3),
    (&["joint"], &["range"], 2),
    (&["joint"], &["ref", "springref"], 1),
    // The scale of a mesh is of URDF as well; what follows is of URDF alone.
    (&["mesh"], &["refpos", "scale"], 3),
    (&["mesh"], &["refquat"], 4),
    (&["mass"], &["value"], 1),
    (&["inertia"], &["ixx", "ixy", "ixz", "iyy", "iyz", "izz"], 1),
    (&["origin"], &["xyz", "rpy"], 3),
    (&["axis"], &["xyz"], 3),
    (&["box"], &["size"], 3),
    (&["sphere", "cylinder", "capsule"], &["radius"], 1),
    (&["cylinder", "capsule"], &["length"], 1),
    (&["mimic"], &["multiplier", "offset"], 1),
    (&["limit"], &["lower", "upper"], 1),
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

/// Checks what a model's file and what it includes say.
///
/// # Errors
/// Where a number or word is none or out of bounds, a direction is zero, or there is too much of anything.
pub(crate) fn check(source: &Source) -> Result<(), Refused> {
    check_numbers(source, &source.root)?;
    within(source, &source.root, Part::Other)
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
            format!("it has {number} elements <{name}>, more than the {greatest} that MuJoCo comes to an end with; remove some"),
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
    let wrong = element.attributes.iter().find_map(|(name, value)| {
        let wrong = unsimulated(element, name, value).or_else(|| excessive(element, name, value));
        wrong.or_else(|| fault(element, name, value, part))
    });
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

/// What is wrong with a number with which the engine crashes or never returns.
fn excessive(element: &Element, attribute: &str, value: &str) -> Option<String> {
    let greatest = greatest(&element.name, attribute)?;
    let beyond = |number: f64| number.is_nan() || number.abs() > greatest;
    let token = value.split_ascii_whitespace().find(|token| number(token).is_some_and(beyond))?;
    let what = format!("{attribute}=\"{token}\" of {}", element.title());
    Some(match number(token).is_some_and(f64::is_finite) {
        true => format!(
            "{what} is beyond {greatest}, the greatest that MuJoCo takes safely; give a smaller number"
        ),
        false => format!("{what} is no finite number; give one"),
    })
}

/// What is wrong with a setting of the engine with which nothing can be simulated in a time that anybody would wait.
fn unsimulated(element: &Element, attribute: &str, value: &str) -> Option<String> {
    if element.name != "option" {
        return None;
    }
    let number = number(value.trim())?;
    let [least, greatest] = TIME_STEPS;
    if attribute == "timestep" && !(least..=greatest).contains(&number) {
        return Some(format!(
            "timestep=\"{value}\" is no step of time that can be simulated; give seconds from {least} to {greatest}, such as 0.002"
        ));
    }
    let iterations = attribute.ends_with("iterations") || attribute == "sdf_initpoints";
    (iterations && !(0.0..=GREATEST_ITERATIONS).contains(&number)).then(|| {
        format!(
            "{attribute}=\"{value}\" is no number of iterations that can be waited for; give a whole number from 0 to \
             {GREATEST_ITERATIONS}"
        )
    })
}

/// The greatest number that an attribute may hold, if it is one of those that matter.
fn greatest(element: &str, attribute: &str) -> Option<f64> {
    let count = COUNTS.iter().find(|(tag, name, _)| {
        // One of `nuser_body`, `nuser_geom` and so on.
        let users = *name == "nuser_" && attribute.starts_with(name);
        (*tag == element || *tag == "*") && (*name == attribute || users)
    });
    match count {
        Some(&(_, _, greatest)) => Some(greatest),
        None => LENGTHS.contains(&attribute).then_some(GREATEST_LENGTH),
    }
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
    let counted = COUNTED.iter().find(|(names, attributes, _)| of(names) && attributes.contains(&name));
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
    Angles::new(None, None)
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
