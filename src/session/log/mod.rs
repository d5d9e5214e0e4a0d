//! Logs of touches, of a creature or of a robot: which column holds what, and what a row says.

pub(super) mod table;
pub(super) mod units;

use std::f64::consts::TAU;
use std::path::Path;

use csv::StringRecord;
use nalgebra::Vector3;

use crate::creature::{Creature, DofKind};
use crate::error::Error;
use crate::named::did_you_mean;
use table::{
    CellFault, Column, DEVIATIONS, LIMBS, POINTS, QUATERNION, Quantity, RECEPTORS, Table, read_table,
};
use units::Measure;

/// The columns of counts.
const COUNTS: [&str; 2] = ["bout", "motion"];
/// An angle so far beyond its joint's range, radians, is worth a note each; one beyond it by a whole turn is refused, for it
/// would be another angle with the turn taken off.
const FAR: f64 = 1.0;
/// How many rows are named in a note.
const NAMED: usize = 3;

/// What moves, and has a column in a log; a ball has one for each number of its quaternion.
#[derive(Clone, Copy)]
pub(super) struct LogJoint<'a> {
    pub name: &'a str,
    pub kind: DofKind,
    /// Least and greatest coordinate, radians or metres.
    pub range: [f64; 2],
}

/// A log, of which it is known which column holds what.
pub(super) struct Log<'a> {
    pub path: &'a Path,
    pub table: Table,
    joints: Vec<LogJoint<'a>>,
    /// Per coordinate of a posture its column.
    pub posture: Vec<Option<usize>>,
    /// What looks odd, in sentences.
    pub notes: Vec<String>,
}

impl LogJoint<'_> {
    /// The columns that it has.
    pub fn columns(&self) -> Vec<(String, Option<Measure>)> {
        let name = self.name;
        match self.kind {
            DofKind::Ball => QUATERNION.map(|end| (format!("{name}{end}"), None)).to_vec(),
            DofKind::Hinge => vec![(name.to_string(), Some(Measure::Angle))],
            DofKind::Slide => vec![(name.to_string(), Some(Measure::Length))],
        }
    }
}

impl<'a> Log<'a> {
    /// Reads a log of what moves so, and of further quantities; the header of a session's log must be of the `creature`, if one
    /// is given. `fault` is what is wrong with its columns.
    pub fn read(
        path: &'a Path,
        joints: Vec<LogJoint<'a>>,
        further: &[Quantity<'static>],
        creature: Option<&Creature>,
        fault: impl FnOnce(&Log) -> Option<String>,
    ) -> Result<Log<'a>, Error> {
        let coordinates: Vec<_> = joints.iter().flat_map(LogJoint::columns).collect();
        let names: Vec<String> = coordinates.iter().map(|(name, _)| name.clone()).collect();
        let (table, notes) = read_table(path, &names, creature)?;
        let mut log = Log { path, table, joints, posture: Vec::new(), notes };
        if !log.table.columns.is_empty() {
            let assigned = log.assign(&coordinates, further);
            let fault = assigned.err().or_else(|| fault(&log));
            fault.map_or(Ok(()), |fault| Err(Error::content(path, Some(log.table.line), fault)))?;
        }
        Ok(log)
    }

