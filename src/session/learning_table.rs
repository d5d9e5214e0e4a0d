//! The table of how learning went: a row per checkpoint.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use super::{Action, LEARNING_FILE, RecordError, files};
use crate::named::did_you_mean;

/// Columns that learning writes.
const COLUMNS: [&str; 9] = [
    "touches",
    "predicted_gap_mm",
    "predicted_deviation_mm",
    "converged",
    "fresh_rms",
    "heldout_mean_mm",
    "heldout_p95_mm",
    "hand_mean_mm",
    "axis_median_deg",
];
/// Letters of a column's name at the most.
const LONGEST_NAME: usize = 64;
/// Touches of a log at the most.
const MOST_TOUCHES: f64 = 1e8;
/// Numbers in the table at the most; what is farther off is none that learning gives.
const GREATEST: f64 = 1e15;

/// Writes [`LEARNING_FILE`]: comma-separated values behind a line of column names.
#[derive(Debug)]
pub struct LearningTable {
    path: PathBuf,
    file: File,
    columns: usize,
    rows: usize,
}

impl LearningTable {
    /// Begins the table in a session's folder; an older one there is overwritten.
    ///
    /// # Errors
    /// [`RecordError::Io`] where the folder or the file cannot be made, [`RecordError::Format`] for a
    /// column's name that needs quoting.
    pub fn create(folder: &Path, columns: &[&str]) -> Result<LearningTable, RecordError> {
        let path = folder.join(LEARNING_FILE);
        if let Some(name) = columns.iter().find(|name| name.contains([',', '"', '\n', '\r'])) {
            let message = format!("the column {name:?} has a comma, quote or line break: name it without");
            return Err(RecordError::format(&path, Some(1), message));
        }
        files::make_folder(folder)?;
        let file = File::create(&path).map_err(RecordError::io(&path, Action::Write))?;
        let mut table = LearningTable { path, file, columns: columns.len(), rows: 0 };
        table.write_line(&columns.join(","))?;
        Ok(table)
    }

    /// Adds a row, a number per column; what is no number that a measure can have leaves its cell empty.
    ///
    /// # Errors
    /// [`RecordError::Io`] where writing fails, [`RecordError::Format`] where the row does not have a
    /// number per column.
    pub fn row(&mut self, values: &[f64]) -> Result<(), RecordError> {
        if values.len() != self.columns {
            let message = format!(
                "a row of {} numbers does not fit {} columns: give one per column",
                values.len(),
                self.columns
            );
            return Err(RecordError::format(&self.path, Some(self.rows + 2), message));
        }
        let cell = |value: &f64| if value.abs() <= GREATEST { value.to_string() } else { String::new() };
        let cells: Vec<String> = values.iter().map(cell).collect();
        self.write_line(&cells.join(","))?;
        self.rows += 1;
        Ok(())
    }

    fn write_line(&mut self, line: &str) -> Result<(), RecordError> {
        let line = format!("{line}\n");
        self.file.write_all(line.as_bytes()).map_err(RecordError::io(&self.path, Action::Write))
    }
}

/// What the learner predicted of one touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// The touch, counted from 1.
    pub touch: usize,
    /// How far apart the schema put what touched, millimetres.
    pub gap: f64,
    /// The standard deviation that it expected of that, millimetres.
    pub deviation: f64,
}

/// [`LEARNING_FILE`] as it was read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LearningRows {
    /// The columns' names, which end in their unit.
    pub columns: Vec<String>,
    /// Per row a number per column; none where its cell is empty.
    pub rows: Vec<Vec<Option<f64>>>,
}

