//! How to learn, and the learning that `babble` and `learn` share.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use clap::ValueEnum;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

use super::disturbance_options::DisturbanceOptions;
use super::open::{ModelOptions, body_of, open_body, open_model};
use super::report::{REPORT_FILE, write_report};
use super::{Failure, output, progress};
use crate::babbling::MotionName;
use crate::creature::{Body, Creature, DofKind, JointSelection};
use crate::evaluation::{Bound, Evaluation, OwnAccount, Progress, Summary, evaluate, evaluate_learned};
use crate::ground_truth::GroundTruth;
use crate::learning::onset::random_onset;
use crate::learning::{
    Change, Hersch, Input, Known, KnownJoint, Learned, Learner, LimbFrames, Online, RelaxedGradient,
    SecondOrder, SkinKnowledge, Verdict, What,
};
use crate::live::BabblingView;
use crate::record::{
    Checkpoint, Host, LearningRecord, LearningTable, PROGRAM, SCHEMA_FILE, Session, SessionOptions, TouchLog,
    model_hash, read_known, write_schema_with_std,
};
use crate::schema::BodySchema;
use crate::senses::{Felt, Touch};
use crate::skin::{Receptor, Skin};

/// The learned body as a model, in a session's folder.
pub const LEARNED_FILE: &str = "learned.xml";

/// Options of learning.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct LearnOptions {
    /// The learner: Levenberg-Marquardt from any onset, Hersch's rule as the paper prints it, or that
    /// rule repaired
    #[arg(long, value_enum, default_value_t = LearnerName::Lm)]
    pub learner: LearnerName,
    /// What a touch reports: the receptors, as a skin does, or the contact points [default: receptor; of a
    /// recording, what it holds]
    #[arg(long, value_enum)]
    pub input: Option<InputName>,
    /// What the agent knows of its skin: the surfaces under the receptors, or their centres alone
    #[arg(long, value_enum, default_value_t = SkinName::Surface)]
    pub skin: SkinName,
    /// Which frames points on limbs are given in: those of their joints, or a frame of its own for every limb,
    /// whose pose on its joint is then learned as well (for the learner lm and --input contact)
    #[arg(long, value_enum, default_value_t = FramesName::Joint)]
    pub frames: FramesName,
    /// What is known of joints before the first touch, for the learner lm: a schema.json, whole or with some
    /// of its joints. A joint without deviations is known exactly and stays as it is; with position_std
    /// (metres) and axis_std (radians) it is known nearly
    #[arg(long, value_name = "FILE")]
    pub known: Option<PathBuf>,
    /// What the file of `known` says, once it was read.
    #[arg(skip)]
    pub known_joints: Vec<KnownJoint>,
    #[command(flatten)]
    pub disturbances: DisturbanceOptions,
}

/// An example of a file of known joints, for the help of commands.
pub const KNOWN_HELP: &str = r#"Example of a file for --known: the left elbow exactly, the right wrist's position to 5 mm.
  {"joints": [
    {"joint": "left_elbow", "position": [0.024, 0.089, -0.28],
     "axes": [{"dof": "left_elbow_flexion", "axis": [-0.239924, -0.9466999, -0.2149319]},
              {"dof": "left_elbow_pronation", "axis": [0.2399183, 0.2399183, -0.9406798]}]},
    {"joint": "right_wrist", "position": [0.06, -0.06, -0.235], "position_std": 0.005}
  ]}"#;

/// The learners by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum LearnerName {
    #[default]
    Lm,
    Hersch,
    Gradient,
}

/// The inputs by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum InputName {
    #[default]
    Receptor,
    Contact,
}

/// The knowledge of the skin by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum SkinName {
    #[default]
    Surface,
    Centres,
}

/// The frames of limbs by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum FramesName {
    #[default]
    Joint,
    Limb,
}

impl std::fmt::Display for FramesName {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            FramesName::Joint => "joint",
            FramesName::Limb => "limb",
        })
    }
}

impl std::fmt::Display for LearnerName {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            LearnerName::Lm => "lm",
            LearnerName::Hersch => "hersch",
            LearnerName::Gradient => "gradient",
        })
    }
}

