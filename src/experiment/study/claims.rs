//! Whether what a learner claims is so: many sessions, and every claim held against the truth.
//!
//! A claim is that two limbs are of one class of the [`Account`]: skin of either is placed in
//! the other's frame. It is wrong where held-out skin is off by more than is too little to matter and by more than the
//! claim's own deviations allow.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median};
use super::table::{WallTime, row};
use super::{Findings, Study, Trial, Trials};
use crate::babbling::{BabblingOptions, PolicyName};
use crate::creature::JointSelection;
use crate::evaluation::{HeldOutError, HeldOutPoint, held_out, held_out_points};
use crate::experiment::touches::all_touches;
use crate::experiment::{Embodied, ExperimentError, LearningOptions};
use crate::learning::{Account, AxisModel, Input, Learned, LengthUnit, Parameters, Verdict, What, Z95};
use crate::senses::Touch;
use crate::session::DisturbanceLevels;
use crate::simulation::MotionName;

/// The study `claims`.
pub const STUDY: Study = Study {
    name: "claims",
    about: "how many claims are wrong, of lm over creatures, inputs, counts of touches and noises, and of growth by stages",
    touches: false,
    several: true,
    trials: Trials::of::<ClaimsTrial>(),
};

/// The policies whose sessions it looks at.
pub const POLICIES: [PolicyName; 2] = [PolicyName::Random, PolicyName::Stages];

/// Touches per unknown number of the schema: too few, as many as it takes at the least, enough, many.
const TOUCHES_PER_UNKNOWN: [f64; 4] = [0.5, 1.0, 2.0, 4.0];
/// The same where senses are disturbed.
const DISTURBED_TOUCHES_PER_UNKNOWN: f64 = 4.0;
/// The most touches by the policy `stages`, from which the learner `growth` learns, per unknown number: sessions end by
/// themselves.
const STAGED_TOUCHES_PER_UNKNOWN: f64 = 24.0;
/// Shares of the touches of such a session after which it is taken to have ended.
const ENDS: [f64; 4] = [0.4, 0.6, 0.8, 1.0];
/// What is wrong with the senses: nothing, and so much in one way. Receptors that are misplaced are felt by receptors
/// alone, points that are inexact by contact points.
const NOISES: [DisturbanceLevels; 6] = [
    NONE,
    DisturbanceLevels { joint_noise: 0.1, ..NONE },
    DisturbanceLevels { joint_noise: 1.0, ..NONE },
    DisturbanceLevels { receptor_noise: 1.0, point_noise: 1.0, ..NONE },
    DisturbanceLevels { receptor_noise: 3.0, point_noise: 3.0, ..NONE },
    DisturbanceLevels { false_touches: 0.2, ..NONE },
];
const NONE: DisturbanceLevels =
    DisturbanceLevels { joint_noise: 0.0, receptor_noise: 0.0, false_touches: 0.0, point_noise: 0.0 };
/// A claim is not wrong by less than this on a body of a person's size, millimetres, nor by less than its share on another:
/// too little to matter to anyone …
pub(super) const NEGLIGIBLE_MM: f64 = 0.1;
/// … nor by fewer of its own standard deviations: one in two million by chance.
pub(super) const DEVIATIONS: f64 = 5.0;
/// Limbs whose skin is off by no more are placed in truth, whatever is said of them, millimetres.
const RIGHT_MM: f64 = 1.0;

row! {
    /// A session of the study `claims`.
    pub struct ClaimsMeasurement {
        creature: String = "creature",
        policy: String = "policy",
        input: String = "input",
        noise: String = "noise",
        seed: u64 = "seed",
        touches: usize = "touches",
        verdict: String = "verdict",
        joints_named: usize = "joints named",
        limbs_named: usize = "limbs named",
        claims: usize = "claims",
        wrong: usize = "wrong",
        worst_mm: f64 = "worst claim, mm",
        worst_deviations: f64 = "its deviations",
        right: usize = "pairs placed in truth",
        right_claimed: usize = "of these claimed",
        false_changes: usize = "false changes",
        seconds: WallTime = "seconds",
        reason: String = "reason",
        command: String = "command",
    }
}

row! {
    /// A row of the summary of the study `claims`.
    pub struct ClaimsSummary {
        creature: String = "creature",
        policy: String = "policy",
        input: String = "input",
        noise: String = "noise",
        sessions: usize = "sessions",
        learned: usize = "learned",
        learned_except: usize = "except",
        not_learned: usize = "not",
        claims: usize = "claims",
        wrong: usize = "wrong",
        wrong_sessions: usize = "wrong sessions",
        false_changes: usize = "false changes",
        right_claimed: f64 = "right ones claimed",
        worst_mm: f64 = "worst claim, mm",
        seconds: WallTime = "seconds",
    }
}

