//! A log of touches to calibrate by, read and written: a table of comma-separated values or JSON, a touch a line.
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
//! A unit behind a name (`ax_mm`, `elbow [deg]`) is minded; without one it is metres and radians. Other columns are ignored.

use std::collections::HashMap;
use std::fmt::Write;
use std::path::Path;

use csv::StringRecord;
use nalgebra::Vector3;

use crate::calibration::robot::{Element, Knowledge, MOUNT, Posed, Robot, RobotDof, Value};
use crate::calibration::{End, Feature, SAME_POINT, Touch, drop_repeats};
use crate::creature::DofKind;
use crate::error::Error;
use crate::evaluation::Summary;
use crate::named::did_you_mean;
use crate::plausible::{is_angle, is_length};
use crate::session::log::table::{CellFault, LIMBS, POINTS, QUATERNION, Quantity, RECEPTORS};
use crate::session::log::units::Measure;
use crate::session::log::{Log, LogJoint, far_angles};

const DISTANCE: &str = "distance";
const TOUCH: &str = "touch";
const PLACE: &str = "place";
const TIME: &str = "time";
/// The columns of a log of a robot alone.
const FURTHER: [Quantity<'static>; 4] =
    [(DISTANCE, Some(Measure::Length)), (TOUCH, None), (PLACE, None), (TIME, None)];
/// Points farther from their limb than so many times the robot's size look like another unit.
const FAR: f64 = 20.0;
/// A robot that is shorter than this, metres, is taken to be as long.
const LEAST: f64 = 0.05;

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
    let mut log = read_log(path, robot)?;
    let rows = log.rows(|log, line, row| {
        Ok((log.table.text(row, TOUCH).map(str::to_string), touch_of(log, robot, line, row)?))
    })?;
    let mut touches: Vec<Touch> = Vec::new();
    // Lines of one name and links are contacts of one touch; a line without a name is a touch of its own.
    let mut places = HashMap::new();
    for (name, touch) in rows {
        let links = [0, 1].map(|side: usize| touch.ends[side].first().map(|end| end.feature.link(robot)));
        let line = touch.line;
        let place = *places.entry((name.clone().ok_or(line), links)).or_insert(touches.len());
        match touches.get_mut(place) {
            None => touches.push(touch),
            Some(first) if first.posture == touch.posture => {
                first.ends.iter_mut().zip(touch.ends).for_each(|(ends, more)| ends.extend(more));
            }
            Some(first) => {
                let fault = format!(
                    "touch {} has a different posture on line {}: use one name per posture",
                    name.unwrap_or_default(),
                    first.line
                );
                return Err(log.refused(line, fault));
            }
        }
    }
    let before = touches.len();
    touches.retain(|touch| touch.ends.iter().all(|ends| !ends.is_empty()));
    if touches.is_empty() {
        return Err(log.empty(None));
    }
    let (all, repeats) = (touches.len(), drop_repeats(&mut touches));
    let one_sided = (all < before)
        .then(|| format!("{} touches have contacts on one side only; they are ignored", before - all));
    log.notes.extend(one_sided);
    log.note_repeats(repeats, all);
    log.check_angles(touches.iter().map(|touch| (touch.line, &touch.posture[..])))?;
    log.notes.extend(log.hinges().into_iter().filter_map(|(joint, at)| {
        far_angles(joint, touches.iter().map(|touch| (touch.line, touch.posture[at])))
    }));
    refuse_millimetres(&log, robot, &touches)?;
    Ok(CalibrationLog { touches, notes: log.notes })
}

