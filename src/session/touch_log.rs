//! The log of touches, of this program or another: what its lines hold, what makes one right, and reading it.

use std::collections::{HashMap, HashSet};
use std::f64::consts::TAU;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::UNIT_LENGTH;
use super::stamp::Stamp;
use super::stamp::{read_header, read_log};
use crate::agent::Agent;
use crate::creature::{Creature, DofElement, DofKind};
use crate::error::Error;
use crate::plausible::{GREATEST_LENGTH, is_angle, is_deviation, is_length, place_fault};
use crate::senses::{ExactContact, Moment, RecordedTouch, Touch, TouchEnd};
use crate::skin::Receptor;

/// How far a receptor's position in a log may be from the skin's, metres.
const SAME_POSITION: f64 = 1e-9;

/// What a log of touches holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TouchLog {
    /// The touches, in the log's order.
    pub touches: Vec<RecordedTouch>,
    /// The last line's number where it is incomplete, as a killed process leaves it; it is left out.
    pub truncated: Option<usize>,
    /// Zero bytes at its end, as a file system leaves them where the power failed; they are left out as well.
    pub zeros: usize,
}

/// A line as it is read; JSON has no other way to say "not a finite number" than null.
type FoundLine = TouchLine<String, Vec<Option<f64>>, [Option<f64>; 3]>;

/// Reads the touches of a creature and its skin from the log `path`.
///
/// # Errors
/// If the file cannot be read; with the line, if it
/// is no log of touches or one of a newer version, where it belongs to another creature or skin, and
/// for any line that is no touch; only the last one may be incomplete.
pub fn read_touches(path: &Path, agent: &Agent) -> Result<TouchLog, Error> {
    let receptors = agent.skin().numbers();
    let (mut log, mut told) = (TouchLog::default(), HashSet::new());
    let check = |header: TouchHeader| header.check(agent.creature());
    let end = read_log(path, (STAMP, "touch"), check, |found: FoundLine| {
        let touch = touch(found, agent, &receptors)?;
        if !told.insert(print(&touch)) {
            return Err("it repeats an earlier touch: delete the line".into());
        }
        log.touches.push(touch);
        Ok(())
    })?;
    (log.truncated, log.zeros) = (end.incomplete, end.zeros);
    Ok(log)
}

/// By what a touch is known again: no two motions give the same numbers.
fn print(touch: &RecordedTouch) -> u64 {
    let mut hasher = DefaultHasher::new();
    (touch.bout, touch.motion).hash(&mut hasher);
    let contacts = touch.exact_contact().points.iter().flatten();
    touch.posture.iter().chain(contacts).for_each(|x| x.to_bits().hash(&mut hasher));
    touch.ends.iter().for_each(|end| end.receptor.hash(&mut hasher));
    hasher.finish()
}

/// Checks the header, on a line of the log.
pub(super) fn check_header(path: &Path, json: &[u8], line: usize, creature: &Creature) -> Result<(), Error> {
    let header: TouchHeader = read_header(path, STAMP, line, json)?;
    header.check(creature).map_err(|fault| Error::content(path, Some(line), fault))
}

impl TouchHeader {
    /// Whether the log is of a creature.
    fn check(&self, creature: &Creature) -> Result<(), String> {
        if self.units != UNITS {
            return Err(format!(
                "its units are \"{}\", not \"{UNITS}\": convert its numbers to metres and radians",
                self.units
            ));
        }
        if self.creature != creature.name() || self.coordinates != creature.coordinates() {
            return Err(format!(
                "its touches belong to \"{}\" with {} coordinates, not to \"{}\" with {}: give the model and \
                 joints they were recorded with",
                self.creature,
                self.coordinates,
                creature.name(),
                creature.coordinates()
            ));
        }
        Ok(())
    }
}

