//! What writing a robot's file has in common, whatever the format.

use crate::calibration::robot::{Element, Robot, RobotDof, Value};
use crate::creature::DofKind;

/// A robot's file with what calibration found.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    /// The file.
    pub bytes: Vec<u8>,
    /// What the file's format has no place for, a sentence each.
    pub left_out: Vec<String>,
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
