//! A recording as comma-separated values: a line of column names, then a touch a line.

use std::collections::HashMap;
use std::path::Path;

use csv::StringRecord;
use nalgebra::Vector3;

use super::posture::unit_quaternions;
use super::raw::{RawEnd, RawTouch};
use crate::calibration::robot::likely;
use crate::creature::{Creature, DofKind};
use crate::record::RecordError;
use crate::record::columns::{Column, Table, read_table};
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

/// The touches, and which columns were passed over.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    creature: &Creature,
) -> Result<(Vec<RawTouch>, Option<String>), RecordError> {
    let Table { line, columns, rows } = read_table(path, bytes)?;
    let refuse = |line: usize| move |fault: ContentFault| RecordError::format(path, Some(line), fault);
    let (columns, spare) = CsvColumns::new(columns, creature).map_err(refuse(line))?;
    let touches = rows.iter().map(|(line, row)| columns.touch(row, *line, creature).map_err(refuse(*line)));
    let note = (!spare.is_empty()).then(|| format!("columns that are not used: {}", spare.join(", ")));
    Ok((touches.collect::<Result<_, _>>()?, note))
}

/// Which cell of a row holds what.
struct CsvColumns {
    columns: Vec<Column>,
    posture: Vec<usize>,
    reserved: HashMap<&'static str, usize>,
}

impl CsvColumns {
    /// Those of a head, and the titles of those that mean nothing.
    fn new(columns: Vec<Column>, creature: &Creature) -> Result<(CsvColumns, Vec<String>), ContentFault> {
        let wanted = posture_columns(creature);
        if let Some(name) = wanted.iter().find(|name| reserved().any(|other| other == **name)) {
            return Err(format!(
                "the degree of freedom \"{name}\" is called as a column of another meaning: rename it in the creature's \
                 file, or give the log as lines of JSON"
            ).into());
        }
        // A name as it stands counts before one without its unit.
        let place = |name: &str| {
            let titled = columns.iter().position(|column| column.title == name);
            titled.or_else(|| columns.iter().position(|column| column.name == name))
        };
        let known = |column: &Column| {
            let means = |name: &str| column.title == name || column.name == name;
            wanted.iter().any(|name| means(name)) || reserved().any(means)
        };
        let spare: Vec<String> =
            columns.iter().filter(|column| !known(column)).map(|column| column.title.clone()).collect();
        let posture = wanted.iter().map(|name| {
            place(name).ok_or_else(|| {
                let meant = spare.iter().find(|other| likely(&Column::new(other).name, name));
                let meant =
                    meant.map_or(String::new(), |other| format!(", or is {other} meant? Then rename it"));
                format!("there is no column {name}: add this degree of freedom{meant}")
            })
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
        Ok((CsvColumns { columns, posture, reserved }, spare))
    }

    fn touch(&self, row: &StringRecord, line: usize, creature: &Creature) -> Result<RawTouch, ContentFault> {
        let place = |column: usize| format!("column {}, {}", column + 1, self.columns[column].title);
        let number = |column: usize, unit: &str| -> Result<f64, ContentFault> {
            let cell = &row[column];
            if cell.is_empty() {
                return Err(
                    format!("{}: it is empty: give {unit}, or leave the touch out", place(column)).into()
                );
            }
            match cell.parse::<f64>() {
                Ok(value) if value.is_finite() => Ok(value * self.columns[column].factor.unwrap_or(1.0)),
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
            line,
            bout: count("bout")?,
            motion: count("motion")?,
            ends: [end(0)?, end(1)?],
            posture: posture.into(),
        })
    }
}
