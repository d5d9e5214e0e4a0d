//! What the senses cost beside the physics: Max, all his joints and receptors, stroked by a probe.
//!
//! Bare steps and steps with the touch sensor and the aura take turns in one run, and their ratio is printed.

use std::path::Path;
use std::time::{Duration, Instant};

use bodyschema::creature::JointSelection;
use bodyschema::senses::{Aura, TouchKind};
use bodyschema::simulation::partner::Strokes;
use bodyschema::simulation::{Stage, StageOptions};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Strokes that are measured, each once bare and once felt.
const STROKES: u64 = 40;

fn main() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("mjcf/max/max.xml");
    let options = StageOptions {
        joints: JointSelection::All,
        probes: vec!["probe".to_string()],
        ..StageOptions::default()
    };
    let stage = Stage::new(&path, &options).expect("Max is a creature");
    stage.sense(Aura::watch_out);
    let (mut bare, mut felt) = (Duration::ZERO, Duration::ZERO);
    let (mut steps, mut simulated, mut events) = (0u64, 0.0, 0usize);
    for seed in 0..STROKES {
        for senses in [false, true] {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let begin = stage.time();
            let stroke =
                Strokes::new(&stage).random(TouchKind::Stroke, begin, &mut rng).expect("Max has room");
            let end = stroke.path.end();
            stage.send_probe(0, stroke.path).expect("the probe can go there");
            let began = Instant::now();
            while stage.time() < end {
                if senses {
                    let senses = stage.step().expect("the engine steps");
                    events += senses.touches.len() + senses.near.len();
                    steps += 1;
                } else {
                    stage.step_unfelt().expect("the engine steps");
                }
            }
            *(if senses { &mut felt } else { &mut bare }) += began.elapsed();
            if senses {
                simulated += end - begin;
            }
        }
    }
    let per_step = |spent: Duration| 1e6 * spent.as_secs_f64() / steps as f64;
    println!("bare physics: {:.1} us a step", per_step(bare));
    println!("with all senses: {:.1} us a step, {events} events", per_step(felt));
    println!("ratio: {:.3}", felt.as_secs_f64() / bare.as_secs_f64());
    println!("times real time: {:.1}", simulated / felt.as_secs_f64());
}
