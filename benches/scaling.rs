//! How learning grows with the number of touches: a table at 1,000, 10,000 and 100,000, on one thread.
//!
//! - *global fit*: all touches at once, from a schema whose joints are all up to 5 mm and 0.3° off, to the
//!   optimum (surfaces under the receptors, as by default);
//! - *update*: what the filter takes to predict a touch and learn from it, the mean over all touches;
//! - *stream*: all touches one by one into the default learner from a random initial guess, lock-in, prediction,
//!   updates and repeated fits included, and the conclusion. Not for all 57 joints, which receptors do not
//!   lock in (see the README).
//!
//! `cargo bench --bench scaling`; `-- 10000` leaves out what is longer.

mod max;

use std::time::Instant;

use bodyschema::babbling::Babbler;
use bodyschema::creature::Creature;
use bodyschema::evaluation::evaluate;
use bodyschema::ground_truth::GroundTruth;
use bodyschema::learning::initial_guess::random_direction;
use bodyschema::learning::least_squares::LeastSquares;
use bodyschema::learning::online::Belief;
use bodyschema::learning::surface_gap::SurfaceGap;
use bodyschema::learning::touch_set::{TouchProblem, TouchSet};
use bodyschema::learning::{AxisModel, Input, Learner, Online, Parameters, PriorKnowledge, SecondOrder};
use bodyschema::schema::BodySchema;
use bodyschema::simulation::{MotionName, Movers};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// How far from the truth a global fit starts: metres for positions, radians for axes.
const DISPLACEMENT: f64 = 5e-3;
/// Touches that a filter's first covariance comes from.
const FIRST: usize = 500;
/// Standard deviation of a touch's gap, metres: how deep limbs press into each other.
const DEVIATION: f64 = 1e-6;

fn displaced(truth: &BodySchema) -> BodySchema {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut schema = truth.clone();
    for v in schema.positions.iter_mut().chain(&mut schema.axes) {
        *v += random_direction(&mut rng) * rng.random_range(0.0..DISPLACEMENT);
    }
    schema.axes.iter_mut().for_each(|axis| *axis = axis.normalize());
    schema
}

/// The parameters of the joints that touches involve.
fn touched(creature: &Creature, touches: &TouchSet) -> Parameters {
    let mut touched = vec![false; creature.joints().len()];
    touches.pairs.iter().flat_map(|pair| pair.chain.joints()).for_each(|joint| touched[joint] = true);
    Parameters::new(creature, AxisModel::Unit, |joint| touched[joint])
}

fn measure() {
    let most: usize = std::env::args().skip(1).find_map(|word| word.parse().ok()).unwrap_or(100_000);
    println!(
        "| joints | touches | global fit, s | µs a touch | update, µs | stream, s | µs a touch | held-out, mm |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for (name, (body, agent), streams) in [("torso, 16", max::torso(), true), ("all 57", max::all(), false)] {
        let creature = &body.creature;
        let babbler =
            Babbler::new(Movers::new(&body, &agent, MotionName::Kinematic).expect("Max can babble"));
        let truth = GroundTruth::new(&body).expect("the engine computes poses");
        let counts = [1_000, 10_000, 100_000].into_iter().filter(|&count| count <= most);
        let (touches, _) = max::babble(&babbler, counts.clone().max().unwrap_or(1_000));
        for count in counts {
            let touches = &touches[..count];
            let mut learner = SecondOrder::new(&agent, Input::Receptor, 1);
            touches.iter().for_each(|touch| learner.touch(touch));
            let start = displaced(&truth.schema);
            let began = Instant::now();
            let fitted = learner.refine(&start);
            let fit_s = began.elapsed().as_secs_f64();
            let prepared: Vec<_> = learner.prepared().collect();
            let mut first = TouchSet::default();
            for (limbs, touch) in &prepared[..FIRST.min(count)] {
                first.push_prepared(creature, *limbs, touch.clone());
            }
            let parameters = touched(creature, &first);
            let prior = PriorKnowledge::nothing(&agent).prior;
            let model = SurfaceGap::new(agent.skin(), DEVIATION);
            let mut problem = TouchProblem::new(creature, &first, &parameters, model).with_prior(&prior);
            let information = problem.linearize(&fitted.schema).hessian;
            let belief = Belief::new(fitted.schema.clone(), parameters, information, DEVIATION);
            let mut belief = belief.expect("the touches determine something");
            let began = Instant::now();
            for (_, touch) in &prepared {
                belief.expect(agent.skin(), touch);
                belief.learn(1.0);
            }
            let update_us = 1e6 * began.elapsed().as_secs_f64() / count as f64;
            let mut online = Online::new(&agent, 1);
            let began = Instant::now();
            let streamed = streams.then(|| {
                touches.iter().for_each(|touch| online.touch(touch));
                online.learn()
            });
            let stream_s = began.elapsed().as_secs_f64();
            let learned = streamed.as_ref().unwrap_or(&fitted);
            let evaluation = evaluate(&agent, &truth, &learned.schema, &learned.undetermined());
            let per_touch = |seconds: f64| 1e6 * seconds / count as f64;
            let stream = match streamed {
                Some(_) => format!("{stream_s:.2} | {:.0}", per_touch(stream_s)),
                None => "– | –".to_string(),
            };
            println!(
                "| {name} | {count} | {fit_s:.3} | {:.0} | {update_us:.0} | {stream} | {:.4} |",
                per_touch(fit_s),
                evaluation.determined_mm.mean
            );
        }
    }
}

fn main() {
    // One thread for all that could use more.
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("there is one thread");
    one.install(measure);
}
