//! Learning from a session's touches, and recording the result.

use std::path::Path;
use std::time::Instant;

use super::learning_record::CHANGE;
use super::{
    BabbledSession, Checkpoint, DisturbanceLevels, Host, LEARNED_FILE, LearningOptions, LearningRecord,
    LearningRow, LearningStep, Observer, PROGRAM, Phase, RecordedAccount, SCHEMA_FILE, Session, files,
    write_learning_table, write_schema,
};
use crate::agent::Agent;
use crate::creature::Creature;
use crate::deadline::{Limit, apart, count};
use crate::error::Error;
use crate::evaluation::{Evaluation, OwnAccount, Progress, Summary, evaluate, evaluate_learned};
use crate::export::to_mjcf;
use crate::ground_truth::GroundTruth;
use crate::learning::{
    Account, BodyChange, Expectation, Learned, Learner, LimbFrames, SkinKnowledge, Verdict, What,
};
use crate::named::listed;
use crate::schema::BodySchema;
use crate::senses::DisturbedSenses;

/// What learning from a session came to.
#[derive(Clone, Debug)]
pub struct LearnedSession {
    /// What was learned, and how far it can be trusted.
    pub learned: Learned,
    /// What is said of it, as it is written down: every output has it from here.
    pub record: LearningRecord,
    /// What ended the search for an answer where there was more to be tried; `None` if nothing did.
    pub ended_by: Option<Limit>,
    /// The errors; `None` if the truth is not at hand.
    pub evaluation: Option<Evaluation>,
    /// What can be told without the truth; `None` if the truth is at hand or the learner cannot tell.
    pub own_account: Option<OwnAccount>,
    /// The held-out error from the same touches without the disturbances; `None` if there are none, or no truth at hand.
    pub undisturbed_heldout_mm: Option<Summary>,
}

/// Learns from a session's touches, measures where the truth is at hand, and writes the results into its folder: the
/// schema, the learned body as a model, the table of learning and the record of it.
///
/// The touches are the exact ones: what the agent feels of them is the options' affair. Only the learner is
/// deceived: everything is measured on the session's own skin, which the learned model wears, too.
///
/// # Errors
/// Where there is no touch, or a file cannot be written.
pub fn learn_session(
    folder: &Path,
    babbled: &BabbledSession,
    options: &LearningOptions,
    truth: Option<&GroundTruth>,
    command: &[String],
    observer: &dyn Observer,
) -> Result<LearnedSession, Error> {
    let BabbledSession { session, touches, grown } = babbled;
    let (agent, given) = (&session.agent, options.givens());
    let each = options.kind().learns_each_touch(&given);
    observer.phase(Phase::Learning { touches: touches.len(), each });
    let disturbances = options.disturbances.disturbances();
    let felt = disturbances.felt(agent, touches, options.input(), session.seed);
    // What was learned along the way was learned of a body without the disturbances.
    let grown = grown.as_ref().filter(|_| disturbances.is_none());
    let mut learner = options.learner_from(&felt.agent, grown, session.seed);
    learner.end_at(options.deadline);
    // Without the truth a fit on the way tells nothing that the last does not.
    let due = match truth {
        None if !each => Vec::new(),
        _ => options.kind().checkpoints(&given, touches.len()),
    };
    let predicts = options.kind().predicts(&given);
    let passed = vec![(0, options.initial_guess(agent, session.seed))];
    let mut table = LearningTable { agent, truth, rows: Vec::new(), passed };
    let (mut seconds, mut ended_by, mut result) = (0.0, None, None);
    for (n, touch) in felt.touches.iter().enumerate() {
        let began = Instant::now();
        learner.touch(touch);
        let last = n + 1 == touches.len();
        // The first schema is worth a look, whenever it comes.
        let first = predicts && table.passed.len() == 1 && learner.schema().is_some();
        let due = (first || due.contains(&(n + 1))) && !options.deadline.has_passed();
        // Learning for a row of the table alone is not what learning takes.
        let (learned, done) = apart(|| (last || (due && !predicts)).then(|| learner.learn()));
        count(done);
        ended_by = done.ended.then(|| options.deadline.limit());
        let learned = learned.map(|learned| learned.with_made(&felt.agent, &felt.touches[..=n]));
        if last || !due || each {
            seconds += began.elapsed().as_secs_f64();
        }
        if last {
            for (touches, schema) in learner.way() {
                table.add(touches, Some(&schema), None, None);
            }
        }
        let believed = learner.schema();
        let schema = learned.as_ref().map(|learned| &learned.schema).or(believed.as_deref());
        let (expected, shown) = (learner.expectation(), due || last);
        observer.learned(&LearningStep {
            touches: n + 1,
            touch,
            schema: schema.filter(|_| shown || predicts),
            predicted_gap: expected.map(|expected| expected.gap),
        });
        // One that predicts each touch has a row for each.
        let evaluation = match shown || predicts {
            true => table.add(n + 1, schema.filter(|_| shown), learned.as_ref(), expected),
            false => None,
        };
        result = learned.filter(|_| last).map(|learned| (learned, evaluation));
    }
    let (learned, evaluation) = result.ok_or_else(Error::no_touch)?;
    let undisturbed_heldout_mm = truth.filter(|_| !disturbances.is_none()).map(|truth| {
        observer.phase(Phase::LearningUndisturbed);
        let mut learner = options.learner(agent, session.seed);
        touches.iter().for_each(|touch| learner.touch(&touch.felt(options.input())));
        evaluate_learned(agent, truth, &learner.learn()).heldout_mm
    });
    observer.phase(Phase::Done);
    let tells = truth.is_none()
        && options.kind().uses().surfaces
        && options.skin == SkinKnowledge::Surface
        && options.frames == LimbFrames::Joint;
    let own_account = if tells { OwnAccount::new(&felt.agent, &felt.touches, &learned) } else { None };
    let LearningTable { rows, passed, .. } = table;
    let creature = agent.creature();
    let joint = |&joint: &usize| creature.joints()[joint].name.clone();
    let limb = |&limb: &usize| creature.limbs()[limb].clone();
    let directions = learned.reliable_account().map(|account| &account.observability);
    let record = LearningRecord {
        program: PROGRAM.to_string(),
        command: command.to_vec(),
        host: Some(Host::here()),
        seed: session.seed,
        touches: touches.len(),
        facts: facts(session, options, &learned, seconds, ended_by),
        // To hundredths: nobody reads more of a time.
        seconds: Some((100.0 * seconds).round() / 100.0),
        converged: learned.verdict.converged(),
        verdict: sentence(creature, &learned),
        reason: learned.verdict.reason().map(str::to_string),
        undetermined: learned.undetermined().iter().map(joint).collect(),
        undetermined_limbs: learned.undetermined_limbs().iter().map(limb).collect(),
        open_directions: directions.map_or(Vec::new(), |found| found.undetermined(creature, &learned.schema)),
        bound: evaluation.as_ref().and_then(|evaluation| evaluation.bound_mm),
        account: Some(RecordedAccount::of(&learned)),
        checkpoints: checkpoints(passed, session, &felt, options, truth, (&learned, evaluation.as_ref())),
    };
    write_learning_table(folder, &rows)?;
    let std = learned.schema_std(creature);
    write_schema(&folder.join(SCHEMA_FILE), creature, &learned.schema, std.as_ref())?;
    files::write(&folder.join(LEARNED_FILE), to_mjcf(agent, &learned.schema))?;
    record.write(folder, creature)?;
    Ok(LearnedSession { learned, record, ended_by, evaluation, own_account, undisturbed_heldout_mm })
}

