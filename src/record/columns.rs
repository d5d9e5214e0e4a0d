//! A table's head: what each column holds, and in which unit.

use std::path::Path;

use csv::{ReaderBuilder, StringRecord};

use crate::record::RecordError;

/// The names of units behind a column's own name, and what their numbers are multiplied by to be metres or radians.
const UNITS: [(&str, f64); 7] = [
    ("deg", std::f64::consts::PI / 180.0),
    ("rad", 1.0),
    ("mm", 1e-3),
    ("cm", 1e-2),
    ("m", 1.0),
    ("°", std::f64::consts::PI / 180.0),
    ("degrees", std::f64::consts::PI / 180.0),
];

/// A column.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Column {
    /// As the file has it.
    pub title: String,
    /// Without its unit, where it has one.
    pub name: String,
    /// What its numbers are multiplied by.
    pub factor: Option<f64>,
}

impl Column {
    /// Of a title such as `elbow`, `elbow_deg`, `elbow [deg]` or `ax (mm)`.
    pub fn new(title: &str) -> Column {
        let title = title.trim().trim_start_matches('\u{feff}').to_string();
        for (unit, factor) in UNITS {
            for (open, close) in [("_", ""), (" [", "]"), ("[", "]"), (" (", ")"), ("(", ")")] {
                if let Some(name) =
                    title.strip_suffix(&format!("{open}{unit}{close}")).filter(|name| !name.is_empty())
                {
                    return Column { name: name.to_string(), title, factor: Some(factor) };
                }
            }
        }
        Column { name: title.clone(), title, factor: None }
    }
}

/// A table: its columns, and its rows with the lines that they are on.
pub(super) struct Table {
    /// The line that the names are on.
    pub line: usize,
    pub columns: Vec<Column>,
    pub rows: Vec<(usize, StringRecord)>,
}

/// Reads a table of comma-separated values whose first line has the columns' names.
pub(super) fn read_table(path: &Path, bytes: &[u8]) -> Result<Table, RecordError> {
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
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
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
        match &mut table {
            None => {
                table = Some(Table {
                    line,
                    columns: head(&record).map_err(|fault| refuse(line, fault))?,
                    rows: Vec::new(),
                })
            }
            Some(table) if record.len() == table.columns.len() => table.rows.push((line, record.clone())),
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
    table.ok_or_else(|| refuse(1, "there is no line of column names: begin with one".into()))
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
    if let (1, Some(only)) = (record.len(), record.get(0))
        && let Some(separator) = [';', '\t'].into_iter().find(|separator| only.contains(*separator))
    {
        return Err(format!(
            "its columns are separated by {separator:?}: separate them by commas, and write decimals with a point"
        ));
    }
    let columns: Vec<Column> = record.iter().map(Column::new).collect();
    if !columns.is_empty() && columns.iter().all(|column| column.title.parse::<f64>().is_ok()) {
        return Err("its first line has numbers, no names of columns: begin with a line of names".into());
    }
    for (i, column) in columns.iter().enumerate() {
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

    #[test]
    fn units_are_read_from_titles() {
        let of = |title: &str| {
            let column = Column::new(title);
            (column.name, column.factor.map(|factor| (factor * 180.0 / std::f64::consts::PI).round()))
        };
        for title in ["elbow_deg", "elbow [deg]", "elbow (deg)", "elbow[°]"] {
            assert_eq!(of(title), ("elbow".into(), Some(1.0)));
        }
        assert_eq!(Column::new("ax_mm").factor, Some(1e-3));
        assert_eq!(Column::new("left_arm").factor, None);
        assert_eq!(of("elbow"), ("elbow".into(), None));
    }
}
