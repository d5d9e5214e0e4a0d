//! A robot from a table of Denavit and Hartenberg's numbers, in CSV or JSON.
//!
//! A row is a joint and the link that it carries, called by the column `link`, or else JOINT_link; the root is `base`. A row
//! hangs on the row before it, or on the link or joint that `parent` names. With q for what the joint does, the link is at
//!
//! ```text
//! standard  Rz(theta + q) Tz(d) Tx(a) Rx(alpha) Ry(beta)
//! modified  Rx(alpha) Tx(a) Ry(beta) Rz(theta + q) Tz(d)     as Craig has it
//! ```
//!
//! and with d + q for a slide. `beta` is Hayati's, for joints whose axes are nearly parallel, between which d cannot be told;
//! it is 0 where there is no such column. The numbers are the quantities JOINT.theta, JOINT.d, JOINT.a, JOINT.alpha and
//! JOINT.beta. The offset of a hinge's encoder is the same as its theta, and that of a slide the same as its d: they are one
//! quantity, called by the table's name.

use std::path::Path;

use nalgebra::Vector3;

use super::dh_table::{Cell, Field, Row, Table, table};
use super::tags::Fault;
use crate::calibration::robot::{Element, Robot, Unit, Value};
use crate::creature::{DofKind, UNLIMITED_SLIDE};
use crate::mjcf_xml::GREATEST_TURN;
use crate::session::RecordError;
use crate::session::table::Measure;

/// The root's name.
pub(super) const BASE: &str = "base";
/// Greatest length that is taken for metres where no unit is said.
const GREATEST_LENGTH: f64 = 20.0;
/// The numbers of a row, and which way each moves: a turn or a shift, about or along which axis.
pub(super) const NUMBERS: [Field; 5] = [Field::Theta, Field::D, Field::A, Field::Alpha, Field::Beta];

/// Reads a robot from the bytes of a table of Denavit and Hartenberg's numbers, JSON where it begins with a brace and else
/// CSV; the file is called `path` in messages, and the robot is, where the table does not name it.
///
/// # Errors
/// Where it is no table of a tree of hinges, slides and fixed joints; [`RecordError`] names the line.
pub fn read_dh(path: &Path, bytes: &[u8]) -> Result<Robot, RecordError> {
    let read = table(bytes).and_then(|table| {
        let rows = rows(&table)?;
        let name = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or("robot");
        robot(table.name.as_deref().unwrap_or(name), &rows)
    });
    read.map_err(|(line, message)| RecordError::format(path, Some(line), message))
}

/// The order in which a joint's shifts and turns follow each other.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Convention {
    Standard,
    Modified,
}

impl Convention {
    fn of(text: &str) -> Result<Convention, String> {
        match text.to_lowercase().as_str() {
            "standard" => Ok(Convention::Standard),
            "modified" | "craig" => Ok(Convention::Modified),
            _ => Err(format!("the convention \"{text}\" is not known: give standard or modified")),
        }
    }
}

/// A joint of a table.
struct DhJoint<'a> {
    line: usize,
    name: &'a str,
    link: String,
    /// A link or a joint.
    parent: Option<&'a str>,
    /// None where it does not move.
    kind: Option<DofKind>,
    convention: Convention,
    /// In the order of [`NUMBERS`], metres and radians.
    numbers: [f64; 5],
    range: [f64; 2],
}

impl Row {
    /// The cell of a field.
    pub(super) fn cell(&self, field: Field) -> Option<&Cell> {
        self.cells.iter().find(|cell| cell.field == field)
    }

    /// What a cell says, where there is one and it is not empty.
    pub(super) fn text(&self, field: Field) -> Option<&str> {
        let text = self.cell(field)?.text.trim();
        Some(text).filter(|text| !text.is_empty() && *text != "null")
    }
}

impl Cell {
    /// A number of metres or radians, of what the cell has of its own unit.
    pub(super) fn si(&self, number: f64) -> f64 {
        self.unit.map_or(number, |unit| number / unit.per)
    }

    /// What the cell is to have of its own unit for a number of metres or radians: rounded where that is the same number.
    pub(super) fn own_unit(&self, number: f64) -> f64 {
        let whole = self.unit.map_or(number, |unit| number * unit.per);
        let round = format!("{whole:.14e}").parse().unwrap_or(whole);
        if self.si(round) == number { round } else { whole }
    }
}