    /// Finds out which column holds what.
    fn assign(
        &mut self,
        coordinates: &[(String, Option<Measure>)],
        further: &[Quantity<'static>],
    ) -> Result<(), String> {
        let texts = LIMBS.into_iter().chain(RECEPTORS).chain(COUNTS).map(|name| (name, None));
        let lengths = POINTS.into_iter().flatten().chain(DEVIATIONS);
        let fields = texts.chain(lengths.map(|name| (name, Some(Measure::Length))));
        let fields: Vec<Quantity<'static>> = fields.chain(further.iter().copied()).collect();
        if let Some((name, _)) = coordinates.iter().find(|(name, _)| fields.iter().any(|f| f.0 == *name)) {
            return Err(format!(
                "the joint \"{name}\" has the name of a column with another meaning: rename it in the body's file and here"
            ));
        }
        let moving = coordinates.iter().map(|(name, measure)| (name.as_str(), *measure));
        let wanted: Vec<Quantity> = moving.chain(fields.iter().copied()).collect();
        self.posture = self.table.assign(&wanted)?;
        self.posture.truncate(coordinates.len());
        for names in POINTS {
            let missing = names.iter().find(|name| !self.table.has(name));
            if let Some(missing) = missing.filter(|_| names.iter().any(|name| self.table.has(name))) {
                return Err(format!("column {missing} is missing: a point has three coordinates"));
            }
        }
        let titles: Vec<&str> = self.table.spare().map(|column| column.title.as_str()).collect();
        let unused = (!titles.is_empty()).then(|| format!("unused columns: {}", titles.join(", ")));
        self.notes.extend(unused);
        Ok(())
    }

    /// The column that is likely meant by a name that no column has, as the end of a sentence.
    pub fn meant(&self, name: &str) -> String {
        let near = self.table.spare().find(|column| did_you_mean(column.name(), [name]).is_some());
        near.map_or(String::new(), |near| format!(", or is {} meant? Then rename it", near.title))
    }

    /// The count in a field.
    pub fn count(&self, row: &StringRecord, name: &str) -> Result<Option<u64>, CellFault> {
        let Some(at) = self.table.given(row, name) else { return Ok(None) };
        row[at].parse().map(Some).map_err(|_| {
            let place = self.table.place(at);
            CellFault::Wrong(format!("{place}: \"{}\" is not a whole number: give one", &row[at]))
        })
    }

    /// The standard deviation of each coordinate of the point of a side, if it is given.
    pub fn deviation(&self, row: &StringRecord, side: usize) -> Result<Option<f64>, CellFault> {
        let Some(at) = self.table.given(row, DEVIATIONS[side]) else { return Ok(None) };
        let deviation = self.table.number(row, at, "metres")?;
        if deviation >= 0.0 {
            return Ok(Some(deviation));
        }
        let place = self.table.place(at);
        Err(CellFault::Wrong(format!("{place}: {deviation} is negative: give metres, or leave it empty")))
    }

    /// The point of a side, if there is one.
    pub fn point(&self, row: &StringRecord, side: usize) -> Result<Option<Vector3<f64>>, CellFault> {
        let [Some(x), Some(y), Some(z)] = POINTS[side].map(|name| self.table.at(name)) else {
            return Ok(None);
        };
        if [x, y, z].iter().all(|at| row[*at].is_empty()) {
            return Ok(None);
        }
        let number = |at: usize| self.table.number(row, at, "metres in the limb's frame");
        Ok(Some(Vector3::new(number(x)?, number(y)?, number(z)?)))
    }

    /// What `read` makes of the rows. Those with numbers that are not finite are left out, which is noted.
    ///
    /// # Errors
    /// That of a row, with its line; where nothing is left.
    pub fn rows<T>(
        &mut self,
        read: impl Fn(&Log, usize, &StringRecord) -> Result<T, CellFault>,
    ) -> Result<Vec<T>, Error> {
        let (mut all, mut left_out) = (Vec::with_capacity(self.table.rows.len()), Vec::new());
        for (line, row) in &self.table.rows {
            match read(self, *line, row) {
                Ok(touch) => all.push(touch),
                Err(CellFault::NotFinite(fault)) => left_out.push((line, fault)),
                Err(CellFault::Wrong(fault)) => return Err(self.refused(*line, fault)),
            }
        }
        let note = left_out.first().map(|(line, fault)| {
            format!(
                "{} of {} touches are ignored because their numbers are not finite: line {line}: {fault}",
                left_out.len(),
                self.table.rows.len()
            )
        });
        if all.is_empty() {
            return Err(self.empty(note));
        }
        self.notes.splice(0..0, note);
        Ok(all)
    }

    /// A refusal of a row.
    pub fn refused(&self, line: usize, fault: impl Into<String>) -> Error {
        Error::content(self.path, Some(line), fault)
    }

    /// A refusal of a log without a touch that can be used.
    pub fn empty(&self, why: Option<String>) -> Error {
        let why = why.map_or(String::new(), |why| format!(" ({why})"));
        Error::content(self.path, None, format!("it contains no touches{why}: give one touch per line"))
    }

    /// Notes that rows repeat others.
    pub fn note_repeats(&mut self, repeats: usize, rows: usize) {
        let note =
            || format!("{repeats} of {rows} rows are repeats in the same posture; each touch counts once");
        self.notes.extend((repeats > 0).then(note));
    }

    /// What moves, each with the place of its first coordinate in a posture.
    pub fn joints(&self) -> impl Iterator<Item = (LogJoint<'a>, usize)> {
        let mut at = 0;
        self.joints.iter().map(move |joint| {
            at += joint.kind.coordinates();
            (*joint, at - joint.kind.coordinates())
        })
    }

    /// The hinges that have a column.
    pub fn hinges(&self) -> Vec<(LogJoint<'a>, usize)> {
        let read = |at: usize| self.posture[at].is_some();
        self.joints().filter(|(joint, at)| joint.kind == DofKind::Hinge && read(*at)).collect()
    }

    /// Refuses angles of which most are beyond a full turn, and single ones that their joint cannot have; ranges beyond one are
    /// noted. Postures come with their lines.
    pub fn check_angles<'p>(
        &mut self,
        postures: impl Iterator<Item = (usize, &'p [f64])> + Clone,
    ) -> Result<(), Error> {
        let hinges = self.hinges();
        let angles = |at: usize| postures.clone().map(move |(line, posture)| (line, posture[at]));
        for (LogJoint { name, .. }, at) in &hinges {
            let column = self.posture[*at].map(|column| &self.table.columns[column]);
            // Zero is zero in any unit. A range that allows for such angles is likely to be in degrees itself.
            let turned = || angles(*at).filter(|(_, angle)| *angle != 0.0);
            let beyond = || turned().filter(|(_, angle)| angle.abs() > TAU);
            let most = 2 * beyond().count() > turned().count();
            let example = beyond().next().filter(|_| most && column.is_none_or(Column::is_si));
            if let Some((line, angle)) = example {
                let message = format!(
                    "{name} is {angle}, and most of its angles exceed a full turn of 6.283 radians: convert them \
                     and the range to radians, or remove whole turns; if they are degrees, call the column {name}_deg"
                );
                return Err(self.refused(line, message));
            }
        }
        for (LogJoint { name, range: [low, high], .. }, at) in &hinges {
            let beyond = |(_, angle): &(usize, f64)| (low - angle).max(angle - high) > TAU;
            if let Some((line, angle)) = angles(*at).find(beyond) {
                let message = format!(
                    "{name} is {angle}, more than a turn beyond its range of {low:.3} to {high:.3} radians: \
                     convert degrees to radians, remove whole turns, correct the range, or leave the touch out"
                );
                return Err(self.refused(line, message));
            }
        }
        self.notes.extend(wide_ranges(hinges.iter().map(|(joint, _)| (joint.name, joint.range))));
        Ok(())
    }
}

/// Angles of a joint that are far beyond its range, each with its line, as a sentence.
pub(super) fn far_angles(
    LogJoint { name, range: [low, high], .. }: LogJoint,
    angles: impl Iterator<Item = (usize, f64)>,
) -> Option<String> {
    let far: Vec<_> = angles.filter(|(_, angle)| (low - angle).max(angle - high) > FAR).collect();
    let lines = far.iter().take(NAMED).map(|(line, angle)| format!("{angle} on line {line}"));
    let lines = lines.collect::<Vec<String>>().join(", ");
    let more = if far.len() > NAMED { format!(" and {} more", far.len() - NAMED) } else { String::new() };
    (!far.is_empty()).then(|| {
        format!(
            "{name} is {lines}{more}, far beyond its range of {low:.3} to {high:.3} radians: correct them, or the range"
        )
    })
}

/// Ranges beyond a full turn, as a sentence.
pub(crate) fn wide_ranges<'a>(hinges: impl Iterator<Item = (&'a str, [f64; 2])>) -> Option<String> {
    let mut wide = hinges.filter(|(_, range)| range.iter().any(|end| end.abs() > TAU + 0.01));
    let (name, [low, high]) = wide.next()?;
    let others = match wide.count() {
        0 => String::new(),
        others => format!(" and those of {others} more"),
    };
    Some(format!(
        "the range of {name}, {low} to {high}{others}, exceeds a full turn of 6.283 radians: if it is in degrees, \
         convert it and all angles"
    ))
}
