//! The error of every joint as a box.

use super::ReportInput;
use crate::evaluation::{held_out, held_out_points};
use crate::kinematics::Chain;
use crate::view::charts::{Chart, box_marks, quartiles, rows};
use crate::view::figure;

/// Most joints that are shown: of more, those with the greatest errors.
const MOST_JOINTS: usize = 120;

/// The picture: against the truth where it is known, else by what is left of the touches.
pub(super) fn figure_of(input: &ReportInput) -> String {
    let creature = input.agent.creature();
    let mut values = vec![Vec::new(); creature.joints().len()];
    let (title, caption) = match input.truth {
        Some(truth) => {
            let points = held_out_points(input.agent);
            for error in held_out(creature, truth, input.schema, &points) {
                error.joints.iter().for_each(|&joint| values[joint].push(error.millimetres));
            }
            (
                "held-out error, mm",
                "Per joint, the held-out errors of all skin points expressed in the frame of a limb beyond it. \
                 Boxes show the middle half, whiskers the range.",
            )
        }
        None => {
            for ([a, b], residual) in &input.residuals.values {
                let between = Chain::between(creature, *a, *b);
                between.joints().for_each(|joint| values[joint].push(residual.abs()));
            }
            (
                "residual, mm",
                "The true body is not known. Per joint, the residuals of all touches with the joint between the \
                 two limbs. Boxes show the middle half.",
            )
        }
    };
    let named = creature.joints().iter().map(|joint| joint.name.clone());
    let mut boxes: Vec<(String, [f64; 5])> =
        named.zip(values).filter_map(|(name, values)| Some((name, quartiles(values)?))).collect();
    let all = boxes.len();
    let mut left_out = String::new();
    if all > MOST_JOINTS {
        let mut medians: Vec<f64> = boxes.iter().map(|(_, values)| values[2]).collect();
        medians.sort_by(|a, b| b.total_cmp(a));
        boxes.retain(|(_, values)| values[2] >= medians[MOST_JOINTS - 1]);
        // Many may be equal.
        boxes.truncate(MOST_JOINTS);
        left_out = format!(" Shown are the {MOST_JOINTS} of {all} joints with the largest medians.");
    }
    if boxes.is_empty() {
        return "<p class=\"note\">No data on joint errors.</p>\n".into();
    }
    let marks =
        boxes.iter().enumerate().flat_map(|(k, (name, values))| box_marks(k, name, *values)).collect();
    let names = boxes.into_iter().map(|(name, _)| name).collect();
    let chart = Chart::new("Error per joint", rows(title, names, marks, Vec::new()));
    figure("joint-errors", &chart, &format!("{caption}{left_out}"))
}
