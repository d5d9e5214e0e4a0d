//! Which of many points is the farthest in a direction: what support mappings of polyhedra ask.
//!
//! Points that lie together are kept together, each group with a ball about it. A group is looked into only where its
//! ball reaches farther than the farthest point found so far, so that the answer is exact whatever rounding has made of
//! a convex polyhedron's edges, along which others would climb.

use nalgebra::Vector3;

/// Points that are looked at one by one: fewer balls make up for it.
const GROUP: usize = 12;
/// More than what rounding does to a ball's reach, by the points' size.
const ROUNDING: f64 = 1e-12;

/// Points, grouped by where they are.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FarthestPoint {
    points: Vec<Vector3<f64>>,
    groups: Vec<Group>,
}

/// Points that lie together, and the ball about them.
#[derive(Clone, Debug, PartialEq)]
struct Group {
    centre: Vector3<f64>,
    radius: f64,
    /// Its points: from the first to before the last.
    points: [usize; 2],
}

impl FarthestPoint {
    /// Of some points.
    pub fn new(mut points: Vec<Vector3<f64>>) -> FarthestPoint {
        let mut groups = Vec::with_capacity(points.len().div_ceil(GROUP / 2));
        split(&mut points, 0, &mut groups);
        FarthestPoint { points, groups }
    }

    /// The farthest in a direction of any length; the origin where there are no points.
    pub fn along(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        let length = direction.norm();
        let reach = |group: &Group| direction.dot(&group.centre) + group.radius * length;
        let mut found = Vector3::zeros();
        let mut most = f64::NEG_INFINITY;
        let mut look_into = |group: &Group, most: &mut f64| {
            for point in &self.points[group.points[0]..group.points[1]] {
                let far = direction.dot(point);
                if far > *most {
                    (*most, found) = (far, *point);
                }
            }
        };
        // The group whose middle is the farthest leaves few others to look into.
        let mut first = 0;
        if self.groups.len() > 1 {
            let mut farthest = f64::NEG_INFINITY;
            for (k, group) in self.groups.iter().enumerate() {
                let far = direction.dot(&group.centre);
                if far > farthest {
                    (first, farthest) = (k, far);
                }
            }
            look_into(&self.groups[first], &mut most);
        }
        for (k, group) in self.groups.iter().enumerate() {
            if reach(group) > most && (k != first || self.groups.len() == 1) {
                look_into(group, &mut most);
            }
        }
        found
    }
}

/// Halves the points, of which the first has the number `from`, across the side along which they spread the most, until
/// they are few enough for a group.
fn split(points: &mut [Vector3<f64>], from: usize, groups: &mut Vec<Group>) {
    if points.is_empty() {
        return;
    }
    let least = points.iter().fold(points[0], |least, p| least.inf(p));
    let most = points.iter().fold(points[0], |most, p| most.sup(p));
    if points.len() <= GROUP {
        let centre = 0.5 * (least + most);
        let radius = points.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
        let size = centre.norm() + radius;
        groups.push(Group { centre, radius: radius + ROUNDING * size, points: [from, from + points.len()] });
        return;
    }
    let axis = (most - least).imax();
    let half = points.len() / 2;
    points.select_nth_unstable_by(half, |a, b| a[axis].total_cmp(&b[axis]));
    let (first, second) = points.split_at_mut(half);
    split(first, from, groups);
    split(second, from + half, groups);
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn the_farthest_of_all_is_found_whatever_the_direction() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for count in [0, 1, 4, 8, 12, 13, 100, 2000] {
            // All near a ball's surface, as a hull's corners are, and some twice.
            let mut vector = || -> Vector3<f64> { Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0)) };
            let mut points: Vec<Vector3<f64>> = (0..count).map(|_| vector().normalize() * 0.3).collect();
            points.extend(points.clone().iter().take(3));
            let grouped = FarthestPoint::new(points.clone());
            for _ in 0..200 {
                let direction: Vector3<f64> = vector() * 5.0;
                let far = points.iter().map(|p| direction.dot(p)).fold(f64::NEG_INFINITY, f64::max);
                let found = grouped.along(&direction);
                match count {
                    0 => assert_eq!(found, Vector3::zeros()),
                    _ => assert_eq!(direction.dot(&found), far, "{count} points"),
                }
            }
        }
    }
}