impl std::fmt::Display for InputName {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            InputName::Receptor => "receptor",
            InputName::Contact => "contact",
        })
    }
}

impl std::fmt::Display for SkinName {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            SkinName::Surface => "surface",
            SkinName::Centres => "centres",
        })
    }
}

impl LearnOptions {
    /// What touches report, by name.
    pub fn input_name(&self) -> InputName {
        self.input.unwrap_or_default()
    }

    fn input(&self) -> Input {
        match self.input_name() {
            InputName::Receptor => Input::Receptor,
            InputName::Contact => Input::Contact,
        }
    }

    /// These options, ready for a creature: with the file of known joints read.
    ///
    /// # Errors
    /// Where the file is not one for this creature, where the learner has no use for it, and where it cannot
    /// learn limbs in frames of their own.
    pub fn checked(&self, creature: &Creature) -> Result<LearnOptions, Failure> {
        if self.frames == FramesName::Limb {
            self.check_frames(creature)?;
        }
        let Some(path) = &self.known else { return Ok(self.clone()) };
        if self.learner != LearnerName::Lm {
            return Err(Failure(format!(
                "{}: the learner {} knows nothing beforehand: use --learner lm, or leave out --known",
                path.display(),
                self.learner
            )));
        }
        Ok(LearnOptions { known_joints: read_known(path, creature)?, ..self.clone() })
    }

    /// Whether limbs in frames of their own can be learned of a creature with these options.
    fn check_frames(&self, creature: &Creature) -> Result<(), Failure> {
        let refuse = |why: &str| Err(Failure(format!("--frames limb: {why}")));
        if self.learner != LearnerName::Lm {
            return refuse("only the learner lm finds the limbs' frames: use --learner lm");
        }
        if self.input_name() != InputName::Contact {
            return refuse(
                "receptors are too coarse to tell how a round limb is turned in its frame: use --input contact",
            );
        }
        if self.known.is_some() {
            return refuse("nothing can be known of joints beforehand: leave out --known");
        }
        match creature.dofs().find(|dof| dof.kind == DofKind::Ball) {
            Some(ball) => refuse(&format!(
                "{} is a ball, whose angles are told along the axes of the joint's frame: name hinges and slides \
                 with --joints, or use --frames joint",
                ball.name
            )),
            None => Ok(()),
        }
    }

    /// These options for a session's touches: those of a recording report what the recording holds.
    ///
    /// # Errors
    /// Where receptors are asked for and the recording has none.
    pub fn for_session(&self, session: &Session) -> Result<LearnOptions, Failure> {
        let Some(recording) = &session.recording else { return Ok(self.clone()) };
        let bare = |receptor: &Receptor| receptor.surface.is_none() && receptor.half_extents == [0.0; 2];
        if self.input == Some(InputName::Receptor) && session.skin.receptors.iter().any(bare) {
            return Err(Failure(format!(
                "{}: its touches are points on limbs without a skin: use --input contact, or leave out --input",
                recording.log
            )));
        }
        let points = session.options.input.as_deref() == Some(&InputName::Contact.to_string());
        let found = if points { InputName::Contact } else { InputName::Receptor };
        Ok(LearnOptions { input: Some(self.input.unwrap_or(found)), ..self.clone() })
    }

    /// What was known beforehand, in JSON: the file, and its joints with whether they were exact.
    fn known_json(&self, creature: &Creature) -> Value {
        let Some(path) = &self.known else { return Value::Null };
        let joint = |known: &KnownJoint| json!({ "joint": creature.joints()[known.joint].name, "exact": known.exact });
        json!({ "file": path, "joints": self.known_joints.iter().map(joint).collect::<Vec<_>>() })
    }

    /// The same in words.
    fn known_words(&self, creature: &Creature) -> Option<String> {
        self.known.as_ref()?;
        let names = |exact: bool| {
            let joints = self.known_joints.iter().filter(|known| known.exact == exact);
            let names: Vec<String> =
                joints.map(|known| creature.joints()[known.joint].name.clone()).collect();
            output::names(&names)
        };
        Some(format!("exactly {}; nearly {}", names(true), names(false)))
    }

