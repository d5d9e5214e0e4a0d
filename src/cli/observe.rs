//! `bodyschema observe`: what a session's touches determine.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::learned::warn_truncated;
use super::{Failure, Outcome, output, progress};
use crate::creature::{Creature, DofKind};
use crate::experiment::LearningOptions;
use crate::learning::{Account, Input, Learner, LimbFrames, SecondOrder};
use crate::record::{
    LearningRecord, ReadLock, RecordedAccount, SCHEMA_FILE, Session, TOUCHES_FILE, read_schema, read_touches,
};
use crate::schema::BodySchema;
use crate::senses::Touch;

/// Tell what a session's touches determine, how well, and what they leave open.
///
/// From the surfaces' gaps, or a recording's points, at the session's schema: rank and condition of the problem, the indices that the
/// calibration literature reports, the standard deviation of every joint's position and axes, and every
/// direction in which the schema could change without any touch feeling it; and of every limb how far off its skin
/// may be, and why. No truth is needed.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema observe sessions/max-1
  bodyschema observe sessions/max-1 --json")]
pub struct ObserveArguments {
    /// The session's folder
    session: PathBuf,
    /// Print one JSON object
    #[arg(long, help_heading = "Output")]
    json: bool,
}

pub fn run(args: &ObserveArguments) -> Outcome {
    let _reading = ReadLock::take(&args.session)?;
    let session = Session::read(&args.session)?;
    let agent = &session.agent;
    let creature = agent.creature();
    let log = read_touches(&args.session.join(TOUCHES_FILE), agent)?;
    warn_truncated(&log, &args.session);
    let schema = read_schema(&args.session.join(SCHEMA_FILE), creature)?;
    if log.touches.is_empty() {
        return Err("there is no touch to look at: babble some first".into());
    }
    let spinner = progress::spinner(&format!("looking at {} touches", log.touches.len()));
    let Observed { account, deviation, touches, points } =
        observed(&args.session, &session, &schema, &log.touches)?;
    spinner.finish_and_clear();
    let found = &account.observability;
    let limbs = limb_lines(creature, &account);
    let indices = found.indices();
    let undetermined = found.undetermined(creature, &schema);
    let millimetres = |joint: usize| found.position_std(joint).map(|metres| metres.map(|m| 1e3 * m));
    let degrees = |dof: usize| found.axis_std(creature, dof).map(f64::to_degrees);
    if args.json {
        let joints = creature.joints().iter().enumerate().map(|(j, joint)| {
            json!({
                "joint": joint.name,
                "position_std_mm": millimetres(j),
                "axes_std_deg": joint.dof_indices().map(degrees).collect::<Vec<_>>(),
            })
        });
        return output::json(&json!({
            "session": args.session,
            "touches": touches,
            "touch_deviation_mm": 1e3 * deviation,
            "parameters": found.singular_values.len(),
            "rank": found.rank,
            "condition": found.condition(),
            "singular_values": found.singular_values,
            "indices": indices,
            "joints": joints.collect::<Vec<_>>(),
            "limbs": limbs.iter().map(LimbLine::json).collect::<Vec<_>>(),
            "undetermined": undetermined,
        }));
    }
    say!(
        "{}: {} touches determine {} of {} parameters; condition number {:.0}",
        args.session.display(),
        touches,
        found.rank,
        found.singular_values.len(),
        found.condition()
    );
    say!(
        "D-optimality {:.3e}   inverse condition {:.3e}   least singular value {:.3e}   noise amplification {:.3e}",
        indices.d_optimality,
        indices.inverse_condition,
        indices.minimum_singular_value,
        indices.noise_amplification
    );
    let (what, least) =
        if points { ("miss, per coordinate", "") } else { ("gap", " (0.001 mm at the least)") };
    say!("standard deviation of a touch's {what}: {:.4} mm{least}\n", 1e3 * deviation);
    say!("one standard deviation, – where nothing determines it; an axis by each coordinate across it:");
    say!("  {:<28}{:<32}axes, °", "joint", "position x y z, mm");
    let number = |value: Option<f64>| format!("{:<7}", value.map_or("–".to_string(), output::number));
    for (j, joint) in creature.joints().iter().enumerate() {
        let axes: Vec<String> = joint
            .dof_indices()
            .zip(&joint.dofs)
            .filter(|(_, dof)| dof.kind != DofKind::Ball)
            .map(|(k, _)| number(degrees(k)))
            .collect();
        let position = millimetres(j).map(number).join("  ");
        say!("  {:<28}{position:<32}{}", joint.name, axes.join("  ").trim_end());
    }
    say!("\nhow far off a limb's skin may be in the frames of the other limbs that are placed, 95 %:");
    say!("  {:<28}{:<10}{:<12}{:<12}", "limb", "touches", "best, mm", "worst, mm");
    for line in &limbs {
        let [best, worst] = line.distances.map(|d| d.map_or("–".to_string(), output::number));
        let why = line.why.as_deref().unwrap_or("");
        let line = format!("  {:<28}{:<10}{best:<12}{worst:<12}{why}", line.limb, line.touches);
        say!("{}", line.trim_end());
    }
    say!("");
    if undetermined.is_empty() {
        say!("nothing is left undetermined");
    }
    for words in undetermined {
        say!("undetermined: {words}");
    }
    Ok(())
}

