//! The learning curve: the error and its bound as touches come in, and how far each touch was from its prediction.

use std::slice::from_ref;

use super::ReportInput;
use crate::evaluation::touch_misses;
use crate::named::plural;
use crate::session::{Checkpoint, LearningRow};
use crate::view::charts::{Chart, ChartGroup, ChartMark, Ink, Panel, Scale};
use crate::view::figure;
use crate::view::text::short_number as number;

/// Most touches that are drawn as dots.
const MOST_DOTS: usize = 1200;

/// The picture; a sentence where nothing was kept to draw it from.
pub(super) fn figure_of(input: &ReportInput) -> String {
    let of_checkpoints = |value: fn(&Checkpoint) -> Option<f64>| -> Vec<[f64; 2]> {
        let points = input.record.checkpoints.iter();
        points.filter_map(|at| Some([at.touches as f64, value(at)?])).collect()
    };
    let (initial_guess, errors): (Vec<_>, Vec<_>) =
        of_checkpoints(|at| at.error_rms).into_iter().partition(|at| at[0] == 0.0);
    let limits: Vec<_> = of_checkpoints(|at| at.bound_rms).into_iter().filter(|at| at[0] > 0.0).collect();
    let prediction = |row: &LearningRow| {
        let (gap, deviation) = (row.predicted_gap_mm?, row.predicted_deviation_mm?);
        Some([row.touches as f64, gap.abs(), deviation])
    };
    let predicted: Vec<[f64; 3]> = input.predictions.iter().filter_map(prediction).collect();
    let every = predicted.len().div_ceil(MOST_DOTS).max(1);
    let predicted: Vec<[f64; 3]> = predicted.into_iter().step_by(every).collect();
    // A touch and its two receptors, by which the page finds them on the body.
    let receptors = &input.session.agent.skin().receptors;
    let ends = |touch: usize| {
        let ends = input.touches.get(touch.wrapping_sub(1)).map_or(&[][..], |touch| &touch.ends);
        let ids = ends.iter().map(|end| format!(", {}", receptors[end.receptor].id));
        format!("touch {touch}{}", ids.collect::<String>())
    };
    let mut groups = Vec::new();
    let mut group = |name: &str, ink, marks| groups.push(ChartGroup::new(name, ink, marks));
    if !predicted.is_empty() {
        let dots = predicted.iter().map(|[touch, gap, deviation]| {
            let [missed, by] = [gap, deviation].map(|millimetres| number(*millimetres));
            let says =
                format!("{}: prediction error {missed} mm, predicted ± {by} mm", ends(*touch as usize));
            ChartMark::dot([*touch, *gap], 1.8, says)
        });
        group("prediction error of each touch, before it was used", Ink::Grey, dots.collect());
        let deviations = ChartMark::line(predicted.iter().map(|p| [p[0], p[2]]).collect(), "", 1.5);
        group("predicted deviation", Ink::Green, vec![deviations]);
    } else if input.converged() == Some(true) && !input.touches.is_empty() {
        let every = input.touches.len().div_ceil(MOST_DOTS).max(1);
        let residuals = input.touches.iter().zip(1..).step_by(every).map(|(touch, number_of)| {
            let residual = touch_misses(&input.session.agent, input.schema, from_ref(touch)).max;
            let says = format!("{}: residual {} mm", ends(number_of), number(residual));
            ChartMark::dot([number_of as f64, residual], 1.8, says)
        });
        group("contact residual of each touch, by the final schema", Ink::Grey, residuals.collect());
    }
    if let (Some([_, error]), false) = (initial_guess.first(), errors.is_empty()) {
        let x = errors.iter().chain(&limits).map(|p| p[0]).chain(predicted.iter().map(|p| p[0]));
        let [first, last] = [x.clone().fold(f64::INFINITY, f64::min), x.fold(0.0, f64::max)];
        let says = format!("random initial guess: {} mm", number(*error));
        let points = [first, last].map(|x| [x, *error]);
        let mut marks = points.map(|at| ChartMark::dot(at, 2.0, says.clone())).to_vec();
        marks.push(ChartMark::line(points.to_vec(), "2 4", 1.5));
        group("error of a random initial guess", Ink::Blue, marks);
    }
    let curves = [
        ("held-out error", Ink::Blue, &errors, "", 4.0),
        ("Cramér-Rao bound", Ink::Orange, &limits, "7 4", 3.2),
    ];
    for (name, ink, points, dashes, radius) in
        curves.into_iter().filter(|(_, _, points, ..)| !points.is_empty())
    {
        let says =
            |p: &[f64; 2]| format!("{name} after {}: {} mm", plural(p[0] as usize, "touch"), number(p[1]));
        let mut marks: Vec<ChartMark> = points.iter().map(|p| ChartMark::dot(*p, radius, says(p))).collect();
        marks.push(ChartMark::line(points.clone(), dashes, 2.2));
        group(name, ink, marks);
    }
    if groups.is_empty() {
        return "<p class=\"note\">Too few checkpoints for a curve.</p>\n".into();
    }
    let [x, y] = [0, 1].map(|axis| Scale::logarithmic_of(&groups, axis));
    let panel = Panel::new(("touches", x), ("error, mm", y), groups, [660.0, 320.0]);
    let captions = [
        (
            !errors.is_empty(),
            "The held-out error is the root mean square over limbs that are located in the end.",
        ),
        (
            !limits.is_empty(),
            "The bound is the smallest error that any unbiased learner can achieve on average over many sessions \
             with this many touches and the estimated noise; a single session may lie below it.",
        ),
        (
            !predicted.is_empty(),
            "Dots: predicted distance between the two touching surfaces, before each touch was used.",
        ),
    ];
    let captions: Vec<&str> =
        captions.into_iter().filter_map(|(there, words)| there.then_some(words)).collect();
    figure("curve", &Chart::new("The learning curve", panel), &captions.join(" "))
}
