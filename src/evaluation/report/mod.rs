//! A session as one page to read: what was done, what was learned, and how far it can be trusted.
//!
//! The page stands alone: its style, its data and the library that draws them (plotly.js) are written into it, and
//! it fetches nothing. It is light or dark as the reader's screen is, and can be printed.

mod body;
mod curve;
mod joint_errors;
pub(crate) mod mesh;
pub(crate) mod picture;
mod reachable;
mod residuals;
mod still;
mod tables;
pub(crate) mod text;
mod touch_matrix;
mod uncertainty;

#[cfg(feature = "rerun")]
pub(super) use body::Pose;

use super::Evaluation;
use crate::creature::Creature;
use crate::learning::Input;
use crate::record::{Checkpoint, Prediction, SpaceRecord};
use crate::schema::{BodySchema, SchemaStd};
use crate::senses::Touch;
use crate::skin::Skin;
use residuals::Residuals;
use text::escape;

/// How pages look.
pub(crate) const STYLE: &str = include_str!("style.css");
/// What draws the pictures of a page.
pub(crate) const SCRIPT: &str = include_str!("page.js");

/// All that a report tells, as plain data.
#[derive(Clone, Debug)]
pub struct ReportInput<'a> {
    /// What the agent was given.
    pub creature: &'a Creature,
    /// Its skin.
    pub skin: &'a Skin,
    /// What it learned; must fit the creature.
    pub schema: &'a BodySchema,
    /// How sure it is of it, where the learner can tell; must fit the creature.
    pub std: Option<&'a SchemaStd>,
    /// What it should have learned, where that is known.
    pub truth: Option<&'a BodySchema>,
    /// The error measures, where the truth is known.
    pub evaluation: Option<&'a Evaluation>,
    /// The touches that were learned from.
    pub touches: &'a [Touch],
    /// What a touch reports.
    pub input: Input,
    /// The schema on the way, from the onset on; every schema must fit the creature.
    pub checkpoints: &'a [Checkpoint],
    /// What the learner foretold of touches.
    pub predictions: &'a [Prediction],
    /// Where the hands can get to, once that was worked out.
    pub space: Option<&'a SpaceRecord>,
    /// The session's seed.
    pub seed: u64,
    /// The command lines that made the session, each with what it did in a word or two.
    pub commands: Vec<(String, String)>,
    /// What else was done, name and value in the order to be shown: motions, learner, input, times, engine
    /// version. Joints, receptors, touches and limb pairs need no mention: they are counted here.
    pub facts: Vec<(String, String)>,
    /// The verdict in a sentence.
    pub verdict: String,
    /// The joints that the touches did not determine.
    pub undetermined: &'a [usize],
    /// The limbs whose own frames they did not determine, by name.
    pub undetermined_limbs: &'a [String],
    /// Every direction in which the schema could change without any touch feeling it, in words.
    pub open_directions: &'a [String],
}

/// The whole page: HTML of some five megabytes, most of which is plotly.js.
pub fn html(input: &ReportInput) -> String {
    let name = escape(input.creature.name());
    let seed = input.seed;
    let residuals = Residuals::new(input);
    let sections = [
        ("The learned body", body::body(input)),
        ("What was done", tables::facts(input)),
        ("How well it was learned", tables::errors(input)),
        ("Learning curve", curve::figure_of(input)),
        ("Error per joint", joint_errors::figure_of(input, &residuals)),
        ("Residuals", residuals::figure_of(&residuals)),
        ("How sure the learner is", uncertainty::figure_of(input)),
        ("What stays undetermined", tables::undetermined(input)),
        ("Who touched whom", touch_matrix::figure_of(input)),
        ("Where the hands can get to", reachable::figure_of(input.space)),
        ("Joint by joint", tables::joints(input)),
    ];
    let sections: String = sections
        .iter()
        .map(|(title, content)| format!("<section>\n<h2>{title}</h2>\n{content}</section>\n"))
        .collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <meta name=\"color-scheme\" content=\"light dark\"/>\n<link rel=\"icon\" href=\"data:,\"/>\n\
         <title>{name}, seed {seed}: a learned body schema</title>\n<style>\n{style}</style>\n</head>\n\
         <body>\n<header>\n<h1>{name}</h1>\n<p>A body schema learned from self-touch, seed {seed}</p>\n\
         </header>\n<p class=\"verdict\">{verdict}</p>\n{sections}{library}\n<script>\n{script}</script>\n\
         </body>\n</html>\n",
        style = STYLE,
        verdict = escape(&input.verdict),
        library = picture::library(),
        script = SCRIPT,
    )
}