/// One session to be made of a creature's touches by a seed.
struct Condition {
    policy: PolicyName,
    input: Input,
    noise: DisturbanceLevels,
    touches: usize,
}

/// The sessions of one trial, creature by creature.
#[derive(Debug, Serialize, Deserialize)]
pub struct ClaimsTrial(Vec<ClaimsMeasurement>);

impl Trial for ClaimsTrial {
    type Setting = ();
    type Measurement = ClaimsMeasurement;
    type Summary = ClaimsSummary;

    fn set_up(_subject: &Subject) -> Result<(), ExperimentError> {
        Ok(())
    }

    fn run(subject: &Subject, (): &(), seed: u64) -> Result<ClaimsTrial, ExperimentError> {
        let mut measurements = Vec::new();
        let asked = |policy: PolicyName| subject.policy.is_none_or(|asked| asked == policy);
        for creature in subject.creatures() {
            subject.tell(seed, creature.creature().name());
            let points = held_out_points(creature.agent());
            let parts = [random(creature), staged(creature)];
            for (policy, most) in parts.into_iter().filter(|(policy, _)| asked(*policy)) {
                let touches = babble(creature, policy, most, seed)?;
                let conditions = conditions(creature, policy, touches.len());
                let session_of =
                    |condition: &Condition| session(creature, &points, &touches, condition, seed);
                measurements.par_extend(conditions.par_iter().map(session_of));
            }
        }
        Ok(ClaimsTrial(measurements))
    }

    fn findings(_subject: &Subject, trials: &[ClaimsTrial]) -> Findings<ClaimsMeasurement, ClaimsSummary> {
        findings(trials.iter().flat_map(|trial| trial.0.clone()).collect())
    }
}

/// How a creature babbles at random, and how many touches at the most.
fn random(creature: &Embodied) -> (PolicyName, usize) {
    let most = TOUCHES_PER_UNKNOWN.into_iter().fold(DISTURBED_TOUCHES_PER_UNKNOWN, f64::max);
    (PolicyName::Random, touches(creature, most))
}

/// How it grows by stages, and how many touches at the most.
fn staged(creature: &Embodied) -> (PolicyName, usize) {
    (PolicyName::Stages, touches(creature, STAGED_TOUCHES_PER_UNKNOWN))
}

/// The sessions that some touches of a creature are taken for, by the policy that made so many.
fn conditions(creature: &Embodied, policy: PolicyName, made: usize) -> Vec<Condition> {
    let exact = |touches: usize| Condition { policy, input: Input::Receptor, noise: NONE, touches };
    if policy == PolicyName::Stages {
        return ENDS.iter().map(|share| exact((share * made as f64).round() as usize)).collect();
    }
    let mut found = Vec::new();
    for input in [Input::Receptor, Input::Contact] {
        for noise in NOISES {
            let felt = match input {
                Input::Receptor => DisturbanceLevels { point_noise: 0.0, ..noise },
                Input::Contact => DisturbanceLevels { receptor_noise: 0.0, ..noise },
            };
            let counts: &[f64] =
                if noise == NONE { &TOUCHES_PER_UNKNOWN } else { &[DISTURBED_TOUCHES_PER_UNKNOWN] };
            let counts = counts.iter().map(|&each| touches(creature, each));
            found.extend(counts.map(|touches| Condition { input, noise: felt, ..exact(touches) }));
        }
    }
    found
}

/// So many touches per unknown number of a creature's schema.
fn touches(creature: &Embodied, each: f64) -> usize {
    let unknowns = Parameters::new(creature.creature(), AxisModel::Unit, |_| true).len() as f64;
    (each * unknowns).round().max(1.0) as usize
}

fn babble(
    creature: &Embodied,
    policy: PolicyName,
    touches: usize,
    seed: u64,
) -> Result<Vec<Touch>, ExperimentError> {
    let options = BabblingOptions { touches, seed, jobs: rayon::current_num_threads() };
    let mut made = Vec::new();
    let babbler = creature.babbler(MotionName::default())?;
    all_touches(creature.model(), &babbler, policy, &options, |touch| made.push(touch.clone()))?;
    Ok(made)
}

