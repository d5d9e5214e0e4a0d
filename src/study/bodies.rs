//! What each learner makes of bodies that nobody designed: a benchmark, and the widest test that the learners get.
//!
//! A trial is a seed: of the body, its touches and its initial guesses. A body that is refused, touches nothing, or makes a
//! learner panic is a row that says so.

use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use serde_json::{Value, json};

use super::generated::GeneratedBody;
use super::{Row, Studied, Study, Trial, columns};
use crate::agent::Agent;
use crate::babbling::{BabblingOptions, PolicyName};
use crate::deadline::{Deadline, Tally, apart, count};
use crate::error::Error;
use crate::evaluation::{HeldOutPoint, held_out, held_out_points};
use crate::learning::growth::Growth;
use crate::learning::learners::{HerschsRule, LearnerKind, LevenbergMarquardt, PartByPart};
use crate::learning::{Input, Learned, Learner, LengthUnit, SecondOrder, Verdict, Z95};
use crate::mujoco::Model;
use crate::senses::{DisturbedSenses, RecordedTouch};
use crate::session::{
    BABBLING_SHARE, DisturbanceLevels, Embodied, LEARNING_SHARE, LearningOptions, ModelSource, SessionRequest,
};
use crate::simulation::MotionName;

pub(super) const STUDY: Study = Study {
    name: "bodies",
    about: "what each learner makes of bodies that are drawn at random, and whether anything is claimed wrongly",
    of: Studied::Generated,
    touches: Some(1000),
    seconds: Some(50.0),
    cases: || WAYS.iter().map(|way| way.name.to_string()).collect(),
    columns: columns! {
        way: Case, family: Part, seed, limb_m, limbs, dof, hinges, slides, balls, locked, spins, followers,
        skew, policy, touches, outcome, touched: Sum, refused: Sum, whole: Sum, learned: Sum,
        learned_partly: Sum, not_learned: Sum, late: Sum, joints, joints_named, heldout_mm,
        worst_heldout_mm, heldout_percent: Median, right, pairs: Sum, determined: Sum, claims: Sum,
        wrong: Sum, worst_mm, worst_deviations, work_s: Median, reason, command,
    },
    notes: &[
        "whole: bodies of which 95 % of all held-out points are off by at most 1 % of the typical limb's length, whatever the \
         learner says; right: the share of these points. learned, learned_partly, not_learned: what the learner says; hersch \
         makes no judgement and claims nothing.",
        "A claim is that the skin of two limbs is located in each other's frames. It is wrong if held-out skin is off by more \
         than 0.1 mm (on bodies much smaller or larger than a person, by more than its share) and 5 of its own standard \
         deviations.",
        "determined: pairs of limbs whose skin the same touches locate in each other's frames, as they would be accounted for at the \
         true schema.",
        "default: as `bodyschema babble BODY` learns, by stages and growth if that suits the body; the others learn from the \
         same touches at random. late: the work that a way may take was spent before all was done. The column command of the \
         table makes a row's session again.",
    ],
    run,
};

/// A way to learn.
struct Way {
    name: &'static str,
    learner: &'static dyn LearnerKind,
    input: Input,
    /// What is wrong with the senses, on a body of a person's size; lengths are in proportion.
    disturbances: DisturbanceLevels,
}

impl Way {
    /// What is wrong with the senses of a body.
    fn disturbances(&self, agent: &Agent) -> DisturbanceLevels {
        let receptor_noise = LengthUnit::of(agent).metres() * self.disturbances.receptor_noise;
        DisturbanceLevels { receptor_noise, ..self.disturbances }
    }

    /// The options of a session that learns of a body so, each after a blank.
    fn options(&self, agent: &Agent) -> String {
        let input = (self.input == Input::Contact).then(|| " --input contact".to_string());
        let DisturbanceLevels { joint_noise, receptor_noise, false_touches, .. } = self.disturbances(agent);
        let levels = [
            ("joint-noise", joint_noise),
            ("receptor-noise", receptor_noise),
            ("false-touches", false_touches),
        ];
        let levels = levels.into_iter().filter(|(_, level)| *level > 0.0);
        input.into_iter().chain(levels.map(|(name, level)| format!(" --{name} {level}"))).collect()
    }
}

