//! A table's head: what each column holds, and in which unit. Every table that is read here is read by it.

use std::path::Path;

use csv::{ReaderBuilder, StringRecord};

use crate::session::RecordError;

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
/// What may stand between a name and its unit.
const SEPARATORS: [char; 6] = [' ', '_', '-', '.', '/', ','];
/// Brackets that a unit may stand in.
const BRACKETS: [(char, char); 4] = [('[', ']'), ('(', ')'), ('{', '}'), ('<', '>')];

/// The unit of a word, in any spelling.
fn unit(word: &str) -> Option<Unit> {
    let word = word.trim().trim_end_matches('.').to_lowercase();
    let (_, measure, per) = *UNITS.iter().find(|(words, ..)| words.contains(&word.as_str()))?;
    Some(Unit { measure, per })
}

/// A title's name and the unit behind it, as in `elbow_deg`, `elbow [Deg]`, `elbowDeg` or `ax / mm`; of a unit in brackets
/// that is not known the word.
pub(crate) fn name_and_unit(title: &str) -> Option<(&str, Result<Unit, &str>)> {
    title.char_indices().skip(1).find_map(|(at, first)| {
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
    /// The last line, where it ends in the middle and is left out.
    pub cut: Option<usize>,
}

impl Table {
    /// Which column holds each of some quantities; none where no one does. Their units are known from then on.
    ///
    /// A title that is exactly a quantity's name counts before one with a unit behind it.
    ///
    /// # Errors
    /// Where a column's unit is not known, or measures something else.
    pub fn assign(&mut self, wanted: &[Quantity]) -> Result<Vec<Option<usize>>, String> {
        let titled = |name: &str| self.columns.iter().position(|column| column.title == name);
        let mut places: Vec<Option<usize>> = wanted.iter().map(|(name, _)| titled(name)).collect();
        for (k, (wanted, measure)) in wanted.iter().enumerate() {
            if places[k].is_some() {
                continue;
            }
            for at in 0..self.columns.len() {
                let title = &self.columns[at].title;
                let Some((name, unit)) = name_and_unit(title).filter(|(name, _)| name == wanted) else {
                    continue;
                };
                if places.contains(&Some(at)) {
                    continue;
                }
                let unit = match (unit, measure) {
                    (Ok(unit), Some(measure)) if unit.measure == *measure => Some(unit),
                    (Ok(_), Some(measure)) => {
                        let (noun, units) = measure.in_words();
                        return Err(format!("column \"{title}\": {name} is {noun}: give it in {units}"));
                    }
                    (Ok(_), None) => {
                        return Err(format!("column \"{title}\": {name} has no unit: rename it"));
                    }
                    (Err(word), Some(measure)) => {
                        let (_, units) = measure.in_words();
                        return Err(format!(
                            "column \"{title}\": the unit {word} is not known: give {units}"
                        ));
                    }
                    (Err(_), None) => None,
                };
                (places[k], self.columns[at].unit) = (Some(at), unit);
                break;
            }
        }
        Ok(places)
    }

    /// The titles of columns that are none of these.
    pub fn spare(&self, used: &[usize]) -> Vec<&Column> {
        let spare = self.columns.iter().enumerate().filter(|(at, _)| !used.contains(at));
        spare.map(|(_, column)| column).filter(|column| !column.title.is_empty()).collect()
    }

    /// A column, as messages call it.
    pub fn place(&self, at: usize) -> String {
        format!("column {}, {}", at + 1, self.columns[at].title)
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

/// Reads a table whose first line has the columns' names; they are separated by commas, tabs or semicolons. Lines that hold
/// nothing are left out.
pub(crate) fn read_table(path: &Path, bytes: &[u8]) -> Result<Table, RecordError> {
    let refuse = |line: usize, message: String| RecordError::format(path, Some(line), message);
    let text = bytes.trim_ascii_start();
    if text.starts_with(b"{") || text.starts_with(b"[") {
        return Err(refuse(
            1,
            "it is JSON, where a table of touches belongs: give the log as comma-separated values".into(),
        ));
    }
    if text.starts_with(b"<") {
        return Err(refuse(
            1,
            "it is XML, where a table of touches belongs: give the robot first and then the log as comma-separated values".into(),
        ));
    }
    let separator = separator(bytes);
    // Of a log that is being written the last line may be there in part.
    let unended = 1 + bytes.iter().filter(|&&byte| byte == b'\n').count();
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
                table = Some(Table { line, columns, rows: Vec::new(), cut: None })
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

/// That touches with numbers that are not finite are left out, as a sentence; `left_out` has their lines and what is wrong
/// with each.
pub(crate) fn left_out_in_words(left_out: &[(usize, String)], all: usize) -> Option<String> {
    let (line, fault) = left_out.first()?;
    Some(format!(
        "{} of {all} touches are left out, for they have numbers that are not finite: line {line}: {fault}",
        left_out.len()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(head: &str) -> Table {
        read_table(Path::new("log.csv"), head.as_bytes()).unwrap()
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
