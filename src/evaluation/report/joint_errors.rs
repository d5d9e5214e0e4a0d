//! The error of every joint as a box.

use plotly::box_plot::BoxPoints;
use plotly::common::Marker;
use plotly::{BoxPlot, Trace};

use super::ReportInput;
use super::picture::{BLUE, axis, bounds, figure, layout, log_axis, significant, small, thinned};
use super::residuals::Residuals;
use super::text::escape;
use crate::evaluation::{held_out, held_out_points};
use crate::ground_truth::GroundTruth;
use crate::kinematics::Chain;

/// Most values that a box is made of.
const MOST: usize = 400;
/// Values below this are drawn as this, millimetres: rounding, not learning.
const LEAST: f64 = 1e-12;

/// The picture: against the truth where it is known, else by what is left of the touches.
pub(super) fn figure_of(input: &ReportInput, residuals: &Residuals) -> String {
    let creature = input.creature;
    let mut values = vec![Vec::new(); creature.joints().len()];
    let title = match input.truth {
        Some(truth) => {
            let truth = GroundTruth { schema: truth.clone() };
            let points = held_out_points(creature, input.skin);
            for error in held_out(creature, &truth, input.schema, &points) {
                error.joints.iter().for_each(|&joint| values[joint].push(error.millimetres));
            }
            "held-out error, mm"
        }
        None => {
            for ([a, b], residual) in &residuals.values {
                Chain::between(creature, *a, *b)
                    .joints()
                    .for_each(|joint| values[joint].push(residual.abs()));
            }
            "residual, mm"
        }
    };
    let values: Vec<Vec<f64>> = values
        .into_iter()
        .map(|list| {
            let list: Vec<f64> = list.into_iter().filter(|value| value.is_finite()).collect();
            thinned(list, MOST).into_iter().map(|value| significant(value.max(LEAST), 3)).collect()
        })
        .collect();
    let Some((least, greatest)) = bounds(values.iter().flatten().copied()) else {
        return "<p class=\"note\">There is nothing to measure a joint's error by.</p>\n".into();
    };
    let boxes = creature.joints().iter().zip(values).filter(|(_, list)| !list.is_empty());
    let traces: Vec<Box<dyn Trace>> = boxes
        .map(|(joint, list)| -> Box<dyn Trace> {
            BoxPlot::<f64, f64>::new(list)
                .name(escape(&joint.name))
                .marker(Marker::new().color(BLUE).size(3))
                .box_points(BoxPoints::False)
                .show_legend(false)
        })
        .collect();
    let layout = layout()
        .x_axis(axis("").tick_angle(-60.0).tick_font(small()))
        .y_axis(log_axis(title, least, greatest))
        .show_legend(false);
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
    figure("joint-errors", "Error per joint", 430, traces, layout, caption)
}
