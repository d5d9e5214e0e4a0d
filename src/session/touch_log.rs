//! The log of touches, of this program or another: what its lines hold, what makes one right, reading it, and writing it while
//! touches are made.

use std::collections::{HashMap, HashSet};
use std::f64::consts::TAU;
use std::fs::{self, File, OpenOptions};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::files::{self, lock};
use super::stamp::{Stamp, drop_zeros, read_header, read_log};
use super::{TOUCHES_FILE, UNIT_LENGTH};
use crate::agent::Agent;
use crate::creature::{Creature, DofElement, DofKind};
use crate::error::Error;
use crate::plausible::{GREATEST_LENGTH, is_angle, is_deviation, is_length, place_fault};
use crate::senses::{ExactContact, Moment, RecordedTouch, Touch, TouchEnd};
use crate::skin::Receptor;

const STAMP: Stamp = Stamp { format: "bodyschema touches", version: 1 };
/// Times, forces and depths at the most, seconds, newtons and metres: thirty years, and the weight of an oil tanker.
const GREATEST_MOMENT: f64 = 1e9;
/// A contact is at most so many times as far from its receptor as that reaches from its joint …
const FAR: f64 = 10.0;
/// … or as this is, metres.
const LEAST_REACH: f64 = 0.1;
/// The units of a log: of positions and distances, and of angles.
const UNITS: &str = "m rad";
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

/// The header, behind its stamp.
#[derive(Deserialize, Serialize)]
struct TouchHeader {
    /// The creature's name.
    creature: String,
    /// How many numbers a posture has.
    coordinates: usize,
    /// [`UNITS`].
    units: String,
}

/// A vector in a line; JSON has no other way to say "not a finite number" than null.
type Numbers = [Option<f64>; 3];

/// A touch as a line has it.
///
/// Limbs and positions follow from the receptors; they are given so that a log can be read alone.
#[derive(Deserialize, Serialize)]
struct TouchLine {
    bout: u64,
    motion: u64,
    posture: Vec<Option<f64>>,
    /// The ids of the two receptors, the one on the earlier limb first.
    receptors: [String; 2],
    /// The names of their limbs.
    limbs: [String; 2],
    /// `p_LR` of both: the receptors' centres in their limbs' frames.
    positions: [Numbers; 2],
    /// The exact points of contact in the limbs' frames.
    contacts: [Numbers; 2],
    /// Standard deviations of the contacts' coordinates, metres, where the recording gives them.
    #[serde(skip_serializing_if = "Option::is_none")]
    deviations: Option<[Option<f64>; 2]>,
    /// Simulated seconds since the bout began, where forces were at work, …
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<f64>,
    /// … the normal force of the contact, newtons, …
    #[serde(skip_serializing_if = "Option::is_none")]
    force: Option<f64>,
    /// … and how deep the surfaces were in each other, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    depth: Option<f64>,
}

