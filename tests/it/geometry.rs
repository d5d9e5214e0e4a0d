//! The one gap, over all pairs of shapes: against search, sampling and the engine, and by what any gap must be.

use std::sync::Arc;

use bodyschema::geometry::{
    Capsule, ConvexBody, Frame, Gap, Hull, PlacedShape, Precision, Shape, closest_points, gap, gap_from,
};
use bodyschema::mujoco::{Data, Model};
use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// How exact a gap is, metres: two solutions of an algorithm that stops within 1 nm.
const EXACT: f64 = 5e-9;
/// How exact the engine's contacts are, metres.
const ENGINE: f64 = 5e-6;

const KINDS: usize = 6;

fn shape(kind: usize) -> Shape {
    let corners = [[0.3, 0.0, 0.0], [-0.1, 0.2, 0.0], [0.0, -0.2, 0.1], [0.0, 0.1, 0.3]];
    let faces = vec![[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];
    match kind {
        0 => Shape::Sphere { radius: 0.15 },
        1 => Shape::Capsule { radius: 0.1, half_length: 0.2 },
        2 => Shape::Ellipsoid { semi_axes: [0.1, 0.2, 0.05] },
        3 => Shape::Cylinder { radius: 0.1, half_length: 0.2 },
        4 => Shape::Box { half_extents: [0.1, 0.2, 0.05] },
        _ => Shape::Hull(Hull::new(corners.map(Vector3::from).to_vec(), faces).unwrap()),
    }
}

fn vector(rng: &mut ChaCha8Rng, far: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| rng.random_range(-far..far))
}

/// A frame at random, up to so many metres from the origin along each axis.
fn frame(rng: &mut ChaCha8Rng, far: f64) -> Frame {
    Frame { rotation: Rotation3::new(vector(rng, 3.0)).into_inner(), origin: vector(rng, far) }
}

/// A shape and its pose.
#[derive(Clone)]
struct Solid {
    shape: Shape,
    pose: Frame,
}

impl Solid {
    fn placed(&self) -> PlacedShape<'_> {
        PlacedShape::new(&self.shape, Frame::identity(), self.pose).unwrap()
    }

    fn moved(&self, by: &Vector3<f64>) -> Solid {
        let mut moved = self.clone();
        moved.pose.origin += by;
        moved
    }
}

fn exact(a: &Solid, b: &Solid) -> Gap {
    gap(&a.placed(), &b.placed(), Precision::Exact)
}

/// All pairs of kinds of shapes, each at random poses, and a number.
fn pairs(seed: u64, far: f64) -> impl Iterator<Item = (usize, Solid, Solid)> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..6 * KINDS * KINDS).map(move |trial| {
        let mut solid = |kind: usize, far: f64| Solid { shape: shape(kind), pose: frame(&mut rng, far) };
        (trial, solid(trial % KINDS, 0.01), solid(trial / KINDS % KINDS, far))
    })
}

/// The same, moved so that they are apart by `distance`, metres.
fn parted(seed: u64, distance: f64) -> impl Iterator<Item = (usize, Solid, Solid)> {
    pairs(seed, 0.1).map(move |(trial, a, b)| {
        let b = b.moved(&Vector3::new(1.0, 0.3, -0.2));
        let found = exact(&a, &b);
        let b = b.moved(&(found.normal * (found.distance - distance)));
        (trial, a, b)
    })
}

/// How far apart the planes across a unit normal, from the second to the first, hold two bodies.
fn along(a: &Solid, b: &Solid, n: &Vector3<f64>) -> f64 {
    n.dot(&(a.placed().support(&-n) - b.placed().support(n)))
}

/// The distance along the best of many directions, each refined: slow, and never above the truth.
fn by_search(a: &Solid, b: &Solid, seed: u64) -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let directions: Vec<Vector3<f64>> = (0..300).map(|_| vector(&mut rng, 1.0).normalize()).collect();
    let first = directions.iter().max_by(|m, n| along(a, b, m).total_cmp(&along(a, b, n))).unwrap();
    let (mut best, mut most) = (*first, along(a, b, first));
    for step in 0..2000 {
        let trial = (best + vector(&mut rng, 0.3) * 0.99f64.powi(step / 2)).normalize();
        let found = along(a, b, &trial);
        if found > most {
            (best, most) = (trial, found);
        }
    }
    most
}

