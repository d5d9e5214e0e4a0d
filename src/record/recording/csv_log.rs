//! A recording as comma-separated values: a line of column names, then a touch a line.

use std::collections::HashMap;
use std::path::Path;

use csv::{ReaderBuilder, StringRecord};
use nalgebra::Vector3;

use super::posture::unit_quaternions;
use super::raw::{RawEnd, RawTouch};
use crate::creature::{Creature, DofKind};
use crate::record::RecordError;
use crate::record::error::ContentFault;

/// The columns beside those of the degrees of freedom, end a then end b.
const LIMBS: [&str; 2] = ["limb_a", "limb_b"];
const RECEPTORS: [&str; 2] = ["receptor_a", "receptor_b"];
const POINTS: [[&str; 3]; 2] = [["ax", "ay", "az"], ["bx", "by", "bz"]];
const DEVIATIONS: [&str; 2] = ["a_std", "b_std"];
const COUNTS: [&str; 2] = ["bout", "motion"];
/// What the columns of a ball's quaternion have behind its name.
const QUATERNION: [&str; 4] = ["_w", "_x", "_y", "_z"];

/// All names of columns that are not of degrees of freedom.
fn reserved() -> impl Iterator<Item = &'static str> {
    let pairs = [LIMBS, RECEPTORS, DEVIATIONS, COUNTS].into_iter().flatten();
    pairs.chain(POINTS.into_iter().flatten())
}

/// The names of the columns of a posture, in the creature's order.
fn posture_columns(creature: &Creature) -> Vec<String> {
    let of_dof = |dof: &crate::creature::Dof| match dof.kind {
        DofKind::Ball => QUATERNION.map(|suffix| format!("{}{suffix}", dof.name)).to_vec(),
        _ => vec![dof.name.clone()],
    };
    creature.dofs().flat_map(of_dof).collect()
}

/// The touches.
pub(super) fn read(path: &Path, bytes: &[u8], creature: &Creature) -> Result<Vec<RawTouch>, RecordError> {
    let refuse = |line: u64, message: String| RecordError::format(path, Some(line as usize), message);
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(bytes);
    let mut record = StringRecord::new();
    let mut columns: Option<CsvColumns> = None;
    let mut touches = Vec::new();
    loop {
        match reader.read_record(&mut record) {
            Ok(true) => {}
            Ok(false) => break,
            Err(error) => {
                let line = error.position().map_or(0, csv::Position::line);
                return Err(refuse(line, format!("it is no text in UTF-8 ({error}): save the file as such")));
            }
        }
        let line = line_of(&record, bytes);
        match &columns {
            None => {
                columns =
                    Some(CsvColumns::new(&record, creature).map_err(|fault| refuse(line, fault.into()))?)
            }
            Some(columns) => {
                let touch =
                    columns.touch(&record, line, creature).map_err(|fault| refuse(line, fault.into()))?;
                touches.push(touch);
            }
        }
    }
    if columns.is_none() {
        return Err(refuse(1, "there is no line of column names: begin with one".into()));
    }
    Ok(touches)
}

/// The line on which a record begins, from 1. The reader counts from where it began to look, blank lines and
/// comments before the record included.
pub(in crate::record) fn line_of(record: &StringRecord, bytes: &[u8]) -> u64 {
    let Some(position) = record.position() else { return 1 };
    let rest = &bytes[(position.byte() as usize).min(bytes.len())..];
    let skipped = rest
        .split(|&byte| byte == b'\n')
        .take_while(|line| line.trim_ascii().is_empty() || line.starts_with(b"#"))
        .count();
    position.line() + skipped as u64
}

/// Which cell of a row holds what.
struct CsvColumns {
    names: Vec<String>,
    posture: Vec<usize>,
    reserved: HashMap<&'static str, usize>,
}