/// Reads the touches of a creature and its skin from the log `path`.
///
/// # Errors
/// If the file cannot be read; with the line, if it
/// is no log of touches or one of a newer version, where it belongs to another creature or skin, and
/// for any line that is no touch; only the last one may be incomplete.
pub fn read_touches(path: &Path, agent: &Agent) -> Result<TouchLog, Error> {
    let receptors = agent.skin().numbers();
    let mut told = HashSet::new();
    let check = |header: TouchHeader| header.check(agent.creature());
    let (touches, end) = read_log(path, (STAMP, "touch"), check, |line: TouchLine| {
        let touch = line.touch(agent, &receptors)?;
        if !told.insert(print(&touch)) {
            return Err("it repeats an earlier touch: delete the line".into());
        }
        Ok(touch)
    })?;
    Ok(TouchLog { touches, truncated: end.incomplete, zeros: end.zeros })
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
    fn of(creature: &Creature) -> TouchHeader {
        TouchHeader {
            creature: creature.name().into(),
            coordinates: creature.coordinates(),
            units: UNITS.into(),
        }
    }

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

impl TouchLine {
    /// The line of a touch that is right.
    fn of(touch: &RecordedTouch, agent: &Agent) -> Result<TouchLine, String> {
        let met = met(touch, agent)?;
        let numbers = |vector: Vector3<f64>| <[f64; 3]>::from(vector).map(Some);
        let contact = touch.exact_contact();
        Ok(TouchLine {
            bout: touch.bout,
            motion: touch.motion,
            posture: touch.posture.iter().copied().map(Some).collect(),
            receptors: met.map(|(receptor, _)| receptor.id.clone()),
            limbs: met.map(|(_, limb)| limb.to_string()),
            positions: met.map(|(receptor, _)| numbers(receptor.position)),
            contacts: contact.points.map(numbers),
            deviations: Some(contact.deviations).filter(|deviations| deviations.iter().any(Option::is_some)),
            time: touch.moment.map(|moment| moment.time),
            force: touch.moment.map(|moment| moment.force),
            depth: contact.depth.filter(|_| touch.moment.is_some()),
        })
    }

    /// The touch that it is, once that is right.
    fn touch(self, agent: &Agent, receptors: &HashMap<&str, usize>) -> Result<RecordedTouch, String> {
        let vector = |numbers: Numbers| Vector3::from(numbers.map(|x| x.unwrap_or(f64::NAN)));
        let skin = agent.skin();
        let end = |k: usize| -> Result<TouchEnd, String> {
            let id = &self.receptors[k];
            let &receptor = receptors.get(id.as_str()).ok_or_else(|| {
                format!("the skin has no receptor \"{id}\": give the skin the touches were recorded with")
            })?;
            let limb = &agent.creature().limbs()[skin.receptors[receptor].limb];
            if self.limbs[k] != *limb {
                return Err(format!(
                    "receptor \"{id}\" is on limb {limb}, not on \"{}\": give the skin the touches were recorded \
                     with, or correct the line",
                    self.limbs[k]
                ));
            }
            let away = (vector(self.positions[k]) - skin.receptors[receptor].position).norm();
            if away.is_nan() || away > SAME_POSITION {
                return Err(format!(
                    "the position of receptor \"{id}\" differs from the skin's: give the skin the touches were \
                     recorded with, or correct the line"
                ));
            }
            Ok(TouchEnd::at(receptor))
        };
        let ends = [end(0)?, end(1)?];
        let posture = self.posture.iter().map(|x| x.unwrap_or(f64::NAN)).collect();
        let moment = match (self.time, self.force, self.depth) {
            (None, None, None) => None,
            (Some(time), Some(force), Some(_)) => Some(Moment { time, force }),
            _ => return Err("it has only some of time, force and depth: give all three or none".into()),
        };
        let contact = ExactContact {
            points: self.contacts.map(vector),
            deviations: self.deviations.unwrap_or_default(),
            depth: self.depth,
        };
        let touch = Touch { bout: self.bout, motion: self.motion, posture, ends, moment };
        let touch = RecordedTouch::new(touch, contact);
        check(&touch, agent)?;
        Ok(touch)
    }
}

/// The two receptors of a touch, and the names of the limbs that they are on.
fn met<'a>(touch: &Touch, agent: &'a Agent) -> Result<[(&'a Receptor, &'a str); 2], String> {
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

/// Writes [`TOUCHES_FILE`], a line a touch.
///
/// Every touch is handed to the system in one piece as soon as it is written: where the process is
/// killed, at most the last line is incomplete, and [`read_touches`] leaves that
/// one out, and [`TouchWriter::resume`] goes on in the middle of it. While a writer lives it holds the system's lock on
/// the file, so that no second one writes to it. After an error the writer is of no more use.
#[derive(Debug)]
pub struct TouchWriter<'a> {
    path: PathBuf,
    file: File,
    agent: &'a Agent,
    /// Lines written, the header included.
    lines: usize,
    buffer: Vec<u8>,
    /// What an interrupted writer left.
    left: Vec<u8>,
    /// How much of that has been written once more.
    passed: usize,
    /// Zero bytes that were at its end.
    zeros: usize,
}

