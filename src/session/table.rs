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

use super::files;
use super::json_lines::{drop_zeros, incomplete};
use super::touch_reader::check_header;
use crate::creature::Creature;
use crate::error::{Error, json_reason};

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
const MARK: [u8; 3] = [0xef, 0xbb, 0xbf];

/// What a number measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Measure {
    Length,
    Angle,
}

impl Measure {
    /// As a noun, and the units that a column may have.
    fn in_words(self) -> (&'static str, &'static str) {
        match self {
            Measure::Length => ("a length", "m, cm or mm"),
            Measure::Angle => ("an angle", "rad or deg"),
        }
    }
}

/// The unit that a column's title says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unit {
    /// What it measures.
    pub measure: Measure,
    /// How many of it make a metre or a radian.
    pub per: f64,
}

/// Degrees in a radian.
pub(crate) const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// Units by their words in small letters, what they measure, and how many make a metre or a radian.
const UNITS: [(&[&str], Measure, f64); 6] = [
    (&["m", "meter", "meters", "metre", "metres"], Measure::Length, 1.0),
    (&["cm", "centimeter", "centimeters", "centimetre", "centimetres"], Measure::Length, 100.0),
    (&["mm", "millimeter", "millimeters", "millimetre", "millimetres"], Measure::Length, 1000.0),
    (&["rad", "rads", "radian", "radians"], Measure::Angle, 1.0),
    (&["mrad"], Measure::Angle, 1000.0),
    (&["deg", "degs", "degree", "degrees", "°", "º"], Measure::Angle, DEGREES),
];
/// Bytes of a unit at most, with what is around it.
const LONGEST_UNIT: usize = 40;
/// What may stand between a name and its unit.
const SEPARATORS: [char; 6] = [' ', '_', '-', '.', '/', ','];
/// Brackets that a unit may stand in.
const BRACKETS: [(char, char); 4] = [('[', ']'), ('(', ')'), ('{', '}'), ('<', '>')];

/// The unit of a word, in any spelling.
pub(crate) fn unit(word: &str) -> Option<Unit> {
    let word = word.trim().trim_end_matches('.').to_lowercase();
    let (_, measure, per) = *UNITS.iter().find(|(words, ..)| words.contains(&word.as_str()))?;
    Some(Unit { measure, per })
}

/// A title's name and the unit behind it, as in `elbow_deg`, `elbow [Deg]`, `elbowDeg` or `ax / mm`; of a unit in brackets
/// that is not known the word.
pub(crate) fn name_and_unit(title: &str) -> Option<(&str, Result<Unit, &str>)> {
    // A unit is short, and a title may be a whole file.
    let begin = title.len().saturating_sub(LONGEST_UNIT);
    title.char_indices().skip(1).filter(|(at, _)| *at >= begin).find_map(|(at, first)| {
        let (name, rest) = title.split_at(at);
        let word = rest.trim_start_matches(SEPARATORS);
        let inside = BRACKETS.iter().find_map(|(open, close)| word.strip_prefix(*open)?.strip_suffix(*close));
        if let Some(inside) = inside {
            return Some((name, unit(inside).ok_or(inside)));
        }
        let humped = first.is_uppercase() && !name.ends_with(char::is_uppercase);
        let apart = word.len() < rest.len() || humped || first == '°';
        let word = word.strip_prefix("in ").unwrap_or(word);
        unit(word).filter(|_| apart).map(|unit| (name, Ok(unit)))
    })
}

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
pub(crate) struct Table {
    /// The line that the names are on.
    pub line: usize,
    pub columns: Vec<Column>,
    pub rows: Vec<(usize, StringRecord)>,
    /// The last line, if it ends in the middle and is left out.
    pub cut: Option<usize>,
    /// Whether it was JSON, where columns have names alone.
    is_json: bool,
    /// What looks odd about the file, in sentences.
    pub notes: Vec<String>,
}

impl Table {
    /// Which column holds each of some quantities; none where no one does. Their units are known from then on.
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
                    return refuse(format!("the unit {word} is not known: give {units}"));
                }
                (Err(_), None) => None,
            };
            (places[k], self.columns[at].unit) = (Some(at), unit);
        }
        Ok(places)
    }

    /// The titles of columns that are none of these.
    pub fn spare(&self, used: &[usize]) -> Vec<&Column> {
        let spare = self.columns.iter().enumerate().filter(|(at, _)| !used.contains(at));
        spare.map(|(_, column)| column).filter(|column| !column.title.is_empty()).collect()
    }

    /// What worth a note is: of the file, and that its last line is left out.
    pub fn notes(&self) -> impl Iterator<Item = String> + use<> {
        let cut = self.cut.map(|line| {
            format!("it ends in the middle of line {line}: that touch is left out, all before it are used")
        });
        self.notes.clone().into_iter().chain(cut)
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
            Err(_) => Err(CellFault::Wrong(format!("{place}: \"{cell}\" is no number: give {needed}"))),
        }
    }
}