    /// The learner, from an onset drawn from `seed`.
    pub fn learner<'a>(&self, creature: &'a Creature, skin: &'a Skin, seed: u64) -> Box<dyn Learner + 'a> {
        let onset = || random_onset(creature, &mut ChaCha8Rng::seed_from_u64(seed));
        match self.learner {
            LearnerName::Hersch => Box::new(Hersch::new(creature, skin, self.input(), onset())),
            LearnerName::Gradient => {
                Box::new(RelaxedGradient::new(creature, skin, self.input(), onset(), seed))
            }
            LearnerName::Lm => {
                let known = Known::nothing(creature, skin).with(&self.known_joints);
                if self.learns_online() {
                    return Box::new(Online::new(creature, skin, seed).with_known(known));
                }
                Box::new(self.second_order(creature, skin, seed).with_known(known))
            }
        }
    }

    /// What is believed before the first touch: the onset of a learner that has but one, else one like those that
    /// it starts from.
    fn onset(&self, creature: &Creature, seed: u64) -> BodySchema {
        let onset = random_onset(creature, &mut ChaCha8Rng::seed_from_u64(seed));
        if self.frames == FramesName::Limb { onset.with_limb_poses() } else { onset }
    }

    /// The learner of all touches at once, with this input and this knowledge of skin and frames.
    fn second_order<'a>(&self, creature: &'a Creature, skin: &'a Skin, seed: u64) -> SecondOrder<'a> {
        let knowledge = match self.skin {
            SkinName::Surface => SkinKnowledge::Surface,
            SkinName::Centres => SkinKnowledge::Centres,
        };
        let frames = match self.frames {
            FramesName::Joint => LimbFrames::Joint,
            FramesName::Limb => LimbFrames::Limb,
        };
        SecondOrder::new(creature, skin, self.input(), seed).with_frames(frames).with_skin(knowledge)
    }

    /// Whether the learner goes touch by touch and predicts each before it learns from it.
    fn learns_online(&self) -> bool {
        let evidence = (self.input_name(), self.skin) == (InputName::Receptor, SkinName::Surface);
        self.learner == LearnerName::Lm && evidence
    }

    /// What the learner was allowed to know, in words.
    fn knowledge(&self) -> &'static str {
        match (self.learner, self.input_name(), self.skin) {
            (_, InputName::Contact, _) => "contact points",
            (LearnerName::Lm, InputName::Receptor, SkinName::Surface) => {
                "receptors and the surfaces under them"
            }
            (LearnerName::Hersch | LearnerName::Gradient, ..) | (_, _, SkinName::Centres) => {
                "receptor centres"
            }
        }
    }
}

/// What learning from a session came to.
pub struct SessionLearning {
    pub learned: Learned,
    pub seconds: f64,
    pub evaluation: Option<Evaluation>,
    /// What can be told without the truth; none where the truth is at hand or the learner cannot tell.
    pub own_account: Option<OwnAccount>,
    pub undetermined: Vec<String>,
    /// Limbs whose own frames are not known, by name.
    pub undetermined_limbs: Vec<String>,
    /// The held-out error from the same touches without the disturbances; none where there are none, or no
    /// truth at hand.
    pub undisturbed_heldout_mm: Option<Summary>,
}

/// The truth of a session's creature, from its model.
pub fn session_truth(session: &Session, model: Option<&Path>) -> Result<GroundTruth, Failure> {
    Ok(GroundTruth::new(&session_body(session, model)?)?)
}

