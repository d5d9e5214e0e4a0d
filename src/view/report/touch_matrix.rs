//! How often each pair of limbs touched.

use super::ReportInput;
use crate::agent::Agent;
use crate::senses::Touch;
use crate::view::charts::{Chart, ChartGroup, ChartMark, Ink, Panel, Ruler, Scale};
use crate::view::figure;
use crate::view::text::touches;

/// A matrix of at most so many limbs has room for its counts.
const ROOM: usize = 24;
/// Least shade of a pair that touched.
const LIGHTEST: f64 = 0.14;

/// The lower half of the matrix of aura limbs × aura limbs.
pub(super) fn figure_of(input: &ReportInput) -> String {
    let names: Vec<String> =
        input.agent.creature().aura_limbs().iter().map(|aura| aura.name.replace('_', " ")).collect();
    let counts = counts(input.agent, input.touches);
    let most = counts.iter().flatten().copied().max().unwrap_or(0);
    if most == 0 {
        return "<p class=\"note\">No touch between named limbs.</p>\n".into();
    }
    let n = names.len();
    let shade = |count: usize| LIGHTEST + (1.0 - LIGHTEST) * (count as f64).ln_1p() / (most as f64).ln_1p();
    let mut marks = Vec::new();
    for (i, row) in counts.iter().enumerate() {
        for (j, &count) in row.iter().enumerate().filter(|(_, count)| **count > 0) {
            let (x, y) = (j as f64, i as f64);
            marks.push(ChartMark::Cell {
                from: [x - 0.47, y - 0.47],
                to: [x + 0.47, y + 0.47],
                opacity: shade(count),
                text: if n <= ROOM { count.to_string() } else { String::new() },
                says: format!("{}, {}: {}", names[i], names[j], touches(count)),
            });
        }
    }
    let ruler = || Ruler { title: String::new(), scale: Scale::Names(names.clone()) };
    let side = (27.0 * n as f64).clamp(160.0, 620.0);
    let panel = Panel {
        title: String::new(),
        x: ruler(),
        y: ruler(),
        groups: vec![ChartGroup { name: String::new(), ink: Ink::Blue, marks }],
        plot: [1.15 * side, side],
    };
    let caption = "Touches per pair of limbs: the stronger the colour, the more (logarithmic). Empty: never touched each other.";
    figure("touch-matrix", &Chart::new("Touches per pair of limbs", panel), caption)
}

/// Touches per pair of aura limbs, the later limb first.
fn counts(agent: &Agent, touches: &[Touch]) -> Vec<Vec<usize>> {
    let (creature, skin) = (agent.creature(), agent.skin());
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
