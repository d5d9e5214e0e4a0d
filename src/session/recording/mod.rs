//! Self-touch recordings of a body that no simulator knows: a creature by hand, a log of touches from anywhere.
//!
//! A creature comes from a JSON file ([`read_creature`]), the log from a [table](super::log::table) ([`read_recording`]). What a touch
//! needs is where the joints were, which two limbs met, and either the point of contact in both limbs' frames or the receptors
//! that felt it. Limbs without a skin get [bare receptors](bare_receptors), so that such a recording is a session as any other.

mod creature_file;

use std::collections::BTreeMap;
use std::path::Path;

use csv::StringRecord;
use nalgebra::Vector3;

pub use creature_file::{CreatureFile, read_creature};
pub(super) use creature_file::{creature_of, list, typed};

use super::log::table::{CellFault, LIMBS, POINTS, RECEPTORS};
use super::log::{Log, LogJoint, far_angles};
use super::touch_log::check;
use super::{
    BabbledSession, LearningOptions, Observer, RecordingFiles, Session, SessionOptions, TouchWriter,
    UNIT_LENGTH,
};
use crate::agent::Agent;
use crate::calibration::{SAME_POINT, SAME_POSTURE, drop_alike};
use crate::creature::{DofKind, Posture};
use crate::error::Error;
use crate::evaluation::Summary;
use crate::named::listed;
use crate::senses::{ExactContact, Input, RecordedTouch, Touch, TouchEnd};
use crate::skin::{Receptor, Skin};

/// Bare receptors of a limb at the most.
const BARE_RECEPTORS: usize = 12;
/// How far from 1 the length of a quaternion may be that was written with few digits; it is then scaled.
const ROUNDED: f64 = 0.01;
/// Points farther from their limb's origin than this, metres, on the median look like millimetres; a single one so many times
/// as far as the median is worth a note.
const FAR: f64 = 10.0;
/// A limb that is shorter than this, metres, is taken to be as long.
const LEAST: f64 = 0.05;
/// Share of a degree of freedom's coordinates beyond its range that is worth a note.
const BEYOND_SHARE: f64 = 0.05;
/// How far they are beyond it then at the least, radians and metres.
const BEYOND: f64 = 0.02;

/// A log of touches, and the skin that they are on.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// The agent that was given, with bare receptors if limbs were touched that have none.
    pub agent: Agent,
    /// The touches in the log's order.
    pub touches: Vec<RecordedTouch>,
    /// What the touches report: points if every touch has them and one lacks receptors, else receptors.
    pub input: Input,
    /// What looks odd, in sentences: nothing that stands in the way.
    pub notes: Vec<String>,
}

/// A touch as its row has it, of limbs and receptors that there are; its posture in the creature's order.
struct RawTouch {
    line: usize,
    bout: Option<u64>,
    motion: Option<u64>,
    posture: Posture,
    ends: [RawEnd; 2],
}

/// One end of such a touch.
struct RawEnd {
    limb: usize,
    /// The receptor, if it is named and the skin has it.
    receptor: Option<usize>,
    /// The point of contact in the limb's frame, metres.
    point: Option<Vector3<f64>>,
    /// Standard deviation of each of its coordinates, metres.
    deviation: Option<f64>,
}

/// Reads a recording's touches from `path`: JSON or a table of comma-separated values, packed by gzip or not.
///
/// # Errors
/// If the file cannot be read, or, with line and column, for what is
/// no touch of the creature; for a log without touches; and for one whose angles look like degrees.
pub fn read_recording(path: &Path, agent: &Agent) -> Result<Recording, Error> {
    let creature = agent.creature();
    let joints = creature.dofs().map(|dof| LogJoint { name: &dof.name, kind: dof.kind, range: dof.range });
    let mut log = Log::read(path, joints.collect(), &[], Some(creature), missing)?;
    let rows = log.rows(|log, line, row| raw_touch(log, line, row, agent))?;
    let postures = rows.iter().map(|touch| (touch.line, &touch.posture[..]));
    log.check_angles(postures)?;
    let odd: Vec<String> = out_of_range(&log, &rows).chain(far_points(&rows, creature.limbs())).collect();
    let (agent, mut touches) = resolve(&log, agent, &rows)?;
    let repeats = drop_repeats(&mut touches);
    log.notes.extend(odd);
    log.note_repeats(repeats, rows.len());
    let all_receptors = rows.iter().flat_map(|touch| &touch.ends).all(|end| end.receptor.is_some());
    if let Some(without) = rows.iter().find(|touch| touch.ends.iter().any(|end| end.point.is_none()))
        && !all_receptors
    {
        let message = "this touch has only receptors, others only points: give points in every touch, or receptors in every touch";
        return Err(log.refused(without.line, message));
    }
    let input = if all_receptors { Input::Receptor } else { Input::Contact };
    Ok(Recording { agent, touches, input, notes: log.notes })
}