#[test]
fn a_gap_is_as_wide_or_as_deep_as_directions_and_points_tell() {
    let (mut apart, mut deep) = (0, 0);
    for (trial, a, b) in pairs(4, 0.3) {
        let found = exact(&a, &b);
        assert!((found.normal.norm() - 1.0).abs() < 1e-12);
        let between = found.points[0] - found.points[1] - found.normal * found.distance;
        assert!(between.norm() < 1e-4, "{trial}: {} off, {found:?}", between.norm());
        let searched = by_search(&a, &b, trial as u64);
        // A capsule whose segment is in the other is as deep as its deepest point: it may have farther to go.
        let radii = [&a, &b].map(|solid| solid.placed().as_capsule().map_or(f64::INFINITY, |c| c.radius));
        if found.distance > -radii[0].min(radii[1]) {
            for (solid, p) in [(&a, found.points[0]), (&b, found.points[1])] {
                assert!(solid.placed().signed_distance(&p).0.abs() < 1e-6, "{trial}: {found:?}");
            }
            assert!((along(&a, &b, &found.normal) - found.distance).abs() < EXACT, "{trial}: {found:?}");
        }
        assert!(found.distance > searched - 1e-8, "{trial}: {} and {searched}", found.distance);
        // No point of one is nearer to the other.
        let samples = a.shape.samples(1e-4);
        let nearest = samples.iter().map(|(p, _)| b.placed().signed_distance(&a.pose.point(p)).0);
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        if found.distance > 0.0 {
            assert!(nearest > found.distance - EXACT, "{trial}: {nearest} and {}", found.distance);
            assert!(nearest < found.distance + 0.02, "{trial}: {nearest} and {}", found.distance);
        }
        apart += usize::from(found.distance > 0.0);
        deep += usize::from(found.distance < 0.0);
    }
    assert!(apart > 40 && deep > 40, "{apart} {deep}");
}

#[test]
fn a_gap_does_not_depend_on_which_body_comes_first_nor_on_where_both_are() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for (trial, a, b) in pairs(5, 0.4) {
        let found = exact(&a, &b);
        let exchanged = exact(&b, &a).reversed();
        let motion = frame(&mut rng, 2.0);
        let carried = |solid: &Solid| Solid { shape: solid.shape.clone(), pose: motion * solid.pose };
        let carried = exact(&carried(&a), &carried(&b));
        for other in [exchanged.distance, carried.distance] {
            assert!((other - found.distance).abs() < EXACT, "{trial}: {other} for {found:?}");
        }
        // Of bodies in each other, several normals may be as good.
        if found.distance > 1e-3 {
            assert!((exchanged.normal - found.normal).norm() < 1e-3, "{trial}: {exchanged:?} for {found:?}");
            let turned = motion.rotation.tr_mul(&carried.normal);
            assert!((turned - found.normal).norm() < 1e-3, "{trial}: {turned} for {found:?}");
        }
        // Nor on what is guessed first.
        let guess = vector(&mut rng, 1.0).normalize();
        let guessed = gap_from(&a.placed(), &b.placed(), Precision::Exact, &guess);
        assert!((guessed.distance - found.distance).abs() < EXACT, "{trial}: {guessed:?} for {found:?}");
    }
}

#[test]
fn the_normal_is_the_gradient_of_the_gap() {
    for (trial, a, b) in parted(6, 0.05) {
        let found = exact(&a, &b);
        const STEP: f64 = 1e-5;
        for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
            let [less, more] = [-STEP, STEP].map(|step| exact(&a.moved(&(axis * step)), &b).distance);
            let slope = (more - less) / (2.0 * STEP);
            assert!((slope - found.normal.dot(&axis)).abs() < 1e-3, "{trial}: {slope} for {found:?}");
        }
    }
}

