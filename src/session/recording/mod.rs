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

use super::babbling::BabbledSession;
use super::learning_options::LearningOptions;
use super::log::table::{CellFault, LIMBS, POINTS, RECEPTORS};
use super::log::{Log, LogEnd, LogJoint, far_angles};
use super::observer::Observer;
use super::touch_log::check;
use super::{RecordingFiles, Session, SessionOptions, TouchWriter, UNIT_LENGTH};
use crate::agent::Agent;
use crate::calibration::{SAME_POINT, SAME_POSTURE, drop_alike};
use crate::creature::{Creature, DofKind, Posture};
use crate::error::Error;
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

/// A touch before it is known whether creature and skin have what it names; its posture in the creature's order.
struct RawTouch {
    line: usize,
    bout: Option<u64>,
    motion: Option<u64>,
    posture: Posture,
    ends: [LogEnd; 2],
}

impl LogEnd {
    /// The receptor, an index into the skin; `None` if the skin does not have it.
    fn of_skin(&self, skin: &Skin) -> Option<usize> {
        self.receptor.as_ref().and_then(|id| skin.receptor(id))
    }
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
    let rows = log.rows(|log, line, row| raw_touch(log, line, row, creature))?;
    let postures = rows.iter().map(|touch| (touch.line, &touch.posture[..]));
    log.check_angles(postures)?;
    let odd: Vec<String> = out_of_range(&log, &rows).chain(far_points(&rows)).collect();
    let Recording { agent, mut touches, input, .. } = resolve(&log, agent, &rows)?;
    let repeats = drop_repeats(&mut touches);
    log.notes.extend(odd);
    log.note_repeats(repeats, rows.len());
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
                learner: Some(learning.learner.name().to_string()),
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
    let side = [0, 1]
        .into_iter()
        .find(|&side| !(log.has(RECEPTORS[side]) || log.has(LIMBS[side]) && log.has(POINTS[side][0])))?;
    let (limb, receptor, [x, y, z]) = (LIMBS[side], RECEPTORS[side], POINTS[side]);
    let missing = if log.has(limb) { x } else { limb };
    Some(format!("column {missing} is missing: give {limb} with {x}, {y}, {z}, or {receptor}"))
}

