//! A plot of a study: lines and dots over two axes.

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint};
use plotters::prelude::*;

use crate::evaluation::report::text::{tick_label, ticks};

/// Colours that people with any colour vision tell apart (Okabe and Ito), one per series.
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];
const GRID: RGBColor = RGBColor(226, 229, 233);
const TEXT: RGBColor = RGBColor(82, 96, 109);
/// Size of the drawing, pixels.
const SIZE: (u32, u32) = (900, 520);
/// Values below this are drawn as this on a logarithmic axis: rounding, not learning.
const LEAST: f64 = 1e-12;

/// What an axis counts.
pub enum Scale {
    /// A logarithmic scale.
    Logarithmic,
    /// Names, each at its number counted from 0.
    Names(Vec<String>),
}

/// An axis.
pub struct Axis {
    /// What it shows, with its unit.
    pub title: &'static str,
    /// How it counts.
    pub scale: Scale,
}

/// Points of one colour and one entry in the legend.
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// Points to join by a line.
    pub line: Vec<(f64, f64)>,
    /// Points to draw as dots.
    pub dots: Vec<(f64, f64)>,
}

/// A plot; points with a value that is not finite are left out.
pub struct Plot {
    /// The axis to the right.
    pub x: Axis,
    /// The axis upwards; names stand from the top down.
    pub y: Axis,
    /// What is drawn.
    pub series: Vec<Series>,
}

/// An axis on which coordinates run evenly, whatever it counts.
struct Ruler<'a> {
    scale: &'a Scale,
    even: Even,
}

/// The even coordinate of an axis, with the ticks that it is given.
#[derive(Clone)]
struct Even {
    range: std::ops::Range<f64>,
    ticks: Vec<f64>,
}

impl Ranged for Even {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (first, last): (i32, i32)) -> i32 {
        let share = (value - self.range.start) / (self.range.end - self.range.start);
        first + (share * f64::from(last - first)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.range.clone()
    }
}

impl Scale {
    /// Where a value lies on the even coordinate of its axis.
    fn coordinate(&self, value: f64) -> f64 {
        match self {
            Scale::Logarithmic => value.max(LEAST).log10(),
            Scale::Names(_) => -value,
        }
    }
}

impl<'a> Ruler<'a> {
    /// An axis that holds all of `values`.
    fn new(axis: &'a Axis, values: impl Iterator<Item = f64>) -> Ruler<'a> {
        let scale = &axis.scale;
        match scale {
            Scale::Names(names) => {
                let ticks = (0..names.len()).map(|k| scale.coordinate(k as f64)).collect();
                Ruler { scale, even: Even { range: 0.5 - names.len() as f64..0.5, ticks } }
            }
            Scale::Logarithmic => {
                let bounds = |(low, high): (f64, f64), x: f64| (low.min(x), high.max(x));
                let (low, high) = values.map(|x| x.max(LEAST)).fold((f64::INFINITY, 0.0), bounds);
                // Without values, or with a single one, there is still an axis to draw.
                let (low, high) = if low > high { (1.0, 10.0) } else { (low / 1.3, high * 1.3) };
                let range = if high / low < 10.0 { low / 2.0..high * 2.0 } else { low..high };
                let ticks = ticks(&range).into_iter().map(f64::log10).collect();
                Ruler { scale, even: Even { range: range.start.log10()..range.end.log10(), ticks } }
            }
        }
    }

    fn label(&self, coordinate: f64) -> String {
        match self.scale {
            Scale::Logarithmic => tick_label(10f64.powf(coordinate)),
            Scale::Names(names) => names.get(-coordinate as usize).cloned().unwrap_or_default(),
        }
    }
}

impl Plot {
    /// The corner in whose ninth of the plot the fewest points lie, for the legend.
    fn emptiest_corner(&self, rulers: [&Ruler; 2]) -> SeriesLabelPosition {
        let third = |ruler: &Ruler, value: f64| {
            let Even { range, .. } = &ruler.even;
            let share = (ruler.scale.coordinate(value) - range.start) / (range.end - range.start);
            (3.0 * share).floor()
        };
        let corners = [
            ((2.0, 2.0), SeriesLabelPosition::UpperRight),
            ((0.0, 0.0), SeriesLabelPosition::LowerLeft),
            ((0.0, 2.0), SeriesLabelPosition::UpperLeft),
            ((2.0, 0.0), SeriesLabelPosition::LowerRight),
        ];
        let points = || self.series.iter().flat_map(|series| series.line.iter().chain(&series.dots));
        let crowd = |corner: (f64, f64)| {
            points().filter(|(x, y)| (third(rulers[0], *x), third(rulers[1], *y)) == corner).count()
        };
        let [first, others @ ..] = corners;
        let (_, position) = others.into_iter().fold((crowd(first.0), first.1), |best, (corner, position)| {
            let count = crowd(corner);
            if count < best.0 { (count, position) } else { best }
        });
        position
    }

