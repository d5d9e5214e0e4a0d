//! A table of Denavit and Hartenberg's numbers as it stands in a file, CSV or JSON: every cell knows its bytes and its unit.

use std::collections::BTreeMap;
use std::ops::Range;

use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::value::RawValue;

use super::edits::first_byte;
use super::tags::{Fault, line_of, text_begins};
use crate::session::json_reason;
use crate::session::table::{Measure, Unit, name_and_unit};

/// What a column or a field says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Field {
    Joint,
    Parent,
    Link,
    Kind,
    Convention,
    Theta,
    D,
    A,
    Alpha,
    /// Hayati's turn about y, for axes that are nearly parallel.
    Beta,
    Least,
    Greatest,
    /// Both of them, in JSON.
    Range,
    Comment,
}

impl Field {
    /// The names of fields; the first of each is what messages call it.
    const NAMES: [(Field, &'static [&'static str]); 14] = [
        (Field::Joint, &["joint", "name"]),
        (Field::Parent, &["parent"]),
        (Field::Link, &["link", "child"]),
        (Field::Kind, &["kind", "type"]),
        (Field::Convention, &["convention"]),
        (Field::Theta, &["theta", "theta_offset", "offset"]),
        (Field::D, &["d"]),
        (Field::A, &["a"]),
        (Field::Alpha, &["alpha"]),
        (Field::Beta, &["beta"]),
        (Field::Least, &["min", "lower"]),
        (Field::Greatest, &["max", "upper"]),
        (Field::Range, &["range"]),
        (Field::Comment, &["comment", "note"]),
    ];

    /// What it is called.
    pub fn name(self) -> &'static str {
        Field::NAMES.iter().find(|(field, _)| *field == self).map_or("", |(_, names)| names[0])
    }

    /// What its numbers measure, where it has numbers: of ranges it is what the joint does.
    fn takes(self, measure: Measure) -> bool {
        match self {
            Field::Theta | Field::Alpha | Field::Beta => measure == Measure::Angle,
            Field::D | Field::A => measure == Measure::Length,
            Field::Least | Field::Greatest | Field::Range => true,
            _ => false,
        }
    }
}

/// A field and its unit by a name such as `alpha`, `alpha_deg`, `alpha [deg]` or `a (mm)`.
fn field(name: &str) -> Result<(Field, Option<Unit>), String> {
    let (bare, unit) = match name_and_unit(name.trim()) {
        Some((bare, Ok(unit))) => (bare, Some(unit)),
        Some((_, Err(_))) => {
            return Err(format!("\"{name}\": its unit is not known: give m, cm, mm, rad or deg"));
        }
        None => (name, None),
    };
    let bare = bare.trim().to_lowercase();
    let Some((field, _)) = Field::NAMES.iter().find(|(_, names)| names.contains(&bare.as_str())) else {
        let names: Vec<&str> = Field::NAMES.iter().map(|(_, names)| names[0]).collect();
        return Err(format!("\"{name}\" is none of {}: rename it or leave it out", names.join(", ")));
    };
    match unit {
        Some(unit) if !field.takes(unit.measure) => {
            let units = match (field.takes(Measure::Length), field.takes(Measure::Angle)) {
                (true, _) => "m, cm or mm",
                (_, true) => "rad or deg",
                _ => "no unit",
            };
            Err(format!("\"{name}\": {} has another unit: give {units}", field.name()))
        }
        unit => Ok((*field, unit)),
    }
}

/// Radians as books print them: 90°, or a product with π such as -pi/2, 2*pi/3 or 1.5π.
fn printed(text: &str) -> Option<f64> {
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
    for part in factors.split_inclusive(['*', '/', '·', '×']) {
        let factor = part.trim_end_matches(['*', '/', '·', '×']);
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
    (!factors.is_empty() && !factors.ends_with(['*', '/', '·', '×'])).then_some(product)
}

/// A cell of a table.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cell {
    /// What it says.
    pub field: Field,
    /// The unit that its name says; none for metres and radians.
    pub unit: Option<Unit>,
    /// What is in it, without quotes.
    pub text: String,
    /// Where that is in the file.
    pub at: Range<usize>,
}

