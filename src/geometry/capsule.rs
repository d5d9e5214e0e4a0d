//! Capsules, spheres swept along a segment, whose gap is exact and cheap; and balls. Capsules and balls about bodies show at
//! once that these are far apart.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use super::{Frame, Gap};

/// Segments shorter than this, squared metres, are points.
const SHORT: f64 = 1e-18;
/// Nearer than this, metres, two points have no direction from one to the other.
const MET: f64 = 1e-12;

/// All points within a radius of a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// The centre, metres.
    pub centre: Vector3<f64>,
    /// The radius, metres.
    pub radius: f64,
}

impl Ball {
    /// A ball about others, centred on average of their centres; none about nothing.
    pub fn about(balls: &[Ball]) -> Option<Ball> {
        let centre = balls.iter().map(|ball| ball.centre).sum::<Vector3<f64>>() / balls.len() as f64;
        let reach = balls.iter().map(|ball| (ball.centre - centre).norm() + ball.radius);
        (!balls.is_empty()).then(|| Ball { centre, radius: reach.fold(0.0, f64::max) })
    }

    /// How far two balls are apart when their centres are at the points given, metres, negative where they overlap.
    #[inline]
    pub fn gap_at(&self, centre: &Vector3<f64>, other: &Ball, other_centre: &Vector3<f64>) -> f64 {
        (centre - other_centre).norm() - self.radius - other.radius
    }
}

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

    /// A capsule about the box of these half sides about the origin, along its longest side.
    pub fn about_box(half: &Vector3<f64>) -> Capsule {
        let axis = half.imax();
        let others = Vector3::from_fn(|k, _| if k == axis { 0.0 } else { half[k] });
        Capsule::along(axis, half[axis], others.norm())
    }

    /// A capsule about the origin along one of the axes.
    pub(super) fn along(axis: usize, half_length: f64, radius: f64) -> Capsule {
        let end = Vector3::ith(axis, half_length);
        Capsule { ends: [end, -end], radius }
    }

    /// A capsule about points along the direction in which they spread the most; none about none.
    pub fn about_points(points: &[Vector3<f64>]) -> Option<Capsule> {
        if points.is_empty() {
            return None;
        }
        let middle = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
        let spread: Matrix3<f64> = points.iter().map(|p| (p - middle) * (p - middle).transpose()).sum();
        let eigen = SymmetricEigen::new(spread);
        let axis: Vector3<f64> = eigen.eigenvectors.column(eigen.eigenvalues.imax()).into();
        let places: Vec<(f64, f64)> = points
            .iter()
            .map(|p| {
                let along = (p - middle).dot(&axis);
                (along, (p - middle - axis * along).norm())
            })
            .collect();
        let radius = places.iter().map(|place| place.1).fold(0.0, f64::max);
        // How far the axis must go for the caps to cover what is at its ends.
        let needed = |sign: f64| {
            let of =
                |&(along, off): &(f64, f64)| sign * along - (radius * radius - off * off).max(0.0).sqrt();
            places.iter().map(of).fold(0.0, f64::max)
        };
        Some(Capsule { ends: [middle - axis * needed(-1.0), middle + axis * needed(1.0)], radius })
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

/// The least and the greatest corner of the box along the axes about some points; `None` if there are none.
pub fn box_about(points: impl IntoIterator<Item = Vector3<f64>>) -> Option<[Vector3<f64>; 2]> {
    let corners = points.into_iter().map(|point| [point, point]);
    corners.reduce(|[low, high], [least, most]| [low.inf(&least), high.sup(&most)])
}

/// Some of a list of capsules that lie together, and a ball about them.
#[derive(Clone, Debug)]
pub struct Cluster {
    /// The capsules, by their places in the list.
    pub members: Vec<u32>,
    /// The ball.
    pub ball: Ball,
}

/// Splits capsules until each cluster's ball is at most about `largest` metres in radius, so that balls tell what is
/// apart. `members` are places in `capsules`.
pub fn clusters(members: Vec<u32>, capsules: &[Capsule], largest: f64) -> Vec<Cluster> {
    let of = |member: &u32| &capsules[*member as usize];
    let ends = members.iter().flat_map(|member| of(member).ends);
    let Some([low, high]) = box_about(ends) else { return Vec::new() };
    let centre = 0.5 * (low + high);
    let reach = |member: &u32| {
        let capsule = of(member);
        capsule.ends.iter().map(|end| (end - centre).norm()).fold(0.0, f64::max) + capsule.radius
    };
    let radius = members.iter().map(reach).fold(0.0, f64::max);
    if radius > largest && members.len() > 1 {
        let axis = (high - low).imax();
        let middle = |member: &u32| of(member).ends.iter().map(|end| end[axis]).sum::<f64>();
        let mut sorted = members.clone();
        sorted.sort_by(|a, b| middle(a).total_cmp(&middle(b)));
        let rest = sorted.split_off(sorted.len() / 2);
        let mut split = clusters(sorted, capsules, largest);
        split.extend(clusters(rest, capsules, largest));
        return split;
    }
    vec![Cluster { members, ball: Ball { centre, radius } }]
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