const EXACT: DisturbanceLevels = DisturbanceLevels::NONE;
const ROUGH_ANGLES: DisturbanceLevels = DisturbanceLevels { joint_noise: 0.1, ..EXACT };
const ROUGHER_ANGLES: DisturbanceLevels = DisturbanceLevels { joint_noise: 1.0, ..EXACT };
const LM: Way = Way { name: "lm", learner: &LevenbergMarquardt, input: Input::Receptor, disturbances: EXACT };
const BY_CONTACT: Way = Way { input: Input::Contact, ..LM };

/// The ways to learn: as the program does by default, and each learner from touches at random; `lm` also by contact points, and
/// with senses that are wrong.
const WAYS: [Way; 11] = [
    Way { name: "default", learner: &PartByPart, ..LM },
    LM,
    Way { name: "hersch", learner: &HerschsRule, ..LM },
    Way { name: "angles to 0.1°", disturbances: ROUGH_ANGLES, ..LM },
    Way { name: "angles to 1°", disturbances: ROUGHER_ANGLES, ..LM },
    Way { name: "receptors to 3 mm", disturbances: DisturbanceLevels { receptor_noise: 3.0, ..EXACT }, ..LM },
    Way { name: "5 % false", disturbances: DisturbanceLevels { false_touches: 0.05, ..EXACT }, ..LM },
    Way { name: "20 % false", disturbances: DisturbanceLevels { false_touches: 0.2, ..EXACT }, ..LM },
    Way { name: "contact", ..BY_CONTACT },
    Way { name: "contact, angles to 0.1°", disturbances: ROUGH_ANGLES, ..BY_CONTACT },
    Way { name: "contact, angles to 1°", disturbances: ROUGHER_ANGLES, ..BY_CONTACT },
];
/// Touches by stages, which end when all is known, at most, in units of those at random.
const STAGED: usize = 4;
/// Skin that is off by no more than this share of the typical limb's length is right: a task would hardly notice.
const RIGHT: f64 = 0.01;
/// The share of held-out points that are right on a body that is learned by the truth's measure.
const WHOLE: f64 = 0.95;
/// A claim is not wrong by less than this on a body of a person's size, millimetres: too little to matter to any task.
const NEGLIGIBLE_MM: f64 = 0.1;
/// A claim is not wrong by fewer of its own standard deviations: one in two million by chance.
const DEVIATIONS: f64 = 5.0;

/// A body that babbled.
struct Babbled {
    policy: PolicyName,
    touches: Vec<RecordedTouch>,
    grown: Option<Growth>,
    work: Tally,
}

fn run(trial: &Trial) -> Result<Vec<Row>, Error> {
    let body = GeneratedBody::new(trial.seed);
    let embodied = survived(|| embody(&body));
    // Ways share the touches at random, if one needs them.
    let random = OnceCell::new();
    let row = |way: &Way| {
        let found = embodied.as_ref().map_err(Clone::clone).and_then(|own| {
            let by_default = way.learner.name() == PartByPart.name();
            if by_default && Growth::suits(own.creature()) {
                let most = trial.touches.saturating_mul(STAGED);
                let staged = survived(|| babble(own, PolicyName::Stages, most, trial))?;
                return learn(own, &staged, way, &body, trial);
            }
            let at_random =
                random.get_or_init(|| survived(|| babble(own, PolicyName::Random, trial.touches, trial)));
            let way = if by_default { &LM } else { way };
            learn(own, at_random.as_ref().map_err(Clone::clone)?, way, &body, trial)
        });
        let mut row = found.unwrap_or_else(|failed| failed);
        let options = embodied.as_ref().map(|own| way.options(own.agent())).unwrap_or_default();
        describe(&mut row, way.name, &body, &options);
        row
    };
    Ok(WAYS.iter().filter(|way| trial.asks(way.name)).map(row).collect())
}

/// Adds what was drawn, how it went in counts, and the command of a session with these `options`.
fn describe(row: &mut Row, way: &str, body: &GeneratedBody, options: &str) {
    if let Value::Object(drawn) = json!(body.drawn) {
        drawn.into_iter().for_each(|(name, value)| row[name] = value);
    }
    row["limb_m"] = row["length"].take();
    row["way"] = json!(way);
    let outcome = row["outcome"].as_str().unwrap_or_default();
    let counts = [
        ("touched", outcome != "touched nothing"),
        ("refused", outcome == "refused" || outcome == "panicked"),
        ("learned", outcome == "learned"),
        ("learned_partly", outcome == "learned partly"),
        ("not_learned", outcome == "not learned"),
    ];
    counts.into_iter().for_each(|(name, holds)| row[name] = json!(holds));
    let babble = match row["policy"].as_str().and_then(|policy| policy.split_once(", ")) {
        Some(("random", learner)) => {
            format!(" --policy random --learner {learner} --touches {}{}", row["touches"], options)
        }
        _ => String::new(),
    };
    let (seed, name) = (body.seed, body.name());
    row["command"] = json!(format!(
        "bodyschema study generate --seed {seed} --out {name}.xml && bodyschema babble {name}.xml --seed {seed}{babble}"
    ));
}

