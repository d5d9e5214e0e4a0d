//! How many touches a second of CPU time bodies of different shapes make, and what each costs: the creatures of `mjcf/`, and
//! ten bodies of meshes.
//!
//! `cargo bench --bench surfaces`; `-- 2` measures each for two seconds of CPU time, and files named after it are measured
//! in place of those.

mod meshes;

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use bodyschema::agent::Agent;
use bodyschema::creature::{Body, JointSelection, Posture};
use bodyschema::mujoco::Model;
use bodyschema::simulation::{Effort, Ending, MotionName, Movers};
use bodyschema::skin::{GrowOptions, grow};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

const CREATURES: [&str; 7] = ["max", "hexapod", "octopus", "snake", "fourarms", "sauropod", "contraption"];
/// How long a body is measured where nobody says so, seconds of CPU time.
const SECONDS: f64 = 5.0;
/// Motions after which a body begins anew where it starts: none is measured only where it got caught.
const MOTIONS_PER_BOUT: u64 = 100;
/// Motions between looks at the clock.
const MOTIONS_PER_LOOK: u64 = 20;

/// CPU time of this thread, seconds; where the system does not tell, the time that has passed since `began`.
fn cpu_time(began: Instant) -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = text.split_whitespace().next().and_then(|word| word.parse::<f64>().ok());
    nanoseconds.map_or_else(|| began.elapsed().as_secs_f64(), |time| 1e-9 * time)
}

/// Babbles for some seconds and prints a row.
fn measure(name: &str, model: Model, seconds: f64) {
    let began = Instant::now();
    let loaded = cpu_time(began);
    let body = match Body::new(Arc::new(model), &JointSelection::Default) {
        Ok(body) => body,
        Err(error) => return println!("| {name} | {error} |"),
    };
    let skin = grow(&body, &GrowOptions::default()).expect("skin grows where limbs have a surface");
    let agent = Agent::new(body.creature.clone(), skin).expect("receptors have names");
    let movers = match Movers::new(&body, &agent, MotionName::Kinematic) {
        Ok(movers) => movers,
        Err(error) => return println!("| {name} | {error} |"),
    };
    let start = cpu_time(began);
    let mut mover = movers.mover().expect("there is memory for a posture");
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (mut touches, mut passed) = (0, 0.0);
    while passed < seconds {
        if mover.effort().motions.is_multiple_of(MOTIONS_PER_BOUT) {
            mover.reset().expect("the engine goes on");
        }
        match mover.advance(&Posture::random(&body.creature, &mut rng)) {
            Ok(ending) => touches += u64::from(matches!(ending, Ending::Touch(_))),
            Err(error) => return println!("| {name} | {error} |"),
        }
        if mover.effort().motions.is_multiple_of(MOTIONS_PER_LOOK) {
            passed = cpu_time(began) - start;
        }
    }
    let Effort { motions, engine_checks, gap_checks, bare, again, .. } = mover.effort();
    let per_touch = |count: u64| count as f64 / touches.max(1) as f64;
    println!(
        "| {name} | {:.2} | {motions} | {touches} | {bare} | {again} | {:.1} | {:.0} | {:.0} |",
        start - loaded,
        per_touch(engine_checks),
        per_touch(gap_checks),
        touches as f64 / passed
    );
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let seconds = words.iter().find_map(|word| word.parse().ok()).unwrap_or(SECONDS);
    let files = words.iter().filter(|word| word.parse::<f64>().is_err());
    println!(
        "| body | ready, s | motions | touches | bare | again | engine checks a touch | looks at gaps a touch | \
         touches a second |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let named: Vec<&String> = files.collect();
    for file in &named {
        match Model::from_path(file) {
            Ok(model) => measure(file, model, seconds),
            Err(error) => println!("| {file} | {error} |"),
        }
    }
    if !named.is_empty() {
        return;
    }
    for name in CREATURES {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("mjcf/{name}/{name}.xml"));
        measure(name, Model::from_path(&path).expect("the creature loads"), seconds);
    }
    for (name, xml) in meshes::bodies() {
        measure(&name, Model::from_xml(&xml).expect("the body compiles"), seconds);
    }
}
