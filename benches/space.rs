//! What the reachable space costs: a map of Max's left hand, a question to it, and a posture that reaches for a point.

mod max;

use std::hint::black_box;
use std::time::Duration;

use bodyschema::ground_truth::GroundTruth;
use bodyschema::learning::Certainty;
use bodyschema::peripersonal::{OwnBody, ReachableMap};
use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Side of the voxels, metres.
const VOXEL: f64 = 0.02;
/// Points that are gone round.
const POINTS: usize = 10_000;

fn space(criterion: &mut Criterion) {
    let (body, agent) = max::torso();
    let schema = GroundTruth::new(&body).expect("Max has joints").schema;
    let own = OwnBody::new(&agent, schema, Certainty::Exact, &[]);
    let hand = own.creature().limb("left_hand").expect("Max has hands");
    let chest = own.carrier_of(&[hand]);
    let build = || ReachableMap::new(&own, hand, chest, VOXEL).expect("a hand has skin");
    let mut group = criterion.benchmark_group("space");
    group.sample_size(10).measurement_time(Duration::from_secs(30));
    group.bench_function("map of a hand, 2 cm", |bencher| bencher.iter(|| black_box(build())));
    group.finish();
    let map = build();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let low = map.lattice().middle(map.lattice().first);
    let size = Vector3::from(map.lattice().counts.map(|count| count as f64 * VOXEL));
    let points: Vec<Vector3<f64>> = (0..POINTS)
        .map(|_| low + size.component_mul(&Vector3::from_fn(|_, _| rng.random_range(-0.1..1.1))))
        .collect();
    let mut next = points.iter().cycle();
    criterion.bench_function("query: level, distance out of reach, posture", |bencher| {
        bencher.iter(|| {
            let point = next.next().expect("the cycle has no end");
            black_box(map.whereabouts(point))
        });
    });
    let cells: Vec<[i32; 3]> = map.voxels().map(|(cell, _)| cell).step_by(37).collect();
    let mut cells = cells.iter().cycle();
    criterion.bench_function("a posture that reaches for a point", |bencher| {
        bencher.iter(|| {
            let cell = cells.next().expect("the cycle has no end");
            black_box(map.reach(&map.lattice().middle(*cell)))
        });
    });
}

criterion_group!(benches, space);
criterion_main!(benches);