#[test]
fn bodies_moved_by_their_gap_are_in_contact_and_no_gap_jumps_there() {
    for (trial, a, b) in parted(7, 0.1) {
        let first = exact(&a, &b);
        for wanted in [1e-3, 1e-5, 1e-6, 2e-7, 5e-8, 1e-9, 0.0, -1e-9, -1e-7, -1e-6, -1e-5, -1e-4] {
            let b = b.moved(&(first.normal * (first.distance - wanted)));
            let found = exact(&a, &b);
            // Sharp corners that are moved into each other may leave each other sideways.
            let least = if wanted < 1e-7 { f64::min(wanted, 0.0) } else { wanted };
            assert!(found.distance > least - EXACT, "{trial}: {} for {wanted}", found.distance);
            if wanted > 1e-7 {
                assert!(found.distance < wanted + EXACT, "{trial}: {} for {wanted}", found.distance);
                // What a direction away from that of two corners loses is of second order.
                let turned = (found.normal - first.normal).norm();
                assert!(turned < (1e-8 / wanted).sqrt().max(0.02), "{trial}: {turned} at {wanted}");
            } else {
                let most = 1e-7 + 0.5 * f64::abs(wanted);
                assert!(found.distance < most, "{trial}: {} for {wanted}", found.distance);
            }
        }
    }
}

#[test]
fn a_lower_bound_is_near_the_gap_and_never_beyond_it() {
    let mut apart = 0;
    for (trial, a, b) in pairs(8, 0.5) {
        let (found, bound) = (exact(&a, &b), gap(&a.placed(), &b.placed(), Precision::LowerBound));
        assert!((bound.normal.norm() - 1.0).abs() < 1e-12);
        if found.distance > 0.0 {
            apart += 1;
            assert!(bound.distance < found.distance + EXACT, "{trial}: {bound:?} of {found:?}");
            assert!(bound.distance > 0.949 * found.distance, "{trial}: {bound:?} of {found:?}");
            // What a direction separates is true whoever finds it.
            assert!((along(&a, &b, &bound.normal) - bound.distance).abs() < 1e-12, "{trial}: {bound:?}");
        } else {
            assert!(bound.distance <= 1e-6, "{trial}: {bound:?} though they meet");
        }
    }
    assert!(apart > 40, "{apart}");
}

#[test]
fn the_gap_of_round_bodies_is_that_of_their_centres_and_radii() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for wanted in [-1e-3, -1e-4, 0.0, 1e-6, 1e-4, 1e-3, 0.01] {
        let direction = vector(&mut rng, 1.0).normalize();
        let pose = Frame { origin: direction * (0.08 + wanted), ..frame(&mut rng, 0.1) };
        let ball = Solid { shape: Shape::Sphere { radius: 0.03 }, pose };
        let around = Frame { origin: Vector3::zeros(), ..frame(&mut rng, 0.1) };
        for shape in [Shape::Ellipsoid { semi_axes: [0.05; 3] }, Shape::Sphere { radius: 0.05 }] {
            let found = exact(&ball, &Solid { shape, pose: around });
            assert!((found.distance - wanted).abs() < 1e-8, "{} in place of {wanted}", found.distance);
            assert!((found.normal - direction).norm() < 1e-9);
            let middle = direction * (0.05 + 0.5 * wanted);
            assert!((found.middle() - middle).norm() < 1e-8);
        }
    }
}

#[test]
fn a_capsule_is_as_near_as_the_nearest_point_of_its_segment() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for kind in 0..KINDS {
        for _ in 0..20 {
            let solid = Solid { shape: shape(kind), pose: frame(&mut rng, 0.1) };
            let capsule = Capsule { ends: [0, 1].map(|_| vector(&mut rng, 0.6)), radius: 0.02 };
            let found = gap(&capsule, &solid.placed(), Precision::Exact);
            let along = |k: usize| capsule.ends[0].lerp(&capsule.ends[1], k as f64 / 1000.0);
            let sampled = (0..=1000).map(|k| solid.placed().signed_distance(&along(k)).0 - capsule.radius);
            let least = sampled.fold(f64::INFINITY, f64::min);
            assert!(found.distance <= least + 1e-9 && found.distance > least - 2e-3, "{found:?} and {least}");
        }
    }
}

