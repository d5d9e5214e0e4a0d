//! Maps as a picture: three slices through the chest, with the body at ease.

use nalgebra::Vector3;
use plotters::prelude::*;

use super::vtk::about;
use crate::peripersonal::{Lattice, Level, OwnBody, ReachableMap};

/// Near and far, by how many hands get there: one, or more.
const NEAR: [RGBColor; 2] = [RGBColor(86, 180, 233), RGBColor(0, 114, 178)];
const FAR: [RGBColor; 2] = [RGBColor(250, 224, 170), RGBColor(240, 190, 90)];
const LIMB: RGBColor = RGBColor(20, 24, 28);
const GRID: RGBColor = RGBColor(226, 229, 233);
const TEXT: RGBColor = RGBColor(82, 96, 109);
/// A metre, pixels.
const SCALE: f64 = 220.0;
/// Room about a slice: to the left, above, between and below, pixels.
const ROOM: (f64, f64, f64, f64) = (56.0, 64.0, 64.0, 76.0);

/// Room about what is drawn of a slice, metres.
const MARGIN: f64 = 0.05;

/// A slice: its name, the axes to the right and upwards with what they are called, and the axis across it.
pub(super) struct Slice {
    pub name: &'static str,
    pub axes: [usize; 2],
    pub across: usize,
}

/// Axes as MJCF has them for a body that stands: x ahead, y to the left, z up.
pub(super) const SLICES: [Slice; 3] = [
    Slice { name: "from above", axes: [1, 0], across: 2 },
    Slice { name: "from the side", axes: [0, 2], across: 1 },
    Slice { name: "from the front", axes: [1, 2], across: 0 },
];
const NAMES: [&str; 3] = ["x", "y", "z"];

/// Where the slices cross: the middle of what is near to any hand.
pub(super) fn crossing(maps: &[ReachableMap]) -> Vector3<f64> {
    let mut middle = Vector3::zeros();
    let mut count = 0.0;
    for map in maps {
        for (cell, _) in map.voxels().filter(|(_, level)| *level == Level::Near) {
            middle += map.lattice().middle(cell);
            count += 1.0;
        }
    }
    if count == 0.0 { Vector3::zeros() } else { middle / count }
}

/// The voxels of one slice, run by run along the first axis: first voxel, length, and colour.
fn runs(maps: &[ReachableMap], lattice: &Lattice, slice: &Slice, at: i32) -> Vec<([i32; 2], i32, RGBColor)> {
    let [a, b] = slice.axes;
    let colour = |cell: [i32; 3]| {
        let levels = || maps.iter().map(|map| map.level_of(cell));
        let near = levels().filter(|level| *level == Level::Near).count();
        let any = levels().filter(|level| *level != Level::OutOfReach).count();
        match (near, any) {
            (0, 0) => None,
            (0, any) => Some(FAR[usize::from(any > 1)]),
            (near, _) => Some(NEAR[usize::from(near > 1)]),
        }
    };
    let mut runs: Vec<([i32; 2], i32, RGBColor)> = Vec::new();
    for v in 0..lattice.counts[b] as i32 {
        for u in 0..lattice.counts[a] as i32 {
            let mut cell = [at; 3];
            (cell[a], cell[b]) = (lattice.first[a] + u, lattice.first[b] + v);
            let Some(colour) = colour(cell) else { continue };
            match runs.last_mut() {
                Some(([u0, v0], length, before))
                    if *v0 == cell[b] && *u0 + *length == cell[a] && *before == colour =>
                {
                    *length += 1;
                }
                _ => runs.push(([cell[a], cell[b]], 1, colour)),
            }
        }
    }
    runs
}

/// Points of the outline of a limb's pieces, seen along an axis, in the map's frame.
pub(super) fn outlines(own: &OwnBody, map: &ReachableMap, slice: &Slice) -> Vec<Vec<Vector3<f64>>> {
    let frames = own.frames(&own.at_ease());
    let to_map = map.frame.inverse();
    let [a, b] = slice.axes;
    let outline = |surface: &crate::skin::Surface| {
        let pose = to_map * frames[surface.limb];
        let around = (0..=48).map(|k| std::f64::consts::TAU * f64::from(k) / 48.0);
        let directions = around.map(|angle| {
            let mut direction = Vector3::zeros();
            (direction[a], direction[b]) = (angle.cos(), angle.sin());
            pose.rotation.tr_mul(&direction)
        });
        directions.filter_map(|direction| Some(pose.point(&surface.support(&direction)?))).collect()
    };
    own.skin.surfaces.iter().map(outline).filter(|points: &Vec<_>| !points.is_empty()).collect()
}

