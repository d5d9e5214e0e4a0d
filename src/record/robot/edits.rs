//! A robot's file written back: only the numbers that calibration changed, every other byte as it was.

use std::ops::Range;

use super::tags::{Tag, text_begins};
use crate::calibration::robot::{Element, Robot, RobotDof, Value};
use crate::creature::DofKind;

/// A robot's file with what calibration found.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    /// The file.
    pub bytes: Vec<u8>,
    /// What the file's format cannot say, a sentence each.
    pub left_out: Vec<String>,
}

/// Changes of a file's bytes.
#[derive(Clone, Debug, Default)]
pub(super) struct Edits {
    all: Vec<(Range<usize>, String)>,
}

impl Edits {
    /// Puts a text in the place of another.
    pub fn replace(&mut self, at: Range<usize>, text: impl Into<String>) {
        self.all.push((at, text.into()));
    }

    /// Puts a text before a byte, after what was put there before it.
    pub fn insert(&mut self, at: usize, text: impl Into<String>) {
        self.replace(at..at, text);
    }

    /// Changes the numbers of an element's attributes; those that stay keep their text.
    pub fn set(&mut self, original: &[u8], tag: &Tag, changes: &[Change]) {
        for change in changes.iter().filter(|change| !change.is_none()) {
            let Some(attribute) = tag.attribute(change.attribute) else {
                self.insert(tag.after_attributes(), change.text());
                continue;
            };
            let words = words(original, &attribute.at);
            if words.len() != change.new.len() {
                // Its blanks are written in some other way.
                self.replace(attribute.at.clone(), change.numbers());
                continue;
            }
            for (i, at) in words.into_iter().enumerate().filter(|(i, _)| !change.keeps(*i)) {
                self.replace(at, digits(change.new[i]));
            }
        }
    }

    /// The file with all changes, which must not overlap.
    pub fn of(mut self, bytes: &[u8]) -> Vec<u8> {
        self.all.sort_by_key(|(at, _)| at.start);
        let mut written = Vec::with_capacity(bytes.len());
        let mut done = 0;
        for (at, text) in self.all {
            written.extend_from_slice(&bytes[done..at.start]);
            written.extend_from_slice(text.as_bytes());
            done = at.end;
        }
        written.extend_from_slice(&bytes[done..]);
        written
    }
}

/// Numbers of an attribute as they were and as they are to be.
pub(super) struct Change {
    /// The attribute.
    pub attribute: &'static str,
    /// Its numbers as they were.
    pub old: Vec<f64>,
    /// Its numbers as they are to be.
    pub new: Vec<f64>,
    /// What counts as no difference.
    pub negligible: f64,
}

impl Change {
    /// A change of which any difference counts.
    pub fn of(attribute: &'static str, old: impl Into<Vec<f64>>, new: impl Into<Vec<f64>>) -> Change {
        Change { attribute, old: old.into(), new: new.into(), negligible: 0.0 }
    }

    /// Whether nothing changes.
    fn is_none(&self) -> bool {
        self.old.len() == self.new.len() && (0..self.new.len()).all(|i| self.keeps(i))
    }

    fn keeps(&self, i: usize) -> bool {
        self.old.get(i).is_some_and(|old| (self.new[i] - old).abs() <= self.negligible)
    }

    /// The new numbers.
    pub fn numbers(&self) -> String {
        self.new.iter().copied().map(digits).collect::<Vec<_>>().join(" ")
    }

    /// The attribute with its new numbers.
    pub fn text(&self) -> String {
        format!(" {}=\"{}\"", self.attribute, self.numbers())
    }
}

/// An element of its own line with the new numbers of attributes.
pub(super) fn new_element(name: &str, changes: &[Change]) -> String {
    format!("\n<{name}{}/>", changes.iter().map(Change::text).collect::<String>())
}

/// The numbers in a text.
pub(super) fn number_list(text: &str) -> Vec<f64> {
    text.split_ascii_whitespace().filter_map(|word| word.parse().ok()).collect()
}

