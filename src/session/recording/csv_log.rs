//! A recording as comma-separated values: a line of column names, then a touch a line.

use std::collections::HashMap;
use std::path::Path;

use csv::StringRecord;
use nalgebra::Vector3;

use super::posture::unit_quaternions;
use super::raw::{RawEnd, RawLog, RawTouch};
use crate::calibration::robot::likely;
use crate::creature::{Creature, DofKind};
use crate::session::RecordError;
use crate::session::columns::{CellFault, Measure, Quantity, Table, read_table};
use crate::session::record_error::ContentFault;

/// The columns beside those of the degrees of freedom, end a then end b.
const LIMBS: [&str; 2] = ["limb_a", "limb_b"];
const RECEPTORS: [&str; 2] = ["receptor_a", "receptor_b"];
const POINTS: [[&str; 3]; 2] = [["ax", "ay", "az"], ["bx", "by", "bz"]];
const DEVIATIONS: [&str; 2] = ["a_std", "b_std"];
const COUNTS: [&str; 2] = ["bout", "motion"];
/// What the columns of a ball's quaternion have behind its name.
const QUATERNION: [&str; 4] = ["_w", "_x", "_y", "_z"];

/// All columns that are not of degrees of freedom.
fn reserved() -> impl Iterator<Item = Quantity<'static>> {
    let texts = [LIMBS, RECEPTORS, COUNTS].into_iter().flatten().map(|name| (name, None));
    let lengths = DEVIATIONS.into_iter().chain(POINTS.into_iter().flatten());
    texts.chain(lengths.map(|name| (name, Some(Measure::Length))))
}

/// The columns of a posture, in the creature's order.
fn posture_columns(creature: &Creature) -> Vec<(String, Option<Measure>)> {
    let of_dof = |dof: &crate::creature::Dof| match dof.kind {
        DofKind::Ball => QUATERNION.map(|suffix| (format!("{}{suffix}", dof.name), None)).to_vec(),
        DofKind::Hinge => vec![(dof.name.clone(), Some(Measure::Angle))],
        DofKind::Slide => vec![(dof.name.clone(), Some(Measure::Length))],
    };
    creature.dofs().flat_map(of_dof).collect()
}

/// The touches, and what is worth a note.
pub(super) fn read(path: &Path, bytes: &[u8], creature: &Creature) -> Result<RawLog, RecordError> {
    let mut table = read_table(path, bytes)?;
    let refuse = |line: usize| move |fault: ContentFault| RecordError::format(path, Some(line), fault);
    let columns = CsvColumns::new(&mut table, creature).map_err(refuse(table.line))?;
    let mut log = RawLog { cut: table.cut, ..RawLog::default() };
    for (line, row) in &table.rows {
        log.take(*line, columns.touch(&table, row, *line, creature)).map_err(refuse(*line))?;
    }
    let spare: Vec<&str> = columns.spare.iter().map(|title| title.as_str()).collect();
    log.notes.extend((!spare.is_empty()).then(|| format!("columns that are not used: {}", spare.join(", "))));
    Ok(log)
}

/// Which cell of a row holds what.
struct CsvColumns {
    posture: Vec<usize>,
    reserved: HashMap<&'static str, usize>,
    /// The titles of those that mean nothing.
    spare: Vec<String>,
}

impl CsvColumns {
    /// Those of a head.
    fn new(table: &mut Table, creature: &Creature) -> Result<CsvColumns, ContentFault> {
        let wanted = posture_columns(creature);
        if let Some((name, _)) = wanted.iter().find(|(name, _)| reserved().any(|(other, _)| other == *name)) {
            return Err(format!(
                "the degree of freedom \"{name}\" is called as a column of another meaning: rename it in the creature's \
                 file, or give the log as lines of JSON"
            ).into());
        }
        let mut quantities: Vec<Quantity> =
            wanted.iter().map(|(name, measure)| (name.as_str(), *measure)).collect();
        for quantity in reserved() {
            quantities.push(quantity);
        }
        let places = table.assign(&quantities)?;
        let used: Vec<usize> = places.iter().flatten().copied().collect();
        let spare = table.spare(&used);
        let (of_posture, of_reserved) = places.split_at(wanted.len());
        let posture = wanted.iter().zip(of_posture).map(|((name, _), place)| {
            place.ok_or_else(|| {
                let meant = spare.iter().find(|other| likely(other.name(), name));
                let meant = meant
                    .map_or(String::new(), |other| format!(", or is {} meant? Then rename it", other.title));
                format!("there is no column {name}: add this degree of freedom{meant}")
            })
        });
        let posture = posture.collect::<Result<Vec<usize>, String>>()?;
        let spare = spare.iter().map(|column| column.title.clone()).collect();
        let reserved: HashMap<&'static str, usize> =
            reserved().zip(of_reserved).filter_map(|((name, _), place)| Some((name, (*place)?))).collect();
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
        Ok(CsvColumns { posture, reserved, spare })
    }

    fn touch(
        &self,
        table: &Table,
        row: &StringRecord,
        line: usize,
        creature: &Creature,
    ) -> Result<RawTouch, CellFault> {
        let place = |column: usize| table.place(column);
        let number = |column: usize, unit: &str| table.number(row, column, unit);
        // A reserved column's cell, where there is such a column and it is not empty.
        let cell = |name: &str| {
            let column = *self.reserved.get(name)?;
            (!row[column].is_empty()).then_some(column)
        };
        let count = |name: &str| -> Result<Option<u64>, CellFault> {
            let Some(column) = cell(name) else { return Ok(None) };
            let value = row[column].parse::<u64>();
            value.map(Some).map_err(|_| {
                let message = format!("{}: \"{}\" is no whole number: give one", place(column), &row[column]);
                CellFault::Wrong(message)
            })
        };
        let mut posture = Vec::with_capacity(self.posture.len());
        for &column in &self.posture {
            posture.push(number(column, "radians, or metres of a slide")?);
        }
        unit_quaternions(creature, &mut posture);
        let end = |side: usize| -> Result<RawEnd, CellFault> {
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
                let message =
                    format!("{}: {wrong} is negative: give metres, or leave it empty", place(column));
                return Err(CellFault::Wrong(message));
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
            line,
            bout: count("bout")?,
            motion: count("motion")?,
            ends: [end(0)?, end(1)?],
            posture: posture.into(),
        })
    }
}