/// Reads a table. `coordinates` are the columns of a posture that JSON gives as a list; the header of a session's log must be of
/// the `creature`, if one is given.
pub(crate) fn read_table(
    path: &Path,
    coordinates: &[String],
    creature: Option<&Creature>,
) -> Result<Table, Error> {
    let (bytes, notes) = read_text(path)?;
    let table = match bytes.trim_ascii_start().first() {
        Some(b'{' | b'[') => read_json(path, &bytes, coordinates, creature)?,
        _ => read_separated(path, &bytes)?,
    };
    Ok(Table { notes, ..table })
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
                return refused("unpacked it is larger than 4 GiB".into());
            }
            Ok(_) => {}
            // As it is while it is being written.
            Err(error) if error.kind() == ErrorKind::UnexpectedEof && !plain.is_empty() => notes
                .push("it was packed by gzip and ends in the middle: what can be unpacked is used".into()),
            Err(error) => return refused(format!("it is packed by gzip and cannot be read ({error})")),
        }
        bytes = plain;
    }
    let zeros = drop_zeros(&mut bytes);
    if let Some(text) = utf_16(&bytes) {
        bytes = text.into_bytes();
    } else if zeros > 0 {
        notes.push(format!("it ends in {zeros} zero bytes, as after a power failure: they are left out"));
    }
    if bytes.starts_with(&MARK) {
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
    // The last character's zero byte may be gone.
    let pair = |pair: &[u8]| of([pair[0], pair.get(1).copied().unwrap_or_default()]);
    let units: Vec<u16> = bytes[2..].chunks(2).map(pair).collect();
    Some(String::from_utf16_lossy(&units))
}

/// Reads objects of JSON, one after the other or in a list. Every name in one of them is a column.
fn read_json(
    path: &Path,
    bytes: &[u8],
    coordinates: &[String],
    creature: Option<&Creature>,
) -> Result<Table, Error> {
    let bytes = &with_null(bytes);
    let refuse = |line: usize, fault: String| Err(Error::content(path, Some(line), fault));
    let begin = bytes.len() - bytes.trim_ascii_start().len();
    let list = bytes[begin..].starts_with(b"[");
    let between = |byte: &u8| byte.is_ascii_whitespace() || list && *byte == b',';
    let (mut at, mut line) = (begin + usize::from(list), 1 + newlines(&bytes[..begin]));
    let mut table =
        Table { line, columns: Vec::new(), rows: Vec::new(), cut: None, is_json: true, notes: Vec::new() };
    // The column of each title, and the objects with the lines that they begin on.
    let (mut places, mut objects) = (HashMap::new(), Vec::new());
    while let Some(blank) = bytes[at..].iter().position(|byte| !between(byte)) {
        line += newlines(&bytes[at..at + blank]);
        at += blank;
        if list && bytes[at] == b']' {
            break;
        }
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
                let fault = format!("it is no touch ({}): mend the line or delete it", json_reason(&error));
                return refuse(line + error.line().saturating_sub(1), fault);
            }
        }
        line += newlines(json);
        at += json.len();
    }
    table.line = objects.first().map_or(table.line, |(line, _)| *line);
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
        plain.extend_from_slice(if word.is_some() {
            b"null"
        } else {
            &bytes[at..bytes.len().min(at + taken)]
        });
        at += taken;
    }
    Cow::Owned(plain)
}

/// The cells of an object, each with its column.
fn cells(touch: &Value, coordinates: &[String]) -> Result<Vec<(String, String)>, String> {
    let Value::Object(fields) = touch else {
        return Err("it is no touch, which is an object: mend the line or delete it".into());
    };
    let mut cells = Vec::new();
    for (field, value) in fields {
        match (field.as_str(), value) {
            // Where receptors are is known from the skin; what is null is not given.
            ("positions", _) | (_, Value::Null) => {}
            ("posture", Value::Array(numbers)) => {
                if numbers.len() != coordinates.len() {
                    return Err(format!(
                        "posture has {} numbers in place of {}: give one for each coordinate, in their order, or an object of \
                         names",
                        numbers.len(),
                        coordinates.len()
                    ));
                }
                add(&mut cells, coordinates, numbers)?;
            }
            ("posture", Value::Object(named)) => {
                for (name, value) in named {
                    match value {
                        Value::Array(quaternion) if quaternion.len() == QUATERNION.len() => {
                            add(&mut cells, &QUATERNION.map(|end| format!("{name}{end}")), quaternion)?;
                        }
                        value => add(&mut cells, &[name], [value])?,
                    }
                }
            }
            ("posture", _) => {
                let what = "posture is neither a list of numbers nor an object of names: give one of the two";
                return Err(what.into());
            }
            ("limbs", Value::Array(names)) if names.len() == 2 => add(&mut cells, &LIMBS, names)?,
            ("receptors", Value::Array(names)) if names.len() == 2 => add(&mut cells, &RECEPTORS, names)?,
            ("deviations", Value::Array(numbers)) if numbers.len() == 2 => {
                let given = DEVIATIONS.iter().zip(numbers).filter(|(_, number)| !number.is_null());
                given.into_iter().try_for_each(|(title, number)| add(&mut cells, &[title], [number]))?;
            }
            ("contacts", Value::Array(points)) if points.len() == 2 => {
                for (titles, point) in POINTS.iter().zip(points) {
                    let point = point.as_array().filter(|point| point.len() == 3);
                    let point = point.ok_or("contacts are not two points of three coordinates: give them")?;
                    add(&mut cells, titles, point)?;
                }
            }
            (_, value) => add(&mut cells, &[field], [value])?,
        }
    }
    Ok(cells)
}

