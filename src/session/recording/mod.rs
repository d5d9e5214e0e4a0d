//! Self-touch recordings of a body that no simulator knows: a creature by hand, a log of touches from anywhere.
//!
//! A creature comes from a JSON file ([`read_creature`]), the log from lines of JSON or from comma-separated
//! values ([`read_recording`]). What a touch needs is where the joints were, which two limbs met, and either the
//! point of contact in both limbs' frames or the receptors that felt it. Limbs without a skin get [bare
//! receptors](bare_receptors), so that such a recording is a session as any other.

mod creature_file;
mod csv_log;
mod json_log;
mod posture;
mod raw;

use std::path::Path;

use nalgebra::Vector3;

pub use creature_file::{CreatureFile, read_creature};
use raw::{RawEnd, RawTouch};

use super::RecordError;
use super::given_log::{cut_in_words, read_log};
use super::touch_line::check;
use crate::agent::Agent;
use crate::calibration::{SAME_POINT, SAME_POSTURE, first_alike};
use crate::learning::Input;
use crate::senses::{Touch, TouchEnd};
use crate::session::record_error::ContentFault;
use crate::skin::{Receptor, Skin};

/// Bare receptors of a limb at the most.
const BARE_RECEPTORS: usize = 12;

/// A log of touches, and the skin that they are on.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// The agent that was given, with bare receptors where limbs were touched that have none.
    pub agent: Agent,
    /// The touches in the log's order.
    pub touches: Vec<Touch>,
    /// What the touches report: points where every touch has them and one lacks receptors, else receptors.
    pub input: Input,
    /// What looks odd, in sentences: nothing that stands in the way.
    pub notes: Vec<String>,
}

/// Reads a recording's touches from `path`, by its content: JSON where it begins so, else a table of comma-separated values;
/// both may be packed by gzip.
///
/// # Errors
/// [`RecordError::Io`] where the file cannot be read. [`RecordError::Format`], with line and column, for what is
/// no touch of the creature; for a log without touches; and for one whose angles are in degrees by the look.
pub fn read_recording(path: &Path, agent: &Agent) -> Result<Recording, RecordError> {
    let creature = agent.creature();
    let (bytes, mut notes) = read_log(path)?;
    let is_json = matches!(bytes.trim_ascii_start().first(), Some(b'{' | b'['));
    let read = if is_json { json_log::read } else { csv_log::read };
    let log = read(path, &bytes, creature)?;
    notes.extend(log.left_out_in_words());
    if log.touches.is_empty() {
        let why = notes.pop().map_or(String::new(), |note| format!(" ({note})"));
        let message = format!("it holds no touch{why}: give one with a touch a line");
        return Err(RecordError::format(path, None, message));
    }
    posture::refuse_degrees(path, creature, &log.touches)?;
    notes.extend(log.cut.map(cut_in_words));
    notes.extend(posture::notes(creature, &log.touches));
    notes.extend(log.notes);
    let mut recording = resolve(path, agent, &log.touches)?;
    let rows = recording.touches.len();
    let repeats = drop_repeats(&mut recording.touches);
    notes.extend((repeats > 0).then(|| {
        format!("{repeats} of {rows} rows repeat another in the same posture: each touch counts once")
    }));
    Ok(Recording { notes, ..recording })
}

/// Leaves of touches that repeat one another the first; how many went.
fn drop_repeats(touches: &mut Vec<Touch>) -> usize {
    let row = |touch: &Touch| {
        let posture = touch.posture.iter().map(|x| x / SAME_POSTURE);
        let points = touch.ends.iter().flat_map(|end| end.contact.iter().map(|x| x / SAME_POINT));
        ((touch.bout, touch.ends.map(|end| end.receptor)), posture.chain(points).collect())
    };
    let first = first_alike(&touches.iter().map(row).collect::<Vec<_>>());
    let before = touches.len();
    let mut keep = first.iter().enumerate().map(|(i, of)| i == *of);
    touches.retain(|_| keep.next().unwrap_or(true));
    before - touches.len()
}

