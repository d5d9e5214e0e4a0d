//! Where two convex solids are closest, or how deep they are in each other.
//!
//! All that is asked of a solid is its farthest point in a direction. Apart, the algorithm of Gilbert, Johnson and
//! Keerthi walks to the point of their difference that is nearest to the origin (van den Bergen, "A Fast and Robust
//! GJK Implementation for Collision Detection of Convex Objects", 1999); overlapping, a polytope inside the
//! difference grows about the origin until its nearest face is one of the difference's own (van den Bergen,
//! "Proximity Queries and Penetration Depth Computation on 3D Game Objects", 2001).

use nalgebra::Vector3;

/// A bound of the distance is good enough at this share of it.
const GOOD: f64 = 0.95;
/// Most support points looked for with a bound: more are needed only where shapes all but touch.
const MOST: usize = 40;
/// Most support points looked for with an exact distance: round shapes need them.
const MOST_EXACT: usize = 200;
/// How exact a distance is where no rounding is in the way, metres …
const EXACT: f64 = 1e-9;
/// … and by its share: what is short must not be inexact, for its direction counts as well.
const EXACT_SHARE: f64 = 1e-4;
/// A tetrahedron less high than this is flat, metres.
const FLAT: f64 = 1e-12;
/// How far a corner may be from a plane that it is in, metres.
const ROUNDING: f64 = 1e-13;
/// Solids nearer than this, metres, are taken to overlap: the way from one to the other is too short to tell its
/// direction.
const MEETING: f64 = 1e-7;

/// Where two solids come closest.
#[derive(Clone, Copy, Debug)]
pub struct Closest {
    /// Distance between them; negative where they overlap, the shortest way that parts them, metres.
    pub distance: f64,
    /// Unit normal from the second to the first.
    pub normal: Vector3<f64>,
    /// The closest point of each, or the deepest, metres.
    pub points: [Vector3<f64>; 2],
}

/// A point of the difference of two solids, first less second, and the points of both that it is made of.
#[derive(Clone, Copy, Debug)]
struct Corner {
    difference: Vector3<f64>,
    points: [Vector3<f64>; 2],
}

/// The point of a simplex that is nearest to the origin, and how it is made of the corners.
struct Nearest {
    point: Vector3<f64>,
    /// Positive for the corners of the face that it is on, 0 for others.
    weights: [f64; 4],
}

/// How far apart two convex solids are at the least, and along which unit vector, from the second to the first. Not
/// above 0 where they meet or nothing tells them apart. `support` gives the point of their difference (first less
/// second) that is farthest in a direction; `guess` is a direction to begin with.
pub fn separation(
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
        let closer = nearest_to_origin(&simplex);
        keep(&mut simplex, &closer.weights);
        // Rounding, or the origin inside.
        if simplex.len() == 4 || closer.point.norm() >= distance {
            break;
        }
        nearest = closer.point;
    }
    best
}

/// The farthest point of a convex solid in a direction of any length.
pub type Support<'a> = &'a dyn Fn(&Vector3<f64>) -> Vector3<f64>;

/// Where two convex solids are closest, given by their farthest points, and a direction from the second to the
/// first to begin with.
pub fn closest(supports: [Support; 2], guess: &Vector3<f64>) -> Closest {
    let support = |direction: &Vector3<f64>| {
        let points = [supports[0](direction), supports[1](&-direction)];
        Corner { difference: points[0] - points[1], points }
    };
    let mut simplex = vec![support(&-guess)];
    let mut nearest = Nearest { point: simplex[0].difference, weights: [1.0, 0.0, 0.0, 0.0] };
    for _ in 0..MOST_EXACT {
        let distance = nearest.point.norm();
        if distance < MEETING {
            return deepest(&support, simplex);
        }
        let corner = support(&-nearest.point);
        let left = distance - nearest.point.dot(&corner.difference) / distance;
        let known = simplex.iter().any(|other| other.difference == corner.difference);
        if known || left < EXACT.min(EXACT_SHARE * distance) {
            break;
        }
        let mut trial = simplex.clone();
        trial.push(corner);
        let closer = nearest_to_origin(&trial.iter().map(|corner| corner.difference).collect::<Vec<_>>());
        if closer.weights.iter().all(|&weight| weight > 0.0) {
            return deepest(&support, trial);
        }
        // Rounding: the way is as short as it gets.
        if closer.point.norm() >= distance {
            break;
        }
        keep(&mut trial, &closer.weights);
        simplex = trial;
        let mut weights = [0.0; 4];
        let kept = closer.weights.iter().filter(|&&weight| weight > 0.0);
        weights.iter_mut().zip(kept).for_each(|(weight, kept)| *weight = *kept);
        nearest = Nearest { point: closer.point, weights };
    }
    let distance = nearest.point.norm();
    let points = [0, 1].map(|k| mean(&simplex, &nearest.weights, k));
    Closest { distance, normal: nearest.point / distance, points }
}

