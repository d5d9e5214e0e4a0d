//! Which column of a table of touches holds what.

use std::collections::HashMap;

use csv::StringRecord;
use nalgebra::Vector3;

use super::table::{
    CellFault, Column, DEVIATIONS, LIMBS, Measure, POINTS, QUATERNION, Quantity, RECEPTORS, Table,
};
use crate::creature::DofKind;

/// The columns of counts.
const COUNTS: [&str; 2] = ["bout", "motion"];

/// The columns of a degree of freedom in a posture.
pub(crate) fn coordinate_columns(name: &str, kind: DofKind) -> Vec<(String, Option<Measure>)> {
    match kind {
        DofKind::Ball => QUATERNION.map(|end| (format!("{name}{end}"), None)).to_vec(),
        DofKind::Hinge => vec![(name.to_string(), Some(Measure::Angle))],
        DofKind::Slide => vec![(name.to_string(), Some(Measure::Length))],
    }
}

/// The columns of a table of touches.
pub(crate) struct TouchColumns {
    /// Per coordinate of a posture.
    pub posture: Vec<Option<usize>>,
    fields: HashMap<&'static str, usize>,
    /// Those that mean nothing.
    pub spare: Vec<Column>,
}

impl TouchColumns {
    /// The columns of a table for postures of these coordinates, and of further quantities.
    pub fn new(
        table: &mut Table,
        coordinates: &[(String, Option<Measure>)],
        further: &[Quantity<'static>],
    ) -> Result<TouchColumns, String> {
        let texts = LIMBS.into_iter().chain(RECEPTORS).chain(COUNTS).map(|name| (name, None));
        let lengths = POINTS.into_iter().flatten().chain(DEVIATIONS);
        let fields: Vec<Quantity<'static>> =
            texts.chain(lengths.map(|name| (name, Some(Measure::Length)))).collect();
        if let Some((name, _)) = coordinates.iter().find(|(name, _)| fields.iter().any(|f| f.0 == *name)) {
            return Err(format!(
                "\"{name}\" moves, and is called as a column of another meaning: rename it in the body's file and here"
            ));
        }
        let coordinates = coordinates.iter().map(|(name, measure)| (name.as_str(), *measure));
        let fields: Vec<Quantity<'static>> = fields.into_iter().chain(further.iter().copied()).collect();
        let wanted: Vec<Quantity> = coordinates.clone().chain(fields.iter().copied()).collect();
        let mut posture = table.assign(&wanted)?;
        let places = posture.split_off(coordinates.count());
        let fields: HashMap<&'static str, usize> =
            fields.iter().zip(places).filter_map(|((name, _), place)| Some((*name, place?))).collect();
        for names in POINTS {
            let missing = names.iter().find(|name| !fields.contains_key(*name));
            if let Some(missing) = missing.filter(|_| names.iter().any(|name| fields.contains_key(name))) {
                return Err(format!("there is no column {missing}: a point has three coordinates"));
            }
        }
        let used: Vec<usize> = posture.iter().flatten().chain(fields.values()).copied().collect();
        let spare = table.spare(&used).into_iter().cloned().collect();
        Ok(TouchColumns { posture, fields, spare })
    }

    /// The columns that mean nothing, in a sentence.
    pub fn note(&self) -> Option<String> {
        let titles: Vec<&str> = self.spare.iter().map(|column| column.title.as_str()).collect();
        (!titles.is_empty()).then(|| format!("columns that are not used: {}", titles.join(", ")))
    }

    /// The column of a field.
    pub fn place(&self, name: &str) -> Option<usize> {
        self.fields.get(name).copied()
    }

    /// The column of a field whose cell in a row is not empty.
    pub fn given(&self, row: &StringRecord, name: &str) -> Option<usize> {
        self.place(name).filter(|at| !row[*at].is_empty())
    }

    /// The text of a field.
    pub fn text<'r>(&self, row: &'r StringRecord, name: &str) -> Option<&'r str> {
        self.given(row, name).map(|at| &row[at])
    }

    /// The count in a field.
    pub fn count(&self, table: &Table, row: &StringRecord, name: &str) -> Result<Option<u64>, CellFault> {
        let Some(at) = self.given(row, name) else { return Ok(None) };
        let count = row[at].parse().map(Some);
        count.map_err(|_| {
            let message = format!("{}: \"{}\" is no whole number: give one", table.place(at), &row[at]);
            CellFault::Wrong(message)
        })
    }

    /// The point of a side, if there is one.
    pub fn point(
        &self,
        table: &Table,
        row: &StringRecord,
        side: usize,
    ) -> Result<Option<Vector3<f64>>, CellFault> {
        let places = POINTS[side].map(|name| self.place(name));
        let [Some(x), Some(y), Some(z)] = places else { return Ok(None) };
        if [x, y, z].iter().all(|at| row[*at].is_empty()) {
            return Ok(None);
        }
        let number = |at: usize| table.number(row, at, "metres in the limb's frame");
        Ok(Some(Vector3::new(number(x)?, number(y)?, number(z)?)))
    }

    /// The standard deviation of each coordinate of that point, if it is given.
    pub fn deviation(
        &self,
        table: &Table,
        row: &StringRecord,
        side: usize,
    ) -> Result<Option<f64>, CellFault> {
        let Some(at) = self.given(row, DEVIATIONS[side]) else { return Ok(None) };
        let deviation = table.number(row, at, "metres")?;
        if deviation < 0.0 {
            let message =
                format!("{}: {deviation} is negative: give metres, or leave it empty", table.place(at));
            return Err(CellFault::Wrong(message));
        }
        Ok(Some(deviation))
    }
}

/// That touches with numbers that are not finite are left out, as a sentence; `left_out` has their lines and what is wrong
/// with each.
pub(crate) fn left_out_in_words(left_out: &[(usize, String)], all: usize) -> Option<String> {
    let (line, fault) = left_out.first()?;
    Some(format!(
        "{} of {all} touches are left out, for they have numbers that are not finite: line {line}: {fault}",
        left_out.len()
    ))
}
