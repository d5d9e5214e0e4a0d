//! Tables: a title per column and a row per thing, the same on a terminal, on a page and in a file.

use std::fmt::Write;

use serde_json::Value;

use super::text::{error_number, escape};
use crate::study;

/// What a cell holds whose value does not exist.
pub(crate) const NONE: &str = "–";

/// Rows of cells under titles; numbers are words already, for they have as many digits as is read of them.
pub(crate) struct Table {
    titles: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table of some rows, each with a cell per title.
    pub fn new<T: Into<String>, R: IntoIterator<Item = String>>(
        titles: impl IntoIterator<Item = T>,
        rows: impl IntoIterator<Item = R>,
    ) -> Table {
        let rows = rows.into_iter().map(|row| row.into_iter().collect()).collect();
        Table { titles: titles.into_iter().map(Into::into).collect(), rows }
    }

    /// A table of an array of objects, given per column its title and the name of its field.
    pub fn of_json(rows: &Value, columns: &[(&str, &str)]) -> Table {
        let row = |row: &Value| columns.iter().map(|(_, field)| in_words(&row[*field])).collect::<Vec<_>>();
        let rows = rows.as_array().into_iter().flatten();
        Table::new(columns.iter().map(|(title, _)| *title), rows.map(row))
    }

    /// The table of a study, for a person.
    pub fn of_study(table: &study::Table) -> Table {
        Table::of_cells(table, in_words)
    }

    /// The same for a file: numbers in the shortest form that reads back to the same bits.
    pub fn exact_of_study(table: &study::Table) -> Table {
        Table::of_cells(table, |value| match value {
            Value::Null => String::new(),
            Value::String(words) => words.clone(),
            other => other.to_string(),
        })
    }

    fn of_cells(table: &study::Table, cell: fn(&Value) -> String) -> Table {
        let row = |row: &Value| table.names.iter().map(|name| cell(&row[name])).collect::<Vec<_>>();
        Table::new(&table.names, table.rows.iter().map(row))
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Whether a column is of numbers, which stand to the right. The first one names the rows.
    fn is_of_numbers(&self, column: usize) -> bool {
        let is_number = |cell: &str| {
            let digits = cell.trim_start_matches(['<', ' ', '-', '−']);
            ["", NONE].contains(&cell) || digits.starts_with(|c: char| c.is_ascii_digit())
        };
        column > 0 && self.rows.iter().all(|row| row.get(column).is_none_or(|cell| is_number(cell)))
    }

    /// Its lines for a terminal, titles first.
    pub fn lines(&self) -> impl Iterator<Item = String> {
        let all = || std::iter::once(&self.titles).chain(&self.rows);
        let width = |k: usize| all().map(|row| row[k].chars().count()).max().unwrap_or(0);
        let columns: Vec<(usize, bool)> =
            (0..self.titles.len()).map(|k| (width(k), self.is_of_numbers(k))).collect();
        all().map(move |row| {
            let cells = row.iter().zip(&columns).map(|(cell, &(width, right))| {
                if right { format!("  {cell:>width$}") } else { format!("  {cell:<width$}") }
            });
            cells.collect::<String>().trim_end().to_string()
        })
    }

    /// The table on a page, of a class; what does not exist stands out.
    pub fn html(&self, class: &str) -> String {
        let class_of = |column: usize, cell: &str| match (self.is_of_numbers(column), cell) {
            (true, NONE) => " class=\"number open\"",
            (true, _) => " class=\"number\"",
            (false, _) => "",
        };
        // Writing to a string cannot fail.
        let mut html = format!("<div class=\"wide\" tabindex=\"0\"><table class=\"{class}\">\n<thead><tr>");
        for (column, title) in self.titles.iter().enumerate() {
            let _ = write!(html, "<th{}>{}</th>", class_of(column, ""), escape(title));
        }
        html.push_str("</tr></thead>\n<tbody>\n");
        for row in &self.rows {
            for (column, cell) in row.iter().enumerate() {
                let class = class_of(column, cell);
                let _ = match column {
                    0 => write!(html, "<tr><th scope=\"row\">{}</th>", escape(cell)),
                    _ if class.is_empty() => write!(html, "<td>{}</td>", escape(cell)),
                    _ => write!(html, "<td{class}>{}</td>", escape(&cell.replace('-', "−"))),
                };
            }
            html.push_str("</tr>\n");
        }
        html + "</tbody>\n</table></div>\n"
    }

    /// The table in Markdown.
    pub fn markdown(&self) -> String {
        let line = |row: &Vec<String>| {
            let cells: Vec<String> = row.iter().map(|cell| cell.replace('|', "/")).collect();
            format!("| {} |\n", cells.join(" | "))
        };
        let rows: String = self.rows.iter().map(line).collect();
        format!("{}|{}\n{rows}", line(&self.titles), "---|".repeat(self.titles.len()))
    }

    /// The table as comma-separated values.
    pub fn csv(&self) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        for row in std::iter::once(&self.titles).chain(&self.rows) {
            writer.write_record(row).expect("memory takes rows of one length");
        }
        String::from_utf8(writer.into_inner().expect("memory takes all")).expect("cells are text")
    }
}

/// A value as a person reads it.
fn in_words(value: &Value) -> String {
    match value {
        Value::Null => NONE.into(),
        Value::Bool(holds) => if *holds { "yes" } else { "no" }.into(),
        Value::String(words) => words.clone(),
        Value::Number(number) if number.is_f64() => error_number(number.as_f64().unwrap_or(f64::NAN)),
        Value::Array(values) => values.iter().map(in_words).collect::<Vec<_>>().join(", "),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn numbers_stand_to_the_right_and_names_are_quoted() {
        let row = |cells: [&str; 3]| cells.map(String::from);
        let table = Table::new(["limb", "mm", "why"], [row(["a, b", "< 0.001", ""]), row(["<c>", "–", "x"])]);
        let lines: Vec<String> = table.lines().collect();
        assert_eq!(lines, ["  limb       mm  why", "  a, b  < 0.001", "  <c>         –  x"]);
        assert_eq!(table.csv(), "limb,mm,why\n\"a, b\",< 0.001,\n<c>,–,x\n");
        let html = table.html("limbs");
        assert!(html.contains("<td class=\"number open\">–</td><td>x</td>") && html.contains("&lt;c&gt;"));
    }

    #[test]
    fn measurements_of_a_study_keep_all_their_digits_in_a_file() {
        let rows = [
            json!({"way": "a, \"b\"", "error_mm": 0.1 + 0.2, "right": true}),
            json!({"way": "lm", "error_mm": f64::NAN}),
        ];
        let table = study::Table::of(study::columns! { way, error_mm, right }, &rows);
        let csv = Table::exact_of_study(&table).csv();
        assert_eq!(csv, "way,error_mm,right\n\"a, \"\"b\"\"\",0.30000000000000004,true\nlm,,\n");
        let lines: Vec<String> = Table::of_study(&table).lines().collect();
        assert!(lines[1].contains("0.300") && lines[2].contains('–'), "{lines:?}");
    }
}
