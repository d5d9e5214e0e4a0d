//! The table of how learning went: a row per checkpoint.

use crate::error::Error;
use std::io;
use std::path::Path;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

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
    #[serde(default, serialize_with = "written", deserialize_with = "gap")]
    pub predicted_gap_mm: Option<f64>,
    /// … and the standard deviation that the learner expected of that.
    #[serde(default, serialize_with = "written", deserialize_with = "measure")]
    pub predicted_deviation_mm: Option<f64>,
    /// 1 if the schema predicts held-out touches, else 0.
    #[serde(default)]
    pub converged: Option<u8>,
    /// The residual of held-out touches, a root mean square in the learner's own unit.
    #[serde(default, serialize_with = "written", deserialize_with = "measure")]
    pub fresh_rms: Option<f64>,
    /// The mean surface error between all pairs of limbs, millimetres.
    #[serde(default, serialize_with = "written", deserialize_with = "measure")]
    pub heldout_mean_mm: Option<f64>,
    /// 95 % of these errors are less.
    #[serde(default, serialize_with = "written", deserialize_with = "measure")]
    pub heldout_p95_mm: Option<f64>,
    /// The mean surface error between a hand and other limbs, millimetres.
    #[serde(default, serialize_with = "written", deserialize_with = "measure")]
    pub hand_mean_mm: Option<f64>,
    /// The median angle between learned and true axes, degrees.
    #[serde(default, serialize_with = "written", deserialize_with = "measure")]
    pub axis_median_deg: Option<f64>,
}

/// Writes [`LEARNING_FILE`] into a session's folder, which is made if missing: comma-separated values after a line of column
/// names. A number that no measure can have leaves its cell empty.
///
/// # Errors
/// If the folder or the file cannot be written.
pub fn write_learning_table(folder: &Path, rows: &[LearningRow]) -> Result<(), Error> {
    let path = folder.join(LEARNING_FILE);
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row).map_err(io::Error::other).map_err(Error::unwritable(&path))?;
    }
    let table = writer.into_inner().map_err(|error| Error::unwritable(&path)(error.into_error()))?;
    files::write(&path, table)
}

/// A number that no measure can have leaves its cell empty.
fn written<S: Serializer>(number: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    number.filter(|x| x.abs() <= GREATEST).serialize(serializer)
}

/// A gap, which is negative where surfaces overlap.
fn gap<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    within(-GREATEST, deserializer)
}

/// Any other measure.
fn measure<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    within(0.0, deserializer)
}

fn within<'de, D: Deserializer<'de>>(least: f64, deserializer: D) -> Result<Option<f64>, D::Error> {
    let number = Option::<f64>::deserialize(deserializer)?;
    match number.filter(|x| !(least..=GREATEST).contains(x)) {
        None => Ok(number),
        Some(wrong) => Err(D::Error::custom(format!("{wrong} is not a possible value"))),
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
        let mend = "learn again with `bodyschema learn`, which rewrites the table";
        Error::content(&path, Some(line), format!("{what}: {mend}"))
    };
    let mut rows: Vec<LearningRow> = Vec::new();
    for (k, row) in csv::Reader::from_reader(&bytes[..]).deserialize().enumerate() {
        let row: LearningRow = row.map_err(|error: csv::Error| {
            let fault = match error.kind() {
                csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
                    format!("it has {len} cells instead of {expected_len}")
                }
                _ => format!("not a row of learning ({error})"),
            };
            refuse(k + 2, fault)
        })?;
        let before = rows.last().map_or(0, |last| last.touches);
        if !(before..=MOST_TOUCHES).contains(&row.touches) {
            return Err(refuse(k + 2, format!("it is of {} touches, after {before}", row.touches)));
        }
        rows.push(row);
    }
    Ok(rows)
}
