//! Residuals of the touches, drawn.

use std::collections::BTreeMap;

use super::{CalibrationReport, ReportedTouch};
use crate::view::charts::{Chart, ChartGroup, ChartMark, Ink, Panel, Scale};
use crate::view::figure;
use crate::view::report::joint_errors::{box_marks, quartiles};
use crate::view::text::{short_number as number, touches as count_of};

/// Rows of a chart at the most.
const MOST_ROWS: usize = 30;
/// Height of a row and width of a chart of rows, pixels.
const ROW: f64 = 17.0;
const WIDTH: f64 = 560.0;

fn says(touch: &ReportedTouch) -> String {
    let [a, b] = &touch.between;
    let what = if touch.is_false() { ", taken to be false" } else { "" };
    format!("line {}: {a} and {b} are {} mm apart{what}", touch.line, number(touch.millimetres()))
}

/// A box for each pair of links that touched.
pub(super) fn by_pair(report: &CalibrationReport) -> String {
    let mut pairs: BTreeMap<[&str; 2], Vec<&ReportedTouch>> = BTreeMap::new();
    for touch in &report.touches {
        let mut pair = touch.between.each_ref().map(String::as_str);
        pair.sort_unstable();
        pairs.entry(pair).or_default().push(touch);
    }
    let mut pairs: Vec<_> = pairs.into_iter().collect();
    pairs.sort_by_key(|(_, touches)| std::cmp::Reverse(touches.len()));
    let count = pairs.len();
    pairs.truncate(MOST_ROWS);
    let (mut boxes, mut crosses, mut names) = (Vec::new(), Vec::new(), Vec::new());
    for (k, ([a, b], touches)) in pairs.iter().enumerate() {
        let name = format!("{a}, {b}");
        let honest: Vec<f64> =
            touches.iter().filter(|touch| !touch.is_false()).map(|touch| touch.millimetres()).collect();
        let about = format!("{name}, {}", count_of(honest.len()));
        boxes.extend(quartiles(honest).into_iter().flat_map(|values| box_marks(k, &about, values)));
        let wrong = touches.iter().filter(|touch| touch.is_false());
        crosses.extend(wrong.map(|touch| ChartMark::Dot {
            at: [touch.millimetres(), k as f64],
            radius: 3.0,
            cross: true,
            says: says(touch),
        }));
        names.push(name);
    }
    if boxes.is_empty() && crosses.is_empty() {
        return "<p class=\"note\">There is no touch to look at.</p>\n".into();
    }
    let scale = Scale::logarithmic(report.touches.iter().map(ReportedTouch::millimetres));
    let mut groups = vec![ChartGroup::new("", Ink::Blue, boxes)];
    if !crosses.is_empty() {
        groups.push(ChartGroup::new("taken to be false", Ink::Orange, crosses));
    }
    let plot = [WIDTH, ROW * names.len() as f64];
    let panel = Panel::new(("apart, mm", scale), ("", Scale::Names(names)), groups, plot);
    let mut caption = String::from(
        "Per pair of links, most touches first: the middle half in the box, all within the whiskers.",
    );
    if count > MOST_ROWS {
        caption += &format!(" {} more pairs are not drawn.", count - MOST_ROWS);
    }
    figure("by-pair", &Chart::new("Residuals by pair of links", panel), &caption)
}