/// The table of learning as it goes on.
struct LearningTable<'a> {
    agent: &'a Agent,
    truth: Option<&'a GroundTruth>,
    rows: Vec<LearningRow>,
    /// The schemas passed, after how many touches.
    passed: Vec<(usize, BodySchema)>,
}

impl LearningTable<'_> {
    /// Takes down what a learner believed after so many touches; its errors, if it believed anything.
    fn add(
        &mut self,
        touches: usize,
        schema: Option<&BodySchema>,
        learned: Option<&Learned>,
        expected: Option<Expectation>,
    ) -> Option<Evaluation> {
        self.passed.extend(schema.map(|schema| (touches, schema.clone())));
        let evaluation = self.truth.zip(schema).map(|(truth, schema)| match learned {
            Some(learned) => evaluate_learned(self.agent, truth, learned),
            None => evaluate(self.agent, truth, schema, &[]),
        });
        let found = evaluation.as_ref();
        self.rows.push(LearningRow {
            touches,
            predicted_gap_mm: expected.map(|expected| 1e3 * expected.gap),
            predicted_deviation_mm: expected.map(|expected| 1e3 * expected.deviation),
            converged: learned.map(|learned| u8::from(learned.verdict.converged())),
            fresh_rms: learned.map(|learned| learned.fresh_rms),
            heldout_mean_mm: found.map(|e| e.heldout_mm.mean),
            heldout_p95_mm: found.map(|e| e.heldout_mm.p95),
            hand_mean_mm: found.and_then(|e| e.hand_mm).map(|hand| hand.mean),
            axis_median_deg: found.map(|e| e.axis_deg.median),
        });
        evaluation
    }
}

