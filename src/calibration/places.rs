//! Points of a log that recur: receptors whose places on their link may be off, each by itself.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::robot::{Element, Knowledge, MOUNT, Robot};
use super::touch::{Feature, Touch};

/// A point that occurs so often is a receptor: what is said of it once is not checked by anything.
const RECURS: usize = 3;

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
