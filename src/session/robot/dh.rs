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

use csv::StringRecord;
use nalgebra::Vector3;

use super::{Written, unsaid_of_encoder};
use crate::calibration::robot::{Element, Robot, Unit, Value};
use crate::creature::{DofKind, UNLIMITED_SLIDE};
use crate::error::Error;
use crate::model_files::{Edits, GREATEST_TURN, exact};
use crate::session::log::table::{Table, read_separated};
use crate::session::log::units::{Measure, name_and_unit};

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
/// Columns that hold words.
const WORDS: [&str; 5] = ["joint", "parent", "link", "kind", "convention"];
/// Columns without which a table is none.
const NEEDED: [&str; 4] = ["joint", "a", "d", "alpha"];

/// Reads a robot from the bytes of a table; the file is called `path` in messages, and the robot is, too.
///
/// # Errors
/// Where it is no table of a tree of hinges, slides and fixed joints; the error names the line.
pub fn read_dh(path: &Path, bytes: &[u8]) -> Result<Robot, Error> {
    let table = DhTable::read(path, bytes)?;
    let name = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or("robot");
    let mut robot = Robot::new(name, BASE);
    let (mut above, mut order) = (Vec::new(), CONVENTIONS[0].1);
    for (line, row) in &table.table.rows {
        add_joint(&mut robot, &table, row, &mut above, &mut order)
            .map_err(|message| Error::content(path, Some(*line), message))?;
    }
    Ok(robot)
}

/// The table `original`, which `robot` was read from, in its own columns and units, with `values` in the place of the numbers
/// that differ from them, and every other byte as it was. A column `theta` or `beta` is added where one is needed.
///
/// `path` is what the file is called in messages.
///
/// # Errors
/// Where `original` is no such table.
pub fn write_dh(path: &Path, original: &[u8], robot: &Robot, values: &[Value]) -> Result<Written, Error> {
    let table = DhTable::read(path, original)?;
    let end = |line: usize| line_at(original, line).end;
    let mut edits = Edits::default();
    for (column, measure, _) in NUMBERS {
        // Where a cell is to be added, and what is to be in it.
        let mut added = Vec::new();
        for (line, row) in &table.table.rows {
            let name = format!("{}.{column}", table.table.text(row, "joint").unwrap_or_default());
            let Some(quantity) = robot.quantity(&name) else {
                let message = format!("the robot has no {name}: give the file it was read from");
                return Err(Error::content(path, Some(*line), message));
            };
            let value = values[quantity].number();
            match table.table.at(column) {
                Some(at) if value == table.number(row, at, measure).unwrap_or_default() => {}
                Some(at) => edits.replace(cell_at(original, *line, at), exact(&[table.own_unit(at, value)])),
                None => added.push((*line, value)),
            }
        }
        if added.iter().any(|(_, value)| *value != 0.0) {
            edits.insert(end(table.table.line), format!(",{column}"));
            added.into_iter().for_each(|(line, value)| {
                edits.insert(end(line), format!(",{}", exact(&[value])));
            });
        }
    }
    Ok(Written { bytes: edits.of(original), left_out: unsaid(robot, values) })
}

/// Where a line of a file is, counted from 1, without what ends it.
fn line_at(bytes: &[u8], line: usize) -> Range<usize> {
    let mut lines = bytes.split(|byte| *byte == b'\n');
    let begin: usize = lines.by_ref().take(line - 1).map(|line| line.len() + 1).sum();
    let text = lines.next().unwrap_or_default();
    begin..begin + text.strip_suffix(b"\r").unwrap_or(text).len()
}

/// Where a cell of a line is, without blanks and quotes about it.
fn cell_at(bytes: &[u8], line: usize, cell: usize) -> Range<usize> {
    let mut quoted = false;
    let mut cells = bytes[line_at(bytes, line)].split(|byte| {
        quoted ^= *byte == b'"';
        *byte == b',' && !quoted
    });
    let bare = cells.nth(cell).unwrap_or_default().trim_ascii();
    let bare = bare.strip_prefix(b"\"").and_then(|inside| inside.strip_suffix(b"\"")).unwrap_or(bare);
    let from = bare.as_ptr() as usize - bytes.as_ptr() as usize;
    from..from + bare.len()
}

