//! A robot's file written back: only the numbers that calibration changed, every other byte as it was.

use std::ops::Range;

use super::tags::text_begins;
use crate::calibration::robot::{Robot, RobotDof, Value};
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
