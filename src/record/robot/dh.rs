//! A robot from a table of Denavit and Hartenberg's numbers in CSV, and the table with other numbers.
//!
//! A row is a joint and the link that it carries, called by the column `link`, or else JOINT_link; the root is `base`. A row
//! hangs on the row before it, or on the link or joint of a row above that `parent` names. With q for what the joint does, the link is at
//!
//! ```text
//! standard  Rz(theta + q) Tz(d) Tx(a) Rx(alpha) Ry(beta)
//! modified  Rx(alpha) Tx(a) Ry(beta) Rz(theta + q) Tz(d)     as Craig has it
//! ```
//!
//! and with d + q for a slide. `beta` is Hayati's, for joints whose axes are nearly parallel, between which d is not
//! identifiable; it is 0 where there is no such column. The numbers are the quantities JOINT.theta, JOINT.d, JOINT.a,
//! JOINT.alpha and JOINT.beta. The offset of a hinge's encoder is the same as its theta, and that of a slide the same as its
//! d: they are one quantity, called by the table's name.

use std::ops::Range;
use std::path::Path;

use nalgebra::Vector3;

use super::writing::{Written, unsaid_compliance, unsaid_gain};
use crate::calibration::robot::{Element, Robot, Unit as Of, Value};
use crate::creature::{DofKind, UNLIMITED_SLIDE};
use crate::model_files::{Edits, GREATEST_TURN, exact};
use crate::session::RecordError;
use crate::session::table::{Measure, Unit, name_and_unit};

/// The root's name.
const BASE: &str = "base";
/// Greatest length that is taken for metres where no unit is given.
const GREATEST_LENGTH: f64 = 20.0;
/// The format in sentences about what it has no columns for.
const FORMAT: &str = "a DH table";
/// The numbers of a row: a turn about or a shift along which axis.
const NUMBERS: [(&str, Measure, usize); 5] = [
    ("theta", Measure::Angle, 2),
    ("d", Measure::Length, 2),
    ("a", Measure::Length, 0),
    ("alpha", Measure::Angle, 0),
    ("beta", Measure::Angle, 1),
];
/// Where the numbers come in a product, by convention.
const CONVENTIONS: [(&str, [usize; 5]); 3] =
    [("standard", [0, 1, 2, 3, 4]), ("modified", [3, 2, 4, 0, 1]), ("craig", [3, 2, 4, 0, 1])];
/// Columns, other names for them, and the units that they may have.
const COLUMNS: [(&str, &[&str], &[Measure]); 13] = [
    ("joint", &["name"], &[]),
    ("parent", &[], &[]),
    ("link", &["child"], &[]),
    ("kind", &["type"], &[]),
    ("convention", &[], &[]),
    ("theta", &["theta_offset", "offset"], &[Measure::Angle]),
    ("d", &[], &[Measure::Length]),
    ("a", &[], &[Measure::Length]),
    ("alpha", &[], &[Measure::Angle]),
    ("beta", &[], &[Measure::Angle]),
    ("min", &["lower"], &[Measure::Length, Measure::Angle]),
    ("max", &["upper"], &[Measure::Length, Measure::Angle]),
    ("comment", &["note"], &[]),
];
/// Columns without which a table is none.
const NEEDED: [&str; 4] = ["joint", "a", "d", "alpha"];

/// What is wrong with a table, with its fix, and in which line.
type Fault = (usize, String);

/// Reads a robot from the bytes of a table; the file is called `path` in messages, and the robot is, too.
///
/// # Errors
/// Where it is no table of a tree of hinges, slides and fixed joints; [`RecordError`] names the line.
pub fn read_dh(path: &Path, bytes: &[u8]) -> Result<Robot, RecordError> {
    let read = Table::of(bytes).and_then(|table| {
        let name = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or("robot");
        robot(name, &joints(&table)?)
    });
    read.map_err(|(line, message)| RecordError::format(path, Some(line), message))
}

/// The table `original`, which `robot` was read from, in its own columns and units, with `values` in the place of the numbers
/// that differ from them, and every other byte as it was. A column `theta` or `beta` is added where one is needed.
///
/// `path` is what the file is called in messages.
///
/// # Errors
/// Where `original` is no such table.
pub fn write_dh(
    path: &Path,
    original: &[u8],
    robot: &Robot,
    values: &[Value],
) -> Result<Written, RecordError> {
    let edits = edits(original, robot, values);
    let edits = edits.map_err(|(line, message)| RecordError::format(path, Some(line), message))?;
    Ok(Written { bytes: edits.of(original), left_out: unsaid(robot, values) })
}

