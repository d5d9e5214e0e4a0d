//! `bodyschema babble`: the main job.

use std::path::{Path, PathBuf};
use std::time::Instant;

use super::learn_options::{KNOWN_HELP, LearnOptions, learn_session, print_table, to_json};
use super::open::{ModelOptions, open_body};
use super::skin::skin_for;
use super::touches::{babbler, make_touches, threads, touch_count};
use super::{Failure, Outcome, output, progress};
use crate::babbling::{BabblingOptions, MotionName, PolicyName};
use crate::creature::JointSelection;
use crate::ground_truth::GroundTruth;
use crate::record::{
    BabblingEffort, Host, PROGRAM, SESSION_FILE, Session, SessionOptions, TouchWriter, model_hash,
};

/// Babble, touch, learn the body schema, and measure it.
///
/// The creature takes random postures one after the other and stops where its skin touches its skin. From the
/// pairs of receptors and the joint angles alone it learns where its joints are and how they turn; the model's
/// own kinematics serve only to measure the result. All goes into a session folder.
#[derive(clap::Args)]
#[command(after_help = format!("Examples:
  bodyschema babble mjcf/max/max.xml
  bodyschema babble mjcf/max/max.xml --touches 500 --input contact --seed 7
  bodyschema babble mjcf/max/max.xml --joints all --touches 5000 --jobs 4
  bodyschema babble mjcf/max/max.xml --touches 250 --policy informative
  bodyschema babble mjcf/max/max.xml --touches 300 --motion dynamic
  bodyschema babble mjcf/max/max.xml --learner hersch --json
  bodyschema babble mjcf/max/max.xml --touches 60 --known known.json\n\n{KNOWN_HELP}"))]
pub struct Args {
    /// The MJCF file of a creature with touch sensors (grow them with `bodyschema skin`)
    model: PathBuf,
    /// Touches to make
    #[arg(long, default_value_t = 1000, value_parser = touch_count)]
    touches: usize,
    /// Seed of all random numbers: the same seed gives the same touches
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The joints that move: a set that the model names (torso), all, or names separated by commas
    /// [default: torso where the model names it, else all]
    #[arg(long)]
    joints: Option<JointSelection>,
    /// Threads; they change nothing but the time [default: one per core]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// How motions are chosen; all but random learn a schema on the way to choose by, on one thread
    #[arg(long, value_enum, default_value_t)]
    policy: PolicyName,
    /// How the body is moved: straight through its postures, or by servos in a simulation with gravity
    #[arg(long, value_enum, default_value_t)]
    motion: MotionName,
    #[command(flatten)]
    open: ModelOptions,
    #[command(flatten)]
    learn: LearnOptions,
    /// The session's folder [default: the first free of sessions/CREATURE-1, -2, …]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Outcome {
    let selection = args.joints.clone().unwrap_or_default();
    let body = open_body(&args.model, &selection, &args.open)?;
    let learn = args.learn.checked(&body.creature)?;
    let skin = skin_for(&args.model, &body)?;
    let truth = GroundTruth::new(&body)?;
    let babbler = babbler(&args.model, &body, &skin, args.motion)?;
    let folder = session_folder(args.out.as_deref(), body.creature.name())?;
    let mut session = Session {
        program: PROGRAM.to_string(),
        engine: body.model.version().to_string(),
        model: args.model.display().to_string(),
        model_hash: model_hash(&args.model)?,
        recording: None,
        command: output::command_line(),
        host: Some(Host::here()),
        seed: args.seed,
        options: SessionOptions {
            touches: args.touches,
            joints: selection.to_string(),
            strip: args.open.strip,
            root: args.open.root.clone(),
            input: Some(learn.input_name().to_string()),
            learner: Some(learn.learner.to_string()),
            known: learn.known.as_ref().map(|path| path.display().to_string()),
            policy: Some(args.policy.to_string()),
            motion: Some(args.motion)
                .filter(|motion| *motion != MotionName::default())
                .map(|m| m.to_string()),
        },
        effort: None,
        creature: body.creature.clone(),
        skin: skin.clone(),
    };
    session.write(&folder)?;
    let mut log = TouchWriter::create(&folder, &body.creature, &skin)?;
    let options = BabblingOptions { touches: args.touches, seed: args.seed, jobs: threads(args.jobs) };
    let bar = progress::touches(args.touches);
    let began = Instant::now();
    let mut made = Vec::with_capacity(args.touches);
    let effort = make_touches(&args.model, &babbler, args.policy, &options, |touch| {
        log.write(touch)?;
        made.push(touch.clone());
        bar.inc(1);
        Ok(())
    })?;
    session.effort = Some(BabblingEffort::new(&effort, began.elapsed()));
    log.finish()?;
    bar.finish_and_clear();
    session.write(&folder)?;
    let result = learn_session(&folder, &session, &made, &learn, Some(&truth))?;
    if args.json {
        return output::json(&to_json(&folder, &session, &made, &learn, &result));
    }
    print_table(&folder, &session, &made, &learn, &result);
    Ok(())
}

/// The folder to write to: never one that holds a session already.
pub(super) fn session_folder(out: Option<&Path>, creature: &str) -> Result<PathBuf, Failure> {
    let taken = |folder: &Path| folder.join(SESSION_FILE).exists();
    let folder = match out {
        Some(folder) if taken(folder) => {
            return Err(Failure(format!(
                "{} holds a session already: give another folder with --out, or remove it",
                folder.display()
            )));
        }
        Some(folder) => folder.to_path_buf(),
        None => {
            let name: String =
                creature.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).take(40).collect();
            let numbered = |k: u32| Path::new("sessions").join(format!("{name}-{k}"));
            (1..).map(numbered).find(|folder| !folder.exists()).expect("some number is free")
        }
    };
    output::make_folder(&folder)?;
    Ok(folder)
}
