//! A session of what a creature feels while it is stroked all over.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::error::Error;
use crate::senses::{FiringRecorder, TouchEvent};
use crate::session::{FiringWriter, Host, PROGRAM, SENSATIONS_FILE, Session, SessionOptions, model_hash};
use crate::simulation::partner::stroke_for;
use crate::simulation::{Stage, event_json};

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
    Session {
        program: PROGRAM.to_string(),
        engine: stage.body().model.version().to_string(),
        model: model.display().to_string(),
        model_hash: model_hash(model)?,
        recording: None,
        command,
        host: Some(Host::here()),
        seed,
        options: SessionOptions { joints: "all".to_string(), root, ..SessionOptions::default() },
        effort: None,
        agent: stage.agent().clone(),
    }
    .write(folder)?;
    let mut firings = FiringWriter::create(folder, stage.agent().creature().name(), stage.skin())?;
    let path = folder.join(SENSATIONS_FILE);
    let unwritable = |error| Error::unwritable(&path)(error);
    let mut sensations = BufWriter::new(File::create(&path).map_err(unwritable)?);
    let (mut recorder, mut fired, mut sensed) = (FiringRecorder::default(), 0, 0);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let room = stroke_for(stage, seconds, &mut rng, |stage, time, contacts, events| {
        progress(time);
        for firing in recorder.step(time, contacts) {
            firings.write(&firing)?;
            fired += 1;
        }
        for event in events.iter().filter(|event| matches!(event, TouchEvent::Sensed { .. })) {
            writeln!(sensations, "{}", event_json(stage, time, event)).map_err(unwritable)?;
            sensed += 1;
        }
        Ok::<(), Error>(())
    })?;
    for firing in recorder.rest() {
        firings.write(&firing)?;
        fired += 1;
    }
    firings.finish()?;
    sensations.flush().map_err(unwritable)?;
    match room {
        true => Ok([sensed, fired]),
        false => Err(Error::unfit(model, "there is no room to stroke this creature")),
    }
}
