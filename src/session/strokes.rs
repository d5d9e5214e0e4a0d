//! A session of what a creature feels while it is stroked all over: which receptor fired and when, with nothing of where receptors are.

use std::collections::HashMap;
use std::path::Path;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::stamp::{Stamp, read_log};
use crate::error::Error;
use crate::senses::{Firing, FiringRecorder, TouchEvent};
use crate::session::{FIRINGS_FILE, SENSATIONS_FILE, Session, SessionOptions, files, model_hash};
use crate::simulation::partner::stroke_for;
use crate::simulation::{Stage, event_json};
use crate::skin::Skin;

const STAMP: Stamp = Stamp { format: "bodyschema firings", version: 1 };

/// What the header says beside its stamp.
#[derive(Serialize, Deserialize)]
struct FiringHeader {
    /// The creature's name.
    creature: String,
}

/// A firing as a line has it; times are seconds.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FiringLine<Id> {
    receptor: Id,
    first: f64,
    last: f64,
}

/// Writes the firings of a creature's skin to [`FIRINGS_FILE`] in `folder`, a line a firing; an older log there is replaced.
///
/// # Errors
/// If the file cannot be written.
pub fn write_firings(folder: &Path, creature: &str, skin: &Skin, firings: &[Firing]) -> Result<(), Error> {
    let path = folder.join(FIRINGS_FILE);
    let mut lines = serde_json::to_string(&STAMP.on(&FiringHeader { creature: creature.to_string() }))
        .map_err(|error| Error::unwritable(&path)(error.into()))?;
    for Firing { receptor, span: [first, last] } in firings {
        let line = FiringLine { receptor: &skin.receptors[*receptor].id, first: *first, last: *last };
        let line = serde_json::to_string(&line).map_err(|error| Error::unwritable(&path)(error.into()))?;
        lines = lines + "\n" + &line;
    }
    files::write(&path, lines + "\n")
}

/// Reads the firings of a creature's skin from the log `path`, in the log's order; the last line may be incomplete, as
/// a killed process leaves it, and is left out then.
///
/// # Errors
/// If the file cannot be read; with the line, if it is no log of
/// firings or one of a newer version, where it belongs to another creature or skin, and for any line that is no firing.
pub fn read_firings(path: &Path, creature: &str, skin: &Skin) -> Result<Vec<Firing>, Error> {
    let receptors = skin.numbers();
    let check = |header: FiringHeader| match header.creature {
        found if found == creature => Ok(()),
        found => Err(format!(
            "its firings belong to \"{found}\", not to \"{creature}\": give the log of one session"
        )),
    };
    Ok(read_log(path, (STAMP, "firing"), check, |line| firing(&line, &receptors))?.0)
}

fn firing(line: &FiringLine<String>, receptors: &HashMap<&str, usize>) -> Result<Firing, String> {
    let id = &line.receptor;
    let &receptor = receptors.get(id.as_str()).ok_or_else(|| {
        format!("the skin has no receptor \"{id}\": correct the line, or give the session it was recorded in")
    })?;
    let span = [line.first, line.last];
    if span.iter().any(|time| !time.is_finite() || time.abs() > 1e9) || span[0] > span[1] {
        return Err(format!(
            "receptor \"{id}\" cannot have fired from {} to {} s: give times in order, or delete the line",
            span[0], span[1]
        ));
    }
    Ok(Firing { receptor, span })
}

/// What is stroked, and for how long.
pub struct StrokedSession<'a> {
    /// The model's file.
    pub model: &'a Path,
    /// The body at which the creature begins, where it was named.
    pub root: Option<String>,
    /// The command line that asks for it, word by word.
    pub command: Vec<String>,
    /// Seed of the strokes.
    pub seed: u64,
    /// Simulated seconds.
    pub seconds: f64,
}

/// Strokes the creature on a stage, and writes a session of it into a folder: which receptor fired and when, and what the touch
/// sensor made of it. `progress` is told the simulated seconds so far. Returns how many sensations and firings there were.
///
/// # Errors
/// If a file cannot be written, the engine fails, or there is no room to stroke the creature.
pub fn record_strokes(
    folder: &Path,
    stage: &Stage,
    asked: StrokedSession,
    progress: impl Fn(f64),
) -> Result<[u64; 2], Error> {
    let StrokedSession { model, root, command, seed, seconds } = asked;
    let (creature, skin) = (stage.agent().creature(), stage.skin());
    let session = Session {
        engine: stage.body().model.version().to_string(),
        model: model.display().to_string(),
        model_hash: model_hash(model)?,
        command,
        seed,
        options: SessionOptions { joints: "all".to_string(), root, ..SessionOptions::default() },
        agent: stage.agent().clone(),
        ..Session::made_here()
    };
    let mut recorder = FiringRecorder::default();
    let (mut firings, mut sensed, mut sensations) = (Vec::new(), 0, String::new());
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let room = stroke_for(stage, seconds, &mut rng, |stage, time, contacts, events| {
        progress(time);
        firings.extend(recorder.step(time, contacts));
        for event in events.iter().filter(|event| matches!(event, TouchEvent::Sensed { .. })) {
            sensations += &format!("{}\n", event_json(stage, time, event));
            sensed += 1;
        }
        Ok::<(), Error>(())
    })?;
    if !room {
        return Err(Error::unfit(model, "this creature has no surface that can be stroked"));
    }
    firings.extend(recorder.rest());
    session.write(folder)?;
    write_firings(folder, creature.name(), skin, &firings)?;
    files::write(&folder.join(SENSATIONS_FILE), sensations)?;
    Ok([sensed, firings.len() as u64])
}
