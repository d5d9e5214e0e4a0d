//! What was learned, as `babble`, `learn` and `report` print it.

use std::path::Path;

use serde_json::{Value, json};

use super::{Failure, output};
use crate::agent::Agent;
use crate::evaluation::{Evaluation, Summary};
use crate::ground_truth::GroundTruth;
use crate::learning::learners::{LearnerKind, LevenbergMarquardt, PartByPart};
use crate::named::{listed, plural};
use crate::senses::{RecordedTouch, limb_pairs};
use crate::session::{
    BabbledSession, FolderLock, LearnedSession, LearningOptions, LearningRecord, Observer, TOUCHES_FILE,
    TouchLog, learn_session, read_touches,
};
use crate::simulation::MotionName;
use crate::view::report::{REPORT_FILE, bound_in_words, error_rows, summaries, write_report};
use crate::view::text::shell_words;
use crate::view::tone::Tone;

/// Why nothing is known of a body: learning failed, or its learner makes no judgement.
const UNCONFIRMED: &str = "no held-out touches confirm the schema";
/// Where touches told too little, so many times as many are proposed.
const MORE: usize = 3;

/// Learns from a session's touches, writes all that comes of it into its folder at once, the report as well, and prints it.
pub fn learn_and_print(
    lock: &FolderLock,
    babbled: &BabbledSession,
    options: &LearningOptions,
    truth: Option<&GroundTruth>,
    observer: &dyn Observer,
    as_json: bool,
) -> Result<LearnedSession, Failure> {
    let command = output::command_line();
    let folder = lock.part()?;
    let result = learn_session(folder, babbled, options, truth, &command, observer)?;
    write_report(folder, &babbled.session, &babbled.touches, truth)?;
    lock.commit()?;
    let printed = Printed { folder: lock.place(), babbled, options, result: &result };
    if as_json {
        output::json(&printed.to_json())?;
    } else {
        printed.print();
    }
    Ok(result)
}

/// What is printed of what was learned.
struct Printed<'a> {
    folder: &'a Path,
    babbled: &'a BabbledSession,
    options: &'a LearningOptions,
    result: &'a LearnedSession,
}

