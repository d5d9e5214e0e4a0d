//! Rows of boxes with whiskers: how some millimetres are spread, name by name.

use super::{ChartGroup, ChartMark, Ink, Panel, Scale};
use crate::view::text::short_number as number;

/// Height of a row, and width of all of them, pixels.
const ROW: f64 = 17.0;
const WIDTH: f64 = 560.0;

/// The least, the three quartiles and the greatest of values that are finite; `None` if there is none.
pub fn quartiles(values: impl IntoIterator<Item = f64>) -> Option<[f64; 5]> {
    let mut values: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    Some([0.0, 0.25, 0.5, 0.75, 1.0].map(|share| values[(share * last as f64).round() as usize]))
}

/// A row's box and whiskers.
pub fn box_marks(row: usize, name: &str, [least, low, middle, high, greatest]: [f64; 5]) -> [ChartMark; 3] {
    let row = row as f64;
    let [a, b, c, d, e] = [middle, low, high, least, greatest].map(number);
    let says = format!("{name}: median {a} mm, middle half {b} to {c} mm, range {d} to {e} mm");
    let (from, to) = ([low, row - 0.32], [high, row + 0.32]);
    let line = |points, width| ChartMark::Line { points, dashes: "", width };
    [
        line(vec![[least, row], [greatest, row]], 1.0),
        ChartMark::Cell { from, to, opacity: 0.5, text: String::new(), says },
        line(vec![[middle, row - 0.32], [middle, row + 0.32]], 2.2),
    ]
}

/// Rows under names, on a logarithmic axis that holds all of them; further groups lie over them.
pub fn rows(title: &str, names: Vec<String>, boxes: Vec<ChartMark>, over: Vec<ChartGroup>) -> Panel {
    let mut groups = vec![ChartGroup::new("", Ink::Blue, boxes)];
    groups.extend(over);
    let plot = [WIDTH, ROW * names.len() as f64];
    Panel::new((title, Scale::logarithmic_of(&groups, 0)), ("", Scale::Names(names)), groups, plot)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_split_values_in_four() {
        assert_eq!(quartiles([5.0, 1.0, f64::NAN, 3.0, 2.0, 4.0]), Some([1.0, 2.0, 3.0, 4.0, 5.0]));
        assert_eq!(quartiles([f64::NAN]), None);
    }
}
