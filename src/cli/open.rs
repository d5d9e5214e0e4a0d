//! Opening a model for a command.

use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::Arc;

use nix::sys::resource::{Resource, getrlimit, setrlimit};
use serde::{Deserialize, Serialize};

use super::progress::Bars;
use super::{Failure, Outcome};
use crate::creature::{Body, DofKind, JointSelection};
use crate::ground_truth::GroundTruth;
use crate::model_files::unreadable_mesh;
use crate::mujoco::{Data, Model};
use crate::session::{self, Embodied, ModelSource, Session, mistaken_for_model, wide_ranges};

/// Processor time that a file may take to load, seconds.
const TIME: u64 = 20;
/// Memory that a file may take to load, bytes.
const MEMORY: u64 = 8 << 30;

/// The model that is meant where none is named.
pub const MAX: &str = "mjcf/max/max.xml";

/// Whether the model that is meant where none is named is there: it is in the program's repository.
pub fn is_there(model: &Path, command: &str) -> Outcome {
    if model.exists() || model != Path::new(MAX) {
        return Ok(());
    }
    Err(Failure(format!(
        "{MAX}: no such file here: give a model, as in `bodyschema {command} MODEL`, or change to the folder that \
         contains mjcf"
    )))
}

/// What of a file is the creature.
#[derive(clap::Args, Clone, Debug, Default, Serialize, Deserialize)]
#[command(next_help_heading = "Reading the model")]
pub struct ModelArguments {
    /// The creature's root body [default: the first body of the tree with the most joints]
    #[arg(long, value_name = "BODY")]
    pub root: Option<String>,
}

impl ModelArguments {
    /// A model's file, read like this.
    pub fn source(&self, model: &Path, joints: JointSelection) -> ModelSource {
        ModelSource { model: model.to_path_buf(), joints, root: self.root.clone(), textures: false }
    }
}

/// Reads a creature in its model with its skin, after another process has shown that the engine survives it.
pub fn embodied(source: ModelSource) -> Result<Embodied, Failure> {
    rehearse(&source.model)?;
    let place = source.model.display().to_string();
    let embodied = Embodied::open(source, &Bars::default())?;
    let hinges = embodied.agent().creature().dofs().filter(|dof| dof.kind == DofKind::Hinge);
    if let Some(note) = wide_ranges(hinges.map(|dof| (dof.name.as_str(), dof.range))) {
        tell!("{place}: {note}");
    }
    Ok(embodied)
}

/// A session's creature in its model, or in another that is named; with its textures where they are wanted.
pub fn session_body(session: &Session, model: Option<&Path>, textures: bool) -> Result<Body, Failure> {
    rehearse(model.unwrap_or(Path::new(&session.model)))?;
    Ok(session::session_body(session, model, textures, &Bars::default())?)
}

/// The truth, where a model is at hand; a recording has one only if it is named.
pub fn known_truth(session: &Session, model: Option<&Path>) -> Result<Option<GroundTruth>, Failure> {
    if session.model.is_empty() && model.is_none() {
        return Ok(None);
    }
    match session_body(session, model, false).and_then(|body| Ok(GroundTruth::new(&body)?)) {
        Ok(truth) => Ok(Some(truth)),
        Err(error) if model.is_some() => Err(error),
        Err(Failure(sentence)) => {
            tell!("not measured: {sentence}");
            Ok(None)
        }
    }
}

/// Whether the engine survives a model: a process of its own reads it, for a foreign file can crash the engine's
/// compiler, or keep it busy for ever.
pub fn rehearse(path: &Path) -> Outcome {
    if let Some(sentence) = mistaken_for_model(path) {
        return Err(Failure(sentence));
    }
    // Where this program cannot be run again there is no harm in going on without a rehearsal.
    let Ok(program) = std::env::current_exe() else { return Ok(()) };
    let mut command = Command::new(program);
    command.arg("rehearse").arg("--").arg(path);
    let Ok(output) = command.stdin(Stdio::null()).output() else { return Ok(()) };
    if let Some(reason) = reason(output.status) {
        if let Some(refused) = unreadable_mesh(path) {
            return Err(Failure(refused.to_string()));
        }
        let fix = "look for huge numbers, sizes and meshes in it, or remove parts";
        return Err(Failure::at(path, format_args!("{reason}; {fix}")));
    }
    let said = String::from_utf8_lossy(&output.stderr);
    let sentence = said.trim().strip_prefix("bodyschema: ").unwrap_or(said.trim());
    if output.status.success() { Ok(()) } else { Err(Failure(sentence.to_string())) }
}

/// Why a rehearsal ended, where it did not come to its end.
fn reason(status: ExitStatus) -> Option<String> {
    const SIGXCPU: i32 = 24;
    const SIGKILL: i32 = 9;
    match status.signal()? {
        SIGXCPU | SIGKILL => {
            let seconds = at_most(Resource::RLIMIT_CPU, TIME).unwrap_or(TIME);
            Some(format!("MuJoCo did not finish loading it within {seconds} s"))
        }
        signal => Some(format!("MuJoCo crashes on it (signal {signal})")),
    }
}

/// A limit, or a lower one that the process has been given and must not raise.
fn at_most(resource: Resource, most: u64) -> std::io::Result<u64> {
    let (soft, hard) = getrlimit(resource)?;
    Ok(most.min(soft).min(hard))
}

/// Read a model within limits of time and memory, for another process that waits.
#[derive(clap::Args)]
pub struct RehearseArgs {
    model: PathBuf,
}

/// Reads a model and computes one posture.
pub fn run(args: &RehearseArgs) -> Outcome {
    let limits = [(Resource::RLIMIT_CPU, TIME), (Resource::RLIMIT_AS, MEMORY), (Resource::RLIMIT_CORE, 0)];
    for (resource, most) in limits {
        let limit = at_most(resource, most)?;
        setrlimit(resource, limit, limit)?;
    }
    let mut data = Data::new(Arc::new(Model::read(&args.model)?.0))?;
    data.kinematics()?;
    data.collision()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rehearsal_that_does_not_end_says_why() {
        assert_eq!(reason(ExitStatus::from_raw(0)), None);
        assert_eq!(reason(ExitStatus::from_raw(1 << 8)), None);
        assert!(reason(ExitStatus::from_raw(24)).unwrap().contains("20 s"));
        assert!(reason(ExitStatus::from_raw(11)).unwrap().contains("signal 11"));
    }
}
