//! Segments, and the capsules about them: spheres swept along a segment, whose gap is exact and cheap.

use nalgebra::Vector3;

use super::{Ball, Frame, Gap};

/// Segments shorter than this, squared metres, are points.
const SHORT: f64 = 1e-18;
/// Nearer than this, metres, two points have no direction from one to the other.
const MET: f64 = 1e-12;

/// All points within a radius of a segment; a ball where both ends are one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// The ends of the segment, metres.
    pub ends: [Vector3<f64>; 2],
    /// The radius, metres.
    pub radius: f64,
}

impl Capsule {
    /// The ball about a point, as a capsule without length.
    #[inline]
    pub fn ball(centre: Vector3<f64>, radius: f64) -> Capsule {
        Capsule { ends: [centre; 2], radius }
    }

    /// The same capsule in frame A, given in frame B at `X_AB`.
    #[inline]
    pub fn placed(&self, x_ab: &Frame) -> Capsule {
        Capsule { ends: self.ends.map(|end| x_ab.point(&end)), radius: self.radius }
    }

    /// The smallest ball about it.
    pub fn bounding_ball(&self) -> Ball {
        let [a, b] = self.ends;
        Ball { centre: 0.5 * (a + b), radius: self.radius + 0.5 * (b - a).norm() }
    }

    /// Where two capsules come closest; overlapping ones are measured along the shortest line between their
    /// segments.
    #[inline]
    pub fn gap(&self, other: &Capsule) -> Gap {
        let Gap { distance, normal, points: [p, q] } = self.gap_at_segments(other);
        Gap { distance, normal, points: [p - normal * self.radius, q + normal * other.radius] }
    }

    /// The same with the closest points of the segments in place of those of the surfaces.
    #[inline]
    pub(crate) fn gap_at_segments(&self, other: &Capsule) -> Gap {
        let points = closest_points(&self.ends, &other.ends);
        let between = points[0] - points[1];
        let distance = between.norm();
        let normal = if distance > MET { between / distance } else { Vector3::z() };
        Gap { distance: distance - self.radius - other.radius, normal, points }
    }

    /// How far it is from a ball at the least, metres, negative where they overlap.
    #[inline]
    pub fn distance_to(&self, ball: &Ball) -> f64 {
        let [p, q] = closest_points(&[ball.centre; 2], &self.ends);
        (p - q).norm() - ball.radius - self.radius
    }
}

/// Distance of a point to a sphere's surface and the outward normal there, given where the point is from the centre; of
/// a swept sphere, from the nearest point of its segment.
#[inline]
pub(super) fn distance_to_sphere(offset: &Vector3<f64>, radius: f64) -> (f64, Vector3<f64>) {
    let length = offset.norm();
    let normal = if length > MET { offset / length } else { Vector3::x() };
    (length - radius, normal)
}

/// The closest points of two segments, one on each (Ericson, "Real-Time Collision Detection", 2005, section 5.1.9).
#[inline]
pub fn closest_points(a: &[Vector3<f64>; 2], b: &[Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
    let (along_a, along_b, between) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    let (aa, bb) = (along_a.norm_squared(), along_b.norm_squared());
    let (ab, fb) = (along_a.dot(&along_b), along_b.dot(&between));
    let ca = along_a.dot(&between);
    let (s, t) = if aa <= SHORT && bb <= SHORT {
        (0.0, 0.0)
    } else if aa <= SHORT {
        (0.0, (fb / bb).clamp(0.0, 1.0))
    } else if bb <= SHORT {
        ((-ca / aa).clamp(0.0, 1.0), 0.0)
    } else {
        let denominator = aa * bb - ab * ab;
        let s = if denominator > 1e-12 * aa * bb {
            ((ab * fb - ca * bb) / denominator).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let t = (ab * s + fb) / bb;
        if t < 0.0 {
            ((-ca / aa).clamp(0.0, 1.0), 0.0)
        } else if t > 1.0 {
            (((ab - ca) / aa).clamp(0.0, 1.0), 1.0)
        } else {
            (s, t)
        }
    };
    [a[0] + along_a * s, b[0] + along_b * t]
}
