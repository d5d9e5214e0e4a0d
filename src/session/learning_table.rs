//! The table of how learning went: a row per checkpoint.

use crate::error::Error;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{LEARNING_FILE, files};

/// Touches of a log at the most.
const MOST_TOUCHES: usize = 100_000_000;
/// Numbers in the table at the most; learning gives none that are farther off.
const GREATEST: f64 = 1e15;

/// A row of [`LEARNING_FILE`]; what is not known has an empty cell.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LearningRow {
    /// The touches that were learned from.
    pub touches: usize,
    /// How far apart the schema before put the surfaces that met in the last of them, millimetres, …
    #[serde(default)]
    pub predicted_gap_mm: Option<f64>,
    /// … and the standard deviation that the learner expected of that.
    #[serde(default)]
    pub predicted_deviation_mm: Option<f64>,
    /// 1 if the schema predicts held-out touches, else 0.
    #[serde(default)]
    pub converged: Option<u8>,
    /// The residual of held-out touches, a root mean square in the learner's own unit.
    #[serde(default)]
    pub fresh_rms: Option<f64>,
    /// The mean surface error between all pairs of limbs, millimetres.
    #[serde(default)]
    pub heldout_mean_mm: Option<f64>,
    /// 95 % of these errors are less.
    #[serde(default)]
    pub heldout_p95_mm: Option<f64>,
    /// The mean surface error between a hand and other limbs, millimetres.
    #[serde(default)]
    pub hand_mean_mm: Option<f64>,
    /// The median angle between learned and true axes, degrees.
    #[serde(default)]
    pub axis_median_deg: Option<f64>,
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

/// Writes [`LEARNING_FILE`]: comma-separated values after a line of column names.
pub struct LearningTable {
    path: PathBuf,
    writer: csv::Writer<File>,
}

impl LearningTable {
    /// Begins the table in a session's folder; an older one there is overwritten.
    ///
    /// # Errors
    /// If the folder or the file cannot be made.
    pub fn create(folder: &Path) -> Result<LearningTable, Error> {
        let path = folder.join(LEARNING_FILE);
        files::make_folder(folder)?;
        let file = File::create(&path).map_err(Error::unwritable(&path))?;
        Ok(LearningTable { path, writer: csv::Writer::from_writer(file) })
    }

    /// Adds a row. A number that no measure can have leaves its cell empty.
    ///
    /// # Errors
    /// If writing fails.
    pub fn row(&mut self, row: &LearningRow) -> Result<(), Error> {
        let mut row = row.clone();
        row.numbers().into_iter().for_each(|number| *number = number.filter(|x| x.abs() <= GREATEST));
        let written = self.writer.serialize(&row).map_err(io::Error::other);
        written.and_then(|()| self.writer.flush()).map_err(Error::unwritable(&self.path))
    }
}

impl LearningRow {
    /// The measures, the predicted gap first.
    fn numbers(&mut self) -> [&mut Option<f64>; 7] {
        [
            &mut self.predicted_gap_mm,
            &mut self.predicted_deviation_mm,
            &mut self.fresh_rms,
            &mut self.heldout_mean_mm,
            &mut self.heldout_p95_mm,
            &mut self.hand_mean_mm,
            &mut self.axis_median_deg,
        ]
    }

    /// What of it cannot be, after a row of so many touches.
    fn fault(&self, before: usize) -> Option<String> {
        let mut row = self.clone();
        let numbers = row.numbers();
        // A gap may be an overlap.
        let least = |k: usize| if k == 0 { -GREATEST } else { 0.0 };
        let wrong = numbers
            .iter()
            .enumerate()
            .find_map(|(k, number)| number.filter(|x| !(least(k)..=GREATEST).contains(x)));
        let converged = self.converged.filter(|converged| *converged > 1).map(f64::from);
        if let Some(wrong) = wrong.or(converged) {
            return Some(format!("{wrong} is no number that this measure can have"));
        }
        let touches = self.touches;
        let order = touches >= before && touches <= MOST_TOUCHES;
        (!order).then(|| format!("it is of {touches} touches, after {before}"))
    }
}

/// Reads [`LEARNING_FILE`] of a session's folder; nothing if there is no such file.
///
/// # Errors
/// If it cannot be read, or, with the line, if it is no such table.
pub fn read_learning_table(folder: &Path) -> Result<Vec<LearningRow>, Error> {
    let path = folder.join(LEARNING_FILE);
    if !path.exists() {
        return Ok(Vec::new());
    }
    let bytes = files::read(&path)?;
    let refuse = |line: usize, what: String| {
        let mend = "learn again with `bodyschema learn`, which writes the table anew";
        Error::content(&path, Some(line), format!("{what}: {mend}"))
    };
    let mut rows: Vec<LearningRow> = Vec::new();
    for (k, row) in csv::Reader::from_reader(&bytes[..]).deserialize().enumerate() {
        let row: LearningRow = row.map_err(|error: csv::Error| match error.kind() {
            csv::ErrorKind::Deserialize { err, pos } => {
                let field = err.field().map_or(String::new(), |field| format!("cell {}: ", field + 1));
                let line = pos.as_ref().map_or(k + 2, |pos| pos.line() as usize);
                refuse(line, format!("it is no row of learning ({field}{})", err.kind()))
            }
            csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
                refuse(k + 2, format!("it has {len} cells in place of {expected_len}"))
            }
            _ => refuse(k + 2, format!("it is no row of learning ({error})")),
        })?;
        if let Some(fault) = row.fault(rows.last().map_or(0, |last| last.touches)) {
            return Err(refuse(k + 2, fault));
        }
        rows.push(row);
    }
    Ok(rows)
}

/// What the learner predicted of touches, from [`LEARNING_FILE`] of a session's folder; nothing if it is not there.
///
/// # Errors
/// As [`read_learning_table`].
pub fn read_predictions(folder: &Path) -> Result<Vec<Prediction>, Error> {
    let prediction = |row: LearningRow| {
        let (gap, deviation) = (row.predicted_gap_mm?, row.predicted_deviation_mm?);
        Some(Prediction { touch: row.touches, gap, deviation })
    };
    Ok(read_learning_table(folder)?.into_iter().filter_map(prediction).collect())
}
