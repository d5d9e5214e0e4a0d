//! Studies: cases measured over seeds, and a table of the results.
//!
//! A [`Study`] is a function from a seed to rows of named values, one or more for each of its cases. A trial depends on its
//! seed alone, so [`StudyRun`] makes trials on all cores, goes on where it was interrupted, and leaves shares of the trials to
//! other processes; [`Findings`] are the same whoever made which trial.
//!
//! To add a study, write a file with a `pub const STUDY: Study` beside this one and name it in [`STUDIES`].

mod acting;
mod bodies;
pub mod calibration;
mod disturbances;
pub mod generated;
mod hersch;
mod learners;
mod run;
mod senses;
mod shares;
mod subject;
mod table;

pub(crate) use bodies::by_default;
pub use run::{Asked, Findings, StudyOptions, StudyRun, Trial};
pub use shares::{Share, StudyShare};
pub(crate) use shares::{Unready, made_shares, share_folder};
pub use subject::Subject;
pub(crate) use table::columns;
pub use table::{By, Column, Row, Table};

use crate::error::Error;

/// The studies, in the order in which they are named to the user.
pub const STUDIES: &[&Study] = &[
    &bodies::STUDY,
    &learners::STUDY,
    &hersch::STUDY,
    &disturbances::STUDY,
    &acting::STUDY,
    &senses::STUDY,
    &calibration::STUDY,
];

/// A question that is answered by measuring cases over seeds.
pub struct Study {
    /// The name on the command line.
    pub name: &'static str,
    /// The question, in a line.
    pub about: &'static str,
    /// Who is studied.
    pub of: Studied,
    /// Touches of a trial unless others are asked for; `None` if it does not babble.
    pub touches: Option<usize>,
    /// Work of a case, in seconds of one core, unless another limit is asked for; `None` if it has no limit.
    pub seconds: Option<f64>,
    /// The names of its cases.
    pub cases: fn() -> Vec<String>,
    /// The columns of its table.
    pub columns: &'static [Column],
    /// How to read the table, in sentences.
    pub notes: &'static [&'static str],
    /// The rows of a trial, without its seed. An attempt that fails is a measurement; only what cannot be measured is an error.
    pub run: fn(&Trial) -> Result<Vec<Row>, Error>,
}

/// Who is studied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Studied {
    /// Bodies or robots that the seeds make.
    Generated,
    /// A creature that learns its body in the trials, or is touched.
    Creature,
    /// A creature that acts by what it has learned of its body before: in a session, or by the first seed.
    Acting,
}

impl Study {
    /// The study of a name.
    pub fn of_name(name: &str) -> Option<&'static Study> {
        STUDIES.iter().copied().find(|study| study.name == name)
    }
}
