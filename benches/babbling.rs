//! What a posture check and a touch cost on Max's torso, on one thread.

mod max;

use std::hint::black_box;
use std::time::Duration;

use bodyschema::babbling::Babbler;
use bodyschema::creature::Posture;
use bodyschema::mujoco::Data;
use bodyschema::simulation::{MotionName, Movers};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Touches babbled at a time.
const TOUCHES: usize = 2_000;
/// Postures that the check goes round.
const POSTURES: usize = 1_000;

/// One posture: kinematics, then collision, both by the engine.
fn posture_check(criterion: &mut Criterion) {
    let (body, _) = max::torso();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let posture = |_| body.qpos(&Posture::random(&body.creature, &mut rng));
    let postures: Vec<Vec<f64>> = (0..POSTURES).map(posture).collect();
    let mut data = Data::new(body.model.clone()).expect("there is memory for one posture");
    let mut postures = postures.iter().cycle();
    criterion.bench_function("posture check", |bencher| {
        bencher.iter(|| {
            data.set_qpos(postures.next().expect("the cycle has no end")).expect("the posture fits");
            data.kinematics().expect("the engine computes poses");
            data.collision().expect("the engine finds contacts");
            black_box(data.contacts().count())
        });
    });
}

/// From a motion to a touch, per touch.
fn touch(criterion: &mut Criterion) {
    let (body, agent) = max::torso();
    let babbler = Babbler::new(Movers::new(&body, &agent, MotionName::Kinematic).expect("Max can babble"));
    let (_, effort) = max::babble(&babbler, TOUCHES);
    let per_touch = |count: u64| count as f64 / TOUCHES as f64;
    println!(
        "each of {TOUCHES} touches took {:.1} motions, {:.1} posture checks by the engine and {:.0} looks \
         at the gap of two limbs",
        per_touch(effort.motions),
        per_touch(effort.engine_checks),
        per_touch(effort.gap_checks)
    );
    let mut group = criterion.benchmark_group("touch");
    group.throughput(Throughput::Elements(TOUCHES as u64));
    group.sample_size(10).measurement_time(Duration::from_secs(15));
    group.bench_function(format!("{TOUCHES} on one thread"), |bencher| {
        bencher.iter(|| max::babble(&babbler, TOUCHES));
    });
    group.finish();
}

criterion_group!(benches, posture_check, touch);
criterion_main!(benches);
