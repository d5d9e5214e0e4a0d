//! A session as one page to read: what was done, what was learned, and how far it can be trusted.
//!
//! The page stands alone: its style, its data and what draws them are written into it, and it fetches nothing. It is
//! light or dark as the reader's screen is, and can be printed.

mod body;
pub mod calibration;
mod curve;
mod reachable;
mod tables;
mod touch_matrix;

use std::path::Path;

use crate::error::Error;
use crate::evaluation::{Evaluation, evaluate_claims};
use crate::ground_truth::GroundTruth;
use crate::named::plural;
use crate::schema::{BodySchema, SchemaStd};
use crate::senses::RecordedTouch;
use crate::session::{
    LearningRecord, LearningRow, SCHEMA_FILE, Session, SpaceRecord, files, read_learning_table,
    read_schema_with_std,
};
use crate::view::page;
use crate::view::text::{error_number, escape};
use crate::view::tone::Tone;
pub(crate) use tables::{bound_in_words, error_rows, limb_table, summaries};

/// The report, in a session's folder.
pub const REPORT_FILE: &str = "report.html";

/// What the page does beside drawing the body.
pub(super) const SCRIPT: &str = include_str!("report.js");

/// What a report shows: a session, and what was learned in it.
#[derive(Clone, Copy)]
pub struct ReportInput<'a> {
    /// The session.
    pub session: &'a Session,
    /// The record of learning; must fit the creature.
    pub record: &'a LearningRecord,
    /// The learned schema; must fit the creature.
    pub schema: &'a BodySchema,
    /// Its standard deviations, if the learner estimates them; must fit the creature.
    pub std: Option<&'a SchemaStd>,
    /// The true body, if it is known.
    pub truth: Option<&'a GroundTruth>,
    /// The error measures, if the truth is known.
    pub evaluation: Option<&'a Evaluation>,
    /// The touches that were learned from.
    pub touches: &'a [RecordedTouch],
    /// The rows of the table of learning, with the learner's predictions of touches.
    pub predictions: &'a [LearningRow],
    /// The reachable workspace, if it was computed.
    pub space: Option<&'a SpaceRecord>,
}

impl ReportInput<'_> {
    /// Whether held-out touches confirm the schema; `None` in sessions without a record of that.
    fn converged(&self) -> Option<bool> {
        (!self.record.program.is_empty()).then_some(self.record.converged)
    }

    /// The seed of what was learned, else of the session.
    fn seed(&self) -> u64 {
        if self.converged().is_some() { self.record.seed } else { self.session.seed }
    }

    /// The joints that the touches do not determine.
    fn undetermined(&self) -> Vec<usize> {
        let joints = self.session.agent.creature().joints();
        (0..joints.len()).filter(|&joint| self.record.undetermined.contains(&joints[joint].name)).collect()
    }
}

/// A section of the page: its title, and what makes its content.
type Section = (&'static str, fn(&ReportInput) -> String);

/// The sections of the page, below the body.
const SECTIONS: &[Section] = &[
    ("Accuracy", tables::errors),
    ("Undetermined joints and limbs", tables::undetermined),
    ("Located limbs", tables::limbs),
    ("Learning curve", curve::figure_of),
    ("Touches by pair of limbs", touch_matrix::figure_of),
    ("Reachable workspace", reachable::figure_of),
    ("Joint by joint", tables::joints),
    ("Settings", tables::facts),
];

/// The whole page: HTML of some hundred kilobytes, of a creature of a thousand limbs less than two thousand.
pub fn html(input: &ReportInput) -> String {
    let name = input.session.agent.creature().name();
    let seed = input.seed();
    let sections = in_sections(SECTIONS.iter().map(|(title, content)| (*title, content(input))));
    let content = format!(
        "<header>\n<h1>{}</h1>\n<p>A body schema learned from self-touch</p>\n</header>\n{}{sections}",
        escape(name),
        body::figure_of(input, &headline(input)),
    );
    page(&format!("{name}, seed {seed}: a learned body schema"), "", &content, SCRIPT)
}

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
    files::write(&folder.join(REPORT_FILE), report)?;
    Ok((record, evaluation))
}

/// The verdict; how much of the body is located, and, where the truth is known, how far off that is.
fn headline(input: &ReportInput) -> String {
    let tone = input.converged().map_or(String::new(), |_| format!(" {}", Tone::of(input.record).name()));
    let verdict = escape(&input.record.verdict);
    let Some(evaluation) = input.evaluation else {
        return format!("<p class=\"verdict{tone}\">{verdict}</p>\n");
    };
    let (error, located, of) = match input.record.reliable_account() {
        Some(account) => {
            let (located, all) = (account.located().len(), account.limbs().len());
            (evaluation.determined_mm.mean, format!("{located} of {all} limbs located<br/>"), "located limbs")
        }
        None => (evaluation.heldout_mm.mean, String::new(), "all limbs"),
    };
    if !error.is_finite() {
        return format!("<p class=\"verdict{tone}\">{verdict}</p>\n");
    }
    let babbling = input.session.effort.map_or(0.0, |effort| effort.babbling_s);
    let time =
        input.record.seconds.map_or(String::new(), |learning| format!(" in {}", time(babbling + learning)));
    format!(
        "<p class=\"verdict{tone}\">{verdict}</p>\n<p class=\"headline\">{located}<strong>{} mm</strong> after {}{time}<br/>\
         <small>mean surface error of {of} relative to one another, compared with the true model</small></p>\n",
        escape(&error_number(error)),
        plural(input.touches.len(), "touch"),
    )
}

/// A time as people say it.
fn time(seconds: f64) -> String {
    match seconds {
        short if short < 60.0 => format!("{short:.1} s"),
        long if long < 3600.0 => format!("{:.0} min", long / 60.0),
        long => format!("{:.1} h", long / 3600.0),
    }
}

/// Titles and contents as sections of a page.
fn in_sections<'a>(sections: impl IntoIterator<Item = (&'a str, String)>) -> String {
    let section = |(title, content)| format!("<section>\n<h2>{title}</h2>\n{content}</section>\n");
    sections.into_iter().map(section).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_told_in_the_unit_that_fits() {
        assert_eq!([4.31, 90.0, 5400.0].map(time), ["4.3 s", "2 min", "1.5 h"]);
    }
}
