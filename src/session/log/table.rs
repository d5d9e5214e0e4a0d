//! Tables of touches and of postures, as people have them: comma-separated values or JSON, packed by gzip or not.
//!
//! A table has a line of column names, then a touch a line; columns are separated by commas, tabs or semicolons. JSON has a touch
//! a line, or a list of them, each an object: `posture` by names or as a list, `limbs`, `receptors`, `contacts` and `deviations`
//! as in a session's log, and any column by its name.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::{ErrorKind, Read};
use std::path::Path;

use csv::{ReaderBuilder, StringRecord};
use flate2::read::MultiGzDecoder;
use serde_json::Value;
use serde_json::value::RawValue;

use super::units::{Measure, Unit, name_and_unit};
use crate::creature::Creature;
use crate::error::{Error, json_reason};
use crate::session::files;
use crate::session::stamp::{drop_zeros, incomplete};
use crate::session::touch_log::check_header;

/// The columns of limbs, receptors and points of contact, side a then side b.
pub(crate) const LIMBS: [&str; 2] = ["limb_a", "limb_b"];
pub(crate) const RECEPTORS: [&str; 2] = ["receptor_a", "receptor_b"];
pub(crate) const POINTS: [[&str; 3]; 2] = [["ax", "ay", "az"], ["bx", "by", "bz"]];
/// The columns of the standard deviations of the points' coordinates.
pub(crate) const DEVIATIONS: [&str; 2] = ["a_std", "b_std"];
/// The ends of the names of the columns of a ball's quaternion.
pub(crate) const QUATERNION: [&str; 4] = ["_w", "_x", "_y", "_z"];
/// The first bytes of a file that gzip packed.
const PACKED: [u8; 2] = [0x1f, 0x8b];
/// Greatest bytes of a table that is unpacked: a few packed bytes may stand for very many.
const GREATEST_TABLE: u64 = 4 << 30;
/// The mark that some programs put before text in UTF-8.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// What a column may hold: what it is called, and what its numbers measure; none of texts, counts and quaternions.
pub(crate) type Quantity<'a> = (&'a str, Option<Measure>);

/// A column.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Column {
    /// As the file has it.
    pub title: String,
    /// The unit of what it holds; none for metres and radians, and before that is known.
    pub unit: Option<Unit>,
}

impl Column {
    fn new(title: &str) -> Column {
        Column { title: title.trim().trim_start_matches('\u{feff}').to_string(), unit: None }
    }

    /// Its title without a unit.
    pub fn name(&self) -> &str {
        name_and_unit(&self.title).map_or(&self.title, |(name, _)| name)
    }

    /// Whether its numbers are taken for metres or radians as they stand.
    pub fn is_si(&self) -> bool {
        self.unit.is_none_or(|unit| unit.per == 1.0)
    }
}

/// Why a cell's number cannot be used.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum CellFault {
    /// It is NaN or infinite, as sensors and programs say that there is none.
    NotFinite(String),
    /// Anything else.
    Wrong(String),
}

/// A table: its columns, and its rows with the lines that they are on.
#[derive(Default)]
pub(crate) struct Table {
    /// The line that the names are on.
    pub line: usize,
    pub columns: Vec<Column>,
    /// Columns by the quantities that they hold, as far as these were assigned.
    places: HashMap<String, usize>,
    pub rows: Vec<(usize, StringRecord)>,
    /// The last line, if it ends in the middle and is left out.
    pub cut: Option<usize>,
    /// Whether it was JSON, where columns have names alone.
    is_json: bool,
}

impl Table {
    /// Which column holds each of some quantities; `None` if no one does. Their units are known from then on.
    ///
    /// A title that is exactly a quantity's name counts before one with a unit behind it.
    pub fn assign(&mut self, wanted: &[Quantity]) -> Result<Vec<Option<usize>>, String> {
        let titled = |name: &str| self.columns.iter().position(|column| column.title == name);
        let mut places: Vec<Option<usize>> = wanted.iter().map(|(name, _)| titled(name)).collect();
        for (k, (wanted, measure)) in wanted.iter().enumerate() {
            let free = |at: &usize| places[k].is_none() && !places.contains(&Some(*at));
            let found = (0..self.columns.len()).filter(free).find_map(|at| {
                let (name, unit) = name_and_unit(&self.columns[at].title)?;
                (name == *wanted).then_some((at, unit))
            });
            let Some((at, unit)) = found else { continue };
            let refuse = |why: String| Err(format!("column \"{}\": {why}", self.columns[at].title));
            let unit = match (unit, measure.map(|measure| (measure, measure.in_words()))) {
                (Ok(unit), Some((measure, _))) if unit.measure == measure => Some(unit),
                (Ok(_), Some((_, (noun, units)))) => {
                    return refuse(format!("{wanted} is {noun}: give it in {units}"));
                }
                (Ok(_), None) => return refuse(format!("{wanted} has no unit: rename it")),
                (Err(word), Some((_, (_, units)))) => {
                    return refuse(format!("unknown unit {word}: give {units}"));
                }
                (Err(_), None) => None,
            };
            (places[k], self.columns[at].unit) = (Some(at), unit);
        }
        let found = wanted.iter().zip(&places).filter_map(|((name, _), at)| Some((name.to_string(), (*at)?)));
        self.places.extend(found);
        Ok(places)
    }

