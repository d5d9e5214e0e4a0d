//! The algorithm of Gilbert, Johnson and Keerthi: where two convex bodies are closest.
//!
//! All that is asked of a body is its farthest point in a direction (its support mapping). The algorithm walks to the
//! point of the bodies' difference that is nearest to the origin (van den Bergen, "A Fast and Robust GJK Implementation
//! for Collision Detection of Convex Objects", 1999). Every support point on the way bounds the distance from below.

use nalgebra::Vector3;

use super::Gap;
use super::epa::penetration;
use super::simplex::{Corner, Simplex, SimplexPoint, witnesses};

/// A lower bound of the distance is good enough at this share of it.
const GOOD: f64 = 0.95;
/// Most support points looked for with a bound: more are needed only where shapes all but touch.
const MOST: usize = 40;
/// Most support points looked for with an exact distance: round shapes need them.
const MOST_EXACT: usize = 200;
/// How exact a distance is where no rounding is in the way, metres …
const EXACT: f64 = 1e-9;
/// … and by its share: what is short must not be inexact, for its direction counts as well.
const EXACT_SHARE: f64 = 1e-4;
/// Bodies nearer than this, metres, are taken to overlap: the way from one to the other is too short to tell its
/// direction.
const OVERLAPPING: f64 = 1e-7;
/// Bodies nearer than this, metres, whose distance did not become exact are looked at as those that overlap.
const STALLED: f64 = 1e-5;
/// The same as [`OVERLAPPING`] where a bound is enough.
const MET: f64 = 1e-9;

/// How exact a gap must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// To a nanometre, overlaps included.
    Exact,
    /// The same where bodies overlap by less than a millimetre; of what is deeper in each other, to a thousandth of the depth.
    ExactWhereShallow,
    /// A lower bound of the distance, no worse than 5 % below it; not above 0 where the bodies overlap, and then of no
    /// further meaning. The points are near the closest ones at best.
    LowerBound,
}

/// The gap of two convex bodies, given by the point of their difference that is farthest in a direction of length 1;
/// `guess` is a unit vector from the second to the first to begin with. A lower bound needs not be above `enough`.
pub(super) fn gjk(
    support: &dyn Fn(&Vector3<f64>) -> Corner,
    guess: &Vector3<f64>,
    precision: Precision,
    enough: f64,
) -> Gap {
    let first = support(&-guess);
    // The nearest point to the origin found so far, and the corners that span it.
    let mut simplex = Simplex::new(first);
    let mut nearest = simplex.nearest_to_origin();
    // The plane that parts the bodies the farthest: a lower bound and its normal.
    let mut best = (guess.dot(&first.difference), *guess);
    let exact = precision != Precision::LowerBound;
    // Whether it is enough to know that the distance is between these bounds.
    let is_reached = |least: f64, most: f64| match exact {
        true => most - least < EXACT.min(EXACT_SHARE * most),
        false => least >= enough.min(GOOD * most),
    };
    for _ in 0..if exact { MOST_EXACT } else { MOST } {
        let distance = nearest.point.norm();
        if exact && distance < OVERLAPPING {
            return penetration(support, simplex.corners(), precision);
        }
        if !exact && (distance < MET || is_reached(best.0, distance)) {
            break;
        }
        let direction = nearest.point / distance;
        let corner = support(&-direction);
        let bound = direction.dot(&corner.difference);
        // What is exact has the normal that leads to the nearest point: no other bound counts.
        if bound > best.0 || exact {
            best = (bound, direction);
        }
        let known = simplex.corners().iter().any(|other| other.difference == corner.difference);
        if known || is_reached(best.0, distance) {
            break;
        }
        let trial = simplex.with(corner);
        let closer = trial.nearest_to_origin();
        if closer.weights.iter().all(|&weight| weight > 0.0) {
            if exact {
                return penetration(support, trial.corners(), precision);
            }
            break;
        }
        // Rounding: the way is as short as it gets.
        if closer.point.norm() >= distance {
            break;
        }
        let weights;
        (simplex, weights) = trial.face_of(&closer);
        nearest = SimplexPoint { point: closer.point, weights };
    }
    let points = witnesses(simplex.corners(), &nearest.weights);
    if !exact {
        return Gap { distance: best.0, normal: best.1, points };
    }
    let distance = nearest.point.norm();
    // Of a flat simplex, rounding may hide the way on. So near to contact the polytope finds it.
    if distance < STALLED && distance - best.0 > EXACT {
        return penetration(support, simplex.corners(), precision);
    }
    Gap { distance, normal: nearest.point / distance, points }
}