impl BabbledSession {
    /// Reads a recording: the description of the `creature` in JSON, and the `log` of touches, a table or JSON by its
    /// content, of which at most the first `most` are used. The observer is told of what is odd about it. The seed is `seed`,
    /// else the description's. Ranges of joints become what the touches visit: a log shows no other postures, and a
    /// description often gives a whole turn for want of better.
    ///
    /// # Errors
    /// If a file cannot be read, or is not what it should be.
    pub fn of_recording(
        (creature, log): (&Path, &Path),
        most: usize,
        seed: Option<u64>,
        learning: &LearningOptions,
        command: Vec<String>,
        observer: &dyn Observer,
    ) -> Result<BabbledSession, Error> {
        let described = read_creature(creature)?;
        let recording = read_recording(log, &described.agent)?;
        for note in &recording.notes {
            observer.note(&format!("{}: {note}", log.display()));
        }
        let mut touches = recording.touches;
        touches.truncate(most);
        let visited = recording.agent.creature().visited(touches.iter().map(|touch| &touch.posture));
        let path = |path: &Path| path.display().to_string();
        let session = Session {
            recording: Some(RecordingFiles { creature: path(creature), log: path(log) }),
            command,
            seed: seed.or(described.seed).unwrap_or(1),
            options: SessionOptions {
                touches: touches.len(),
                joints: "all".to_string(),
                input: Some(learning.input.unwrap_or(recording.input).to_string()),
                learner: Some(learning.kind().name().to_string()),
                known: learning.known.as_ref().map(|known| known.display().to_string()),
                ..SessionOptions::default()
            },
            agent: Agent::new(visited, recording.agent.skin().clone())?,
            ..Session::made_here()
        };
        Ok(BabbledSession { session, touches, grown: None })
    }

    /// Writes the session and its touches into a folder.
    ///
    /// # Errors
    /// If a file cannot be written, or there is a log in the folder already.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        let mut writer = TouchWriter::create(folder, &self.session.agent)?;
        self.touches.iter().try_for_each(|touch| writer.write(touch))?;
        writer.finish()?;
        self.session.write(folder)
    }
}

/// The column that a log lacks of those that every touch needs.
fn missing(log: &Log) -> Option<String> {
    let lacks = |(joint, at): &(LogJoint, usize)| {
        log.posture[*at..at + joint.kind.coordinates()].iter().position(Option::is_none)
    };
    if let Some((joint, k)) = log.joints().find_map(|joint| Some((joint.0, lacks(&joint)?))) {
        let (name, _) = &joint.columns()[k];
        return Some(format!("column {name} is missing: add this degree of freedom{}", log.meant(name)));
    }
    let side = [0, 1].into_iter().find(|&side| {
        !(log.table.has(RECEPTORS[side]) || log.table.has(LIMBS[side]) && log.table.has(POINTS[side][0]))
    })?;
    let (limb, receptor, [x, y, z]) = (LIMBS[side], RECEPTORS[side], POINTS[side]);
    let missing = if log.table.has(limb) { x } else { limb };
    Some(format!("column {missing} is missing: give {limb} with {x}, {y}, {z}, or {receptor}"))
}

/// The touch of a row. Quaternions that were rounded when they were written are scaled; those that fit to the last digits stay.
fn raw_touch(log: &Log, line: usize, row: &StringRecord, agent: &Agent) -> Result<RawTouch, CellFault> {
    let number = |at: &usize| log.table.number(row, *at, "radians, or metres of a slide");
    let mut posture = log.posture.iter().flatten().map(number).collect::<Result<Vec<f64>, _>>()?;
    for ball in agent.creature().elements().filter(|element| element.is_ball()) {
        let coordinates = ball.of_mut(&mut posture);
        let length = coordinates.iter().map(|x| x * x).sum::<f64>().sqrt();
        let off = (length - 1.0).abs();
        if off > UNIT_LENGTH && off < ROUNDED {
            coordinates.iter_mut().for_each(|x| *x /= length);
        }
    }
    Ok(RawTouch {
        line,
        bout: log.count(row, "bout")?,
        motion: log.count(row, "motion")?,
        ends: [raw_end(log, row, 0, agent)?, raw_end(log, row, 1, agent)?],
        posture: posture.into(),
    })
}

