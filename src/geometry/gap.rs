//! The gap between two placed shapes: distance, normal and closest points.

use nalgebra::Vector3;

use super::gjk::{Precision, gjk};
use super::simplex::Corner;
use super::{Capsule, Frame, Shape};
use crate::deadline::count_work;

/// What a step towards the gap of two bodies counts as, in work of [`count_work`].
const SUPPORT: usize = 600;

/// Where two bodies come closest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Distance between them, negative where they overlap, metres.
    pub distance: f64,
    /// Unit normal from the second to the first: the gradient of the distance by where the first is.
    pub normal: Vector3<f64>,
    /// The closest point of each, or the deepest, metres.
    pub points: [Vector3<f64>; 2],
}

impl Gap {
    /// The middle between the closest points, metres.
    #[inline]
    pub fn middle(&self) -> Vector3<f64> {
        0.5 * (self.points[0] + self.points[1])
    }

    /// The same gap with the bodies exchanged.
    #[inline]
    pub fn reversed(self) -> Gap {
        let [first, second] = self.points;
        Gap { distance: self.distance, normal: -self.normal, points: [second, first] }
    }
}

/// A convex body in the frame in which gaps are asked for.
pub trait ConvexBody {
    /// Its farthest point in a direction of any length (its support mapping), metres.
    fn support(&self, direction: &Vector3<f64>) -> Vector3<f64>;

    /// A point inside, metres.
    fn centre(&self) -> Vector3<f64>;

    /// The body itself as a capsule, where it is one or a ball.
    fn as_capsule(&self) -> Option<Capsule> {
        None
    }

    /// Distance of a point to the surface, metres, negative inside, and the outward unit normal there.
    fn signed_distance(&self, p: &Vector3<f64>) -> (f64, Vector3<f64>);
}

/// A solid shape in the common frame C.
#[derive(Clone, Copy, Debug)]
pub struct PlacedShape<'a> {
    shape: &'a Shape,
    x_cg: Frame,
}

impl<'a> PlacedShape<'a> {
    /// A shape at `X_LG` on a limb at `X_CL`; none for one that is known only by its receptors.
    #[inline]
    pub fn new(shape: &'a Shape, x_lg: Frame, x_cl: Frame) -> Option<PlacedShape<'a>> {
        shape.is_solid().then(|| PlacedShape { shape, x_cg: x_cl * x_lg })
    }
}

const SOLID: &str = "a placed shape is solid";

impl ConvexBody for PlacedShape<'_> {
    fn support(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        let local = self.x_cg.rotation.tr_mul(direction);
        self.x_cg.point(&self.shape.support(&local).expect(SOLID))
    }

    fn centre(&self) -> Vector3<f64> {
        self.x_cg.origin
    }

    fn as_capsule(&self) -> Option<Capsule> {
        self.shape.as_capsule(&self.x_cg)
    }

    fn signed_distance(&self, p: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let (distance, normal) = self.shape.signed_distance(&self.x_cg.inverse_point(p)).expect(SOLID);
        (distance, self.x_cg.direction(&normal))
    }
}

impl ConvexBody for Capsule {
    fn support(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        let [p, q] = self.ends;
        let far = if p.dot(direction) > q.dot(direction) { p } else { q };
        far + direction.try_normalize(f64::MIN_POSITIVE).unwrap_or_default() * self.radius
    }

    fn centre(&self) -> Vector3<f64> {
        0.5 * (self.ends[0] + self.ends[1])
    }

    fn as_capsule(&self) -> Option<Capsule> {
        Some(*self)
    }

    fn signed_distance(&self, p: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let point = Capsule::ball(*p, 0.0);
        let gap = point.gap(self);
        (gap.distance, gap.normal)
    }
}

/// The gap between two convex bodies in a common frame.
///
/// Exact gaps of capsules and balls are worked out in closed form, those of a capsule and any other body along the
/// capsule's segment by the other's signed distance: an overlap that the segment itself takes part in counts as deep as
/// its deepest point. All others are found by GJK and, where they overlap, by EPA.
pub fn gap(a: &dyn ConvexBody, b: &dyn ConvexBody, precision: Precision) -> Gap {
    closed_form(a, b, precision).unwrap_or_else(|| gap_by_support(a, b, precision))
}

/// The same, where a unit vector is known that leads from the second body to the first, or nearly so.
pub fn gap_from(a: &dyn ConvexBody, b: &dyn ConvexBody, precision: Precision, guess: &Vector3<f64>) -> Gap {
    closed_form(a, b, precision).unwrap_or_else(|| iterated(a, b, precision, guess))
}

