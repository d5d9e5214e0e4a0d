//! The learned joints as a table, for spreadsheets and programs that know neither MJCF nor URDF.

use std::path::Path;

use super::ExportedFile;
use crate::agent::Agent;
use crate::creature::DofKind;
use crate::schema::BodySchema;

/// The columns: positions in metres, ranges in radians, of slides in metres.
const TITLES: &str =
    "joint,parent,dof,kind,position_x,position_y,position_z,axis_x,axis_y,axis_z,lower,upper,follows";

/// A row per degree of freedom: `l_P` of its joint and `a_P` in the parent limb's frame. A ball has no axis.
pub(super) fn files(agent: &Agent, schema: &BodySchema, path: &Path) -> Vec<ExportedFile> {
    let creature = agent.creature();
    let names: Vec<&str> = creature.dofs().map(|dof| dof.name.as_str()).collect();
    let mut table = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    let written = "a table in memory takes every row";
    table.write_record(TITLES.split(',')).expect(written);
    for (joint, position) in creature.joints().iter().zip(&schema.positions) {
        for (k, dof) in joint.dof_indices().zip(&joint.dofs) {
            let axis = (dof.kind != DofKind::Ball).then_some(&schema.axes[k]);
            let axis = [0, 1, 2].map(|i| axis.map(|axis| axis[i].to_string()));
            let parent = &creature.limbs()[joint.parent];
            let position = <[f64; 3]>::from(*position).map(|x| x.to_string());
            let range = dof.range.map(|limit| limit.to_string());
            let follows = dof.follows.map(|coupling| names[coupling.leader]);
            let row = (&joint.name, parent, &dof.name, dof.kind, position, axis, range, follows);
            table.serialize(row).expect(written);
        }
    }
    vec![(path.to_path_buf(), table.into_inner().expect("a table in memory is never flushed in vain"))]
}
