//! `bodyschema export`: a learned body for other programs.

use std::path::PathBuf;

use super::folders::written_session;
use super::{Failure, Outcome, output};
use crate::error::Error;
use crate::export::ExportFormat;
use crate::session::{LEARNED_FILE, MadeFolders, ReadLock, SCHEMA_FILE, Session, folder_of, read_schema};

/// Write a session's learned body as a model for other programs.
///
/// The file extension selects the format: .xml for MJCF, .urdf for URDF, .csv for a table of the joints, .vtk for the
/// skin in the reference posture (for ParaView). In MJCF and URDF, joints are placed as in the schema, limbs have the
/// shapes of the skin, and masses are placeholders. URDF has no ball joints, capsules or ellipsoids: a ball becomes
/// three hinges, a capsule a cylinder and two spheres, and an ellipsoid an STL mesh written next to the file. Limbs of
/// a recording without a skin have no shape.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema export sessions/max-1
  bodyschema export sessions/max-1 --out max.urdf")]
pub struct ExportArguments {
    /// The session's folder
    session: PathBuf,
    /// The file to write, ending in .xml, .urdf, .csv or .vtk [default: learned.xml in the session's folder]
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    out: Option<PathBuf>,
    #[arg(long, hide = true)]
    mjcf: bool,
    #[arg(long, hide = true)]
    urdf: bool,
}

pub fn run(args: &ExportArguments) -> Outcome {
    for (given, old, ending) in [(args.mjcf, "--mjcf", "xml"), (args.urdf, "--urdf", "urdf")] {
        if given {
            return Err(Failure(format!(
                "{old}: the file extension selects the format: give --out FILE.{ending}"
            )));
        }
    }
    let path = args.out.clone().unwrap_or_else(|| args.session.join(LEARNED_FILE));
    let format = ExportFormat::of(&path)?;
    // What goes beside the session's own files is made of them as they are.
    let inside = folder_of(&path) == args.session;
    let _lock = inside.then(|| written_session(&args.session)).transpose()?;
    let _reading = ReadLock::take(&args.session)?;
    let session = Session::read(&args.session)?;
    let schema = read_schema(&args.session.join(SCHEMA_FILE), session.agent.creature())?;
    let files = (format.files)(&session.agent, &schema, &path);
    let _made = MadeFolders::make(folder_of(&path)).map_err(Error::unwritable(&path))?;
    let mut new = Vec::new();
    for (path, bytes) in &files {
        // What others refer to comes first, and is of no use alone.
        let was_there = path.exists();
        output::file(path, bytes).inspect_err(|_| {
            for path in &new {
                let _ = std::fs::remove_file(path);
            }
        })?;
        new.extend((!was_there).then_some(path));
    }
    files.iter().rev().for_each(|(path, _)| say!("{}", path.display()));
    Ok(())
}
