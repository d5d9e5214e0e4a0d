//! Checks on foreign model files before the engine sees them.
//!
//! Of 5,000 mutated files MuJoCo 2.2.2 crashed on some sizes and never returned from others: numbers of that order are
//! refused here, in the file and in what it includes.

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
    ("*", "nuser", 1e6),
    ("quality", "shadowsize", 65536.0),
    ("quality", "offsamples", 1024.0),
    ("global", "offwidth", 65536.0),
    ("global", "offheight", 65536.0),
    ("mesh", "maxhullvert", 1e6),
];

/// Checks all numbers of a model's file and of what it includes.
///
/// # Errors
/// Where one is out of bounds.
pub(crate) fn check(source: &Source) -> Result<(), Refused> {
    check_numbers(source, &source.root)?;
    within(source, &source.root)
}

/// Checks how many elements a tree has.
///
/// # Errors
/// Where the engine would not come to an end with them.
pub(crate) fn check_numbers(source: &Source, root: &Element) -> Result<(), Refused> {
    let mut numbers = [0; GREATEST_NUMBERS.len()];
    count(root, &mut numbers);
    let over = GREATEST_NUMBERS.iter().zip(numbers).find(|((_, greatest), number)| number > greatest);
    match over {
        None => Ok(()),
        Some(((name, greatest), number)) => Err(source.refused(
            root,
            format!("it has {number} elements <{name}>, more than the {greatest} that MuJoCo comes to an end with; remove some"),
        )),
    }
}

fn count(element: &Element, numbers: &mut [usize; GREATEST_NUMBERS.len()]) {
    if let Some(kind) = GREATEST_NUMBERS.iter().position(|(name, _)| *name == element.name) {
        numbers[kind] += 1;
    }
    element.children.iter().for_each(|child| count(child, numbers));
}

fn within(source: &Source, element: &Element) -> Result<(), Refused> {
    for (attribute, value) in &element.attributes {
        if let Some(message) = unsimulated(element, attribute, value) {
            return Err(source.refused(element, message));
        }
        let Some(greatest) = greatest(&element.name, attribute) else { continue };
        if let Some(token) = excess(value, greatest) {
            let title = element.title();
            let message = if number(token).is_some_and(f64::is_finite) {
                format!(
                    "{attribute}=\"{token}\" of {title} is beyond {greatest}, the greatest that MuJoCo takes safely; give \
                     a smaller number"
                )
            } else {
                format!("{attribute}=\"{token}\" of {title} is no finite number; give one")
            };
            return Err(source.refused(element, message));
        }
    }
    element.children.iter().try_for_each(|child| within(source, child))
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
        (*tag == element || *tag == "*") && (*name == attribute || counts_users(name, attribute))
    });
    match count {
        Some(&(_, _, greatest)) => Some(greatest),
        None => LENGTHS.contains(&attribute).then_some(GREATEST_LENGTH),
    }
}

/// Whether `attribute` is one of `nuser_body`, `nuser_geom`, …
fn counts_users(name: &str, attribute: &str) -> bool {
    name == "nuser" && attribute.starts_with("nuser_")
}

/// The first token of `value` that is a number beyond `greatest`.
fn excess(value: &str, greatest: f64) -> Option<&str> {
    let beyond = |number: f64| number.is_nan() || number.abs() > greatest;
    value.split_ascii_whitespace().find(|token| number(token).is_some_and(beyond))
}

/// The number that `token` begins with, as C reads it.
fn number(token: &str) -> Option<f64> {
    let ends = token.char_indices().map(|(at, mark)| at + mark.len_utf8());
    ends.rev().take(64).find_map(|end| token[..end].parse().ok())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn refusal(xml: &str) -> Option<Refused> {
        check(&Source::of_text(Path::new("hostile.xml"), xml).unwrap()).err()
    }

    #[test]
    fn ordinary_models_pass() {
        let xml = "<mujoco><!-- size=\"1e30\" --><asset><texture width='512' height=\"512\"/></asset>\n\
                   <geom size=\"1 2 3\" pos='-5 0 1e3' name=\"a>b\"/></mujoco>";
        assert_eq!(refusal(xml), None);
    }

    #[test]
    fn hostile_numbers_are_named_with_their_line() {
        let refused = refusal("<mujoco>\n<texture width=\"999999999\"/></mujoco>").unwrap();
        assert_eq!((refused.path.to_str(), refused.line), (Some("hostile.xml"), Some(2)));
        assert!(refused.message.contains("width"), "{}", refused.message);
        for value in ["1e30", "-1e30", "nan", "inf", "0 1e30", "1e30m", "&#49;e30"] {
            let refused = refusal(&format!("<geom size='{value}'/>")).unwrap();
            assert!(refused.message.contains("size"), "{}", refused.message);
        }
        assert!(refusal("<geom fromto = '0 0 0 0 0 1e30'/>").is_some());
        assert!(refusal("<size nuser_body='999999999'/>").is_some());
    }

    #[test]
    fn what_cannot_be_simulated_or_compiled_in_time_is_refused() {
        let option = |setting: &str| refusal(&format!("<mujoco><option {setting}/></mujoco>"));
        for setting in
            ["timestep='1e-300'", "timestep='0'", "timestep='-1'", "timestep='nan'", "timestep='1e300'"]
        {
            assert!(option(setting).unwrap().message.contains("timestep"), "{setting}");
        }
        for setting in ["iterations='2000000000'", "noslip_iterations='2000000000'", "mpr_iterations='-5'"] {
            assert!(option(setting).unwrap().message.contains("iterations"), "{setting}");
        }
        assert_eq!(option("timestep='0.002' iterations='100' noslip_iterations='0'"), None);
        let bodies = |number: usize| refusal(&format!("<mujoco>{}</mujoco>", "<body/>".repeat(number)));
        assert_eq!(bodies(10_000), None);
        assert!(bodies(100_000).unwrap().message.contains("100000 elements <body>"));
    }
}
