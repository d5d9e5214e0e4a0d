//! Charts, all of them: panels with two axes each, as SVG that follows the reader's screen.
//!
//! Each mark has a title, which a browser shows where the mouse rests, and a class, by which `charts.css` gives it the colours
//! of a light or a dark screen. The drawing's unit is a tenth of a pixel.

mod mark;
mod scale;

use std::fmt::Write;

pub use mark::{ChartGroup, ChartMark, Ink};
pub use scale::Scale;

use super::text::escape;

/// Units of the drawing to a pixel.
const FINE: f64 = 10.0;
/// Size of letters, pixels.
const LETTERS: f64 = 12.0;
/// Height of a line of the legend and of an axis' title, pixels.
const LINE: f64 = 20.0;
/// Between an axis and its labels, pixels.
const GAP: f64 = 8.0;

/// A length in pixels in units of the drawing.
fn fine(pixels: f64) -> i32 {
    (FINE * pixels).round() as i32
}

/// The width of a text in letters of 12 pixels: that in DejaVu Sans, which is wider than what most screens have.
fn width_of(text: &str) -> f64 {
    let share = |letter: char| match letter {
        'f' | 'i' | 'j' | 'l' | 'r' | 't' | 'I' | ' ' | '.' | ',' | ':' | ';' | '\'' | '|' | '(' | ')'
        | '-' => 0.41,
        '²' | '³' | '⁰'..='⁹' | '⁻' | '°' => 0.5,
        'm' | 'w' | 'M' | 'W' | '@' | '%' => 1.0,
        letter if letter.is_ascii_uppercase() => 0.79,
        letter if letter.is_ascii() => 0.64,
        _ => 1.0,
    };
    LETTERS * text.chars().map(share).sum::<f64>()
}

/// Two axes and the marks on them.
pub struct Panel {
    /// What stands above it; empty for nothing.
    pub title: String,
    /// The axis to the right, with what it shows and its unit; empty for nothing.
    pub x: (String, Scale),
    /// The axis upwards; names stand from the top down.
    pub y: (String, Scale),
    /// The marks, one group over the other.
    pub groups: Vec<ChartGroup>,
    /// Width and height between its axes, pixels.
    pub plot: [f64; 2],
}

/// Panels side by side.
pub struct Chart {
    /// What it shows, for those who cannot see it.
    pub says: String,
    /// The panels, from the left, their feet on one line.
    pub panels: Vec<Panel>,
}

impl Chart {
    /// A chart of one panel.
    pub fn new(says: &str, panel: Panel) -> Chart {
        Chart { says: says.into(), panels: vec![panel] }
    }

    /// The chart as a part of a page that has `charts.css`.
    pub fn in_page(&self) -> String {
        let margins: Vec<[f64; 4]> = self.panels.iter().map(Panel::margins).collect();
        let sized = || self.panels.iter().zip(&margins);
        let width = sized().map(|(panel, [left, right, ..])| left + panel.plot[0] + right).sum::<f64>();
        let (legend, rows) = self.legend(width);
        let head = LINE * rows as f64;
        let tallest = sized().map(|(panel, [_, _, top, _])| top + panel.plot[1]).fold(0.0, f64::max);
        let foot = margins.iter().map(|[.., bottom]| *bottom).fold(0.0, f64::max);
        let mut svg = format!(
            "<svg class=\"chart\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\" \
             style=\"width:{width:.0}px;--own:{width:.0}px\">\n",
            fine(width),
            fine(head + tallest + foot),
            escape(&self.says),
        );
        let mut left = 0.0;
        for (panel, margins) in sized() {
            panel.draw([left + margins[0], head + tallest - panel.plot[1]], &mut svg);
            left += margins[0] + panel.plot[0] + margins[1];
        }
        svg + &format!("<g>\n{legend}</g>\n</svg>\n")
    }

    /// The names of groups with their colours, and how many rows they take.
    fn legend(&self, width: f64) -> (String, usize) {
        let (mut svg, mut x, mut row) = (String::new(), 0.0, 0);
        let named = self.panels.iter().flat_map(|panel| &panel.groups).filter(|group| !group.name.is_empty());
        for group in named {
            let wide = 34.0 + width_of(&group.name);
            if x > 0.0 && x + wide > width {
                (x, row) = (0.0, row + 1);
            }
            let _ = writeln!(
                svg,
                "<g class=\"{}\" transform=\"translate({} {})\">{}<text x=\"190\" y=\"45\" class=\"plain\">{}</text></g>",
                group.ink.class(),
                fine(x + 4.0),
                fine(LINE * row as f64 + 8.0),
                group.sample(),
                escape(&group.name)
            );
            x += wide;
        }
        let rows = if svg.is_empty() { 0 } else { row + 1 };
        (svg, rows)
    }
}

impl Panel {
    /// A panel without a title, given the titles and scales of its axes.
    pub fn new(x: (&str, Scale), y: (&str, Scale), groups: Vec<ChartGroup>, plot: [f64; 2]) -> Panel {
        let [x, y] = [x, y].map(|(title, scale)| (title.to_string(), scale));
        Panel { title: String::new(), x, y, groups, plot }
    }

