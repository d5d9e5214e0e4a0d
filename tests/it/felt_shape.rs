//! The shape of a thing from simulated touches of a fingertip.

use bodyschema::geometry::{Frame, PlacedShape, Precision, Shape, gap};
use bodyschema::peripersonal::{FeltShape, PlacedSkin, ShapeEstimate};
use bodyschema::skin::Surface;
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn thing(kind: usize, rng: &mut ChaCha8Rng) -> (Shape, Rotation3<f64>) {
    let yaw = Rotation3::from_axis_angle(&Vector3::z_axis(), rng.random_range(0.0..3.0));
    let lying = yaw * Rotation3::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2);
    let mut size = |low: f64, high: f64| rng.random_range(low..high);
    let (a, b, c) = (size(0.015, 0.06), size(0.015, 0.06), size(0.015, 0.075));
    match kind {
        0 => (Shape::Box { half_extents: [a, b, c] }, yaw),
        1 => (Shape::Cylinder { radius: a, half_length: c }, yaw),
        2 => (Shape::Capsule { radius: 0.5 * a + 0.01, half_length: b }, lying),
        _ => (Shape::Ellipsoid { semi_axes: [a, b, c] }, yaw),
    }
}

/// The share of the union of both that is in both.
fn agreement(estimate: &ShapeEstimate, shape: &Shape, pose: &Frame, rng: &mut ChaCha8Rng) -> f64 {
    let (mut both, mut any) = (0, 0);
    let reach = 1.3 * shape.bounding_radius();
    for _ in 0..20_000 {
        let p = pose.origin + Vector3::from_fn(|_, _| rng.random_range(-reach..reach));
        let truly = shape.holds(&pose.inverse_point(&p), 0.0);
        let taken = estimate.holds(&p);
        both += usize::from(truly && taken);
        any += usize::from(truly || taken);
    }
    both as f64 / any.max(1) as f64
}

#[test]
fn a_shape_is_known_from_fifteen_touches() {
    let mut shares = Vec::new();
    for seed in 0..4 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (shape, rotation) = thing(seed as usize, &mut rng);
        let up = Vector3::z();
        let low = rotation * shape.support(&(rotation.inverse() * -up)).unwrap();
        let pose = Frame { rotation: rotation.into_inner(), origin: Vector3::new(0.4, 0.1, 0.2 - low.z) };
        let truth = PlacedShape::new(&shape, Frame::identity(), pose).unwrap();
        let about = pose.origin + Vector3::from_fn(|_, _| rng.random_range(-0.015..0.015));
        let mut felt = FeltShape::new(about, up, Some(0.2));
        let finger = Surface {
            limb: 1,
            origin: Vector3::zeros(),
            rotation: Matrix3::identity(),
            shape: Shape::Capsule { radius: 0.008, half_length: 0.012 },
            geom: 0,
        };
        let candidates: Vec<Vector3<f64>> = (0..60)
            .map(|k| {
                let z = 1.0 - 1.2 * (f64::from(k) + 0.5) / 60.0;
                let angle = 2.4 * f64::from(k);
                let across = (1.0 - z * z).sqrt();
                Vector3::new(across * angle.cos(), across * angle.sin(), z)
            })
            .collect();
        let mut estimate: Option<ShapeEstimate> = None;
        let mut used: Vec<Vector3<f64>> = Vec::new();
        for _ in 0..15 {
            let score = |u: &Vector3<f64>| match &estimate {
                Some(estimate) => {
                    estimate.doubt(u) - 0.002 * used.iter().filter(|v| v.dot(u) > 0.999).count() as f64
                }
                None => -u.x,
            };
            let u = *candidates.iter().max_by(|a, b| score(a).total_cmp(&score(b))).unwrap();
            used.push(u);
            let p = match &estimate {
                Some(estimate) => estimate.middle(),
                None => about,
            };
            let p = Vector3::new(p.x, p.y, p.z.max(0.215));
            let turn = Rotation3::rotation_between(&Vector3::z(), &u).unwrap_or_else(Rotation3::identity);
            let at = |far: f64| Frame { rotation: turn.into_inner(), origin: p + u * (far + 0.02) };
            let mut far = 0.18;
            let mut touched = false;
            while far > -0.1 {
                let placed = finger.placed(&at(far)).unwrap();
                let distance = gap(&placed, &truth, Precision::Exact).distance;
                if distance < 2e-4 {
                    touched = true;
                    break;
                }
                if at(far).origin.z < 0.205 + 0.008 && u.z > 0.0 {
                    break;
                }
                far -= distance.max(1e-4);
            }
            for back in [0.002, 0.01, 0.02, 0.04, 0.06] {
                felt.is_clear_of(PlacedSkin::new(&finger, &at(far + back)).unwrap());
            }
            if touched {
                felt.touches(PlacedSkin::new(&finger, &at(far)).unwrap());
            }
            if let Some(next) = felt.estimate() {
                estimate = Some(next);
            }
        }
        let estimate = estimate.unwrap();
        let share = agreement(&estimate, &shape, &pose, &mut rng);
        shares.push(share);
        // Sizes are claimed in talk: within what is said of them, and a centimetre.
        let size = estimate.size(&up);
        let support = |u: Vector3<f64>| shape.support(&(rotation.inverse() * u)).unwrap();
        let width = |u: Vector3<f64>| {
            let along = rotation.inverse() * u;
            along.dot(&support(u)) - along.dot(&support(-u))
        };
        let narrow = (0..90)
            .map(|k| (std::f64::consts::PI * f64::from(k) / 90.0).sin_cos())
            .map(|(sin, cos)| width(Vector3::new(cos, sin, 0.0)))
            .fold(f64::INFINITY, f64::min);
        for (felt, truly) in [(size.height, width(up)), (size.breadth, narrow)] {
            let off = (felt.length - truly).abs();
            assert!(off < 0.01 + 2.0 * felt.deviation, "{seed}: {felt:?}, truly {truly}");
        }
    }
    shares.sort_by(f64::total_cmp);
    assert!(shares[0] > 0.75 && shares[1] + shares[2] > 2.0 * 0.85, "intersections over unions {shares:?}");
}
