//! The report of a session, from what its folder holds.

use std::path::Path;

use super::{ReportInput, html};
use crate::error::Error;
use crate::evaluation::{Evaluation, evaluate_claims, touch_misses};
use crate::ground_truth::GroundTruth;
use crate::senses::RecordedTouch;
use crate::session::{
    LearningRecord, SCHEMA_FILE, Session, SpaceRecord, read_learning_table, read_schema_with_std, write_whole,
};
use crate::view::text::shell_words;

/// The report, in a session's folder.
pub const REPORT_FILE: &str = "report.html";

/// Writes the report of a session from what its folder holds, and returns what was learned, and the error measures if the truth is known. Of its
/// touches those count that were learned from.
///
/// # Errors
/// Where a file of it cannot be read, or the report not written.
pub fn write_report(
    folder: &Path,
    session: &Session,
    touches: &[RecordedTouch],
    truth: Option<&GroundTruth>,
) -> Result<(LearningRecord, Option<Evaluation>), Error> {
    let agent = &session.agent;
    let creature = agent.creature();
    let (schema, std) = read_schema_with_std(&folder.join(SCHEMA_FILE), creature)?;
    let record = LearningRecord::read(folder, creature)?;
    let touches = &touches[..record.touches.min(touches.len())];
    let joints = creature.joints();
    let undetermined: Vec<usize> =
        (0..joints.len()).filter(|&joint| record.undetermined.contains(&joints[joint].name)).collect();
    let evaluation = truth.map(|truth| {
        let evaluation = evaluate_claims(agent, truth, &schema, record.reliable_account());
        Evaluation { bound_mm: record.bound, ..evaluation }
    });
    let predictions = read_learning_table(folder)?;
    let space = SpaceRecord::read(folder)?;
    let report = ReportInput {
        agent,
        schema: &schema,
        std: std.as_ref(),
        truth,
        evaluation: evaluation.as_ref(),
        touches,
        residual: touch_misses(agent, &schema, touches),
        record: &record,
        predictions: &predictions,
        space: space.as_ref(),
        seed: if record.program.is_empty() { session.seed } else { record.seed },
        commands: commands(session, &record),
        facts: facts(session, &record),
        converged: Some(record.converged),
        seconds: seconds(session, &record),
        undetermined: &undetermined,
    };
    let path = folder.join(REPORT_FILE);
    write_whole(&path, html(&report).as_bytes()).map_err(Error::unwritable(&path))?;
    Ok((record, evaluation))
}

/// How long touching and learning took in all, as far as that was kept.
fn seconds(session: &Session, learned: &LearningRecord) -> Option<f64> {
    let learning = learned.seconds?;
    Some(session.effort.map_or(0.0, |effort| effort.babbling_s) + learning)
}

/// The command lines that made the session and, if by another, what was learned from it.
fn commands(session: &Session, learned: &LearningRecord) -> Vec<(String, String)> {
    let again = Some(&learned.command).filter(|command| **command != session.command);
    let commands = [("Made by", Some(&session.command)), ("Learned by", again)].into_iter();
    let kept = commands.filter_map(|(what, command)| Some((what, command?))).filter(|(_, c)| !c.is_empty());
    kept.map(|(what, command)| (what.to_string(), shell_words(command))).collect()
}

/// How the session came about, and how it was learned from.
fn facts(session: &Session, learned: &LearningRecord) -> Vec<(String, String)> {
    let effort = session.effort.as_ref();
    let host = learned.host.as_ref().or(session.host.as_ref());
    let recording = session.recording.as_ref();
    let simulated = recording.is_none();
    let facts = [
        ("program", Some(session.program.clone())),
        ("creature", recording.map(|recording| recording.creature.clone())),
        ("log", recording.map(|recording| recording.log.clone())),
        ("model", simulated.then(|| session.model.clone())),
        ("engine", simulated.then(|| format!("MuJoCo {}", session.engine))),
        ("processor", host.map(|host| host.cpu.clone())),
        ("cores", host.map(|host| host.cores.to_string())),
        ("operating system", host.map(|host| host.os.clone())),
        ("motions", effort.map(|effort| effort.of_motions.motions.to_string())),
        ("babbling", effort.map(|effort| format!("{:.2} s", effort.babbling_s))),
        ("babbling ended", effort.and_then(|effort| Some(effort.ended_by?.to_string()))),
        ("simulated", effort.and_then(|effort| Some(format!("{:.0} s", effort.simulated_s()?)))),
    ];
    let facts = facts.into_iter().filter_map(|(name, value)| Some((name.to_string(), value?)));
    facts.chain(learned.facts.iter().cloned()).collect()
}