    /// The column that holds a quantity.
    pub fn at(&self, name: &str) -> Option<usize> {
        self.places.get(name).copied()
    }

    /// Whether a column holds a quantity.
    pub fn has(&self, name: &str) -> bool {
        self.at(name).is_some()
    }

    /// The column that holds a quantity, if its cell in a row is not empty.
    pub fn given(&self, row: &StringRecord, name: &str) -> Option<usize> {
        self.at(name).filter(|at| row.get(*at).is_some_and(|cell| !cell.is_empty()))
    }

    /// What a row has of a quantity, if its cell is not empty.
    pub fn text<'r>(&self, row: &'r StringRecord, name: &str) -> Option<&'r str> {
        self.given(row, name).map(|at| &row[at])
    }

    /// The columns with a title that hold none of the quantities that were assigned.
    pub fn spare(&self) -> impl Iterator<Item = &Column> {
        let unused = |at: &usize| self.places.values().all(|used| used != at);
        let spare = (0..self.columns.len()).filter(unused).map(|at| &self.columns[at]);
        spare.filter(|column| !column.title.is_empty())
    }

    /// A column, as messages call it.
    pub fn place(&self, at: usize) -> String {
        let title = &self.columns[at].title;
        if self.is_json { title.clone() } else { format!("column {}, {title}", at + 1) }
    }

    /// The number in a cell, metres or radians where it has a unit; `needed` says what is to be given.
    pub fn number(&self, row: &StringRecord, at: usize, needed: &str) -> Result<f64, CellFault> {
        let (cell, place) = (&row[at], self.place(at));
        if cell.is_empty() {
            let message = format!("{place}: it is empty: give {needed}, or leave the touch out");
            return Err(CellFault::Wrong(message));
        }
        match cell.parse::<f64>() {
            Ok(number) if number.is_finite() => {
                Ok(self.columns[at].unit.map_or(number, |unit| number / unit.per))
            }
            Ok(_) => Err(CellFault::NotFinite(format!("{place}: {cell} is not finite"))),
            Err(_) => Err(CellFault::Wrong(format!("{place}: \"{cell}\" is not a number: give {needed}"))),
        }
    }
}

/// Reads a table, and tells what is worth a note about the file. `coordinates` are the columns of a posture that JSON gives as a
/// list; the header of a session's log must be of the `creature`, if one is given.
pub(crate) fn read_table(
    path: &Path,
    coordinates: &[String],
    creature: Option<&Creature>,
) -> Result<(Table, Vec<String>), Error> {
    let (bytes, mut notes) = read_text(path)?;
    let table = match bytes.trim_ascii_start().first() {
        Some(b'{' | b'[') => read_json(path, &with_null(&bytes), coordinates, creature)?,
        _ => read_separated(path, &bytes)?,
    };
    notes.extend(table.cut.map(|line| {
        format!("it ends in the middle of line {line}; that touch is ignored, all before it are used")
    }));
    Ok((table, notes))
}

