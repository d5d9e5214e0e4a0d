//! The learning curve: the error and its bound as touches come in, and how far each touch was from its prediction.

use super::ReportInput;
use crate::view::charts::{Chart, ChartGroup, ChartMark, Ink, Panel, Scale};
use crate::view::figure;
use crate::view::text::{bounds, short_number as number, thinned, touches};

/// Values below this are drawn as this, millimetres: rounding, not learning.
const LEAST: f64 = 1e-12;
/// Most touches that are drawn as dots.
const MOST_DOTS: usize = 1200;

/// The picture; a sentence where nothing was kept to draw it from.
pub(super) fn figure_of(input: &ReportInput) -> String {
    let drawn = |value: f64| value.abs().max(LEAST);
    let of_checkpoints = |value: fn(&crate::session::Checkpoint) -> Option<f64>| -> Vec<[f64; 2]> {
        let points = input.checkpoints.iter().filter(|checkpoint| checkpoint.touches > 0);
        points.filter_map(|checkpoint| Some([checkpoint.touches as f64, drawn(value(checkpoint)?)])).collect()
    };
    let errors = of_checkpoints(|checkpoint| checkpoint.error_rms);
    let limits = of_checkpoints(|checkpoint| checkpoint.bound_rms);
    let initial_guess = input.checkpoints.iter().find(|checkpoint| checkpoint.touches == 0);
    let initial_guess = initial_guess.and_then(|checkpoint| checkpoint.error_rms).map(drawn);
    let prediction = |row: &crate::session::LearningRow| {
        let (gap, deviation) = (row.predicted_gap_mm?, row.predicted_deviation_mm?);
        Some([row.touches as f64, drawn(gap), drawn(deviation)])
    };
    let predicted: Vec<[f64; 3]> = input.predictions.iter().filter_map(prediction).collect();
    let predicted = thinned(predicted, MOST_DOTS);
    let x = || errors.iter().chain(&limits).map(|p| p[0]).chain(predicted.iter().map(|p| p[0]));
    let y = errors.iter().chain(&limits).map(|p| p[1]).chain(initial_guess);
    let y = y.chain(predicted.iter().flat_map(|p| [p[1], p[2]]));
    let (Some((first, last)), scale) = (bounds(x()), Scale::logarithmic(y)) else {
        return "<p class=\"note\">Too little was kept on the way for a curve.</p>\n".into();
    };
    let mut groups = Vec::new();
    let mut group = |name: &str, ink, marks| groups.push(ChartGroup::new(name, ink, marks));
    let after = |count: f64| format!("after {}", touches(count as usize));
    if !predicted.is_empty() {
        let dot = |p: &[f64; 3]| {
            let says =
                format!("touch {}: missed by {} mm, predicted ± {} mm", p[0], number(p[1]), number(p[2]));
            ChartMark::Dot { at: [p[0], p[1]], radius: 1.8, cross: false, says }
        };
        group(
            "miss of each touch, before it was learned from",
            Ink::Grey,
            predicted.iter().map(dot).collect(),
        );
        let line = predicted.iter().map(|p| [p[0], p[2]]).collect();
        let line = ChartMark::Line { points: line, dashes: "", width: 1.5 };
        group("deviation predicted for it", Ink::Green, vec![line]);
    }
    if let Some(error) = initial_guess.filter(|_| !errors.is_empty()) {
        let points = vec![[first, error], [last, error]];
        let dots = points
            .iter()
            .map(|at| ChartMark::dot(*at, 2.0, format!("at a random initial guess: {} mm", number(error))));
        let line = ChartMark::Line { points: points.clone(), dashes: "2 4", width: 1.5 };
        group("error of a random initial guess", Ink::Blue, dots.chain([line]).collect());
    }
    let mut curve = |name: &str, ink: Ink, points: &[[f64; 2]], dashes: &'static str, radius: f64| {
        if points.is_empty() {
            return;
        }
        let says = |p: &[f64; 2]| format!("{name} {}: {} mm", after(p[0]), number(p[1]));
        let mut marks: Vec<ChartMark> = points.iter().map(|p| ChartMark::dot(*p, radius, says(p))).collect();
        marks.push(ChartMark::Line { points: points.to_vec(), dashes, width: 2.2 });
        group(name, ink, marks);
    };
    curve("held-out error", Ink::Blue, &errors, "", 4.0);
    curve("Cramér-Rao bound", Ink::Orange, &limits, "7 4", 3.2);
    let panel =
        Panel::new(("touches", Scale::logarithmic(x())), ("error, mm", scale), groups, [660.0, 320.0]);
    let mut caption = String::new();
    if !errors.is_empty() {
        caption
            .push_str("The held-out error is the root mean square over limbs that are located in the end. ");
    }
    if !limits.is_empty() {
        caption.push_str(
            "The bound is the least that any unbiased learner could leave on average over many sessions with so many \
             touches, if their noise is what the learner estimates; a single session may lie below it. ",
        );
    }
    if !predicted.is_empty() {
        caption.push_str("Dots: how far apart the schema put the two surfaces that then touched.");
    }
    figure("curve", &Chart::new("The learning curve", panel), caption.trim_end())
}
