//! A session made of a recording of a real body.

use std::path::{Path, PathBuf};

use super::babbling::Provenance;
use super::learning_options::LearningOptions;
use super::observer::Observer;
use crate::agent::Agent;
use crate::error::Error;
use crate::senses::RecordedTouch;
use crate::session::{
    Host, PROGRAM, RecordingFiles, Session, SessionOptions, TouchWriter, read_creature, read_recording,
};

/// The two files of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordingSource {
    /// The description of the creature in JSON.
    pub creature: PathBuf,
    /// The log of touches: a table or JSON, by its content.
    pub log: PathBuf,
}

/// A session made of a recording.
#[derive(Clone, Debug)]
pub struct RecordedSession {
    /// The session; it has no model.
    pub session: Session,
    /// Its touches.
    pub touches: Vec<RecordedTouch>,
}

impl RecordedSession {
    /// Reads a recording, of which the first touches are used, at most so many; the observer is told of what is odd
    /// about it. Where no seed is given it is the description's. Ranges of joints become what the touches visit: a log tells of
    /// no other postures, and a description often says a whole turn for want of better.
    ///
    /// # Errors
    /// Where a file cannot be read, or is not what it should be.
    pub fn read(
        source: &RecordingSource,
        most: usize,
        seed: Option<u64>,
        learning: &LearningOptions,
        provenance: Provenance,
        observer: &dyn Observer,
    ) -> Result<RecordedSession, Error> {
        let described = read_creature(&source.creature)?;
        let recording = read_recording(&source.log, &described.agent)?;
        for note in &recording.notes {
            observer.note(&format!("{}: {note}", source.log.display()));
        }
        let mut touches = recording.touches;
        touches.truncate(most);
        let creature = recording.agent.creature().visited(touches.iter().map(|touch| &touch.posture));
        let agent = Agent::new(creature, recording.agent.skin().clone())?;
        let path = |path: &Path| path.display().to_string();
        let session = Session {
            program: PROGRAM.to_string(),
            engine: String::new(),
            model: String::new(),
            model_hash: String::new(),
            recording: Some(RecordingFiles { creature: path(&source.creature), log: path(&source.log) }),
            command: provenance.command,
            host: Some(Host::here()),
            seed: seed.or(described.seed).unwrap_or(1),
            options: SessionOptions {
                touches: touches.len(),
                joints: "all".to_string(),
                input: Some(learning.input.unwrap_or(recording.input).to_string()),
                learner: Some(learning.learner.name().to_string()),
                asked: provenance.asked,
                ..SessionOptions::default()
            },
            effort: None,
            agent,
        };
        Ok(RecordedSession { session, touches })
    }

    /// Writes it into a folder.
    ///
    /// # Errors
    /// Where a file cannot be written, or there is a log in the folder already.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        let mut writer = TouchWriter::create(folder, &self.session.agent)?;
        for touch in &self.touches {
            writer.write(touch)?;
        }
        writer.finish()?;
        self.session.write(folder)
    }
}
