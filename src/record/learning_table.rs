//! The table of how learning went: a row per checkpoint.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use super::{Action, LEARNING_FILE, RecordError, files};

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

    /// Adds a row, a number per column; what is not a number (NaN) leaves its cell empty.
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
        let cell = |value: &f64| if value.is_nan() { String::new() } else { value.to_string() };
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

/// What the learner foretold of one touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// The touch, counted from 1.
    pub touch: usize,
    /// How far apart the schema put what touched, millimetres.
    pub gap: f64,
    /// The standard deviation that it expected of that, millimetres.
    pub deviation: f64,
}

/// Reads from [`LEARNING_FILE`] of a session's folder what the learner foretold of touches; nothing where there is
/// no such file, or no such columns.
///
/// # Errors
/// [`RecordError::Io`] where it cannot be read, [`RecordError::Format`] where a number is none.
pub fn read_predictions(folder: &Path) -> Result<Vec<Prediction>, RecordError> {
    let path = folder.join(LEARNING_FILE);
    if !path.exists() {
        return Ok(Vec::new());
    }
    let bytes = files::read(&path)?;
    let text = String::from_utf8_lossy(&bytes);
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let column = |name: &str| names.iter().position(|found| *found == name);
    let columns = ["touches", "predicted_gap_mm", "predicted_deviation_mm"].map(column);
    let [Some(touch), Some(gap), Some(deviation)] = columns else { return Ok(Vec::new()) };
    let mut predictions = Vec::new();
    for (n, line) in lines.enumerate() {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |column: usize| {
            match cells.get(column).copied().unwrap_or_default() {
            "" => Ok(None),
            cell => cell.parse::<f64>().map(Some).map_err(|_| {
                let message = format!(
                    "\"{cell}\" is no number: learn again with `bodyschema learn`, which writes the table anew"
                );
                RecordError::format(&path, Some(n + 2), message)
            }),
        }
        };
        if let (Some(touch), Some(gap), Some(deviation)) = (number(touch)?, number(gap)?, number(deviation)?)
        {
            predictions.push(Prediction { touch: touch as usize, gap, deviation });
        }
    }
    Ok(predictions)
}