/// What something comes to, or the row of why there is nothing to be measured; a panic in it, which is a defect, is a finding and
/// ends no study.
fn survived<T>(run: impl FnOnce() -> Result<T, Error>) -> Result<T, Row> {
    let (found, work) = apart(|| catch_unwind(AssertUnwindSafe(run)));
    let (outcome, reason) = match found {
        Ok(Ok(found)) => return Ok(found),
        Ok(Err(error)) if error.is_no_contact() => ("touched nothing", error.to_string()),
        Ok(Err(error)) => ("refused", error.to_string()),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            ("panicked", text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("no message").into())
        }
    };
    Err(json!({"outcome": outcome, "reason": reason, "work_s": work.seconds(), "touches": 0, "right": 0.0,
               "whole": false, "pairs": 0, "determined": 0, "claims": 0, "wrong": 0, "late": false, "joints": 0, "joints_named": 0}))
}

/// The body with its skin; what has no touch sensors gets them in memory.
fn embody(body: &GeneratedBody) -> Result<Embodied, Error> {
    let model = Arc::new(Model::from_xml(&body.mjcf)?);
    Embodied::of_model(ModelSource::new(format!("{}.xml", body.name())), model, &())
}

fn babble(embodied: &Embodied, policy: PolicyName, most: usize, trial: &Trial) -> Result<Babbled, Error> {
    let by = Deadline::after_work_of(BABBLING_SHARE * trial.seconds);
    let babbler = embodied.babbler(MotionName::default())?.until(by).learning_from(Input::Receptor);
    let wanted = BabblingOptions { touches: most, seed: trial.seed, jobs: 1 };
    let (made, work) = apart(|| embodied.touches(&babbler, policy, &wanted));
    let (touches, grown) = made?;
    Ok(Babbled { policy, touches, grown, work })
}

/// What a learner comes to with the touches of a body.
fn learn(
    embodied: &Embodied,
    babbled: &Babbled,
    way: &Way,
    body: &GeneratedBody,
    trial: &Trial,
) -> Result<Row, Row> {
    survived(|| {
        // Ways share touches, and each has the work that these leave.
        let by = Deadline::after_work_of(LEARNING_SHARE * trial.seconds);
        count(babbled.work);
        let disturbances = way.disturbances(embodied.agent());
        let how = LearningOptions {
            learner: Some(way.learner),
            input: Some(way.input),
            disturbances,
            deadline: by,
            ..LearningOptions::default()
        };
        let felt =
            disturbances.disturbances().felt(embodied.agent(), &babbled.touches, way.input, trial.seed);
        let mut learner = how.learner_from(&felt.agent, babbled.grown.as_ref(), trial.seed);
        learner.end_at(by);
        felt.touches.iter().for_each(|touch| learner.touch(touch));
        let (learned, work) = apart(|| learner.learn());
        let mut row = measured(embodied, &learned, body.drawn.length);
        row["determined"] = json!(determined(embodied, &felt, way.input));
        row["policy"] = json!(format!("{}, {}", babbled.policy, way.learner.name()));
        row["touches"] = json!(babbled.touches.len());
        row["late"] = json!(work.ended || babbled.work.ended);
        row["work_s"] = json!(work.seconds() + babbled.work.seconds());
        Ok(row)
    })
}

/// The row of a creature that babbles and learns as the program does by default.
pub fn by_default(source: &ModelSource, input: Input, seed: u64) -> Row {
    let found = survived(|| {
        let learning = LearningOptions { input: Some(input), ..LearningOptions::default() };
        let request = SessionRequest { seed, learning, ..SessionRequest::default() };
        let body = Embodied::open(source.clone(), &())?.babble_as(&request)?.learn()?;
        let unit = LengthUnit::of(body.embodied().agent()).metres();
        let mut row = measured(body.embodied(), body.learned(), unit);
        row["touches"] = json!(body.touches().len());
        Ok(row)
    });
    found.unwrap_or_else(|failed| failed)
}