/// A session's creature in its model, or in another that is named.
pub fn session_body(session: &Session, model: Option<&Path>) -> Result<Body, Failure> {
    let path = model.map_or_else(|| PathBuf::from(&session.model), Path::to_path_buf);
    if session.recording.is_some() {
        // Which joints of a model a recording has is not known by the name of a set.
        let (open, model) = (ModelOptions::default(), Arc::new(open_model(&path, false)?));
        for selection in [JointSelection::Default, JointSelection::All] {
            let body = body_of(model.clone(), &path, &selection, &open)?;
            if same_tree(&body.creature, &session.creature) {
                return Ok(body);
            }
        }
        return Err(Failure(format!(
            "{}: it has not the limbs and degrees of freedom of the recording: name a model that has, or leave out \
             --model",
            path.display()
        )));
    }
    let selection = session.options.joints.parse::<JointSelection>().unwrap_or_default();
    let SessionOptions { strip, root, .. } = &session.options;
    let body = open_body(&path, &selection, &ModelOptions { strip: *strip, root: root.clone() })?;
    // Who names another file vouches for it, as far as it can be told.
    let other_file = model.is_none() && model_hash(&path)? != session.model_hash;
    if other_file || body.creature != session.creature {
        return Err(Failure(format!(
            "{}: it is not the model that was babbled on, or it has changed since: name the right one with --model",
            path.display()
        )));
    }
    Ok(body)
}

/// Whether two creatures have the same limbs, joints and kinds of degrees of freedom.
pub fn same_tree(a: &Creature, b: &Creature) -> bool {
    let joints = |creature: &Creature| {
        let parents: Vec<usize> = creature.joints().iter().map(|joint| joint.parent).collect();
        let dofs: Vec<_> = creature.dofs().map(|dof| (dof.name.clone(), dof.kind)).collect();
        (creature.limbs().to_vec(), parents, dofs)
    };
    joints(a) == joints(b)
}

