//! A table: for a person, as JSON and as comma-separated values alike.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

/// A column.
pub struct Column {
    /// Its name in files, with its unit at the end: `heldout_mm`.
    pub name: &'static str,
    /// Its heading for a person: `held-out, mm`.
    pub heading: &'static str,
    /// Whether it says how long something took here, which no seed decides.
    pub wall_time: bool,
}

/// How long something took on this machine, in the unit that its column names: the one thing in a table that the seeds do not decide.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize)]
pub struct WallTime(pub f64);

/// One entry of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words.
    Words(String),
    /// A number; one that is not finite means that there is none.
    Number(f64),
    /// A whole number, such as a seed.
    Count(u64),
    /// Yes or no.
    Truth(bool),
}

/// A kind of row: its columns and the cells of one.
pub trait StudyRow: Serialize {
    /// The columns, in order.
    const COLUMNS: &'static [Column];

    /// A cell per column.
    fn cells(&self) -> Vec<Cell>;
}

/// Rows of cells under columns.
pub struct Table {
    columns: &'static [Column],
    rows: Vec<Vec<Cell>>,
}

/// What can stand in a cell.
pub(super) trait CellValue {
    /// Whether it is of this machine, not of a seed.
    const WALL_TIME: bool = false;

    /// The cell.
    fn cell(&self) -> Cell;
}

impl CellValue for WallTime {
    const WALL_TIME: bool = true;

    fn cell(&self) -> Cell {
        Cell::Number(self.0)
    }
}

impl CellValue for String {
    fn cell(&self) -> Cell {
        Cell::Words(self.clone())
    }
}

impl CellValue for f64 {
    fn cell(&self) -> Cell {
        Cell::Number(*self)
    }
}

impl CellValue for u64 {
    fn cell(&self) -> Cell {
        Cell::Count(*self)
    }
}

impl CellValue for usize {
    fn cell(&self) -> Cell {
        Cell::Count(*self as u64)
    }
}

impl CellValue for bool {
    fn cell(&self) -> Cell {
        Cell::Truth(*self)
    }
}

/// Defines a kind of row: a field per column, with the heading under which a person reads it. A column whose name in
/// files is no field's is named after `as`.
macro_rules! row {
    ($(#[$about:meta])* pub struct $row:ident {
        $($field:ident $(as $name:literal)?: $type:ty = $heading:literal),+ $(,)?
    }) => {
        $(#[$about])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        pub struct $row {
            $(
                #[doc = $heading]
                $(#[serde(rename = $name)])?
                pub $field: $type,
            )+
        }

        impl $crate::experiment::study::StudyRow for $row {
            const COLUMNS: &'static [$crate::experiment::study::Column] = &[
                $($crate::experiment::study::Column {
                    name: $crate::experiment::study::table::row!(@name $field $($name)?),
                    heading: $heading,
                    wall_time: <$type as $crate::experiment::study::table::CellValue>::WALL_TIME,
                }),+
            ];

            fn cells(&self) -> Vec<$crate::experiment::study::Cell> {
                use $crate::experiment::study::table::CellValue;
                vec![$(self.$field.cell()),+]
            }
        }
    };
    (@name $field:ident) => { stringify!($field) };
    (@name $field:ident $name:literal) => { $name };
}

pub(super) use row;

impl Cell {
    fn to_json(&self) -> Value {
        match self {
            Cell::Words(words) => json!(words),
            Cell::Number(number) => json!(number),
            Cell::Count(count) => json!(count),
            Cell::Truth(truth) => json!(truth),
        }
    }

    /// Numbers in the shortest form that reads back to the same bits; empty where there is none.
    fn to_csv(&self) -> String {
        match self {
            Cell::Words(words) => words.clone(),
            Cell::Number(number) if number.is_finite() => number.to_string(),
            Cell::Number(_) => String::new(),
            Cell::Count(count) => count.to_string(),
            Cell::Truth(truth) => truth.to_string(),
        }
    }

