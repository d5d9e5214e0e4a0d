//! Opening a model for a command.

use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::Arc;

use super::{Failure, Outcome};
use crate::creature::{Body, JointSelection};
use crate::mujoco::{self, Data, Model};

/// Processor time that a file may take to load, seconds.
const TIME: u64 = 30;
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
    rehearse(path, strip)?;
    if !strip {
        return Model::from_path(path).map_err(|error| match error {
            mujoco::Error::Read { .. } if path.is_file() && strips(path) => Failure(format!(
                "{error}; or give --strip to read its bodies, joints, geoms and meshes alone"
            )),
            error => Failure::from(error),
        });
    }
    let (model, left_out) = Model::stripped(path)?;
    if !left_out.is_empty() {
        let entries = left_out.iter().map(|(what, count)| match count {
            1 => what.clone(),
            count => format!("{what} ({count} times)"),
        });
        eprintln!("bodyschema: left out of {}: {}", path.display(), entries.collect::<Vec<_>>().join(", "));
    }
    Ok(model)
}

/// Whether a file that was refused can be read with `--strip`.
fn strips(path: &Path) -> bool {
    rehearse(path, true).is_ok() && Model::stripped(path).is_ok()
}

/// Lets a process of its own read the model: a foreign file can crash the engine's compiler, or keep it busy for ever.
fn rehearse(path: &Path, strip: bool) -> Outcome {
    // Where this program cannot be run again there is no harm in going on without a rehearsal.
    let Ok(program) = std::env::current_exe() else { return Ok(()) };
    let mut command = Command::new(program);
    command.arg("rehearse").args(strip.then_some("--strip")).arg("--").arg(path);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let Ok(status) = command.status() else { return Ok(()) };
    match reason(status) {
        Some(reason) => Err(Failure(format!(
            "{}: {reason}; look for huge numbers, sizes and meshes in it, or remove parts of it",
            path.display()
        ))),
        None => Ok(()),
    }
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

/// Reads a model and computes one posture; errors are of no interest here.
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