/// A lower bound of the gap between two convex bodies, metres, and the unit normal of the plane that tells it, from the
/// second to the first: `enough`, or no worse than 5 % below the gap; not above 0 where they overlap. The search begins
/// with a normal that is known to lead from the second body to the first, or nearly so.
pub fn separation(
    a: &dyn ConvexBody,
    b: &dyn ConvexBody,
    guess: &Vector3<f64>,
    enough: f64,
) -> (f64, Vector3<f64>) {
    let found = gjk(&difference(a, b), guess, Precision::LowerBound, enough);
    (found.distance, found.normal)
}

fn closed_form(a: &dyn ConvexBody, b: &dyn ConvexBody, precision: Precision) -> Option<Gap> {
    let exact = precision != Precision::LowerBound;
    match (a.as_capsule(), b.as_capsule()) {
        (Some(a), Some(b)) => Some(a.gap(&b)),
        (Some(a), None) if exact => Some(capsule_gap(&a, |p| b.signed_distance(p))),
        (None, Some(b)) if exact => Some(capsule_gap(&b, |p| a.signed_distance(p)).reversed()),
        _ => None,
    }
}

/// Distance of a point to the surface of a body of which nothing but its support mapping is known, metres, negative inside,
/// and the outward unit normal there.
pub(crate) fn distance_by_support(
    body: &dyn ConvexBody,
    p: &Vector3<f64>,
    precision: Precision,
) -> (f64, Vector3<f64>) {
    let found = gap_by_support(&Capsule::ball(*p, 0.0), body, precision);
    (found.distance, found.normal)
}

/// The gap where no closed form is to be looked for.
pub(crate) fn gap_by_support(a: &dyn ConvexBody, b: &dyn ConvexBody, precision: Precision) -> Gap {
    let guess = (a.centre() - b.centre()).try_normalize(1e-9).unwrap_or(Vector3::x());
    iterated(a, b, precision, &guess)
}

fn iterated(a: &dyn ConvexBody, b: &dyn ConvexBody, precision: Precision, guess: &Vector3<f64>) -> Gap {
    gjk(&difference(a, b), guess, precision, f64::INFINITY)
}

/// The support mapping of the difference of two bodies, which counts as work with what is done with a point of it.
fn difference(a: &dyn ConvexBody, b: &dyn ConvexBody) -> impl Fn(&Vector3<f64>) -> Corner {
    |direction| {
        count_work(SUPPORT);
        let points = [a.support(direction), b.support(&-direction)];
        Corner { difference: points[0] - points[1], points }
    }
}

/// The gap between a capsule and a convex body that its signed distance tells of. Along the capsule's segment the
/// distance is convex, and its least is the gap.
fn capsule_gap(capsule: &Capsule, signed_distance: impl Fn(&Vector3<f64>) -> (f64, Vector3<f64>)) -> Gap {
    let [start, end] = capsule.ends;
    let along = end - start;
    let at = |t: f64| {
        let p = start + along * t;
        let (distance, normal) = signed_distance(&p);
        (p, distance, normal, normal.dot(&along))
    };
    let first = at(0.0);
    let (p, distance, normal, _) = if first.3 >= 0.0 { first } else { least_distance(first, at) };
    Gap {
        distance: distance - capsule.radius,
        normal,
        points: [p - normal * capsule.radius, p - normal * distance],
    }
}

/// A point of a segment, its signed distance, the normal there and how fast the distance grows along the segment.
type Sounding = (Vector3<f64>, f64, Vector3<f64>, f64);

/// Where on a segment, from 0 to 1, a convex distance is least that falls from `first` on: the root of its slope, by
/// regula falsi with the Illinois rule, which cannot leave its bracket.
fn least_distance(first: Sounding, at: impl Fn(f64) -> Sounding) -> Sounding {
    let second = at(1.0);
    if second.3 <= 0.0 {
        return second;
    }
    let (mut low, mut high) = ((0.0, first.3), (1.0, second.3));
    let mut found = first;
    let mut kept = 0;
    for _ in 0..60 {
        let t = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        found = at(t);
        if found.3.abs() * (high.0 - low.0) < 1e-13 {
            break;
        }
        if found.3 < 0.0 {
            low = (t, found.3);
            high.1 *= if kept < 0 { 0.5 } else { 1.0 };
            kept = -1;
        } else {
            high = (t, found.3);
            low.1 *= if kept > 0 { 0.5 } else { 1.0 };
            kept = 1;
        }
    }
    found
}