/// The point of one solid that corners with these weights are made of.
fn mean(corners: &[Corner], weights: &[f64], k: usize) -> Vector3<f64> {
    corners.iter().zip(weights).map(|(corner, weight)| corner.points[k] * *weight).sum()
}

/// Keeps the corners with a weight.
fn keep<T>(simplex: &mut Vec<T>, weights: &[f64; 4]) {
    let mut weights = weights.iter();
    simplex.retain(|_| weights.next().is_some_and(|&weight| weight > 0.0));
}

/// A face of a polytope, its corners counterclockwise as seen from outside.
struct Face {
    corners: [usize; 3],
    /// Outward unit normal.
    normal: Vector3<f64>,
    /// How far the face's plane is from the origin along it.
    offset: f64,
}

/// How deep two solids are in each other whose difference has the origin inside, or nearly on its surface.
fn deepest(support: &dyn Fn(&Vector3<f64>) -> Corner, simplex: Vec<Corner>) -> Closest {
    let mut corners = simplex;
    fill(support, &mut corners);
    let face = |corners: &[Corner], at: [usize; 3]| {
        let [a, b, c] = at.map(|k| corners[k].difference);
        let normal = (b - a).cross(&(c - a)).try_normalize(f64::MIN_POSITIVE)?;
        Some(Face { corners: at, normal, offset: normal.dot(&a) })
    };
    let mut faces: Vec<Face> = Vec::new();
    if corners.len() == 4 {
        for (at, opposite) in [([0, 1, 2], 3), ([0, 1, 3], 2), ([0, 2, 3], 1), ([1, 2, 3], 0)] {
            let Some(found) = face(&corners, at) else { continue };
            let inward = found.normal.dot(&corners[opposite].difference) > found.offset;
            let turned = [at[0], at[2], at[1]];
            faces.extend(if inward { face(&corners, turned) } else { Some(found) });
        }
    }
    // The best direction so far: no other parts the solids sooner.
    let mut best: Option<(f64, Vector3<f64>)> = None;
    let by_offset = |a: &&Face, b: &&Face| a.offset.total_cmp(&b.offset);
    for _ in 0..MOST_EXACT {
        let Some(nearest) = faces.iter().min_by(by_offset) else { break };
        let corner = support(&nearest.normal);
        let depth = nearest.normal.dot(&corner.difference);
        if best.is_none_or(|(least, _)| depth < least) {
            best = Some((depth, nearest.normal));
        }
        if depth - nearest.offset < EXACT {
            break;
        }
        // The faces that see the new corner give way to those between it and their outline.
        let number = corners.len();
        corners.push(corner);
        let mut edges: Vec<[usize; 2]> = Vec::new();
        faces.retain(|face| {
            // A face in whose plane the corner is counts as one that sees it: none of the new ones is a sliver.
            let hidden = face.normal.dot(&corner.difference) < face.offset - ROUNDING;
            if !hidden {
                let [a, b, c] = face.corners;
                for edge in [[a, b], [b, c], [c, a]] {
                    match edges.iter().position(|other| *other == [edge[1], edge[0]]) {
                        Some(twin) => drop(edges.swap_remove(twin)),
                        None => edges.push(edge),
                    }
                }
            }
            hidden
        });
        let (before, added) = (faces.len(), edges.len());
        faces.extend(edges.into_iter().filter_map(|[a, b]| face(&corners, [a, b, number])));
        // A sliver without a normal: what is known is as good as rounding allows.
        if faces.len() != before + added {
            break;
        }
    }
    let least = faces.iter().min_by(by_offset).map_or(0.0, |face| face.offset);
    // Of faces in one plane, the origin is above one.
    let level = faces.iter().filter(|face| face.offset <= least + EXACT).map(|face| {
        let chosen = face.corners.map(|k| corners[k]);
        (on_triangle(&chosen.map(|corner| corner.difference)), chosen)
    });
    let above = level.min_by(|a, b| a.0.point.norm_squared().total_cmp(&b.0.point.norm_squared()));
    let (Some((depth, normal)), Some((foot, chosen))) = (best, above) else {
        // Solids without a thickness.
        return Closest { distance: 0.0, normal: Vector3::z(), points: corners[0].points };
    };
    let points = [0, 1].map(|k| mean(&chosen, &foot.weights, k));
    // The difference's surface is at `normal * depth`: the first solid leaves the second against the normal.
    Closest { distance: -depth, normal: -normal, points }
}