/// A cell's number, metres or radians. Where its unit is not said, it is refused if it is greater than `greatest`.
pub(super) fn number(joint: &str, cell: &Cell, measure: Measure, greatest: f64) -> Result<f64, String> {
    let (name, text) = (cell.field.name(), cell.text.trim());
    let si = cell.si_number().ok_or_else(|| {
        let mend = match cell.field {
            Field::Theta | Field::D => "give what is added to the joint's own coordinate, 0 if nothing",
            _ => "give one",
        };
        format!("{name} of joint {joint} is \"{text}\", which is no finite number: {mend}")
    })?;
    if cell.unit.is_none() && si.abs() > greatest {
        let (unit, other, suffix) = match measure {
            Measure::Length => ("metres", "millimetres", "mm"),
            Measure::Angle => ("radians", "degrees", "deg"),
        };
        return Err(format!(
            "{name} of joint {joint} is {text} {unit}: call it {name}_{suffix} if it is in {other}, or mend it"
        ));
    }
    if measure == Measure::Angle && si.abs() > greatest {
        return Err(format!(
            "{name} of joint {joint} is {text}, more than a turn: take whole turns off, or mend it"
        ));
    }
    Ok(si)
}

/// The joints of a table.
fn rows(table: &Table) -> Result<Vec<DhJoint<'_>>, Fault> {
    let mut convention = match &table.convention {
        Some(text) => Convention::of(text).map_err(|message| (1, message))?,
        None => Convention::Standard,
    };
    let mut joints: Vec<DhJoint> = Vec::new();
    for row in &table.rows {
        let joint = joint(row, &mut convention).map_err(|message| (row.line, message))?;
        let twice =
            |what: &str, name: &str| Err((row.line, format!("there are two {what} {name}: rename one")));
        if joints.iter().any(|other| other.name == joint.name) {
            return twice("joints", joint.name);
        }
        if joint.link == BASE || joints.iter().any(|other| other.link == joint.link) {
            return twice("links", &joint.link);
        }
        joints.push(joint);
    }
    match joints.is_empty() {
        true => Err((1, "it has no joint: give one a row".into())),
        false => Ok(joints),
    }
}

/// The joint of a row; the convention stays until a row names another.
fn joint<'a>(row: &'a Row, convention: &mut Convention) -> Result<DhJoint<'a>, String> {
    for (i, cell) in row.cells.iter().enumerate() {
        // Of ranges there may be a column of angles and one of lengths.
        let same = |other: &&Cell| other.field == cell.field;
        let ranges = [Field::Least, Field::Greatest].contains(&cell.field);
        if !ranges && row.cells[..i].iter().find(same).is_some() {
            return Err(format!("{} is given twice: leave one of them out", cell.field.name()));
        }
    }
    let name = row.text(Field::Joint).ok_or("the joint has no name: give it one")?;
    let kind = match row.text(Field::Kind).map(str::to_lowercase).as_deref() {
        None | Some("hinge" | "revolute" | "r") => Some(DofKind::Hinge),
        Some("slide" | "prismatic" | "p") => Some(DofKind::Slide),
        Some("fixed") => None,
        Some(other) => {
            return Err(format!("joint {name} is of the kind \"{other}\": give hinge, slide or fixed"));
        }
    };
    if let Some(text) = row.text(Field::Convention) {
        *convention = Convention::of(text)?;
    }
    let mut numbers = [0.0; 5];
    for (field, into) in NUMBERS.into_iter().zip(&mut numbers) {
        let optional = [Field::Theta, Field::Beta].contains(&field);
        match row.cell(field) {
            Some(cell) if optional && cell.text.trim().is_empty() => {}
            Some(cell) => {
                let (measure, greatest) = match field {
                    Field::D | Field::A => (Measure::Length, GREATEST_LENGTH),
                    _ => (Measure::Angle, GREATEST_TURN),
                };
                *into = number(name, cell, measure, greatest)?;
            }
            None if optional => {}
            None => return Err(format!("joint {name} has no {}: give it, 0 if it is none", field.name())),
        }
    }
    let range = match kind {
        None => [0.0; 2],
        Some(kind) => range(row, name, kind)?,
    };
    let link = row.text(Field::Link).map_or_else(|| format!("{name}_link"), str::to_string);
    let parent = row.text(Field::Parent);
    Ok(DhJoint { line: row.line, name, link, parent, kind, convention: *convention, numbers, range })
}