#[test]
fn the_closest_points_of_segments_are_closer_than_any_others() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    for trial in 0..300 {
        // Some are points, some parallel, some cross.
        let along = vector(&mut rng, 1.0);
        let mut segment = |k: usize| {
            let start = vector(&mut rng, 1.0);
            let to = [vector(&mut rng, 1.0), Vector3::zeros(), along][(trial / 3usize.pow(k as u32)) % 3];
            [start, start + to]
        };
        let (a, b) = (segment(0), segment(1));
        let [p, q] = closest_points(&a, &b);
        let sampled = (0..=40).flat_map(|i| (0..=40).map(move |j| [i, j].map(|k| f64::from(k) / 40.0)));
        let least = sampled.map(|[s, t]| (a[0].lerp(&a[1], s) - b[0].lerp(&b[1], t)).norm());
        let least = least.fold(f64::INFINITY, f64::min);
        assert!((p - q).norm() <= least + 1e-12, "{trial}: {} and {least}", (p - q).norm());
        for (point, ends) in [(p, a), (q, b)] {
            let [s, t] = [0, 1].map(|k| (point - ends[k]).norm());
            assert!(
                (s + t - (ends[1] - ends[0]).norm()).abs() < 1e-12,
                "{trial}: {point} is not on {ends:?}"
            );
        }
    }
}

#[test]
fn bounding_volumes_hold_all_of_a_shape() {
    let mut rng = ChaCha8Rng::seed_from_u64(10);
    for kind in 0..KINDS {
        let shape = shape(kind);
        let (capsule, ball) = (shape.bounding_capsule().unwrap(), shape.bounding_radius());
        let farthest: Vec<Vector3<f64>> =
            (0..500).map(|_| shape.support(&vector(&mut rng, 1.0)).unwrap()).collect();
        let about = Capsule::about_points(&farthest).unwrap();
        for p in &farthest {
            for capsule in [&capsule, &about] {
                assert!(capsule.signed_distance(p).0 < 1e-9, "{shape:?}: {p} is outside of {capsule:?}");
            }
            assert!(
                p.norm() < ball + 1e-9 && p.abs() <= shape.half_bounds().add_scalar(1e-9),
                "{shape:?}: {p}"
            );
        }
    }
}

/// The engine finds contacts of two shapes as soon as their gap closes: there, of all it tells, it is right.
#[test]
fn the_engine_finds_a_contact_where_a_gap_has_closed_and_none_before() {
    let geom = |name: &str, kind: usize| {
        let (of_type, size) = shape(kind).mjcf().unwrap();
        let numbers: Vec<String> = size.iter().map(f64::to_string).collect();
        let rest = match shape(kind).hull() {
            Some(_) => "mesh=\"hull\"".to_string(),
            None => format!("size=\"{}\"", numbers.join(" ")),
        };
        format!("<body name=\"{name}\"><freejoint/><geom type=\"{of_type}\" {rest} mass=\"1\"/></body>")
    };
    let vertices: Vec<String> =
        shape(5).hull().unwrap().vertices().iter().flatten().map(f64::to_string).collect();
    let mut data: Vec<Data> = Vec::new();
    for pair in 0..KINDS * KINDS {
        let xml = format!(
            "<mujoco><asset><mesh name=\"hull\" vertex=\"{}\"/></asset><worldbody>{}{}</worldbody></mujoco>",
            vertices.join(" "),
            geom("a", pair % KINDS),
            geom("b", pair / KINDS)
        );
        data.push(Data::new(Arc::new(Model::from_xml(&xml).unwrap())).unwrap());
    }
    let mut compared = 0;
    for (trial, a, b) in parted(11, 0.05) {
        let first = exact(&a, &b);
        // It judges cylinders by an algorithm that is less exact.
        let cylinder = [&a, &b].iter().any(|solid| matches!(solid.shape, Shape::Cylinder { .. }));
        let near = if cylinder { 1e-3 } else { ENGINE };
        for (wanted, meets) in [(near, false), (-near, true)] {
            let b = b.moved(&(first.normal * (first.distance - wanted)));
            // Moved into each other, sharp corners may leave each other sideways.
            if meets && exact(&a, &b).distance > -0.9 * near {
                continue;
            }
            let coordinates = |solid: &Solid| {
                let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(
                    solid.pose.rotation,
                ));
                let p = solid.pose.origin;
                [p.x, p.y, p.z, turn.w, turn.i, turn.j, turn.k]
            };
            let data = &mut data[trial % (KINDS * KINDS)];
            data.set_qpos(&[coordinates(&a), coordinates(&b)].concat()).unwrap();
            data.kinematics().unwrap();
            data.collision().unwrap();
            let found = data.contacts().next().is_some();
            assert_eq!(found, meets, "{trial}: {:?} and {:?} at {wanted}", a.shape, b.shape);
            compared += 1;
        }
    }
    assert!(compared > 300, "{compared}");
}
