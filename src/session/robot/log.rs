//! A log of touches to calibrate by: a table of comma-separated values or JSON, a touch a line.
//!
//! | column | is |
//! |---|---|
//! | `limb_a`, `limb_b` | what touched: a limb (with a point), or a named point or surface |
//! | `ax`, `ay`, `az`, `bx`, `by`, `bz` | the point on a limb or frame, in its frame |
//! | `a_std`, `b_std` | standard deviation of each coordinate |
//! | `distance` | how far apart the two were, where they did not touch |
//! | `touch` | the same in lines of one posture: contacts of which nobody knows who met whom |
//! | `place` | in place of `limb_b`: a fixed place by its name, at `bx`, `by`, `bz` in the root's frame, or nobody knows where |
//! | `time` | when it was logged: what is held out is then a stretch of time |
//! | a joint's name | what its encoder read; empty where it has no part in the touch |
//!
//! A unit behind a name (`ax_mm`, `elbow [deg]`) is minded; without one it is metres and radians. Other columns are passed over.

use std::collections::HashMap;
use std::path::Path;

use csv::StringRecord;
use nalgebra::Vector3;

use crate::calibration::robot::{Element, Knowledge, Posed, Robot, RobotDof, Value};
use crate::calibration::{End, Feature, SAME_POINT, Touch, drop_repeats};
use crate::creature::DofKind;
use crate::error::Error;
use crate::named::did_you_mean;
use crate::plausible::{is_angle, is_length};
use crate::session::angles::{HingeAngles, wide_ranges};
use crate::session::table::{
    CellFault, Column, LIMBS, Measure, POINTS, Quantity, RECEPTORS, Table, read_table,
};
use crate::session::touch_columns::{TouchColumns, coordinate_columns, left_out_in_words};

const DISTANCE: &str = "distance";
const TOUCH: &str = "touch";
const PLACE: &str = "place";
const TIME: &str = "time";
/// The columns of a log of a robot alone.
const FURTHER: [Quantity<'static>; 4] =
    [(DISTANCE, Some(Measure::Length)), (TOUCH, None), (PLACE, None), (TIME, None)];
/// Points farther from their limb than so many times the robot's size look like another unit.
const FAR: f64 = 20.0;

/// A log, read.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationLog {
    /// The touches.
    pub touches: Vec<Touch>,
    /// What looks odd, in sentences: nothing that stands in the way.
    pub notes: Vec<String>,
}

/// Reads a log of touches of a robot.
///
/// # Errors
/// If it cannot be read, or, with line, column and fix, if it is none.
pub fn read_calibration_log(path: &Path, robot: &Robot) -> Result<CalibrationLog, Error> {
    let rows = Rows::read(path, robot)?;
    let (table, columns) = (&rows.table, &rows.columns);
    let mut notes: Vec<String> = table.notes().chain(columns.note()).collect();
    let mut not_finite = Vec::new();
    let mut touches: Vec<Touch> = Vec::new();
    // Lines of one name and links are contacts of one touch; a line without a name is a touch of its own.
    let mut places = HashMap::new();
    for (line, row) in &table.rows {
        let refuse = |fault: String| Err(Error::content(path, Some(*line), fault));
        let touch = match rows.touch(*line, row) {
            Ok(touch) => touch,
            Err(CellFault::NotFinite(fault)) => {
                not_finite.push((*line, fault));
                continue;
            }
            Err(CellFault::Wrong(fault)) => return refuse(fault),
        };
        let name = columns.text(row, TOUCH);
        let links = [0, 1].map(|side: usize| touch.ends[side].first().map(|end| end.feature.link(robot)));
        let place = *places.entry((name.ok_or(line), links)).or_insert(touches.len());
        match touches.get_mut(place) {
            None => touches.push(touch),
            Some(first) if first.posture == touch.posture => {
                first.ends.iter_mut().zip(touch.ends).for_each(|(ends, more)| ends.extend(more));
            }
            Some(first) => {
                return refuse(format!(
                    "touch {} has another posture than on line {}: give lines of one posture one name, others another",
                    name.unwrap_or_default(),
                    first.line
                ));
            }
        }
    }
    let before = touches.len();
    touches.retain(|touch| touch.ends.iter().all(|ends| !ends.is_empty()));
    notes.extend(left_out_in_words(&not_finite, table.rows.len()));
    if touches.len() < before {
        notes.push(format!(
            "{} touches have contacts on one side alone: they are left out",
            before - touches.len()
        ));
    }
    if touches.is_empty() {
        return Err(Error::content(path, None, "it holds no touch: give one with a touch a line"));
    }
    let all = touches.len();
    let repeats = drop_repeats(&mut touches);
    if repeats > 0 {
        notes.push(format!(
            "{repeats} of {all} rows repeat another in the same posture: each touch counts once"
        ));
    }
    notes.extend(rows.check_angles(path, &touches)?);
    rows.refuse_millimetres(path, &touches)?;
    Ok(CalibrationLog { touches, notes })
}

