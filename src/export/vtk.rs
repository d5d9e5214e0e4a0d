//! Files of VTK, which ParaView opens: the skin of a learned body, and maps of where hands can get to.
//!
//! The forms are a head of a few lines and numbers, so they are written here and not by a library ("VTK File Formats", section
//! "Simple Legacy Formats").

use std::fmt::Write;
use std::path::Path;

use nalgebra::Vector3;

use super::ExportedFile;
use crate::agent::Agent;
use crate::kinematics::limb_frames;
use crate::peripersonal::{Lattice, OwnBody, ReachableMap};
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

/// The maps: per hand 2 near, 1 far and 0 out of reach, in the box about all of them.
pub fn reachable_vtk(own: &OwnBody, maps: &[ReachableMap]) -> Vec<u8> {
    let lattice = Lattice::about(maps.iter().map(ReachableMap::lattice));
    let [nx, ny, nz] = lattice.counts;
    let origin = lattice.middle(lattice.first);
    let chest = maps.first().map_or("", |map| &own.creature().limbs()[map.chest]);
    // The second line is a title of at most 255 characters.
    let title: String =
        format!("{}: 2 near, 1 far, 0 out of reach; metres in the frame of {chest}", own.creature().name())
            .chars()
            .filter(|c| c.is_ascii_graphic() || *c == ' ')
            .take(250)
            .collect();
    let mut file = format!(
        "# vtk DataFile Version 3.0\n{title}\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS {nx} {ny} {nz}\nORIGIN {} {} {}\n\
         SPACING {v} {v} {v}\nPOINT_DATA {}\n",
        origin.x,
        origin.y,
        origin.z,
        lattice.len(),
        v = lattice.voxel
    )
    .into_bytes();
    for map in maps {
        // A name with blanks would end at the first of them.
        let name: String =
            map.name(own).chars().map(|c| if c.is_ascii_graphic() { c } else { '_' }).collect();
        file.extend(format!("SCALARS {name} unsigned_char 1\nLOOKUP_TABLE default\n").into_bytes());
        file.extend((0..lattice.len()).map(|index| map.level_of(lattice.cell_at(index)).number()));
        file.push(b'\n');
    }
    file
}
