//! Shortest ways over the graph.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use super::SurfaceGraph;

impl SurfaceGraph<'_> {
    /// Gives points that no patch holds to the receptor that is nearest along their limb's skin.
    pub(super) fn give_to_receptors(&mut self) {
        let mut queue = BinaryHeap::new();
        let mut reached = vec![f64::INFINITY; self.points.len()];
        for (i, point) in self.points.iter().enumerate().filter(|(_, point)| point.receptor.is_some()) {
            reached[i] = 0.0;
            queue.push(Reverse((Length(0.0), i, point.receptor)));
        }
        while let Some(Reverse((Length(length), i, receptor))) = queue.pop() {
            if length > reached[i] {
                continue;
            }
            self.points[i].receptor = receptor;
            for &(j, way) in &self.links[i] {
                let j = j as usize;
                if self.points[j].limb == self.points[i].limb && length + way < reached[j] {
                    reached[j] = length + way;
                    queue.push(Reverse((Length(length + way), j, receptor)));
                }
            }
        }
    }

    /// The lengths of the shortest ways from a point, until all targets are reached (Dijkstra).
    pub(super) fn ways(&self, from: usize, targets: &[usize], reached: &mut HashMap<usize, f64>) {
        reached.clear();
        let mut left = targets.to_vec();
        let mut queue = BinaryHeap::from([Reverse((Length(0.0), from))]);
        reached.insert(from, 0.0);
        while let Some(Reverse((Length(length), i))) = queue.pop() {
            if length > reached[&i] {
                continue;
            }
            left.retain(|target| *target != i);
            if left.is_empty() {
                break;
            }
            for &(j, way) in &self.links[i] {
                let (j, length) = (j as usize, length + way);
                if reached.get(&j).is_none_or(|before| length < *before) {
                    reached.insert(j, length);
                    queue.push(Reverse((Length(length), j)));
                }
            }
        }
    }
}

/// A length in an order.
#[derive(Clone, Copy, PartialEq)]
struct Length(f64);

impl Eq for Length {}

impl Ord for Length {
    fn cmp(&self, other: &Length) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl PartialOrd for Length {
    fn partial_cmp(&self, other: &Length) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
