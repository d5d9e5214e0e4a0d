//! A picture of the page: a figure of plotly.js, kept as data beside the place it is drawn in.

use plotly::common::{Anchor, ExponentFormat, Font, Orientation};
use plotly::configuration::DisplayModeBar;
use plotly::layout::{Axis, AxisType, Legend, Margin};
use plotly::{Configuration, Layout, Plot, Trace};

use super::text::{escape, tick_label, ticks};

/// Colours that people with any colour vision tell apart, on white and on black (after Okabe and Ito).
pub(crate) const BLUE: &str = "#3a8fc4";
pub(crate) const ORANGE: &str = "#e08214";
pub(crate) const GREY: &str = "#8a939c";
pub(crate) const GREEN: &str = "#2aa57c";

/// What draws the pictures, as text that a script of the page hands to the browser when the first is to be drawn.
///
/// The first script of what the library embeds is plotly.js; what follows draws formulas, of which there are none.
pub(crate) fn library() -> String {
    let scripts = Plot::offline_js_sources();
    let source = scripts.split_once('>').and_then(|(_, rest)| rest.split_once("</script>"));
    let source = source.map_or("", |(source, _)| source);
    format!("<script type=\"text/plain\" id=\"library\">{source}</script>")
}

/// The place of a picture, its data and its caption, which is HTML.
pub(crate) fn figure(
    id: &str,
    says: &str,
    height: usize,
    traces: Vec<Box<dyn Trace>>,
    layout: Layout,
    caption: &str,
) -> String {
    figure_over(id, says, height, traces, layout, caption, "")
}

/// A [`figure`] with a still in its place, which is SVG, until it is drawn.
pub(super) fn figure_over(
    id: &str,
    says: &str,
    height: usize,
    traces: Vec<Box<dyn Trace>>,
    layout: Layout,
    caption: &str,
    still: &str,
) -> String {
    let mut plot = Plot::new();
    plot.add_traces(traces);
    plot.set_layout(layout.height(height).auto_size(true));
    plot.set_configuration(
        Configuration::new().responsive(true).display_logo(false).display_mode_bar(DisplayModeBar::Hover),
    );
    let data = harmless(&plot.to_json());
    format!(
        "<figure>\n<div class=\"plot\" id=\"{id}\" role=\"img\" aria-label=\"{}\" style=\"height:{height}px\">{still}</div>\n\
         <script type=\"application/json\" data-plot=\"{id}\">{data}</script>\n\
         <figcaption>{caption}</figcaption>\n</figure>\n",
        escape(says)
    )
}

/// JSON in a script of a page: no character may end the script or begin an element.
pub(crate) fn harmless(json: &str) -> String {
    json.replace('&', "\\u0026").replace('<', "\\u003c").replace('>', "\\u003e")
}

/// A layout with its legend above.
pub(crate) fn layout() -> Layout {
    let legend = Legend::new()
        .orientation(Orientation::Horizontal)
        .x(0.0)
        .y(1.02)
        .x_anchor(Anchor::Left)
        .y_anchor(Anchor::Bottom);
    Layout::new().legend(legend).margin(Margin::new().left(88).right(16).top(40).bottom(56))
}

/// An axis with a title.
pub(crate) fn axis(title: &str) -> Axis {
    Axis::new().title(title).auto_margin(true).exponent_format(ExponentFormat::Power)
}

/// A logarithmic axis with a title, labelled with plain numbers where these are short.
pub(crate) fn log_axis(title: &str, least: f64, greatest: f64) -> Axis {
    let decades = (greatest / least).log10();
    // Room at both ends, and never less than about a decade.
    let room = (0.05 * decades).max(0.4 * (1.0 - decades)).max(0.04);
    let range = least * 10f64.powf(-room)..greatest * 10f64.powf(room);
    let labelled = ticks(&range);
    axis(title)
        .type_(AxisType::Log)
        .range(vec![range.start.log10(), range.end.log10()])
        .tick_text(labelled.iter().map(|tick| tick_label(*tick)).collect::<Vec<_>>())
        .tick_values(labelled)
}

/// Small print of a picture.
pub(crate) fn small() -> Font {
    Font::new().size(11)
}

/// The least and the greatest of positive numbers; none where there is none.
pub(crate) fn bounds(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    let positive = values.into_iter().filter(|value| value.is_finite() && *value > 0.0);
    positive.fold(None, |bounds, value| {
        let (least, greatest) = bounds.unwrap_or((value, value));
        Some((value.min(least), value.max(greatest)))
    })
}

/// A number to so many significant digits: a page needs no more, and each costs a byte.
pub(crate) fn significant(value: f64, digits: usize) -> f64 {
    format!("{value:.digits$e}", digits = digits - 1).parse().unwrap_or(value)
}

/// At most `most` of a list, evenly taken.
pub(crate) fn thinned<T>(list: Vec<T>, most: usize) -> Vec<T> {
    let every = list.len().div_ceil(most.max(1)).max(1);
    list.into_iter().step_by(every).collect()
}
