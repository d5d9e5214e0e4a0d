//! Charts of the reachable workspace: three slices through the chest.

use crate::session::{SpaceRecord, SpaceSlice};
use crate::view::charts::{Chart, ChartGroup, ChartMark, Ink, Panel, Scale};
use crate::view::text::plain;

/// Width of all slices together, pixels.
const WIDTH: f64 = 780.0;
/// Room about what is drawn of a slice, metres.
const MARGIN: f64 = 0.05;
const NAMES: [&str; 3] = ["x", "y", "z"];
/// How far a voxel is away, by its digit counted from 1: its colour, and what it is called.
const LEVELS: [(Ink, &str); 4] =
    [(Ink::Sand, "far"), (Ink::Ochre, "far, for more"), (Ink::Sky, "near"), (Ink::Blue, "near, for more")];

/// The slices as a chart, all at one scale.
pub fn chart(space: &SpaceRecord, says: &str) -> Chart {
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
    Chart { says: says.into(), panels: space.slices.iter().enumerate().map(panel).collect() }
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
                runs(row, digit).map(move |[from, length]| {
                    let corner = |u: usize, v: usize| {
                        [slice.first[0] + voxel * (u as f64 - 0.5), slice.first[1] + voxel * (v as f64 - 0.5)]
                    };
                    let (from, to) = (corner(from, v), corner(from + length, v + 1));
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
    let outlines = slice.outlines.iter().map(|points| ChartMark::Line {
        points: points.clone(),
        dashes: "",
        width: 1.0,
    });
    groups.push(ChartGroup::new("", Ink::Letters, outlines.collect()));
    groups
}

/// Where a digit stands in a row: the first of each run of it, and how many.
fn runs(row: &str, digit: u8) -> impl Iterator<Item = [usize; 2]> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for (u, _) in row.bytes().enumerate().filter(|(_, found)| *found == digit) {
        match runs.last_mut() {
            Some([from, length]) if *from + *length == u => *length += 1,
            _ => runs.push([u, 1]),
        }
    }
    runs.into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_told_run_by_run() {
        assert_eq!(runs("0113301", b'1').collect::<Vec<_>>(), [[1, 2], [6, 1]]);
        assert_eq!(runs("000", b'1').count(), 0);
    }
}