/// A table whose columns are known.
struct DhTable {
    table: Table,
    /// The columns of the ends of ranges: there may be one of angles and one of lengths.
    ends: Vec<(&'static str, usize)>,
}

impl DhTable {
    fn read(path: &Path, bytes: &[u8]) -> Result<DhTable, Error> {
        // The mark that some editors put before text.
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let mut table = read_separated(path, bytes)?;
        let refused = |line: usize, message: String| Err(Error::content(path, Some(line), message));
        if let Some(line) = table.cut {
            return refused(line, "it ends in the middle of this row: complete it".into());
        }
        let head = bytes.split(|byte| *byte == b'\n').nth(table.line - 1).unwrap_or_default();
        if head.iter().any(|byte| b";\t".contains(byte)) {
            let message = "its columns are not separated by commas: use commas, and decimal points";
            return refused(table.line, message.into());
        }
        let numbers = NUMBERS.map(|(name, measure, _)| (name, Some(measure)));
        let wanted: Vec<_> = WORDS.map(|name| (name, None)).into_iter().chain(numbers).collect();
        let found = table.assign(&wanted).map_err(|fault| Error::content(path, Some(table.line), fault))?;
        let mut ends = Vec::new();
        for at in 0..table.columns.len() {
            let title = table.columns[at].title.clone();
            let (name, unit) = match name_and_unit(&title) {
                Some((name, Ok(unit))) => (name, Some(unit)),
                _ => (title.as_str(), None),
            };
            if found.contains(&Some(at)) || name == "comment" {
                continue;
            }
            // A range is of angles or lengths, by what the joint does.
            let Some(end) = ["min", "max"].into_iter().find(|end| *end == name) else {
                let names =
                    WORDS.into_iter().chain(NUMBERS.map(|(name, ..)| name)).collect::<Vec<_>>().join(", ");
                let message = format!(
                    "column \"{title}\" is none of {names}, min, max, comment: rename it or leave it out"
                );
                return refused(table.line, message);
            };
            table.columns[at].unit = unit;
            ends.push((end, at));
        }
        let missing = NEEDED.into_iter().find(|needed| !table.has(needed));
        match missing {
            Some(missing) => {
                let message = format!(
                    "column {missing} is missing: begin with a header that includes joint, a, d, alpha and theta"
                );
                refused(table.line, message)
            }
            None if table.rows.is_empty() => {
                refused(table.line, "it has no joints: give one joint per row".into())
            }
            None => Ok(DhTable { table, ends }),
        }
    }

    /// A cell's number in metres or radians; `None` if it has no finite one.
    fn number(&self, row: &StringRecord, at: usize, measure: Measure) -> Option<f64> {
        let number = match row[at].parse::<f64>() {
            Ok(number) => Some(self.si(at, number)),
            Err(_) => printed(&row[at]).filter(|_| measure == Measure::Angle),
        };
        number.filter(|number| number.is_finite())
    }

    fn si(&self, at: usize, number: f64) -> f64 {
        self.table.columns[at].unit.map_or(number, |unit| number / unit.per)
    }

    /// A number of metres or radians in a column's own unit: rounded where that is the same number.
    fn own_unit(&self, at: usize, number: f64) -> f64 {
        let whole = self.table.columns[at].unit.map_or(number, |unit| number * unit.per);
        let round = format!("{whole:.14e}").parse().unwrap_or(whole);
        if self.si(at, round) == number { round } else { whole }
    }

