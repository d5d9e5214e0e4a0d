//! `bodyschema learn`: learn from a session's touches, or from a recording.

use std::path::PathBuf;

use super::folders::{Force, session_folder, written_session};
use super::learned::{learn_and_print, read_log};
use super::open::known_truth;
use super::progress::Bars;
use super::{Outcome, output};
use crate::given_number::count;
use crate::learning::{Input, Learner, LimbFrames};
use crate::session::{BabbledSession, LearningOptions, ReadLock, Session};

/// Learn again from the touches of a session, or from a recording of a real body.
///
/// For a session, the log alone is enough: it contains the creature and its skin. If the model is still available, the result
/// is compared with it. The session's schema, table and learned model are replaced together. With --out the session is left
/// unchanged, and its touches and the new results go into a new session; --force replaces an existing one.
///
/// Given a model instead of a session, it babbles first: `learn MODEL` is the same as `babble MODEL`, with the same options.
///
/// For a recording, a JSON description of the creature and a log of touches are enough, and no model is needed: a new
/// session is made from the two. Units are metres and radians.
#[derive(clap::Args)]
#[command(after_help = format!("Examples:
  bodyschema learn sessions/max-1
  bodyschema learn sessions/max-1 --learner hersch
  bodyschema learn sessions/max-1 --learner hersch --out sessions/max-by-hersch
  bodyschema learn sessions/max-1 --touches 300 --json
  bodyschema learn sessions/max-1 --frames limb --input contact
  bodyschema learn sessions/max-1 --touches 60 --known known.json
  bodyschema learn --creature robot.json --log touches.csv
  bodyschema learn --creature robot.json --log touches.jsonl --out sessions/robot-monday\n\n{RECORDING_HELP}\n\n{KNOWN_HELP}"))]
pub struct LearnArguments {
    /// The session's folder
    #[arg(required_unless_present = "creature", conflicts_with_all = ["creature", "log"])]
    session: Option<PathBuf>,
    /// The description of a recorded creature in JSON: the creature of a session.json, with its skin if it has
    /// one, or a whole session.json
    #[arg(long, value_name = "FILE", requires = "log", help_heading = "A recording")]
    creature: Option<PathBuf>,
    /// The recorded touches: CSV, or JSON with one touch per line or a list; optionally gzipped
    #[arg(long, value_name = "FILE", requires = "creature", help_heading = "A recording")]
    log: Option<PathBuf>,
    /// Folder of a new session for the results [default: for a recording, the first free of sessions/CREATURE-1, -2, …;
    /// for a session, its own folder]
    #[arg(long, short, value_name = "DIR", help_heading = "Output")]
    out: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Use only the first touches of the log
    #[arg(long, value_parser = count)]
    touches: Option<usize>,
    /// Draw the initial guesses with a seed other than the session's
    #[arg(long)]
    seed: Option<u64>,
    #[command(flatten)]
    learning: LearningOptions,
    /// The model to compare with, if it is not at the path recorded in the session
    #[arg(long)]
    model: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// What the two files of a recording look like, for the help.
const RECORDING_HELP: &str = r#"Example of a recording: an elbow, and two touches with the points in the limbs' frames.
  robot.json   {"name": "arm", "limbs": ["base", "forearm"], "joints": [{"name": "elbow", "parent": "base",
                "dofs": [{"name": "elbow_pitch", "kind": "hinge", "range": [-1.5, 1.5]}]}]}
  touches.csv  limb_a,limb_b,ax,ay,az,bx,by,bz,elbow_pitch
               base,forearm,0.08,0.01,0.02,0.21,0.00,0.01,0.75
               base,forearm,0.05,0.02,0.02,0.19,0.01,0.00,1.10
  For receptors, use the columns receptor_a,receptor_b instead of limbs and points. a_std,b_std are standard
  deviations of the points' coordinates, metres; without them noise is estimated. In JSON, one touch per line:
  {"posture": {"elbow_pitch": 0.75}, "limbs": ["base", "forearm"], "contacts": [[0.08, 0.01, 0.02], [0.21, 0.0, 0.01]]}"#;

/// An example of a file of known joints, for the help of commands.
pub const KNOWN_HELP: &str = r#"Example of a file for --known: the left elbow exactly, the right wrist's position to 5 mm.
  {"joints": [
    {"joint": "left_elbow", "position": [0.024, 0.089, -0.28],
     "axes": [{"dof": "left_elbow_flexion", "axis": [-0.239924, -0.9466999, -0.2149319]},
              {"dof": "left_elbow_pronation", "axis": [0.2399183, 0.2399183, -0.9406798]}]},
    {"joint": "right_wrist", "position": [0.06, -0.06, -0.235], "position_std": 0.005}
  ]}"#;

pub fn run(args: &LearnArguments) -> Outcome {
    // The lock of the session's own folder, which the results go to unless --out names another.
    let mut own = None;
    let mut babbled = match (&args.session, &args.creature, &args.log) {
        (Some(folder), ..) => {
            own = args.out.is_none().then(|| written_session(folder)).transpose()?;
            let _reading = ReadLock::take(folder)?;
            let session = Session::read(folder)?;
            let touches = read_log(folder, &session.agent)?;
            BabbledSession { session, touches, grown: None }
        }
        (None, Some(creature), Some(log)) => BabbledSession::of_recording(
            (creature, log),
            args.touches.unwrap_or(usize::MAX),
            args.seed,
            &args.learning,
            output::command_line(),
            &Bars::default(),
        )?,
        // The parser sees to it that there is one or the other.
        _ => return Err("give a session's folder, or --creature and --log".into()),
    };
    let learning = args.learning.for_session(&babbled.session)?;
    let is_new = own.is_none();
    let new = || session_folder(args.out.as_deref(), babbled.session.agent.creature().name(), args.force);
    let lock = own.map_or_else(new, Ok)?;
    let truth = known_truth(&babbled.session, args.model.as_deref())?;
    if is_new {
        babbled.write(lock.part()?)?;
    }
    babbled.touches.truncate(args.touches.unwrap_or(usize::MAX));
    babbled.session.seed = args.seed.unwrap_or(babbled.session.seed);
    let bars = Bars::default();
    let result = learn_and_print(&lock, &babbled, &learning, truth.as_ref(), &bars, args.json)?;
    if !result.learned.verdict.converged() && are_of_limb_frames(&babbled, &learning) {
        tell!(
            "these touches fit if points are in the limbs' own frames, as in URDF, which are not parallel at \
             zero: learn with `--frames limb --input contact`"
        );
    }
    Ok(())
}

/// Whether the points of a recording that is not learned are explained in frames of the limbs' own.
fn are_of_limb_frames(babbled: &BabbledSession, learning: &LearningOptions) -> bool {
    // What is exact is found by one of the first.
    const STARTS: usize = 4;
    let agent = &babbled.session.agent;
    let other = LearningOptions { frames: LimbFrames::Limb, ..learning.clone() };
    let asked = learning.frames == LimbFrames::Joint && learning.input() == Input::Contact;
    if !asked || babbled.session.recording.is_none() || other.check(agent.creature()).is_err() {
        return false;
    }
    let mut learner = other.second_order(agent, babbled.session.seed);
    babbled.touches.iter().for_each(|touch| learner.touch(&touch.felt(other.input())));
    learner.learn_in(STARTS).verdict.converged()
}
