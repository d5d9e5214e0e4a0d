//! Maps of where hands can get to as a file of VTK, which ParaView opens: the legacy form of an image with a number per voxel and hand.
//!
//! The form is a head of a few lines and the numbers as bytes, so it is written here and not by a library
//! ("VTK File Formats", section "Simple Legacy Formats").

use crate::peripersonal::{Lattice, OwnBody, ReachableMap};

/// The box about the boxes of all maps.
pub fn about(maps: &[ReachableMap]) -> Lattice {
    let lattices = || maps.iter().map(ReachableMap::lattice);
    let first = [0, 1, 2].map(|k| lattices().map(|l| l.first[k]).min().unwrap_or(0));
    let end = [0, 1, 2].map(|k| lattices().map(|l| l.first[k] + l.counts[k] as i32).max().unwrap_or(0));
    let counts = [0, 1, 2].map(|k| (end[k] - first[k]) as usize);
    Lattice { voxel: lattices().next().map_or(0.0, |l| l.voxel), first, counts }
}

/// The maps: per hand 2 near, 1 far and 0 out of reach, in the box about all of them.
pub fn reachable_vtk(own: &OwnBody, maps: &[ReachableMap]) -> Vec<u8> {
    let lattice = about(maps);
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