/// Gives every touch its limbs and receptors.
fn resolve(path: &Path, agent: &Agent, raw: &[RawTouch]) -> Result<Recording, RecordError> {
    let skin = agent.skin();
    let creature = agent.creature();
    let refuse = |touch: &RawTouch| {
        let line = touch.line;
        move |fault: ContentFault| RecordError::format(path, Some(line), fault)
    };
    let given = skin.receptors.len();
    let mut limbs = Vec::with_capacity(raw.len());
    for touch in raw {
        limbs.push([
            limb_of(agent, touch, 0).map_err(refuse(touch))?,
            limb_of(agent, touch, 1).map_err(refuse(touch))?,
        ]);
    }
    let mut points = vec![Vec::new(); creature.limbs().len()];
    for (touch, limbs) in raw.iter().zip(&limbs) {
        for (end, &limb) in touch.ends.iter().zip(limbs) {
            if let (None, Some(point)) = (end.receptor(skin), end.point) {
                points[limb].push(point);
            }
        }
    }
    let mut skin = skin.clone();
    for (limb, points) in points.iter().enumerate() {
        if !skin.receptors.iter().any(|receptor| receptor.limb == limb) {
            skin.receptors.extend(bare_receptors(&creature.limbs()[limb], limb, points));
        }
    }
    let agent = agent.with_skin(skin).map_err(|error| RecordError::format(path, None, error.to_string()))?;
    let skin = agent.skin();
    let mut all_points = true;
    let mut all_receptors = true;
    let mut touches = Vec::with_capacity(raw.len());
    for (number, (found, limbs)) in raw.iter().zip(&limbs).enumerate() {
        let end = |k: usize| {
            let end: &RawEnd = &found.ends[k];
            let named = end.receptor(skin).filter(|&receptor| receptor < given);
            let receptor = named.or_else(|| nearest(skin, limbs[k], &end.point?));
            let receptor = receptor.expect("an end has a receptor or a point");
            let contact = end.point.unwrap_or(skin.receptors[receptor].position);
            (named, TouchEnd { receptor, contact, deviation: end.deviation })
        };
        let (a, b) = (end(0), end(1));
        all_points &= found.ends.iter().all(|end| end.point.is_some());
        all_receptors &= a.0.is_some() && b.0.is_some();
        let mut ends = [a.1, b.1];
        if limbs[0] > limbs[1] {
            ends.swap(0, 1);
        }
        let (bout, motion) = (found.bout.unwrap_or(0), found.motion.unwrap_or(number as u64 + 1));
        let touch = Touch { bout, motion, posture: found.posture.clone(), ends, moment: None };
        check(&touch, &agent).map_err(refuse(found))?;
        touches.push(touch);
    }
    if !all_receptors && !all_points {
        let without = |touch: &&RawTouch| touch.ends.iter().any(|end| end.point.is_none());
        let line = raw.iter().find(without).map(|touch| touch.line);
        let message = "this touch has only receptors and others have only points: give points in every touch, or \
                       receptors in every touch";
        return Err(RecordError::format(path, line, message));
    }
    let input = if all_receptors { Input::Receptor } else { Input::Contact };
    Ok(Recording { agent, touches, input, notes: Vec::new() })
}

/// The limb of one end of a touch: where its receptor is, or the one that is named.
fn limb_of(agent: &Agent, touch: &RawTouch, k: usize) -> Result<usize, ContentFault> {
    let skin = agent.skin();
    let creature = agent.creature();
    let end = &touch.ends[k];
    let side = ["a", "b"][k];
    let named = match &end.limb {
        None => None,
        Some(name) => Some(creature.limb(name).ok_or_else(|| {
            format!(
                "{}: {} has no limb \"{name}\": name one of {}",
                end.limb_place,
                creature.name(),
                some(creature.limbs())
            )
        })?),
    };
    let felt = match end.receptor(skin) {
        Some(receptor) => Some(skin.receptors[receptor].limb),
        None => match &end.receptor {
            Some(id) if end.point.is_none() || end.limb.is_none() => {
                let mend = if skin.receptors.is_empty() {
                    "give the creature's file a skin, or give limbs and points in place of receptors"
                } else {
                    "give the skin that the touches were recorded with"
                };
                return Err(
                    format!("{}: the skin has no receptor \"{id}\": {mend}", end.receptor_place).into()
                );
            }
            _ => None,
        },
    };
    match (felt, named) {
        (Some(felt), Some(named)) if felt != named => Err(format!(
            "{}: receptor \"{}\" is on limb {}, not on {}: mend one of the two",
            end.limb_place,
            end.receptor.as_deref().unwrap_or_default(),
            creature.limbs()[felt],
            creature.limbs()[named]
        ).into()),
        (Some(limb), _) => Ok(limb),
        (None, Some(_)) if end.point.is_none() => Err(format!(
            "end {side} has a limb but no point on it: give the point of contact in the limb's frame, or a receptor"
        ).into()),
        (None, Some(limb)) => Ok(limb),
        (None, None) => Err(format!("end {side} has no limb: name the limb, or a receptor of the skin").into()),
    }
}

/// The first names of many.
fn some(names: &[String]) -> String {
    const SHOWN: usize = 8;
    match names.len() {
        n if n <= SHOWN => names.join(", "),
        n => format!("{} and {} more", names[..SHOWN].join(", "), n - SHOWN),
    }
}

/// The receptor of a limb whose centre is nearest to a point.
fn nearest(skin: &Skin, limb: usize, point: &Vector3<f64>) -> Option<usize> {
    let distance = |receptor: usize| (skin.receptors[receptor].position - point).norm_squared();
    let on_limb = (0..skin.receptors.len()).filter(|&receptor| skin.receptors[receptor].limb == limb);
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