/// Where the words of a stretch of a file are.
fn words(bytes: &[u8], at: &Range<usize>) -> Vec<Range<usize>> {
    let mut words = Vec::new();
    let mut begin = None;
    for i in at.clone() {
        match (bytes[i].is_ascii_whitespace(), begin) {
            (false, None) => begin = Some(i),
            (true, Some(from)) => {
                words.push(from..i);
                begin = None;
            }
            _ => {}
        }
    }
    words.extend(begin.map(|from| from..at.end));
    words
}

/// The negative of a number as it is written.
pub(super) fn negative(text: &str) -> String {
    let text = text.trim();
    match (text.strip_prefix('-'), text.parse::<f64>()) {
        (Some(positive), _) => positive.to_string(),
        (None, Ok(0.0)) => text.to_string(),
        _ => format!("-{}", text.trim_start_matches('+')),
    }
}

/// The line break and the blanks before a place; a line break alone where something else stands there.
pub(super) fn indentation(bytes: &[u8], at: usize) -> String {
    let before = &bytes[..at];
    let line = before.iter().rposition(|&byte| byte == b'\n').map_or(0, |end| end + 1);
    let blanks = &before[line..];
    let lines = if before[..line].ends_with(b"\r\n") { "\r\n" } else { "\n" };
    match std::str::from_utf8(blanks) {
        Ok(blanks) if line > 0 && blanks.trim().is_empty() => format!("{lines}{blanks}"),
        _ => lines.to_string(),
    }
}

/// Whether a link's pose at rest was to be found.
pub(super) fn is_to_be_found(robot: &Robot, link: usize) -> bool {
    robot.links[link].elements.iter().any(|element| match element {
        Element::Shift(q) | Element::Turn(q) | Element::ShiftAlong(_, q) | Element::TurnAbout(_, q) => {
            robot.quantities[*q].is_open()
        }
        Element::Fixed(_) | Element::Dof(_) => false,
    })
}

/// A number to the last digit.
pub(super) fn digits(number: f64) -> String {
    // Adding zero turns -0 into 0.
    (number + 0.0).to_string()
}

/// The first letter or mark of a file.
pub(super) fn first_byte(bytes: &[u8]) -> Option<u8> {
    bytes[text_begins(bytes)..].iter().copied().find(|byte| !byte.is_ascii_whitespace())
}

/// An encoder's gain, for which `format` has no word.
pub(super) fn unsaid_gain(robot: &Robot, values: &[Value], dof: usize, format: &str) -> Option<String> {
    let RobotDof { name, quantities, .. } = &robot.dofs[dof];
    let gain = values[quantities.as_ref()?.gain].number();
    let sentence = format!(
        "gain of {name} ({gain:.6}) cannot be said in {format}: multiply what its encoder reads by it"
    );
    (gain != 1.0).then_some(sentence)
}

/// How far a joint gives way, for which `format` has no word.
pub(super) fn unsaid_compliance(robot: &Robot, values: &[Value], dof: usize, format: &str) -> Option<String> {
    let RobotDof { name, quantities, kind, .. } = &robot.dofs[dof];
    let compliance = values[quantities.as_ref()?.compliance].number();
    let (unit, load) = match kind {
        DofKind::Slide => ("m/N", "force"),
        DofKind::Hinge | DofKind::Ball => ("rad/(N m)", "torque"),
    };
    let sentence = format!(
        "compliance of {name} ({compliance:.3e} {unit}) cannot be said in {format}: add it times the {load} to what its \
         encoder reads"
    );
    (compliance != 0.0).then_some(sentence)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_leave_the_rest_alone() {
        let mut edits = Edits::default();
        edits.replace(8..9, "6");
        edits.insert(2, "b");
        edits.insert(2, "c");
        edits.replace(3..4, "");
        assert_eq!(edits.of(b"a x2 y z5"), b"a bcx y z6".to_vec());
    }
}
