//! Residuals of the touches, drawn.

use std::collections::BTreeMap;

use crate::calibration::{Calibration, Seen};
use crate::session::name_of;
use crate::view::charts::{Chart, ChartGroup, ChartMark, Ink, box_marks, quartiles, rows};
use crate::view::figure;
use crate::view::text::{short_number as number, touches as count_of};

/// Rows at the most.
const MOST_ROWS: usize = 30;

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
        let about = format!("{a}, {b}, {}", count_of(honest.len()));
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
    let over = (!crosses.is_empty()).then(|| ChartGroup::new("classified as false", Ink::Orange, crosses));
    let panel = rows("apart, mm", names, boxes, over.into_iter().collect());
    let mut caption = String::from(
        "Per pair of links, most touches first. Boxes show the middle half, whiskers the range.",
    );
    if left_out > 0 {
        caption += &format!(" {left_out} more pairs are not drawn.");
    }
    figure("by-pair", &Chart::new("Residuals by pair of links", panel), &caption)
}
