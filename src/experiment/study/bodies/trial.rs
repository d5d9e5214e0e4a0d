//! One generated body, and what each way to learn comes to with it: all that is found out by one seed.

use std::cell::OnceCell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::super::claims::judge;
use super::{RIGHT, outcome};
use crate::babbling::{BabblingError, BabblingOptions, PolicyName};
use crate::deadline::{Deadline, Tally, apart, computed, count};
use crate::evaluation::{held_out, held_out_points};
use crate::experiment::bodies::{DrawnBody, GeneratedBody};
use crate::experiment::touches::all_touches;
use crate::experiment::{CreatureFault, Embodied, ExperimentError, LearningOptions, ModelSource};
use crate::learning::growth::Growth;
use crate::learning::learners::{HerschsRule, LearnerKind, LevenbergMarquardt, PartByPart, RepairedHersch};
use crate::learning::{Input, Verdict};
use crate::mujoco::Model;
use crate::senses::Touch;
use crate::simulation::{MotionName, SimulationError};

/// Touches by stages, which end by themselves, at the most, in units of those at random.
const STAGED: usize = 4;
/// The share of a way's time after which no touches are made, and that after which nothing more is tried to explain them.
const BABBLING: f64 = 0.65;
const LEARNING: f64 = 0.85;

/// The ways to learn that are compared: as the program does by itself, and each learner from touches at random.
pub const WAYS: [&str; 4] = ["default", "lm", "gradient", "hersch"];

/// How a trial goes.
#[derive(Clone, Debug, PartialEq)]
pub struct BodiesOptions {
    /// Touches at random.
    pub touches: usize,
    /// Work that one way to learn may take with one body, its touches included, in seconds of a core that does nothing else.
    pub seconds: f64,
    /// The ways to learn, of [`WAYS`].
    pub ways: Vec<&'static str>,
}

impl Default for BodiesOptions {
    /// A thousand touches, and as much as a session takes that is not told otherwise.
    fn default() -> BodiesOptions {
        BodiesOptions { touches: 1000, seconds: 50.0, ways: WAYS.to_vec() }
    }
}

/// All that is found out by one seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyTrial {
    /// The seed of the body, its touches and its initial guesses.
    pub seed: u64,
    /// What was drawn.
    pub drawn: DrawnBody,
    /// What each way came to.
    pub ways: Vec<WayTrial>,
    /// Processor time of each, its touches included, seconds.
    pub seconds: Vec<f64>,
}

/// What one way to learn came to with one body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WayTrial {
    /// Its name.
    pub way: String,
    /// How motions were chosen, and the learner.
    pub policy: String,
    /// How it went, in the words of [`outcome`].
    pub outcome: String,
    /// Why it failed, where it did.
    pub reason: String,
    /// Whether the work was spent before all was done.
    pub late: bool,
    /// Touches made.
    pub touches: usize,
    /// Joints, and those named as undetermined.
    pub joints: [usize; 2],
    /// Mean and greatest held-out error, millimetres; none where nothing was learned.
    pub error_mm: Option<[f64; 2]>,
    /// The share of held-out points that are off by no more than a hundredth of a limb's length.
    pub right: f64,
    /// Pairs of limbs that are claimed, and those of them that are wrong.
    pub claims: [usize; 2],
    /// Pairs of limbs that could be claimed.
    pub pairs: usize,
    /// The greatest error of what is claimed, millimetres, and the most of its own deviations that an error is that matters;
    /// none where there is none.
    pub worst: [Option<f64>; 2],
}

/// Why there is nothing to be measured.
#[derive(Clone)]
struct Failed {
    outcome: &'static str,
    reason: String,
    /// Processor time until then, seconds.
    seconds: f64,
}

impl From<ExperimentError> for Failed {
    fn from(error: ExperimentError) -> Failed {
        let untouched = matches!(
            &error,
            ExperimentError::Creature {
                reason: CreatureFault::Babbling(BabblingError::NoTouch { .. })
                    | CreatureFault::Simulation(SimulationError::NoPairs { .. }),
                ..
            }
        );
        let outcome = if untouched { outcome::UNTOUCHED } else { outcome::REFUSED };
        Failed { outcome, reason: error.to_string(), seconds: 0.0 }
    }
}

/// A body that babbled.
struct Babbled {
    policy: PolicyName,
    touches: Vec<Touch>,
    grown: Option<Growth>,
    seconds: f64,
    /// What was done for them.
    done: Tally,
}

/// The body of a seed, and what each way to learn comes to with it: but for the seconds it depends on the seed and the options
/// alone.
pub fn trial(seed: u64, options: &BodiesOptions) -> BodyTrial {
    let touches = options.touches;
    let body = GeneratedBody::new(seed);
    let embodied = unpanicked(|| Ok(embody(&body)?));
    // Ways share the touches at random, where there is one that needs them.
    let random = OnceCell::new();
    let at_random =
        |own| random.get_or_init(|| unpanicked(|| babble(own, PolicyName::Random, touches, seed, options)));
    let mut trial = BodyTrial { seed, drawn: body.drawn.clone(), ways: Vec::new(), seconds: Vec::new() };
    for &way in &options.ways {
        let found = embodied.as_ref().map_err(Clone::clone).and_then(|own| {
            let learner: &'static dyn LearnerKind = match way {
                "default" if Growth::suits(own.creature()) => {
                    let most = touches.saturating_mul(STAGED);
                    let staged = unpanicked(|| babble(own, PolicyName::Stages, most, seed, options))?;
                    return learn(own, &staged, &PartByPart, &body, way, options);
                }
                "gradient" => &RepairedHersch,
                "hersch" => &HerschsRule,
                _ => &LevenbergMarquardt,
            };
            learn(own, at_random(own).as_ref().map_err(Clone::clone)?, learner, &body, way, options)
        });
        let (found, seconds) = found.unwrap_or_else(|Failed { outcome, reason, seconds }| {
            let failed = WayTrial { way: way.into(), outcome: outcome.into(), reason, ..WayTrial::default() };
            (failed, seconds)
        });
        trial.ways.push(found);
        trial.seconds.push(seconds);
    }
    trial
}

