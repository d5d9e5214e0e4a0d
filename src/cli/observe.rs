//! `bodyschema observe`: what a session's touches determine.

use std::path::PathBuf;

use serde_json::json;

use super::learned::{print_knowledge, warn_truncated};
use super::{Outcome, output};
use crate::agent::Agent;
use crate::creature::DofKind;
use crate::kinematics::Chain;
use crate::learning::Input;
use crate::record::{
    LearningRecord, ReadLock, SCHEMA_FILE, Session, TOUCHES_FILE, read_schema, read_touches,
};
use crate::senses::Touch;
use crate::view::text;

/// Show what a session's touches determine, how well, and what they leave open.
///
/// From the surfaces' gaps, or a recording's points, at the session's schema: rank and condition of the problem, the indices that the
/// calibration literature reports, the standard deviation of every joint's position and axes, and every unobservable
/// direction of the schema; and of every limb how far off its skin may be, and why. No truth is needed. Bounds hold near a
/// right schema only: none are given of one that no held-out touches confirm.
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
    // Of a session that is not learned yet its absence says so.
    read_schema(&args.session.join(SCHEMA_FILE), creature)?;
    if log.touches.is_empty() {
        return Err("there is no touch to look at: babble some first".into());
    }
    let record = LearningRecord::read_or_unknown(&args.session, creature)?;
    let touches = &log.touches[..record.touches.min(log.touches.len())];
    let (Some(account), Some(recorded)) = (record.reliable_account(), &record.account) else {
        return unconfirmed(args, agent, touches, &record);
    };
    let deviation = recorded.deviation.unwrap_or_default();
    let points = recorded.basis.input == Input::Contact;
    let found = &account.observability;
    let indices = found.indices();
    let millimetres = |joint: usize| found.position_std(joint).map(|metres| metres.map(|m| 1e3 * m));
    let degrees = |dof: usize| found.axis_std(creature, dof).map(f64::to_degrees);
    let lines = account.limb_lines(creature);
    if args.json {
        let joints = creature.joints().iter().enumerate().map(|(j, joint)| {
            json!({
                "joint": joint.name,
                "position_std_mm": millimetres(j),
                "axes_std_deg": joint.dof_indices().map(degrees).collect::<Vec<_>>(),
            })
        });
        let limbs = lines.iter().map(|line| {
            let [best, worst] = line.bounds.map(|metres| Some(1e3 * metres).filter(|mm| mm.is_finite()));
            json!({
                "limb": creature.limbs()[line.limb],
                "touches": line.touches,
                "supporting_touches": line.supporting,
                "best_mm": best,
                "worst_mm": worst,
                "open": line.why,
            })
        });
        let determined = json!({
            "session": args.session,
            "touches": touches.len(),
            "touch_deviation_mm": 1e3 * deviation,
            "parameters": found.singular_values.len(),
            "rank": found.rank,
            "condition": found.condition(),
            "singular_values": found.singular_values,
            "indices": indices,
            "joints": joints.collect::<Vec<_>>(),
            "limbs": limbs.collect::<Vec<_>>(),
            "bounds_note": record.floor_note(),
            "unobservable": record.open_directions,
        });
        return output::json(&output::joined(determined, record.knowledge_json()));
    }
    say!("{}: {}", args.session.display(), text::touches(touches.len()));
    print_knowledge(&record);
    record.open_directions.iter().for_each(|words| say!("  {words}"));
    say!(
        "\nThe touches determine {} of {} parameters; condition number {:.0}",
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
        if points { ("residual, per coordinate", "") } else { ("gap", " (0.001 mm at the least)") };
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
    say!("\nhow far off a limb's skin may be in the frames of the other limbs that are located, 95 %:");
    say!("  {:<28}{:<10}{:<12}{:<12}{:<12}", "limb", "touches", "supporting", "best, mm", "worst, mm");
    for line in &lines {
        let [best, worst] = line.bounds.map(|metres| output::number(1e3 * metres));
        let why = line.why.as_deref().unwrap_or("");
        let name = &creature.limbs()[line.limb];
        let line =
            format!("  {name:<28}{:<10}{:<12}{best:<12}{worst:<12}{why}", line.touches, line.supporting);
        say!("{}", line.trim_end());
    }
    if let Some(note) = record.floor_note() {
        say!("{note}");
    }
    Ok(())
}

/// What can be shown of touches whose schema nothing confirms: which limbs and joints they exercise.
fn unconfirmed(
    args: &ObserveArguments,
    agent: &Agent,
    touches: &[Touch],
    record: &LearningRecord,
) -> Outcome {
    let creature = agent.creature();
    let mut of_limbs = vec![0; creature.limbs().len()];
    let mut of_joints = vec![0; creature.joints().len()];
    for limbs in touches.iter().map(|touch| touch.limbs(agent.skin())) {
        limbs.into_iter().for_each(|limb| of_limbs[limb] += 1);
        Chain::between(creature, limbs[0], limbs[1]).joints().for_each(|joint| of_joints[joint] += 1);
    }
    let joints = || creature.joints().iter().map(|joint| &joint.name).zip(&of_joints);
    let limbs = || agent.limbs_with_skin().into_iter().map(|limb| (&creature.limbs()[limb], of_limbs[limb]));
    if args.json {
        let exercised = json!({
            "session": args.session,
            "touches": touches.len(),
            "joints": joints().map(|(joint, touches)| json!({ "joint": joint, "touches": touches })).collect::<Vec<_>>(),
            "limbs": limbs().map(|(limb, touches)| json!({ "limb": limb, "touches": touches })).collect::<Vec<_>>(),
        });
        return output::json(&output::joined(exercised, record.knowledge_json()));
    }
    say!("{}: {}", args.session.display(), text::touches(touches.len()));
    print_knowledge(record);
    say!("\nNo bounds are given: they hold near a right schema only. What the touches exercise:");
    say!("  {:<28}touches across it", "joint");
    joints().for_each(|(joint, touches)| say!("  {joint:<28}{touches}"));
    say!("  {:<28}touches of its skin", "limb");
    limbs().for_each(|(limb, touches)| say!("  {limb:<28}{touches}"));
    Ok(())
}
