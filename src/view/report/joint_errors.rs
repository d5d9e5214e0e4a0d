//! The error of every joint as a box.

use super::ReportInput;
use crate::evaluation::{held_out, held_out_points};
use crate::kinematics::Chain;
use crate::view::charts::{Chart, ChartGroup, ChartMark, Ink, Panel, Scale};
use crate::view::figure;
use crate::view::text::short_number as number;

/// Values below this are drawn as this, millimetres: rounding, not learning.
const LEAST: f64 = 1e-12;
/// Most joints that are shown: of more, those with the greatest errors.
const MOST_JOINTS: usize = 120;
/// Height of a joint's row, and width of all of them, pixels.
const ROW: f64 = 17.0;
const WIDTH: f64 = 560.0;

/// The picture: against the truth where it is known, else by what is left of the touches.
pub(super) fn figure_of(input: &ReportInput) -> String {
    let creature = input.agent.creature();
    let mut values = vec![Vec::new(); creature.joints().len()];
    let title = match input.truth {
        Some(truth) => {
            let points = held_out_points(input.agent);
            for error in held_out(creature, truth, input.schema, &points) {
                error.joints.iter().for_each(|&joint| values[joint].push(error.millimetres));
            }
            "held-out error, mm"
        }
        None => {
            for ([a, b], residual) in &input.residuals.values {
                Chain::between(creature, *a, *b)
                    .joints()
                    .for_each(|joint| values[joint].push(residual.abs()));
            }
            "residual, mm"
        }
    };
    let named = creature.joints().iter().map(|joint| joint.name.clone());
    let mut boxes: Vec<(String, [f64; 5])> =
        named.zip(values).filter_map(|(name, values)| Some((name, quartiles(values)?))).collect();
    let all = boxes.len();
    if all > MOST_JOINTS {
        let mut medians: Vec<f64> = boxes.iter().map(|(_, values)| values[2]).collect();
        medians.sort_by(|a, b| b.total_cmp(a));
        boxes.retain(|(_, values)| values[2] >= medians[MOST_JOINTS - 1]);
        // Many may be equal.
        boxes.truncate(MOST_JOINTS);
    }
    let left_out = match all - boxes.len() {
        0 => String::new(),
        _ => format!(" Of {all} joints it shows the {} with the greatest medians.", boxes.len()),
    };
    if boxes.is_empty() {
        return "<p class=\"note\">There is nothing to measure a joint's error by.</p>\n".into();
    }
    let mut marks = Vec::new();
    for (k, (name, values)) in boxes.iter().enumerate() {
        marks.extend(box_marks(k, name, *values));
    }
    let scale = Scale::logarithmic(boxes.iter().flat_map(|(_, values)| [values[0], values[4]]));
    let height = ROW * boxes.len() as f64;
    let names = Scale::Names(boxes.into_iter().map(|(name, _)| name).collect());
    let groups = vec![ChartGroup::new("", Ink::Blue, marks)];
    let panel = Panel::new((title, scale), ("", names), groups, [WIDTH, height]);
    let caption = match input.truth {
        Some(_) => {
            "Per joint, the held-out errors of all skin points that are expressed in a limb beyond it: the middle \
             half in the box, all within the whiskers."
        }
        None => {
            "The truth is not known. Per joint, how far apart the schema puts what touched, over all touches with \
             the joint between the two limbs: the middle half in the box."
        }
    };
    figure("joint-errors", &Chart::new("Error per joint", panel), &format!("{caption}{left_out}"))
}

/// A box in a row, with whiskers, of the least, the three quartiles and the greatest of some millimetres.
pub(super) fn box_marks(
    row: usize,
    name: &str,
    [least, low, middle, high, greatest]: [f64; 5],
) -> [ChartMark; 3] {
    let row = row as f64;
    let says = format!(
        "{name}: {} mm on the median, half of it from {} to {} mm, all from {} to {} mm",
        number(middle),
        number(low),
        number(high),
        number(least),
        number(greatest)
    );
    let whiskers = vec![[least, row], [greatest, row]];
    let (from, to) = ([low, row - 0.32], [high, row + 0.32]);
    let points = vec![[middle, row - 0.32], [middle, row + 0.32]];
    [
        ChartMark::Line { points: whiskers, dashes: "", width: 1.0 },
        ChartMark::Cell { from, to, opacity: 0.5, text: String::new(), says },
        ChartMark::Line { points, dashes: "", width: 2.2 },
    ]
}

/// The least, the three quartiles and the greatest of values that are finite; none where there is none.
pub(super) fn quartiles(values: Vec<f64>) -> Option<[f64; 5]> {
    let mut values: Vec<f64> =
        values.into_iter().filter(|value| value.is_finite()).map(|value| value.max(LEAST)).collect();
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    Some([0.0, 0.25, 0.5, 0.75, 1.0].map(|share| values[(share * last as f64).round() as usize]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_split_values_in_four() {
        assert_eq!(quartiles(vec![5.0, 1.0, f64::NAN, 3.0, 2.0, 4.0]), Some([1.0, 2.0, 3.0, 4.0, 5.0]));
        assert_eq!(quartiles(vec![f64::NAN]), None);
    }
}
