//! What a step of acting costs: a quadratic program over all joints of Max's torso that has a hand go somewhere and joints
//! get out of the way, with barriers between limbs that are near each other and to a thing that comes.

mod max;

use std::hint::black_box;

use bodyschema::ground_truth::GroundTruth;
use bodyschema::learning::Certainty;
use bodyschema::peripersonal::{Barrier, CollisionChecker, OwnBody, PlaceVelocity, VelocityProgram};
use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Postures that are gone round.
const POSTURES: usize = 50;
/// Limbs nearer than this to each other have barriers, metres.
const NEAR: f64 = 0.06;
/// The fastest that joints turn, radians a second, and the length of a step, seconds.
const FASTEST: f64 = 3.0;
const STEP: f64 = 1e-3;

fn acting(criterion: &mut Criterion) {
    let (body, agent) = max::torso();
    let schema = GroundTruth::new(&body).expect("Max has joints").schema;
    let own = OwnBody::new(&agent, schema, Certainty::Exact, &[]);
    let clearance = CollisionChecker::new(&own);
    let joints: Vec<usize> = (0..own.creature().joints().len()).collect();
    let hand = own.creature().limb("left_hand").expect("Max has hands");
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let at_ease = own.at_ease();
    let postures: Vec<_> =
        (0..POSTURES).map(|_| own.posture_near(&at_ease, &joints, 0.5, &mut rng)).collect();
    // Joints want to turn as fast as they may, so that ranges, speeds and barriers all count.
    let wanted: Vec<f64> = at_ease.iter().map(|_| rng.random_range(-4.0..4.0)).collect();
    let solve = |posture: &[f64], along: bool| {
        let frames = own.frames(posture);
        let mut program = VelocityProgram::new(&own, posture, &frames, &joints, FASTEST, STEP);
        if along {
            wanted.iter().enumerate().for_each(|(q, velocity)| program.want_joint(q, *velocity, 1.0));
        }
        let point = frames[hand].origin;
        program.want(&PlaceVelocity {
            limb: hand,
            point,
            velocity: Vector3::new(0.1, 0.0, 0.1),
            weight: 100.0,
        });
        for near in clearance.near(&frames, NEAR) {
            let rate = (-30.0 * (near.gap.distance - 0.01)).min(0.0);
            program.keep(&Barrier {
                limb: near.limb,
                other: near.other,
                points: near.gap.points,
                normal: near.gap.normal,
                rate,
                yields: false,
            });
        }
        let (normal, rate) = (-Vector3::x(), 0.3);
        program.keep(&Barrier { limb: hand, other: None, points: [point; 2], normal, rate, yields: true });
        program.solve()
    };
    let mut group = criterion.benchmark_group("acting");
    for (name, along) in
        [("a hand's way and a thing that comes", false), ("all joints at their fastest as well", true)]
    {
        let mut next = postures.iter().cycle();
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                let posture = next.next().expect("the cycle has no end");
                black_box(solve(posture, along))
            });
        });
    }
    group.finish();
}

criterion_group!(benches, acting);
criterion_main!(benches);
