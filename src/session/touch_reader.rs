//! Reading the log of touches, of this program or another.

use std::collections::{HashMap, HashSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;

use nalgebra::Vector3;

use super::json_lines::{read_header, read_log};
use super::touch_line::{STAMP, TouchHeader, TouchLine, UNITS, check};
use crate::agent::Agent;
use crate::creature::Creature;
use crate::error::Error;
use crate::senses::{ExactContact, Moment, RecordedTouch, Touch, TouchEnd};

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
            return Err("it is a touch that was told before: delete the line".into());
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
                "its touches are of \"{}\" with {} coordinates, not of \"{}\" with {}: give the model and the joints that they \
                 were recorded with",
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
            format!("the skin has no receptor \"{id}\": give the skin that the touches were recorded with")
        })?;
        let limb = &agent.creature().limbs()[skin.receptors[receptor].limb];
        if found.limbs[k] != *limb {
            return Err(format!(
                "receptor \"{id}\" is on limb {limb}, not on \"{}\": give the skin that the touches were \
                 recorded with, or mend the line",
                found.limbs[k]
            ));
        }
        let away = (vector(&found.positions[k]) - skin.receptors[receptor].position).norm();
        if away.is_nan() || away > SAME_POSITION {
            return Err(format!(
                "the position of receptor \"{id}\" is not the skin's: give the skin that the touches were \
                 recorded with, or mend the line"
            ));
        }
        Ok(TouchEnd::at(receptor))
    };
    let ends = [end(0)?, end(1)?];
    let posture = found.posture.iter().map(|x| x.unwrap_or(f64::NAN)).collect();
    let moment = match (found.time, found.force, found.depth) {
        (None, None, None) => None,
        (Some(time), Some(force), Some(_)) => Some(Moment { time, force }),
        _ => return Err("it has some of time, force and depth: give all three or none".into()),
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