/// Adds to a robot the fixed places that the log's column `place` names: points on its root, known where the log says where
/// they are, and else free about where the robot puts what touched them.
///
/// # Errors
/// As of [`read_calibration_log`]; also where a place is said to be at two positions.
pub fn add_fixed_places(path: &Path, robot: &mut Robot) -> Result<(), Error> {
    let rows = Rows::read(path, robot)?;
    let mut named = Vec::new();
    for (line, row) in &rows.table.rows {
        let Some(name) = rows.columns.text(row, PLACE).filter(|name| robot.surface(name).is_none()) else {
            continue;
        };
        match rows.point(row, 1) {
            Ok(said) => named.push((*line, name.to_string(), said)),
            // The row is left out where the log is read.
            Err(CellFault::NotFinite(_)) => {}
            Err(CellFault::Wrong(fault)) => return Err(Error::content(path, Some(*line), fault)),
        }
    }
    let own = robot.links.len();
    let mut unsaid = Vec::new();
    for (line, name, said) in named {
        match (robot.link(&name), said) {
            (None, _) => {
                let link = robot.add_place(&name, 0, said.unwrap_or_default());
                if said.is_none() {
                    unsaid.push((link, robot.quantities.len() - 1));
                }
            }
            (Some(link), Some(at)) if link >= own => {
                let Element::Shift(position) = robot.links[link].elements[0] else { continue };
                if (robot.quantities[position].nominal.vector() - at).norm() > SAME_POINT {
                    let fault = format!(
                        "place {name} is at another position than before: give it one, or another name"
                    );
                    return Err(Error::content(path, Some(line), fault));
                }
            }
            (Some(_), _) => {}
        }
    }
    if unsaid.is_empty() {
        return Ok(());
    }
    let touches = read_calibration_log(path, robot)?.touches;
    for (link, position) in unsaid {
        let values = robot.nominal();
        let at_place = |touch: &Touch| {
            let here = |end: &&End| end.feature.link(robot) == link;
            touch.ends[1].iter().any(|end| here(&end)).then(|| {
                let end = &touch.ends[0][0];
                let frame = Posed::new(robot, &values, &touch.posture).frames()[end.feature.link(robot)];
                match end.feature {
                    Feature::Point(_, point) => frame.point(&point),
                    Feature::Surface(_) => frame.origin,
                }
            })
        };
        let points: Vec<Vector3<f64>> = touches.iter().filter_map(at_place).collect();
        let middle = points.iter().sum::<Vector3<f64>>() / points.len().max(1) as f64;
        let quantity = &mut robot.quantities[position];
        (quantity.nominal, quantity.knowledge) = (Value::Position(middle), [Knowledge::Free; 3]);
    }
    Ok(())
}

/// Whether bytes look like a log of touches.
pub(super) fn is_log(bytes: &[u8]) -> bool {
    let head = bytes.split(|byte| *byte == b'\n').find(|line| !line.starts_with(b"#")).unwrap_or_default();
    let head = String::from_utf8_lossy(head);
    LIMBS.iter().chain(&RECEPTORS).any(|name| head.split(',').any(|title| title.trim() == *name))
}

