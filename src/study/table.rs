//! Tables: rows of named values, summarized by case, for a person, as JSON and as comma-separated values alike.

use serde_json::{Map, Value, json};

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

impl Column {
    /// A column that is summarized in some ways.
    pub const fn new(name: &'static str, by: &'static [By]) -> Column {
        Column { name, by }
    }
}

/// Rows of values under names.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    names: Vec<String>,
    rows: Vec<Vec<Value>>,
}

impl Table {
    /// All measurements.
    pub fn of(columns: &[Column], rows: &[Row]) -> Table {
        let names = columns.iter().map(|column| column.name.to_string()).collect();
        let values = |row: &Row| columns.iter().map(|column| row[column.name].clone()).collect();
        Table { names, rows: rows.iter().map(values).collect() }
    }

    /// A row per case, in the order in which cases occur first.
    pub fn summary(columns: &[Column], rows: &[Row]) -> Table {
        let with = |by: By| columns.iter().filter(move |column| column.by.contains(&by));
        let cases: Vec<&str> = with(By::Case).map(|column| column.name).collect();
        let part = with(By::Part).map(|column| column.name).next();
        let mut groups: Vec<(Vec<Value>, Vec<&Row>)> = Vec::new();
        for row in rows {
            let case = || cases.iter().map(|case| row[*case].clone());
            let keys = match part {
                Some(part) => vec![json!("all"), row[part].clone()].into_iter().map(Some).collect(),
                None => vec![None],
            };
            for part in keys {
                let key: Vec<Value> = case().chain(part).collect();
                match groups.iter_mut().find(|(other, _)| *other == key) {
                    Some((_, rows)) => rows.push(row),
                    None => groups.push((key, vec![row])),
                }
            }
        }
        // Parts follow their case, whichever case occurred in between.
        let first =
            |key: &[Value]| groups.iter().position(|(other, _)| other[..cases.len()] == key[..cases.len()]);
        let order: Vec<usize> = groups.iter().filter_map(|(key, _)| first(key)).collect();
        let mut placed: Vec<_> = order.into_iter().zip(groups).collect();
        placed.sort_by_key(|(first, _)| *first);
        let measures = || {
            let of = columns.iter().flat_map(|column| column.by.iter().map(move |by| (column.name, *by)));
            of.filter(|(_, by)| !matches!(by, By::Case | By::Part))
        };
        let names = cases.iter().copied().chain(part).map(String::from).chain([String::from("trials")]);
        let names = names.chain(measures().map(|(name, by)| by.name_of(name))).collect();
        let line = |(_, (key, rows)): (usize, (Vec<Value>, Vec<&Row>))| {
            let values = measures().map(|(name, by)| by.of(rows.iter().map(|row| &row[name])));
            key.into_iter().chain([json!(rows.len())]).chain(values).collect()
        };
        Table { names, rows: placed.into_iter().map(line).collect() }
    }

    /// An array with an object per row.
    pub fn to_json(&self) -> Value {
        let object = |row: &Vec<Value>| {
            let fields = self.names.iter().cloned().zip(row.iter().cloned());
            Value::Object(fields.collect::<Map<_, _>>())
        };
        Value::Array(self.rows.iter().map(object).collect())
    }

    /// A line of names and a line per row; numbers in the shortest form that reads back to the same bits.
    ///
    /// # Errors
    /// If there is no memory left to write to.
    pub fn to_csv(&self) -> Result<String, csv::Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(&self.names)?;
        for row in &self.rows {
            writer.write_record(row.iter().map(|value| match value {
                Value::Null => String::new(),
                Value::String(words) => words.clone(),
                other => other.to_string(),
            }))?;
        }
        let bytes = writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }

    /// Its lines for a person, names first, words to the left and numbers to the right.
    pub fn lines(&self) -> Vec<String> {
        let all: Vec<Vec<String>> = std::iter::once(self.names.clone())
            .chain(self.rows.iter().map(|row| row.iter().map(in_words).collect()))
            .collect();
        let width = |k: usize| all.iter().map(|line| line[k].chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..self.names.len()).map(width).collect();
        let is_words = |k: usize| self.rows.iter().any(|row| row[k].is_string());
        let line = |cells: &Vec<String>| {
            let cells = cells.iter().zip(&widths).enumerate().map(|(k, (cell, width))| {
                if is_words(k) { format!("  {cell:<width$}") } else { format!("  {cell:>width$}") }
            });
            cells.collect::<String>().trim_end().to_string()
        };
        all.iter().map(line).collect()
    }
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

    /// What values come to; null if none of them exists.
    fn of<'a>(self, values: impl Iterator<Item = &'a Value>) -> Value {
        let number = |value: &Value| value.as_f64().or_else(|| Some(f64::from(u8::from(value.as_bool()?))));
        let numbers: Vec<f64> = values.filter_map(number).collect();
        let sum = || numbers.iter().sum::<f64>();
        json!(match self {
            _ if numbers.is_empty() => f64::NAN,
            By::Case | By::Part => f64::NAN,
            By::Median => median(&numbers),
            By::Least => numbers.iter().copied().fold(f64::INFINITY, f64::min),
            By::Most => numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            By::Share => sum() / numbers.len() as f64,
            By::Sum if sum().fract() == 0.0 => return json!(sum() as i64),
            By::Sum => sum(),
        })
    }
}

/// The middle value, or the mean of the middle two; NaN of none.
fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => f64::NAN,
        count => 0.5 * (sorted[(count - 1) / 2] + sorted[count / 2]),
    }
}

/// A value as a person reads it: numbers to three digits, a dash for what does not exist.
fn in_words(value: &Value) -> String {
    match value {
        Value::Null => "–".into(),
        Value::Bool(holds) => if *holds { "yes" } else { "no" }.into(),
        Value::String(words) => words.clone(),
        Value::Number(number) if number.is_f64() => three_digits(number.as_f64().unwrap_or(f64::NAN)),
        other => other.to_string(),
    }
}

fn three_digits(number: f64) -> String {
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

    const COLUMNS: &[Column] = &[
        Column::new("way", &[By::Case]),
        Column::new("family", &[By::Part]),
        Column::new("seed", &[]),
        Column::new("error_mm", &[By::Median, By::Most]),
        Column::new("right", &[By::Share]),
        Column::new("claims", &[By::Sum]),
    ];

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
    fn measurements_are_the_same_in_every_form() {
        let table = Table::of(COLUMNS, &rows());
        let csv = table.to_csv().unwrap();
        assert!(
            csv.starts_with("way,family,seed,error_mm,right,claims\nlm,hand,1,0.30000000000000004,true,1\n"),
            "{csv}"
        );
        assert!(csv.contains("\n\"a, \"\"b\"\"\",hand,1,,,1\n"), "{csv}");
        assert_eq!(table.to_json()[0], rows()[0]);
        assert_eq!(serde_json::from_str::<Value>(&table.to_json().to_string()).unwrap(), table.to_json());
        assert!(table.lines()[2].contains('–'), "{:?}", table.lines());
        assert_eq!([2.34e-9, 0.0123, 1.2345, 123.4].map(three_digits), ["2.3e-9", "0.012", "1.23", "123"]);
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
