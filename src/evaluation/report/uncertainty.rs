//! How sure the learner is of every joint.

use plotly::common::{HoverInfo, Marker, MarkerSymbol, Mode};
use plotly::layout::AxisType;
use plotly::{Scatter, Trace};

use super::ReportInput;
use super::picture::{BLUE, GREEN, ORANGE, axis, bounds, figure, layout, log_axis, significant, small};
use super::text::{degrees_and_millimetres as number, escape};
use crate::creature::DofKind;
use crate::schema::SchemaStd;

/// Deviations of one kind: per value the joint and what it is called, and how much; none where nothing
/// determines it.
type Deviations = Vec<(String, String, Option<f64>)>;

/// The picture; a sentence where the learner cannot tell.
pub(super) fn figure_of(input: &ReportInput) -> String {
    let Some(std) = input.std else {
        return "<p class=\"note\">This learner does not tell how sure it is.</p>\n".into();
    };
    let (positions, axes) = deviations(input, std);
    let values = |list: &Deviations| bounds(list.iter().filter_map(|(_, _, value)| *value));
    let (least, greatest) = values(&positions).unwrap_or((1e-3, 1e-3));
    let (sharpest, bluntest) = values(&axes).unwrap_or((1e-3, 1e-3));
    // What is open stands above all that is not.
    let above = |least: f64, greatest: f64| greatest * (greatest / least).powf(0.12).max(2.0);
    let (top, axes_top) = (above(least, greatest), above(sharpest, bluntest));
    let mut traces: Vec<Box<dyn Trace>> = Vec::new();
    traces.extend(dots(&positions, "position", "mm", BLUE, "y", top));
    traces.extend(dots(&axes, "axis", "°", GREEN, "y2", axes_top));
    let names: Vec<String> = input.creature.joints().iter().map(|joint| escape(&joint.name)).collect();
    let joints = axis("")
        .type_(AxisType::Category)
        .tick_angle(-60.0)
        .tick_font(small())
        .category_order(plotly::layout::CategoryOrder::Array)
        .category_array(names);
    let open = |list: &Deviations| list.iter().any(|(_, _, value)| value.is_none());
    let upper = |list: &Deviations, top: f64, greatest: f64| if open(list) { top } else { greatest };
    let layout = layout()
        .x_axis(joints.anchor("y2"))
        .y_axis(log_axis("position, mm", least, upper(&positions, top, greatest)).domain(&[0.55, 1.0]))
        .y_axis2(log_axis("axis, °", sharpest, upper(&axes, axes_top, bluntest)).domain(&[0.0, 0.45]))
        .show_legend(true);
    let known = positions.iter().filter(|(_, _, value)| *value == Some(0.0)).count();
    let mut caption =
        "One standard deviation by the learner's own account: of each coordinate of a joint's position, \
                       and of each axis across its direction. Crosses stand for what no touch determines."
            .to_string();
    if known > 0 {
        caption.push_str(" What was known exactly beforehand is not shown.");
    }
    figure("uncertainty", "Uncertainty of every joint", 520, traces, layout, &caption)
}

fn deviations(input: &ReportInput, std: &SchemaStd) -> (Deviations, Deviations) {
    let (mut positions, mut axes) = (Vec::new(), Vec::new());
    for (j, joint) in input.creature.joints().iter().enumerate() {
        let name = escape(&joint.name);
        let coordinates = std.positions.get(j).into_iter().flatten();
        for (coordinate, value) in ["x", "y", "z"].into_iter().zip(coordinates) {
            positions.push((name.clone(), format!("{name}, {coordinate}"), value.map(|metres| 1e3 * metres)));
        }
        for (k, dof) in joint.dof_indices().zip(&joint.dofs).filter(|(_, dof)| dof.kind != DofKind::Ball) {
            let value = std.axes.get(k).copied().flatten();
            axes.push((name.clone(), escape(&dof.name), value.map(f64::to_degrees)));
        }
    }
    (positions, axes)
}

/// Dots for what is known and crosses for what is open.
fn dots(
    list: &Deviations,
    what: &str,
    unit: &str,
    colour: &'static str,
    y_axis: &str,
    top: f64,
) -> Vec<Box<dyn Trace>> {
    let mut traces: Vec<Box<dyn Trace>> = Vec::new();
    let known: Vec<_> = list
        .iter()
        .filter_map(|(joint, name, value)| Some((joint, name, value.filter(|v| *v > 0.0)?)))
        .collect();
    if !known.is_empty() {
        let hover = known.iter().map(|(_, name, value)| format!("{name}: {} {unit}", number(*value)));
        traces.push(
            Scatter::new(
                known.iter().map(|(joint, ..)| joint.to_string()).collect(),
                known.iter().map(|(.., value)| significant(*value, 4)).collect(),
            )
            .name(what)
            .mode(Mode::Markers)
            .marker(Marker::new().size(7).color(colour).opacity(0.75))
            .hover_text_array(hover.collect::<Vec<_>>())
            .hover_info(HoverInfo::Text)
            .y_axis(y_axis),
        );
    }
    let open: Vec<_> = list.iter().filter(|(_, _, value)| value.is_none()).collect();
    if !open.is_empty() {
        let hover = open.iter().map(|(_, name, _)| format!("{name}: undetermined"));
        traces.push(
            Scatter::new(open.iter().map(|(joint, ..)| joint.clone()).collect(), vec![top; open.len()])
                .name(format!("{what} undetermined"))
                .mode(Mode::Markers)
                .marker(Marker::new().size(8).color(ORANGE).symbol(MarkerSymbol::X))
                .hover_text_array(hover.collect::<Vec<_>>())
                .hover_info(HoverInfo::Text)
                .y_axis(y_axis),
        );
    }
    traces
}
