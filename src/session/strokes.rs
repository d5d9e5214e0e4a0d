//! A session of what a creature feels while it is stroked all over: which receptor fired and when, with nothing of where receptors
//! are; and the somatotopic map that is made of it: the neighbours of every receptor, by their ids.

use std::collections::{BTreeMap, HashMap};
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
use crate::skin::{MOST_NEIGHBOURS, Skin, SomatotopicMap};

const FIRINGS: Stamp = Stamp { format: "bodyschema firings", version: 1 };
const MAP: Stamp = Stamp { format: "bodyschema map", version: 1 };

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
    let mut lines = serde_json::to_string(&FIRINGS.on(&FiringHeader { creature: creature.to_string() }))
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
    Ok(read_log(path, (FIRINGS, "firing"), check, |line| firing(&line, &receptors))?.0)
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

/// What the file of a map has beside its stamp.
#[derive(Serialize, Deserialize)]
struct MapContent {
    creature: String,
    /// Per receptor its neighbours, nearest first.
    neighbours: BTreeMap<String, Vec<String>>,
}

/// Writes a map of a creature's skin to `path`: per receptor its neighbours, nearest first.
///
/// # Errors
/// If the file cannot be written.
pub fn write_map(path: &Path, creature: &str, skin: &Skin, map: &SomatotopicMap) -> Result<(), Error> {
    let id = |receptor: usize| skin.receptors[receptor].id.clone();
    let of = |receptor: usize| map.neighbours(receptor).iter().map(|&other| id(other)).collect();
    let neighbours = (0..map.receptors()).map(|receptor| (id(receptor), of(receptor))).collect();
    MAP.write(path, &MapContent { creature: creature.to_string(), neighbours })
}

/// Reads the map of a creature's skin from `path`.
///
/// # Errors
/// If the file cannot be read; or if it is no map or one of a newer
/// version, where it is of another creature or names other receptors than the skin has, where a receptor has more than eight neighbours, or is its own, and where one of two receptors has the other for a neighbour, but not
/// the other way round.
pub fn read_map(path: &Path, creature: &str, skin: &Skin) -> Result<SomatotopicMap, Error> {
    let read: MapContent = MAP.read(path, "map of neighbours")?;
    let refuse = |message: String| Err(Error::content(path, None, message));
    if read.creature != creature {
        return refuse(format!(
            "it is a map of \"{}\", not of \"{creature}\": give the one that `bodyschema skin map` wrote for this creature",
            read.creature
        ));
    }
    let numbers = skin.numbers();
    let number = |id: &str| {
        numbers.get(id).copied().ok_or_else(|| {
            let message = format!(
                "{creature} has no receptor \"{id}\": remove it, or give the map of this skin (`bodyschema \
                 inspect` lists the receptors)"
            );
            Error::content(path, None, message)
        })
    };
    let mut neighbours: Vec<Option<Vec<usize>>> = vec![None; skin.receptors.len()];
    for (id, others) in &read.neighbours {
        let receptor = number(id)?;
        let found = others.iter().map(|other| number(other)).collect::<Result<Vec<usize>, Error>>()?;
        if found.contains(&receptor) {
            return refuse(format!("\"{id}\" is its own neighbour: remove it from its list"));
        }
        if let Some(twice) = (1..found.len()).find(|k| found[..*k].contains(&found[*k])) {
            let other = &others[twice];
            return refuse(format!("\"{id}\" lists its neighbour \"{other}\" twice: remove one"));
        }
        if found.len() > MOST_NEIGHBOURS {
            let count = found.len();
            return refuse(format!(
                "\"{id}\" has {count} neighbours: keep only the nearest, at most {MOST_NEIGHBOURS}"
            ));
        }
        neighbours[receptor] = Some(found);
    }
    if let Some(missing) = neighbours.iter().position(Option::is_none) {
        return refuse(format!(
            "it lists {} of the {} receptors of {creature}, and \"{}\" is none of them: give the map of this \
             skin; a receptor without neighbours has an empty list",
            neighbours.iter().flatten().count(),
            neighbours.len(),
            skin.receptors[missing].id
        ));
    }
    let neighbours: Vec<Vec<usize>> = neighbours.into_iter().flatten().collect();
    for (receptor, of) in neighbours.iter().enumerate() {
        if let Some(&other) = of.iter().find(|&&other| !neighbours[other].contains(&receptor)) {
            let [id, other] = [receptor, other].map(|r| &skin.receptors[r].id);
            return refuse(format!(
                "\"{id}\" lists its neighbour \"{other}\", but not the other way round: add \"{id}\" to the list \
                 of \"{other}\", or remove it"
            ));
        }
    }
    Ok(SomatotopicMap::of_lists(neighbours))
}