impl Cell {
    /// Its number in metres or radians; none where it has no finite one.
    pub fn si_number(&self) -> Option<f64> {
        let text = self.text.trim();
        let number = match text.parse() {
            Ok(number) => Some(self.si(number)),
            Err(_) => printed(text).filter(|_| self.field.takes(Measure::Angle)),
        };
        number.filter(|number| number.is_finite())
    }
}

/// A row of a table: a joint.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Row {
    /// The line in which it begins, counted from 1.
    pub line: usize,
    /// Its cells.
    pub cells: Vec<Cell>,
    /// Where another cell may be put.
    pub end: usize,
}

/// A table.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Table {
    /// The robot's name, where the file says it.
    pub name: Option<String>,
    /// The convention of rows that name none.
    pub convention: Option<String>,
    /// Its rows.
    pub rows: Vec<Row>,
    /// Where the name of another column may be put; none of JSON, whose rows name their cells.
    pub header_end: Option<usize>,
}

/// Reads a table, as JSON where it begins so.
///
/// # Errors
/// Where it is neither.
pub(super) fn table(bytes: &[u8]) -> Result<Table, Fault> {
    match first_byte(bytes) {
        None => return Err((1, "it is empty: give a table of a joint a row".into())),
        Some(b'<') => {
            let message = "it is XML where a table of Denavit and Hartenberg's numbers is expected: give it with the \
                           ending .urdf, or give CSV or JSON";
            return Err((1, message.into()));
        }
        _ => {}
    }
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let line = line_of(bytes, error.valid_up_to());
        (line, "it is no text in UTF-8: save it as such".to_string())
    })?;
    match first_byte(bytes) {
        Some(b'{') => json(text),
        Some(b'[') => Err((1, "it is a list: give an object {\"joints\": […]}".into())),
        _ => csv(text),
    }
}

/// Whether a file of JSON has joints with numbers of Denavit and Hartenberg's.
pub(super) fn is_dh_json(bytes: &[u8]) -> bool {
    #[derive(Deserialize)]
    struct Joints {
        joints: Vec<BTreeMap<String, IgnoredAny>>,
    }
    let found: Result<Joints, _> = serde_json::from_slice(&bytes[text_begins(bytes)..]);
    let numbers = |name: &String| {
        field(name).is_ok_and(|(field, _)| [Field::Theta, Field::D, Field::A, Field::Alpha].contains(&field))
    };
    found.is_ok_and(|found| found.joints.iter().any(|joint| joint.keys().any(numbers)))
}

/// A file of JSON.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object with a list of joints")]
struct JsonTable<'a> {
    name: Option<String>,
    convention: Option<String>,
    #[serde(rename = "comment")]
    _comment: Option<serde_json::Value>,
    #[serde(borrow)]
    joints: Vec<BTreeMap<String, &'a RawValue>>,
}