impl CsvColumns {
    fn new(header: &StringRecord, creature: &Creature) -> Result<CsvColumns, ContentFault> {
        let names: Vec<String> =
            header.iter().map(|name| name.trim_start_matches('\u{feff}').to_string()).collect();
        if let [only] = names.as_slice()
            && let Some(separator) = [';', '\t'].into_iter().find(|separator| only.contains(*separator))
        {
            return Err(format!(
                "its columns are separated by {separator:?}: separate them by commas, and write decimals with a point"
            ).into());
        }
        let wanted = posture_columns(creature);
        if let Some(name) = wanted.iter().find(|name| reserved().any(|other| other == **name)) {
            return Err(format!(
                "the degree of freedom \"{name}\" is called as a column of another meaning: rename it in the creature's \
                 file, or give the log as lines of JSON"
            ).into());
        }
        for (i, name) in names.iter().enumerate() {
            let column = i + 1;
            if names[..i].contains(name) {
                return Err(format!("column {column}, {name}: it occurs twice: leave one of them out").into());
            }
            if !wanted.contains(name) && !reserved().any(|other| other == name) {
                return Err(format!(
                    "column {column}, \"{name}\": it is neither a degree of freedom of {} nor one of {}: rename it or \
                     leave it out",
                    creature.name(),
                    reserved().collect::<Vec<_>>().join(", ")
                ).into());
            }
        }
        let place = |name: &str| names.iter().position(|other| other == name);
        let posture = wanted.iter().map(|name| {
            place(name).ok_or_else(|| format!("there is no column {name}: add this degree of freedom"))
        });
        let posture = posture.collect::<Result<Vec<usize>, String>>()?;
        let reserved: HashMap<&'static str, usize> =
            reserved().filter_map(|name| place(name).map(|place| (name, place))).collect();
        let has = |name: &str| reserved.contains_key(name);
        for side in [0, 1] {
            let (limb, receptor) = (LIMBS[side], RECEPTORS[side]);
            let points = POINTS[side].iter().filter(|name| has(name)).count();
            if points != 0 && points != 3 {
                let missing = POINTS[side].iter().find(|name| !has(name)).copied().unwrap_or_default();
                return Err(format!("there is no column {missing}: a point has three coordinates").into());
            }
            let told = has(receptor) || (has(limb) && points == 3);
            if !told {
                let [x, y, z] = POINTS[side];
                return Err(format!(
                    "there is no column {}: give {limb} with {x}, {y}, {z}, or {receptor}",
                    if has(limb) { x } else { limb }
                )
                .into());
            }
        }
        Ok(CsvColumns { names, posture, reserved })
    }

    fn touch(&self, row: &StringRecord, line: u64, creature: &Creature) -> Result<RawTouch, ContentFault> {
        if row.len() != self.names.len() {
            return Err(format!(
                "it has {} cells in place of {}: give one for each column",
                row.len(),
                self.names.len()
            )
            .into());
        }
        let place = |column: usize| format!("column {}, {}", column + 1, self.names[column]);
        let number = |column: usize, unit: &str| -> Result<f64, ContentFault> {
            let cell = &row[column];
            if cell.is_empty() {
                return Err(
                    format!("{}: it is empty: give {unit}, or leave the touch out", place(column)).into()
                );
            }
            match cell.parse::<f64>() {
                Ok(value) if value.is_finite() => Ok(value),
                Ok(_) => Err(format!(
                    "{}: {cell} is not finite: give {unit}, or leave the touch out",
                    place(column)
                )
                .into()),
                Err(_) => Err(format!("{}: \"{cell}\" is no number: give {unit}", place(column)).into()),
            }
        };
        // A reserved column's cell, where there is such a column and it is not empty.
        let cell = |name: &str| {
            let column = *self.reserved.get(name)?;
            (!row[column].is_empty()).then_some(column)
        };
        let count = |name: &str| -> Result<Option<u64>, ContentFault> {
            let Some(column) = cell(name) else { return Ok(None) };
            let value = row[column].parse::<u64>();
            value.map(Some).map_err(|_| {
                format!("{}: \"{}\" is no whole number: give one", place(column), &row[column]).into()
            })
        };
        let mut posture = Vec::with_capacity(self.posture.len());
        for &column in &self.posture {
            posture.push(number(column, "radians, or metres of a slide")?);
        }
        unit_quaternions(creature, &mut posture);
        let end = |side: usize| -> Result<RawEnd, ContentFault> {
            let point = match POINTS[side].map(cell) {
                [None, None, None] => None,
                _ => {
                    let mut point = Vector3::zeros();
                    for (name, value) in POINTS[side].iter().zip(point.iter_mut()) {
                        *value = number(self.reserved[name], "metres in the limb's frame")?;
                    }
                    Some(point)
                }
            };
            let deviation = match cell(DEVIATIONS[side]) {
                None => None,
                Some(column) => Some(number(column, "metres")?),
            };
            if let (Some(wrong), Some(column)) = (deviation.filter(|x| *x < 0.0), cell(DEVIATIONS[side])) {
                return Err(format!(
                    "{}: {wrong} is negative: give metres, or leave it empty",
                    place(column)
                )
                .into());
            }
            let text = |name: &str| cell(name).map(|column| row[column].to_string());
            Ok(RawEnd {
                limb: text(LIMBS[side]),
                limb_place: ["column limb_a", "column limb_b"][side],
                receptor: text(RECEPTORS[side]),
                receptor_place: ["column receptor_a", "column receptor_b"][side],
                point,
                deviation,
            })
        };
        Ok(RawTouch {
            line: line as usize,
            bout: count("bout")?,
            motion: count("motion")?,
            ends: [end(0)?, end(1)?],
            posture: posture.into(),
        })
    }
}