/// Coordinates beyond their ranges, as sentences.
fn out_of_range(log: &Log, touches: &[RawTouch]) -> impl Iterator<Item = String> {
    log.joints().filter(|(joint, _)| joint.kind != DofKind::Ball).filter_map(|(joint, at)| {
        let LogJoint { name, range: [low, high], .. } = joint;
        let values = || touches.iter().map(|touch| touch.posture[at]);
        let beyond = values().filter(|x| *x < low - BEYOND || *x > high + BEYOND).count();
        if beyond as f64 <= BEYOND_SHARE * touches.len() as f64 {
            let angles = touches.iter().map(|touch| (touch.line, touch.posture[at]));
            return far_angles(joint, angles).filter(|_| joint.kind == DofKind::Hinge);
        }
        let [least, most] =
            [values().fold(f64::INFINITY, f64::min), values().fold(-f64::INFINITY, f64::max)];
        Some(format!(
            "{name} goes from {least:.3} to {most:.3}, beyond its range of {low:.3} to {high:.3}, in {beyond} of \
             {} touches: correct the range in the creature file, or the angles' sign or zero",
            touches.len()
        ))
    })
}

/// The first point that is far from its limb for a point of it, and points that are all far, as sentences.
fn far_points(touches: &[RawTouch], limbs: &[String]) -> impl Iterator<Item = String> {
    let mut of_limbs = BTreeMap::<usize, Vec<(usize, f64)>>::new();
    for (line, end) in touches.iter().flat_map(|touch| touch.ends.iter().map(|end| (touch.line, end))) {
        let distance = end.point.map(|point| point.norm());
        of_limbs.entry(end.limb).or_default().extend(distance.map(|distance| (line, distance)));
    }
    let median = |points: &[(usize, f64)]| Summary::of(points.iter().map(|(_, distance)| *distance)).median;
    let one = of_limbs.iter().find_map(|(limb, points)| {
        let usual = median(points).max(LEAST);
        let (line, far) = points.iter().find(|(_, distance)| *distance > FAR * usual)?;
        let limb = &limbs[*limb];
        Some(format!(
            "on line {line} the point on {limb} is {far:.3} m from its origin, but half of its points are within \
             {usual:.3} m: correct it, or leave the touch out"
        ))
    });
    let median = median(&of_limbs.into_values().flatten().collect::<Vec<_>>());
    let millimetres = (median > FAR).then(|| {
        format!(
            "half of the points are more than {median:.0} m from their limb's origin: if they are in millimetres, \
             convert them to metres"
        )
    });
    one.into_iter().chain(millimetres)
}

/// Leaves of touches that repeat one another the first; how many went.
fn drop_repeats(touches: &mut Vec<RecordedTouch>) -> usize {
    drop_alike(touches, |touch| {
        let posture = touch.posture.iter().map(|x| x / SAME_POSTURE);
        let points = touch.exact_contact().points.iter().flatten().map(|x| x / SAME_POINT);
        ((touch.bout, touch.ends.map(|end| end.receptor)), posture.chain(points).collect())
    })
}

/// Gives every touch its receptors, in the order of their limbs, on limbs without a skin bare ones.
fn resolve(log: &Log, agent: &Agent, raw: &[RawTouch]) -> Result<(Agent, Vec<RecordedTouch>), Error> {
    let limbs = agent.creature().limbs();
    let mut points = vec![Vec::new(); limbs.len()];
    for end in raw.iter().flat_map(|touch| &touch.ends).filter(|end| end.receptor.is_none()) {
        points[end.limb].extend(end.point);
    }
    let mut skin = agent.skin().clone();
    for (limb, points) in points.iter().enumerate() {
        if skin.receptors_on(limb).next().is_none() {
            skin.receptors.extend(bare_receptors(&limbs[limb], limb, points));
        }
    }
    let agent = agent.with_skin(skin).map_err(|error| Error::unfit(log.path, error.to_string()))?;
    let skin = agent.skin();
    let mut touches = Vec::with_capacity(raw.len());
    for (number, found) in raw.iter().enumerate() {
        // The end on the earlier limb comes first.
        let [a, b] = &found.ends;
        let ends = if a.limb > b.limb { [b, a] } else { [a, b] };
        let receptors = ends.map(|end| {
            let receptor = end.receptor.or_else(|| nearest(skin, end.limb, &end.point?));
            receptor.expect("an end has a receptor or a point")
        });
        let touch = Touch {
            bout: found.bout.unwrap_or(0),
            motion: found.motion.unwrap_or(number as u64 + 1),
            posture: found.posture.clone(),
            ends: receptors.map(TouchEnd::at),
            moment: None,
        };
        let point = |k: usize| ends[k].point.unwrap_or(skin.receptors[receptors[k]].position);
        let deviations = ends.map(|end| end.deviation);
        let contact = ExactContact { points: [point(0), point(1)], deviations, depth: None };
        let touch = RecordedTouch::new(touch, contact);
        check(&touch, &agent).map_err(|fault| log.refused(found.line, fault))?;
        touches.push(touch);
    }
    Ok((agent, touches))
}

