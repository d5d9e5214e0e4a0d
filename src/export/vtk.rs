//! The learned body as a file of VTK, which ParaView opens: its receptors in the reference posture, limb by limb.
//!
//! The form is a head of a few lines and numbers in text ("VTK File Formats", section "Simple Legacy Formats").

use std::fmt::Write;
use std::path::Path;

use nalgebra::Vector3;

use super::ExportedFile;
use crate::agent::Agent;
use crate::kinematics::limb_frames;
use crate::schema::BodySchema;

/// Every receptor as a quadrangle in the root limb's frame, metres, with the number of its limb and its normal.
pub(super) fn files(agent: &Agent, schema: &BodySchema, path: &Path) -> Vec<ExportedFile> {
    let creature = agent.creature();
    let frames = limb_frames(creature, schema, &creature.reference_posture());
    let receptors = &agent.skin().receptors;
    let name: String = creature.name().chars().filter(|c| c.is_ascii_graphic()).take(200).collect();
    let mut text =
        format!("# vtk DataFile Version 3.0\n{name} as learned, metres\nASCII\nDATASET POLYDATA\n");
    let mut line = |words: std::fmt::Arguments| {
        let _ = writeln!(text, "{words}");
    };
    let vector = |v: Vector3<f64>| format!("{} {} {}", v.x, v.y, v.z);
    line(format_args!("POINTS {} double", 4 * receptors.len()));
    for receptor in receptors {
        let [u, v] = receptor.half_extents;
        let (along, across) = (receptor.tangent * u, receptor.bitangent() * v);
        for corner in [-along - across, along - across, along + across, across - along] {
            line(format_args!("{}", vector(frames[receptor.limb].point(&(receptor.position + corner)))));
        }
    }
    line(format_args!("POLYGONS {} {}", receptors.len(), 5 * receptors.len()));
    for first in (0..receptors.len()).map(|r| 4 * r) {
        line(format_args!("4 {first} {} {} {}", first + 1, first + 2, first + 3));
    }
    line(format_args!("CELL_DATA {}\nSCALARS limb int 1\nLOOKUP_TABLE default", receptors.len()));
    receptors.iter().for_each(|receptor| line(format_args!("{}", receptor.limb)));
    line(format_args!("NORMALS normal double"));
    for receptor in receptors {
        line(format_args!("{}", vector(frames[receptor.limb].direction(&receptor.normal))));
    }
    vec![(path.to_path_buf(), text.into_bytes())]
}