/// A table of a robot's touches, and which column holds what.
struct Rows<'r> {
    robot: &'r Robot,
    table: Table,
    columns: TouchColumns,
}

impl<'r> Rows<'r> {
    fn read(path: &Path, robot: &'r Robot) -> Result<Rows<'r>, Error> {
        let columns_of_dof = |dof: &RobotDof| coordinate_columns(&dof.name, dof.kind);
        let coordinates: Vec<_> = robot.leaders().flat_map(columns_of_dof).collect();
        let names: Vec<String> = coordinates.iter().map(|(name, _)| name.clone()).collect();
        let mut table = read_table(path, &names, None)?;
        let columns = TouchColumns::new(&mut table, &coordinates, &FURTHER);
        let columns = columns.and_then(|columns| Rows::checked(columns, robot));
        let columns = columns.map_err(|fault| Error::content(path, Some(1), fault))?;
        Ok(Rows { robot, table, columns })
    }

    /// Columns that name what touched on both sides, and where a joint was.
    fn checked(columns: TouchColumns, robot: &Robot) -> Result<TouchColumns, String> {
        let has = |name: &str| columns.place(name).is_some();
        for side in 0..2 {
            let is_place = side == 1 && has(PLACE);
            if !is_place && !has(LIMBS[side]) && !has(RECEPTORS[side]) {
                return Err(format!("there is no column {}: name what touched on this side", LIMBS[side]));
            }
        }
        let missing = robot.dofs.iter().filter(|dof| columns.posture[dof.coordinate].is_none());
        let missing: Vec<&str> = missing.map(|dof| dof.name.as_str()).collect();
        let spare = &columns.spare;
        if missing.len() == robot.dofs.len() && !missing.is_empty() {
            let example = spare.first().map_or(String::new(), |column| format!(", not \"{}\"", column.title));
            return Err(format!(
                "no column is called as a joint of {}: name them {} …{example}",
                robot.name, missing[0]
            ));
        }
        for column in spare {
            // A column that nearly has a missing joint's name is a slip, one of anything else is somebody's own.
            let called = column.name().to_lowercase();
            if let Some(near) = missing.iter().find(|name| name.to_lowercase() == called) {
                return Err(format!(
                    "column \"{}\" is nearly called as the joint {near}: rename it",
                    column.title
                ));
            }
        }
        Ok(columns)
    }

    fn number(&self, row: &StringRecord, at: usize) -> Result<f64, CellFault> {
        let number = self.table.number(row, at, "a number")?;
        if is_length(number) && is_angle(number) {
            return Ok(number);
        }
        Err(CellFault::Wrong(format!(
            "{}: {} is beyond all that can be: give metres or radians, or leave the touch out",
            self.table.place(at),
            &row[at]
        )))
    }

    /// The touch of a row, or the contact that it has of one.
    fn touch(&self, line: usize, row: &StringRecord) -> Result<Touch, CellFault> {
        let ends = [self.end(row, 0)?, self.end(row, 1)?];
        if self.columns.text(row, TOUCH).is_none() && ends.iter().any(Option::is_none) {
            let side = usize::from(ends[0].is_some());
            let message = format!("column {} is empty: name what touched", LIMBS[side]);
            return Err(CellFault::Wrong(message));
        }
        let distance = self.columns.given(row, DISTANCE).map(|at| self.number(row, at)).transpose()?;
        let links =
            ends.each_ref().map(|end| end.as_ref().map_or(usize::MAX, |end| end.feature.link(self.robot)));
        Ok(Touch {
            line,
            posture: self.posture(row, links)?,
            ends: ends.map(|end| end.into_iter().collect()),
            distance: distance.unwrap_or_default(),
            time: self.columns.text(row, TIME).and_then(|cell| cell.parse().ok()),
        })
    }

    /// The point of a side, if there is one.
    fn point(&self, row: &StringRecord, side: usize) -> Result<Option<Vector3<f64>>, CellFault> {
        let point = self.columns.point(&self.table, row, side)?;
        match point.filter(|point| !point.iter().all(|x| is_length(*x))) {
            None => Ok(point),
            Some(_) => Err(CellFault::Wrong(format!(
                "the point {} is beyond all that can be: give metres, or leave the touch out",
                POINTS[side].join(", ")
            ))),
        }
    }

    fn end(&self, row: &StringRecord, side: usize) -> Result<Option<End>, CellFault> {
        let robot = self.robot;
        let wrong = |message: String| Err(CellFault::Wrong(message));
        let place = self.columns.text(row, PLACE).filter(|_| side == 1);
        let [limb, receptor] = [LIMBS, RECEPTORS].map(|names| self.columns.text(row, names[side]));
        if let (Some(place), Some(other)) = (place, limb.or(receptor)) {
            return wrong(format!(
                "both {place} and {other} are named: leave column place or {} empty",
                LIMBS[1]
            ));
        }
        // A receptor is a point of its own; the limb beside it says no more.
        let receptor = receptor.filter(|name| limb.is_none() || robot.link(name).is_some());
        let Some(name) = receptor.or(limb).or(place) else { return Ok(None) };
        let deviation = self.columns.deviation(&self.table, row, side)?;
        let point = self.point(row, side)?.filter(|_| place.is_none());
        let feature = match (point, robot.surface(name), robot.points_of(name)) {
            (Some(point), _, Some(link)) => Feature::Point(link, point),
            (None, Some(surface), _) => Feature::Surface(surface),
            (None, None, Some(link)) if robot.is_place(link) => Feature::Point(link, Vector3::zeros()),
            (None, None, Some(_)) => {
                return wrong(format!(
                    "{name} has no point: give {} and the others, or name a surface of it",
                    POINTS[side][0]
                ));
            }
            (Some(_), Some(_), None) => {
                return wrong(format!(
                    "{name} is a surface: leave its point out, or name the limb that it is on"
                ));
            }
            (_, None, None) => {
                let links = robot.links.iter().map(|link| link.name.as_str());
                let names = links.chain(robot.surfaces.iter().map(|surface| surface.name.as_str()));
                let names = names.filter(|name| !name.ends_with(".mount"));
                let near = did_you_mean(name, names.clone()).or({ names }.next()).unwrap_or_default();
                return wrong(format!(
                    "column {}: {} has nothing called \"{name}\": name a limb, a point or a surface of it, such as {near}",
                    LIMBS[side], robot.name
                ));
            }
        };
        Ok(Some(End { feature, deviation }))
    }

    /// The posture; joints between the two must have been read.
    fn posture(&self, row: &StringRecord, links: [usize; 2]) -> Result<Vec<f64>, CellFault> {
        let robot = self.robot;
        let mut posture = Vec::with_capacity(self.columns.posture.len());
        let mut not_finite = None;
        for at in &self.columns.posture {
            posture.push(match at.filter(|at| !row[*at].is_empty()).map(|at| self.number(row, at)) {
                Some(Err(fault @ CellFault::NotFinite(_))) => {
                    not_finite.get_or_insert(fault);
                    None
                }
                read => read.transpose()?,
            });
        }
        for (index, dof) in robot.dofs.iter().enumerate() {
            let own = dof.coordinate..dof.coordinate + dof.kind.coordinates();
            if posture[own].iter().any(Option::is_none) && robot.is_between(index, links) {
                if let Some(fault) = not_finite {
                    return Err(fault);
                }
                let unit = if dof.kind == DofKind::Slide { "metres" } else { "angle" };
                let meant = self
                    .columns
                    .spare
                    .iter()
                    .map(Column::name)
                    .find(|name| did_you_mean(name, [dof.name.as_str()]).is_some());
                let meant =
                    meant.map_or(String::new(), |name| format!(", or is {name} meant? Then rename it"));
                return Err(CellFault::Wrong(format!(
                    "{} moves what touched and was not read: give a column {} with its {unit}{meant}",
                    dof.name, dof.name
                )));
            }
        }
        let mut posture: Vec<f64> = posture.into_iter().map(Option::unwrap_or_default).collect();
        for dof in robot.dofs.iter().filter(|dof| dof.kind == DofKind::Ball) {
            let own = &mut posture[dof.coordinate..dof.coordinate + 4];
            let length = own.iter().map(|x| x * x).sum::<f64>().sqrt();
            if length < 0.5 {
                own.copy_from_slice(&[1.0, 0.0, 0.0, 0.0]);
            } else {
                own.iter_mut().for_each(|x| *x /= length);
            }
        }
        Ok(posture)
    }

    /// Refuses angles that most of them are beyond a full turn, and single ones that their joint cannot have; what else looks odd.
    fn check_angles(&self, path: &Path, touches: &[Touch]) -> Result<Vec<String>, Error> {
        let Rows { robot, table, columns } = self;
        let hinges = || robot.dofs.iter().filter(|dof| dof.kind == DofKind::Hinge);
        let mut notes: Vec<String> =
            wide_ranges(hinges().map(|dof| (dof.name.as_str(), dof.range))).into_iter().collect();
        for dof in hinges() {
            let Some(at) = columns.posture.get(dof.coordinate).copied().flatten() else { continue };
            let angles = touches.iter().map(|touch| (touch.line, touch.posture[dof.coordinate])).collect();
            let hinge = HingeAngles { name: &dof.name, range: dof.range, angles };
            if let Some((_, example)) = hinge.degrees().filter(|_| is_si(&table.columns[at])) {
                let message = format!(
                    "{} is {example} and mostly beyond a full turn of 6.283 radians: if these are degrees, call the column {}_deg",
                    dof.name, dof.name
                );
                return Err(Error::content(path, Some(1), message));
            }
            // What follows another has a range of its own, and an encoder may count otherwise than its joint.
            let leads = robot.leaders().any(|leader| leader.name == dof.name);
            if let Some((line, message)) = hinge.impossible().filter(|_| leads) {
                return Err(Error::content(path, Some(line), message));
            }
            notes.extend(hinge.note().filter(|_| leads));
        }
        Ok(notes)
    }

    /// Refuses points that are far from their limb for a robot of this size.
    fn refuse_millimetres(&self, path: &Path, touches: &[Touch]) -> Result<(), Error> {
        let Rows { robot, table, columns } = self;
        let size = reach(robot).max(0.05);
        for (side, [x, y, z]) in POINTS.into_iter().enumerate() {
            let Some(at) = columns.place(x) else { continue };
            if !is_si(&table.columns[at]) {
                continue;
            }
            let mut distances: Vec<f64> = touches
                .iter()
                .flat_map(|touch| &touch.ends[side])
                .filter_map(|end| match end.feature {
                    Feature::Point(_, point) => Some(point.norm()),
                    Feature::Surface(_) => None,
                })
                .collect();
            distances.sort_by(f64::total_cmp);
            let Some(median) = distances.get(distances.len() / 2).copied() else { continue };
            if median > FAR * size {
                let message = format!(
                    "half of the points {x}, {y}, {z} are more than {median:.0} m from their limb's origin, and {} is about \
                 {size:.1} m long: if these are millimetres, call the columns {x}_mm, {y}_mm, {z}_mm",
                    robot.name
                );
                return Err(Error::content(path, Some(1), message));
            }
        }
        Ok(())
    }
}

/// Whether a column's numbers are taken for metres or radians as they stand.
fn is_si(column: &Column) -> bool {
    column.unit.is_none_or(|unit| unit.per == 1.0)
}

/// The longest way from the root out along positions, metres.
fn reach(robot: &Robot) -> f64 {
    let values = robot.nominal();
    let posture = robot.zero_posture();
    let posed = Posed::new(robot, &values, &posture);
    let mut ways = vec![0.0f64; robot.links.len()];
    for link in 1..robot.links.len() {
        ways[link] = ways[robot.links[link].parent] + posed.frame(&[link]).origin.norm();
    }
    ways.into_iter().fold(0.0, f64::max)
}