    /// A cell's number for a joint. Where its unit is not given, it is refused if it is greater than `greatest`.
    fn checked(
        &self,
        row: &StringRecord,
        (column, at): (&str, usize),
        measure: Measure,
        greatest: f64,
    ) -> Result<f64, String> {
        let text = &row[at];
        let of = format!("{column} of joint {}", self.table.text(row, "joint").unwrap_or_default());
        let si = self.number(row, at, measure).ok_or_else(|| {
            let fix = match column {
                "theta" | "d" => "give the constant added to the joint coordinate, such as 0",
                _ => "give one",
            };
            format!("{of} is \"{text}\", not a finite number: {fix}")
        })?;
        let (unit, other, suffix) = match measure {
            Measure::Length => ("metres", "millimetres", "mm"),
            Measure::Angle => ("radians", "degrees", "deg"),
        };
        if self.table.columns[at].unit.is_none() && si.abs() > greatest {
            return Err(format!(
                "{of} is {text} {unit}: call it {column}_{suffix} if it is in {other}, or correct it"
            ));
        }
        if measure == Measure::Angle && si.abs() > greatest {
            return Err(format!("{of} is {text}, more than a turn: remove whole turns, or correct it"));
        }
        Ok(si)
    }
}

/// Adds the joint of a row and the link that it carries; `above` are those of the rows above, and the convention `order` stays
/// until a row names another.
fn add_joint<'a>(
    robot: &mut Robot,
    table: &'a DhTable,
    row: &'a StringRecord,
    above: &mut Vec<(&'a str, String)>,
    order: &mut [usize; 5],
) -> Result<(), String> {
    let text = |column: &str| table.table.text(row, column);
    let name = text("joint").ok_or("the joint has no name: give it one")?;
    let link = text("link").map_or_else(|| format!("{name}_link"), str::to_string);
    let (kind, moved) = match text("kind").map(str::to_lowercase).as_deref() {
        None | Some("hinge" | "revolute" | "r") => (Some(DofKind::Hinge), "theta"),
        Some("slide" | "prismatic" | "p") => (Some(DofKind::Slide), "d"),
        Some("fixed") => (None, ""),
        Some(other) => {
            return Err(format!("joint {name} has kind \"{other}\": give hinge, slide or fixed"));
        }
    };
    if let Some(text) = text("convention") {
        let known = CONVENTIONS.iter().find(|(name, _)| *name == text.to_lowercase());
        let unknown = || format!("unknown convention \"{text}\": give standard or modified");
        *order = known.ok_or_else(unknown)?.1;
    }
    let mut numbers = [0.0; 5];
    for ((column, measure, _), into) in NUMBERS.into_iter().zip(&mut numbers) {
        let greatest = if measure == Measure::Length { GREATEST_LENGTH } else { GREATEST_TURN };
        let needed = NEEDED.contains(&column);
        if let Some(at) = table.table.at(column).filter(|at| needed || !row[*at].is_empty()) {
            *into = table.checked(row, (column, at), measure, greatest)?;
        }
    }
    let range = kind.map_or(Ok([0.0; 2]), |kind| range(table, row, name, kind))?;
    if above.iter().any(|(other, _)| *other == name) {
        return Err(format!("two joints are called {name}: rename one"));
    }
    if robot.link(&link).is_some() {
        return Err(format!("two links are called {link}: rename one"));
    }
    let parent = match text("parent") {
        None => robot.links.len() - 1,
        Some(parent) => {
            let by_joint = || above.iter().find(|(other, _)| *other == parent);
            let found = robot.link(parent).or_else(|| robot.link(&by_joint()?.1));
            found.ok_or_else(|| {
                format!(
                    "the parent of joint {name}, {parent}, is neither a joint nor a link of an earlier row: \
                     correct it, move its row up, or give {BASE}"
                )
            })?
        }
    };
    let dof = kind.map(|kind| robot.add_dof(name, kind, range, Vector3::z()));
    let elements = NUMBERS.into_iter().zip(numbers).map(|((column, measure, axis), number)| {
        let called = format!("{name}.{column}");
        let dof = dof.filter(|_| moved == column);
        if let Some((dof, q)) = dof.and_then(|dof| Some((dof, robot.dofs[dof].quantities?))) {
            robot.quantities[q.offset].name = called;
            robot.quantities[q.offset].nominal = Value::Number(number);
            return Element::Dof(dof);
        }
        let unit = if measure == Measure::Length { Unit::Metre } else { Unit::Radian };
        let quantity = robot.add_quantity(called, unit, Value::Number(number));
        match measure {
            Measure::Length => Element::ShiftAlong(axis, quantity),
            Measure::Angle => Element::TurnAbout(axis, quantity),
        }
    });
    let elements: Vec<Element> = elements.collect();
    robot.add_link(link.clone(), parent, order.iter().map(|&place| elements[place]).collect());
    above.push((name, link));
    Ok(())
}

/// Least and greatest coordinate of a joint that moves.
fn range(table: &DhTable, row: &StringRecord, name: &str, kind: DofKind) -> Result<[f64; 2], String> {
    let (measure, moves, unit, span, greatest) = match kind {
        DofKind::Slide => (Measure::Length, "shifts", "mm", UNLIMITED_SLIDE, GREATEST_LENGTH),
        // Some turn twice about, either way.
        DofKind::Hinge | DofKind::Ball => {
            (Measure::Angle, "turns", "deg", std::f64::consts::PI, 2.0 * GREATEST_TURN)
        }
    };
    let mut range = [-span, span];
    for (column, end) in ["min", "max"].into_iter().zip(&mut range) {
        let given = |(name, at): &&(&str, usize)| *name == column && !row[*at].is_empty();
        for (_, at) in table.ends.iter().filter(given) {
            if table.table.columns[*at].unit.is_some_and(|unit| unit.measure != measure) {
                return Err(format!(
                    "{column} of joint {name}, which {moves}, has the wrong unit: give {column}_{unit}"
                ));
            }
            *end = table.checked(row, (column, *at), measure, greatest)?;
        }
    }
    match range[0] < range[1] {
        true => Ok(range),
        false => Err(format!("the range of joint {name} is empty: give a min below the max")),
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

/// What a table has no columns for.
fn unsaid(robot: &Robot, values: &[Value]) -> Vec<String> {
    let mut unsaid = Vec::new();
    for (dof, about) in robot.dofs.iter().enumerate() {
        let Some(q) = about.quantities else { continue };
        let name = &about.name;
        if values[q.sign].number() < 0.0 {
            unsaid.push(format!(
                "sign of {name} (-1) cannot be expressed in {FORMAT}: negate its encoder reading"
            ));
        }
        unsaid.extend(unsaid_of_encoder(robot, values, dof, FORMAT));
        let aside = values[q.axis].distance(&robot.quantities[q.axis].nominal);
        if aside > 0.0 {
            unsaid.push(format!(
                "axis of {name} (aside by {aside:.6} rad) cannot be expressed in {FORMAT}: calibrate {name}.alpha \
                 and {name}.beta instead"
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
                "link {} on {parent} cannot be expressed in {FORMAT}: keep its pose elsewhere",
                link.name
            ));
        }
    }
    unsaid
}