/// Least and greatest coordinate of a joint that moves.
fn range(row: &Row, name: &str, kind: DofKind) -> Result<[f64; 2], String> {
    let (measure, span, greatest) = match kind {
        DofKind::Slide => (Measure::Length, UNLIMITED_SLIDE, GREATEST_LENGTH),
        // Some turn twice about, either way.
        DofKind::Hinge | DofKind::Ball => (Measure::Angle, std::f64::consts::PI, 2.0 * GREATEST_TURN),
    };
    let end = |field: Field| -> Result<Option<f64>, String> {
        let mut found = None;
        for cell in row.cells.iter().filter(|cell| cell.field == field && !cell.text.trim().is_empty()) {
            if cell.unit.is_some_and(|unit| unit.measure != measure) {
                let (moves, unit) = match measure {
                    Measure::Length => ("shifts", "mm"),
                    Measure::Angle => ("turns", "deg"),
                };
                let field = field.name();
                return Err(format!(
                    "{field} of joint {name}, which {moves}, has another unit: give {field}_{unit}"
                ));
            }
            found = Some(number(name, cell, measure, greatest)?);
        }
        Ok(found)
    };
    let [least, greatest] = [end(Field::Least)?.unwrap_or(-span), end(Field::Greatest)?.unwrap_or(span)];
    match least < greatest {
        true => Ok([least, greatest]),
        false => Err(format!("the range of joint {name} leaves it no room: give a min below the max")),
    }
}

/// The robot of a table's joints.
fn robot(name: &str, joints: &[DhJoint]) -> Result<Robot, Fault> {
    let mut parents = Vec::new();
    for (i, joint) in joints.iter().enumerate() {
        parents.push(match joint.parent {
            None if i == 0 => BASE,
            None => joints[i - 1].link.as_str(),
            Some(BASE) => BASE,
            Some(parent) => {
                let by_link = joints.iter().find(|other| other.link == parent);
                let found = by_link.or_else(|| joints.iter().find(|other| other.name == parent));
                let found = found.ok_or_else(|| {
                    let message = format!(
                        "joint {} hangs on {parent}, which is neither a joint nor a link: correct it, or give {BASE}",
                        joint.name
                    );
                    (joint.line, message)
                })?;
                found.link.as_str()
            }
        });
    }
    let mut robot = Robot::new(name, BASE);
    let mut due: Vec<usize> = (0..joints.len()).collect();
    while !due.is_empty() {
        let before = due.len();
        due.retain(|&i| {
            let Some(parent) = robot.link(parents[i]) else { return true };
            add_joint(&mut robot, &joints[i], parent);
            false
        });
        if due.len() == before {
            let names: Vec<&str> = due.iter().map(|&i| joints[i].name).collect();
            let message = match names.as_slice() {
                [one] => format!("joint {one} hangs on itself: correct its parent"),
                all => format!(
                    "joints {} hang on each other in a circle: correct the parent of one of them",
                    all.join(", ")
                ),
            };
            return Err((joints[due[0]].line, message));
        }
    }
    Ok(robot)
}

fn add_joint(robot: &mut Robot, joint: &DhJoint, parent: usize) {
    let DhJoint { name, kind, numbers, .. } = joint;
    let dof = kind.map(|kind| robot.add_dof(name, kind, joint.range, Vector3::z()));
    let moved = match kind {
        None => None,
        Some(DofKind::Slide) => Some(Field::D),
        Some(DofKind::Hinge | DofKind::Ball) => Some(Field::Theta),
    };
    let mut elements = [Element::Fixed(crate::geometry::Frame::identity()); 5];
    for ((field, number), element) in NUMBERS.into_iter().zip(numbers).zip(&mut elements) {
        let called = format!("{name}.{}", field.name());
        let dof = dof.filter(|_| moved == Some(field));
        if let Some((dof, q)) = dof.and_then(|dof| Some((dof, robot.dofs[dof].quantities?))) {
            robot.quantities[q.offset].name = called;
            robot.quantities[q.offset].nominal = Value::Number(*number);
            *element = Element::Dof(dof);
            continue;
        }
        let shifts = matches!(field, Field::D | Field::A);
        let unit = if shifts { Unit::Metre } else { Unit::Radian };
        let quantity = robot.add_quantity(called, unit, Value::Number(*number));
        *element = match field {
            Field::Theta => Element::TurnAbout(2, quantity),
            Field::D => Element::ShiftAlong(2, quantity),
            Field::A => Element::ShiftAlong(0, quantity),
            Field::Alpha => Element::TurnAbout(0, quantity),
            _ => Element::TurnAbout(1, quantity),
        };
    }
    let [theta, d, a, alpha, beta] = elements;
    let elements = match joint.convention {
        Convention::Standard => vec![theta, d, a, alpha, beta],
        Convention::Modified => vec![alpha, a, beta, theta, d],
    };
    robot.add_link(joint.link.clone(), parent, elements);
}
