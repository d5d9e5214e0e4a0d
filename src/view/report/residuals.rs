//! Contact residuals under the learned schema.

use super::ReportInput;
use crate::evaluation::Summary;
use crate::view::charts::{Chart, ChartGroup, ChartMark, Ink, Panel, Scale};
use crate::view::figure;
use crate::view::text::{short_number as number, touches};

/// Bars of the histogram.
const BARS: usize = 60;
/// Residuals this many times beyond the bulk are counted, not drawn: they would squeeze all others into one bar.
const FAR: f64 = 6.0;

/// The picture; a sentence where there was no touch.
pub(super) fn figure_of(input: &ReportInput) -> String {
    let residuals = input.residuals;
    let all: Vec<f64> = residuals.values.iter().map(|(_, value)| *value).filter(|v| v.is_finite()).collect();
    if all.is_empty() {
        return "<p class=\"note\">No touches.</p>\n".into();
    }
    let sizes = Summary::of(all.iter().map(|value| value.abs()));
    // Micrometres where millimetres would have many zeros.
    let (scale, unit) = if sizes.p95 < 0.05 { (1e3, "µm") } else { (1.0, "mm") };
    let limit = FAR * sizes.p95;
    let count = all.len();
    let drawn: Vec<f64> =
        all.into_iter().filter(|value| value.abs() <= limit).map(|value| scale * value).collect();
    let beyond = count - drawn.len();
    let what =
        if residuals.gaps { "gap between the two surfaces" } else { "distance between the two points" };
    let bars = histogram(&drawn);
    let cell = |&([from, to], count): &([f64; 2], usize)| {
        let says = format!("{} from {} to {} {unit}", touches(count), number(from), number(to));
        let (from, to) = ([from, 0.0], [to, count as f64]);
        ChartMark::Cell { from, to, opacity: 1.0, text: String::new(), says }
    };
    let marks = bars.iter().filter(|(_, count)| *count > 0).map(cell).collect();
    let (first, last) = (bars[0].0[0], bars[bars.len() - 1].0[1]);
    let room = 0.02 * (last - first);
    let x = (format!("{what}, {unit}"), Scale::Linear(first - room, last + room));
    let y = ("touches", Scale::linear(0.0, bars.iter().map(|(_, count)| *count as f64)));
    let groups = vec![ChartGroup::new("", Ink::Blue, marks)];
    let panel = Panel::new((x.0.as_str(), x.1), y, groups, [660.0, 230.0]);
    let [median, p95, most] = [sizes.median, sizes.p95, sizes.max].map(|x| number(scale * x));
    let mut caption = format!(
        "Residuals of all touches under the learned schema: median {median} {unit}, 95th percentile {p95} {unit}, \
         maximum {most} {unit}."
    );
    if residuals.gaps {
        caption.push_str(" Negative values are overlaps.");
    }
    if beyond > 0 {
        caption.push_str(&format!(" {beyond} of {count} lie outside the chart."));
    }
    figure("residuals", &Chart::new("Residuals of the touches", panel), &caption)
}

/// Values counted in bars of one width, of which there is one at least.
fn histogram(values: &[f64]) -> Vec<([f64; 2], usize)> {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // Values that are all alike make one bar.
    let (low, high) =
        if high > low { (low, high) } else { (low.min(0.0), high.max(0.0).max(low.min(0.0) + 1.0)) };
    let width = (high - low) / BARS as f64;
    let mut counts = vec![0; BARS];
    values.iter().for_each(|value| counts[(((value - low) / width) as usize).min(BARS - 1)] += 1);
    let side = |k: usize| low + width * k as f64;
    counts.into_iter().enumerate().map(|(k, count)| ([side(k), side(k + 1)], count)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_counted_once() {
        let bars = histogram(&[-1.0, 0.0, 0.5, 2.0, 2.0]);
        assert_eq!(bars.iter().map(|(_, count)| count).sum::<usize>(), 5);
        assert_eq!((bars[0].1, bars[BARS - 1].1), (1, 2));
        assert_eq!(histogram(&[3.0; 4]).iter().map(|(_, count)| count).sum::<usize>(), 4);
    }
}