/// A table as it stands in a file.
struct Table {
    /// Where the name of another column may be put.
    header_end: usize,
    rows: Vec<Row>,
}

/// A joint.
struct Row {
    /// The line, counted from 1.
    line: usize,
    cells: Vec<Cell>,
    /// Where another cell may be put.
    end: usize,
}

/// A cell of a table.
struct Cell {
    /// The name of its column, as in [`COLUMNS`].
    column: &'static str,
    /// The unit in its column's title; none for metres and radians.
    unit: Option<Unit>,
    /// What is in it, without quotes.
    text: String,
    /// Where that is in the file.
    at: Range<usize>,
}

impl Table {
    fn of(bytes: &[u8]) -> Result<Table, Fault> {
        let text = std::str::from_utf8(bytes).map_err(|error| {
            let before = &bytes[..error.valid_up_to()];
            let line = 1 + before.iter().filter(|byte| **byte == b'\n').count();
            (line, "it is no text in UTF-8: save it as such".to_string())
        })?;
        let mut columns: Option<Vec<(&'static str, Option<Unit>)>> = None;
        let mut table = Table { header_end: 0, rows: Vec::new() };
        let mut next = 0;
        for (number, whole) in text.split_inclusive('\n').enumerate() {
            let (line, begin) = (number + 1, next);
            next += whole.len();
            let bare = whole.trim_end_matches(['\n', '\r']);
            let end = begin + bare.len();
            let words = bare.trim_start_matches('\u{feff}');
            if words.trim().is_empty() || words.starts_with('#') {
                continue;
            }
            let cells = cells(words, end - words.len());
            let Some(columns) = &columns else {
                let titles: Vec<&str> = cells.iter().map(|at| &text[at.clone()]).collect();
                columns = Some(header(&titles).map_err(|message| (line, message))?);
                table.header_end = end;
                continue;
            };
            if cells.len() != columns.len() {
                let (found, needed) = (cells.len(), columns.len());
                let message = format!("it has {found} cells in place of {needed}: give one for each column");
                return Err((line, message));
            }
            let cells = columns.iter().zip(cells).map(|(&(column, unit), at)| Cell {
                column,
                unit,
                text: text[at.clone()].replace("\"\"", "\""),
                at,
            });
            table.rows.push(Row { line, cells: cells.collect(), end });
        }
        match table.rows.is_empty() {
            true => Err((1, "it has no joint: give a table of a joint a row".into())),
            false => Ok(table),
        }
    }
}

/// Where the cells of a line are, without blanks and quotes about them; the line begins at a byte of the file.
fn cells(line: &str, begin: usize) -> Vec<Range<usize>> {
    let mut quoted = false;
    let apart = line.split(|mark: char| {
        quoted ^= mark == '"';
        mark == ',' && !quoted
    });
    let bare = |cell: &str| {
        let cell = cell.trim();
        let cell = cell.strip_prefix('"').and_then(|cell| cell.strip_suffix('"')).unwrap_or(cell);
        let from = begin + (cell.as_ptr() as usize - line.as_ptr() as usize);
        from..from + cell.len()
    };
    apart.map(bare).collect()
}

/// The columns by their titles.
fn header(titles: &[&str]) -> Result<Vec<(&'static str, Option<Unit>)>, String> {
    if let [only] = titles
        && let Some(separator) = [';', '\t'].into_iter().find(|separator| only.contains(*separator))
    {
        return Err(format!(
            "its columns are separated by {separator:?}: separate them by commas, and write decimals with a point"
        ));
    }
    let columns: Vec<_> = titles.iter().map(|title| column(title)).collect::<Result<_, _>>()?;
    let missing = NEEDED.into_iter().find(|needed| !columns.iter().any(|(column, _)| column == needed));
    match missing {
        Some(missing) => Err(format!(
            "there is no column {missing}: begin with a line of column names, joint, a, d, alpha and theta among them"
        )),
        None => Ok(columns),
    }
}

/// A column and its unit by a title such as `alpha`, `alpha_deg`, `alpha [deg]` or `a (mm)`.
fn column(title: &str) -> Result<(&'static str, Option<Unit>), String> {
    let (bare, unit) = match name_and_unit(title) {
        Some((bare, Ok(unit))) => (bare, Some(unit)),
        Some((_, Err(_))) => {
            return Err(format!("column \"{title}\": its unit is not known: give m, cm, mm, rad or deg"));
        }
        None => (title, None),
    };
    let bare = bare.trim().to_lowercase();
    let found = COLUMNS.iter().find(|(name, others, _)| *name == bare || others.contains(&bare.as_str()));
    let Some((name, _, measures)) = found else {
        let names = COLUMNS.map(|(name, ..)| name).join(", ");
        return Err(format!("column \"{title}\" is none of {names}: rename it or leave it out"));
    };
    match unit {
        Some(unit) if !measures.contains(&unit.measure) => {
            let units = match measures.first() {
                Some(Measure::Length) => "m, cm or mm",
                Some(Measure::Angle) => "rad or deg",
                None => "no unit",
            };
            Err(format!("column \"{title}\": {name} has another unit: give {units}"))
        }
        unit => Ok((*name, unit)),
    }
}

impl Row {
    fn cell(&self, column: &str) -> Option<&Cell> {
        self.cells.iter().find(|cell| cell.column == column)
    }