/// How many pairs of limbs with skin touches locate in each other's frames by an account of them at the true schema.
fn determined(embodied: &Embodied, felt: &DisturbedSenses, input: Input) -> usize {
    let unit = LengthUnit::of(&felt.agent);
    let to_unit = 1.0 / unit.metres();
    let mut learner = SecondOrder::new(&unit.agent(&felt.agent), input, 0);
    felt.touches.iter().for_each(|touch| learner.touch(&touch.scaled(embodied.creature(), to_unit)));
    let (account, _) = learner.account(&embodied.truth().schema.scaled(to_unit));
    let limbs = embodied.agent().limbs_with_skin();
    let is_claimed =
        |(i, a): (usize, &usize)| limbs[i + 1..].iter().filter(|&&b| account.claims(*a, b)).count();
    limbs.iter().enumerate().map(is_claimed).sum()
}

/// Compares what was learned with the truth, of a body whose limbs are typically so long, metres.
fn measured(embodied: &Embodied, learned: &Learned, length: f64) -> Row {
    let (agent, creature) = (embodied.agent(), embodied.creature());
    let points = held_out_points(agent);
    let errors = held_out(creature, embodied.truth(), &learned.schema, &points);
    let (count, limit) = (errors.len() as f64, 1e3 * RIGHT * length);
    let mean = errors.iter().sum::<f64>() / count;
    let right = errors.iter().filter(|&&error| error <= limit).count() as f64 / count.max(1.0);
    let [joints_named, limbs_named] = [learned.undetermined().len(), learned.undetermined_limbs().len()];
    let (outcome, reason) = match learned.verdict.clone() {
        Verdict::Converged if joints_named + limbs_named == 0 => ("learned", String::new()),
        Verdict::Converged => ("learned partly", String::new()),
        Verdict::Failed(why) => ("not learned", why),
        Verdict::Unjudged(why) => ("not judged", why),
    };
    let skinned = agent.limbs_with_skin().len();
    let mut row = json!({
        "outcome": outcome,
        "reason": reason,
        "joints": creature.joints().len(),
        "joints_named": joints_named,
        "limbs_named": limbs_named,
        "heldout_mm": mean,
        "worst_heldout_mm": errors.iter().copied().fold(f64::NAN, f64::max),
        "heldout_percent": 0.1 * mean / length,
        "right": right,
        "whole": right >= WHOLE,
        "pairs": skinned * skinned.saturating_sub(1) / 2,
    });
    judge(&mut row, embodied, learned, (&points, &errors));
    row
}

/// Compares the claims of a learner with the truth: that skin of two limbs of one class of its account is located in each other's
/// frames. Adds how many pairs of limbs are claimed, how many of these wrongly, the greatest error of a claim, and the most of its
/// own deviations that an error is that matters.
fn judge(row: &mut Row, embodied: &Embodied, learned: &Learned, (points, errors): (&[HeldOutPoint], &[f64])) {
    (row["claims"], row["wrong"]) = (json!(0), json!(0));
    let Some(account) = learned.reliable_account() else { return };
    // What is off by little of a person is off by much of a hand.
    let negligible = LengthUnit::of(embodied.agent()).metres() * NEGLIGIBLE_MM;
    // Metres; of a point that has none, the deviation that would just be claimed.
    let deviation = |HeldOutPoint { posture, limbs, p_a, .. }: &HeldOutPoint| {
        let (creature, observed) = (embodied.creature(), &account.observability);
        let own = observed.point_deviation(creature, &learned.schema, posture, *limbs, p_a);
        if own.is_finite() { own } else { account.limit() / Z95 }
    };
    let (mut worst_mm, mut worst_deviations) = (f64::NAN, f64::NAN);
    // Per pair of limbs that is claimed, whether that is wrong.
    let mut claims: BTreeMap<[usize; 2], bool> = BTreeMap::new();
    for (point, millimetres) in points.iter().zip(errors) {
        let [a, b] = point.limbs;
        if !account.claims(a, b) {
            continue;
        }
        let matters = *millimetres > negligible;
        let deviations = if matters { millimetres / (1e3 * deviation(point)) } else { f64::NAN };
        worst_mm = millimetres.max(worst_mm);
        worst_deviations = deviations.max(worst_deviations);
        *claims.entry([a.min(b), a.max(b)]).or_default() |= deviations > DEVIATIONS;
    }
    row["claims"] = json!(claims.len());
    row["wrong"] = json!(claims.values().filter(|is_wrong| **is_wrong).count());
    (row["worst_mm"], row["worst_deviations"]) = (json!(worst_mm), json!(worst_deviations));
}