fn json(text: &str) -> Result<Table, Fault> {
    let read: JsonTable = serde_json::from_str(&text[text_begins(text.as_bytes())..]).map_err(|error| {
        let message =
            format!("it is no table of Denavit and Hartenberg's numbers ({}): mend it", json_reason(&error));
        (error.line().max(1), message)
    })?;
    let place = |part: &str| {
        let begin = part.as_ptr() as usize - text.as_ptr() as usize;
        begin..begin + part.len()
    };
    let mut rows = Vec::new();
    for (i, joint) in read.joints.iter().enumerate() {
        let places = || joint.values().map(|value| place(value.get()));
        let Some(first) = places().map(|at| at.start).min() else {
            return Err((1, format!("joint {} of the list is empty: give it numbers", i + 1)));
        };
        let line = line_of(text.as_bytes(), first);
        let end = places().map(|at| at.end).max().unwrap_or(first);
        let mut cells = Vec::new();
        for (name, value) in joint {
            let line = line_of(text.as_bytes(), place(value.get()).start);
            let (field, unit) = field(name).map_err(|message| (line, message))?;
            let mut add = |field: Field, value: &RawValue| {
                let raw = value.get();
                let at = place(raw);
                match serde_json::from_str::<String>(raw) {
                    Ok(text) => cells.push(Cell { field, unit, text, at: at.start + 1..at.end - 1 }),
                    Err(_) => cells.push(Cell { field, unit, text: raw.to_string(), at }),
                }
            };
            match field {
                Field::Comment => {}
                Field::Range => {
                    let Ok([least, greatest]) = serde_json::from_str::<[&RawValue; 2]>(value.get()) else {
                        return Err((
                            line,
                            format!(
                                "\"{name}\" is no list of two numbers: give the least and the \
                                                   greatest"
                            ),
                        ));
                    };
                    add(Field::Least, least);
                    add(Field::Greatest, greatest);
                }
                field => add(field, value),
            }
        }
        cells.sort_by_key(|cell| cell.at.start);
        rows.push(Row { line, cells, end });
    }
    Ok(Table { name: read.name, convention: read.convention, rows, header_end: None })
}

fn csv(text: &str) -> Result<Table, Fault> {
    let mut table = Table::default();
    let mut columns: Option<Vec<(Field, Option<Unit>)>> = None;
    let mut at = text_begins(text.as_bytes());
    while at < text.len() {
        let line = line_of(text.as_bytes(), at);
        let (cells, end, next) = record(text, at);
        let begin = std::mem::replace(&mut at, next);
        if text[begin..end].trim().is_empty() || text[begin..].starts_with('#') {
            continue;
        }
        let Some(columns) = &columns else {
            columns = Some(header(text, &cells).map_err(|message| (line, message))?);
            table.header_end = Some(end);
            continue;
        };
        if cells.len() != columns.len() {
            let message = format!(
                "it has {} cells in place of {}: give one for each column",
                cells.len(),
                columns.len()
            );
            return Err((line, message));
        }
        let cells = columns.iter().zip(cells).map(|((field, unit), at)| {
            let text = text[at.clone()].replace("\"\"", "\"");
            Cell { field: *field, unit: *unit, text, at }
        });
        table.rows.push(Row {
            line,
            cells: cells.filter(|cell| cell.field != Field::Comment).collect(),
            end,
        });
    }
    Ok(table)
}

/// The columns by the line that names them.
fn header(text: &str, cells: &[Range<usize>]) -> Result<Vec<(Field, Option<Unit>)>, String> {
    if let [only] = cells
        && let Some(separator) =
            [';', '\t'].into_iter().find(|separator| text[only.clone()].contains(*separator))
    {
        return Err(format!(
            "its columns are separated by {separator:?}: separate them by commas, and write decimals with a point"
        ));
    }
    let mut columns: Vec<(Field, Option<Unit>)> = Vec::new();
    for at in cells {
        let (field, unit) = field(&text[at.clone()]).map_err(|message| format!("column {message}"))?;
        if field == Field::Range {
            return Err("column \"range\": give min and max, a column each".into());
        }
        columns.push((field, unit));
    }
    let needed = [Field::Joint, Field::A, Field::D, Field::Alpha];
    match needed.into_iter().find(|field| !columns.iter().any(|(other, _)| other == field)) {
        Some(missing) => Err(format!(
            "there is no column {}: begin with a line of column names, joint, a, d, alpha and theta among them",
            missing.name()
        )),
        None => Ok(columns),
    }
}

