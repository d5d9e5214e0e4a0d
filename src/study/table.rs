//! Tables: rows of named values, and their summary by case.

use serde_json::{Value, json};

use crate::evaluation::Summary;

/// A measurement: a JSON object with a value per column. A value that is null or left out does not exist, such as the error of
/// an attempt that failed.
pub type Row = Value;

/// A column of a study's table.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    /// Its name, with its unit at the end: `heldout_mm`.
    pub name: &'static str,
    /// How the summary has it; not at all if there is none.
    pub by: &'static [By],
}

/// How a column is summarized.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum By {
    /// It names the case: the summary has a row per value.
    Case,
    /// It names a part of a case: the summary has a row per value, after one for all parts together.
    Part,
    /// The median of its numbers.
    Median,
    /// The least of its numbers.
    Least,
    /// The greatest of its numbers.
    Most,
    /// The share of its rows in which it is true.
    Share,
    /// The sum of its numbers, or how often it is true.
    Sum,
}

/// The columns of a study, each with the ways in which the summary has it: `columns! { way: Case, seed, error_mm: Median Most }`.
macro_rules! columns {
    ($($name:ident $(: $($by:ident)+)?),* $(,)?) => {
        &[$($crate::study::Column { name: stringify!($name), by: &[$($($crate::study::By::$by),+)?] }),*]
    };
}

pub(crate) use columns;

/// Rows of values under names, in the order of their columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// The names of the columns.
    pub names: Vec<String>,
    /// The rows, each an object with a value per column.
    pub rows: Vec<Row>,
}

impl Table {
    /// All measurements.
    pub fn of(columns: &[Column], rows: &[Row]) -> Table {
        let names: Vec<String> = columns.iter().map(|column| column.name.to_string()).collect();
        let kept = |row: &Row| names.iter().map(|name| (name.clone(), row[name].clone())).collect();
        Table { rows: rows.iter().map(kept).collect(), names }
    }

    /// A row per case, in the order in which cases occur first, followed by one per part if the cases have parts.
    pub fn summary(columns: &[Column], rows: &[Row]) -> Table {
        let with = |by: By| columns.iter().filter(move |column| column.by.contains(&by));
        let cases: Vec<&str> = with(By::Case).map(|column| column.name).collect();
        let part = with(By::Part).map(|column| column.name).next();
        let measures = || {
            let of = columns.iter().flat_map(|column| column.by.iter().map(move |by| (column.name, *by)));
            of.filter(|(_, by)| !matches!(by, By::Case | By::Part))
        };
        let line = |rows: &[&Row], of_part: Value| -> Row {
            let of_case = cases.iter().map(|case| (case.to_string(), rows[0][*case].clone()));
            let measured = measures().map(|(name, by)| (by.name_of(name), by.of(rows, name)));
            let counted = ("trials".to_string(), json!(rows.len()));
            let part = part.map(|part| (part.to_string(), of_part));
            of_case.chain(part).chain([counted]).chain(measured).collect()
        };
        let mut lines = Vec::new();
        for of_case in grouped(rows, &cases) {
            lines.push(line(&of_case, json!("all")));
            if let Some(part) = part {
                let parts = grouped(of_case, &[part]);
                lines.extend(parts.iter().map(|rows| line(rows, rows[0][part].clone())));
            }
        }
        let names = cases.iter().copied().chain(part).chain(["trials"]).map(String::from);
        Table { names: names.chain(measures().map(|(name, by)| by.name_of(name))).collect(), rows: lines }
    }

    /// An array with an object per row.
    pub fn to_json(&self) -> Value {
        json!(self.rows)
    }
}

/// Rows that are alike in some columns together, in the order in which these values occur first.
fn grouped<'a>(rows: impl IntoIterator<Item = &'a Row>, columns: &[&str]) -> Vec<Vec<&'a Row>> {
    let mut groups: Vec<Vec<&Row>> = Vec::new();
    for row in rows {
        let is_alike = |group: &&mut Vec<&Row>| columns.iter().all(|name| group[0][*name] == row[*name]);
        match groups.iter_mut().find(is_alike) {
            Some(group) => group.push(row),
            None => groups.push(vec![row]),
        }
    }
    groups
}

impl By {
    /// The name of a summarized column.
    fn name_of(self, column: &str) -> String {
        match self {
            By::Least => format!("least_{column}"),
            By::Most => format!("most_{column}"),
            _ => column.to_string(),
        }
    }

    /// The summary of a column of some rows; null if no value of it exists.
    fn of(self, rows: &[&Row], column: &str) -> Value {
        let number = |value: &Value| value.as_f64().or_else(|| Some(f64::from(u8::from(value.as_bool()?))));
        let numbers: Vec<f64> = rows.iter().filter_map(|row| number(&row[column])).collect();
        let all = Summary::of(numbers.iter().copied());
        let sum = numbers.iter().sum::<f64>();
        json!(match self {
            _ if numbers.is_empty() => f64::NAN,
            By::Case | By::Part => f64::NAN,
            By::Median => all.median,
            By::Least => numbers.iter().copied().fold(f64::INFINITY, f64::min),
            By::Most => all.max,
            By::Share => all.mean,
            By::Sum if sum.fract() == 0.0 => return json!(sum as i64),
            By::Sum => sum,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COLUMNS: &[Column] = columns! {
        way: Case, family: Part, seed, error_mm: Median Most, right: Share, claims: Sum,
    };

    fn rows() -> Vec<Row> {
        let row = |way: &str, family: &str, seed: u64, error_mm: f64, right: Option<bool>| json!({"way": way, "family": family, "seed": seed, "error_mm": error_mm, "right": right, "claims": seed});
        vec![
            row("lm", "hand", 1, 0.1 + 0.2, Some(true)),
            row("a, \"b\"", "hand", 1, f64::NAN, None),
            row("lm", "star", 2, 4.0, Some(false)),
            row("a, \"b\"", "tree", 2, 123.4, None),
        ]
    }

    #[test]
    fn a_summary_has_every_case_with_its_parts_and_leaves_out_what_does_not_exist() {
        let summary = Table::summary(COLUMNS, &rows()).to_json();
        let keys: Vec<_> =
            summary.as_array().unwrap().iter().map(|row| (&row["way"], &row["family"])).collect();
        let expected = [
            ("lm", "all"),
            ("lm", "hand"),
            ("lm", "star"),
            ("a, \"b\"", "all"),
            ("a, \"b\"", "hand"),
            ("a, \"b\"", "tree"),
        ];
        assert!(keys.iter().zip(expected).all(|((a, b), (c, d))| *a == c && *b == d), "{keys:?}");
        let all = &summary[0];
        assert_eq!((&all["trials"], &all["claims"], &all["right"]), (&2.into(), &3.into(), &0.5.into()));
        assert_eq!((&all["error_mm"], &all["most_error_mm"]), (&2.15.into(), &4.0.into()));
        assert_eq!((&summary[3]["error_mm"], &summary[4]["error_mm"]), (&123.4.into(), &Value::Null));
    }
}
