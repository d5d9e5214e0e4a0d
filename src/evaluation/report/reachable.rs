//! Where the hands can get to: slices of the reachable map.

use plotly::common::{Anchor, ColorBar, ColorScale, ColorScaleElement, Font, HoverInfo, Line, Mode};
use plotly::layout::{Annotation, Axis, Margin};
use plotly::{HeatMap, Layout, Scatter, Trace};

use super::picture::{GREY, figure, significant};
use super::text::{degrees_and_millimetres as number, escape};
use crate::record::{SpaceRecord, SpaceSlice};

/// Out of reach, far for one hand and for more, near for one and for more.
const COLOURS: [&str; 5] = ["rgba(0,0,0,0)", "#f3d9a4", "#e3a33b", "#7fc0e6", "#1f77b4"];
const LEVELS: [&str; 4] = ["far, one", "far, more", "near, one", "near, more"];
const NAMES: [&str; 3] = ["x", "y", "z"];
/// Room between two slices, as a share of the whole width.
const BETWEEN: f64 = 0.07;

/// The picture; a sentence that says how to get one where there is no map yet.
pub(super) fn figure_of(space: Option<&SpaceRecord>) -> String {
    let Some(space) = space.filter(|space| !space.slices.is_empty()) else {
        return "<p class=\"note\">There is no map yet: <code>bodyschema space SESSION</code> works it out and \
                <code>bodyschema report SESSION</code> shows it here.</p>\n"
            .into();
    };
    let several = space.hands.len() > 1;
    let mut traces: Vec<Box<dyn Trace>> = Vec::new();
    let mut layout =
        Layout::new().show_legend(false).margin(Margin::new().left(56).right(16).top(44).bottom(56));
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for slice in &space.slices {
        for (k, &axis) in slice.axes.iter().enumerate() {
            let [from, to] = extent(slice, space.voxel, k);
            (low[axis], high[axis]) = (low[axis].min(from), high[axis].max(to));
        }
    }
    let span = |slice: &SpaceSlice, k: usize| high[slice.axes[k]] - low[slice.axes[k]];
    // At most three slices: a plane each.
    let slices = &space.slices[..space.slices.len().min(3)];
    let widths: f64 = slices.iter().map(|slice| span(slice, 0)).sum();
    let room = 1.0 - BETWEEN * (slices.len() - 1) as f64;
    let tallest = slices.iter().map(|slice| span(slice, 1)).fold(0.0, f64::max);
    let mut from = 0.0;
    let mut notes = Vec::new();
    for (n, slice) in slices.iter().enumerate() {
        let number = if n == 0 { String::new() } else { (n + 1).to_string() };
        let (x_axis, y_axis) = (format!("x{number}"), format!("y{number}"));
        traces.push(map(slice, space.voxel, several, n == 0, (&x_axis, &y_axis)));
        traces.push(outlines(slice, (&x_axis, &y_axis)));
        let width = room * span(slice, 0) / widths;
        let [a, b] = slice.axes;
        let turned = a == 1 && b == 0;
        let limits = |axis: usize, turned: bool| {
            if turned { vec![high[axis], low[axis]] } else { vec![low[axis], high[axis]] }
        };
        let right = Axis::new()
            .title(format!("{}, m", NAMES[a]))
            .domain(&[from, from + width])
            .range(limits(a, turned))
            .dtick(0.5)
            .anchor(&y_axis);
        let up = Axis::new()
            .title(format!("{}, m", NAMES[b]))
            .domain(&[0.0, span(slice, 1) / tallest])
            .range(limits(b, false))
            .scale_anchor(&x_axis)
            .dtick(0.5)
            .anchor(&x_axis);
        layout = match n {
            0 => layout.x_axis(right).y_axis(up),
            1 => layout.x_axis2(right).y_axis2(up),
            _ => layout.x_axis3(right).y_axis3(up),
        };
        let third = 3 - a - b;
        notes.push(
            Annotation::new()
                .text(format!("{}, {} = {:.2} m", escape(&slice.name), NAMES[third], slice.at))
                .x_ref("paper")
                .y_ref("paper")
                .x(from)
                .y(span(slice, 1) / tallest)
                .x_anchor(Anchor::Left)
                .y_anchor(Anchor::Bottom)
                .show_arrow(false)
                .font(Font::new().size(12)),
        );
        from += width + BETWEEN;
    }
    let litres = space.hands.iter().zip(&space.litres).map(|(hand, [near, far])| {
        format!("{}: {} l near, {} l far", escape(hand), number(*near), number(*far))
    });
    let caption = format!(
        "Where {} can get to by the learned schema, in the frame of {}: near by the arm alone, far by leaning{}. \
         Lines are limbs at ease. {}.",
        escape(&space.hands.join(" and ")),
        escape(&space.chest),
        if several { ", for one of them or for more" } else { "" },
        litres.collect::<Vec<_>>().join("; ")
    );
    // The page is about 980 pixels wide: slices keep their shape.
    let height = (room * 840.0 * tallest / widths).round().clamp(200.0, 900.0) as usize + 100;
    figure("reachable", "Slices of the reachable map", height, traces, layout.annotations(notes), &caption)
}