/// Learns from the first touches, and holds what is claimed against the truth.
fn session(
    creature: &Embodied,
    points: &[HeldOutPoint],
    made: &[Touch],
    condition: &Condition,
    seed: u64,
) -> ClaimsMeasurement {
    let options = LearningOptions {
        learner: LearningOptions::default_learner(Some(condition.policy)),
        input: Some(condition.input),
        disturbances: condition.noise,
        ..LearningOptions::default()
    };
    let began = std::time::Instant::now();
    let touches = &made[..condition.touches.min(made.len())];
    let felt = condition.noise.disturbances().felt(creature.agent(), touches, seed);
    let mut learner = options.learner(&felt.agent, seed);
    felt.touches.iter().for_each(|touch| learner.touch(touch));
    let learned = learner.learn();
    let seconds = WallTime(began.elapsed().as_secs_f64());
    let judged = judge(creature, &learned, points);
    let changed = |change: &&crate::learning::BodyChange| !matches!(change.what, What::Corrected { .. });
    let (verdict, reason) = match &learned.verdict {
        Verdict::Converged if judged.joints_named + judged.limbs_named == 0 => ("learned", ""),
        Verdict::Converged => ("learned except", ""),
        Verdict::Failed(why) => ("not learned", why.as_str()),
        Verdict::Unjudged(why) => ("not judged", why.as_str()),
    };
    ClaimsMeasurement {
        creature: creature.creature().name().into(),
        policy: condition.policy.to_string(),
        input: condition.input.to_string(),
        noise: condition.noise.to_string(),
        seed,
        touches: touches.len(),
        verdict: verdict.into(),
        joints_named: judged.joints_named,
        limbs_named: judged.limbs_named,
        claims: judged.claims,
        wrong: judged.wrong,
        worst_mm: judged.worst_mm,
        worst_deviations: judged.worst_deviations,
        right: judged.right,
        right_claimed: judged.right_claimed,
        false_changes: learned.changes.iter().filter(changed).count(),
        seconds,
        reason: reason.into(),
        command: command(creature, condition, seed),
    }
}

/// The command line that makes a session again.
fn command(creature: &Embodied, condition: &Condition, seed: u64) -> String {
    let DisturbanceLevels { joint_noise, receptor_noise, false_touches, point_noise } = condition.noise;
    let mut words = format!("bodyschema babble {}", creature.model().display());
    if creature.source().joints != JointSelection::Default {
        words += &format!(" --joints {}", creature.source().joints);
    }
    words += &format!(" --seed {seed} --touches {}", condition.touches);
    words += &match condition.policy {
        PolicyName::Stages => " --policy stages --learner growth".to_string(),
        _ => format!(" --policy random --input {}", condition.input),
    };
    let levels = [
        ("joint-noise", joint_noise),
        ("receptor-noise", receptor_noise),
        ("false-touches", false_touches),
        ("point-noise", point_noise),
    ];
    for (option, level) in levels.into_iter().filter(|(_, level)| *level > 0.0) {
        words += &format!(" --{option} {level}");
    }
    words
}

/// Claims held against the truth.
pub(super) struct Judged {
    pub joints_named: usize,
    pub limbs_named: usize,
    /// Pairs of limbs that are claimed, and those of them that are wrong.
    pub claims: usize,
    pub wrong: usize,
    /// The greatest error of what is claimed, and the most of its own deviations that an error is that matters.
    pub worst_mm: f64,
    pub worst_deviations: f64,
    /// Pairs of limbs that are placed in truth, and those of them that are claimed.
    pub right: usize,
    pub right_claimed: usize,
}

/// Holds what a learner claims against the truth, at held-out points.
pub(super) fn judge(creature: &Embodied, learned: &Learned, points: &[HeldOutPoint]) -> Judged {
    let (agent, schema) = (creature.agent(), &learned.schema);
    let account = learned.account.as_ref().filter(|_| learned.verdict.converged());
    // What is off by little of a person is off by much of a hand.
    let unit = LengthUnit::of(agent).metres();
    let (negligible, right) = (unit * NEGLIGIBLE_MM, unit * RIGHT_MM);
    let mut judged = Judged {
        joints_named: learned.undetermined().len(),
        limbs_named: learned.undetermined_limbs().len(),
        claims: 0,
        wrong: 0,
        worst_mm: f64::NAN,
        worst_deviations: f64::NAN,
        right: 0,
        right_claimed: 0,
    };
    let errors = held_out(agent.creature(), creature.truth(), schema, points);
    let mut pairs: BTreeMap<[usize; 2], Vec<(&HeldOutPoint, &HeldOutError)>> = BTreeMap::new();
    for (point, error) in points.iter().zip(&errors) {
        let [a, b] = point.limbs;
        pairs.entry([a.min(b), a.max(b)]).or_default().push((point, error));
    }
    for ([a, b], of_pair) in pairs {
        let worst = of_pair.iter().map(|(_, error)| error.millimetres).fold(0.0, f64::max);
        let claiming = account.filter(|account| account.claims(a, b));
        judged.right += usize::from(worst <= right);
        let Some(account) = claiming else { continue };
        judged.right_claimed += usize::from(worst <= right);
        judged.claims += 1;
        judged.worst_mm = judged.worst_mm.max(worst);
        let mut wrong = false;
        for (point, error) in of_pair.iter().filter(|(_, error)| error.millimetres > negligible) {
            let deviations = error.millimetres / (1e3 * deviation(creature, learned, account, point));
            judged.worst_deviations = judged.worst_deviations.max(deviations);
            wrong |= deviations > DEVIATIONS;
        }
        judged.wrong += usize::from(wrong);
    }
    judged
}

