//! A session as one page to read: what was done, what was learned, and how far it can be trusted.
//!
//! The page stands alone: its style, its data and what draws them are written into it, and it fetches nothing. It is
//! light or dark as the reader's screen is, and can be printed.

mod body;
pub mod calibration;
mod curve;
mod headline;
mod reachable;
mod session;
mod tables;
mod touch_matrix;

use crate::agent::Agent;
use crate::evaluation::{Evaluation, Summary};
use crate::ground_truth::GroundTruth;
use crate::schema::{BodySchema, SchemaStd};
use crate::senses::RecordedTouch;
use crate::session::{LearningRecord, LearningRow, SpaceRecord};
use crate::view::page;
use crate::view::text::escape;
pub use session::{REPORT_FILE, write_report};
pub(crate) use tables::{bound_in_words, error_rows, limb_table, summaries};

/// What the page does beside drawing the body.
pub(super) const SCRIPT: &str = include_str!("report.js");

/// All that a report tells, as plain data.
#[derive(Clone, Debug)]
pub struct ReportInput<'a> {
    /// What the agent was given.
    pub agent: &'a Agent,
    /// What it learned; must fit the creature.
    pub schema: &'a BodySchema,
    /// How sure it is of it, where the learner can tell; must fit the creature.
    pub std: Option<&'a SchemaStd>,
    /// What it should have learned and what it looks like, where that is known.
    pub truth: Option<&'a GroundTruth>,
    /// The error measures, where the truth is known.
    pub evaluation: Option<&'a Evaluation>,
    /// The touches that were learned from.
    pub touches: &'a [RecordedTouch],
    /// How far apart the schema puts what touched, millimetres.
    pub residual: Summary,
    /// What learning came to; its checkpoints and its account must fit the creature.
    pub record: &'a LearningRecord,
    /// The rows of the table of learning, which have what the learner predicted of touches.
    pub predictions: &'a [LearningRow],
    /// The reachable workspace, if it was computed.
    pub space: Option<&'a SpaceRecord>,
    /// The session's seed.
    pub seed: u64,
    /// The command lines that made the session, each with what it did in a word or two.
    pub commands: Vec<(String, String)>,
    /// What else was done, name and value in the order to be shown: motions, learner, input, times, engine
    /// version. Joints, receptors, touches and limb pairs need no mention: they are counted here.
    pub facts: Vec<(String, String)>,
    /// Whether held-out touches confirm what was learned; `None` if that was not kept.
    pub converged: Option<bool>,
    /// How long it took to touch and to learn, seconds; `None` if that was not kept.
    pub seconds: Option<f64>,
    /// The joints that the touches did not determine.
    pub undetermined: &'a [usize],
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
    let name = input.agent.creature().name();
    let seed = input.seed;
    let sections = in_sections(SECTIONS.iter().map(|(title, content)| (*title, content(input))));
    let content = format!(
        "<header>\n<h1>{}</h1>\n<p>A body schema learned from self-touch</p>\n</header>\n{}{sections}",
        escape(name),
        body::figure_of(input, &headline::of(input)),
    );
    page(&format!("{name}, seed {seed}: a learned body schema"), "", &content, SCRIPT)
}

/// Titles and contents as sections of a page.
fn in_sections<'a>(sections: impl IntoIterator<Item = (&'a str, String)>) -> String {
    let section = |(title, content)| format!("<section>\n<h2>{title}</h2>\n{content}</section>\n");
    sections.into_iter().map(section).collect()
}
