//! The reachable workspace: three slices through the chest, with near and far voxels and the limbs.

use super::ReportInput;
use crate::session::{SpaceRecord, SpaceSlice};
use crate::view::charts::{Chart, ChartGroup, ChartMark, Ink, Panel, Scale};
use crate::view::figure;
use crate::view::text::{escape, plain, short_number as number};

/// Width of all slices together, pixels.
const WIDTH: f64 = 780.0;
/// Room about what is drawn of a slice, metres.
const MARGIN: f64 = 0.05;
const NAMES: [&str; 3] = ["x", "y", "z"];
/// How far a voxel is away, by its digit counted from 1: its colour, and what it is called.
const LEVELS: [(Ink, &str); 4] =
    [(Ink::Sand, "far"), (Ink::Ochre, "far, for more"), (Ink::Sky, "near"), (Ink::Blue, "near, for more")];

/// The picture; a sentence that says how to get one where there is no map yet.
pub(super) fn figure_of(input: &ReportInput) -> String {
    let Some(space) = input.space.filter(|space| !space.slices.is_empty()) else {
        return "<p class=\"note\">No map yet: <code>bodyschema reach SESSION</code> computes it, then <code>bodyschema report SESSION</code> shows it here.</p>\n"
            .into();
    };
    let litres = space.hands.iter().zip(&space.litres).map(|(hand, [near, far])| {
        format!("{}: {} litres near, {} litres far", escape(hand), number(*near), number(*far))
    });
    let caption = format!(
        "Workspace of {} according to the learned schema, in the frame of {}: near with the arm alone, far when \
         leaning{}. Lines are limbs in the rest posture. {}.{}",
        escape(&space.hands.join(" and ")),
        escape(&space.chest),
        if space.hands.len() > 1 { ", for one hand or several" } else { "" },
        litres.collect::<Vec<_>>().join("; "),
        space.doubts.iter().map(|doubt| format!(" <b>{}.</b>", escape(doubt))).collect::<String>()
    );
    figure("reachable", &chart(space), &caption)
}

/// The slices as a chart, all at one scale.
fn chart(space: &SpaceRecord) -> Chart {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for slice in &space.slices {
        for (k, &axis) in slice.axes.iter().enumerate() {
            let [from, to] = extent(slice, space.voxel, k);
            (low[axis], high[axis]) = (low[axis].min(from), high[axis].max(to));
        }
    }
    let span = |axis: usize| high[axis] - low[axis];
    let widths: f64 = space.slices.iter().map(|slice| span(slice.axes[0])).sum();
    let panel = |(n, slice): (usize, &SpaceSlice)| {
        let [a, b] = slice.axes;
        // From above, the body faces up the page, and its left is to the left.
        let turned = a == 1 && b == 0;
        let across = if turned { Scale::Linear(high[a], low[a]) } else { Scale::Linear(low[a], high[a]) };
        let at = plain((1e2 * slice.at).round() / 1e2);
        let title = |axis: usize| format!("{}, m", NAMES[axis]);
        Panel {
            title: format!("{}, {} = {at} m", slice.name, NAMES[3 - a - b]),
            x: (title(a), across),
            y: (title(b), Scale::Linear(low[b], high[b])),
            // One legend is enough for all.
            groups: groups(slice, space.voxel, space.hands.len() > 1, n == 0),
            plot: [span(a), span(b)].map(|metres| WIDTH * metres / widths),
        }
    };
    Chart {
        says: "Slices of the reachable map".into(),
        panels: space.slices.iter().enumerate().map(panel).collect(),
    }
}

/// The least and greatest coordinate of a slice along its first or second axis, metres.
fn extent(slice: &SpaceSlice, voxel: f64, k: usize) -> [f64; 2] {
    let count = if k == 0 { slice.rows.iter().map(String::len).max().unwrap_or(0) } else { slice.rows.len() };
    let from = slice.first[k] - 0.5 * voxel;
    let places = slice.outlines.iter().flatten().map(|point| point[k]);
    let (low, high) =
        places.fold((from, from + voxel * count as f64), |(low, high), x| (low.min(x), high.max(x)));
    [low - MARGIN, high + MARGIN]
}

/// The voxels of a slice by how far they are away, run by run, and the limbs.
fn groups(slice: &SpaceSlice, voxel: f64, several: bool, named: bool) -> Vec<ChartGroup> {
    let shown = LEVELS.iter().enumerate().filter(|(k, _)| several || k % 2 == 0);
    let mut groups: Vec<ChartGroup> = shown
        .map(|(k, (ink, name))| {
            let digit = b'1' + k as u8;
            let rows = slice.rows.iter().enumerate();
            let marks = rows.flat_map(|(v, row)| {
                runs(row).filter(move |(found, _)| *found == digit).map(move |(_, [begin, end])| {
                    let corner = |u: usize, v: usize| {
                        [slice.first[0] + voxel * (u as f64 - 0.5), slice.first[1] + voxel * (v as f64 - 0.5)]
                    };
                    let (from, to) = (corner(begin, v), corner(end, v + 1));
                    let [a, b] = slice.axes.map(|axis| NAMES[axis]);
                    let says = format!(
                        "{name}: {a} from {:.2} to {:.2} m, {b} from {:.2} to {:.2} m",
                        from[0], to[0], from[1], to[1]
                    );
                    ChartMark::Cell { from, to, opacity: 1.0, text: String::new(), says }
                })
            });
            let name = if named { name.to_string() } else { String::new() };
            ChartGroup::new(&name, *ink, marks.collect())
        })
        .collect();
    let outlines = slice.outlines.iter().map(|points| ChartMark::line(points.clone(), "", 1.0));
    groups.push(ChartGroup::new("", Ink::Letters, outlines.collect()));
    groups
}

/// The runs of equal digits in a row: the digit, where the run begins, and where the next one does.
fn runs(row: &str) -> impl Iterator<Item = (u8, [usize; 2])> {
    let mut end = 0;
    row.as_bytes().chunk_by(|a, b| a == b).map(move |run| {
        let begin = end;
        end += run.len();
        (run[0], [begin, end])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_told_run_by_run() {
        let found: Vec<_> = runs("0113301").filter(|(digit, _)| *digit == b'1').collect();
        assert_eq!(found, [(b'1', [1, 3]), (b'1', [6, 7])]);
        assert_eq!(runs("000").count(), 1);
    }
}
