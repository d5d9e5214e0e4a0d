//! How a session came about and how far it has come: everything needed to repeat it, to go on with it or to read its touches.

use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::stamp::Stamp;
use super::{PROGRAM, PROGRESS_FILE, SESSION_FILE, files, mistaken};
use crate::agent::Agent;
use crate::babbling::BoutsDone;
use crate::creature::Creature;
use crate::deadline::Limit;
use crate::error::Error;
use crate::simulation::Effort;
use crate::skin::Skin;

const STAMP: Stamp = Stamp { format: "bodyschema session", version: 1 };
const PROGRESS: Stamp = Stamp { format: "bodyschema babbling", version: 1 };

/// A session: who babbled, in which model, how, and what it cost.
///
/// In the file, the format's name and version come before these fields.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Session {
    /// The program and its version: [`PROGRAM`](super::PROGRAM).
    pub program: String,
    /// The version of MuJoCo that simulated it; empty where it was recorded and not simulated.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub engine: String,
    /// The model's path as it was given; empty where there is none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub model: String,
    /// The model's content: `model_hash`; empty where there is none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub model_hash: String,
    /// The files it was made of, where it was recorded and not simulated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recording: Option<RecordingFiles>,
    /// The command line that made it, word by word; empty where it was not kept.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub command: Vec<String>,
    /// The computer it was made on; `None` if it was not kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub host: Option<Host>,
    /// Seed of all random streams.
    pub seed: u64,
    /// What was asked for.
    pub options: SessionOptions,
    /// What babbling cost; `None` until it is done.
    // There as a null at least: what is misspelt would be none in silence.
    #[serde(deserialize_with = "Option::deserialize")]
    pub effort: Option<BabblingEffort>,
    /// The creature that babbled, and its skin.
    // Read apart, as `AgentFile`: within the other fields an error would lose its line.
    #[serde(flatten, skip_deserializing)]
    pub agent: Agent,
}

/// The agent of a session, as its file has it.
#[derive(Deserialize)]
struct AgentFile {
    creature: Creature,
    skin: Skin,
}

/// The files of a recording, by their paths as they were given.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RecordingFiles {
    /// The description of the creature.
    pub creature: String,
    /// The log of touches.
    pub log: String,
}

/// What a session was asked for, in the words of the command line.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SessionOptions {
    /// Touches wanted.
    pub touches: usize,
    /// Which joints move.
    pub joints: String,
    /// The body at which the creature begins; none for the first of the tree with most joints.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub root: Option<String>,
    /// What a touch reports; `None` if nothing was to be learned.
    pub input: Option<String>,
    /// The learner; `None` if nothing was to be learned.
    pub learner: Option<String>,
    /// The file of prior knowledge of joints; `None` if nothing was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub known: Option<String>,
    /// How motions were chosen; none in sessions from before there was a choice, which were random.
    #[serde(default)]
    pub policy: Option<String>,
    /// How the body was moved; `None` if it was without forces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<String>,
    /// What the command that made it was asked, with all that it chose by default, as it reads it again; null if that was no
    /// command, and in sessions of versions that did not write it.
    #[serde(default, skip_serializing_if = "Value::is_null")]
    pub asked: Value,
}

/// What babbling cost: its motions, and its time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BabblingEffort {
    /// What its motions cost.
    #[serde(flatten)]
    pub of_motions: Effort,
    /// Touches made, where a policy knew all before it had made as many as were asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub touches: Option<usize>,
    /// What ended it where there was more to be touched; `None` if nothing did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ended_by: Option<Limit>,
    /// Time that passed, seconds.
    pub babbling_s: f64,
}

impl BabblingEffort {
    /// Time that passed in the simulation, seconds; `None` if no forces were at work.
    pub fn simulated_s(&self) -> Option<f64> {
        Some(self.of_motions.simulated_s).filter(|seconds| *seconds > 0.0)
    }
}

impl Session {
    /// What every session has that is made by this program on this computer; all else is empty.
    pub fn made_here() -> Session {
        Session { program: PROGRAM.to_string(), host: Some(Host::here()), ..Session::default() }
    }

    /// Writes [`SESSION_FILE`] into `folder`, which is made if missing; whole or not at all.
    ///
    /// # Errors
    /// If the folder or the file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        STAMP.write(&folder.join(SESSION_FILE), self)
    }

    /// Reads [`SESSION_FILE`] of `folder`.
    ///
    /// # Errors
    /// If it cannot be read, or if there is none, with what is there instead, or
    /// where it is no session, one of a newer version, or one whose skin does not fit its creature.
    pub fn read(folder: &Path) -> Result<Session, Error> {
        let path = folder.join(SESSION_FILE);
        let json = files::read(&path).map_err(|error| match error.is_missing() {
            true => Error::content(folder, None, mistaken::for_session(folder)),
            false => error,
        })?;
        let mut session: Session = STAMP.content(&path, "session", &json)?;
        let AgentFile { creature, skin } = STAMP.content(&path, "session", &json)?;
        let agent = Agent::new(creature, skin);
        session.agent = agent.map_err(|error| Error::content(&path, None, error.to_string()))?;
        Ok(session)
    }
}

/// A computer, as far as times depend on it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Host {
    /// The processor's name; its architecture where it tells no name.
    pub cpu: String,
    /// Threads that run at the same time.
    pub cores: usize,
    /// The operating system.
    pub os: String,
}

impl Host {
    /// This computer.
    pub fn here() -> Host {
        let value = |file: &str, key: &str| {
            let text = std::fs::read_to_string(file).ok()?;
            let line = text.lines().find(|line| line.starts_with(key))?;
            let (_, value) = line.split_once([':', '='])?;
            Some(value.trim().trim_matches('"').to_string()).filter(|value| !value.is_empty())
        };
        let (arch, os) = (std::env::consts::ARCH, std::env::consts::OS);
        Host {
            cpu: value("/proc/cpuinfo", "model name").unwrap_or_else(|| arch.to_string()),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            os: value("/etc/os-release", "PRETTY_NAME")
                .map_or_else(|| os.to_string(), |name| format!("{name} ({os} {arch})")),
        }
    }
}

/// The bouts that are done, and what they cost. In a session's folder as long as it babbles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BabblingProgress {
    /// Bouts done.
    pub bouts: u64,
    /// Touches made in them.
    pub touches: usize,
    /// What they cost.
    pub effort: BabblingEffort,
}

impl BabblingProgress {
    /// The bouts done; how often gaps were looked at is not kept.
    pub fn done(&self) -> BoutsDone {
        BoutsDone { bouts: self.bouts, touches: self.touches, effort: self.effort.of_motions }
    }

    /// Writes [`PROGRESS_FILE`] into `folder`, whole or not at all.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        PROGRESS.write(&folder.join(PROGRESS_FILE), self)
    }

    /// Reads [`PROGRESS_FILE`] of `folder`; `None` if there is none that can be used.
    pub fn read(folder: &Path) -> Option<BabblingProgress> {
        PROGRESS.read(&folder.join(PROGRESS_FILE), "progress of babbling").ok()
    }

    /// Removes [`PROGRESS_FILE`] from `folder`, where babbling is done.
    pub fn remove(folder: &Path) {
        // Left behind, it does no harm.
        let _ = std::fs::remove_file(folder.join(PROGRESS_FILE));
    }
}
