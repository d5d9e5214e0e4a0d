//! `bodyschema babble`: the main job.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::arguments::Arguments;
use super::learn_options::{KNOWN_HELP, LearnOptions, learn_session, print_table, to_json};
use super::live::{Live, LiveOptions};
use super::open::{ModelOptions, open_body};
use super::skin::skin_for;
use super::touches::{babbler, make_touches, threads, touch_count};
use super::{Failure, Outcome, output, progress};
use crate::babbling::{BabblingOptions, BoutsDone, Made, MotionName, PolicyName};
use crate::creature::{Body, JointSelection};
use crate::ground_truth::GroundTruth;
use crate::live::BabblingView;
use crate::record::{
    BabblingEffort, BabblingProgress, Host, PROGRAM, SESSION_FILE, Session, SessionOptions, TouchWriter,
    model_hash,
};
use crate::senses::Touch;
use crate::skin::Skin;

/// How often it is written down how far babbling has come.
const KEPT_EVERY: Duration = Duration::from_secs(1);

/// Babble, touch, learn the body schema, and measure it.
///
/// The creature takes random postures one after the other and stops where its skin touches its skin. From the
/// pairs of receptors and the joint angles alone it learns where its joints are and how they turn; the model's
/// own kinematics serve only to measure the result. All goes into a session folder.
#[derive(clap::Args)]
#[command(after_help = format!("Examples:
  bodyschema babble mjcf/max/max.xml
  bodyschema babble mjcf/max/max.xml --touches 500 --input contact --seed 7
  bodyschema babble mjcf/max/max.xml --joints all --touches 5000 --jobs 4    # takes minutes
  bodyschema babble mjcf/max/max.xml --touches 250 --policy informative      # takes minutes
  bodyschema babble mjcf/max/max.xml --touches 300 --motion dynamic          # takes minutes
  bodyschema babble mjcf/max/max.xml --learner hersch --json
  bodyschema babble mjcf/max/max.xml --touches 2000 --live                   # watch it in a browser
  bodyschema babble --resume sessions/max-1
  bodyschema babble mjcf/max/max.xml --touches 60 --known known.json\n\n{KNOWN_HELP}"))]
pub struct Args {
    /// The MJCF file of a creature with touch sensors (grow them with `bodyschema skin`)
    #[arg(required_unless_present = "resume")]
    model: Option<PathBuf>,
    /// Touches to make
    #[arg(long, default_value_t = 1000, value_parser = touch_count)]
    pub(super) touches: usize,
    /// Seed of all random numbers: the same seed gives the same touches
    #[arg(long, default_value_t = 1)]
    pub(super) seed: u64,
    /// The joints that move: a set that the model names (torso), all, or names separated by commas
    /// [default: torso where the model names it, else all]
    #[arg(long)]
    joints: Option<JointSelection>,
    /// Threads; they change nothing but the time [default: one per core]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(super) jobs: Option<u16>,
    /// How motions are chosen; all but random learn a schema on the way to choose by, on one thread
    #[arg(long, value_enum, default_value_t)]
    pub(super) policy: PolicyName,
    /// How the body is moved: straight through its postures, or by servos in a simulation with gravity
    #[arg(long, value_enum, default_value_t)]
    pub(super) motion: MotionName,
    #[command(flatten)]
    open: ModelOptions,
    #[command(flatten)]
    learn: LearnOptions,
    /// The session's folder [default: the first free of sessions/CREATURE-1, -2, …]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Go on with a session that was interrupted, with the options that are in its session.json: its touches become
    /// what they would have been. Takes --jobs, --json and --live beside it
    #[arg(long, value_name = "DIR")]
    resume: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    pub(super) json: bool,
    #[command(flatten)]
    pub(super) live: LiveOptions,
}

impl Args {
    /// The model's file.
    fn model(&self) -> Result<&Path, Failure> {
        // The parser sees to it that there is one.
        self.model.as_deref().ok_or(Failure("name the model's file".into()))
    }
}

pub fn run(args: &Args, given: Arguments) -> Outcome {
    match &args.resume {
        Some(folder) => super::resume::run(folder, args),
        None => begin(args, given),
    }
}

/// Begins a session.
fn begin(args: &Args, given: Arguments) -> Outcome {
    let plan = Plan::new(args)?;
    let folder = session_folder(args.out.as_deref(), plan.body.creature.name())?;
    let session = plan.session(args, given)?;
    session.write(&folder)?;
    let log = TouchWriter::create(&folder, &plan.body.creature, &plan.skin)?;
    plan.babble(
        args,
        folder,
        session,
        Begun { log, done: BoutsDone::default(), spent: Duration::ZERO, made: Vec::new() },
    )
}

/// All that is made ready before the first touch.
pub(super) struct Plan {
    pub body: Body,
    pub skin: Skin,
    truth: GroundTruth,
    learn: LearnOptions,
}