/// Adds corners until they span a tetrahedron, where the solids have a thickness.
fn fill(support: &dyn Fn(&Vector3<f64>) -> Corner, corners: &mut Vec<Corner>) {
    corners.truncate(4);
    // How far the last corner is from the point, line or plane of the others: in it, it says nothing.
    let height = |corners: &[Corner]| {
        let at = |k: usize| corners[k].difference - corners[0].difference;
        match corners.len() {
            0 | 1 => f64::INFINITY,
            2 => at(1).norm(),
            3 => at(1).cross(&at(2)).norm() / at(1).norm(),
            _ => at(1).cross(&at(2)).normalize().dot(&at(3)).abs(),
        }
    };
    let mut spanning: Vec<Corner> = Vec::with_capacity(4);
    let try_corner = |corner: Corner, spanning: &mut Vec<Corner>| {
        spanning.push(corner);
        if height(spanning) < MEETING {
            spanning.pop();
        }
    };
    for corner in corners.drain(..) {
        try_corner(corner, &mut spanning);
    }
    while spanning.len() < 4 {
        let at = |k: usize| spanning[k].difference - spanning[0].difference;
        let directions: Vec<Vector3<f64>> = match spanning.len() {
            1 => vec![Vector3::x(), Vector3::y(), Vector3::z()],
            2 => {
                let along = at(1).normalize();
                let across = along.cross(&Vector3::ith(along.iamin(), 1.0)).normalize();
                vec![across, along.cross(&across)]
            }
            _ => vec![at(1).cross(&at(2)).normalize()],
        };
        let before = spanning.len();
        for direction in directions.iter().flat_map(|d| [*d, -d]) {
            if spanning.len() == before {
                try_corner(support(&direction), &mut spanning);
            }
        }
        if spanning.len() == before {
            break;
        }
    }
    *corners = spanning;
}

/// The better of a bound and that of the plane through `point`, the farthest against `direction`.
fn better(best: (f64, Vector3<f64>), direction: &Vector3<f64>, point: &Vector3<f64>) -> (f64, Vector3<f64>) {
    let bound = direction.dot(point);
    if bound > best.0 { (bound, *direction) } else { best }
}

/// The point of a simplex of one to four corners that is nearest to the origin; all four have a weight where the
/// origin is inside.
fn nearest_to_origin(simplex: &[Vector3<f64>]) -> Nearest {
    match *simplex {
        [a, b] => on_segment(&a, &b),
        [a, b, c] => on_triangle(&[a, b, c]),
        [a, b, c, d] => {
            let corners = [a, b, c, d];
            let faces = [([0, 1, 2], 3), ([0, 1, 3], 2), ([0, 2, 3], 1), ([1, 2, 3], 0)];
            let inside = faces.iter().all(|(face, opposite)| {
                let [p, q, r] = face.map(|k| corners[k]);
                let normal = (q - p).cross(&(r - p));
                // A flat tetrahedron has no inside.
                let height = normal.dot(&(corners[*opposite] - p));
                normal.dot(&-p) * height > 0.0 && height.abs() > FLAT * normal.norm()
            });
            if inside {
                return Nearest { point: Vector3::zeros(), weights: [0.25; 4] };
            }
            // Of a sliver rounding cannot tell the faces towards the origin from the others.
            let found = faces.map(|(face, _)| on_triangle(&face.map(|k| corners[k])).among(face));
            let nearer = |x: &Nearest, y: &Nearest| x.point.norm_squared().total_cmp(&y.point.norm_squared());
            found.into_iter().min_by(nearer).expect("a tetrahedron has faces")
        }
        _ => Nearest { point: simplex[0], weights: [1.0, 0.0, 0.0, 0.0] },
    }
}

impl Nearest {
    /// The same with the first corners numbered as in a larger simplex.
    fn among<const N: usize>(self, numbers: [usize; N]) -> Nearest {
        let mut weights = [0.0; 4];
        numbers.iter().zip(self.weights).for_each(|(&number, weight)| weights[number] = weight);
        Nearest { point: self.point, weights }
    }
}

fn on_segment(a: &Vector3<f64>, b: &Vector3<f64>) -> Nearest {
    let along = b - a;
    let share = -a.dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
    if share <= 0.0 {
        Nearest { point: *a, weights: [1.0, 0.0, 0.0, 0.0] }
    } else if share >= 1.0 {
        Nearest { point: *b, weights: [0.0, 1.0, 0.0, 0.0] }
    } else {
        Nearest { point: a + along * share, weights: [1.0 - share, share, 0.0, 0.0] }
    }
}