/// The touch of a row. Quaternions that were rounded when they were written are scaled; those that fit to the last digits stay.
fn raw_touch(log: &Log, line: usize, row: &StringRecord, creature: &Creature) -> Result<RawTouch, CellFault> {
    let number = |at: &usize| log.table.number(row, *at, "radians, or metres of a slide");
    let mut posture = log.posture.iter().flatten().map(number).collect::<Result<Vec<f64>, _>>()?;
    for ball in creature.elements().filter(|element| element.is_ball()) {
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
        ends: [log.end(row, 0)?, log.end(row, 1)?],
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
fn far_points(touches: &[RawTouch]) -> impl Iterator<Item = String> {
    let (mut of_limbs, mut all) = (BTreeMap::<&str, Vec<(usize, f64)>>::new(), Vec::new());
    for (touch, end) in touches.iter().flat_map(|touch| touch.ends.iter().map(move |end| (touch, end))) {
        let Some(distance) = end.point.map(|point| point.norm()) else { continue };
        all.push(distance);
        if let Some(limb) = &end.limb {
            of_limbs.entry(limb).or_default().push((touch.line, distance));
        }
    }
    let one = of_limbs.into_iter().find_map(|(limb, points)| {
        let usual = median(points.iter().map(|(_, distance)| *distance).collect())?.max(LEAST);
        let (line, far) = points.into_iter().find(|(_, distance)| *distance > FAR * usual)?;
        Some(format!(
            "on line {line} the point on {limb} is {far:.3} m from its origin, but half of its points are within \
             {usual:.3} m: correct it, or leave the touch out"
        ))
    });
    let millimetres = median(all).filter(|median| *median > FAR).map(|median| {
        format!(
            "half of the points are more than {median:.0} m from their limb's origin: if they are in millimetres, \
             convert them to metres"
        )
    });
    one.into_iter().chain(millimetres)
}

/// The middle one of some numbers.
pub(super) fn median(mut numbers: Vec<f64>) -> Option<f64> {
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied()
}

/// Leaves of touches that repeat one another the first; how many went.
fn drop_repeats(touches: &mut Vec<RecordedTouch>) -> usize {
    drop_alike(touches, |touch| {
        let posture = touch.posture.iter().map(|x| x / SAME_POSTURE);
        let points = touch.exact_contact().points.iter().flatten().map(|x| x / SAME_POINT);
        ((touch.bout, touch.ends.map(|end| end.receptor)), posture.chain(points).collect())
    })
}

/// Gives every touch its limbs and receptors.
fn resolve(log: &Log, agent: &Agent, raw: &[RawTouch]) -> Result<Recording, Error> {
    let limbs = agent.creature().limbs();
    let met = raw.iter().map(|touch| {
        let limbs = limb_of(agent, touch, 0).and_then(|a| Ok([a, limb_of(agent, touch, 1)?]));
        limbs.map_err(|fault| log.refused(touch.line, fault))
    });
    let met: Vec<[usize; 2]> = met.collect::<Result<_, _>>()?;
    let mut points = vec![Vec::new(); limbs.len()];
    for (end, &limb) in raw.iter().flat_map(|touch| &touch.ends).zip(met.iter().flatten()) {
        if end.of_skin(agent.skin()).is_none() {
            points[limb].extend(end.point);
        }
    }
    let mut skin = agent.skin().clone();
    let given = skin.receptors.len();
    for (limb, points) in points.iter().enumerate() {
        if skin.receptors_on(limb).next().is_none() {
            skin.receptors.extend(bare_receptors(&limbs[limb], limb, points));
        }
    }
    let agent = agent.with_skin(skin).map_err(|error| Error::unfit(log.path, error.to_string()))?;
    let skin = agent.skin();
    let named = |end: &LogEnd| end.of_skin(skin).filter(|&receptor| receptor < given);
    let all_receptors = raw.iter().flat_map(|touch| &touch.ends).all(|end| named(end).is_some());
    let mut touches = Vec::with_capacity(raw.len());
    for (number, (found, limbs)) in raw.iter().zip(&met).enumerate() {
        // The end on the earlier limb comes first.
        let order = if limbs[0] > limbs[1] { [1, 0] } else { [0, 1] };
        let receptors = order.map(|k| {
            let end = &found.ends[k];
            let receptor = named(end).or_else(|| nearest(skin, limbs[k], &end.point?));
            receptor.expect("an end has a receptor or a point")
        });
        let touch = Touch {
            bout: found.bout.unwrap_or(0),
            motion: found.motion.unwrap_or(number as u64 + 1),
            posture: found.posture.clone(),
            ends: receptors.map(TouchEnd::at),
            moment: None,
        };
        let point = |k: usize| found.ends[order[k]].point.unwrap_or(skin.receptors[receptors[k]].position);
        let deviations = order.map(|k| found.ends[k].deviation);
        let contact = ExactContact { points: [point(0), point(1)], deviations, depth: None };
        let touch = RecordedTouch::new(touch, contact);
        check(&touch, &agent).map_err(|fault| log.refused(found.line, fault))?;
        touches.push(touch);
    }
    if let Some(without) = raw.iter().find(|touch| touch.ends.iter().any(|end| end.point.is_none()))
        && !all_receptors
    {
        let message = "this touch has only receptors, others only points: give points in every touch, or receptors in every touch";
        return Err(log.refused(without.line, message));
    }
    let input = if all_receptors { Input::Receptor } else { Input::Contact };
    Ok(Recording { agent, touches, input, notes: Vec::new() })
}

/// The limb of one end of a touch: where its receptor is, or the one that is named.
fn limb_of(agent: &Agent, touch: &RawTouch, k: usize) -> Result<usize, String> {
    let (creature, skin) = (agent.creature(), agent.skin());
    let (end, side, limbs) = (&touch.ends[k], ["a", "b"][k], creature.limbs());
    let limb = |name: &String| {
        creature.limb(name).ok_or_else(|| {
            let (column, all) = (LIMBS[k], listed(limbs));
            format!("column {column}: {} has no limb \"{name}\": choose one of {all}", creature.name())
        })
    };
    let named = end.limb.as_ref().map(limb).transpose()?;
    let felt = end.of_skin(skin).map(|receptor| skin.receptors[receptor].limb);
    match (felt, named, &end.receptor) {
        (Some(felt), Some(named), Some(id)) if felt != named => {
            let (column, [felt, named]) = (LIMBS[k], [felt, named].map(|limb| &limbs[limb]));
            Err(format!(
                "column {column}: receptor \"{id}\" is on limb {felt}, not on {named}: correct one of the two"
            ))
        }
        (Some(limb), ..) => Ok(limb),
        (None, _, Some(id)) if end.point.is_none() || named.is_none() => {
            let mend = if skin.receptors.is_empty() {
                "add a skin to the creature file, or give limbs and points instead of receptors"
            } else {
                "give the skin that the touches were recorded with"
            };
            Err(format!("column {}: the skin has no receptor \"{id}\": {mend}", RECEPTORS[k]))
        }
        (None, Some(_), _) if end.point.is_none() => Err(format!(
            "end {side} has a limb but no point on it: give the point of contact in the limb's frame, or a receptor"
        )),
        (None, Some(limb), _) => Ok(limb),
        (None, None, _) => Err(format!("end {side} has no limb: name the limb, or a receptor of the skin")),
    }
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
