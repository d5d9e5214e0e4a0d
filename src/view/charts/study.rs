//! The plot of a study as a chart.

use super::{Chart, ChartGroup, ChartMark, Ink, Panel, Scale};
use crate::experiment::study::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use crate::view::text::short_number;

/// Width and height between the axes, pixels.
const PLOT: [f64; 2] = [700.0, 400.0];

/// The chart of what a study plots.
pub fn study_chart(plot: &StudyPlot, title: &str) -> Chart {
    let all = plot.series.iter().flat_map(|series| series.line.iter().chain(&series.dots));
    let finite: Vec<(f64, f64)> = all.copied().filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
    let axis = |axis: &PlotAxis, values: Vec<f64>| match &axis.scale {
        AxisScale::Logarithmic => (axis.title, Scale::logarithmic(values)),
        AxisScale::Names(names) => (axis.title, Scale::Names(names.clone())),
    };
    let group = |(series, ink): (&PlotSeries, Ink)| {
        let says = |x: f64, y: f64| format!("{}: {}, {}", series.name, told(&plot.x, x), told(&plot.y, y));
        let dots = series.dots.iter().map(|&(x, y)| ChartMark::dot([x, y], 3.0, says(x, y)));
        let line = series.line.iter().map(|&(x, y)| [x, y]).collect();
        ChartGroup { name: series.name.clone(), ink, marks: dots.chain([ChartMark::line(line)]).collect() }
    };
    let [x, y] = [
        axis(&plot.x, finite.iter().map(|p| p.0).collect()),
        axis(&plot.y, finite.iter().map(|p| p.1).collect()),
    ];
    let groups = plot.series.iter().zip(Ink::SERIES.into_iter().cycle()).map(group).collect();
    Chart::new(title, Panel::new(x, y, groups, PLOT))
}

/// A value on an axis in words.
fn told(axis: &PlotAxis, value: f64) -> String {
    match &axis.scale {
        AxisScale::Logarithmic => format!("{} {}", axis.title, short_number(value)),
        AxisScale::Names(names) => names.get(value.round() as usize).cloned().unwrap_or_default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(y: AxisScale, points: Vec<(f64, f64)>) -> StudyPlot {
        let series = PlotSeries { name: "a < b".into(), line: points.clone(), dots: points };
        let x = PlotAxis { title: "touches", scale: AxisScale::Logarithmic };
        StudyPlot { x, y: PlotAxis { title: "error, mm", scale: y }, series: vec![series] }
    }

    #[test]
    fn names_stand_at_their_numbers() {
        let names = AxisScale::Names(vec!["first".into(), "second".into()]);
        let svg = study_chart(&plot(names, vec![(100.0, 0.0), (200.0, 1.0)]), "title").alone();
        assert!(svg.contains("<title>a &lt; b: touches 200, second</title>"), "{svg}");
    }
}