/// What there is of a session when it goes on, or begins.
pub(super) struct Begun<'a> {
    /// The log, ready for the touch after those of `done`.
    pub log: TouchWriter<'a>,
    /// The bouts that need not be made again.
    pub done: BoutsDone,
    /// The time that they took.
    pub spent: Duration,
    /// Their touches.
    pub made: Vec<Touch>,
}

impl Plan {
    pub fn new(args: &Args) -> Result<Plan, Failure> {
        let body = open_body(args.model()?, &args.joints.clone().unwrap_or_default(), &args.open)?;
        let learn = args.learn.checked(&body.creature)?;
        let skin = skin_for(args.model()?, &body)?;
        let truth = GroundTruth::new(&body)?;
        // Whether the creature can babble at all is told before any folder is made.
        babbler(args.model()?, &body, &skin, args.motion)?;
        Ok(Plan { body, skin, truth, learn })
    }

    fn session(&self, args: &Args, arguments: Arguments) -> Result<Session, Failure> {
        let model = args.model()?;
        Ok(Session {
            program: PROGRAM.to_string(),
            engine: self.body.model.version().to_string(),
            model: model.display().to_string(),
            model_hash: model_hash(model)?,
            recording: None,
            command: output::command_line(),
            host: Some(Host::here()),
            seed: args.seed,
            options: SessionOptions {
                touches: args.touches,
                joints: args.joints.clone().unwrap_or_default().to_string(),
                strip: args.open.strip,
                root: args.open.root.clone(),
                input: Some(self.learn.input_name().to_string()),
                learner: Some(self.learn.learner.to_string()),
                known: self.learn.known.as_ref().map(|path| path.display().to_string()),
                policy: Some(args.policy.to_string()),
                motion: Some(args.motion)
                    .filter(|motion| *motion != MotionName::default())
                    .map(|m| m.to_string()),
                arguments,
            },
            effort: None,
            creature: self.body.creature.clone(),
            skin: self.skin.clone(),
        })
    }

    /// Babbles what is missing, learns, and prints the result.
    pub fn babble(&self, args: &Args, folder: PathBuf, mut session: Session, begun: Begun) -> Outcome {
        let Begun { mut log, done, spent, mut made } = begun;
        let model = args.model()?;
        let babbler = babbler(model, &self.body, &self.skin, args.motion)?;
        let options = BabblingOptions { touches: args.touches, seed: args.seed, jobs: threads(args.jobs) };
        let live = self.live(args, made.len())?;
        let learner =
            live.as_ref().map(|live| live.begin(&self.body.creature, &self.skin, args.seed)).transpose()?;
        let bar = progress::counted("babbling", args.touches as u64, "touches");
        bar.set_position(made.len() as u64);
        let began = Instant::now();
        let mut kept = began;
        let effort = make_touches(model, &babbler, args.policy, done, &options, |news| {
            match news {
                Made::Touch(touch) => {
                    log.write(touch)?;
                    if let Some(live) = &live {
                        live.view.touched(touch);
                    }
                    made.push(touch.clone());
                    bar.inc(1);
                }
                // Bouts can be shorter than it takes to write this down.
                Made::Bout(done) if kept.elapsed() >= KEPT_EVERY => {
                    BabblingProgress::new(&done, spent + began.elapsed()).write(&folder)?;
                    kept = Instant::now();
                }
                Made::Bout(_) => {}
            }
            Ok(())
        })?;
        drop(learner);
        session.effort = Some(BabblingEffort::new(&effort, spent + began.elapsed()));
        log.finish()?;
        bar.finish_and_clear();
        session.write(&folder)?;
        BabblingProgress::remove(&folder);
        self.learn(args, &folder, &session, &made, live.as_ref())
    }

    /// The page to watch it on, where one is asked for.
    pub fn live(&self, args: &Args, made: usize) -> Result<Option<Live>, Failure> {
        let simulated = || self.truth.schema.clone();
        let view = || BabblingView::new(&self.body.creature, &self.skin, simulated(), args.touches, made);
        args.live.address().map(|address| Live::new(address, view())).transpose()
    }

    /// Learns from all touches, and prints the result.
    pub fn learn(
        &self,
        args: &Args,
        folder: &Path,
        session: &Session,
        made: &[Touch],
        live: Option<&Live>,
    ) -> Outcome {
        let learn = &self.learn;
        let view = live.map(|live| &*live.view);
        let result = learn_session(folder, session, made, learn, Some(&self.truth), view)?;
        if args.json {
            output::json(&to_json(folder, session, made, learn, &result))?;
        } else {
            print_table(folder, session, made, learn, &result);
        }
        if let Some(live) = live {
            live.rest();
        }
        Ok(())
    }
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