/// The text of a file in UTF-8, unpacked and without a mark before it; and what is worth a note.
fn read_text(path: &Path) -> Result<(Vec<u8>, Vec<String>), Error> {
    let mut bytes = files::read(path)?;
    let mut notes = Vec::new();
    if bytes.starts_with(&PACKED) {
        let mut plain = Vec::new();
        let refused = |what: String| Err(Error::content(path, None, format!("{what}: unpack it first")));
        match MultiGzDecoder::new(&bytes[..]).take(GREATEST_TABLE + 1).read_to_end(&mut plain) {
            Ok(_) if plain.len() as u64 > GREATEST_TABLE => {
                return refused("it is larger than 4 GiB when decompressed".into());
            }
            Ok(_) => {}
            // As it is while it is being written.
            Err(error) if error.kind() == ErrorKind::UnexpectedEof && !plain.is_empty() => {
                notes.push("the gzip file is truncated; what can be decompressed is used".into())
            }
            Err(error) => return refused(format!("the gzip file cannot be read ({error})")),
        }
        bytes = plain;
    }
    if let Some(text) = utf_16(&bytes) {
        bytes = text.into_bytes();
    }
    let zeros = drop_zeros(&mut bytes);
    if zeros > 0 {
        notes.push(format!("it ends in {zeros} zero bytes, as after a power failure; they are ignored"));
    }
    if bytes.starts_with(MARK) {
        bytes.drain(..MARK.len());
    }
    Ok((bytes, notes))
}

/// The text of bytes in UTF-16, as spreadsheets write it.
fn utf_16(bytes: &[u8]) -> Option<String> {
    let of: fn([u8; 2]) -> u16 = match bytes {
        [0xff, 0xfe, ..] => u16::from_le_bytes,
        [0xfe, 0xff, ..] => u16::from_be_bytes,
        _ => return None,
    };
    let units: Vec<u16> = bytes[2..].chunks_exact(2).map(|pair| of([pair[0], pair[1]])).collect();
    Some(String::from_utf16_lossy(&units))
}

/// Reads objects of JSON, one after the other or in a list. Every name in one of them is a column.
fn read_json(
    path: &Path,
    bytes: &[u8],
    coordinates: &[String],
    creature: Option<&Creature>,
) -> Result<Table, Error> {
    let refuse = |line: usize, fault: String| Err(Error::content(path, Some(line), fault));
    let list = bytes.trim_ascii_start().starts_with(b"[");
    let between = |byte: &u8| byte.is_ascii_whitespace() || list && b"[,]".contains(byte);
    let (mut at, mut line) = (0, 1);
    let mut table = Table { is_json: true, ..Table::default() };
    // The objects with the lines that they begin on.
    let mut objects = Vec::new();
    while let Some(blank) = bytes[at..].iter().position(|byte| !between(byte)) {
        line += newlines(&bytes[at..at + blank]);
        at += blank;
        let json = value(&bytes[at..]);
        match serde_json::from_slice::<Value>(json) {
            Ok(found) if objects.is_empty() && found.get("format").is_some() => {
                creature.map_or(Ok(()), |creature| check_header(path, json, line, creature))?;
            }
            Ok(found) => match cells(&found, coordinates) {
                Ok(cells) => objects.push((line, cells)),
                Err(fault) => return refuse(line, fault),
            },
            Err(error)
                if at + json.len() == bytes.len() && !objects.is_empty() && incomplete(json, &error) =>
            {
                table.cut = Some(line);
            }
            Err(error) => {
                let fault = format!("not a touch ({}): correct the line or delete it", json_reason(&error));
                return refuse(line + error.line().saturating_sub(1), fault);
            }
        }
        line += newlines(json);
        at += json.len();
    }
    table.line = objects.first().map_or(1, |(line, _)| *line);
    let mut places = HashMap::new();
    for (title, _) in objects.iter().flat_map(|(_, cells)| cells) {
        if !places.contains_key(title) {
            places.insert(title.clone(), table.columns.len());
            table.columns.push(Column::new(title));
        }
    }
    for (line, cells) in objects {
        let mut row = vec![String::new(); table.columns.len()];
        cells.into_iter().for_each(|(title, cell)| row[places[&title]] = cell);
        table.rows.push((line, StringRecord::from(row)));
    }
    Ok(table)
}

fn newlines(bytes: &[u8]) -> usize {
    bytes.iter().filter(|&&byte| byte == b'\n').count()
}

/// The JSON that bytes begin with, however many lines it has, or all of them if they end in it; if it is none, the line.
fn value(bytes: &[u8]) -> &[u8] {
    let mut values = serde_json::Deserializer::from_slice(bytes).into_iter::<&RawValue>();
    match values.next() {
        Some(Ok(raw)) => &bytes[..raw.get().len()],
        Some(Err(error)) if error.is_eof() => bytes,
        _ => bytes.split_inclusive(|&byte| byte == b'\n').next().unwrap_or(bytes),
    }
}