/// Learns from touches, measures where the truth is at hand, and writes the session's results.
///
/// The touches are the exact ones: what the agent feels of them is the options' affair. Only the learner is
/// deceived: everything is measured on the session's own skin, which the learned model wears, too.
pub fn learn_session(
    folder: &Path,
    session: &Session,
    touches: &[Touch],
    options: &LearnOptions,
    truth: Option<&GroundTruth>,
    view: Option<&BabblingView>,
) -> Result<SessionLearning, Failure> {
    if let Some(view) = view {
        view.now("learning");
    }
    let (creature, skin) = (&session.creature, &session.skin);
    // Whoever expects nothing of a touch has a row per checkpoint alone.
    let expects = options.learns_online();
    let bar = match expects || options.learner == LearnerName::Hersch {
        true => progress::counted("learning", touches.len() as u64, "touches"),
        false => progress::spinner(&format!("learning from {} touches", touches.len())),
    };
    let mut columns = vec!["touches", "predicted_gap_mm", "predicted_deviation_mm", "converged", "fresh_rms"];
    if truth.is_some() {
        columns.extend(["heldout_mean_mm", "heldout_p95_mm", "hand_mean_mm", "axis_median_deg"]);
    }
    let mut table = LearningTable::create(folder, &columns)?;
    let disturbances = options.disturbances.disturbances();
    let felt = disturbances.felt(creature, skin, touches, session.seed);
    let mut learner = options.learner(creature, &felt.skin, session.seed);
    let mut passed = vec![(0, options.onset(creature, session.seed))];
    let mut result = None;
    let mut seconds = 0.0;
    // Without the truth a fit on the way tells nothing that the last does not.
    let checkpoints = match truth {
        None if options.learner == LearnerName::Lm && !expects => Vec::new(),
        _ => checkpoints(options, touches.len()),
    };
    for (n, touch) in felt.touches.iter().enumerate() {
        let began = Instant::now();
        learner.touch(touch);
        // The first schema is worth a look, whenever it comes.
        let first = expects && passed.len() == 1 && learner.schema().is_some();
        let due = first || checkpoints.contains(&(n + 1));
        let last = n + 1 == touches.len();
        // Learning for a row of the table alone is not what learning takes.
        let learned = (last || (due && !expects)).then(|| learner.learn());
        bar.inc(1);
        if last || !due || expects || options.learner == LearnerName::Hersch {
            seconds += began.elapsed().as_secs_f64();
        }
        if !(due || last || expects) {
            continue;
        }
        let expected = learner.expectation();
        let millimetres = |value: Option<f64>| value.map_or(f64::NAN, |metres| 1e3 * metres);
        let mut row = vec![
            (n + 1) as f64,
            millimetres(expected.map(|expected| expected.gap)),
            millimetres(expected.map(|expected| expected.deviation)),
            learned.as_ref().map_or(f64::NAN, |learned| f64::from(u8::from(learned.verdict.converged()))),
            learned.as_ref().map_or(f64::NAN, |learned| learned.fresh_rms),
        ];
        let undetermined = learned.as_ref().map_or(&[][..], |learned| &learned.undetermined);
        let schema = learned.as_ref().map(|learned| &learned.schema).or_else(|| learner.schema());
        if let Some(schema) = schema.filter(|_| due || last) {
            passed.push((n + 1, schema.clone()));
        }
        if let Some(view) = view {
            view.learned(n + 1, Some(touch), schema, expected.map(|expected| expected.gap));
        }
        let measured = truth.zip(schema).filter(|_| due || last);
        let evaluation = measured.map(|(truth, schema)| match &learned {
            Some(learned) => evaluate_learned(creature, skin, truth, learned),
            None => evaluate(creature, skin, truth, schema, undetermined),
        });
        if truth.is_some() {
            row.extend(evaluation.as_ref().map_or([f64::NAN; 4], |e| {
                let hand = e.hand_mm.map_or(f64::NAN, |hand| hand.mean);
                [e.heldout_mm.mean, e.heldout_mm.p95, hand, e.axis_deg.median]
            }));
        }
        table.row(&row)?;
        if last {
            result = learned.map(|learned| (learned, evaluation));
        }
    }
    let (learned, evaluation) = result.ok_or("there is no touch to learn from: babble some first")?;
    let undisturbed_heldout_mm = truth.filter(|_| !disturbances.is_none()).map(|truth| {
        bar.set_message("learning without the disturbances, for comparison");
        let mut learner = options.learner(creature, skin, session.seed);
        touches.iter().for_each(|touch| learner.touch(touch));
        let learned = learner.learn();
        evaluate_learned(creature, skin, truth, &learned).heldout_mm
    });
    bar.finish_and_clear();
    let std = learned.schema_std(creature);
    write_schema_with_std(&folder.join(SCHEMA_FILE), creature, &learned.schema, std.as_ref())?;
    let model = crate::schema::to_mjcf(creature, skin, &learned.schema);
    output::file(&folder.join(LEARNED_FILE), &model)?;
    let undetermined = learned.undetermined.iter().map(|&j| creature.joints()[j].name.clone()).collect();
    let undetermined_limbs =
        learned.undetermined_limbs.iter().map(|&limb| creature.limbs()[limb].clone()).collect();
    let tells = truth.is_none()
        && options.learner == LearnerName::Lm
        && options.skin == SkinName::Surface
        && options.frames == FramesName::Joint;
    let own_account = if tells {
        OwnAccount::new(creature, &felt.skin, options.input(), &felt.touches, &learned)
    } else {
        None
    };
    let result = SessionLearning {
        learned,
        seconds,
        evaluation,
        own_account,
        undetermined,
        undetermined_limbs,
        undisturbed_heldout_mm,
    };
    let record = LearningRecord {
        program: PROGRAM.to_string(),
        command: output::command_line(),
        host: Some(Host::here()),
        seed: session.seed,
        touches: touches.len(),
        facts: facts(session, options, &result),
        converged: result.learned.verdict.converged(),
        verdict: sentence(creature, &result.learned),
        undetermined: result.undetermined.clone(),
        undetermined_limbs: result.undetermined_limbs.clone(),
        open_directions: open_directions(creature, &result.learned),
        bound: result.evaluation.as_ref().and_then(|evaluation| evaluation.bound_mm),
        checkpoints: checkpoints_of(passed, session, &felt, options, truth, &result),
    };
    record.write(folder, creature)?;
    write_report(folder, session, touches, truth)?;
    if let Some(view) = view {
        view.done(&record.verdict, &result.learned.schema, folder.join(REPORT_FILE));
    }
    Ok(result)
}

