//! A session made of a recording of a real body.

use std::path::Path;

use super::babbling::BabbledSession;
use super::learning_options::LearningOptions;
use super::observer::Observer;
use crate::agent::Agent;
use crate::error::Error;
use crate::session::{RecordingFiles, Session, SessionOptions, TouchWriter, read_creature, read_recording};

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
