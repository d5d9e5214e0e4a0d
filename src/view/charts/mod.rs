//! Charts, all of them: panels with two axes each, as SVG that follows the reader's screen.
//!
//! plotters lays out axes, grids and labels. The marks are written beside it, for it knows neither titles, which a
//! browser shows where the mouse rests, nor classes, by which `charts.css` gives the colours of a light or a dark
//! screen. Numbers of the drawing are tenths of a pixel: plotters has whole ones.

mod mark;
mod ruler;
mod study;

use std::fmt::Write;

use plotters::prelude::*;

pub use mark::{ChartGroup, ChartMark, Ink};
pub use ruler::{Ruler, Scale};
pub use study::study_chart;

use super::text::escape;

/// The colours of charts.
pub(super) const STYLE: &str = include_str!("charts.css");

/// Whole numbers of the drawing to a pixel.
const FINE: f64 = 10.0;
/// Size of letters, pixels; plotters takes letters to be so much higher.
const LETTERS: f64 = 12.0;
const HIGHER: f64 = 1.24;
/// Room to the left of all: plotters puts the letters of an upright title right at the edge, where a browser cuts their tops, pixels.
const EDGE: f64 = 4.0;
/// Size of the letters of a drawing's own title, pixels.
const TITLE: f64 = 15.0;
/// Height of a line of the legend, pixels.
const LEGEND: f64 = 20.0;
/// Stand-ins for colours that plotters cannot name: that of letters, and that of grids.
const TEXT: RGBColor = RGBColor(1, 2, 3);
const GRID: RGBColor = RGBColor(1, 2, 4);

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

/// Two axes and what is drawn on them.
pub struct Panel {
    /// What stands above it; empty for nothing.
    pub title: String,
    /// The axis to the right.
    pub x: Ruler,
    /// The axis upwards; names stand from the top down.
    pub y: Ruler,
    /// What is drawn, one after the other.
    pub groups: Vec<ChartGroup>,
    /// Width and height between its axes, pixels.
    pub plot: [f64; 2],
}

/// Panels side by side.
pub struct Chart {
    /// What it is, for who cannot see it, and above a drawing that stands alone.
    pub says: String,
    /// The panels, from the left, their feet on one line.
    pub panels: Vec<Panel>,
}

impl Chart {
    /// A chart of one panel.
    pub fn new(says: &str, panel: Panel) -> Chart {
        Chart { says: says.into(), panels: vec![panel] }
    }

    /// The chart as a part of a page that has [`STYLE`].
    pub fn in_page(&self) -> String {
        self.svg("", "", "")
    }

    /// The chart as a file of its own.
    pub fn alone(&self) -> String {
        let style = format!("<style>\n{}{STYLE}</style>\n", include_str!("alone.css"));
        self.svg(" xmlns=\"http://www.w3.org/2000/svg\"", &style, &self.says)
    }