/// What the report says of how it was learned.
fn facts(session: &Session, options: &LearnOptions, result: &SessionLearning) -> Vec<(String, String)> {
    let mut facts = Vec::new();
    facts.push(("learner", options.learner.to_string()));
    facts.push(("knowledge", options.knowledge().to_string()));
    if options.frames == FramesName::Limb {
        facts.push(("frames of limbs", "their own, learned".to_string()));
    }
    if let Some(known) = options.known_words(&session.creature) {
        facts.push(("joints known beforehand", known));
    }
    if options.disturbances != DisturbanceOptions::default() {
        facts.push(("disturbances", options.disturbances.to_string()));
    }
    facts.push(("random onsets", result.learned.onsets.to_string()));
    facts.push(("learning", format!("{:.2} s", result.seconds)));
    facts.extend(changes(&session.creature, &result.learned).into_iter().map(|change| ("change", change)));
    facts.into_iter().map(|(name, value)| (name.to_string(), value)).collect()
}

/// Every direction in which the schema could change without any touch feeling it, in words.
fn open_directions(creature: &Creature, learned: &Learned) -> Vec<String> {
    learned
        .observability
        .as_ref()
        .map_or(Vec::new(), |observability| observability.undetermined(creature, &learned.schema))
}

/// The schemas on the way with their errors and the bounds of these, where the truth is at hand.
fn checkpoints_of(
    passed: Vec<(usize, BodySchema)>,
    session: &Session,
    felt: &Felt,
    options: &LearnOptions,
    truth: Option<&GroundTruth>,
    result: &SessionLearning,
) -> Vec<Checkpoint> {
    let creature = &session.creature;
    let learned = &result.learned;
    let progress = truth.map(|truth| Progress::new(creature, &session.skin, truth, learned));
    // What touches determine is judged at what was learned in the end: at a wrong schema it says nothing.
    let mut learner = options.second_order(creature, &felt.skin, session.seed);
    let mut touches = felt.touches.iter();
    let bounded = options.learner == LearnerName::Lm && learned.verdict.converged();
    let checkpoint = |(count, schema): (usize, BodySchema)| {
        touches.by_ref().take(count - learner.touches().len()).for_each(|touch| learner.touch(touch));
        let progress = progress.as_ref();
        let bound_rms = progress.filter(|_| bounded && count > 0).and_then(|progress| {
            if count == felt.touches.len() {
                return result.evaluation.as_ref()?.bound_mm.map(|bound| bound.bound_rms);
            }
            progress.bound_rms(&learner.observe(&learned.schema).0)
        });
        let error_rms = progress.and_then(|progress| progress.error_rms(&schema));
        Checkpoint { touches: count, schema, error_rms, bound_rms }
    };
    passed.into_iter().map(checkpoint).collect()
}

/// How the body changed as the learner understood it, in sentences.
fn changes(creature: &Creature, learned: &Learned) -> Vec<String> {
    let sentence = |change: &Change| {
        let what = match &change.what {
            What::Joint { joint, distance } => {
                format!("{} moved by {:.1} mm", creature.joints()[*joint].name, 1e3 * distance)
            }
            What::Corrected { joint, distance } => {
                let name = &creature.joints()[*joint].name;
                format!("{name} had been learned wrongly, by {:.1} mm", 1e3 * distance)
            }
            What::Tool(tool) => {
                let length = 1e3 * (tool.tip - tool.grip).norm();
                format!("{} holds a stick of {length:.0} mm", creature.limbs()[tool.limb])
            }
            What::Beyond => "the body changed beyond what one joint or a stick explains".to_string(),
        };
        format!("from touch {} on, understood at touch {}: {what}", change.since + 1, change.touch + 1)
    };
    learned.changes.iter().map(sentence).collect()
}

/// The verdict in a sentence.
fn sentence(creature: &Creature, learned: &Learned) -> String {
    match &learned.verdict {
        Verdict::Converged => match learned.undetermined.len() {
            0 => "converged: it explains touches that it was not fitted to".to_string(),
            left_out => format!(
                "converged but for {left_out} of {} joints: the rest explains touches that it was not fitted to",
                creature.joints().len()
            ),
        },
        Verdict::Failed(why) => format!("NOT learned: {why}"),
        Verdict::Unjudged(why) => format!("not judged: {why}"),
    }
}