/// The three slices as a drawing.
///
/// # Errors
/// Where the drawing library fails.
pub fn svg(own: &OwnBody, maps: &[ReachableMap]) -> Result<String, Box<dyn std::error::Error>> {
    let mut svg = String::new();
    let Some(first) = maps.first() else { return Ok(svg) };
    let lattice = about(maps);
    let half = lattice.half();
    let at = lattice.cell(&crossing(maps));
    // The box about the voxels and the limbs.
    let last = Vector3::from(lattice.counts.map(|count| count.saturating_sub(1) as f64)) * lattice.voxel;
    let (mut low, mut high) = (lattice.middle(lattice.first), lattice.middle(lattice.first) + last);
    for point in SLICES.iter().flat_map(|slice| outlines(own, first, slice)).flatten() {
        (low, high) = (low.inf(&point), high.sup(&point));
    }
    let low = low.add_scalar(-half - MARGIN);
    let size = (high - low).add_scalar(half + MARGIN);
    let (left, top, between, below) = ROOM;
    let pixels = |metres: f64| metres * SCALE;
    let width: f64 = SLICES.iter().map(|slice| pixels(size[slice.axes[0]]) + between).sum::<f64>() + left;
    let height = SLICES.iter().map(|slice| pixels(size[slice.axes[1]])).fold(0.0, f64::max) + top + below;
    {
        let area = SVGBackend::with_string(&mut svg, (width as u32, height as u32)).into_drawing_area();
        area.fill(&WHITE)?;
        let text = |size: u32| ("sans-serif", size).into_font().color(&TEXT);
        let hands: Vec<&str> = maps.iter().map(|map| own.creature.limbs()[map.hand].as_str()).collect();
        let title = format!(
            "{}: where {} can get to, in the frame of {}",
            own.creature.name(),
            hands.join(" and "),
            own.creature.limbs()[first.chest]
        );
        area.draw(&Text::new(title, (left as i32, 14), text(15)))?;
        let mut begin = left;
        for slice in &SLICES {
            let [a, b] = slice.axes;
            let (from, to) = (begin, begin + pixels(size[a]));
            let bottom = top + pixels(size[b]);
            // From above, the body faces up the page, and its left is to the left.
            let mirrored = slice.across == 2;
            let place = |u: f64, v: f64| {
                let along = if mirrored { low[a] + size[a] - u } else { u - low[a] };
                ((from + pixels(along)).round() as i32, (bottom - pixels(v - low[b])).round() as i32)
            };
            for (cell, length, colour) in runs(maps, &lattice, slice, at[slice.across]) {
                let [u, v] = cell.map(|x| f64::from(x) * lattice.voxel - half);
                let corners = [place(u, v), place(u + f64::from(length) * lattice.voxel, v + lattice.voxel)];
                area.draw(&Rectangle::new(corners, colour.filled()))?;
            }
            let ticks = |k: usize| {
                let [first, last] = [low[k] / 0.5, (low[k] + size[k]) / 0.5];
                (first.ceil() as i32..=last.floor() as i32).map(|tick| 0.5 * f64::from(tick))
            };
            for tick in ticks(a) {
                let [p, q] = [place(tick, low[b]), place(tick, low[b] + size[b])];
                area.draw(&PathElement::new([p, q], GRID.mix(0.7)))?;
                area.draw(&Text::new(format!("{tick:.1}"), (p.0 - 9, p.1 + 6), text(12)))?;
            }
            for tick in ticks(b) {
                let [p, q] = [place(low[a], tick), place(low[a] + size[a], tick)];
                area.draw(&PathElement::new([p, q], GRID.mix(0.7)))?;
                let x = p.0.min(q.0);
                area.draw(&Text::new(format!("{tick:>4.1}"), (x - 28, p.1 - 6), text(12)))?;
            }
            for outline in outlines(own, first, slice) {
                let points: Vec<(i32, i32)> = outline.iter().map(|p| place(p[a], p[b])).collect();
                area.draw(&PathElement::new(points, LIMB.mix(0.8)))?;
            }
            let across = f64::from(at[slice.across]) * lattice.voxel;
            let caption = format!("{}, {} = {across:.2} m", slice.name, NAMES[slice.across]);
            area.draw(&Text::new(caption, (from as i32, (top - 20.0) as i32), text(13)))?;
            let axes = format!(
                "{} to the {}, {} upwards, m",
                NAMES[a],
                if mirrored { "left" } else { "right" },
                NAMES[b]
            );
            area.draw(&Text::new(axes, (from as i32, (bottom + 22.0) as i32), text(12)))?;
            begin = to + between;
        }
        let legend: &[(&str, RGBColor)] = &[
            ("near: by the arm alone", NEAR[0]),
            ("near for both", NEAR[1]),
            ("far: by leaning", FAR[0]),
            ("far, for both", FAR[1]),
        ];
        let shown = legend.iter().enumerate().filter(|(k, _)| maps.len() > 1 || k % 2 == 0);
        let y = height as i32 - 22;
        for (n, (_, (name, colour))) in shown.enumerate() {
            let x = left as i32 + 180 * n as i32;
            area.draw(&Rectangle::new([(x, y), (x + 12, y + 12)], colour.filled()))?;
            area.draw(&Text::new(*name, (x + 18, y), text(12)))?;
        }
        area.present()?;
    }
    Ok(svg)
}
