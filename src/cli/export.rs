//! `bodyschema export`: a learned body for other programs.

use std::path::PathBuf;

use super::folders::written_session;
use super::{Outcome, output};
use crate::export::{Urdf, to_mjcf, to_urdf};
use crate::record::{LEARNED_FILE, MadeFolders, ReadLock, SCHEMA_FILE, Session, folder_of, read_schema};

/// Write a session's learned body as a model for other programs.
///
/// The joints are where the schema has them, the limbs have the shapes that the skin tells of, masses are
/// stand-ins. MJCF is what MuJoCo's `simulate` opens. URDF has no balls, capsules or ellipsoids: three hinges stand
/// for a ball, a cylinder and two spheres for a capsule, and ellipsoids refer to an STL mesh that is written beside
/// the file. Limbs of a recording without a skin have no shape.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema export sessions/max-1 --mjcf
  bodyschema export sessions/max-1 --urdf --out max.urdf")]
pub struct ExportArguments {
    /// The session's folder
    session: PathBuf,
    #[command(flatten)]
    format: Format,
    /// The file to write [default: learned.xml or learned.urdf in the session's folder]
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    out: Option<PathBuf>,
}

#[derive(clap::Args)]
#[group(required = true, multiple = false)]
struct Format {
    /// MJCF, for MuJoCo
    #[arg(long)]
    mjcf: bool,
    /// URDF, for ROS and most simulators
    #[arg(long)]
    urdf: bool,
}

pub fn run(args: &ExportArguments) -> Outcome {
    // What goes beside the session's own files is made of them as they are.
    let _lock = args.out.is_none().then(|| written_session(&args.session)).transpose()?;
    let _reading = ReadLock::take(&args.session)?;
    let session = Session::read(&args.session)?;
    let agent = &session.agent;
    let creature = agent.creature();
    let schema = read_schema(&args.session.join(SCHEMA_FILE), creature)?;
    let file = |name: &str| args.out.clone().unwrap_or_else(|| args.session.join(name));
    if args.format.mjcf {
        let path = file(LEARNED_FILE);
        output::file(&path, to_mjcf(agent, &schema))?;
        say!("{}", path.display());
        return Ok(());
    }
    let path = file("learned.urdf");
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let mesh_name = format!("{stem}_ellipsoid.stl");
    let Urdf { xml, mesh } = to_urdf(agent, &schema, &mesh_name);
    let mesh_path = path.with_file_name(mesh_name);
    let _made = MadeFolders::make(folder_of(&path)).map_err(output::not_written(&path))?;
    // First what the other refers to, which is of no use alone.
    let new = mesh.is_some() && !mesh_path.exists();
    if let Some(mesh) = &mesh {
        output::file(&mesh_path, mesh)?;
    }
    output::file(&path, xml).inspect_err(|_| {
        if new {
            let _ = std::fs::remove_file(&mesh_path);
        }
    })?;
    say!("{}", path.display());
    if mesh.is_some() {
        say!("{}", mesh_path.display());
    }
    Ok(())
}