/// The same JSON with null for NaN and Infinity, as Python writes them. They are longer or as long, and lines stay.
fn with_null(bytes: &[u8]) -> Cow<'_, [u8]> {
    const WORDS: [&[u8]; 3] = [b"NaN", b"-Infinity", b"Infinity"];
    if !WORDS.iter().any(|word| bytes.windows(word.len()).any(|window| window == *word)) {
        return Cow::Borrowed(bytes);
    }
    let (mut plain, mut at, mut quoted) = (Vec::with_capacity(bytes.len()), 0, false);
    while let Some(&byte) = bytes.get(at) {
        let word = WORDS.iter().find(|word| !quoted && bytes[at..].starts_with(word));
        let taken = word.map_or(1, |word| word.len()).max(1 + usize::from(quoted && byte == b'\\'));
        quoted ^= byte == b'"';
        let end = bytes.len().min(at + taken);
        plain.extend_from_slice(if word.is_some() { b"null" } else { &bytes[at..end] });
        at = end;
    }
    Cow::Owned(plain)
}

/// The cells of an object, each with its column. JSON has no other way to say "not a finite number" than null.
fn cells(touch: &Value, coordinates: &[String]) -> Result<Vec<(String, String)>, String> {
    let Value::Object(fields) = touch else {
        return Err("not a touch, which is an object: correct the line or delete it".into());
    };
    let mut cells: Vec<(String, &Value)> = Vec::new();
    for (field, value) in fields {
        let list = value.as_array().map_or(&[][..], Vec::as_slice);
        match (field.as_str(), value) {
            // Where receptors are is known from the skin; what is null is not given.
            ("positions", _) | (_, Value::Null) => {}
            ("posture", Value::Array(_)) if list.len() == coordinates.len() => {
                cells.extend(coordinates.iter().cloned().zip(list));
            }
            ("posture", Value::Array(_)) => {
                return Err(format!(
                    "posture has {} numbers instead of {}: give one for each coordinate, in order, or an object with names",
                    list.len(),
                    coordinates.len()
                ));
            }
            ("posture", Value::Object(named)) => {
                for (name, value) in named {
                    match value.as_array().filter(|quaternion| quaternion.len() == QUATERNION.len()) {
                        Some(quaternion) => {
                            cells.extend(
                                QUATERNION.map(|end| format!("{name}{end}")).into_iter().zip(quaternion),
                            );
                        }
                        None => cells.push((name.clone(), value)),
                    }
                }
            }
            ("posture", _) => {
                let what = "posture is neither a list of numbers nor an object with names: give one of these";
                return Err(what.into());
            }
            ("limbs", _) if list.len() == 2 => cells.extend(LIMBS.map(String::from).into_iter().zip(list)),
            ("receptors", _) if list.len() == 2 => {
                cells.extend(RECEPTORS.map(String::from).into_iter().zip(list));
            }
            ("deviations", _) if list.len() == 2 => {
                let given = DEVIATIONS.map(String::from).into_iter().zip(list);
                cells.extend(given.filter(|(_, number)| !number.is_null()));
            }
            ("contacts", _) if list.len() == 2 => {
                for (titles, point) in POINTS.iter().zip(list) {
                    let point = point.as_array().filter(|point| point.len() == 3);
                    let point = point.ok_or("contacts are not two points of three coordinates: give both")?;
                    cells.extend(titles.map(String::from).into_iter().zip(point));
                }
            }
            _ => cells.push((field.clone(), value)),
        }
    }
    let text = |(title, value): (String, &Value)| match value {
        Value::Null => Ok((title, f64::NAN.to_string())),
        Value::String(text) => Ok((title, text.clone())),
        Value::Number(number) => Ok((title, number.to_string())),
        _ => Err(format!(
            "{title} is neither a number nor a string: give posture, limbs, contacts, receptors, deviations, or \
             columns by name"
        )),
    };
    cells.into_iter().map(text).collect()
}

