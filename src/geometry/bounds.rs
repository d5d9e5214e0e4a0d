//! Bounding volumes: balls and capsules about bodies, which tell at once that these are far apart.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use super::Capsule;

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

impl Capsule {
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
}