    fn svg(&self, space: &str, style: &str, title: &str) -> String {
        let margins: Vec<[f64; 4]> = self.panels.iter().map(Panel::margins).collect();
        let sized = || self.panels.iter().zip(&margins);
        let width = sized().map(|(panel, [left, right, ..])| left + panel.plot[0] + right).sum::<f64>();
        let width = width.max(TITLE + TITLE / LETTERS * width_of(title));
        let (legend, rows) = self.legend(width);
        let above = if title.is_empty() { 0.0 } else { 1.5 * LEGEND };
        let head = above + LEGEND * rows as f64;
        let tallest = sized().map(|(panel, [_, _, top, _])| top + panel.plot[1]).fold(0.0, f64::max);
        let foot = margins.iter().map(|[.., bottom]| *bottom).fold(0.0, f64::max);
        let height = head + tallest + foot;
        let mut scaffold = String::new();
        let mut marks = String::new();
        {
            let size = [width, height].map(|side| (FINE * side).round() as u32);
            let area = SVGBackend::with_string(&mut scaffold, size.into()).into_drawing_area();
            let mut left = 0.0;
            for (panel, margins) in sized() {
                let size = [margins[0] + panel.plot[0] + margins[1], margins[2] + panel.plot[1] + margins[3]];
                let corner = [left, head + tallest - panel.plot[1] - margins[2]];
                let [corner, size] = [corner, size].map(|pair| pair.map(|x| (FINE * x).round() as i32));
                // A string takes all that is written.
                let _ = panel.draw(
                    &area.clone().shrink((corner[0], corner[1]), (size[0], size[1])),
                    *margins,
                    &mut marks,
                );
                left += f64::from(size[0]) / FINE;
            }
        }
        let body = scaffold.split_once('>').map_or("", |(_, body)| body);
        let body = body.trim_end().trim_end_matches("</svg>");
        let body = body
            .replace("\"#010203\"", "\"currentColor\"")
            .replace("\"#010204\"", "\"var(--line)\"")
            .replace(" opacity=\"1\"", "")
            .replace(" font-family=\"sans-serif\"", "");
        let title = match title {
            "" => String::new(),
            title => format!("<text class=\"title\" x=\"100\" y=\"190\">{}</text>\n", escape(title)),
        };
        format!(
            "<svg{space} class=\"chart\" viewBox=\"0 0 {:.0} {:.0}\" role=\"img\" \
             aria-label=\"{}\" style=\"width:{width:.0}px;--own:{width:.0}px\">\n{style}{title}{body}{marks}\
             <g transform=\"translate(0 {:.0})\">\n{legend}</g>\n</svg>\n",
            FINE * width,
            FINE * height,
            escape(&self.says),
            FINE * above,
        )
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
                "<g class=\"{}\" transform=\"translate({:.0} {:.0})\">{}<text x=\"190\" y=\"45\" class=\"plain\">{}</text></g>",
                group.ink.class(),
                FINE * (x + 4.0),
                FINE * (LEGEND * row as f64 + 8.0),
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
    /// The room about the plot, for what is written at the axes, pixels: left, right, above and below.
    fn margins(&self) -> [f64; 4] {
        let titled = |ruler: &Ruler| if ruler.title.is_empty() { 0.0 } else { 20.0 };
        // How far the title of an axis reaches out beyond it on either side.
        let over = |ruler: &Ruler, side: usize| 0.5 * (width_of(&ruler.title) - self.plot[side]);
        let top = if self.title.is_empty() { 8.0 } else { 1.5 * LETTERS + 8.0 };
        let (named, longest) = (matches!(self.x.scale, Scale::Names(_)), self.x.widest());
        // Names stand aslant; the first of them reaches out to the left.
        let aslant = 0.75 * longest;
        let below = titled(&self.x) + if named { 10.0 + aslant } else { 22.0 };
        let left = EDGE + (12.0 + self.y.widest() + titled(&self.y)).max(if named { aslant } else { 0.0 });
        let right = if named { 16.0 } else { (0.5 * longest).max(16.0) };
        let [across, up] = [over(&self.x, 0), over(&self.y, 1)];
        [left.max(across), right.max(across), top.max(up), below.max(up)]
    }

    fn draw(
        &self,
        area: &DrawingArea<SVGBackend, plotters::coord::Shift>,
        margins: [f64; 4],
        marks: &mut String,
    ) -> Result<(), Box<dyn std::error::Error>> {
        let fine = |pixels: f64| (FINE * pixels).round() as i32;
        let font = || ("sans-serif", FINE * LETTERS * HIGHER).into_font().color(&TEXT);
        let named = matches!(self.x.scale, Scale::Names(_));
        let (x, y) = (self.x.right(), self.y.up());
        let mut chart = ChartBuilder::on(area)
            .margin_left(fine(EDGE))
            .margin_right(fine(margins[1]))
            .margin_top(fine(margins[2]))
            .x_label_area_size(fine(margins[3]))
            .y_label_area_size(fine(margins[0] - EDGE))
            .build_cartesian_2d(x.clone(), y.clone())?;
        chart
            .configure_mesh()
            .bold_line_style(GRID.stroke_width(FINE as u32))
            .light_line_style(TRANSPARENT)
            .axis_style(GRID.stroke_width(FINE as u32))
            .set_all_tick_mark_size(fine(3.0))
            .x_desc(&self.x.title)
            .y_desc(&self.y.title)
            .axis_desc_style(font())
            .label_style(font())
            .x_label_formatter(&|at| if named { String::new() } else { self.x.label(x.value(*at)) })
            .y_label_formatter(&|at| self.y.label(y.value(*at)))
            .draw()?;
        let place = |point: [f64; 2]| -> [i32; 2] {
            chart.backend_coord(&(x.coordinate(point[0]), y.coordinate(point[1]))).into()
        };
        if !self.title.is_empty() {
            let (left, top) =
                (chart.plotting_area().get_pixel_range().0.start, area.get_pixel_range().1.start);
            writeln!(
                marks,
                "<text x=\"{left}\" y=\"{}\">{}</text>",
                top + fine(LETTERS),
                escape(&self.title)
            )?;
        }
        if let Scale::Names(names) = &self.x.scale {
            let foot = chart.plotting_area().get_pixel_range().1.end + fine(10.0);
            for (k, name) in names.iter().enumerate() {
                let x = chart.backend_coord(&(x.coordinate(k as f64), 0.0)).0 + fine(4.0);
                let name = escape(name);
                writeln!(
                    marks,
                    "<text class=\"aslant\" transform=\"translate({x} {foot}) rotate(-45)\">{name}</text>"
                )?;
            }
        }
        self.groups.iter().for_each(|group| group.draw(&place, marks));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(y: Scale, points: &[[f64; 2]]) -> Chart {
        let dots = points.iter().map(|at| ChartMark::dot(*at, 3.0, "a < b".into())).collect();
        let groups = vec![ChartGroup { name: "a & b".into(), ink: Ink::Blue, marks: dots }];
        let x = Ruler { title: "touches".into(), scale: Scale::logarithmic(points.iter().map(|p| p[0])) };
        let y = Ruler { title: "error, mm".into(), scale: y };
        Chart::new("a chart", Panel { title: String::new(), x, y, groups, plot: [300.0, 200.0] })
    }

    #[test]
    fn what_cannot_be_drawn_is_left_out() {
        for points in [&[][..], &[[100.0, f64::NAN]], &[[100.0, 0.0]], &[[100.0, 2.0], [200.0, 1e-20]]] {
            let svg = chart(Scale::logarithmic(points.iter().map(|p| p[1])), points).alone();
            assert!(svg.starts_with("<svg") && svg.contains("touches") && !svg.contains("NaN"), "{svg}");
            assert!(svg.contains("a &amp; b"), "{svg}");
            xmltree::Element::parse(svg.as_bytes()).unwrap();
        }
    }

    #[test]
    fn marks_say_what_they_are() {
        let svg = chart(Scale::logarithmic([1.0, 10.0]), &[[100.0, 2.0], [200.0, 4.0]]).in_page();
        assert_eq!(svg.matches("<title>a &lt; b</title>").count(), 2);
    }

    #[test]
    fn names_stand_at_their_numbers() {
        let names = Scale::Names(vec!["first".into(), "second".into()]);
        let svg = chart(names, &[[100.0, 0.0], [200.0, 1.0]]).in_page();
        assert!(svg.find("first").is_some() && svg.contains("second"), "{svg}");
        // The marks come first, then the one that explains them.
        let heights: Vec<f64> = svg
            .split("cy=\"")
            .skip(1)
            .filter_map(|rest| rest.split('"').next()?.parse().ok())
            .take(2)
            .collect();
        assert!(heights.len() == 2 && heights[0] < heights[1], "the first stands above: {heights:?}");
    }

    #[test]
    fn no_colour_is_left_that_a_dark_screen_would_hide() {
        let svg = chart(Scale::logarithmic([1.0, 10.0]), &[[100.0, 2.0]]).in_page();
        assert!(!svg.contains("\"#"), "{svg}");
    }
}
