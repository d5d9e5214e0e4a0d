//! The learning curve: the error and its bound as touches come in, and how far each touch was from what was foretold.

use plotly::common::{DashType, Line, Marker, Mode};
use plotly::{Scatter, Trace};

use super::ReportInput;
use super::picture::{BLUE, GREEN, GREY, ORANGE, bounds, figure, layout, log_axis, significant, thinned};

/// Values below this are drawn as this, millimetres: rounding, not learning.
const LEAST: f64 = 1e-12;
/// Most touches that are drawn as dots.
const MOST_DOTS: usize = 2000;

/// The picture; a sentence where nothing was kept to draw it from.
pub(super) fn figure_of(input: &ReportInput) -> String {
    let drawn = |value: f64| significant(value.abs().max(LEAST), 4);
    let errors: Vec<(f64, f64)> = input
        .checkpoints
        .iter()
        .filter(|checkpoint| checkpoint.touches > 0)
        .filter_map(|checkpoint| Some((checkpoint.touches as f64, drawn(checkpoint.error_rms?))))
        .collect();
    let limits: Vec<(f64, f64)> = input
        .checkpoints
        .iter()
        .filter_map(|checkpoint| Some((checkpoint.touches as f64, drawn(checkpoint.bound_rms?))))
        .collect();
    let onset = input.checkpoints.iter().find(|checkpoint| checkpoint.touches == 0);
    let onset = onset.and_then(|checkpoint| checkpoint.error_rms).map(drawn);
    let foretold: Vec<(f64, f64, f64)> = input
        .predictions
        .iter()
        .filter(|prediction| prediction.gap.is_finite() && prediction.deviation.is_finite())
        .map(|prediction| (prediction.touch as f64, drawn(prediction.gap), drawn(prediction.deviation)))
        .collect();
    let foretold = thinned(foretold, MOST_DOTS);
    let touches = |points: &[(f64, f64)]| points.iter().map(|p| p.0).collect::<Vec<_>>();
    let values = |points: &[(f64, f64)]| points.iter().map(|p| p.1).collect::<Vec<_>>();
    let all_x = touches(&errors).into_iter().chain(touches(&limits)).chain(foretold.iter().map(|p| p.0));
    let all_y = values(&errors).into_iter().chain(values(&limits)).chain(onset);
    let all_y = all_y.chain(foretold.iter().flat_map(|p| [p.1, p.2]));
    let (Some((first, last)), Some((least, greatest))) = (bounds(all_x), bounds(all_y)) else {
        return "<p class=\"note\">Too little was kept on the way for a curve.</p>\n".into();
    };
    let mut traces: Vec<Box<dyn Trace>> = Vec::new();
    if !foretold.is_empty() {
        let x: Vec<f64> = foretold.iter().map(|p| p.0).collect();
        traces.push(
            Scatter::new(x.clone(), foretold.iter().map(|p| p.1).collect())
                .name("miss of each touch, before it was learned from")
                .mode(Mode::Markers)
                .marker(Marker::new().size(4).color(GREY).opacity(0.45)),
        );
        traces.push(
            Scatter::new(x, foretold.iter().map(|p| p.2).collect())
                .name("deviation foretold for it")
                .mode(Mode::Lines)
                .line(Line::new().color(GREEN).width(1.5)),
        );
    }
    if let Some(error) = onset.filter(|_| !errors.is_empty()) {
        traces.push(
            Scatter::new(vec![first, last], vec![error; 2])
                .name("error of a random onset")
                .mode(Mode::Lines)
                .line(Line::new().color(BLUE).width(1.5).dash(DashType::Dot)),
        );
    }
    if !errors.is_empty() {
        traces.push(
            Scatter::new(touches(&errors), values(&errors))
                .name("held-out error")
                .mode(Mode::LinesMarkers)
                .line(Line::new().color(BLUE).width(2.5))
                .marker(Marker::new().size(8)),
        );
    }
    if !limits.is_empty() {
        traces.push(
            Scatter::new(touches(&limits), values(&limits))
                .name("Cramér-Rao bound")
                .mode(Mode::LinesMarkers)
                .line(Line::new().color(ORANGE).width(2.0).dash(DashType::Dash))
                .marker(Marker::new().size(6)),
        );
    }
    let layout = layout()
        .x_axis(log_axis("touches", first, last))
        .y_axis(log_axis("mm", least, greatest))
        .show_legend(true);
    let mut caption = String::new();
    if !errors.is_empty() {
        caption.push_str(
            "The held-out error is the root mean square over what the touches determine in the end. ",
        );
    }
    if !limits.is_empty() {
        caption.push_str(
            "The bound is the least that any unbiased learner could leave on average after so many touches, were \
             their noise what the learner takes it to be. ",
        );
    }
    if !foretold.is_empty() {
        caption.push_str("Dots: how far apart the schema put the two surfaces that then touched.");
    }
    figure("curve", "The learning curve", 430, traces, layout, caption.trim_end())
}