    /// What is in a cell, if there is one and it is not empty.
    fn text(&self, column: &str) -> Option<&str> {
        Some(self.cell(column)?.text.trim()).filter(|text| !text.is_empty())
    }
}

impl Cell {
    /// A number of metres or radians, of what the cell has of its own unit.
    fn si(&self, number: f64) -> f64 {
        self.unit.map_or(number, |unit| number / unit.per)
    }

    /// What the cell is to have of its own unit for a number of metres or radians: rounded where that is the same number.
    fn own_unit(&self, number: f64) -> f64 {
        let whole = self.unit.map_or(number, |unit| number * unit.per);
        let round = format!("{whole:.14e}").parse().unwrap_or(whole);
        if self.si(round) == number { round } else { whole }
    }

    /// Its number in metres or radians; none where it has no finite one.
    fn si_number(&self, measure: Measure) -> Option<f64> {
        let text = self.text.trim();
        let number = match text.parse() {
            Ok(number) => Some(self.si(number)),
            Err(_) => printed(text).filter(|_| measure == Measure::Angle),
        };
        number.filter(|number| number.is_finite())
    }

    /// The same of a joint. Where its unit is not given, it is refused if it is greater than `greatest`.
    fn number(&self, joint: &str, measure: Measure, greatest: f64) -> Result<f64, String> {
        let Cell { column, text, .. } = self;
        let si = self.si_number(measure).ok_or_else(|| {
            let fix = match *column {
                "theta" | "d" => "give what is added to the joint's own coordinate, 0 if nothing",
                _ => "give one",
            };
            format!("{column} of joint {joint} is \"{}\", which is no finite number: {fix}", text.trim())
        })?;
        let (unit, other, suffix) = match measure {
            Measure::Length => ("metres", "millimetres", "mm"),
            Measure::Angle => ("radians", "degrees", "deg"),
        };
        if self.unit.is_none() && si.abs() > greatest {
            return Err(format!(
                "{column} of joint {joint} is {text} {unit}: call it {column}_{suffix} if it is in {other}, or mend it"
            ));
        }
        if measure == Measure::Angle && si.abs() > greatest {
            return Err(format!(
                "{column} of joint {joint} is {text}, more than a turn: take whole turns off, or mend it"
            ));
        }
        Ok(si)
    }
}

/// Radians as books print them: 90°, or a product with π such as -pi/2, 2*pi/3 or 1.5π.
fn printed(text: &str) -> Option<f64> {
    const SIGNS: [char; 4] = ['*', '/', '·', '×'];
    let text: String = text.to_lowercase().chars().filter(|mark| !mark.is_whitespace()).collect();
    let text = text.replace('π', "pi").replace('−', "-");
    if let Some(number) = ["°", "deg"].iter().find_map(|unit| text.strip_suffix(unit)) {
        return number.parse::<f64>().ok().map(f64::to_radians);
    }
    let (mut product, factors) = match text.strip_prefix('-') {
        Some(factors) => (-1.0, factors),
        None => (1.0, text.strip_prefix('+').unwrap_or(&text)),
    };
    let factors = factors.strip_prefix('(').and_then(|inside| inside.strip_suffix(')')).unwrap_or(factors);
    let mut divided = false;
    for part in factors.split_inclusive(SIGNS) {
        let factor = part.trim_end_matches(SIGNS);
        // As mathematics and the libraries of Python and C call it.
        let times =
            ["np.pi", "numpy.pi", "math.pi", "m_pi", "pi"].iter().find_map(|pi| factor.strip_suffix(pi));
        let number = match times {
            Some("") => std::f64::consts::PI,
            Some(times) => times.parse::<f64>().ok()? * std::f64::consts::PI,
            None => factor.parse().ok()?,
        };
        product = if divided { product / number } else { product * number };
        divided = part.ends_with('/');
    }
    (!factors.is_empty() && !factors.ends_with(SIGNS)).then_some(product)
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
    /// Where its numbers come in the product.
    order: [usize; 5],
    /// In the order of [`NUMBERS`], metres and radians.
    numbers: [f64; 5],
    range: [f64; 2],
}

/// The joints of a table.
fn joints(table: &Table) -> Result<Vec<DhJoint<'_>>, Fault> {
    let mut order = CONVENTIONS[0].1;
    let mut joints: Vec<DhJoint> = Vec::new();
    for row in &table.rows {
        let joint = joint(row, &mut order).map_err(|message| (row.line, message))?;
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
    Ok(joints)
}

/// The joint of a row; the convention stays until a row names another.
fn joint<'a>(row: &'a Row, order: &mut [usize; 5]) -> Result<DhJoint<'a>, String> {
    for (i, cell) in row.cells.iter().enumerate() {
        // Of ranges there may be a column of angles and one of lengths.
        let several = ["min", "max", "comment"].contains(&cell.column);
        if !several && row.cells[..i].iter().any(|other| other.column == cell.column) {
            return Err(format!("{} is given twice: leave one of them out", cell.column));
        }
    }
    let name = row.text("joint").ok_or("the joint has no name: give it one")?;
    let kind = match row.text("kind").map(str::to_lowercase).as_deref() {
        None | Some("hinge" | "revolute" | "r") => Some(DofKind::Hinge),
        Some("slide" | "prismatic" | "p") => Some(DofKind::Slide),
        Some("fixed") => None,
        Some(other) => {
            return Err(format!("joint {name} is of the kind \"{other}\": give hinge, slide or fixed"));
        }
    };
    if let Some(text) = row.text("convention") {
        let known = CONVENTIONS.iter().find(|(name, _)| *name == text.to_lowercase());
        *order = known
            .ok_or_else(|| format!("the convention \"{text}\" is not known: give standard or modified"))?
            .1;
    }
    let mut numbers = [0.0; 5];
    for ((column, measure, _), into) in NUMBERS.into_iter().zip(&mut numbers) {
        let greatest = if measure == Measure::Length { GREATEST_LENGTH } else { GREATEST_TURN };
        let needed = NEEDED.contains(&column);
        if let Some(cell) = row.cell(column).filter(|cell| needed || !cell.text.trim().is_empty()) {
            *into = cell.number(name, measure, greatest)?;
        }
    }
    let range = kind.map_or(Ok([0.0; 2]), |kind| range(row, name, kind))?;
    let link = row.text("link").map_or_else(|| format!("{name}_link"), str::to_string);
    Ok(DhJoint {
        line: row.line,
        name,
        link,
        parent: row.text("parent"),
        kind,
        order: *order,
        numbers,
        range,
    })
}

