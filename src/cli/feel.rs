//! `bodyschema feel`: what a creature feels when it is touched.

use std::path::PathBuf;

use rand::SeedableRng;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

use super::open::{ModelOptions, open_body};
use super::{Failure, Outcome};
use crate::creature::JointSelection;
use crate::interaction::{Script, Strokes, World, aura_event_json, event_json};
use crate::senses::{Aura, Kind};

/// How long the creature is watched after all is done to it, seconds.
const AFTER: f64 = 0.1;

/// Touch a creature and tell what it feels, as JSON lines while it happens.
///
/// A script says which probes, balls of 8 mm, take which way:
///
///   {"probes": [{"name": "finger", "path": [
///     {"time": 0.0, "receptor": "left_forearm_05", "height": 0.03},
///     {"time": 0.3, "receptor": "left_forearm_05", "height": -0.005},
///     {"time": 0.4, "receptor": "left_forearm_05", "height": 0.03}]}]}
///
/// A waypoint is a time in seconds and a place: a receptor, with how far above it the probe's surface is (below 0
/// it presses, with 400 N for each metre), or "at", the probe's middle in the world's frame. Without a script
/// the creature is touched at random.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema feel mjcf/max/max.xml
  bodyschema feel mjcf/max/max.xml --script touches.json")]
pub struct Args {
    /// The MJCF file of a creature
    model: PathBuf,
    /// What is done to the creature
    #[arg(long, value_name = "FILE", conflicts_with_all = ["stimulations", "seed"])]
    script: Option<PathBuf>,
    /// How often it is touched at random
    #[arg(long, default_value_t = 5)]
    stimulations: u32,
    /// Seed of the random touches
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The body at which the creature begins [default: the first of the tree with most joints]
    #[arg(long, value_name = "BODY")]
    root: Option<String>,
}

pub fn run(args: &Args) -> Outcome {
    let options = ModelOptions { strip: false, root: args.root.clone() };
    let body = open_body(&args.model, &JointSelection::All, &options)?;
    let script = args.script.as_deref().map(Script::read).transpose().map_err(Failure)?;
    let probes = script.as_ref().map_or_else(|| vec!["probe".to_string()], Script::probes);
    let world = World::new(&args.model, &body, &probes);
    let mut world = world.map_err(|error| Failure(format!("{}: {error}", args.model.display())))?;
    if world.skin.receptors.is_empty() {
        return Err(Failure(format!("{}: nothing of this creature can be touched", args.model.display())));
    }
    let mut aura = Aura::new(&world.body, &world.skin, &world.data);
    let Some(script) = script else { return at_random(args, &mut world, &mut aura) };
    let paths = script.paths(&world).map_err(|clause| {
        let file = args.script.as_deref().unwrap_or(&args.model);
        Failure(format!("{}: {clause}: see `bodyschema inspect` for its receptors", file.display()))
    })?;
    let end = paths.iter().map(|path| path.end()).fold(0.0, f64::max);
    for (probe, path) in paths.into_iter().enumerate() {
        world.send(probe, path)?;
    }
    watch(&mut world, &mut aura, end)
}

/// Touches the creature at random, one touch after the other.
fn at_random(args: &Args, world: &mut World, aura: &mut Aura) -> Outcome {
    let mut rng = ChaCha8Rng::seed_from_u64(args.seed);
    for _ in 0..args.stimulations {
        let kind = *Kind::ALL.choose(&mut rng).expect("there are kinds");
        let stimulation = Strokes::new(world).random(kind, world.data.time(), &mut rng);
        let Some(stimulation) = stimulation else { continue };
        let end = stimulation.path.end();
        world.send(0, stimulation.path)?;
        watch(world, aura, end)?;
    }
    Ok(())
}

/// Simulates to a time and a little longer, and prints what is felt.
fn watch(world: &mut World, aura: &mut Aura, end: f64) -> Outcome {
    loop {
        let (time, events) = world.step()?;
        for event in aura.step(time, &world.body, &world.skin, &world.data) {
            say!("{}", aura_event_json(world, time, &event));
        }
        for event in events {
            say!("{}", event_json(world, time, &event));
        }
        if time > end + AFTER {
            return Ok(());
        }
    }
}
