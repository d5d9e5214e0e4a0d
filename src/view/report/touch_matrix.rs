//! How often each pair of limbs touched.

use std::collections::BTreeMap;

use super::ReportInput;
use crate::agent::Agent;
use crate::named::{in_words, plural};
use crate::senses::RecordedTouch;
use crate::view::charts::{Chart, ChartGroup, ChartMark, Ink, Panel, Scale};
use crate::view::figure;

/// A matrix of at most so many limbs has room for its counts.
const ROOM: usize = 24;
/// Most limbs of a matrix: of more, those that touched most.
const MOST: usize = 60;
/// Least shade of a pair that touched.
const LIGHTEST: f64 = 0.14;

/// The lower half of the matrix of aura limbs × aura limbs.
pub(super) fn figure_of(input: &ReportInput) -> String {
    let auras = input.session.agent.creature().aura_limbs();
    let counts = counts(&input.session.agent, input.touches);
    let mut of_limbs = vec![0; auras.len()];
    counts.iter().for_each(|(&[a, b], &count)| {
        of_limbs[a] += count;
        of_limbs[b] += if a == b { 0 } else { count };
    });
    let mut limbs: Vec<usize> = (0..auras.len()).collect();
    limbs.sort_by_key(|&limb| std::cmp::Reverse(of_limbs[limb]));
    limbs.truncate(MOST);
    limbs.sort_unstable();
    let names: Vec<String> = limbs.iter().map(|&limb| in_words(&auras[limb].name)).collect();
    let at = |limb: usize| limbs.binary_search(&limb).ok();
    let shown: Vec<([usize; 2], usize)> =
        counts.iter().filter_map(|(&[a, b], &count)| Some(([at(a)?, at(b)?], count))).collect();
    let Some(most) = shown.iter().map(|(_, count)| *count).max() else {
        return "<p class=\"note\">No touches between named limbs.</p>\n".into();
    };
    let n = names.len();
    let shade = |count: usize| LIGHTEST + (1.0 - LIGHTEST) * (count as f64).ln_1p() / (most as f64).ln_1p();
    let mut marks = Vec::new();
    for ([i, j], count) in shown {
        let (x, y) = (j as f64, i as f64);
        marks.push(ChartMark::Cell {
            from: [x - 0.47, y - 0.47],
            to: [x + 0.47, y + 0.47],
            opacity: shade(count),
            text: if n <= ROOM { count.to_string() } else { String::new() },
            says: format!("{}, {}: {}", names[i], names[j], plural(count, "touch")),
        });
    }
    let names = || Scale::Names(names.clone());
    let side = (27.0 * n as f64).clamp(160.0, 620.0);
    let groups = vec![ChartGroup::new("", Ink::Blue, marks)];
    let panel = Panel::new(("", names()), ("", names()), groups, [1.15 * side, side]);
    let left_out = match auras.len() - n {
        0 => String::new(),
        _ => format!(" Shown are the {n} of {} limbs with the most touches.", auras.len()),
    };
    let caption = format!(
        "Number of touches per pair of limbs, on a logarithmic colour scale. Empty: no touch.{left_out}"
    );
    figure("touch-matrix", &Chart::new("Touches per pair of limbs", panel), &caption)
}

/// Touches per pair of aura limbs that touched, the later limb first.
fn counts(agent: &Agent, touches: &[RecordedTouch]) -> BTreeMap<[usize; 2], usize> {
    let (creature, skin) = (agent.creature(), agent.skin());
    let auras: Vec<Option<usize>> = (0..creature.limbs().len()).map(|limb| creature.aura_of(limb)).collect();
    let mut counts = BTreeMap::new();
    for touch in touches {
        let [a, b] = touch.limbs(skin).map(|limb| auras[limb]);
        if let Some((a, b)) = a.zip(b) {
            *counts.entry([a.max(b), a.min(b)]).or_default() += 1;
        }
    }
    counts
}