/// The least and greatest coordinate of a slice along its first or second axis, metres.
fn extent(slice: &SpaceSlice, voxel: f64, k: usize) -> [f64; 2] {
    let count = if k == 0 { slice.rows.iter().map(String::len).max().unwrap_or(0) } else { slice.rows.len() };
    let from = slice.first[k] - 0.5 * voxel;
    let places = slice.outlines.iter().flatten().map(|point| point[k]);
    let (low, high) =
        places.fold((from, from + voxel * count as f64), |(low, high), x| (low.min(x), high.max(x)));
    [low - 0.04, high + 0.04]
}

fn map(
    slice: &SpaceSlice,
    voxel: f64,
    several: bool,
    with_scale: bool,
    (x_axis, y_axis): (&str, &str),
) -> Box<dyn Trace> {
    let places = |k: usize, count: usize| {
        (0..count).map(|n| significant(slice.first[k] + voxel * n as f64, 6)).collect()
    };
    let columns = slice.rows.iter().map(String::len).max().unwrap_or(0);
    let level = |digit: u8| (digit > b'0').then(|| f64::from(digit - b'0'));
    let cells: Vec<Vec<Option<f64>>> =
        slice.rows.iter().map(|row| row.bytes().map(level).collect()).collect();
    let (x, y): (Vec<f64>, Vec<f64>) = (places(0, columns), places(1, slice.rows.len()));
    let steps = COLOURS.iter().enumerate().flat_map(|(n, colour)| {
        [n, n + 1].map(|edge| ColorScaleElement(0.2 * edge as f64, colour.to_string()))
    });
    let shown = |level: &usize| several || level % 2 == 1;
    let levels: Vec<usize> = (1..=4).filter(shown).collect();
    let name = |level: &usize| {
        let name = LEVELS[level - 1];
        if several { name.to_string() } else { name.replace(", one", "") }
    };
    HeatMap::new(x, y, cells)
        .color_scale(ColorScale::Vector(steps.collect()))
        .zmin(-0.5)
        .zmax(4.5)
        .hover_info(HoverInfo::XAndY)
        .hover_on_gaps(false)
        .show_scale(with_scale)
        .color_bar(
            ColorBar::new()
                .thickness(14)
                .tick_vals(levels.iter().map(|level| *level as f64).collect())
                .tick_text(levels.iter().map(name).collect::<Vec<_>>()),
        )
        .x_axis(x_axis)
        .y_axis(y_axis)
}

fn outlines(slice: &SpaceSlice, (x_axis, y_axis): (&str, &str)) -> Box<dyn Trace> {
    let (mut x, mut y) = (Vec::new(), Vec::new());
    for outline in &slice.outlines {
        x.extend(outline.iter().map(|point| Some(significant(point[0], 4))).chain([None]));
        y.extend(outline.iter().map(|point| Some(significant(point[1], 4))).chain([None]));
    }
    Scatter::new(x, y)
        .mode(Mode::Lines)
        .line(Line::new().color(GREY).width(1.0))
        .hover_info(HoverInfo::Skip)
        .x_axis(x_axis)
        .y_axis(y_axis)
}