    /// The plot as a drawing of its own.
    ///
    /// # Errors
    /// Where the drawing library fails.
    pub fn svg(&self, title: &str) -> Result<String, Box<dyn std::error::Error>> {
        let font = |size: u32| ("sans-serif", size).into_font().color(&TEXT);
        let points = || {
            let all = self.series.iter().flat_map(|series| series.line.iter().chain(&series.dots));
            all.copied().filter(|(x, y)| x.is_finite() && y.is_finite())
        };
        let x_ruler = Ruler::new(&self.x, points().map(|point| point.0));
        let y_ruler = Ruler::new(&self.y, points().map(|point| point.1));
        let longest =
            y_ruler.even.ticks.iter().map(|&tick| y_ruler.label(tick).chars().count()).max().unwrap_or(0);
        let mut svg = String::new();
        {
            let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
            area.fill(&WHITE)?;
            let mut chart = ChartBuilder::on(&area)
                .caption(title, font(15))
                .margin(12)
                .x_label_area_size(46)
                .y_label_area_size(34 + 6 * longest as u32)
                .build_cartesian_2d(x_ruler.even.clone(), y_ruler.even.clone())?;
            chart
                .configure_mesh()
                .bold_line_style(GRID)
                .light_line_style(TRANSPARENT)
                .axis_style(GRID)
                .x_desc(self.x.title)
                .y_desc(self.y.title)
                .axis_desc_style(font(13))
                .label_style(font(12))
                .x_label_formatter(&|x| x_ruler.label(*x))
                .y_label_formatter(&|y| y_ruler.label(*y))
                .draw()?;
            for (series, colour) in self.series.iter().zip(COLOURS.into_iter().cycle()) {
                let place = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
                    let finite = points.iter().filter(|(x, y)| x.is_finite() && y.is_finite());
                    finite.map(|&(x, y)| (self.x.scale.coordinate(x), self.y.scale.coordinate(y))).collect()
                };
                let dots = place(&series.dots).into_iter().map(|dot| Circle::new(dot, 3, colour.filled()));
                chart.draw_series(dots)?;
                chart
                    .draw_series(LineSeries::new(place(&series.line), colour.stroke_width(2)))?
                    .label(series.name.clone())
                    .legend(move |(x, y)| Circle::new((x + 10, y), 4, colour.filled()));
            }
            chart
                .configure_series_labels()
                .position(self.emptiest_corner([&x_ruler, &y_ruler]))
                .background_style(WHITE.mix(0.85))
                .border_style(GRID)
                .label_font(font(12))
                .draw()?;
            area.present()?;
        }
        Ok(svg)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(y: Scale, points: Vec<(f64, f64)>) -> Plot {
        let series = Series { name: "a < b".into(), line: points.clone(), dots: points };
        let x = Axis { title: "touches", scale: Scale::Logarithmic };
        Plot { x, y: Axis { title: "error, mm", scale: y }, series: vec![series] }
    }

    #[test]
    fn what_cannot_be_drawn_is_left_out() {
        for points in
            [vec![], vec![(100.0, f64::NAN)], vec![(100.0, 0.0)], vec![(100.0, 2.0), (200.0, 1e-20)]]
        {
            let svg = plot(Scale::Logarithmic, points).svg("title").unwrap();
            assert!(svg.starts_with("<svg") && svg.contains("touches") && !svg.contains("NaN"), "{svg}");
            assert!(svg.contains("a &lt; b"), "{svg}");
        }
    }

    #[test]
    fn names_stand_at_their_numbers() {
        let names = Scale::Names(vec!["first".into(), "second".into()]);
        let svg = plot(names, vec![(100.0, 0.0), (200.0, 1.0)]).svg("title").unwrap();
        assert!(svg.contains("first") && svg.contains("second"));
    }
}
