//! How often each pair of limbs touched.

use plotly::common::{ColorBar, ColorScale, ColorScaleElement, Font, HoverInfo, Title};
use plotly::layout::{Annotation, Axis, Margin};
use plotly::{HeatMap, Layout, Trace};

use super::ReportInput;
use super::picture::figure;
use super::text::{escape, plural};
use crate::creature::Creature;
use crate::senses::Touch;
use crate::skin::Skin;

/// A matrix of at most so many limbs has room for its counts.
const ROOM: usize = 24;

/// The lower half of the matrix of aura limbs × aura limbs.
pub(super) fn figure_of(input: &ReportInput) -> String {
    let label = |name: &str| escape(&name.replace('_', " "));
    let names: Vec<String> = input.creature.aura_limbs().iter().map(|aura| label(&aura.name)).collect();
    let counts = counts(input.creature, input.skin, input.touches);
    let most = counts.iter().flatten().copied().max().unwrap_or(0);
    if most == 0 {
        return "<p class=\"note\">No touch between named limbs.</p>\n".into();
    }
    let n = names.len();
    let places: Vec<f64> = (0..n).map(|k| k as f64).collect();
    let shade = |count: usize| (count > 0).then(|| (count as f64).ln_1p());
    let cells: Vec<Vec<Option<f64>>> =
        (0..n).map(|i| (0..n).map(|j| if j <= i { shade(counts[i][j]) } else { None }).collect()).collect();
    let hover: Vec<Vec<String>> = (0..n)
        .map(|i| (0..n).map(|j| format!("{}, {}: {}", names[i], names[j], touches(counts[i][j]))).collect())
        .collect();
    let ticks: Vec<usize> =
        [1, 3, 10, 30, 100, 300, 1000, 3000, 10_000, 100_000].into_iter().filter(|n| *n <= most).collect();
    let scale = [(0.0, "#d3e5f1"), (0.5, "#4f9bcb"), (1.0, "#0a3d66")];
    let scale = scale.map(|(at, colour)| ColorScaleElement(at, colour.to_string()));
    let map = HeatMap::new(places.clone(), places.clone(), cells)
        .color_scale(ColorScale::Vector(scale.to_vec()))
        .zmin(0.0)
        .zmax(shade(most).unwrap_or(1.0))
        .hover_on_gaps(false)
        .hover_text_matrix(hover)
        .hover_info(HoverInfo::Text)
        .color_bar(
            ColorBar::new()
                .title(Title::with_text("touches"))
                .thickness(14)
                .tick_vals(ticks.iter().filter_map(|n| shade(*n)).collect())
                .tick_text(ticks.iter().map(usize::to_string).collect::<Vec<_>>()),
        );
    // A cell is wide enough for its count where there are few limbs.
    let mut notes = Vec::new();
    for (i, row) in counts.iter().enumerate().filter(|_| n <= ROOM) {
        for (j, &count) in row.iter().enumerate().filter(|(_, count)| **count > 0) {
            let dark = (count as f64).ln_1p() > 0.45 * (most as f64).ln_1p();
            let ink = if dark { "#ffffff" } else { "#14202b" };
            notes.push(
                Annotation::new()
                    .x(j as f64)
                    .y(i as f64)
                    .text(count.to_string())
                    .show_arrow(false)
                    .font(Font::new().size(11).color(ink)),
            );
        }
    }
    let axis = || {
        Axis::new()
            .tick_values(places.clone())
            .tick_text(names.clone())
            .show_grid(false)
            .zero_line(false)
            .auto_margin(true)
    };
    let end = n as f64 - 0.5;
    let layout = Layout::new()
        .annotations(notes)
        .margin(Margin::new().left(16).right(16).top(12).bottom(16))
        .x_axis(axis().tick_angle(-45.0).range(vec![-0.5, end]))
        .y_axis(axis().range(vec![end, -0.5]));
    let height = (26 * n + 150).clamp(300, 900);
    let traces: Vec<Box<dyn Trace>> = vec![map];
    let caption =
        "Touches per pair of limbs, darker for more (logarithmic). Empty: never touched each other.";
    figure("touch-matrix", "Touches per pair of limbs", height, traces, layout, caption)
}

/// Touches per pair of aura limbs, the later limb first.
fn counts(creature: &Creature, skin: &Skin, touches: &[Touch]) -> Vec<Vec<usize>> {
    let number = creature.aura_limbs().len();
    let mut counts = vec![vec![0; number]; number];
    for touch in touches {
        let [a, b] = touch.ends.map(|end| creature.aura_of(skin.receptors[end.receptor].limb));
        if let Some((a, b)) = a.zip(b) {
            counts[a.max(b)][a.min(b)] += 1;
        }
    }
    counts
}

fn touches(count: usize) -> String {
    if count == 1 { "1 touch".into() } else { plural(count, "touche") }
}