/// What the account says of a limb.
struct LimbLine {
    limb: String,
    touches: usize,
    /// In the frame of a limb of the largest class where it is known best, and where worst, millimetres.
    distances: [Option<f64>; 2],
    /// Why it is not placed; none where it is.
    why: Option<String>,
}

impl LimbLine {
    fn json(&self) -> Value {
        json!({
            "limb": self.limb,
            "touches": self.touches,
            "best_mm": self.distances[0],
            "worst_mm": self.distances[1],
            "open": self.why,
        })
    }
}

/// What the account says of each limb that has skin, the limb that is placed worst first.
fn limb_lines(creature: &Creature, account: &Account) -> Vec<LimbLine> {
    let distances = |limb: usize| account.distance_to_most(limb).unwrap_or([f64::INFINITY; 2]);
    let millimetres = |metres: f64| Some(1e3 * metres).filter(|mm| mm.is_finite());
    let line = |limb: usize| LimbLine {
        limb: creature.limbs()[limb].clone(),
        touches: account.witnesses.of_limbs[limb],
        distances: distances(limb).map(millimetres),
        why: account.openness(creature, limb).map(|why| why.words(creature)),
    };
    account.worst_first().into_iter().map(line).collect()
}

/// What touches determine.
struct Observed {
    account: Account,
    /// Standard deviation of a touch, metres.
    deviation: f64,
    /// The touches that it rests on.
    touches: usize,
    /// Whether these told points of contact.
    points: bool,
}

/// What the learner of a session said of it; of one that said nothing, what its touches determine at its schema.
fn observed(
    folder: &Path,
    session: &Session,
    schema: &BodySchema,
    touches: &[Touch],
) -> Result<Observed, Failure> {
    let agent = &session.agent;
    let record = LearningRecord::read(folder, agent.creature())?;
    let count = record.as_ref().map_or(touches.len(), |record| record.touches.min(touches.len()));
    let recorded = record.and_then(|record| record.account);
    let (input, frames) = match &recorded {
        Some(recorded) => (recorded.basis.input, recorded.basis.frames),
        // Sessions from before there was an account: limbs in frames of their own are learned from contact points.
        None => {
            let own_frames = !schema.limb_poses.is_empty();
            let points = LearningOptions::default().for_session(session)?.input() == Input::Contact;
            let input = if points || own_frames { Input::Contact } else { Input::Receptor };
            (input, if own_frames { LimbFrames::Limb } else { LimbFrames::Joint })
        }
    };
    let points = input == Input::Contact;
    if let Some(RecordedAccount { deviation: Some(deviation), account: Some(account), .. }) = recorded {
        return Ok(Observed { account, deviation, touches: count, points });
    }
    let mut learner = SecondOrder::new(agent, input, session.seed).with_frames(frames);
    touches[..count].iter().for_each(|touch| learner.touch(touch));
    let (account, deviation) = learner.account(schema);
    Ok(Observed { account, deviation, touches: count, points })
}