/// Reads a table whose first line has the columns' names; they are separated by commas, tabs or semicolons. Lines that hold
/// nothing are left out.
pub(crate) fn read_separated(path: &Path, bytes: &[u8]) -> Result<Table, Error> {
    let refuse = |line: usize, message: String| Err(Error::content(path, Some(line), message));
    if bytes.trim_ascii_start().starts_with(b"<") {
        let message = "it is XML, not a table of touches: give the robot first, then the log as CSV";
        return refuse(1, message.into());
    }
    let separator = separator(bytes);
    // Of a log that is being written the last line may be there in part.
    let unended = 1 + newlines(bytes);
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .delimiter(separator)
        .trim(csv::Trim::All)
        .from_reader(bytes);
    let mut table = Table::default();
    for record in reader.records() {
        let record = match record {
            Ok(record) => record,
            Err(error) => {
                let line = error.position().map_or(0, csv::Position::line) as usize;
                return refuse(line, format!("it is not UTF-8 text ({error}): save the file as UTF-8"));
            }
        };
        let line = line_of(&record, bytes);
        let (cells, wanted) = (record.len(), table.columns.len());
        match () {
            () if record.iter().all(str::is_empty) => {}
            () if wanted == 0 => {
                table.columns = head(&record).map_err(|fault| Error::content(path, Some(line), fault))?;
                table.line = line;
            }
            // Where semicolons separate, commas are decimal points.
            () if cells == wanted && separator == b';' => table.rows.push((line, pointed(&record))),
            () if cells == wanted => table.rows.push((line, record)),
            () if line == unended && !table.rows.is_empty() => table.cut = Some(line),
            () => {
                let message = format!("it has {cells} cells instead of {wanted}: give one for each column");
                return refuse(line, message);
            }
        }
    }
    if table.columns.is_empty() {
        let message = "it contains no touches and no header: begin with a line of column names";
        return refuse(1, message.into());
    }
    Ok(table)
}

/// What separates the columns: what there is most of in the first line that holds anything.
fn separator(bytes: &[u8]) -> u8 {
    let mut lines = bytes.split(|&byte| byte == b'\n');
    let head =
        lines.find(|line| !line.trim_ascii().is_empty() && !line.starts_with(b"#")).unwrap_or_default();
    let number = |separator: u8| head.iter().filter(|&&byte| byte == separator).count();
    // Of as many the last counts.
    [b';', b'\t', b','].into_iter().max_by_key(|separator| number(*separator)).unwrap_or(b',')
}

/// A row with points for decimal commas.
fn pointed(row: &StringRecord) -> StringRecord {
    let number = |cell: &str| Some(cell.replacen(',', ".", 1)).filter(|cell| cell.parse::<f64>().is_ok());
    row.iter().map(|cell| number(cell).unwrap_or_else(|| cell.to_string())).collect()
}

/// The line on which a record begins, from 1. The reader counts from where it began to look, blank lines and
/// comments before the record included.
fn line_of(record: &StringRecord, bytes: &[u8]) -> usize {
    let Some(position) = record.position() else { return 1 };
    let rest = &bytes[(position.byte() as usize).min(bytes.len())..];
    let skipped = rest
        .split(|&byte| byte == b'\n')
        .take_while(|line| line.trim_ascii().is_empty() || line.starts_with(b"#"))
        .count();
    position.line() as usize + skipped
}

fn head(record: &StringRecord) -> Result<Vec<Column>, String> {
    let columns: Vec<Column> = record.iter().map(Column::new).collect();
    if columns.iter().all(|column| column.title.parse::<f64>().is_ok()) {
        return Err("its first line contains numbers instead of column names: begin with a header".into());
    }
    for (i, column) in columns.iter().enumerate().filter(|(_, column)| !column.title.is_empty()) {
        if columns[..i].iter().any(|other| other.title == column.title) {
            let title = &column.title;
            return Err(format!("column {}, {title}: it occurs twice: leave one of them out", i + 1));
        }
    }
    Ok(columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(head: &str) -> Table {
        read_separated(Path::new("log.csv"), head.as_bytes()).unwrap()
    }

    #[test]
    fn a_name_as_it_stands_counts_before_one_with_a_unit() {
        let angle = Some(Measure::Angle);
        // A thumb's carpometacarpal joint, beside a thumb.
        let mut both = table("thumb_cm,thumb\n");
        assert_eq!(both.assign(&[("thumb", angle), ("thumb_cm", angle)]), Ok(vec![Some(1), Some(0)]));
        assert!(both.columns.iter().all(|column| column.unit.is_none()));
        // What is another's own name is nobody's with a unit.
        assert_eq!(
            table("thumb_cm\n").assign(&[("thumb", angle), ("thumb_cm", angle)]),
            Ok(vec![None, Some(0)])
        );
        // The joint's own name ends as a unit, and there is a unit behind it.
        let mut unit = table("thumb_cm_deg,thumb_cm_rad\n");
        assert_eq!(unit.assign(&[("thumb_cm", angle)]), Ok(vec![Some(0)]));
        assert_eq!(unit.columns[0].unit.map(|unit| unit.measure), angle);
        assert_eq!(unit.spare().next().unwrap().title, "thumb_cm_rad");
    }
}