/// What something comes to; a panic in it, which is a defect, is told of and ends no study.
fn unpanicked<T>(run: impl FnOnce() -> Result<T, Failed>) -> Result<T, Failed> {
    let began = computed();
    let found = catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let reason = text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
        Err(Failed { outcome: outcome::PANICKED, reason: reason.into(), seconds: 0.0 })
    });
    found.map_err(|failed| Failed { seconds: seconds_since(began), ..failed })
}

/// The body with its skin; one without touch sensors gets some in memory.
fn embody(body: &GeneratedBody) -> Result<Embodied, ExperimentError> {
    let model = Arc::new(Model::from_xml(&body.mjcf)?);
    Embodied::of_model(ModelSource::new(format!("{}.xml", body.name())), model, &())
}

/// Seconds of processor time since a moment.
fn seconds_since(began: Duration) -> f64 {
    computed().saturating_sub(began).as_secs_f64()
}

fn babble(
    embodied: &Embodied,
    policy: PolicyName,
    most: usize,
    seed: u64,
    options: &BodiesOptions,
) -> Result<Babbled, Failed> {
    let began = computed();
    let by = Deadline::after_work_of(BABBLING * options.seconds);
    let babbler = embodied.babbler(MotionName::default())?;
    let babbler = babbler.until(by).learning_from(Input::Receptor);
    let wanted = BabblingOptions { touches: most, seed, jobs: 1 };
    let mut touches = Vec::new();
    let make =
        || all_touches(embodied.model(), &babbler, policy, &wanted, |touch| touches.push(touch.clone()));
    let (made, done) = apart(make);
    let (_, grown) = made?;
    Ok(Babbled { policy, touches, grown, seconds: seconds_since(began), done })
}

/// What a way to learn comes to with the touches of a body, and its seconds, the touches included.
fn learn(
    embodied: &Embodied,
    babbled: &Babbled,
    kind: &'static dyn LearnerKind,
    body: &GeneratedBody,
    way: &str,
    options: &BodiesOptions,
) -> Result<(WayTrial, f64), Failed> {
    let began = computed();
    let with_touches = |seconds: f64| babbled.seconds + seconds;
    let found = unpanicked(|| Ok(learned(embodied, babbled, kind, body, way, options)));
    match found {
        Ok(found) => Ok((found, with_touches(seconds_since(began)))),
        Err(failed) => Err(Failed { seconds: with_touches(failed.seconds), ..failed }),
    }
}

/// Learns, and holds what came of it against the truth.
fn learned(
    embodied: &Embodied,
    babbled: &Babbled,
    kind: &'static dyn LearnerKind,
    body: &GeneratedBody,
    way: &str,
    options: &BodiesOptions,
) -> WayTrial {
    let (agent, creature) = (embodied.agent(), embodied.creature());
    // Ways share touches, and each has the work that these leave.
    let by = Deadline::after_work_of(LEARNING * options.seconds);
    count(babbled.done);
    let how = LearningOptions { learner: kind, deadline: by, ..LearningOptions::default() };
    let mut learner = how.learner_from(agent, babbled.grown.as_ref(), body.seed);
    learner.end_at(by);
    babbled.touches.iter().for_each(|touch| learner.touch(touch));
    let (learned, done) = apart(|| learner.learn());
    let late = done.ended || babbled.done.ended;

    let points = held_out_points(agent);
    let judged = judge(embodied, &learned, &points);
    let errors = held_out(creature, embodied.truth(), &learned.schema, &points);
    let millimetres = || errors.iter().map(|error| error.millimetres);
    let (count, limit) = (errors.len() as f64, 1e3 * RIGHT * body.drawn.length);
    let error_mm = [millimetres().sum::<f64>() / count, millimetres().fold(0.0, f64::max)];
    let skinned = agent.limbs_with_skin().len();
    let (outcome, reason) = match learned.verdict {
        Verdict::Converged if judged.joints_named + judged.limbs_named == 0 => {
            (outcome::LEARNED, String::new())
        }
        Verdict::Converged => (outcome::EXCEPT, String::new()),
        Verdict::Failed(why) => (outcome::NOT, why),
        Verdict::Unjudged(why) => (outcome::UNJUDGED, why),
    };
    WayTrial {
        way: way.into(),
        policy: format!("{}, {}", babbled.policy, kind.name()),
        outcome: outcome.into(),
        reason,
        late,
        touches: babbled.touches.len(),
        joints: [creature.joints().len(), judged.joints_named],
        error_mm: error_mm.iter().all(|error| error.is_finite()).then_some(error_mm),
        right: if errors.is_empty() {
            0.0
        } else {
            millimetres().filter(|&error| error <= limit).count() as f64 / count
        },
        claims: [judged.claims, judged.wrong],
        pairs: skinned * skinned.saturating_sub(1) / 2,
        worst: [judged.worst_mm, judged.worst_deviations]
            .map(|worst| Some(worst).filter(|worst| worst.is_finite())),
    }
}