/// After how many touches to measure on the way, where that costs little: a learner that learns as it goes
/// need only be looked at, and contact points are learned in an instant.
fn checkpoints(options: &LearnOptions, touches: usize) -> Vec<usize> {
    let doubling = |from: usize| (0..40).map(move |k| from << k).take_while(move |&n| n < touches);
    // Roughly evenly spaced where touches are counted in powers of ten.
    let round = [50, 70, 100, 150, 200, 300, 500, 700].into_iter();
    let round = (0..).flat_map(move |k| round.clone().map(move |n| n * 10usize.pow(k)));
    match (options.learner, options.input_name()) {
        _ if options.learns_online() => round.take_while(|&n| n < touches).collect(),
        (LearnerName::Hersch, _) => doubling(10).collect(),
        (LearnerName::Lm, InputName::Contact) if touches <= 4000 => doubling(125).collect(),
        (LearnerName::Lm | LearnerName::Gradient, _) => Vec::new(),
    }
}

/// The number of limb pairs that touched.
pub fn limb_pairs(skin: &Skin, touches: &[Touch]) -> usize {
    let pair = |touch: &Touch| touch.ends.map(|end| skin.receptors[end.receptor].limb);
    touches.iter().map(pair).collect::<std::collections::BTreeSet<_>>().len()
}

/// How deep limbs were in each other where motions with physics stopped, millimetres; none where no touch tells.
fn depth_mm(touches: &[Touch]) -> Option<Summary> {
    let depths = || touches.iter().filter_map(|touch| touch.moment).map(|moment| 1e3 * moment.depth);
    depths().next().map(|_| Summary::of(depths()))
}

/// The one JSON object of `babble` and `learn`.
pub fn to_json(
    folder: &Path,
    session: &Session,
    touches: &[Touch],
    options: &LearnOptions,
    result: &SessionLearning,
) -> Value {
    let summary = |s: Option<Summary>| s.map_or(Value::Null, |s| json!(s));
    let evaluation = result.evaluation.as_ref();
    let (verdict, reason) = match &result.learned.verdict {
        Verdict::Converged => (true, Value::Null),
        Verdict::Failed(why) | Verdict::Unjudged(why) => (false, json!(why)),
    };
    json!({
        "creature": session.creature.name(),
        "joints": session.creature.joints().len(),
        "dof": session.creature.dof(),
        "touches": touches.len(),
        "motions": session.effort.map(|effort| effort.motions),
        "limb_pairs": limb_pairs(&session.skin, touches),
        "babbling_s": session.effort.map(|effort| effort.babbling_s),
        "motion": session.options.motion.clone().unwrap_or_else(|| MotionName::default().to_string()),
        "simulated_s": session.effort.and_then(|effort| effort.simulated_s),
        "depth_mm": summary(depth_mm(touches)),
        "learning_s": result.seconds,
        "seed": session.seed,
        "policy": session.options.policy,
        "learner": options.learner.to_string(),
        "input": options.input_name().to_string(),
        "knowledge": options.knowledge(),
        "frames": options.frames.to_string(),
        "known": options.known_json(&session.creature),
        "converged": verdict,
        "reason": reason,
        "onsets": result.learned.onsets,
        "disturbances": options.disturbances.to_json(),
        "heldout_mm": summary(evaluation.map(|e| e.heldout_mm)),
        "undisturbed_heldout_mm": summary(result.undisturbed_heldout_mm),
        "determined_mm": summary(evaluation.map(|e| e.determined_mm)),
        "bound_mm": evaluation.and_then(|e| e.bound_mm),
        "hand_mm": summary(evaluation.and_then(|e| e.hand_mm)),
        "axis_deg": summary(evaluation.map(|e| e.axis_deg)),
        "axis_line_mm": summary(evaluation.map(|e| e.axis_line_mm)),
        "expected_mm": result.own_account.and_then(|account| account.expected_mm),
        "fresh_mm": summary(result.own_account.and_then(|account| account.fresh_mm)),
        "undetermined": result.undetermined,
        "undetermined_limbs": result.undetermined_limbs,
        "changes": changes(&session.creature, &result.learned),
        "session": folder,
    })
}

