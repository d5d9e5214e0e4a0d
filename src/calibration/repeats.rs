//! Rows of a log that repeat one another: a touch that is held while rows go on being written, or rows that are copied.
//!
//! What disturbs a touch is drawn once for all of its rows. Each counts once, and what is of one posture is judged together.
//! Points that recur are receptors, whose places on their link may be off, each by itself.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::robot::{Element, Knowledge, MOUNT, Robot};
use super::touch::{Feature, Touch};

/// Coordinates of a posture that differ by less are the same, radians and metres: what an encoder at rest may flicker by.
pub const SAME_POSTURE: f64 = 2e-3;
/// Points that differ by less are the same, metres: a second touch is felt farther off.
pub const SAME_POINT: f64 = 1e-4;

/// A point that occurs so often is a receptor: what is said of it once is not checked by anything.
const RECURS: usize = 3;

/// For every row the first one that it is alike to, itself where there is none: of the same key, and no number differs by more
/// than 1. Numbers are of one count for a key.
fn first_alike<K: PartialEq>(rows: &[(K, Vec<f64>)]) -> Vec<usize> {
    // Rows that are alike are near each other in any mean; no weights that a grid of postures would repeat.
    let weight = |k: usize| 0.5 + 0.5 * (0.618_033_988_75 * (k + 1) as f64).fract();
    let mean = |numbers: &[f64]| numbers.iter().enumerate().map(|(k, x)| weight(k) * x).sum::<f64>();
    let most = rows.iter().map(|(_, numbers)| numbers.len()).max().unwrap_or(0);
    let reach: f64 = (0..most).map(weight).sum();
    let mut order: Vec<(f64, usize)> =
        rows.iter().enumerate().map(|(i, (_, numbers))| (mean(numbers), i)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut first: Vec<usize> = (0..rows.len()).collect();
    let alike = |a: usize, b: usize| {
        let ((key, x), (other, y)) = (&rows[a], &rows[b]);
        key == other && x.len() == y.len() && x.iter().zip(y).all(|(x, y)| (x - y).abs() <= 1.0)
    };
    for (rank, &(at, i)) in order.iter().enumerate() {
        let before = order[..rank].iter().rev().take_while(|(other, _)| at - other <= reach);
        let found = before.map(|(_, j)| first[*j]).filter(|j| alike(i, *j)).min();
        first[i] = found.unwrap_or(i);
    }
    // The first in the order of the log speaks for all of them.
    let mut earliest: Vec<usize> = (0..rows.len()).collect();
    for (i, of) in first.iter().enumerate() {
        earliest[*of] = earliest[*of].min(i);
    }
    first.into_iter().map(|of| earliest[of]).collect()
}

/// For every touch the first one in the same posture.
pub fn postures(touches: &[Touch]) -> Vec<usize> {
    let rows: Vec<((), Vec<f64>)> = touches.iter().map(|touch| ((), posture(touch))).collect();
    first_alike(&rows)
}

/// Leaves of touches that repeat one another the first; how many went.
pub fn drop_repeats(touches: &mut Vec<Touch>) -> usize {
    drop_alike(touches, |touch| {
        let mut numbers = posture(touch);
        numbers.push(touch.distance / SAME_POINT);
        let mut met = Vec::new();
        for (side, end) in
            touch.ends.iter().enumerate().flat_map(|(side, ends)| ends.iter().map(move |end| (side, end)))
        {
            met.push(match end.feature {
                Feature::Point(link, point) => {
                    numbers.extend(point.iter().map(|x| x / SAME_POINT));
                    (side, false, link)
                }
                Feature::Surface(surface) => (side, true, surface),
            });
        }
        (met, numbers)
    })
}

/// Leaves of those that are alike by their key and numbers the first; how many went.
pub fn drop_alike<T, K: PartialEq>(all: &mut Vec<T>, row: impl Fn(&T) -> (K, Vec<f64>)) -> usize {
    let first = first_alike(&all.iter().map(row).collect::<Vec<_>>());
    let before = all.len();
    let mut keep = first.iter().enumerate().map(|(i, of)| i == *of);
    all.retain(|_| keep.next().unwrap_or(true));
    before - all.len()
}

fn posture(touch: &Touch) -> Vec<f64> {
    touch.posture.iter().map(|x| x / SAME_POSTURE).collect()
}

/// Makes every point of a link that recurs in the touches a place of its own, known to a standard deviation (metres) before any
/// touch; how many there are. Their quantities are called `LINK.placeN.position`.
pub fn add_places(robot: &mut Robot, touches: &mut [Touch], deviation: f64) -> usize {
    let mut counts: BTreeMap<(usize, [u64; 3]), usize> = BTreeMap::new();
    for end in touches.iter().flat_map(|touch| &touch.ends).flatten() {
        if let Feature::Point(link, point) = end.feature {
            *counts.entry((link, bits(&point))).or_insert(0) += 1;
        }
    }
    let recurring: Vec<(usize, [u64; 3])> =
        counts.into_iter().filter(|(_, count)| *count >= RECURS).map(|(point, _)| point).collect();
    for (number, (link, point)) in recurring.iter().enumerate() {
        let name = robot.links[*link].name.trim_end_matches(MOUNT).to_string();
        let place = format!("{name}.place{}", number + 1);
        robot.add_place(&place, *link, Vector3::from(point.map(f64::from_bits)));
        if let Some(quantity) = robot.quantities.last_mut() {
            quantity.knowledge = [Knowledge::Near(deviation); 3];
        }
    }
    put_on_places(robot, touches);
    recurring.len()
}

/// Puts the points of touches that are at a robot's places on them: those of another log, too.
pub fn put_on_places(robot: &Robot, touches: &mut [Touch]) {
    let mut places: BTreeMap<(usize, [u64; 3]), usize> = BTreeMap::new();
    for (link, about) in robot.links.iter().enumerate() {
        if let [Element::Shift(position)] = about.elements.as_slice() {
            places.insert((about.parent, bits(&robot.quantities[*position].nominal.vector())), link);
        }
    }
    for end in touches.iter_mut().flat_map(|touch| &mut touch.ends).flatten() {
        if let Feature::Point(link, point) = end.feature
            && let Some(place) = places.get(&(link, bits(&point)))
        {
            end.feature = Feature::Point(*place, Vector3::zeros());
        }
    }
}

/// A point that compares as a key; no zero has a sign.
fn bits(point: &Vector3<f64>) -> [u64; 3] {
    [point.x, point.y, point.z].map(|x| (x + 0.0).to_bits())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_that_flicker_are_one_and_others_are_not() {
        let rows = [
            (1, vec![0.0, 5.0]),
            (1, vec![3.0, 5.0]),
            (1, vec![0.4, 5.3]),
            (2, vec![0.0, 5.0]),
            (1, vec![2.9, 4.5]),
        ];
        assert_eq!(first_alike(&rows), [0, 1, 0, 3, 1]);
    }
}