/// Least and greatest coordinate of a joint that moves.
fn range(row: &Row, name: &str, kind: DofKind) -> Result<[f64; 2], String> {
    let (measure, moves, unit, span, greatest) = match kind {
        DofKind::Slide => (Measure::Length, "shifts", "mm", UNLIMITED_SLIDE, GREATEST_LENGTH),
        // Some turn twice about, either way.
        DofKind::Hinge | DofKind::Ball => {
            (Measure::Angle, "turns", "deg", std::f64::consts::PI, 2.0 * GREATEST_TURN)
        }
    };
    let mut range = [-span, span];
    for (column, end) in ["min", "max"].into_iter().zip(&mut range) {
        let given = |cell: &&Cell| cell.column == column && !cell.text.trim().is_empty();
        for cell in row.cells.iter().filter(given) {
            if cell.unit.is_some_and(|unit| unit.measure != measure) {
                return Err(format!(
                    "{column} of joint {name}, which {moves}, has another unit: give {column}_{unit}"
                ));
            }
            *end = cell.number(name, measure, greatest)?;
        }
    }
    match range[0] < range[1] {
        true => Ok(range),
        false => Err(format!("the range of joint {name} leaves it no room: give a min below the max")),
    }
}

/// The robot of a table's joints.
fn robot(name: &str, joints: &[DhJoint]) -> Result<Robot, Fault> {
    let mut robot = Robot::new(name, BASE);
    for (i, joint) in joints.iter().enumerate() {
        let above = &joints[..i];
        let parent = match joint.parent {
            None => above.last().map_or(BASE, |before| &before.link),
            Some(BASE) => BASE,
            Some(parent) => {
                let by_link = above.iter().find(|other| other.link == parent);
                let found = by_link.or_else(|| above.iter().find(|other| other.name == parent));
                let found = found.ok_or_else(|| {
                    let message = format!(
                        "joint {} hangs on {parent}, which is neither a joint nor a link of a row above: correct it, move \
                         its row up, or give {BASE}",
                        joint.name
                    );
                    (joint.line, message)
                })?;
                &found.link
            }
        };
        let parent = robot.link(parent).unwrap_or_default();
        add_joint(&mut robot, joint, parent);
    }
    Ok(robot)
}