/// The schemas during learning with their errors and the bounds of these, where the truth is at hand and the touches show noise:
/// at the numerical floor there is no noise to bound an error by.
fn checkpoints(
    passed: Vec<(usize, BodySchema)>,
    session: &Session,
    felt: &DisturbedSenses,
    options: &LearningOptions,
    truth: Option<&GroundTruth>,
    (learned, evaluation): (&Learned, Option<&Evaluation>),
) -> Vec<Checkpoint> {
    let progress = truth.map(|truth| Progress::new(&session.agent, truth, learned));
    // What touches determine is judged at what was learned in the end: at a wrong schema it says nothing.
    let mut learner = options.second_order(&felt.agent, session.seed);
    let mut touches = felt.touches.iter();
    let bounded = learned.reliable_account().is_some_and(|account| !account.witnesses.at_floor);
    let checkpoint = |(count, schema): (usize, BodySchema)| {
        touches.by_ref().take(count - learner.touches().len()).for_each(|touch| learner.touch(touch));
        let progress = progress.as_ref();
        let bound_rms = progress.filter(|_| bounded && count > 0).and_then(|progress| {
            if count == felt.touches.len() {
                return evaluation?.bound_mm.map(|bound| bound.bound_rms);
            }
            progress.bound_rms(&learner.observe(&learned.schema).0)
        });
        let error_rms = progress.and_then(|progress| progress.error_rms(&schema));
        Checkpoint { touches: count, schema, error_rms, bound_rms }
    };
    passed.into_iter().map(checkpoint).collect()
}

/// What the report says of how it was learned.
fn facts(
    session: &Session,
    options: &LearningOptions,
    learned: &Learned,
    seconds: f64,
    ended_by: Option<Limit>,
) -> Vec<(String, String)> {
    let mut facts =
        vec![("learner", options.kind().name().to_string()), ("knowledge", options.knowledge().to_string())];
    if options.frames == LimbFrames::Limb {
        facts.push(("frames of limbs", "their own, learned".to_string()));
    }
    if let Some(known) = options.known_words(session.agent.creature()) {
        facts.push(("prior knowledge of joints", known));
    }
    if options.disturbances != DisturbanceLevels::default() {
        facts.push(("disturbances", options.disturbances.to_string()));
    }
    facts.push(("random initial guesses", learned.initial_guesses.to_string()));
    facts.push(("learning", format!("{seconds:.2} s")));
    facts.extend(changes(session.agent.creature(), learned).into_iter().map(|change| (CHANGE, change)));
    facts.extend(ended_by.map(|limit| ("search", format!("ended {limit}"))));
    facts.into_iter().map(|(name, value)| (name.to_string(), value)).collect()
}

/// How the body changed as the learner understood it, in sentences.
fn changes(creature: &Creature, learned: &Learned) -> Vec<String> {
    let sentence = |change: &BodyChange| {
        let what = match &change.what {
            What::Joint { joint, distance } => {
                format!("{} moved by {:.1} mm", creature.joints()[*joint].name, 1e3 * distance)
            }
            What::Corrected { joint, distance } => {
                let name = &creature.joints()[*joint].name;
                format!("{name} had been learned with an error of {:.1} mm", 1e3 * distance)
            }
            What::Tool(tool) => {
                let length = 1e3 * (tool.tip - tool.grip).norm();
                format!("{} holds a stick of {length:.0} mm", creature.limbs()[tool.limb])
            }
            What::Beyond => "the body changed by more than one joint or a stick can explain".to_string(),
        };
        format!("from touch {}, identified at touch {}: {what}", change.since + 1, change.touch + 1)
    };
    learned.changes.iter().map(sentence).collect()
}

/// The joints and limbs that are not located, by name; `None` if all are.
fn exceptions(creature: &Creature, learned: &Learned) -> Option<String> {
    let joints = learned.undetermined().into_iter().map(|joint| creature.joints()[joint].name.clone());
    let limbs = learned.undetermined_limbs().into_iter().map(|limb| creature.limbs()[limb].clone());
    let named = |kind: &str, names: Vec<String>| match names.as_slice() {
        [] => None,
        [one] => Some(format!("{kind} {one}")),
        several => Some(format!("{kind}s {}", listed(several))),
    };
    let parts = [named("joint", joints.collect()), named("limb", limbs.collect())];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    (!parts.is_empty()).then(|| parts.join(" and "))
}

/// How many limbs are located, as `all 17 limbs` or `4 of 5 limbs`; limbs without skin are not counted.
fn count_of_located(creature: &Creature, account: &Account) -> String {
    let (located, all) = (account.located().len(), account.limbs().len());
    let limbs = if all == creature.limbs().len() { "limbs" } else { "limbs with skin" };
    if located == all { format!("all {all} {limbs}") } else { format!("{located} of {all} {limbs}") }
}

/// The verdict in a sentence: how much is known comes first.
fn sentence(creature: &Creature, learned: &Learned) -> String {
    match (&learned.verdict, &learned.account) {
        (Verdict::Converged, Some(account)) => {
            let located = count_of_located(creature, account);
            match exceptions(creature, learned) {
                None => format!("Learned: {located} are located. The schema predicts held-out touches."),
                Some(names) => format!(
                    "Partly learned: {located} are located, but not {names}. The located part predicts held-out touches."
                ),
            }
        }
        (Verdict::Converged, None) => "Learned. The schema predicts held-out touches.".to_string(),
        (Verdict::Failed(why), _) => format!("NOT learned: {why}"),
        (Verdict::Unjudged(why), _) => format!("Not judged: {why}"),
    }
}
