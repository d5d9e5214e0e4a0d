//! Opening a model for a command.

use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::Arc;

use super::learn_options::{InputName, LearnOptions};
use super::{Failure, Outcome};
use crate::creature::{Body, JointSelection};
use crate::learning::Input;
use crate::mujoco::{Data, Model};
use crate::peripersonal::OwnBody;
use crate::record::{SCHEMA_FILE, Session, TOUCHES_FILE, read_schema, read_touches};

/// Processor time that a file may take to load, seconds.
const TIME: u64 = 20;
/// Memory that a file may take to load, bytes.
const MEMORY: u64 = 8 << 30;

/// How a foreign file is read.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct ModelOptions {
    /// Read bodies, joints, geoms, meshes and touch sensors alone, and list what is left out: for files that
    /// MuJoCo refuses for other parts
    #[arg(long)]
    pub strip: bool,
    /// The body at which the creature begins [default: the first of the tree with most joints]
    #[arg(long, value_name = "BODY")]
    pub root: Option<String>,
}

/// Reads a model and the creature in it.
pub fn open_body(path: &Path, joints: &JointSelection, options: &ModelOptions) -> Result<Body, Failure> {
    let model = Arc::new(open_model(path, options.strip)?);
    body_of(model, path, joints, options)
}

/// The creature in a model of the file at `path`.
pub fn body_of(
    model: Arc<Model>,
    path: &Path,
    joints: &JointSelection,
    options: &ModelOptions,
) -> Result<Body, Failure> {
    Body::rooted(model, joints, options.root.as_deref()).map_err(|error| match error {
        // Engine errors name the file themselves.
        crate::creature::BodyError::Engine(error) => Failure::from(error),
        other => Failure(format!("{}: {other}", path.display())),
    })
}

/// Reads a model, after another process has shown that the engine survives it.
pub fn open_model(path: &Path, strip: bool) -> Result<Model, Failure> {
    if let Err(Failure(sentence)) = rehearse(path, strip) {
        let helps = !strip && path.is_file() && rehearse(path, true).is_ok();
        let hint =
            if helps { "; or give --strip to read its bodies, joints, geoms and meshes alone" } else { "" };
        return Err(Failure(format!("{sentence}{hint}")));
    }
    if !strip {
        return Ok(Model::from_path(path)?);
    }
    let (model, left_out) = Model::stripped(path)?;
    if !left_out.is_empty() {
        let entries = left_out.iter().map(|(what, count)| match count {
            1 => what.clone(),
            count => format!("{what} ({count} times)"),
        });
        tell!("left out of {}: {}", path.display(), entries.collect::<Vec<_>>().join(", "));
    }
    Ok(model)
}

/// Lets a process of its own read the model: a foreign file can crash the engine's compiler, or keep it busy for ever.
fn rehearse(path: &Path, strip: bool) -> Outcome {
    // Where this program cannot be run again there is no harm in going on without a rehearsal.
    let Ok(program) = std::env::current_exe() else { return Ok(()) };
    let mut command = Command::new(program);
    command.arg("rehearse").args(strip.then_some("--strip")).arg("--").arg(path);
    let Ok(output) = command.stdin(Stdio::null()).output() else { return Ok(()) };
    if let Some(reason) = reason(output.status) {
        return Err(Failure(format!(
            "{}: {reason}; look for huge numbers, sizes and meshes in it, or remove parts of it",
            path.display()
        )));
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
        SIGXCPU | SIGKILL => Some(format!("MuJoCo did not come to an end with it in {TIME} s")),
        signal => Some(format!("MuJoCo crashes on it (signal {signal})")),
    }
}

/// Read a model within limits of time and memory, for another process that waits.
#[derive(clap::Args)]
pub struct RehearseArgs {
    model: PathBuf,
    #[arg(long)]
    strip: bool,
}

/// A session and what its creature knows of its body after it.
///
/// # Errors
/// Where a file of it cannot be read, or nothing was touched or learned in it.
pub fn own_body(folder: &Path) -> Result<(Session, OwnBody), Failure> {
    let session = Session::read(folder)?;
    let (creature, skin) = (&session.creature, &session.skin);
    let log = read_touches(&folder.join(TOUCHES_FILE), creature, skin)?;
    let schema = read_schema(&folder.join(SCHEMA_FILE), creature)?;
    if log.touches.is_empty() {
        return Err(Failure(format!("{}: there is no touch in it: babble some first", folder.display())));
    }
    let points = LearnOptions::default().for_session(&session)?.input_name() == InputName::Contact;
    let input = if points || !schema.limb_poses.is_empty() { Input::Contact } else { Input::Receptor };
    let own = OwnBody::new(creature, skin, schema, &log.touches, input);
    Ok((session, own))
}

/// Reads a model and computes one posture.
pub fn run(args: &RehearseArgs) -> Outcome {
    use rlimit::Resource;
    Resource::CPU.set(TIME, TIME)?;
    Resource::AS.set(MEMORY, MEMORY)?;
    Resource::CORE.set(0, 0)?;
    let model = if args.strip { Model::stripped(&args.model)?.0 } else { Model::from_path(&args.model)? };
    let mut data = Data::new(Arc::new(model))?;
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