fn add_joint(robot: &mut Robot, joint: &DhJoint, parent: usize) {
    let DhJoint { name, kind, numbers, order, .. } = joint;
    let dof = kind.map(|kind| robot.add_dof(name, kind, joint.range, Vector3::z()));
    let moved = kind.map(|kind| if kind == DofKind::Slide { "d" } else { "theta" });
    let elements = NUMBERS.into_iter().zip(numbers).map(|((column, measure, axis), number)| {
        let called = format!("{name}.{column}");
        let dof = dof.filter(|_| moved == Some(column));
        if let Some((dof, q)) = dof.and_then(|dof| Some((dof, robot.dofs[dof].quantities?))) {
            robot.quantities[q.offset].name = called;
            robot.quantities[q.offset].nominal = Value::Number(*number);
            return Element::Dof(dof);
        }
        let unit = if measure == Measure::Length { Of::Metre } else { Of::Radian };
        let quantity = robot.add_quantity(called, unit, Value::Number(*number));
        match measure {
            Measure::Length => Element::ShiftAlong(axis, quantity),
            Measure::Angle => Element::TurnAbout(axis, quantity),
        }
    });
    let elements: Vec<Element> = elements.collect();
    robot.add_link(joint.link.clone(), parent, order.iter().map(|&place| elements[place]).collect());
}

/// What is to be changed in a table.
fn edits(original: &[u8], robot: &Robot, values: &[Value]) -> Result<Edits, Fault> {
    let table = Table::of(original)?;
    let mut edits = Edits::default();
    for (column, measure, _) in NUMBERS {
        // Where a cell is to be added, and what is to be in it.
        let mut added = Vec::new();
        for row in &table.rows {
            let name = format!("{}.{column}", row.text("joint").unwrap_or_default());
            let Some(quantity) = robot.quantity(&name) else {
                let message = format!("the robot has no {name}: give the file that it was read from");
                return Err((row.line, message));
            };
            let value = values[quantity].number();
            match row.cell(column) {
                Some(cell) if value == cell.si_number(measure).unwrap_or_default() => {}
                Some(cell) => edits.replace(cell.at.clone(), exact(&[cell.own_unit(value)])),
                None => added.push((row.end, value)),
            }
        }
        if added.iter().any(|(_, value)| *value != 0.0) {
            edits.insert(table.header_end, format!(",{column}"));
            added.into_iter().for_each(|(end, value)| edits.insert(end, format!(",{}", exact(&[value]))));
        }
    }
    Ok(edits)
}

