//! Clusters of touches that belong to one thing, from their positions and the free space between them.

use nalgebra::Vector3;

use super::Feeling;
use super::plan::SEARCHED;
use crate::peripersonal::{CELL, SearchedMap};

/// Touches farther apart than this are not taken for those of one thing by themselves, metres: what is larger is touched at
/// places that are nearer.
const TOGETHER: f64 = 0.07;
/// By so much skin passed lower than both touches where it parts them, metres.
const LOWER: f64 = 0.015;
/// So much of the way between two touches may be empty, metres: a touch is known to a centimetre or two.
const EMPTY: f64 = 0.012;
/// And so much at either end is not looked at, metres.
const END: f64 = 0.012;

/// A thing as it was felt in a search.
#[derive(Clone, Debug)]
pub struct FeltThing {
    /// Its touches, as indices into [`super::Search::felt`].
    pub touches: Vec<usize>,
    /// The middle of them in the root's frame, metres.
    pub at: Vector3<f64>,
}

/// The things that touches are of, in the order in which they were felt first.
pub fn things(map: &SearchedMap, felt: &[Feeling]) -> Vec<FeltThing> {
    let mut group: Vec<usize> = (0..felt.len()).collect();
    let are_one = |a: &Feeling, b: &Feeling| {
        (a.at[0] - b.at[0]).hypot(a.at[1] - b.at[1]) <= TOGETHER && nothing_parts(map, a, b)
    };
    for i in 0..felt.len() {
        for j in 0..i {
            if group[i] != group[j] && !felt[i].gone && !felt[j].gone && are_one(&felt[i], &felt[j]) {
                let (old, new) = (group[i].max(group[j]), group[i].min(group[j]));
                group.iter_mut().filter(|g| **g == old).for_each(|g| *g = new);
            }
        }
    }
    let firsts = (0..felt.len()).filter(|&i| group[i] == i && !felt[i].gone);
    let thing = |first: usize| {
        let touches: Vec<usize> = (first..felt.len()).filter(|&i| group[i] == first).collect();
        let points: Vec<Vector3<f64>> = touches.iter().map(|&i| felt[i].found.point).collect();
        let (mut low, mut high) = (points[0], points[0]);
        for point in &points {
            low = low.inf(point);
            high = high.sup(point);
        }
        FeltThing { touches, at: 0.5 * (low + high) }
    };
    firsts.map(thing).collect()
}

/// Whether no skin has passed between two touches lower than both: where it has there is no thing that reaches from one to
/// the other.
pub(super) fn nothing_parts(map: &SearchedMap, a: &Feeling, b: &Feeling) -> bool {
    let [p, q] = [a, b].map(|felt| [felt.at[0], felt.at[1]]);
    let lower = a.at[2].min(b.at[2]) - LOWER;
    map.longest_empty(p, q, END, lower.max(SEARCHED)) < EMPTY.max(CELL)
}
