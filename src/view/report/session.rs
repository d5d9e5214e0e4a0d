//! The report of a session, from what its folder holds.

use std::path::Path;

use super::{ReportInput, html};
use crate::error::Error;
use crate::evaluation::{Evaluation, evaluate_claims};
use crate::ground_truth::GroundTruth;
use crate::senses::RecordedTouch;
use crate::session::{
    LearningRecord, SCHEMA_FILE, Session, SpaceRecord, read_learning_table, read_schema_with_std, write_whole,
};

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
    let evaluation = truth.map(|truth| {
        let evaluation = evaluate_claims(agent, truth, &schema, record.reliable_account());
        Evaluation { bound_mm: record.bound, ..evaluation }
    });
    let report = html(&ReportInput {
        session,
        record: &record,
        schema: &schema,
        std: std.as_ref(),
        truth,
        evaluation: evaluation.as_ref(),
        touches: &touches[..record.touches.min(touches.len())],
        predictions: &read_learning_table(folder)?,
        space: SpaceRecord::read(folder)?.as_ref(),
    });
    let path = folder.join(REPORT_FILE);
    write_whole(&path, report.as_bytes()).map_err(Error::unwritable(&path))?;
    Ok((record, evaluation))
}