impl Printed<'_> {
    /// How deep limbs were in each other where motions with physics stopped, millimetres; `None` if no touch tells.
    fn depth_mm(&self) -> Option<Summary> {
        let depths = self.babbled.touches.iter().filter_map(|touch| touch.exact_contact().depth);
        let depths: Vec<f64> = depths.map(|metres| 1e3 * metres).collect();
        (!depths.is_empty()).then(|| Summary::of(depths.into_iter()))
    }

    /// The one JSON object of `babble` and `learn`.
    fn to_json(&self) -> Value {
        let Printed { babbled: BabbledSession { session, touches, .. }, options, result, .. } = self;
        let how = json!({
            "creature": session.agent.creature().name(),
            "joints": session.agent.creature().joints().len(),
            "dof": session.agent.creature().dof(),
            "touches": touches.len(),
            "motions": session.effort.map(|effort| effort.of_motions.motions),
            "limb_pairs": limb_pairs(session.agent.skin(), touches).len(),
            "babbling_s": session.effort.map(|effort| effort.babbling_s),
            "motion": session.options.motion.clone().unwrap_or_else(|| MotionName::default().to_string()),
            "simulated_s": session.effort.and_then(|effort| effort.simulated_s()),
            "depth_mm": self.depth_mm(),
            "learning_s": result.record.seconds,
            "ended_by": { "babbling": session.effort.and_then(|effort| effort.ended_by), "learning": result.ended_by },
            "seed": session.seed,
            "policy": session.options.policy,
            "learner": options.kind().name(),
            "input": options.input().to_string(),
            "knowledge": options.knowledge(),
            "frames": options.frames.to_string(),
            "known": options.known_json(session.agent.creature()),
            "initial_guesses": result.learned.initial_guesses,
            "disturbances": options.disturbances,
            "undisturbed_heldout_mm": result.undisturbed_heldout_mm,
            "expected_mm": result.own_account.and_then(|account| account.expected_mm),
            "fresh_mm": result.own_account.and_then(|account| account.fresh_mm),
            "changes": result.record.changes().collect::<Vec<_>>(),
            "session": self.folder,
        });
        output::joined([how, measures_json(result.evaluation.as_ref()), result.record.knowledge_json()])
    }

    /// The short table of what was learned.
    fn print(&self) {
        let Printed { babbled: BabbledSession { session, touches, .. }, result, .. } = self;
        let creature = session.agent.creature();
        say!(
            "{}: {}, {} degrees of freedom, from {} of {}",
            creature.name(),
            plural(creature.joints().len(), "joint"),
            creature.dof(),
            plural(touches.len(), "touch"),
            plural(limb_pairs(session.agent.skin(), touches).len(), "pair of limbs")
        );
        if let Some(depth) = self.depth_mm() {
            let simulated = session.effort.and_then(|effort| effort.simulated_s());
            say!(
                "moved by servos{}: median penetration {} mm, 95th percentile {} mm",
                simulated.map_or(String::new(), |seconds| format!(" for {seconds:.0} simulated seconds")),
                output::number(depth.median),
                output::number(depth.p95)
            );
        }
        result.record.facts.iter().for_each(|(name, value)| say!("{name}: {value}"));
        print_knowledge(&result.record);
        say!("");
        match &result.evaluation {
            None => self.print_own_account(),
            Some(evaluation) => {
                output::table(&summaries(error_rows(evaluation)));
                evaluation.bound_mm.iter().for_each(|bound| say!("\n  {}", bound_in_words(bound)));
            }
        }
        if let Some(undisturbed) = &result.undisturbed_heldout_mm {
            say!("without the disturbances: {} mm", output::number(undisturbed.mean));
        }
        say!("\nsession: {}", self.folder.display());
        say!("next: {}", self.next());
    }

    /// What to do with what was learned, or with what was not.
    fn next(&self) -> String {
        let Printed { babbled, options, result, .. } = self;
        let folder = shell_words(&[self.folder.display().to_string()]);
        if result.learned.verdict.converged() {
            return format!(
                "open {folder}/{REPORT_FILE} in a browser; `bodyschema view {folder}` moves the body, `bodyschema report {folder}` shows what is \
             certain and what is not"
            );
        }
        let strongest = LevenbergMarquardt.name();
        if ![strongest, PartByPart.name()].contains(&options.kind().name()) {
            return format!(
                "`bodyschema learn {folder} --learner {strongest}` learns from the same touches with the strongest learner"
            );
        }
        let more = match (&babbled.session.recording, shell_words(&babbled.session.command)) {
            (Some(_), _) => "record more touches, between more pairs of limbs".to_string(),
            (None, command) => {
                let touches = MORE * babbled.touches.len().max(babbled.session.options.touches);
                format!("make more touches: add --touches {touches} and a new folder to `{command}`")
            }
        };
        format!("{more}; {folder}/{REPORT_FILE} shows which limbs and joints the current touches involve")
    }

    /// What can be told without the truth.
    fn print_own_account(&self) {
        let result = self.result;
        if let Some(account) = &result.own_account {
            if let Some(fresh) = &account.fresh_mm {
                output::table(&summaries([("held-out contact residual", "mm", *fresh)]));
            }
            if let Some(expected) = account.expected_mm {
                say!("  estimated surface error between limbs: {} mm RMS", output::number(expected));
            }
            say!("");
        }
        say!("no comparison with the truth without a model (--model); `bodyschema report` prints more");
    }
}

/// The error measures; null if the truth is not known.
pub fn measures_json(evaluation: Option<&Evaluation>) -> Value {
    let unknown = || json!({ "heldout_mm": null, "determined_mm": null, "bound_mm": null, "hand_mm": null, "axis_deg": null, "axis_line_mm": null });
    evaluation.map_or_else(unknown, |evaluation| json!(evaluation))
}

/// The verdict, and what is not known: the same words from every command.
pub fn print_knowledge(record: &LearningRecord) {
    output::verdict(&record.verdict, Tone::of(record));
    if record.reliable_account().is_none() {
        say!("undetermined joints: all ({UNCONFIRMED})");
        return;
    }
    say!("undetermined joints: {}", listed(&record.undetermined));
    if !record.undetermined_limbs.is_empty() {
        say!("undetermined limbs: {}", listed(&record.undetermined_limbs));
    }
    if !record.open_directions.is_empty() {
        say!("unobservable: {}", record.directions_in_words());
    }
}

/// The touches of a session's folder; what is missing at the end of their log is told.
pub fn read_log(folder: &Path, agent: &Agent) -> Result<Vec<RecordedTouch>, Failure> {
    let TouchLog { touches, truncated, zeros, .. } = read_touches(&folder.join(TOUCHES_FILE), agent)?;
    let place = folder.display();
    if let Some(line) = truncated {
        tell!(
            "the log in {place} ends in the middle of line {line}; that touch is ignored, all before it are used"
        );
    }
    if zeros > 0 {
        tell!("the log in {place} ends in {zeros} zero bytes, as after a power failure; they are ignored");
    }
    Ok(touches)
}
