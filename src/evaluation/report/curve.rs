//! The learning curve: the error as touches come in, both on logarithmic scales.

use plotters::prelude::*;

use super::text::power_of_ten;

/// Size of the drawing, pixels.
const SIZE: (u32, u32) = (820, 320);
/// Colours of the curve, the grid and the text.
const CURVE: RGBColor = RGBColor(47, 102, 144);
const GRID: RGBColor = RGBColor(226, 229, 233);
const TEXT: RGBColor = RGBColor(82, 96, 109);
/// Errors below this are drawn as this, millimetres: rounding, not learning.
const LEAST_ERROR: f64 = 1e-12;
/// Slack for powers of ten that are not exact.
const ROUNDING: f64 = 1e-9;

/// The curve as a figure; a sentence where there are not two points to join.
pub(super) fn figure(rows: &[(usize, f64)]) -> String {
    let drawable = |&&(touches, error): &&(usize, f64)| touches > 0 && error.is_finite() && error >= 0.0;
    let points: Vec<(f64, f64)> =
        rows.iter().filter(drawable).map(|&(n, error)| (n as f64, error.max(LEAST_ERROR))).collect();
    match draw(&points) {
        Some(svg) => format!(
            "<figure>\n{svg}\n<figcaption>Mean held-out error after each checkpoint of \
             learning.</figcaption>\n</figure>\n"
        ),
        None => "<p class=\"note\">Too few checkpoints for a curve.</p>\n".into(),
    }
}

fn draw(points: &[(f64, f64)]) -> Option<String> {
    let bounds = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::INFINITY, 0.0f64), |(low, high), x| (low.min(x), high.max(x)))
    };
    let (first, last) = bounds(&mut points.iter().map(|p| p.0));
    let (least, greatest) = bounds(&mut points.iter().map(|p| p.1));
    if points.len() < 2 || first >= last {
        return None;
    }
    let bottom = least.log10().floor() as i32;
    let top = (greatest.log10().ceil() as i32).max(bottom + 1);
    let mut svg = String::new();
    chart(points, first..last, bottom..top, &mut svg).ok()?;
    Some(svg)
}

/// Draws the points between powers of ten of the error.
fn chart(
    points: &[(f64, f64)],
    touches: std::ops::Range<f64>,
    decades: std::ops::Range<i32>,
    svg: &mut String,
) -> Result<(), Box<dyn std::error::Error>> {
    let font = |size: u32| ("sans-serif", size).into_font().color(&TEXT);
    let area = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    let errors = 10f64.powi(decades.start)..10f64.powi(decades.end);
    let wider = touches.start / 1.15..touches.end * 1.15;
    let (x_ticks, y_ticks) = (ticks(&wider), ticks(&errors));
    let mut chart =
        ChartBuilder::on(&area).margin(8).x_label_area_size(44).y_label_area_size(64).build_cartesian_2d(
            wider.log_scale().with_key_points(x_ticks),
            errors.log_scale().with_key_points(y_ticks),
        )?;
    chart
        .configure_mesh()
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .axis_style(GRID)
        .x_desc("touches")
        .y_desc("error, mm")
        .axis_desc_style(font(13))
        .label_style(font(12))
        .x_label_formatter(&|touches| format!("{touches:.0}"))
        .y_label_formatter(&|error| tick_label(*error))
        .draw()?;
    chart.draw_series(LineSeries::new(points.iter().copied(), CURVE.stroke_width(2)))?;
    chart.draw_series(points.iter().map(|&point| Circle::new(point, 3, CURVE.filled())))?;
    area.present()?;
    Ok(())
}

/// Where to label a logarithmic axis: at powers of ten, and with room also at 2 and 5 times them.
pub(crate) fn ticks(range: &std::ops::Range<f64>) -> Vec<f64> {
    let (first, last) = (range.start.log10().floor() as i32, range.end.log10().ceil() as i32);
    let span = (range.end / range.start).log10();
    let multiples: &[f64] = if span <= 3.1 { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let step = (span / 8.0).ceil().max(1.0) as usize;
    (first..=last)
        .step_by(step)
        .flat_map(|decade| multiples.iter().map(move |multiple| multiple * 10f64.powi(decade)))
        .filter(|tick| (range.start * (1.0 - ROUNDING)..=range.end * (1.0 + ROUNDING)).contains(tick))
        .collect()
}

/// A label of a logarithmic axis: a plain number, or a power of ten where that is shorter.
pub(crate) fn tick_label(error: f64) -> String {
    let exponent = (error.log10() + ROUNDING).floor() as i32;
    match exponent {
        -3..=3 => format!("{error:.digits$}", digits = (-exponent).max(0) as usize),
        _ => {
            let multiple = (error / 10f64.powi(exponent)).round();
            let power = power_of_ten(exponent);
            if multiple == 1.0 { power } else { format!("{multiple}·{power}") }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_fill_short_axes_and_thin_out_on_long_ones() {
        assert_eq!(ticks(&(20.0..600.0)), [20.0, 50.0, 100.0, 200.0, 500.0]);
        assert!((2..=9).contains(&ticks(&(1e-12..1e3)).len()));
        assert_eq!([0.02, 1.0, 500.0, 1e-9, 2e-6].map(tick_label), ["0.02", "1", "500", "10⁻⁹", "2·10⁻⁶"]);
    }

    #[test]
    fn a_curve_needs_two_points() {
        assert!(!figure(&[(10, 1.0)]).contains("<svg"));
        assert!(!figure(&[(10, 1.0), (20, f64::NAN)]).contains("<svg"));
        assert!(figure(&[(10, 1.0), (20, 0.0)]).contains("<svg"));
    }
}
