//! A log of touches as it is read: comma-separated values, angles in degrees.

use std::fmt::Write;

use crate::calibration::robot::{MOUNT, Robot, RobotDof};
use crate::calibration::{Feature, Touch};
use crate::creature::DofKind;

/// Touches as a log that [`read_calibration_log`](super::read_calibration_log) reads, with further columns behind: a title and a
/// cell for each touch. Of several contacts the first of either side is written.
pub fn calibration_table(robot: &Robot, touches: &[&Touch], further: &[(&str, Vec<String>)]) -> String {
    let mut titles = joint_titles(robot);
    titles.extend(further.iter().map(|(title, _)| title.to_string()));
    let mut table = format!("limb_a,limb_b,ax,ay,az,bx,by,bz,{}\n", titles.join(","));
    for (k, touch) in touches.iter().enumerate() {
        let mut cells: Vec<String> =
            (0..2).map(|side| name_of(robot, &touch.ends[side][0].feature)).collect();
        for ends in &touch.ends {
            cells.push(match ends[0].feature {
                Feature::Point(_, p) => format!("{:.7},{:.7},{:.7}", p.x, p.y, p.z),
                Feature::Surface(_) => ",,".into(),
            });
        }
        cells.extend(joint_cells(robot, &touch.posture));
        cells.extend(further.iter().filter_map(|(_, column)| column.get(k).cloned()));
        let _ = writeln!(table, "{}", cells.join(","));
    }
    table
}

/// The columns of what encoders read.
pub(crate) fn joint_titles(robot: &Robot) -> Vec<String> {
    let titles = |dof: &RobotDof| match dof.kind {
        DofKind::Hinge => vec![format!("{}_deg", dof.name)],
        DofKind::Slide => vec![dof.name.clone()],
        DofKind::Ball => ["w", "x", "y", "z"].map(|part| format!("{}_{part}", dof.name)).to_vec(),
    };
    robot.leaders().flat_map(titles).collect()
}

/// What encoders read in these columns.
pub(crate) fn joint_cells(robot: &Robot, posture: &[f64]) -> Vec<String> {
    let mut cells = Vec::new();
    for dof in robot.leaders() {
        let own = &posture[dof.coordinate..dof.coordinate + dof.kind.coordinates()];
        let number = |x: &f64| match dof.kind {
            DofKind::Hinge => format!("{:.5}", x.to_degrees()),
            DofKind::Slide | DofKind::Ball => format!("{x:.7}"),
        };
        cells.extend(own.iter().map(number));
    }
    cells
}

/// What a log calls a feature: its surface, or the link that its point is on.
pub(crate) fn name_of(robot: &Robot, feature: &Feature) -> String {
    match *feature {
        Feature::Surface(surface) => robot.surfaces[surface].name.clone(),
        Feature::Point(link, _) => robot.links[link].name.trim_end_matches(MOUNT).to_string(),
    }
}