/// Adds a cell for each of some columns. JSON has no other way to say "not a finite number" than null.
fn add<'v>(
    cells: &mut Vec<(String, String)>,
    titles: &[impl AsRef<str>],
    values: impl IntoIterator<Item = &'v Value>,
) -> Result<(), String> {
    for (title, value) in titles.iter().map(AsRef::as_ref).zip(values) {
        let cell = match value {
            Value::Null => f64::NAN.to_string(),
            Value::String(text) => text.clone(),
            Value::Number(number) => number.to_string(),
            _ => {
                return Err(format!(
                    "{title} is neither a number nor a text: give posture, limbs, contacts, receptors, deviations, or columns by \
                     their names"
                ));
            }
        };
        cells.push((title.to_string(), cell));
    }
    Ok(())
}

/// Reads a table whose first line has the columns' names; they are separated by commas, tabs or semicolons. Lines that hold
/// nothing are left out.
pub(crate) fn read_separated(path: &Path, bytes: &[u8]) -> Result<Table, Error> {
    let refuse = |line: usize, message: String| Error::content(path, Some(line), message);
    let text = bytes.trim_ascii_start();
    if text.starts_with(b"<") {
        return Err(refuse(
            1,
            "it is XML, where a table of touches belongs: give the robot first and then the log as comma-separated values".into(),
        ));
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
    let mut record = StringRecord::new();
    let mut table: Option<Table> = None;
    loop {
        match reader.read_record(&mut record) {
            Ok(true) => {}
            Ok(false) => break,
            Err(error) => {
                let line = error.position().map_or(0, csv::Position::line) as usize;
                return Err(refuse(line, format!("it is no text in UTF-8 ({error}): save the file as such")));
            }
        }
        let line = line_of(&record, bytes);
        if record.iter().all(str::is_empty) {
            continue;
        }
        match &mut table {
            None => {
                let columns = head(&record).map_err(|fault| refuse(line, fault))?;
                let rows = Vec::new();
                table = Some(Table { line, columns, rows, cut: None, is_json: false, notes: Vec::new() })
            }
            Some(table) if record.len() == table.columns.len() => {
                // Where semicolons separate, commas are decimal points.
                let row = if separator == b';' { pointed(&record) } else { record.clone() };
                table.rows.push((line, row));
            }
            Some(table) if line == unended && !table.rows.is_empty() => table.cut = Some(line),
            Some(table) => {
                return Err(refuse(
                    line,
                    format!(
                        "it has {} cells in place of {}: give one for each column",
                        record.len(),
                        table.columns.len()
                    ),
                ));
            }
        }
    }
    table.ok_or_else(|| {
        refuse(1, "it holds no touch, for there is no line of column names: begin with one".into())
    })
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
    if !columns.is_empty() && columns.iter().all(|column| column.title.parse::<f64>().is_ok()) {
        return Err("its first line has numbers, no names of columns: begin with a line of names".into());
    }
    for (i, column) in columns.iter().enumerate().filter(|(_, column)| !column.title.is_empty()) {
        if columns[..i].iter().any(|other| other.title == column.title) {
            return Err(format!(
                "column {}, {}: it occurs twice: leave one of them out",
                i + 1,
                column.title
            ));
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
    fn units_are_read_in_any_spelling() {
        for title in [
            "elbow_deg",
            "elbow [deg]",
            "elbow (deg)",
            "elbow[°]",
            "elbow [Deg]",
            "elbow_DEG",
            "elbow (Degrees)",
            "elbowDeg",
            "elbow°",
            "elbow / deg",
            "elbow, deg.",
            "elbow-degree",
            "elbow {deg}",
            "elbow in deg",
            "elbow_[deg]",
            "elbow deg",
        ] {
            let unit = Unit { measure: Measure::Angle, per: DEGREES };
            assert_eq!(name_and_unit(title), Some(("elbow", Ok(unit))), "{title}");
        }
        for (title, per) in
            [("ax_mm", 1000.0), ("ax [MM]", 1000.0), ("ax (Cm)", 100.0), ("axMM", 1000.0), ("ax/metres", 1.0)]
        {
            let unit = Unit { measure: Measure::Length, per };
            assert_eq!(name_and_unit(title), Some(("ax", Ok(unit))), "{title}");
        }
        assert_eq!(name_and_unit("elbow [grad]"), Some(("elbow", Err("grad"))));
        for title in ["elbow", "left_arm", "m", "deg", "ARM", "alarm"] {
            assert_eq!(name_and_unit(title), None, "{title}");
        }
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
        assert_eq!(unit.columns[0].unit.map(|unit| unit.per), Some(DEGREES));
        assert_eq!(unit.spare(&[0])[0].title, "thumb_cm_rad");
    }
}