/// The cells of the record that begins at a place, without blanks and quotes about them, the place where it ends, and that
/// where the next one begins.
fn record(text: &str, begin: usize) -> (Vec<Range<usize>>, usize, usize) {
    let mut quoted = false;
    let mut cells = Vec::new();
    let mut from = begin;
    let mut end = text.len();
    for (i, byte) in text.bytes().enumerate().skip(begin) {
        match byte {
            b'"' => quoted = !quoted,
            b',' if !quoted => {
                cells.push(from..i);
                from = i + 1;
            }
            b'\n' if !quoted => {
                end = i;
                break;
            }
            _ => {}
        }
    }
    let next = (end + 1).min(text.len());
    if end > from && text.as_bytes()[end - 1] == b'\r' {
        end -= 1;
    }
    cells.push(from..end);
    let bare = |at: Range<usize>| {
        let inside = &text[at.clone()];
        let begin = at.start + inside.len() - inside.trim_start().len();
        let inside = inside.trim();
        match inside.strip_prefix('"').and_then(|inside| inside.strip_suffix('"')) {
            Some(inside) => begin + 1..begin + 1 + inside.len(),
            None => begin..begin + inside.len(),
        }
    };
    (cells.into_iter().map(bare).collect(), end, next)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::table::DEGREES;

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
            ("PI", PI),
            ("-90°", -PI / 2.0),
            ("45 deg", PI / 4.0),
        ] {
            let found = printed(text).unwrap_or_else(|| panic!("{text} is read"));
            assert!((found - expected).abs() < 1e-15, "{text}: {found}");
        }
        for text in ["pie", "pi/", "*pi", "pi//2", "q1", "", "theta+pi", "1/2/x"] {
            assert_eq!(printed(text), None, "{text}");
        }
        let cell = |field, text: &str| Cell { field, unit: None, text: text.into(), at: 0..0 };
        assert_eq!(cell(Field::Alpha, " pi/2 ").si_number(), Some(PI / 2.0));
        assert_eq!(cell(Field::D, "pi/2").si_number(), None, "a length is no angle");
        assert_eq!(cell(Field::Alpha, "pi/0").si_number(), None);
    }

    #[test]
    fn names_say_fields_and_units() {
        for (name, expected, per) in [
            ("alpha", Field::Alpha, None),
            ("alpha_deg", Field::Alpha, Some(DEGREES)),
            ("Alpha [deg]", Field::Alpha, Some(DEGREES)),
            ("a (mm)", Field::A, Some(1000.0)),
            ("theta_offset_rad", Field::Theta, Some(1.0)),
            ("max(°)", Field::Greatest, Some(DEGREES)),
            ("ALPHA_DEG", Field::Alpha, Some(DEGREES)),
            ("thetaDeg", Field::Theta, Some(DEGREES)),
        ] {
            let (found, unit) = field(name).unwrap();
            assert_eq!((found, unit.map(|unit| unit.per)), (expected, per), "{name}");
        }
        for (name, expected) in [
            ("alpha_mm", "alpha has another unit: give rad or deg"),
            ("a [inch]", "its unit is not known: "),
            ("joint_mm", "joint has another unit: give no unit"),
            ("gamma", "\"gamma\" is none of joint, parent, "),
        ] {
            let message = field(name).unwrap_err();
            assert!(message.contains(expected), "{message}");
        }
    }

    #[test]
    fn cells_know_their_bytes() {
        let csv = "\u{feff}# Remark, of two cells\r\njoint , a,\"d\",alpha_deg\r\n\r\n \"j, 1\", 0.10 ,\"2\",90\r\n";
        let json = "{\"joints\": [\n {\"joint\": \"j, 1\", \"a\": 0.10, \"d\": \"2\", \"alpha_deg\": 90}]}";
        for (text, line) in [(csv, 4), (json, 2)] {
            let table = table(text.as_bytes()).unwrap();
            let row = &table.rows[0];
            assert_eq!(row.line, line);
            let found: Vec<&str> = row.cells.iter().map(|cell| &text[cell.at.clone()]).collect();
            assert_eq!(found, ["j, 1", "0.10", "2", "90"]);
            assert!(
                text[row.end..].starts_with("\r\n") || text[row.end..].starts_with('}'),
                "{:?}",
                &text[row.end..]
            );
        }
    }
}
