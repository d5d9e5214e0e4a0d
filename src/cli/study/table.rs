//! A table: for a person, as JSON and as comma-separated values alike.

use serde_json::{Map, Value, json};

/// A column.
pub struct Column {
    /// Its name in files, with its unit at the end: `heldout_mm`.
    pub name: &'static str,
    /// Its heading for a person: `held-out, mm`.
    pub heading: &'static str,
}

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

/// Rows of cells under columns.
pub struct Table {
    columns: &'static [Column],
    rows: Vec<Vec<Cell>>,
}

impl From<&str> for Cell {
    fn from(words: &str) -> Cell {
        Cell::Words(words.to_string())
    }
}

impl From<String> for Cell {
    fn from(words: String) -> Cell {
        Cell::Words(words)
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Cell {
        Cell::Number(number)
    }
}

impl From<u64> for Cell {
    fn from(count: u64) -> Cell {
        Cell::Count(count)
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Cell {
        Cell::Count(count as u64)
    }
}

impl From<bool> for Cell {
    fn from(truth: bool) -> Cell {
        Cell::Truth(truth)
    }
}

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
            Cell::Words(words) if words.contains([',', '"', '\n', '\r']) => {
                format!("\"{}\"", words.replace('"', "\"\""))
            }
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
    /// A table without rows.
    pub fn new(columns: &'static [Column]) -> Table {
        Table { columns, rows: Vec::new() }
    }

    /// Adds a row, one cell per column.
    pub fn row<const N: usize>(&mut self, cells: [Cell; N]) {
        debug_assert_eq!(cells.len(), self.columns.len(), "a cell per column");
        self.rows.push(cells.into());
    }

    /// An array with an object per row.
    pub fn to_json(&self) -> Value {
        let object = |row: &Vec<Cell>| {
            let fields = self.columns.iter().zip(row);
            Value::Object(fields.map(|(c, cell)| (c.name.to_string(), cell.to_json())).collect::<Map<_, _>>())
        };
        Value::Array(self.rows.iter().map(object).collect())
    }

    /// A line of names and a line per row.
    pub fn to_csv(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|column| column.name).collect();
        let mut text = names.join(",") + "\n";
        for row in &self.rows {
            let cells: Vec<String> = row.iter().map(Cell::to_csv).collect();
            text += &(cells.join(",") + "\n");
        }
        text
    }

    /// Prints it to standard output, words to the left and numbers to the right.
    pub fn print(&self) {
        let cells: Vec<Vec<String>> =
            self.rows.iter().map(|row| row.iter().map(Cell::to_words).collect()).collect();
        let width = |k: usize| {
            let cells = cells.iter().map(|row| row[k].chars().count());
            cells.chain([self.columns[k].heading.chars().count()]).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let headings: Vec<String> = self.columns.iter().map(|column| column.heading.to_string()).collect();
        for line in std::iter::once(&headings).chain(&cells) {
            let mut text = String::new();
            for (k, (cell, width)) in line.iter().zip(&widths).enumerate() {
                let words = matches!(self.rows.first().map(|row| &row[k]), Some(Cell::Words(_)));
                text += &if words { format!("  {cell:<width$}") } else { format!("  {cell:>width$}") };
            }
            say!("{}", text.trim_end());
        }
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

    #[test]
    fn a_cell_reads_the_same_in_every_form() {
        let cells =
            [Cell::from("a, \"b\""), Cell::from(0.1 + 0.2), Cell::from(f64::INFINITY), Cell::from(7u64)];
        let csv: Vec<String> = cells.iter().map(Cell::to_csv).collect();
        assert_eq!(csv, ["\"a, \"\"b\"\"\"", "0.30000000000000004", "", "7"]);
        assert_eq!(cells[2].to_json(), Value::Null);
        assert_eq!(cells[2].to_words(), "–");
        assert_eq!([2.34e-9, 0.0123, 1.2345, 123.4].map(three_digits), ["2.3e-9", "0.012", "1.23", "123"]);
    }
}
