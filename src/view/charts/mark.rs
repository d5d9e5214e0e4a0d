//! Marks on the axes of a chart, each with its tooltip.

use std::fmt::Write;

use super::FINE;
use crate::view::text::escape;

/// Colours that people with any colour vision tell apart, on white and on black (after Okabe and Ito); `charts.css`
/// has their values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    /// What was learned.
    Blue,
    /// A bound, and what stays open.
    Orange,
    /// A learner's own estimate.
    Green,
    /// What is beside the point.
    Grey,
    /// What is near to one.
    Sky,
    /// The colour of letters.
    Letters,
    /// What is far for one, …
    Sand,
    /// … and for more.
    Ochre,
}

impl Ink {
    /// Its class in `charts.css`.
    pub(super) fn class(self) -> String {
        format!("{self:?}").to_lowercase()
    }
}

/// One thing on the axes of a chart. Places are in the units of the axes.
#[derive(Clone, Debug)]
pub enum ChartMark {
    /// Points joined by a line, which is dashed by so many pixels, drawn and not.
    Line { points: Vec<[f64; 2]>, dashes: &'static str, width: f64 },
    /// A dot of a radius in pixels; a cross if that is what it is.
    Dot { at: [f64; 2], radius: f64, cross: bool, says: String },
    /// A box with a text in its middle.
    Cell { from: [f64; 2], to: [f64; 2], opacity: f64, text: String, says: String },
}

impl ChartMark {
    /// A line of a width in pixels, dashed by so many pixels, drawn and not; empty for a whole one.
    pub fn line(points: Vec<[f64; 2]>, dashes: &'static str, width: f64) -> ChartMark {
        ChartMark::Line { points, dashes, width }
    }

    /// The places that it takes.
    pub fn points(&self) -> Vec<[f64; 2]> {
        match self {
            ChartMark::Line { points, .. } => points.clone(),
            ChartMark::Dot { at, .. } => vec![*at],
            ChartMark::Cell { from, to, .. } => vec![*from, *to],
        }
    }

    /// A round dot.
    pub fn dot(at: [f64; 2], radius: f64, says: String) -> ChartMark {
        ChartMark::Dot { at, radius, cross: false, says }
    }
}

/// Marks of one colour and one name.
#[derive(Clone, Debug)]
pub struct ChartGroup {
    /// Its name in the legend; empty where it has none.
    pub name: String,
    /// Its colour.
    pub ink: Ink,
    /// What it draws.
    pub marks: Vec<ChartMark>,
}

impl ChartGroup {
    /// Marks of a name and a colour.
    pub fn new(name: &str, ink: Ink, marks: Vec<ChartMark>) -> ChartGroup {
        ChartGroup { name: name.into(), ink, marks }
    }

    /// Writes the marks, whose places in the drawing `place` tells; a mark without a place is left out.
    pub(super) fn draw(&self, place: &dyn Fn([f64; 2]) -> [i32; 2], svg: &mut String) {
        let _ = writeln!(svg, "<g class=\"{}\">", self.ink.class());
        let finite = |point: &[f64; 2]| point.iter().all(|x| x.is_finite());
        let title = |says: &str| match says {
            "" => String::new(),
            says => format!("<title>{}</title>", escape(says)),
        };
        for mark in &self.marks {
            match mark {
                ChartMark::Line { points, dashes, width } => {
                    let points: Vec<[i32; 2]> =
                        points.iter().filter(|p| finite(p)).map(|p| place(*p)).collect();
                    if points.len() > 1 {
                        svg.push_str(&line(&points, dashes, *width));
                    }
                }
                ChartMark::Dot { at, radius, cross, says } if finite(at) => {
                    let ([x, y], r) = (place(*at), (FINE * radius).round() as i32);
                    let (shape, name) = if *cross {
                        let (x, y, d) = (x - r, y - r, 2 * r);
                        (format!("class=\"cross\" d=\"M{x} {y}l{d} {d}m0 -{d}l-{d} {d}\""), "path")
                    } else {
                        (format!("cx=\"{x}\" cy=\"{y}\" r=\"{r}\""), "circle")
                    };
                    let _ = writeln!(svg, "<{name} {shape}>{}</{name}>", title(says));
                }
                ChartMark::Cell { from, to, opacity, text, says } if finite(from) && finite(to) => {
                    let (a, b) = (place(*from), place(*to));
                    let [x, y] = [0, 1].map(|k| a[k].min(b[k]));
                    let [w, h] = [0, 1].map(|k| (a[k] - b[k]).abs());
                    let shape = format!("x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"");
                    let _ =
                        writeln!(svg, "<rect {shape} fill-opacity=\"{opacity:.2}\">{}</rect>", title(says));
                    if !text.is_empty() {
                        let class = if *opacity > 0.62 { "on" } else { "in" };
                        let (x, y, text) = (x + w / 2, y + h / 2 + 40, escape(text));
                        let _ = writeln!(svg, "<text class=\"{class}\" x=\"{x}\" y=\"{y}\">{text}</text>");
                    }
                }
                ChartMark::Dot { .. } | ChartMark::Cell { .. } => {}
            }
        }
        svg.push_str("</g>\n");
    }

    /// What stands for it in the legend.
    pub(super) fn sample(&self) -> String {
        let is_there =
            |mark: &&ChartMark| !matches!(mark, ChartMark::Line { points, .. } if points.len() < 2);
        match self.marks.iter().rfind(is_there) {
            Some(ChartMark::Dot { cross: true, .. }) => {
                "<path class=\"cross\" d=\"M40 -35l70 70m0 -70l-70 70\"/>".into()
            }
            Some(ChartMark::Cell { .. }) => "<rect x=\"20\" y=\"-50\" width=\"110\" height=\"100\"/>".into(),
            Some(ChartMark::Line { dashes, width, .. }) => line(&[[0, 0], [150, 0]], dashes, *width),
            _ => "<circle cx=\"75\" cy=\"0\" r=\"40\"/>".into(),
        }
    }
}

fn line(points: &[[i32; 2]], dashes: &str, width: f64) -> String {
    let fine = dashes.split(' ').filter_map(|n| n.parse::<f64>().ok()).map(|n| format!("{:.0}", FINE * n));
    let dashes = match fine.collect::<Vec<_>>().join(" ") {
        none if none.is_empty() => none,
        dashes => format!(" stroke-dasharray=\"{dashes}\""),
    };
    let places: Vec<String> = points.iter().map(|[x, y]| format!("{x} {y}")).collect();
    format!(
        "<path class=\"line\" stroke-width=\"{:.0}\"{dashes} d=\"M{}\"/>\n",
        FINE * width,
        places.join("L")
    )
}