/// Reads [`LEARNING_FILE`] of a session's folder; nothing where there is no such file.
///
/// # Errors
/// [`RecordError::Io`] where it cannot be read, [`RecordError::Format`] where a number is none or not finite, a row has not a
/// cell per column, and where it has no column of touches.
pub fn read_learning_table(folder: &Path) -> Result<LearningRows, RecordError> {
    let path = folder.join(LEARNING_FILE);
    if !path.exists() {
        return Ok(LearningRows::default());
    }
    let bytes = files::read(&path)?;
    let text = String::from_utf8_lossy(&bytes);
    let mut lines = text.lines();
    let columns: Vec<String> = lines.next().unwrap_or_default().split(',').map(String::from).collect();
    let refuse = |line: usize, what: String| {
        let mend = "learn again with `bodyschema learn`, which writes the table anew";
        RecordError::format(&path, Some(line), format!("{what}: {mend}"))
    };
    let plain = |name: &String| {
        (1..=LONGEST_NAME).contains(&name.len())
            && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    };
    if let Some(odd) = columns.iter().find(|name| !plain(name)) {
        return Err(refuse(1, format!("\"{odd}\" is no name of a column, of which commas are between")));
    }
    if let Some(twice) = (1..columns.len()).find(|&k| columns[..k].contains(&columns[k])) {
        return Err(refuse(1, format!("there are two columns {}", columns[twice])));
    }
    if let Some(slip) = columns.iter().find(|name| !COLUMNS.contains(&name.as_str())) {
        if let Some(near) = did_you_mean(slip, COLUMNS) {
            return Err(refuse(1, format!("there is a column {slip}, where {near} is meant")));
        }
    }
    let has = |name: &str| columns.iter().any(|column| column == name);
    if has("predicted_gap_mm") != has("predicted_deviation_mm") {
        return Err(refuse(
            1,
            "it has one of predicted_gap_mm and predicted_deviation_mm, and not the other".into(),
        ));
    }
    let Some(touches) = columns.iter().position(|name| name == "touches") else {
        return Err(refuse(1, "there is no column touches".into()));
    };
    let converged = columns.iter().position(|name| name == "converged");
    let number = |n: usize, cell: &str| match cell {
        "" => Ok(None),
        cell => match cell.parse::<f64>() {
            Ok(number) if number.is_finite() && number.abs() <= GREATEST => Ok(Some(number)),
            Ok(number) => Err(refuse(n + 2, format!("{number} is no number that a measure can have"))),
            Err(_) => Err(refuse(n + 2, format!("\"{cell}\" is no number"))),
        },
    };
    let mut last = 0.0;
    let row = |(n, line): (usize, &str)| {
        let cells = line.split(',').map(|cell| number(n, cell)).collect::<Result<Vec<_>, _>>()?;
        if cells.len() != columns.len() {
            let (cells, columns) = (cells.len(), columns.len());
            return Err(refuse(n + 2, format!("it has {cells} cells in place of {columns}")));
        }
        match cells[touches] {
            Some(count) if (0.0..=MOST_TOUCHES).contains(&count) && count.fract() == 0.0 => {
                if count < last {
                    return Err(refuse(n + 2, format!("it is of {count} touches, after {last}")));
                }
                last = count;
                if converged.is_some_and(|k| cells[k].is_some_and(|x| x != 0.0 && x != 1.0)) {
                    return Err(refuse(n + 2, "its converged is neither 0 nor 1".into()));
                }
                let negative =
                    |k: usize| columns[k] != "predicted_gap_mm" && cells[k].is_some_and(|x| x < 0.0);
                match (0..columns.len()).find(|&k| negative(k)) {
                    Some(k) => Err(refuse(n + 2, format!("its {} is negative", columns[k]))),
                    None => Ok(cells),
                }
            }
            _ => Err(refuse(n + 2, "its number of touches is no whole number".into())),
        }
    };
    let rows = lines.enumerate().map(row).collect::<Result<_, _>>()?;
    Ok(LearningRows { columns, rows })
}

/// Reads from [`LEARNING_FILE`] of a session's folder what the learner predicted of touches; nothing where there is
/// no such file, or no such columns.
///
/// # Errors
/// [`RecordError::Io`] where it cannot be read, [`RecordError::Format`] where a number is none.
pub fn read_predictions(folder: &Path) -> Result<Vec<Prediction>, RecordError> {
    let LearningRows { columns, rows } = read_learning_table(folder)?;
    let column = |name: &str| columns.iter().position(|found| found == name);
    let found = ["touches", "predicted_gap_mm", "predicted_deviation_mm"].map(column);
    let [Some(touch), Some(gap), Some(deviation)] = found else { return Ok(Vec::new()) };
    let prediction = |row: &Vec<Option<f64>>| {
        Some(Prediction { touch: row[touch]? as usize, gap: row[gap]?, deviation: row[deviation]? })
    };
    Ok(rows.iter().filter_map(prediction).collect())
}
