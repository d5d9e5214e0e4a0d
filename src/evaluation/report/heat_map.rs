//! How often each pair of limbs touched.

use super::text::{escape, plural};
use crate::creature::Creature;
use crate::senses::Touch;
use crate::skin::Skin;

/// Side of all cells together, and the least and greatest side of one, pixels.
const SIDE: f64 = 520.0;
const CELL: [f64; 2] = [12.0, 32.0];
/// A cell at least this wide has room for its count.
const ROOM: f64 = 22.0;
/// Width of a letter of the labels, pixels.
const LETTER: f64 = 6.3;
/// Colours of the fewest and of the most touches.
const PALE: [f64; 3] = [226.0, 236.0, 243.0];
const DEEP: [f64; 3] = [31.0, 78.0, 121.0];

/// The lower half of the matrix of aura limbs × aura limbs.
pub(super) fn figure(creature: &Creature, skin: &Skin, touches: &[Touch]) -> String {
    let names: Vec<&str> = creature.aura_limbs().iter().map(|aura| aura.name.as_str()).collect();
    let counts = counts(creature, skin, touches);
    let most = counts.iter().flatten().copied().max().unwrap_or(0);
    if most == 0 {
        return "<p class=\"note\">No touch between named limbs.</p>\n".into();
    }
    let cell = (SIDE / names.len() as f64).clamp(CELL[0], CELL[1]);
    let longest = names.iter().map(|name| name.chars().count()).max().unwrap_or(0) as f64;
    let margin = longest * LETTER + 12.0;
    let side = names.len() as f64 * cell;
    // The labels below lean by 45°.
    let (width, height) = (margin + side + 8.0, side + 0.75 * margin + 8.0);
    let mut drawing = String::new();
    for (i, name) in names.iter().enumerate() {
        let label = escape(&name.replace('_', " "));
        let middle = (i as f64 + 0.5) * cell;
        drawing.push_str(&format!(
            "<text x=\"{:.1}\" y=\"{middle:.1}\" text-anchor=\"end\" dy=\".35em\">{label}</text>\n\
             <text text-anchor=\"end\" transform=\"translate({:.1} {:.1}) rotate(-45)\" \
             dy=\".35em\">{label}</text>\n",
            margin - 8.0,
            margin + middle,
            side + 9.0,
        ));
        for (j, other) in names.iter().enumerate().take(i + 1) {
            let count = counts[i][j];
            let (x, y) = (margin + j as f64 * cell, i as f64 * cell);
            let (fill, ink) = colours(count, most);
            let title = format!("{label}, {}: {}", escape(&other.replace('_', " ")), touches_of(count));
            drawing.push_str(&format!(
                "<g><title>{title}</title><rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" \
                 rx=\"2\" fill=\"{fill}\"/>",
                x + 1.0,
                y + 1.0,
                cell - 2.0,
                cell - 2.0,
            ));
            if count > 0 && cell >= ROOM {
                drawing.push_str(&format!(
                    "<text x=\"{:.1}\" y=\"{:.1}\" dy=\".35em\" text-anchor=\"middle\" class=\"count\" \
                     fill=\"{ink}\">{count}</text>",
                    x + cell / 2.0,
                    y + cell / 2.0,
                ));
            }
            drawing.push_str("</g>\n");
        }
    }
    format!(
        "<figure>\n<svg viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" height=\"{height:.0}\" \
         role=\"img\" aria-label=\"Touches per pair of limbs\">\n{drawing}</svg>\n\
         <figcaption>Touches per pair of limbs, darker for more (logarithmic). Empty: \
         never touched each other.</figcaption>\n</figure>\n"
    )
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

/// The colour of a cell and of the number in it.
fn colours(count: usize, most: usize) -> (String, &'static str) {
    if count == 0 {
        return ("var(--empty)".into(), "none");
    }
    let share = (count as f64).ln_1p() / (most as f64).ln_1p();
    let [r, g, b] = [0, 1, 2].map(|k| PALE[k] + share * (DEEP[k] - PALE[k]));
    (format!("rgb({r:.0} {g:.0} {b:.0})"), if share > 0.55 { "#fff" } else { "#1f2933" })
}

fn touches_of(count: usize) -> String {
    if count == 1 { "1 touch".into() } else { plural(count, "touche") }
}
