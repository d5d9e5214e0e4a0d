//! A lower bound of the distance between convex shapes, by the algorithm of Gilbert, Johnson and Keerthi (van den
//! Bergen, "A Fast and Robust GJK Implementation for Collision Detection of Convex Objects", 1999).
//!
//! A motion that may not jump over a contact needs no exact distance, only one that it surely has: the distance
//! along the best separating direction found.

use nalgebra::Vector3;

/// The bound is good enough at this share of the distance.
const GOOD: f64 = 0.95;
/// Most support points looked for: more are needed only where shapes all but touch.
const MOST: usize = 40;

/// How far apart two convex solids are at the least, and along which unit vector, from the second to the first. Not
/// above 0 where they meet or nothing tells them apart. `support` gives the point of their difference (first less
/// second) that is farthest in a direction; `guess` is a direction to begin with.
pub(super) fn separation(
    support: impl Fn(&Vector3<f64>) -> Vector3<f64>,
    guess: &Vector3<f64>,
) -> (f64, Vector3<f64>) {
    let mut best = (f64::NEG_INFINITY, *guess);
    // The nearest point to the origin found so far, and the points of the difference that span it.
    let mut nearest = support(&-guess);
    let mut simplex = vec![nearest];
    best = better(best, guess, &nearest);
    for _ in 0..MOST {
        let distance = nearest.norm();
        if distance < 1e-9 || best.0 >= GOOD * distance {
            break;
        }
        let direction = nearest / distance;
        let point = support(&-direction);
        best = better(best, &direction, &point);
        if best.0 >= GOOD * distance || simplex.contains(&point) {
            break;
        }
        simplex.push(point);
        let (closer, face) = nearest_to_origin(&simplex);
        simplex = face;
        // Rounding, or the origin inside.
        if simplex.len() == 4 || closer.norm() >= distance {
            break;
        }
        nearest = closer;
    }
    best
}

/// The better of a bound and that of the plane through `point`, the farthest against `direction`.
fn better(best: (f64, Vector3<f64>), direction: &Vector3<f64>, point: &Vector3<f64>) -> (f64, Vector3<f64>) {
    let bound = direction.dot(point);
    if bound > best.0 { (bound, *direction) } else { best }
}

/// The point of a simplex that is nearest to the origin, and the corners that span the face it is on; all four
/// corners where the origin is inside.
fn nearest_to_origin(simplex: &[Vector3<f64>]) -> (Vector3<f64>, Vec<Vector3<f64>>) {
    match *simplex {
        [a, b] => on_segment(&a, &b),
        [a, b, c] => on_triangle(&a, &b, &c),
        [a, b, c, d] => {
            let faces = [([a, b, c], d), ([a, b, d], c), ([a, c, d], b), ([b, c, d], a)];
            let outside = faces.into_iter().filter(|([p, q, r], opposite)| {
                let normal = (q - p).cross(&(r - p));
                // A flat tetrahedron has no inside: each face counts.
                normal.dot(&-p) * normal.dot(&(opposite - p)) <= 0.0
            });
            let found = outside.map(|([p, q, r], _)| on_triangle(&p, &q, &r));
            let least = found.min_by(|x, y| x.0.norm_squared().total_cmp(&y.0.norm_squared()));
            least.unwrap_or_else(|| (Vector3::zeros(), simplex.to_vec()))
        }
        _ => (simplex[0], simplex[..1].to_vec()),
    }
}

fn on_segment(a: &Vector3<f64>, b: &Vector3<f64>) -> (Vector3<f64>, Vec<Vector3<f64>>) {
    let along = b - a;
    let share = -a.dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
    if share <= 0.0 {
        (*a, vec![*a])
    } else if share >= 1.0 {
        (*b, vec![*b])
    } else {
        (a + along * share, vec![*a, *b])
    }
}

/// By the triangle's plane where the origin is above its inside, or else by its nearest side.
fn on_triangle(a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>) -> (Vector3<f64>, Vec<Vector3<f64>>) {
    let normal = (b - a).cross(&(c - a));
    let inside = |p: &Vector3<f64>, q: &Vector3<f64>| (q - p).cross(&-p).dot(&normal) >= 0.0;
    if normal.norm_squared() > 0.0 && inside(a, b) && inside(b, c) && inside(c, a) {
        let height = normal * (normal.dot(a) / normal.norm_squared());
        return (height, vec![*a, *b, *c]);
    }
    let sides = [on_segment(a, b), on_segment(b, c), on_segment(c, a)];
    let nearer =
        |x: &(Vector3<f64>, _), y: &(Vector3<f64>, _)| x.0.norm_squared().total_cmp(&y.0.norm_squared());
    sides.into_iter().min_by(nearer).expect("a triangle has sides")
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::skin::{Hull, Shape, Surface};

    fn solid(kind: usize, origin: Vector3<f64>, turn: Vector3<f64>) -> Surface {
        let corners = [[0.3, 0.0, 0.0], [-0.1, 0.2, 0.0], [0.0, -0.2, 0.1], [0.0, 0.1, 0.3]];
        let faces = vec![[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];
        let shape = [
            Shape::Capsule { radius: 0.1, half_length: 0.2 },
            Shape::Ellipsoid { semi_axes: [0.1, 0.2, 0.05] },
            Shape::Cylinder { radius: 0.1, half_length: 0.2 },
            Shape::Box { half_extents: [0.1, 0.2, 0.05] },
            Shape::Hull(Hull::new(corners.map(Vector3::from).to_vec(), faces).unwrap()),
        ];
        let rotation = Rotation3::new(turn).into_inner();
        Surface { limb: 0, origin, rotation, shape: shape[kind].clone(), geom: 0 }
    }

    /// The distance along the best of many directions, each refined: slow, and never above the truth.
    fn by_search(support: &dyn Fn(&Vector3<f64>) -> Vector3<f64>, rng: &mut ChaCha8Rng) -> f64 {
        let bound = |d: &Vector3<f64>| d.dot(&support(&-d));
        let random = |rng: &mut ChaCha8Rng| Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
        let mut best =
            (0..300).map(|_| random(rng).normalize()).max_by(|a, b| bound(a).total_cmp(&bound(b))).unwrap();
        for step in 0..2000 {
            let trial = (best + random(rng) * 0.3 * 0.99f64.powi(step / 2)).normalize();
            if bound(&trial) > bound(&best) {
                best = trial;
            }
        }
        bound(&best)
    }

    #[test]
    fn the_bound_is_near_the_distance_and_never_beyond_it() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut random = |far: f64| Vector3::from_fn(|_, _| rng.random_range(-far..far));
        let mut apart = 0;
        for trial in 0..100 {
            let a = solid(trial % 5, random(0.01), random(3.0));
            let b = solid(trial / 5 % 5, random(0.5), random(3.0));
            let support = |d: &Vector3<f64>| a.support(d).unwrap() - b.support(&-d).unwrap();
            let (bound, normal) = separation(support, &Vector3::x());
            assert!((normal.norm() - 1.0).abs() < 1e-12);
            let searched = by_search(&support, &mut ChaCha8Rng::seed_from_u64(trial as u64));
            if searched > 0.0 {
                apart += 1;
                assert!(bound > 0.9 * searched, "{trial}: {bound} of {searched}");
                // What a direction separates is true whoever finds it.
                assert!((normal.dot(&support(&-normal)) - bound).abs() < 1e-12);
            } else {
                assert!(bound <= 1e-6, "{trial}: {bound} though they meet");
            }
        }
        assert!(apart > 30 && apart < 100, "{apart}");
    }
}