    fn to_words(&self) -> String {
        match self {
            Cell::Words(words) => words.clone(),
            Cell::Number(number) => three_digits(*number),
            Cell::Count(count) => count.to_string(),
            Cell::Truth(truth) => if *truth { "yes" } else { "no" }.to_string(),
        }
    }
}

impl Table {
    /// A table of rows.
    pub fn of<R: StudyRow>(rows: &[R]) -> Table {
        Table { columns: R::COLUMNS, rows: rows.iter().map(R::cells).collect() }
    }

    /// An array with an object per row.
    pub fn to_json(&self) -> Value {
        let object = |row: &Vec<Cell>| {
            let fields = self.columns.iter().zip(row);
            Value::Object(fields.map(|(c, cell)| (c.name.to_string(), cell.to_json())).collect::<Map<_, _>>())
        };
        Value::Array(self.rows.iter().map(object).collect())
    }

    /// A line of names and a line per row, without how long anything took here: it is the same wherever the same seeds are
    /// tried by the same program.
    ///
    /// # Errors
    /// Where it cannot be put into words.
    pub fn to_csv(&self) -> Result<String, csv::Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let kept = |k: &usize| !self.columns[*k].wall_time;
        let kept: Vec<usize> = (0..self.columns.len()).filter(kept).collect();
        writer.write_record(kept.iter().map(|&k| self.columns[k].name))?;
        for row in &self.rows {
            writer.write_record(kept.iter().map(|&k| row[k].to_csv()))?;
        }
        writer.flush()?;
        let bytes = writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }

    /// Its lines for a person, headings first, words to the left and numbers to the right.
    pub fn lines(&self) -> Vec<String> {
        let cells: Vec<Vec<String>> =
            self.rows.iter().map(|row| row.iter().map(Cell::to_words).collect()).collect();
        let width = |k: usize| {
            let cells = cells.iter().map(|row| row[k].chars().count());
            cells.chain([self.columns[k].heading.chars().count()]).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let headings: Vec<String> = self.columns.iter().map(|column| column.heading.to_string()).collect();
        let line = |line: &Vec<String>| {
            let mut text = String::new();
            for (k, (cell, width)) in line.iter().zip(&widths).enumerate() {
                let words = matches!(self.rows.first().map(|row| &row[k]), Some(Cell::Words(_)));
                text += &if words { format!("  {cell:<width$}") } else { format!("  {cell:>width$}") };
            }
            text.trim_end().to_string()
        };
        std::iter::once(&headings).chain(&cells).map(line).collect()
    }
}

/// A number to three digits, whatever its size; a dash where there is none.
fn three_digits(number: f64) -> String {
    if !number.is_finite() {
        return "–".into();
    }
    match number.abs() {
        0.0 => "0".into(),
        x if !(1e-3..1e6).contains(&x) => format!("{number:.1e}"),
        x if x >= 100.0 => format!("{number:.0}"),
        x if x >= 10.0 => format!("{number:.1}"),
        x if x >= 1.0 => format!("{number:.2}"),
        _ => format!("{number:.3}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    row! {
        /// A row to try.
        pub struct TriedRow {
            words: String = "words",
            sum: f64 = "sum",
            none as "0.1_none": f64 = "none",
            count: u64 = "count",
        }
    }

    #[test]
    fn a_cell_reads_the_same_in_every_form() {
        let row = TriedRow { words: "a, \"b\"".into(), sum: 0.1 + 0.2, none: f64::INFINITY, count: 7 };
        let table = Table::of(std::slice::from_ref(&row));
        let csv = table.to_csv().unwrap();
        assert_eq!(csv, "words,sum,0.1_none,count\n\"a, \"\"b\"\"\",0.30000000000000004,,7\n");
        assert_eq!(table.to_json(), json!([row]));
        assert_eq!(table.to_json()[0]["0.1_none"], Value::Null);
        assert_eq!(row.cells()[2].to_words(), "–");
        assert_eq!([2.34e-9, 0.0123, 1.2345, 123.4].map(three_digits), ["2.3e-9", "0.012", "1.23", "123"]);
    }
}