/// The touch that a line tells of.
fn touch(found: FoundLine, agent: &Agent, receptors: &HashMap<&str, usize>) -> Result<RecordedTouch, String> {
    let skin = agent.skin();
    let end = |k: usize| -> Result<TouchEnd, String> {
        let id = &found.receptors[k];
        let &receptor = receptors.get(id.as_str()).ok_or_else(|| {
            format!("the skin has no receptor \"{id}\": give the skin the touches were recorded with")
        })?;
        let limb = &agent.creature().limbs()[skin.receptors[receptor].limb];
        if found.limbs[k] != *limb {
            return Err(format!(
                "receptor \"{id}\" is on limb {limb}, not on \"{}\": give the skin the touches were recorded \
                 with, or correct the line",
                found.limbs[k]
            ));
        }
        let away = (vector(&found.positions[k]) - skin.receptors[receptor].position).norm();
        if away.is_nan() || away > SAME_POSITION {
            return Err(format!(
                "the position of receptor \"{id}\" differs from the skin's: give the skin the touches were \
                 recorded with, or correct the line"
            ));
        }
        Ok(TouchEnd::at(receptor))
    };
    let ends = [end(0)?, end(1)?];
    let posture = found.posture.iter().map(|x| x.unwrap_or(f64::NAN)).collect();
    let moment = match (found.time, found.force, found.depth) {
        (None, None, None) => None,
        (Some(time), Some(force), Some(_)) => Some(Moment { time, force }),
        _ => return Err("it has only some of time, force and depth: give all three or none".into()),
    };
    let contact = ExactContact {
        points: found.contacts.map(|point| vector(&point)),
        deviations: found.deviations.unwrap_or_default(),
        depth: found.depth,
    };
    let touch = Touch { bout: found.bout, motion: found.motion, posture, ends, moment };
    let touch = RecordedTouch::new(touch, contact);
    check(&touch, agent)?;
    Ok(touch)
}

fn vector(found: &[Option<f64>; 3]) -> Vector3<f64> {
    Vector3::from(found.map(|x| x.unwrap_or(f64::NAN)))
}

pub(super) const STAMP: Stamp = Stamp { format: "bodyschema touches", version: 1 };
/// Times, forces and depths at the most, seconds, newtons and metres: thirty years, and the weight of an oil tanker.
const GREATEST_MOMENT: f64 = 1e9;
/// A contact is at most so many times as far from its receptor as that reaches from its joint …
const FAR: f64 = 10.0;
/// … or as this is, metres.
const LEAST_REACH: f64 = 0.1;
/// The units of a log: of positions and distances, and of angles.
pub(super) const UNITS: &str = "m rad";

/// The header, behind its stamp.
#[derive(Deserialize, Serialize)]
#[serde(expecting = "an object")]
pub(super) struct TouchHeader {
    /// The creature's name.
    pub creature: String,
    /// How many numbers a posture has.
    pub coordinates: usize,
    /// [`UNITS`].
    pub units: String,
}

/// A touch as a line tells it: `S` is a text, `P` a posture, `V` a vector.
///
/// Limbs and positions follow from the receptors; they are told so that a log can be read alone.
#[derive(Deserialize, Serialize)]
#[serde(expecting = "an object")]
pub(super) struct TouchLine<S, P, V> {
    pub bout: u64,
    pub motion: u64,
    pub posture: P,
    /// The ids of the two receptors, the one on the earlier limb first.
    pub receptors: [S; 2],
    /// The names of their limbs.
    pub limbs: [S; 2],
    /// `p_LR` of both: the receptors' centres in their limbs' frames.
    pub positions: [V; 2],
    /// The exact points of contact in the limbs' frames.
    pub contacts: [V; 2],
    /// Standard deviations of the contacts' coordinates, metres, where the recording gives them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deviations: Option<[Option<f64>; 2]>,
    /// Simulated seconds since the bout began, where forces were at work, …
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// … the normal force of the contact, newtons, …
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<f64>,
    /// … and how deep the surfaces were in each other, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth: Option<f64>,
}

/// The two receptors of a touch, and the names of the limbs that they are on.
pub(super) fn met<'a>(touch: &Touch, agent: &'a Agent) -> Result<[(&'a Receptor, &'a str); 2], String> {
    let of_end = |end: TouchEnd| -> Result<(&'a Receptor, &'a str), String> {
        let receptor = agent.skin().receptors.get(end.receptor);
        let receptor = receptor.ok_or_else(|| {
            format!("the skin has no receptor {} (counted from 0): leave the touch out", end.receptor)
        })?;
        Ok((receptor, agent.creature().limbs()[receptor.limb].as_str()))
    };
    Ok([of_end(touch.ends[0])?, of_end(touch.ends[1])?])
}