/// The short table of what was learned.
pub fn print_table(
    folder: &Path,
    session: &Session,
    touches: &[Touch],
    options: &LearnOptions,
    result: &SessionLearning,
) {
    let creature = &session.creature;
    say!(
        "{}: {} joints, {} degrees of freedom, from {} touches of {} limb pairs",
        creature.name(),
        creature.joints().len(),
        creature.dof(),
        touches.len(),
        limb_pairs(&session.skin, touches)
    );
    if let Some(depth) = depth_mm(touches) {
        let simulated = session.effort.and_then(|effort| effort.simulated_s);
        say!(
            "moved by servos{}: limbs {} mm deep in each other on the median, {} mm at 95 %",
            simulated.map_or(String::new(), |seconds| format!(" for {seconds:.0} simulated seconds")),
            output::number(depth.median),
            output::number(depth.p95)
        );
    }
    say!(
        "learner {} on {}: {} random onset{}, {:.2} s",
        options.learner,
        options.knowledge(),
        result.learned.onsets,
        if result.learned.onsets == 1 { "" } else { "s" },
        result.seconds
    );
    if let Some(known) = options.known_words(creature) {
        say!("joints known beforehand: {known}");
    }
    if options.disturbances != DisturbanceOptions::default() {
        say!("disturbances: {}", options.disturbances);
    }
    say!("{}", sentence(creature, &result.learned));
    say!("undetermined joints: {}", output::names(&result.undetermined));
    if options.frames == FramesName::Limb {
        say!("limbs whose own frames are undetermined: {}", output::names(&result.undetermined_limbs));
    }
    changes(creature, &result.learned).iter().for_each(|change| say!("{change}"));
    say!("");
    match &result.evaluation {
        None => print_own_account(result),
        Some(evaluation) => print_evaluation(evaluation),
    }
    if let Some(undisturbed) = &result.undisturbed_heldout_mm {
        say!("without the disturbances: {} mm", output::number(undisturbed.mean));
    }
    say!("\nsession: {}", folder.display());
}

/// What can be told without the truth.
fn print_own_account(result: &SessionLearning) {
    if let Some(account) = &result.own_account {
        if let Some(fresh) = &account.fresh_mm {
            output::head();
            output::row("touches not fitted to, apart", "mm", fresh);
        }
        if let Some(expected) = account.expected_mm {
            say!(
                "  by its own account skin is {} mm off in another limb's frame (root mean square)",
                output::number(expected)
            );
        }
        say!("");
    }
    say!(
        "no model, so nothing is compared with the truth (--model names one); `bodyschema observe` tells more"
    );
}

/// The error measures as a table.
pub fn print_evaluation(evaluation: &Evaluation) {
    output::head();
    output::row("skin in another limb's frame", "mm", &evaluation.heldout_mm);
    if evaluation.determined_mm.max < evaluation.heldout_mm.max {
        output::row("with all between determined", "mm", &evaluation.determined_mm);
    }
    if let Some(hand) = &evaluation.hand_mm {
        output::row("with a hand as one of the two", "mm", hand);
    }
    output::row("angle between axes", "°", &evaluation.axis_deg);
    output::row("distance between axis lines", "mm", &evaluation.axis_line_mm);
    if let Some(bound) = &evaluation.bound_mm {
        print_bound(bound);
    }
}

/// The error beside its bound, both as root mean squares.
fn print_bound(bound: &Bound) {
    say!(
        "\n  root mean square over determined joints: {:.2e} mm, {:.2} times the Cramér-Rao bound of {:.2e} mm",
        bound.error_rms,
        bound.ratio,
        bound.bound_rms
    );
}

/// Says on standard error when a log ends in the middle of a line.
pub fn warn_truncated(log: &TouchLog, folder: &Path) {
    if let Some(line) = log.truncated {
        tell!(
            "the log in {} ends in the middle of line {line}: that touch is left out, all before it are used",
            folder.display()
        );
    }
}