/// One end of the touch of a row, on the limb of its receptor or on the one that is named.
fn raw_end(log: &Log, row: &StringRecord, k: usize, agent: &Agent) -> Result<RawEnd, CellFault> {
    let (creature, skin, side) = (agent.creature(), agent.skin(), ["a", "b"][k]);
    let wrong = |message: String| Err(CellFault::Wrong(message));
    let (point, deviation) = (log.point(row, k)?, log.deviation(row, k)?);
    let [limb, id] = [LIMBS, RECEPTORS].map(|names| log.table.text(row, names[k]));
    let named = limb.and_then(|name| creature.limb(name));
    if let (Some(name), None) = (limb, named) {
        let (column, all) = (LIMBS[k], listed(creature.limbs()));
        return wrong(format!(
            "column {column}: {} has no limb \"{name}\": choose one of {all}",
            creature.name()
        ));
    }
    let receptor = id.and_then(|id| skin.receptor(id));
    let felt = receptor.map(|receptor| skin.receptors[receptor].limb);
    let limb = match (felt, named, id) {
        (Some(felt), Some(named), Some(id)) if felt != named => {
            let (column, [felt, named]) = (LIMBS[k], [felt, named].map(|limb| &creature.limbs()[limb]));
            return wrong(format!(
                "column {column}: receptor \"{id}\" is on limb {felt}, not on {named}: correct one of the two"
            ));
        }
        (Some(limb), ..) => limb,
        (None, _, Some(id)) if point.is_none() || named.is_none() => {
            let mend = if skin.receptors.is_empty() {
                "add a skin to the creature file, or give limbs and points instead of receptors"
            } else {
                "give the skin that the touches were recorded with"
            };
            return wrong(format!("column {}: the skin has no receptor \"{id}\": {mend}", RECEPTORS[k]));
        }
        (None, Some(_), _) if point.is_none() => {
            return wrong(format!(
                "end {side} has a limb but no point on it: give the point of contact in the limb's frame, or a receptor"
            ));
        }
        (None, Some(limb), _) => limb,
        (None, None, _) => {
            return wrong(format!("end {side} has no limb: name the limb, or a receptor of the skin"));
        }
    };
    Ok(RawEnd { limb, receptor, point, deviation })
}

/// The receptor of a limb whose centre is nearest to a point.
fn nearest(skin: &Skin, limb: usize, point: &Vector3<f64>) -> Option<usize> {
    let distance = |receptor: usize| (skin.receptors[receptor].position - point).norm_squared();
    let on_limb = skin.receptors_on(limb);
    on_limb.min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
}

/// Receptors of a limb that has no skin: without extent or surface, at points where it was touched, each as far
/// from those before as there is one.
fn bare_receptors(name: &str, limb: usize, points: &[Vector3<f64>]) -> Vec<Receptor> {
    let mut centres: Vec<Vector3<f64>> = Vec::new();
    let mut distances = vec![f64::INFINITY; points.len()];
    while centres.len() < BARE_RECEPTORS {
        let farthest = (0..points.len()).max_by(|&a, &b| distances[a].total_cmp(&distances[b]));
        let Some(farthest) = farthest.filter(|&i| distances[i] > 0.0) else { break };
        centres.push(points[farthest]);
        for (distance, point) in distances.iter_mut().zip(points) {
            *distance = distance.min((point - points[farthest]).norm());
        }
    }
    let receptor = |(i, position)| Receptor {
        id: format!("{name}/{}", i + 1),
        limb,
        position,
        normal: Vector3::z(),
        tangent: Vector3::x(),
        half_extents: [0.0; 2],
        surface: None,
    };
    centres.into_iter().enumerate().map(receptor).collect()
}