/// What a table has no columns for.
fn unsaid(robot: &Robot, values: &[Value]) -> Vec<String> {
    let mut unsaid = Vec::new();
    for (dof, about) in robot.dofs.iter().enumerate() {
        let Some(q) = about.quantities else { continue };
        let name = &about.name;
        if values[q.sign].number() < 0.0 {
            unsaid.push(format!(
                "sign of {name} (-1) cannot be said in {FORMAT}: take what its encoder reads the other way round"
            ));
        }
        unsaid.extend(unsaid_gain(robot, values, dof, FORMAT));
        unsaid.extend(unsaid_compliance(robot, values, dof, FORMAT));
        let aside = values[q.axis].distance(&robot.quantities[q.axis].nominal);
        if aside > 0.0 {
            unsaid.push(format!(
                "axis of {name} (aside by {aside:.6} rad) cannot be said in {FORMAT}: calibrate {name}.alpha and \
                 {name}.beta in its place"
            ));
        }
    }
    for link in &robot.links {
        let changed = link.elements.iter().any(|element| match element {
            Element::Shift(q) | Element::Turn(q) => values[*q] != robot.quantities[*q].nominal,
            _ => false,
        });
        if changed {
            let parent = &robot.links[link.parent].name;
            unsaid.push(format!(
                "link {} on {parent} cannot be said in {FORMAT}: keep its pose elsewhere",
                link.name
            ));
        }
    }
    unsaid
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::calibration::robot::Posed;
    use crate::geometry::Frame;
    use crate::session::table::DEGREES;

    const CSV: &str = "# A hand, with millimetres.\r
joint, a_mm ,d,alpha [deg],theta_deg,kind,parent,min_deg,max_deg,max_mm\r
j1,0,0.30,90, 0,,,-170,170,\r
j2,\"250.5\",0,0,-90.0,hinge,,,,\r
slide,10,0.1,-90,5,slide,j2,,,300\r
flange,0,0.05,0,45,fixed,j1,,,\r
";
    const CRAIG: &str = "name,link,kind,a_mm,d,alpha,theta,beta,max,convention,parent,\"comment\"
j1,,,0,0.30,pi/2,,,,modified,,\"odd, but so it is\"
j2,fore,,250.5,0,-0.1,0.20,,,,,
slide,,prismatic,10,0.1,1,,0.05,0.3,,fore,
old,,,10,0.1,1,,0.1,,standard,base,
";

    fn read(text: &str) -> Result<Robot, String> {
        read_dh(Path::new("table"), text.as_bytes()).map_err(|error| error.to_string())
    }

    fn write(text: &str, robot: &Robot, values: &[Value]) -> (String, Vec<String>) {
        let Written { bytes, left_out } =
            write_dh(Path::new("table"), text.as_bytes(), robot, values).unwrap();
        (String::from_utf8(bytes).unwrap(), left_out)
    }

    fn turn(axis: usize, angle: f64) -> Frame {
        let rotation = Rotation3::new(Vector3::ith(axis, angle)).into_inner();
        Frame { rotation, origin: Vector3::zeros() }
    }

    fn shift(axis: usize, by: f64) -> Frame {
        Frame { origin: Vector3::ith(axis, by), ..Frame::identity() }
    }

    fn far(a: &Frame, b: &Frame) -> f64 {
        (a.rotation - b.rotation).norm().max((a.origin - b.origin).norm())
    }

    #[test]
    fn links_are_where_the_conventions_have_them() {
        let standard = |theta: f64, d, a, alpha| turn(2, theta) * shift(2, d) * shift(0, a) * turn(0, alpha);
        let modified = |theta: f64, d, a, alpha| turn(0, alpha) * shift(0, a) * turn(2, theta) * shift(2, d);
        let degree = std::f64::consts::PI / 180.0;
        let [p, q, s, o] = [0.3, -0.7, 0.05, 1.1];
        let first = standard(p, 0.3, 0.0, 90.0 * degree);
        let second = first * standard(q - 90.0 * degree, 0.0, 0.2505, 0.0);
        let csv = [
            ("j1_link", first),
            ("j2_link", second),
            ("slide_link", second * standard(5.0 * degree, 0.1 + s, 0.01, -90.0 * degree)),
            ("flange_link", first * standard(45.0 * degree, 0.05, 0.0, 0.0)),
        ];
        let first = modified(p, 0.3, 0.0, 90.0 * degree);
        let second = first * modified(q + 0.2, 0.0, 0.2505, -0.1);
        let craig = [
            ("j1_link", first),
            ("fore", second),
            ("slide_link", second * turn(0, 1.0) * shift(0, 0.01) * turn(1, 0.05) * shift(2, 0.1 + s)),
            ("old_link", standard(o, 0.1, 0.01, 1.0) * turn(1, 0.1)),
        ];
        for (text, expected) in [(CSV, csv), (CRAIG, craig)] {
            let robot = read(text).unwrap();
            let (nominal, posture) = (robot.nominal(), [p, q, s, o]);
            let frames = Posed::new(&robot, &nominal, &posture[..robot.coordinates()]).frames();
            for (name, frame) in expected {
                let found = &frames[robot.link(name).unwrap()];
                assert!(far(found, &frame) < 1e-12, "{name}: {found:?} {frame:?}");
            }
            assert!((robot.dofs[2].range[1] - 0.3).abs() < 1e-15);
            assert!(robot.quantity("j1.offset").is_none() && robot.quantity("slide.theta").is_some());
            assert_eq!(robot.quantity("j2.theta"), robot.dofs[1].quantities.map(|q| q.offset));
        }
        assert!((read(CSV).unwrap().dofs[0].range[1] - 170.0 * degree).abs() < 1e-15);
    }

    #[test]
    fn what_did_not_change_is_written_byte_for_byte() {
        for text in [CSV.to_string(), format!("\u{feff}{CSV}"), CSV.trim_end().to_string(), CRAIG.to_string()]
        {
            let robot = read(&text).unwrap();
            assert_eq!(write(&text, &robot, &robot.nominal()), (text, Vec::new()));
        }
    }

    #[test]
    fn only_the_numbers_that_changed_are_written() {
        let robot = read(CSV).unwrap();
        let changed = |name: &str, value: f64| {
            let mut values = robot.nominal();
            values[robot.quantity(name).unwrap()] = Value::Number(value);
            write(CSV, &robot, &values).0
        };
        assert_eq!(changed("j2.a", 0.25075), CSV.replace("\"250.5\"", "\"250.75\""));
        let written = changed("j2.beta", 0.5);
        let lines: Vec<&str> = written.lines().collect();
        assert!(
            lines[1].ends_with("max_mm,beta") && lines[2].ends_with("170,,0") && lines[3].ends_with(",0.5")
        );
    }

    #[test]
    fn a_calibrated_robot_reads_back_as_the_same() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for text in [CSV, CRAIG] {
            let robot = read(text).unwrap();
            let mut values = robot.nominal();
            for (quantity, value) in robot.quantities.iter().zip(&mut values) {
                let called =
                    |(column, ..): &(&str, Measure, usize)| quantity.name.ends_with(&format!(".{column}"));
                if NUMBERS.iter().any(called) {
                    *value = value.stepped(&[rng.random_range(-0.1..0.1)]);
                }
            }
            let (written, left_out) = write(text, &robot, &values);
            assert_eq!(left_out, Vec::<String>::new());
            let again = read(&written).unwrap();
            for _ in 0..20 {
                let posture: Vec<f64> =
                    (0..robot.coordinates()).map(|_| rng.random_range(-2.0..2.0)).collect();
                let one = Posed::new(&robot, &values, &posture).frames();
                let other = Posed::new(&again, &again.nominal(), &posture).frames();
                assert!(one.iter().zip(&other).all(|(a, b)| far(a, b) < 1e-12), "{written}");
            }
        }
    }

    #[test]
    fn what_a_table_cannot_hold_is_reported() {
        let mut robot = read(CSV).unwrap();
        robot.add_mount("tip", 1, Frame::identity());
        let mut values = robot.nominal();
        for (name, value) in [
            ("j1.sign", Value::Number(-1.0)),
            ("j1.gain", Value::Number(1.01)),
            ("slide.compliance", Value::Number(1e-3)),
            ("j2.axis", Value::Direction(Vector3::new(0.0, 0.1, 1.0).normalize())),
            ("tip.position", Value::Position(Vector3::x())),
        ] {
            values[robot.quantity(name).unwrap()] = value;
        }
        let (text, left_out) = write(CSV, &robot, &values);
        assert_eq!(text, CSV);
        let begin = ["sign of j1", "gain of j1", "axis of j2", "compliance of slide", "link tip on j1_link"];
        let all = left_out.iter().zip(begin).all(|(sentence, begin)| sentence.starts_with(begin));
        assert!(all && left_out.len() == begin.len(), "{left_out:?}");
    }

    #[test]
    fn angles_are_read_as_books_print_them() {
        use std::f64::consts::PI;
        for (text, expected) in [
            ("pi/2", PI / 2.0),
            ("-pi", -PI),
            ("2*pi/3", 2.0 * PI / 3.0),
            ("π", PI),
            ("−π/2", -PI / 2.0),
            ("+0.5 * np.pi", 0.5 * PI),
            ("-(math.pi / 4)", -PI / 4.0),
            ("3π/4", 0.75 * PI),
            ("-90°", -PI / 2.0),
            ("45 deg", PI / 4.0),
        ] {
            let found = printed(text).unwrap_or_else(|| panic!("{text} is read"));
            assert!((found - expected).abs() < 1e-15, "{text}: {found}");
        }
        for text in ["pie", "pi/", "*pi", "pi//2", "q1", "", "theta+pi", "1/2/x"] {
            assert_eq!(printed(text), None, "{text}");
        }
    }

    #[test]
    fn titles_hold_names_and_units() {
        for (title, expected, per) in [
            ("alpha", "alpha", None),
            ("alpha_deg", "alpha", Some(DEGREES)),
            ("Alpha [deg]", "alpha", Some(DEGREES)),
            ("a (mm)", "a", Some(1000.0)),
            ("theta_offset_rad", "theta", Some(1.0)),
            ("max(°)", "max", Some(DEGREES)),
            ("thetaDeg", "theta", Some(DEGREES)),
        ] {
            let (found, unit) = column(title).unwrap();
            assert_eq!((found, unit.map(|unit| unit.per)), (expected, per), "{title}");
        }
    }

    #[test]
    fn mistakes_get_a_sentence() {
        let with = |from: &str, to: &str| {
            let text = if CSV.contains(from) { CSV } else { CRAIG };
            assert!(text.contains(from), "{from}");
            read(&text.replacen(from, to, 1)).unwrap_err()
        };
        let cases = [
            (with("alpha [deg]", "comment"), "table, line 2: there is no column alpha: "),
            (
                with("alpha [deg]", "alpha"),
                "table, line 3: alpha of joint j1 is 90 radians: call it alpha_deg",
            ),
            (with("a_mm", "a"), "table, line 4: a of joint j2 is 250.5 metres: call it a_mm"),
            (with("min_deg", "min"), "table, line 3: min of joint j1 is -170 radians: call it min_deg"),
            (with("slide,10", "slide,q2"), "line 5: a of joint slide is \"q2\", which is no finite number: "),
            (
                with("5,slide", "5,screw"),
                "line 5: joint slide is of the kind \"screw\": give hinge, slide or fixed",
            ),
            (
                with("slide,j2", "slide,j9"),
                "line 5: joint slide hangs on j9, which is neither a joint nor a link of a row above: ",
            ),
            (with("slide,j2,,,300", "slide,j2,,90,"), "max of joint slide, which shifts, has another unit: "),
            (with(",,,,\r\nslide", ",,\r\nslide"), "line 4: it has 8 cells in place of 10: "),
            (with("fixed,j1", "fixed,base,,,\r\nj1,0,0,0,0,,"), "there are two joints j1: rename one"),
            (read("joint;a;d").unwrap_err(), "line 1: its columns are separated by ';': "),
            (read("").unwrap_err(), "line 1: it has no joint: "),
            (
                with("modified", "paul"),
                "line 2: the convention \"paul\" is not known: give standard or modified",
            ),
            (with("0.05,0.3,", "0.05,-9,"), "the range of joint slide leaves it no room"),
            (with("theta_deg", "theta_mm"), "column \"theta_mm\": theta has another unit: give rad or deg"),
            (with("d,alpha [deg]", "d [inch],alpha [deg]"), "its unit is not known: "),
            (with("\"comment\"", "weight"), "column \"weight\" is none of joint, parent, "),
        ];
        for (message, expected) in cases {
            assert!(message.contains(expected), "{message} != {expected}");
        }
    }
}