/// Adds to a robot the fixed places that the log's column `place` names: points on its root, known where the log says where
/// they are, and else free about where the robot puts what touched them.
///
/// # Errors
/// As of [`read_calibration_log`]; also where a place is said to be at two positions.
pub fn add_fixed_places(path: &Path, robot: &mut Robot) -> Result<(), Error> {
    let bare = robot.clone();
    let log = read_log(path, &bare)?;
    let mut unsaid = Vec::new();
    for (line, row) in &log.table.rows {
        let Some(name) = log.table.text(row, PLACE).filter(|name| bare.surface(name).is_none()) else {
            continue;
        };
        let said = match point(&log, row, 1) {
            Ok(said) => said,
            // The row is left out where the log is read.
            Err(CellFault::NotFinite(_)) => continue,
            Err(CellFault::Wrong(fault)) => return Err(log.refused(*line, fault)),
        };
        match (robot.link(name), said) {
            (None, _) => {
                let link = robot.add_place(name, 0, said.unwrap_or_default());
                if said.is_none() {
                    unsaid.push((link, robot.quantities.len() - 1));
                }
            }
            (Some(link), Some(at)) if link >= bare.links.len() => {
                let Element::Shift(position) = robot.links[link].elements[0] else { continue };
                if (robot.quantities[position].nominal.vector() - at).norm() > SAME_POINT {
                    let fault = format!(
                        "place {name} is at a different position than before: give it one position, or use another name"
                    );
                    return Err(log.refused(*line, fault));
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

/// Reads a log of a robot: what follows another joint has no column.
fn read_log<'a>(path: &'a Path, robot: &'a Robot) -> Result<Log<'a>, Error> {
    let joints = robot.leaders().map(|dof| LogJoint { name: &dof.name, kind: dof.kind, range: dof.range });
    Log::read(path, joints.collect(), &FURTHER, None, |log| column_fault(log, robot))
}

/// What is wrong with columns that do not name what touched on both sides, and where a joint was.
fn column_fault(log: &Log, robot: &Robot) -> Option<String> {
    let names = |side: usize| {
        log.table.has(LIMBS[side]) || log.table.has(RECEPTORS[side]) || side == 1 && log.table.has(PLACE)
    };
    if let Some(side) = (0..2).find(|&side| !names(side)) {
        return Some(format!("column {} is missing: name the link on this side", LIMBS[side]));
    }
    let missing = robot.dofs.iter().filter(|dof| log.posture[dof.coordinate].is_none());
    let missing: Vec<&str> = missing.map(|dof| dof.name.as_str()).collect();
    if missing.len() == robot.dofs.len() && !missing.is_empty() {
        let example =
            log.table.spare().next().map_or(String::new(), |column| format!(", not \"{}\"", column.title));
        return Some(format!(
            "no column has the name of a joint of {}: name them {} …{example}",
            robot.name, missing[0]
        ));
    }
    log.table.spare().find_map(|column| {
        // A column that nearly has a missing joint's name is a slip, one of anything else is somebody's own.
        let near = missing.iter().find(|name| name.eq_ignore_ascii_case(column.name()))?;
        Some(format!("column \"{}\" resembles the name of joint {near}: rename it", column.title))
    })
}

/// The touch of a row, or the contact that it has of one.
fn touch_of(log: &Log, robot: &Robot, line: usize, row: &StringRecord) -> Result<Touch, CellFault> {
    let ends = [end(log, robot, row, 0)?, end(log, robot, row, 1)?];
    if log.table.text(row, TOUCH).is_none()
        && let Some(side) = ends.iter().position(Option::is_none)
    {
        let message = format!("column {} is empty: name the link", LIMBS[side]);
        return Err(CellFault::Wrong(message));
    }
    let distance = log.table.given(row, DISTANCE).map(|at| number(log, row, at)).transpose()?;
    let links = ends.map(|end| end.map_or(usize::MAX, |end| end.feature.link(robot)));
    Ok(Touch {
        line,
        posture: posture(log, robot, row, links)?,
        ends: ends.map(|end| end.into_iter().collect()),
        distance: distance.unwrap_or_default(),
        time: log.table.text(row, TIME).and_then(|cell| cell.parse().ok()),
    })
}

fn number(log: &Log, row: &StringRecord, at: usize) -> Result<f64, CellFault> {
    let number = log.table.number(row, at, "a number")?;
    if is_length(number) && is_angle(number) {
        return Ok(number);
    }
    let (place, cell) = (log.table.place(at), &row[at]);
    Err(CellFault::Wrong(format!(
        "{place}: {cell} is out of range: give metres or radians, or leave the touch out"
    )))
}

/// The point of a side, if there is one.
fn point(log: &Log, row: &StringRecord, side: usize) -> Result<Option<Vector3<f64>>, CellFault> {
    let point = log.point(row, side)?;
    match point.filter(|point| !point.iter().all(|x| is_length(*x))) {
        None => Ok(point),
        Some(_) => Err(CellFault::Wrong(format!(
            "the point {} is out of range: give metres, or leave the touch out",
            POINTS[side].join(", ")
        ))),
    }
}

/// What touched on a side.
fn end(log: &Log, robot: &Robot, row: &StringRecord, side: usize) -> Result<Option<End>, CellFault> {
    let wrong = |message: String| Err(CellFault::Wrong(message));
    let place = log.table.text(row, PLACE).filter(|_| side == 1);
    let [limb, receptor] = [LIMBS, RECEPTORS].map(|names| log.table.text(row, names[side]));
    if let (Some(place), Some(other)) = (place, limb.or(receptor)) {
        let column = LIMBS[1];
        return wrong(format!("both {place} and {other} are given: leave column place or {column} empty"));
    }
    // A receptor is a point of its own; the limb beside it says no more.
    let receptor = receptor.filter(|name| limb.is_none() || robot.link(name).is_some());
    let Some(name) = receptor.or(limb).or(place) else { return Ok(None) };
    let deviation = log.deviation(row, side)?;
    let point = point(log, row, side)?.filter(|_| place.is_none());
    let feature = match (point, robot.surface(name), robot.points_of(name)) {
        (Some(point), _, Some(link)) => Feature::Point(link, point),
        (None, Some(surface), _) => Feature::Surface(surface),
        (None, None, Some(link)) if robot.is_place(link) => Feature::Point(link, Vector3::zeros()),
        (None, None, Some(_)) => {
            let column = POINTS[side][0];
            return wrong(format!(
                "{name} has no point: give {column} and the others, or name one of its surfaces"
            ));
        }
        (Some(_), Some(_), None) => {
            return wrong(format!("{name} is a surface: leave its point out, or name its limb"));
        }
        (_, None, None) => {
            let links = robot.links.iter().map(|link| link.name.as_str());
            let names = links.chain(robot.surfaces.iter().map(|surface| surface.name.as_str()));
            let names = names.filter(|name| !name.ends_with(".mount"));
            let near = did_you_mean(name, names.clone()).or({ names }.next()).unwrap_or_default();
            return wrong(format!(
                "column {}: {} has nothing called \"{name}\": name one of its limbs, points or surfaces, such as {near}",
                LIMBS[side], robot.name
            ));
        }
    };
    Ok(Some(End { feature, deviation }))
}

/// The posture; joints between the two must have been read.
fn posture(log: &Log, robot: &Robot, row: &StringRecord, links: [usize; 2]) -> Result<Vec<f64>, CellFault> {
    let mut posture = Vec::with_capacity(log.posture.len());
    let mut not_finite = None;
    for at in &log.posture {
        posture.push(match at.filter(|at| !row[*at].is_empty()).map(|at| number(log, row, at)) {
            Some(Err(fault @ CellFault::NotFinite(_))) => {
                not_finite.get_or_insert(fault);
                None
            }
            read => read.transpose()?,
        });
    }
    for (index, dof) in robot.dofs.iter().enumerate() {
        let own = dof.coordinate..dof.coordinate + dof.kind.coordinates();
        if posture[own].iter().all(Option::is_some) || !robot.is_between(index, links) {
            continue;
        }
        let unit = if dof.kind == DofKind::Slide { "metres" } else { "angle" };
        let (name, meant) = (&dof.name, log.meant(&dof.name));
        return Err(not_finite.unwrap_or_else(|| {
            CellFault::Wrong(format!(
                "joint {name} moves a touched link but has no reading: give a column {name} with its {unit}{meant}"
            ))
        }));
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

/// Refuses points that are far from their limb for a robot of this size.
fn refuse_millimetres(log: &Log, robot: &Robot, touches: &[Touch]) -> Result<(), Error> {
    let size = reach(robot).max(LEAST);
    for (side, [x, y, z]) in POINTS.into_iter().enumerate() {
        let distances =
            touches.iter().flat_map(|touch| &touch.ends[side]).filter_map(|end| match end.feature {
                Feature::Point(_, point) => Some(point.norm()),
                Feature::Surface(_) => None,
            });
        let median = Summary::of(distances).median;
        if median > FAR * size && log.table.at(x).is_some_and(|at| log.table.columns[at].is_si()) {
            let message = format!(
                "half of the points {x}, {y}, {z} are more than {median:.0} m from their limb's origin, and {} is about \
                 {size:.1} m long: if these are millimetres, call the columns {x}_mm, {y}_mm, {z}_mm",
                robot.name
            );
            return Err(log.refused(log.table.line, message));
        }
    }
    Ok(())
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

/// Touches as a log that [`read_calibration_log`] reads, with further columns behind: a title and a
/// cell for each touch. Of several contacts the first of either side is written.
pub fn calibration_table(robot: &Robot, touches: &[&Touch], further: &[(&str, Vec<String>)]) -> String {
    let mut titles = joint_titles(robot);
    titles.extend(further.iter().map(|(title, _)| title.to_string()));
    let mut table = format!("limb_a,limb_b,ax,ay,az,bx,by,bz,{}\n", titles.join(","));
    for (k, touch) in touches.iter().enumerate() {
        let mut cells: Vec<String> =
            (0..2).map(|side| name_of(robot, &touch.ends[side][0].feature)).collect();
        for ends in &touch.ends {
            cells.push(match ends[0].feature {
                Feature::Point(_, p) => format!("{:.7},{:.7},{:.7}", p.x, p.y, p.z),
                Feature::Surface(_) => ",,".into(),
            });
        }
        cells.extend(joint_cells(robot, &touch.posture));
        cells.extend(further.iter().filter_map(|(_, column)| column.get(k).cloned()));
        let _ = writeln!(table, "{}", cells.join(","));
    }
    table
}

/// The columns of what encoders read.
pub(crate) fn joint_titles(robot: &Robot) -> Vec<String> {
    let titles = |dof: &RobotDof| match dof.kind {
        DofKind::Hinge => vec![format!("{}_deg", dof.name)],
        DofKind::Slide => vec![dof.name.clone()],
        DofKind::Ball => QUATERNION.map(|end| format!("{}{end}", dof.name)).to_vec(),
    };
    robot.leaders().flat_map(titles).collect()
}

/// What encoders read in these columns.
pub(crate) fn joint_cells(robot: &Robot, posture: &[f64]) -> Vec<String> {
    let mut cells = Vec::new();
    for dof in robot.leaders() {
        let own = &posture[dof.coordinate..dof.coordinate + dof.kind.coordinates()];
        let number = |x: &f64| match dof.kind {
            DofKind::Hinge => format!("{:.5}", x.to_degrees()),
            DofKind::Slide | DofKind::Ball => format!("{x:.7}"),
        };
        cells.extend(own.iter().map(number));
    }
    cells
}

/// What a log calls a feature: its surface, or the link that its point is on.
pub(crate) fn name_of(robot: &Robot, feature: &Feature) -> String {
    match *feature {
        Feature::Surface(surface) => robot.surfaces[surface].name.clone(),
        Feature::Point(link, _) => robot.links[link].name.trim_end_matches(MOUNT).to_string(),
    }
}
