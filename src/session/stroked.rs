//! A session of what a creature feels while it is stroked all over.

use std::path::Path;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::error::Error;
use crate::senses::{FiringRecorder, TouchEvent};
use crate::session::{SENSATIONS_FILE, Session, SessionOptions, model_hash, write_firings, write_whole};
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
        return Err(Error::unfit(model, "there is no room to stroke this creature"));
    }
    firings.extend(recorder.rest());
    session.write(folder)?;
    write_firings(folder, creature.name(), skin, &firings)?;
    let path = folder.join(SENSATIONS_FILE);
    write_whole(&path, sensations.as_bytes()).map_err(Error::unwritable(&path))?;
    Ok([sensed, firings.len() as u64])
}