/// The standard deviation that a claim has of a point, metres; of what has none, that which would just be claimed.
fn deviation(creature: &Embodied, learned: &Learned, account: &Account, point: &HeldOutPoint) -> f64 {
    let own = account.observability.point_deviation(
        creature.creature(),
        &learned.schema,
        &point.posture,
        point.limbs,
        &point.p_a,
    );
    if own.is_finite() { own } else { account.limit() / Z95 }
}

fn findings(measurements: Vec<ClaimsMeasurement>) -> Findings<ClaimsMeasurement, ClaimsSummary> {
    let mut groups: Vec<([String; 4], Vec<&ClaimsMeasurement>)> = Vec::new();
    for one in &measurements {
        let key = [&one.creature, &one.policy, &one.input, &one.noise].map(String::clone);
        match groups.iter_mut().find(|(other, _)| *other == key) {
            Some((_, rows)) => rows.push(one),
            None => groups.push((key, vec![one])),
        }
    }
    let all = ["all"; 4].map(String::from);
    groups.push((all, measurements.iter().collect()));
    let summary: Vec<ClaimsSummary> = groups.into_iter().map(|(key, rows)| summarize(key, &rows)).collect();
    let wrong = measurements.iter().filter(|one| one.wrong > 0);
    let mut notes = vec![
        format!(
            "A claim is that skin of two limbs is placed in each other's frames. It is wrong where held-out skin is off by \
             more than {NEGLIGIBLE_MM} mm and {DEVIATIONS} of its own standard deviations. Right ones claimed: of the \
             pairs of limbs whose skin is off by no more than {RIGHT_MM} mm, the share that is claimed."
        ),
        "No body ever changed: every change that was announced is false. A wrong session can be made again:"
            .to_string(),
    ];
    notes.extend(wrong.map(|one| {
        let ClaimsMeasurement { wrong, claims, worst_mm, command, .. } = one;
        format!("{command}   # {wrong} of {claims} claims wrong, by up to {worst_mm:.3} mm")
    }));
    let inputs = [Input::Receptor, Input::Contact].map(|input| input.to_string());
    let dots = |input: &String| {
        let k = inputs.iter().position(|other| other == input).unwrap_or(0) as f64;
        let own = measurements.iter().filter(|one| one.input == *input && one.worst_mm > 0.0);
        own.map(|one| (one.worst_mm, k)).collect()
    };
    let series =
        inputs.iter().map(|input| PlotSeries { name: input.clone(), line: Vec::new(), dots: dots(input) });
    let plot = StudyPlot {
        x: PlotAxis { title: "greatest error of what is claimed, mm", scale: AxisScale::Logarithmic },
        y: PlotAxis { title: "", scale: AxisScale::Names(inputs.to_vec()) },
        series: series.collect(),
    };
    let numbers = vec![
        ("sessions", measurements.len().into()),
        ("wrong_claims", measurements.iter().map(|one| one.wrong).sum::<usize>().into()),
        ("wrong_sessions", measurements.iter().filter(|one| one.wrong > 0).count().into()),
    ];
    Findings { measurements, summary, notes, plot, numbers }
}

fn summarize([creature, policy, input, noise]: [String; 4], rows: &[&ClaimsMeasurement]) -> ClaimsSummary {
    let count = |holds: &dyn Fn(&ClaimsMeasurement) -> bool| rows.iter().filter(|one| holds(one)).count();
    let sum = |value: fn(&ClaimsMeasurement) -> usize| rows.iter().map(|one| value(one)).sum::<usize>();
    ClaimsSummary {
        creature,
        policy,
        input,
        noise,
        sessions: rows.len(),
        learned: count(&|one| one.verdict == "learned"),
        learned_except: count(&|one| one.verdict == "learned except"),
        not_learned: count(&|one| one.verdict == "not learned"),
        claims: sum(|one| one.claims),
        wrong: sum(|one| one.wrong),
        wrong_sessions: count(&|one| one.wrong > 0),
        false_changes: count(&|one| one.false_changes > 0),
        right_claimed: sum(|one| one.right_claimed) as f64 / sum(|one| one.right) as f64,
        worst_mm: rows.iter().map(|one| one.worst_mm).fold(f64::NAN, f64::max),
        seconds: WallTime(median(rows.iter().map(|one| one.seconds.0))),
    }
}
