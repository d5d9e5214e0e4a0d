//! Studies: one measurement repeated over several seeds.
//!
//! To add a study, write a file beside this one with a kind of [`Trial`] and a `pub const STUDY: Study`, and name it in
//! [`STUDIES`]. A trial takes a [`Subject`], which babbles, learns and evaluates for it, and a seed; all trials together
//! give [`Findings`]: all measurements as typed rows of one tidy table, a summary of them, and what to plot. The command
//! line has the study by its name; a program calls [`measure`] with the kind of trial.

pub mod approach;
mod at_table;
pub mod avoid;
pub mod bodies;
pub mod calibration;
mod changed_body;
pub mod claims;
pub mod disturbances;
mod exhaustive_reach;
pub mod farthest;
pub mod finding;
pub mod growth;
pub mod hersch;
pub mod learners;
pub mod map;
pub mod other_hand;
mod plot;
pub mod policies;
mod reach_bound;
pub mod self_touch;
pub mod sensations;
mod subject;
mod table;
mod touched_trial;
pub mod trial;

use serde_json::Value;

pub use plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
pub use subject::Subject;
pub use table::{Cell, Column, StudyRow, Table, WallTime};
pub use trial::{ReceiveTrial, Trial, Trials, measure};

/// The studies, in the order in which they are named to the user.
pub const STUDIES: &[&Study] = &[
    &learners::STUDY,
    &hersch::STUDY,
    &policies::STUDY,
    &claims::STUDY,
    &disturbances::STUDY,
    &growth::STUDY,
    &sensations::STUDY,
    &approach::STUDY,
    &self_touch::STUDY,
    &map::STUDY,
    &other_hand::STUDY,
    &finding::STUDY,
    &farthest::STUDY,
    &avoid::STUDY,
    &avoid::BUSY,
    &calibration::STUDY,
    &bodies::STUDY,
];

/// A question that is answered by measuring over several seeds.
pub struct Study {
    /// The name on the command line.
    pub name: &'static str,
    /// The question in a line.
    pub about: &'static str,
    /// Whether it learns from babbled touches, so many a trial.
    pub touches: bool,
    /// Whether it is of several creatures where several are named.
    pub several: bool,
    /// Its trials.
    pub trials: Trials,
}

/// What a study found, in rows of its own kinds.
#[derive(Clone, Debug)]
pub struct Findings<M, S> {
    /// All measurements, a row each: one kind of thing per column, so that it can be plotted as it is.
    pub measurements: Vec<M>,
    /// A row per condition over all trials: the table that a person reads.
    pub summary: Vec<S>,
    /// How to read the summary, in sentences.
    pub notes: Vec<String>,
    /// The plot.
    pub plot: StudyPlot,
    /// What a program asks for by name, beside the summary.
    pub numbers: Vec<(&'static str, Value)>,
}

/// What any study found, as tables.
pub struct FoundTables {
    /// All measurements, a row each.
    pub measurements: Table,
    /// A row per condition over all trials.
    pub summary: Table,
    /// How to read the summary, in sentences.
    pub notes: Vec<String>,
    /// The plot.
    pub plot: StudyPlot,
    /// What a program asks for by name, beside the summary.
    pub numbers: Vec<(&'static str, Value)>,
}

impl<M: StudyRow, S: StudyRow> From<Findings<M, S>> for FoundTables {
    fn from(found: Findings<M, S>) -> FoundTables {
        FoundTables {
            measurements: Table::of(&found.measurements),
            summary: Table::of(&found.summary),
            notes: found.notes,
            plot: found.plot,
            numbers: found.numbers,
        }
    }
}
