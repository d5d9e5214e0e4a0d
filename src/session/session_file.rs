//! How a session came about: everything needed to repeat it or to read its touches.

use std::path::Path;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::stamp::Stamp;
use super::{Host, SESSION_FILE, files, mistaken};
use crate::agent::Agent;
use crate::creature::Creature;
use crate::deadline::Limit;
use crate::error::Error;
use crate::simulation::Effort;
use crate::skin::Skin;

const STAMP: Stamp = Stamp { format: "bodyschema session", version: 1 };

/// A session: who babbled, in which model, how, and what it cost.
///
/// In the file, the format's name and version come before these fields.
#[derive(Clone, Debug, PartialEq)]
pub struct Session {
    /// The program and its version: [`PROGRAM`](super::PROGRAM).
    pub program: String,
    /// The version of MuJoCo that simulated it; empty where it was recorded and not simulated.
    pub engine: String,
    /// The model's path as it was given; empty where there is none.
    pub model: String,
    /// The model's content: `model_hash`; empty where there is none.
    pub model_hash: String,
    /// The files it was made of, where it was recorded and not simulated.
    pub recording: Option<RecordingFiles>,
    /// The command line that made it, word by word; empty where it was not kept.
    pub command: Vec<String>,
    /// The computer it was made on; none where it was not kept.
    pub host: Option<Host>,
    /// Seed of all random streams.
    pub seed: u64,
    /// What was asked for.
    pub options: SessionOptions,
    /// What babbling cost; none until it is done.
    pub effort: Option<BabblingEffort>,
    /// The creature that babbled, and its skin.
    pub agent: Agent,
}

/// A session as its file has it.
#[derive(Deserialize, Serialize)]
#[serde(expecting = "an object")]
struct SessionFile {
    program: String,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    engine: String,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    model: String,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    model_hash: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    recording: Option<RecordingFiles>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    command: Vec<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    host: Option<Host>,
    seed: u64,
    options: SessionOptions,
    // There as a null at least: what is misspelt would be none in silence.
    #[serde(deserialize_with = "Option::deserialize")]
    effort: Option<BabblingEffort>,
    creature: Creature,
    skin: Skin,
}

/// One of the two of the fields that both have, and of the ones that it has alone.
macro_rules! of_both {
    ($from:ident, $to:ident { $($own:ident),+ }) => {
        $to {
            program: $from.program,
            engine: $from.engine,
            model: $from.model,
            model_hash: $from.model_hash,
            recording: $from.recording,
            command: $from.command,
            host: $from.host,
            seed: $from.seed,
            options: $from.options,
            effort: $from.effort,
            $($own),+
        }
    };
}

impl From<Session> for SessionFile {
    fn from(session: Session) -> SessionFile {
        let (creature, skin) = (session.agent.creature().clone(), session.agent.skin().clone());
        of_both!(session, SessionFile { creature, skin })
    }
}

impl TryFrom<SessionFile> for Session {
    type Error = Error;

    fn try_from(file: SessionFile) -> Result<Session, Error> {
        let agent = Agent::new(file.creature, file.skin)?;
        Ok(of_both!(file, Session { agent }))
    }
}

/// The files of a recording, by their paths as they were given.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct RecordingFiles {
    /// The description of the creature.
    pub creature: String,
    /// The log of touches.
    pub log: String,
}

/// What a session was asked for, in the words of the command line.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct SessionOptions {
    /// Touches wanted.
    pub touches: usize,
    /// Which joints move.
    pub joints: String,
    /// The body at which the creature begins; none for the first of the tree with most joints.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub root: Option<String>,
    /// What a touch reports; none where nothing was to be learned.
    pub input: Option<String>,
    /// The learner; none where nothing was to be learned.
    pub learner: Option<String>,
    /// The file of prior knowledge of joints; none where nothing was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub known: Option<String>,
    /// How motions were chosen; none in sessions from before there was a choice, which were random.
    #[serde(default)]
    pub policy: Option<String>,
    /// How the body was moved; none where it was without forces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<String>,
    /// Which share of the session it is, as in `3/16`; none where it is all of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub share: Option<String>,
    /// What the command that made it was asked, with all that it chose by default, as it reads it again; null if that was no
    /// command, and in sessions of versions that did not write it.
    #[serde(default, skip_serializing_if = "Value::is_null")]
    pub asked: Value,
}

/// What babbling cost: [`Effort`], and its time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct BabblingEffort {
    /// Motions begun.
    pub motions: u64,
    /// Touches made, where a policy knew all before it had made as many as were asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub touches: Option<usize>,
    /// What ended it where there was more to be touched; none where nothing did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ended_by: Option<Limit>,
    /// Postures whose contacts the engine was asked for.
    pub engine_checks: u64,
    /// Contacts on bare geometry, left out.
    pub bare: u64,
    /// Contacts between neighbouring limbs, left out.
    pub neighbours: u64,
    /// Instant re-contacts, left out.
    pub again: u64,
    /// Time that passed, seconds.
    pub babbling_s: f64,
    /// Time that passed in the simulation, seconds; none where no forces were at work.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulated_s: Option<f64>,
}

impl BabblingEffort {
    /// The effort of motions that took `babbling` in all.
    pub fn new(effort: &Effort, babbling: Duration) -> BabblingEffort {
        BabblingEffort {
            motions: effort.motions,
            touches: None,
            ended_by: None,
            engine_checks: effort.engine_checks,
            bare: effort.bare,
            neighbours: effort.neighbours,
            again: effort.again,
            babbling_s: babbling.as_secs_f64(),
            simulated_s: Some(effort.simulated_s).filter(|simulated| *simulated > 0.0),
        }
    }

    /// The effort without its time; how often gaps were looked at is not kept.
    pub fn effort(&self) -> Effort {
        Effort {
            motions: self.motions,
            engine_checks: self.engine_checks,
            gap_checks: 0,
            bare: self.bare,
            neighbours: self.neighbours,
            again: self.again,
            simulated_s: self.simulated_s.unwrap_or_default(),
        }
    }
}

impl Session {
    /// Writes [`SESSION_FILE`] into `folder`, which is made if missing; whole or not at all.
    ///
    /// # Errors
    /// If the folder or the file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        let path = folder.join(SESSION_FILE);
        files::make_folder(folder)?;
        STAMP.write(&path, &SessionFile::from(self.clone()))
    }

    /// Reads [`SESSION_FILE`] of `folder`.
    ///
    /// # Errors
    /// If it cannot be read, or if there is none, with what is there instead, or
    /// where it is no session, one of a newer version, or one whose skin does not fit its creature.
    pub fn read(folder: &Path) -> Result<Session, Error> {
        let path = folder.join(SESSION_FILE);
        let session: SessionFile =
            STAMP.read(&path, "session").map_err(|error| match mistaken::is_missing(&error) {
                true => Error::content(folder, None, mistaken::for_session(folder)),
                false => error,
            })?;
        Session::try_from(session).map_err(|error| Error::content(&path, None, error.to_string()))
    }
}
