//! The learned joints as a table, for spreadsheets and programs that know neither MJCF nor URDF.

use std::path::Path;

use super::ExportedFile;
use crate::agent::Agent;
use crate::creature::DofKind;
use crate::schema::BodySchema;

/// The columns: positions in metres, ranges in radians, of slides in metres.
const TITLES: [&str; 13] = [
    "joint",
    "parent",
    "dof",
    "kind",
    "position_x",
    "position_y",
    "position_z",
    "axis_x",
    "axis_y",
    "axis_z",
    "lower",
    "upper",
    "follows",
];

/// A row per degree of freedom: `l_P` of its joint and `a_P` in the parent limb's frame. A ball has no axis.
pub(super) fn files(agent: &Agent, schema: &BodySchema, path: &Path) -> Vec<ExportedFile> {
    let creature = agent.creature();
    let names: Vec<&str> = creature.dofs().map(|dof| dof.name.as_str()).collect();
    let mut table = csv::Writer::from_writer(Vec::new());
    let written = "a table in memory takes every row";
    table.write_record(TITLES).expect(written);
    for (joint, position) in creature.joints().iter().zip(&schema.positions) {
        for (k, dof) in joint.dof_indices().zip(&joint.dofs) {
            let axis = (dof.kind != DofKind::Ball).then_some(&schema.axes[k]);
            let kind = match dof.kind {
                DofKind::Hinge => "hinge",
                DofKind::Slide => "slide",
                DofKind::Ball => "ball",
            };
            let mut row = vec![
                joint.name.clone(),
                creature.limbs()[joint.parent].clone(),
                dof.name.clone(),
                kind.to_string(),
            ];
            row.extend(position.iter().map(f64::to_string));
            row.extend((0..3).map(|i| axis.map(|axis| axis[i].to_string()).unwrap_or_default()));
            row.extend(dof.range.map(|limit| limit.to_string()));
            row.push(dof.follows.map(|coupling| names[coupling.leader].to_string()).unwrap_or_default());
            table.write_record(row).expect(written);
        }
    }
    vec![(path.to_path_buf(), table.into_inner().expect("a table in memory is never flushed in vain"))]
}
