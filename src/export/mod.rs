//! A learned body in the formats of others: a file and a line in [`FORMATS`] for each.

mod csv;
mod mjcf;
mod urdf;
mod vtk;

use std::path::{Path, PathBuf};

pub use mjcf::to_mjcf;
pub use urdf::{Urdf, to_urdf};
pub use vtk::reachable_vtk;

use crate::agent::Agent;
use crate::creature::Creature;
use crate::geometry::Frame;
use crate::model_files::Element;
use crate::schema::BodySchema;

/// A file to write: where, and its bytes.
pub type ExportedFile = (PathBuf, Vec<u8>);

/// A format that a learned body is written in.
pub struct ExportFormat {
    /// How its files end.
    pub ending: &'static str,
    /// What it is.
    pub about: &'static str,
    /// The files of a body, of which the last has the name given and refers to the others.
    pub files: fn(&Agent, &BodySchema, &Path) -> Vec<ExportedFile>,
}

/// All formats.
pub const FORMATS: &[ExportFormat] = &[
    ExportFormat { ending: "xml", about: "MJCF, for MuJoCo", files: mjcf::files },
    ExportFormat { ending: "urdf", about: "URDF, for ROS and most simulators", files: urdf::files },
    ExportFormat { ending: "csv", about: "a table of the joints", files: csv::files },
    ExportFormat { ending: "vtk", about: "the skin as quadrangles, for ParaView", files: vtk::files },
];

impl ExportFormat {
    /// The format of a file by its name's ending.
    ///
    /// # Errors
    /// A sentence with the endings that there are.
    pub fn of(path: &Path) -> Result<&'static ExportFormat, String> {
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_lowercase();
        FORMATS.iter().find(|format| format.ending == ending).ok_or_else(|| {
            let all = FORMATS.iter().map(|format| format!(".{} for {}", format.ending, format.about));
            let all = all.collect::<Vec<_>>().join("; ");
            format!("{}: unsupported format: use {all}", path.display())
        })
    }
}

/// `X_JL`: where a limb's own frame is on its joint.
fn limb_pose(creature: &Creature, schema: &BodySchema, limb: usize) -> Frame {
    let pose = creature.joint_of(limb).and_then(|joint| schema.limb_poses.get(joint));
    pose.copied().unwrap_or(Frame::identity())
}

fn add(parent: &mut Element, child: Element) {
    parent.children.push(child);
}
