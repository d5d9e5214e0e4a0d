//! What learning from the touches of Max's torso costs.

mod max;

use std::hint::black_box;
use std::time::Duration;

use bodyschema::agent::Agent;
use bodyschema::babbling::Babbler;
use bodyschema::creature::Creature;
use bodyschema::deadline::Deadline;
use bodyschema::ground_truth::GroundTruth;
use bodyschema::learning::initial_guess::{random_direction, random_guess};
use bodyschema::learning::least_squares::{Stopping, levenberg_marquardt};
use bodyschema::learning::observation::{Observation, ObservationModel, PointsMeet};
use bodyschema::learning::surface_gap::SurfaceGap;
use bodyschema::learning::touch_set::{LimbTouch, TouchProblem, TouchSet};
use bodyschema::learning::{AxisModel, Hersch, Input, Learner, Parameters, SecondOrder};
use bodyschema::schema::BodySchema;
use bodyschema::senses::RecordedTouch;
use bodyschema::simulation::{MotionName, Movers};
use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use nalgebra::Matrix3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The most touches that any benchmark here uses.
const MOST_TOUCHES: usize = 10_000;
/// How far from the truth the schema of an iteration is: metres for positions, radians for axes.
const DISPLACEMENT: f64 = 5e-3;
/// Deviation of a contact point, metres.
const CONTACT_DEVIATION: f64 = 1e-4;
/// Deviation of the surfaces' gap half-way through annealing, metres.
const GAP_DEVIATION: f64 = 1e-3;
/// One linearization, and the damped steps until one is accepted.
const ONE_ITERATION: Stopping =
    Stopping { iterations: 1, relative_cost: 0.0, cost: 0.0, deadline: Deadline::Never };

/// Touches of exact points on `creature`, made ready for a solver.
fn prepare(agent: &Agent, touches: &[RecordedTouch]) -> TouchSet {
    let prepared = touches.iter().map(|touch| {
        let limbs = touch.limbs(agent.skin());
        let ends = [0, 1].map(|k| Observation {
            receptor: touch.ends[k].receptor,
            position: touch.exact_contact().points[k],
            covariance: Matrix3::identity() * CONTACT_DEVIATION.powi(2),
        });
        LimbTouch { limbs, posture: &touch.posture, ends }
    });
    TouchSet::new(agent.creature(), prepared)
}

/// The truth, moved a little: where an iteration has work to do and its step is accepted.
fn displaced(truth: &BodySchema) -> BodySchema {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut schema = truth.clone();
    for v in schema.positions.iter_mut().chain(&mut schema.axes) {
        *v += random_direction(&mut rng) * rng.random_range(0.0..DISPLACEMENT);
    }
    schema.axes.iter_mut().for_each(|axis| *axis = axis.normalize());
    schema
}

fn learning(criterion: &mut Criterion) {
    let (body, agent) = max::torso();
    let creature = &body.creature;
    let babbler = Babbler::new(Movers::new(&body, &agent, MotionName::Kinematic).expect("Max can babble"));
    let (touches, _) = max::babble(&babbler, MOST_TOUCHES);
    let truth = GroundTruth::new(&body).expect("the engine computes poses").schema;

    let initial_guess = random_guess(creature, &mut ChaCha8Rng::seed_from_u64(1));
    let mut hersch = Hersch::new(&agent, Input::Receptor, initial_guess);
    let mut rounds = touches.iter().cycle();
    criterion.bench_function("Hersch update, both directions of a touch", |bencher| {
        bencher.iter(|| hersch.touch(rounds.next().expect("the cycle has no end")));
    });

    let start = displaced(&truth);
    for count in [1_000, 10_000] {
        let set = prepare(&agent, &touches[..count]);
        let gap = SurfaceGap { skin: agent.skin(), gap_deviation: GAP_DEVIATION, patch_deviation: 1.0 };
        lm_iteration(
            criterion,
            creature,
            &set,
            &start,
            PointsMeet::Shaped,
            &format!("points, {count} touches"),
        );
        lm_iteration(criterion, creature, &set, &start, gap, &format!("surface gap, {count} touches"));
    }

    let mut group = criterion.benchmark_group("lm");
    group.sample_size(10).measurement_time(Duration::from_secs(10));
    group.bench_function("learned from 500 contact touches", |bencher| {
        let learner = || {
            let mut learner = SecondOrder::new(&agent, Input::Contact, 1);
            touches[..500].iter().for_each(|touch| learner.touch(&touch.felt(Input::Contact)));
            learner
        };
        bencher.iter_batched(learner, |mut learner| black_box(learner.learn()), BatchSize::PerIteration);
    });
    group.finish();
}

/// One Levenberg-Marquardt iteration over all 132 parameters: linearization, damped step, new cost.
fn lm_iteration(
    criterion: &mut Criterion,
    creature: &Creature,
    touches: &TouchSet,
    start: &BodySchema,
    model: impl ObservationModel + Copy,
    name: &str,
) {
    let parameters = Parameters::new(creature, AxisModel::Unit, |_| true);
    let mut problem = TouchProblem::new(creature, touches, &parameters, model);
    let mut group = criterion.benchmark_group("lm iteration");
    group.sample_size(20);
    group.bench_function(name, |bencher| {
        let initial_guess = || start.clone();
        let iterate = |initial_guess| levenberg_marquardt(&mut problem, initial_guess, ONE_ITERATION);
        bencher.iter_batched(initial_guess, iterate, BatchSize::SmallInput);
    });
    group.finish();
}

criterion_group!(benches, learning);
criterion_main!(benches);