/// Checks that a touch is one of the creature and its skin, and that its numbers are usable.
///
/// The error is a sentence that names what is wrong and its fix.
pub(super) fn check(touch: &RecordedTouch, agent: &Agent) -> Result<(), String> {
    let creature = agent.creature();
    if touch.posture.len() != creature.coordinates() {
        return Err(format!(
            "its posture has {} numbers, but {} has {} coordinates: correct it, or leave the touch out",
            touch.posture.len(),
            creature.name(),
            creature.coordinates()
        ));
    }
    creature.elements().try_for_each(|dof| check_coordinates(&dof, dof.of(&touch.posture)))?;
    let [(a, limb), (b, _)] = met(touch, agent)?;
    if a.limb == b.limb {
        return Err(format!(
            "\"{}\" and \"{}\" are both on limb {limb}, but a touch needs two limbs: leave it out",
            a.id, b.id
        ));
    }
    let contact = touch.exact_contact();
    for (k, receptor) in [a, b].into_iter().enumerate() {
        check_contact(receptor, &contact.points[k], contact.deviations[k])?;
    }
    let depth = contact.depth.unwrap_or(f64::NAN);
    let moment =
        touch.moment.map(|moment| [("time", moment.time), ("force", moment.force), ("depth", depth)]);
    match moment.into_iter().flatten().find(|(_, x)| !(0.0..=GREATEST_MOMENT).contains(x)) {
        None => Ok(()),
        Some((what, wrong)) => Err(format!(
            "its {what} is {wrong}: give a number from 0 to {GREATEST_MOMENT}, or none of time, force and depth"
        )),
    }
}

/// Checks the coordinates of a degree of freedom in a posture.
fn check_coordinates(dof: &DofElement, coordinates: &[f64]) -> Result<(), String> {
    let (name, [low, high], first) = (&dof.name, dof.range, coordinates[0]);
    if !coordinates.iter().all(|x| x.is_finite()) {
        return Err(format!(
            "the posture's {name} is not a finite number: correct it, or leave the touch out"
        ));
    }
    // Beyond its range by a whole turn it would be another angle with the turn taken off.
    let beyond = (low - first).max(first - high);
    let (possible, unit) = match dof.kind {
        DofKind::Hinge => (is_angle(first) && beyond <= TAU, "radians"),
        DofKind::Slide => (is_length(first) && beyond <= 1.0 + 10.0 * (high - low), "metres"),
        DofKind::Ball => {
            let length = coordinates.iter().map(|x| x * x).sum::<f64>().sqrt();
            return match (length - 1.0).abs() > UNIT_LENGTH {
                true => Err(format!(
                    "the posture's quaternion of {name} has length {length}: divide it by its length"
                )),
                false => Ok(()),
            };
        }
    };
    if possible {
        return Ok(());
    }
    Err(format!(
        "the posture's {name} is {first}, far beyond its range of {low:.3} to {high:.3}: give {unit}, or leave the touch out"
    ))
}

/// Checks the point of contact at a receptor, in its limb's frame, and its standard deviation.
fn check_contact(receptor: &Receptor, point: &Vector3<f64>, deviation: Option<f64>) -> Result<(), String> {
    let id = &receptor.id;
    if !point.iter().all(|x| x.is_finite()) {
        return Err(format!(
            "the contact at \"{id}\" is not three finite numbers: correct it, or leave the touch out"
        ));
    }
    if let Some(fault) = place_fault(point) {
        return Err(format!("the contact at \"{id}\" {fault}, or leave the touch out"));
    }
    let reach = receptor.position.norm() + receptor.half_extents.iter().sum::<f64>();
    let away = (point - receptor.position).norm();
    if away > FAR * (reach + LEAST_REACH) {
        return Err(format!(
            "the contact at \"{id}\" is {away:.3} m from the receptor: give metres in the limb's frame, or leave \
             the touch out"
        ));
    }
    match deviation.filter(|std| !(is_deviation(*std) && std.is_finite())) {
        None => Ok(()),
        Some(wrong) => Err(format!(
            "the contact's deviation at \"{id}\" is {wrong}: give metres from 0 to {GREATEST_LENGTH}, or null"
        )),
    }
}