impl<'a> TouchWriter<'a> {
    /// Begins the log in `folder`, which is made if missing; a log that is there is never overwritten.
    ///
    /// # Errors
    /// If the folder or the file cannot be made; or if there is a log
    /// already, or another process is writing it.
    pub fn create(folder: &Path, agent: &'a Agent) -> Result<TouchWriter<'a>, Error> {
        fs::create_dir_all(folder).map_err(Error::unwritable(folder))?;
        let mut writer = TouchWriter::open(folder, agent)?;
        let about = writer.file.metadata().map_err(Error::unwritable(&writer.path))?;
        if about.len() > 0 {
            let message = "a log already exists: give another folder with --out, or move it away";
            return Err(Error::content(&writer.path, None, message));
        }
        writer.write_line(&STAMP.on(&TouchHeader::of(agent.creature())))?;
        Ok(writer)
    }

    /// Goes on with the log that an interrupted writer left in `folder`, if any. What is there stays: the touches that
    /// are written to it must be the same once more, from the first one on or after [`TouchWriter::skip`], and an
    /// incomplete last line is completed. Only what comes after is added. Zero bytes at its end, which a file system
    /// leaves where the power failed before it had stored what was written, are dropped.
    ///
    /// # Errors
    /// If the log cannot be read and written; or if another process is
    /// writing it, or where it is not of this creature.
    pub fn resume(folder: &Path, agent: &'a Agent) -> Result<TouchWriter<'a>, Error> {
        let mut writer = TouchWriter::open(folder, agent)?;
        writer.left = files::read(&writer.path)?;
        writer.zeros = drop_zeros(&mut writer.left);
        if writer.zeros > 0 {
            let cut = writer.file.set_len(writer.left.len() as u64).and_then(|()| writer.file.sync_all());
            cut.map_err(Error::unwritable(&writer.path))?;
        }
        writer.write_line(&STAMP.on(&TouchHeader::of(agent.creature())))?;
        Ok(writer)
    }

    /// Opens a log that no other process writes, without touching what is in it.
    fn open(folder: &Path, agent: &'a Agent) -> Result<TouchWriter<'a>, Error> {
        let path = folder.join(TOUCHES_FILE);
        let opened = OpenOptions::new().append(true).create(true).open(&path);
        let file = opened.map_err(Error::unwritable(&path))?;
        lock(&file, Duration::ZERO).map_err(|_| {
            let message = "another process is writing to it: wait until it is done, or end it";
            Error::content(&path, None, message)
        })?;
        let (buffer, left) = (Vec::new(), Vec::new());
        Ok(TouchWriter { path, file, agent, lines: 0, buffer, left, passed: 0, zeros: 0 })
    }

    /// How many zero bytes were at the end of the log that is gone on with, and were dropped.
    pub fn zeros(&self) -> usize {
        self.zeros
    }

    /// Passes over touches that an interrupted writer left, at most `touches`, without looking at them; how many whole
    /// ones there were.
    ///
    /// # Errors
    /// If the log cannot be read.
    pub fn skip(&mut self, touches: usize) -> Result<usize, Error> {
        for skipped in 0..touches {
            let line = self.next_left();
            match line.last() {
                Some(b'\n') => (self.passed, self.lines) = (self.passed + line.len(), self.lines + 1),
                Some(_) => {
                    let message = "incomplete line: delete it";
                    return Err(Error::content(&self.path, Some(self.lines + 1), message));
                }
                None => return Ok(skipped),
            }
        }
        Ok(touches)
    }

    /// Adds a touch.
    ///
    /// # Errors
    /// If writing fails, and for a touch that could not be
    /// read again: of another creature or skin, or with numbers that are not finite; and for one that is not
    /// what an interrupted writer left here. Such a touch is not written.
    pub fn write(&mut self, touch: &RecordedTouch) -> Result<(), Error> {
        let refuse = |message| Error::content(&self.path, Some(self.lines + 1), message);
        check(touch, self.agent).map_err(refuse)?;
        let line = TouchLine::of(touch, self.agent).map_err(refuse)?;
        self.write_line(&line)
    }

    /// Ends the log and waits until it is on the disk.
    ///
    /// # Errors
    /// If the system cannot store it, or if an interrupted writer left
    /// more than was written now.
    pub fn finish(self) -> Result<(), Error> {
        if !self.next_left().is_empty() {
            let message = "more touches than the session has: delete this line and all after it";
            return Err(Error::content(&self.path, Some(self.lines + 1), message));
        }
        match self.file.sync_all() {
            // What is no file, such as a pipe, has nothing to wait for.
            Err(error) if error.kind() == io::ErrorKind::InvalidInput => Ok(()),
            result => result.map_err(Error::unwritable(&self.path)),
        }
    }

    /// The next line that an interrupted writer left, which may lack its end; empty if there is none.
    fn next_left(&self) -> &[u8] {
        let left = &self.left[self.passed..];
        left.split_inclusive(|byte| *byte == b'\n').next().unwrap_or_default()
    }

    fn write_line(&mut self, content: &impl Serialize) -> Result<(), Error> {
        self.buffer.clear();
        serde_json::to_writer(&mut self.buffer, content)
            .map_err(|error| Error::unwritable(&self.path)(error.into()))?;
        self.buffer.push(b'\n');
        // A line without its end is the last one, and the beginning of this one.
        let there = self.next_left().len();
        if !self.buffer.starts_with(self.next_left()) {
            return Err(Error::content(
                &self.path,
                Some(self.lines + 1),
                "it differs from what is babbled here: it was edited, or made by another version of bodyschema; \
                 babble again into another folder with --out",
            ));
        }
        self.file.write_all(&self.buffer[there..]).map_err(Error::unwritable(&self.path))?;
        self.passed += there;
        self.lines += 1;
        Ok(())
    }
}
