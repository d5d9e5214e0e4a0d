//! `bodyschema report`: what a session learned, printed and as one page to read.

use std::path::PathBuf;

use serde_json::{Value, json};

use super::folders::written_session;
use super::learned::{measures_json, print_knowledge, read_log};
use super::open::known_truth;
use super::{Outcome, output, progress};
use crate::creature::Joint;
use crate::evaluation::{Evaluation, Summary, touch_misses, touches_across};
use crate::learning::LimbLine;
use crate::named::plural;
use crate::senses::RecordedTouch;
use crate::session::{LearningRecord, SCHEMA_FILE, Session, read_schema};
use crate::view::report::{REPORT_FILE, bound_in_words, error_rows, limb_table, summaries, write_report};

/// Report what a session learned, how accurate it is, and what stays unobservable; rewrite its page.
///
/// Prints the verdict; if the model is available, the errors relative to it (surface positions of each limb relative to
/// every other limb at random postures, angles between learned and true axes, and distances between their lines); the
/// contact residual; and how well each limb is located. The last two need no ground truth. --json adds every joint's
/// standard deviations and the observability indices used in the calibration literature. The page is a single file that
/// opens offline in any browser and adds pictures. `babble` and `learn` write it, too.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema report sessions/max-1
  bodyschema report sessions/max-1 --model mjcf/max/max.xml --json")]
pub struct ReportArguments {
    /// The session's folder
    session: PathBuf,
    /// The model to compare with, if it is not at the path recorded in the session
    #[arg(long)]
    model: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long, help_heading = "Output")]
    json: bool,
}

pub fn run(args: &ReportArguments) -> Outcome {
    let folder = &args.session;
    let _lock = written_session(folder)?;
    let session = Session::read(folder)?;
    let log = read_log(folder, &session.agent)?;
    let schema = read_schema(&folder.join(SCHEMA_FILE), session.agent.creature())?;
    let truth = known_truth(&session, args.model.as_deref())?;
    let spinner = progress::spinner("measuring");
    let (record, evaluation) = write_report(folder, &session, &log, truth.as_ref())?;
    let touches = &log[..record.touches.min(log.len())];
    let residual = touch_misses(&session.agent, &schema, touches);
    spinner.finish_and_clear();
    let found = Found { session: &session, touches, record: &record, evaluation, residual };
    if args.json {
        let measures = measures_json(found.evaluation.as_ref());
        return output::json(&output::joined([found.to_json(args), measures, record.knowledge_json()]));
    }
    found.print(args);
    Ok(())
}

/// What is reported.
struct Found<'a> {
    session: &'a Session,
    /// Those that were learned from.
    touches: &'a [RecordedTouch],
    record: &'a LearningRecord,
    /// `None` if the truth is not known.
    evaluation: Option<Evaluation>,
    /// Contact residual, millimetres.
    residual: Summary,
}

impl Found<'_> {
    fn to_json(&self, args: &ReportArguments) -> Value {
        let (agent, creature) = (&self.session.agent, self.session.agent.creature());
        let mut all = json!({
            "session": args.session,
            "page": args.session.join(REPORT_FILE),
            "creature": creature.name(),
            "touches": self.touches.len(),
            "touch_mm": self.residual,
        });
        let [of_joints, of_limbs] = touches_across(agent, self.touches);
        // Bounds hold near a right schema only: none are given of one that no held-out touches confirm.
        let account = self.record.reliable_account();
        let joint = |(j, joint): (usize, &Joint)| {
            let counted = json!({ "joint": joint.name, "touches": of_joints[j] });
            account.map_or(counted.clone(), |account| {
                let observed = &account.observability;
                let degrees = |dof: usize| observed.axis_std(creature, dof).map(f64::to_degrees);
                let certain = json!({
                    "position_std_mm": observed.position_std(j).map(|metres| metres.map(|m| 1e3 * m)),
                    "axes_std_deg": joint.dof_indices().map(degrees).collect::<Vec<_>>(),
                });
                output::joined([counted, certain])
            })
        };
        let bound = |metres: f64| Some(1e3 * metres).filter(|mm| mm.is_finite());
        let line = |line: LimbLine| {
            json!({
                "limb": creature.limbs()[line.limb],
                "touches": line.touches,
                "supporting_touches": line.supporting,
                "best_mm": bound(line.bounds[0]),
                "worst_mm": bound(line.bounds[1]),
                "open": line.why,
            })
        };
        let counted = |limb: usize| json!({ "limb": creature.limbs()[limb], "touches": of_limbs[limb] });
        all["joints"] = creature.joints().iter().enumerate().map(joint).collect();
        all["limbs"] = match account {
            Some(account) => account.limb_lines(creature).into_iter().map(line).collect(),
            None => agent.limbs_with_skin().into_iter().map(counted).collect(),
        };
        let Some(account) = account else { return all };
        let observed = &account.observability;
        let deviation = self.record.account.as_ref().and_then(|recorded| recorded.deviation);
        let determined = json!({
            "touch_deviation_mm": 1e3 * deviation.unwrap_or_default(),
            "parameters": observed.singular_values.len(),
            "rank": observed.rank,
            "condition": observed.condition(),
            "singular_values": observed.singular_values,
            "indices": observed.indices(),
            "bounds_note": self.record.floor_note(),
            "unobservable": self.record.open_directions,
        });
        output::joined([all, determined])
    }

    fn print(&self, args: &ReportArguments) {
        let creature = self.session.agent.creature();
        say!("{}: {} of {}", args.session.display(), plural(self.touches.len(), "touch"), creature.name());
        print_knowledge(self.record);
        self.record.open_directions.iter().for_each(|words| say!("  {words}"));
        say!("");
        let errors = self.evaluation.as_ref().map_or(Vec::new(), error_rows);
        let residual = ("contact residual of all touches", "mm", self.residual);
        output::table(&summaries(errors.into_iter().chain([residual])));
        if let Some(bound) = self.evaluation.as_ref().and_then(|evaluation| evaluation.bound_mm) {
            say!("\n  {}", bound_in_words(&bound));
        }
        if let Some(account) = self.record.reliable_account() {
            say!("\nsurface error of each limb in the frames of the other located limbs (95 % bounds):");
            output::table(&limb_table(account, creature));
            self.record.floor_note().iter().for_each(|note| say!("{note}"));
        }
        say!("\npage: {}", args.session.join(REPORT_FILE).display());
    }
}
