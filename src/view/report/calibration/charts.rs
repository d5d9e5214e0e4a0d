//! Residuals of the touches, drawn.

use std::collections::BTreeMap;

use crate::calibration::{Calibration, Seen};
use crate::named::plural;
use crate::session::name_of;
use crate::view::charts::{Chart, ChartGroup, ChartMark, Ink, Panel, Scale};
use crate::view::figure;
use crate::view::text::short_number as number;

/// Rows at the most.
const MOST_ROWS: usize = 30;
/// Height of a row, and width of all of them, pixels.
const ROW: f64 = 17.0;
const WIDTH: f64 = 560.0;

/// A box for each pair of links that touched; touches that are taken to be false are crosses.
pub(super) fn by_pair(found: &Calibration) -> String {
    let millimetres = |seen: &Seen| 1e3 * seen.apart();
    let mut pairs: BTreeMap<[String; 2], [Vec<&Seen>; 2]> = BTreeMap::new();
    for seen in &found.fit.seen {
        let mut pair =
            found.touches[seen.touch].features(seen.ends).map(|feature| name_of(found.robot, feature));
        pair.sort_unstable();
        let is_false = found.fit.noise.inlier_probability(seen) <= 0.5;
        pairs.entry(pair).or_default()[usize::from(is_false)].push(seen);
    }
    let mut pairs: Vec<_> = pairs.into_iter().collect();
    pairs.sort_by_key(|(_, [honest, wrong])| std::cmp::Reverse(honest.len() + wrong.len()));
    let left_out = pairs.len().saturating_sub(MOST_ROWS);
    pairs.truncate(MOST_ROWS);
    let (mut boxes, mut crosses, mut names) = (Vec::new(), Vec::new(), Vec::new());
    for (k, ([a, b], [honest, wrong])) in pairs.iter().enumerate() {
        let about = format!("{a}, {b}, {}", plural(honest.len(), "touch"));
        let values = quartiles(honest.iter().map(|touch| millimetres(touch)));
        boxes.extend(values.into_iter().flat_map(|values| box_marks(k, &about, values)));
        crosses.extend(wrong.iter().map(|touch| {
            let (line, apart) = (found.touches[touch.touch].line, millimetres(touch));
            let says =
                format!("line {line}: {a} and {b} are {} mm apart (classified as false)", number(apart));
            ChartMark::Dot { at: [apart, k as f64], radius: 3.0, cross: true, says }
        }));
        names.push(format!("{a}, {b}"));
    }
    if names.is_empty() {
        return "<p class=\"note\">No touches.</p>\n".into();
    }
    let mut groups = vec![ChartGroup::new("", Ink::Blue, boxes)];
    groups
        .extend((!crosses.is_empty()).then(|| ChartGroup::new("classified as false", Ink::Orange, crosses)));
    let plot = [WIDTH, ROW * names.len() as f64];
    let across = ("apart, mm", Scale::logarithmic_of(&groups, 0));
    let panel = Panel::new(across, ("", Scale::Names(names)), groups, plot);
    let mut caption = String::from(
        "Per pair of links, most touches first. Boxes show the middle half, whiskers the range.",
    );
    if left_out > 0 {
        caption += &format!(" {left_out} more pairs are not drawn.");
    }
    figure("by-pair", &Chart::new("Residuals by pair of links", panel), &caption)
}

/// The least, the three quartiles and the greatest of values that are finite; `None` if there is none.
fn quartiles(values: impl IntoIterator<Item = f64>) -> Option<[f64; 5]> {
    let mut values: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    Some([0.0, 0.25, 0.5, 0.75, 1.0].map(|share| values[(share * last as f64).round() as usize]))
}

/// A row's box and whiskers.
fn box_marks(row: usize, name: &str, [least, low, middle, high, greatest]: [f64; 5]) -> [ChartMark; 3] {
    let row = row as f64;
    let [a, b, c, d, e] = [middle, low, high, least, greatest].map(number);
    let says = format!("{name}: median {a} mm, middle half {b} to {c} mm, range {d} to {e} mm");
    let (from, to) = ([low, row - 0.32], [high, row + 0.32]);
    [
        ChartMark::line(vec![[least, row], [greatest, row]], "", 1.0),
        ChartMark::Cell { from, to, opacity: 0.5, text: String::new(), says },
        ChartMark::line(vec![[middle, row - 0.32], [middle, row + 0.32]], "", 2.2),
    ]
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