/// By the triangle's plane where the origin is above its inside, or else by its nearest side.
fn on_triangle(corners: &[Vector3<f64>; 3]) -> Nearest {
    let [a, b, c] = corners;
    let normal = (b - a).cross(&(c - a));
    // Twice the signed area between a side and the origin, by the length of the normal.
    let area = |p: &Vector3<f64>, q: &Vector3<f64>| (q - p).cross(&-p).dot(&normal);
    let areas = [area(b, c), area(c, a), area(a, b)];
    if normal.norm_squared() > 0.0 && areas.iter().all(|&area| area >= 0.0) {
        let point = normal * (normal.dot(a) / normal.norm_squared());
        let total: f64 = areas.iter().sum();
        // A corner whose side the origin is above keeps a trace of weight: the triangle is the face.
        let [u, v, w] = areas.map(|area| (area / total).max(f64::MIN_POSITIVE));
        return Nearest { point, weights: [u, v, w, 0.0] };
    }
    let sides = [[0, 1], [1, 2], [2, 0]];
    let found = sides.map(|side| on_segment(&corners[side[0]], &corners[side[1]]).among(side));
    let nearer = |x: &Nearest, y: &Nearest| x.point.norm_squared().total_cmp(&y.point.norm_squared());
    found.into_iter().min_by(nearer).expect("a triangle has sides")
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
    fn solids_are_as_far_apart_or_as_deep_as_directions_tell() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut random = |far: f64| Vector3::from_fn(|_, _| rng.random_range(-far..far));
        let (mut apart, mut deep) = (0, 0);
        for trial in 0..200 {
            let a = solid(trial % 5, random(0.01), random(3.0));
            let b = solid(trial / 5 % 5, random(0.3), random(3.0));
            let of_a = |d: &Vector3<f64>| a.support(d).unwrap();
            let of_b = |d: &Vector3<f64>| b.support(d).unwrap();
            let found = closest([&of_a, &of_b], &Vector3::x());
            let along = |n: &Vector3<f64>| n.dot(&(of_a(&-n) - of_b(n)));
            // The direction parts them as far as is said, and the points lie that far apart along it.
            assert!((found.normal.norm() - 1.0).abs() < 1e-12);
            assert!((along(&found.normal) - found.distance).abs() < 2e-9, "{trial}: {found:?}");
            let between = found.points[0] - found.points[1] - found.normal * found.distance;
            assert!(between.norm() < 1e-4, "{trial}: {} off, {found:?}", between.norm());
            for (solid, p) in [(&a, found.points[0]), (&b, found.points[1])] {
                assert!(solid.signed_distance(&p).unwrap().0.abs() < 1e-6, "{trial}: {found:?}");
            }
            let support = |d: &Vector3<f64>| of_a(d) - of_b(&-d);
            let searched = by_search(&support, &mut ChaCha8Rng::seed_from_u64(trial as u64));
            assert!(found.distance > searched - 1e-8, "{trial}: {} and {searched}", found.distance);
            apart += usize::from(found.distance > 0.0);
            deep += usize::from(found.distance < 0.0);
        }
        assert!(apart > 30 && deep > 30, "{apart} {deep}");
    }

    #[test]
    fn solids_that_touch_are_measured_as_those_a_little_apart() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut random = |far: f64| Vector3::from_fn(|_, _| rng.random_range(-far..far));
        for trial in 0..200 {
            let a = solid(trial % 5, random(0.01), random(3.0));
            let mut b = solid(trial / 5 % 5, random(0.1) + Vector3::x(), random(3.0));
            let measure = |b: &Surface| {
                closest([&|d| a.support(d).unwrap(), &|d| b.support(d).unwrap()], &Vector3::x())
            };
            let first = measure(&b);
            let far = first.normal * first.distance;
            for gap in [1e-3, 1e-5, 1e-6, 2e-7, 5e-8, 1e-9, 0.0, -1e-9, -1e-7, -1e-6, -1e-5, -1e-4] {
                let at = b.origin;
                b.origin += far - first.normal * gap;
                let found = measure(&b);
                // The direction parts them as far as is said. Sharp corners that are moved into each other
                // may leave each other sideways.
                let along = found
                    .normal
                    .dot(&(a.support(&-found.normal).unwrap() - b.support(&found.normal).unwrap()));
                b.origin = at;
                assert!((along - found.distance).abs() < 3e-9, "{trial}: {along} for {gap}");
                let least = if gap < MEETING { gap.min(0.0) } else { gap };
                assert!(found.distance > least - 3e-9, "{trial}: {} for {gap}", found.distance);
                if gap > MEETING {
                    assert!(found.distance < gap + 3e-9, "{trial}: {} for {gap}", found.distance);
                }
                // What a direction away from that of two corners loses is of second order.
                let turned = (found.normal - first.normal).norm();
                let unclear = (1e-8 / gap.max(1e-12)).sqrt().max(0.02);
                assert!(gap <= MEETING || turned < unclear, "{trial}: {turned} at {gap}");
            }
        }
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