    /// The room about the plot, for what is written at the axes, pixels: left, right, above and below.
    fn margins(&self) -> [f64; 4] {
        let titled = |(title, _): &(String, Scale)| if title.is_empty() { 0.0 } else { LINE };
        // How far the title of an axis reaches out beyond it on either side.
        let over = |title: &str, side: usize| 0.5 * (width_of(title) - self.plot[side]);
        let top = if self.title.is_empty() { GAP } else { 1.5 * LETTERS + GAP };
        let (named, longest) = (self.x.1.is_named(), self.x.1.widest());
        // Names stand aslant; the first of them reaches out to the left.
        let aslant = 0.75 * longest;
        let below = titled(&self.x) + if named { 10.0 + aslant } else { LINE + 2.0 };
        let left = 2.0 * GAP + (self.y.1.widest() + titled(&self.y)).max(if named { aslant } else { 0.0 });
        let right = if named { 16.0 } else { (0.5 * longest).max(16.0) };
        let [across, up] = [over(&self.x.0, 0), over(&self.y.0, 1)];
        [left.max(across), right.max(across), top.max(up), below.max(up)]
    }

    /// Draws it with the upper left corner of its plot somewhere, pixels.
    fn draw(&self, corner: [f64; 2], svg: &mut String) {
        let [width, height] = self.plot;
        let [left, top] = corner.map(fine);
        let foot = fine(corner[1] + height);
        let across = |x: f64| fine(corner[0] + width * self.x.1.share(x));
        let up = |y: f64| {
            let share = self.y.1.share(y);
            fine(corner[1] + height * if self.y.1.is_named() { share } else { 1.0 - share })
        };
        let wide = fine(width);
        let mut grid = |d: String| svg.push_str(&format!("<path class=\"grid\" d=\"{d}\"/>\n"));
        grid(format!("M{left} {top}V{foot}h{wide}"));
        self.x.1.ticks().into_iter().for_each(|tick| grid(format!("M{} {top}V{foot}", across(tick))));
        self.y.1.ticks().into_iter().for_each(|tick| grid(format!("M{left} {}h{wide}", up(tick))));
        // A text of a class at a place, turned by some degrees.
        let mut text = |class: &str, [x, y]: [i32; 2], turned: i32, words: &str| {
            let _ = match words {
                "" => Ok(()),
                words => writeln!(
                    svg,
                    "<text class=\"{class}\" transform=\"translate({x} {y}) rotate({turned})\">{}</text>",
                    escape(words)
                ),
            };
        };
        for tick in self.x.1.ticks() {
            let (x, label) = (across(tick), self.x.1.label(tick));
            if self.x.1.is_named() {
                text("aslant", [x + fine(4.0), foot + fine(10.0)], -45, &label);
            } else {
                text("middle", [x, foot + fine(GAP + LETTERS - 3.0)], 0, &label);
            }
        }
        for tick in self.y.1.ticks() {
            text("end", [left - fine(GAP), up(tick) + 42], 0, &self.y.1.label(tick));
        }
        let below = fine(corner[1] + height + self.margins()[3] - 6.0);
        text("middle", [left + fine(width / 2.0), below], 0, &self.x.0);
        let beside = left - fine(2.0 * GAP + self.y.1.widest());
        text("middle", [beside, top + fine(height / 2.0)], -90, &self.y.0);
        text("", [left, top - fine(GAP)], 0, &self.title);
        self.groups.iter().for_each(|group| group.draw(&|[x, y]| [across(x), up(y)], svg));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(y: Scale, points: &[[f64; 2]]) -> Chart {
        let dots = points.iter().map(|at| ChartMark::dot(*at, 3.0, "a < b".into())).collect();
        let groups = vec![ChartGroup::new("a & b", Ink::Blue, dots)];
        let x = Scale::logarithmic(points.iter().map(|p| p[0]));
        Chart::new("a chart", Panel::new(("touches", x), ("error, mm", y), groups, [300.0, 200.0]))
    }

    #[test]
    fn what_cannot_be_drawn_is_left_out() {
        for points in [&[][..], &[[100.0, f64::NAN]], &[[100.0, 0.0]], &[[100.0, 2.0], [200.0, 1e-20]]] {
            let svg = chart(Scale::logarithmic(points.iter().map(|p| p[1])), points).in_page();
            assert!(svg.starts_with("<svg") && svg.contains("touches") && !svg.contains("NaN"), "{svg}");
            assert!(svg.contains("a &amp; b"), "{svg}");
            roxmltree::Document::parse(&svg).unwrap();
        }
    }

    #[test]
    fn marks_have_titles_and_no_colour_that_a_dark_screen_would_hide() {
        let svg = chart(Scale::logarithmic([1.0, 10.0]), &[[100.0, 2.0], [200.0, 4.0]]).in_page();
        assert_eq!(svg.matches("<title>a &lt; b</title>").count(), 2);
        assert!(!svg.contains("\"#"), "{svg}");
    }

    #[test]
    fn names_stand_at_their_numbers() {
        let names = Scale::Names(vec!["first".into(), "second".into()]);
        let svg = chart(names, &[[100.0, 0.0], [200.0, 1.0]]).in_page();
        assert!(svg.contains("first") && svg.contains("second"), "{svg}");
        // The marks come first, then the one that explains them.
        let of = |rest: &str| rest.split('"').next()?.parse().ok();
        let heights: Vec<f64> = svg.split("cy=\"").skip(1).filter_map(of).take(2).collect();
        assert!(heights.len() == 2 && heights[0] < heights[1], "the first stands above: {heights:?}");
    }
}
