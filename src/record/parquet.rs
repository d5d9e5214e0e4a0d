//! The log of touches as a Parquet file: a table that data frames read column by column.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;

use super::{Action, PROGRAM, PartFile, RecordError};
use crate::agent::Agent;
use crate::creature::DofKind;
use crate::senses::Touch;

/// Touches that are written at a time, so that columns of a long log need little memory.
const ROWS: usize = 65_536;

/// The values of a column for some of the touches.
enum Values {
    Counts(Vec<i64>),
    Names(Vec<ByteArray>),
    Numbers(Vec<f64>),
    /// Numbers that a touch may lack.
    Sometimes(Vec<Option<f64>>),
}

/// A column: its name, and its values for touches.
type ParquetColumn<'a> = (String, Box<dyn Fn(&[Touch]) -> Values + 'a>);

/// Writes touches to a Parquet file, a row a touch; whole or not at all.
///
/// The columns are those of a recording in comma-separated values: `bout`, `motion`; `limb_a`, `limb_b` and
/// `receptor_a`, `receptor_b`, names; `ax` … `bz`, the points of contact in their limbs' frames, metres; one per
/// coordinate of the posture under the name of its degree of freedom, radians or metres, of a ball with `_w`, `_x`,
/// `_y`, `_z` behind it. `a_std`, `b_std` (metres), `time` (seconds), `force` (newtons) and `depth` (metres) are null
/// where a touch lacks them.
///
/// # Errors
/// [`RecordError::Io`] where the file cannot be written.
pub fn write_parquet(path: &Path, agent: &Agent, touches: &[Touch]) -> Result<(), RecordError> {
    let failed = |error: ParquetError| RecordError::io(path, Action::Write)(std::io::Error::other(error));
    let io = || RecordError::io(path, Action::Write);
    let part = PartFile::begin(path).map_err(io())?;
    let file = File::create(part.path()).map_err(io())?;
    let columns = columns(agent);
    let schema = Arc::new(schema(&columns).map_err(failed)?);
    let about = Arc::new(WriterProperties::builder().set_created_by(PROGRAM.to_string()).build());
    let mut writer = SerializedFileWriter::new(file, schema, about).map_err(failed)?;
    for touches in touches.chunks(ROWS) {
        let mut rows = writer.next_row_group().map_err(failed)?;
        for (_, values) in &columns {
            write_column(&mut rows, &values(touches)).map_err(failed)?;
        }
        rows.close().map_err(failed)?;
    }
    writer.close().map_err(failed)?;
    part.put().map_err(io())
}

fn columns<'a>(agent: &'a Agent) -> Vec<ParquetColumn<'a>> {
    let mut columns: Vec<ParquetColumn> = vec![
        ("bout".into(), Box::new(|t| Values::Counts(t.iter().map(|t| t.bout.cast_signed()).collect()))),
        ("motion".into(), Box::new(|t| Values::Counts(t.iter().map(|t| t.motion.cast_signed()).collect()))),
    ];
    for (k, side) in ["a", "b"].into_iter().enumerate() {
        let receptor = move |touch: &Touch| &agent.skin().receptors[touch.ends[k].receptor];
        let limb = move |touch: &Touch| agent.creature().limbs()[receptor(touch).limb].clone();
        columns.push((format!("limb_{side}"), Box::new(move |t| names(t, limb))));
        columns.push((format!("receptor_{side}"), Box::new(move |t| names(t, |t| receptor(t).id.clone()))));
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let contact = move |touch: &Touch| touch.ends[k].contact[axis];
            columns.push((format!("{side}{name}"), Box::new(move |t| numbers(t, contact))));
        }
        let deviation = move |touch: &Touch| touch.ends[k].deviation;
        columns.push((format!("{side}_std"), Box::new(move |t| sometimes(t, deviation))));
    }
    for at in agent.creature().elements() {
        let (place, dof) = (at.coordinate(), at.dof());
        let endings = if dof.kind == DofKind::Ball { &["_w", "_x", "_y", "_z"][..] } else { &[""] };
        for (k, ending) in endings.iter().enumerate() {
            let coordinate = move |touch: &Touch| touch.posture[place + k];
            columns.push((format!("{}{ending}", dof.name), Box::new(move |t| numbers(t, coordinate))));
        }
    }
    columns.push(("time".into(), Box::new(|t| sometimes(t, |t| Some(t.moment?.time)))));
    columns.push(("force".into(), Box::new(|t| sometimes(t, |t| Some(t.moment?.force)))));
    columns.push(("depth".into(), Box::new(|t| sometimes(t, |t| Some(t.moment?.depth)))));
    columns
}

fn names(touches: &[Touch], name: impl Fn(&Touch) -> String) -> Values {
    Values::Names(touches.iter().map(|touch| ByteArray::from(name(touch).into_bytes())).collect())
}

fn numbers(touches: &[Touch], number: impl Fn(&Touch) -> f64) -> Values {
    Values::Numbers(touches.iter().map(number).collect())
}

fn sometimes(touches: &[Touch], number: impl Fn(&Touch) -> Option<f64>) -> Values {
    Values::Sometimes(touches.iter().map(number).collect())
}

fn schema(columns: &[ParquetColumn]) -> Result<Type, ParquetError> {
    let field = |(name, values): &ParquetColumn| {
        let (physical, meaning, repetition) = match values(&[]) {
            Values::Counts(_) => (Physical::INT64, None, Repetition::REQUIRED),
            Values::Names(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String), Repetition::REQUIRED),
            Values::Numbers(_) => (Physical::DOUBLE, None, Repetition::REQUIRED),
            Values::Sometimes(_) => (Physical::DOUBLE, None, Repetition::OPTIONAL),
        };
        let field = Type::primitive_type_builder(name, physical).with_logical_type(meaning);
        field.with_repetition(repetition).build().map(Arc::new)
    };
    let fields = columns.iter().map(field).collect::<Result<Vec<_>, _>>()?;
    Type::group_type_builder("touches").with_fields(fields).build()
}

fn write_column(rows: &mut SerializedRowGroupWriter<'_, File>, values: &Values) -> Result<(), ParquetError> {
    let missing = || ParquetError::General("there are more columns than the schema has".into());
    let mut column = rows.next_column()?.ok_or_else(missing)?;
    match values {
        Values::Counts(counts) => column.typed::<Int64Type>().write_batch(counts, None, None)?,
        Values::Names(names) => column.typed::<ByteArrayType>().write_batch(names, None, None)?,
        Values::Numbers(numbers) => column.typed::<DoubleType>().write_batch(numbers, None, None)?,
        Values::Sometimes(numbers) => {
            let there: Vec<i16> = numbers.iter().map(|number| i16::from(number.is_some())).collect();
            let numbers: Vec<f64> = numbers.iter().flatten().copied().collect();
            column.typed::<DoubleType>().write_batch(&numbers, Some(&there), None)?
        }
    };
    column.close()
}
