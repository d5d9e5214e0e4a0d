//! `bodyschema skin feel`: touches a creature and prints what it feels.

use std::path::PathBuf;

use rand::SeedableRng;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

use crate::cli::folders::{Force, session_folder};
use crate::cli::open::{ModelArguments, rehearse};
use crate::cli::progress::Bars;
use crate::cli::{Failure, Outcome, progress};
use crate::creature::JointSelection;
use crate::given_number::positive;
use crate::senses::{Aura, TouchKind, TouchSensor};
use crate::session::{StrokedSession, read_map, record_strokes};
use crate::simulation::partner::{Script, Strokes};
use crate::simulation::{Stage, StageOptions, StepSenses, aura_event_json, event_json};

/// How long the creature is watched after all is done to it, seconds.
const AFTER: f64 = 0.1;

/// Touch a creature and print what it feels, as JSON lines while it happens
///
/// A script gives the paths of probes, balls of 8 mm:
///
///   {"probes": [{"name": "finger", "path": [
///     {"time": 0.0, "receptor": "left_forearm_05", "height": 0.03},
///     {"time": 0.3, "receptor": "left_forearm_05", "height": -0.005},
///     {"time": 0.4, "receptor": "left_forearm_05", "height": 0.03}]}]}
///
/// A waypoint has a time in seconds and a position: either a receptor and the height of the probe's surface above it
/// (if negative, the probe presses with 400 N per metre), or "at", the probe's centre in the world frame. Without a script
/// the creature is touched at random.
///
/// With --strokes it is stroked all over for this many minutes, and the results go into a session folder: firings.jsonl
/// records which receptor fired when, sensations.jsonl the output of the touch sensor. `bodyschema skin map` learns from
/// the firings which receptors are neighbours; with --map the touch sensor uses such a map.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
#[command(after_help = "Examples:
  bodyschema skin feel mjcf/max/max.xml
  bodyschema skin feel mjcf/max/max.xml --script touches.json
  bodyschema skin feel mjcf/max/max.xml --strokes 20 --out sessions/stroked     # takes minutes")]
pub struct FeelArguments {
    /// The MJCF or URDF file of a creature
    model: PathBuf,
    /// The script of touches (JSON)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["stimulations", "seed"])]
    script: Option<PathBuf>,
    /// Number of random touches
    #[arg(long, default_value_t = 5)]
    stimulations: u32,
    /// Stroke it at random for this many simulated minutes and write a session
    #[arg(long, value_name = "MINUTES", value_parser = minutes, conflicts_with_all = ["script", "stimulations"])]
    strokes: Option<f64>,
    /// The session's folder, with --strokes [default: the first free of sessions/CREATURE-1, -2, …]
    #[arg(long, short, value_name = "DIR", requires = "strokes", help_heading = "Output")]
    out: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Neighbour map for the touch sensor, as learned by `bodyschema skin map` [default: from the geometry]
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    /// Seed of the random touches
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    open: ModelArguments,
}

pub fn run(args: &FeelArguments) -> Outcome {
    rehearse(&args.model)?;
    let body = args.open.source(&args.model, JointSelection::All).body(&Bars::default())?;
    let script = args.script.as_deref().map(Script::read).transpose()?;
    let probes = script.as_ref().map_or_else(|| vec!["probe".to_string()], Script::probes);
    let root = body.root_name().map(str::to_string);
    let options = StageOptions { joints: JointSelection::All, root, probes, ..StageOptions::default() };
    let stage = Stage::new(&args.model, &options);
    let stage = stage.map_err(|error| Failure::at(&args.model, error))?;
    if let Some(file) = &args.map {
        let map = read_map(file, stage.agent().creature().name(), stage.skin())?;
        stage.sense(|sensor| *sensor = TouchSensor::new(map, stage.skin()));
    }
    if stage.skin().receptors.is_empty() {
        return Err(Failure::at(&args.model, "this creature has no touchable surface"));
    }
    if let Some(minutes) = args.strokes {
        return strokes(args, &stage, minutes);
    }
    stage.sense(Aura::watch_out);
    let Some(script) = script else { return at_random(args, &stage) };
    let paths = script.paths(&stage).map_err(|clause| {
        let file = args.script.as_deref().unwrap_or(&args.model);
        Failure::at(file, format_args!("{clause}: see `bodyschema inspect` for its receptors"))
    })?;
    let end = paths.iter().map(|path| path.end()).fold(0.0, f64::max);
    for (probe, path) in paths.into_iter().enumerate() {
        stage.send_probe(probe, path)?;
    }
    watch(&stage, end)
}

fn minutes(text: &str) -> Result<f64, String> {
    positive(text).ok().filter(|minutes| *minutes <= 1e4).ok_or("give minutes above 0, up to 10000".into())
}

/// Strokes the creature all over, and writes a session of what it feels.
fn strokes(args: &FeelArguments, stage: &Stage, minutes: f64) -> Outcome {
    let lock = session_folder(args.out.as_deref(), stage.agent().creature().name(), args.force)?;
    let bar = progress::counted("stroking", (60.0 * minutes).ceil() as u64, "simulated seconds");
    let stroked = StrokedSession {
        model: &args.model,
        root: args.open.root.clone(),
        command: crate::cli::output::command_line(),
        seed: args.seed,
        seconds: 60.0 * minutes,
    };
    // A log of firings cannot be gone on with: it is there when it is whole.
    let [sensed, fired] =
        record_strokes(lock.part()?, stage, stroked, |seconds| bar.set_position(seconds as u64))?;
    bar.finish_and_clear();
    lock.commit()?;
    let place = lock.place().display();
    say!("{sensed} sensations and {fired} firings in {minutes} minutes, written to {place}");
    Ok(())
}

/// Touches the creature at random, one touch after the other.
fn at_random(args: &FeelArguments, stage: &Stage) -> Outcome {
    let mut rng = ChaCha8Rng::seed_from_u64(args.seed);
    for _ in 0..args.stimulations {
        let kind = *TouchKind::ALL.choose(&mut rng).expect("there are kinds");
        let stimulation = Strokes::new(stage).random(kind, stage.time(), &mut rng);
        let Some(stimulation) = stimulation else { continue };
        let end = stimulation.path.end();
        stage.send_probe(0, stimulation.path)?;
        watch(stage, end)?;
    }
    Ok(())
}

/// Simulates to a time and a little longer, and prints what is felt.
fn watch(stage: &Stage, end: f64) -> Outcome {
    loop {
        let StepSenses { time, near, touches, .. } = stage.step()?;
        for event in near {
            say!("{}", aura_event_json(stage, time, &event));
        }
        for event in touches {
            say!("{}", event_json(stage, time, &event));
        }
        if time > end + AFTER {
            return Ok(());
        }
    }
}
