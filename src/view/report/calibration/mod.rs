//! A calibration as one page to read: what was found, how sure it is, and what is left of the touches.

mod charts;
mod tables;

use crate::calibration::Misses;
use crate::view::page;
use crate::view::text::escape;

/// All that a report of a calibration tells, as plain data.
#[derive(Clone, Debug, Default)]
pub struct CalibrationReport {
    /// The robot's name.
    pub robot: String,
    /// Whether what was found explains the touches.
    pub calibrated: bool,
    /// The verdict in a sentence.
    pub verdict: String,
    /// What a calibration is right for, in a sentence.
    pub reach: &'static str,
    /// What was done, name and value.
    pub facts: Vec<(String, String)>,
    /// How far apart what touched is put, metres: before and after, of the touches and of those held out.
    pub misses: Vec<(String, Misses)>,
    /// What touches that were held out say of the deviations, in a sentence.
    pub held_out: Option<String>,
    /// What was to be found.
    pub quantities: Vec<ReportedQuantity>,
    /// What cannot be told apart, in sentences.
    pub untold: Vec<String>,
    /// Parameters that are known together better than each, the most alike first.
    pub correlations: Vec<(String, String, f64)>,
    /// What is left of the touches.
    pub touches: Vec<ReportedTouch>,
}

/// A quantity as a person reads it.
#[derive(Clone, Debug)]
pub struct ReportedQuantity {
    /// Its name.
    pub name: String,
    /// The unit of its numbers.
    pub unit: &'static str,
    /// Its value before any touch.
    pub before: String,
    /// The value that was found.
    pub after: String,
    /// How far it is from the one before.
    pub change: f64,
    /// Standard deviations of its parameters, infinite where they are not told.
    pub deviations: Vec<f64>,
}

/// What is left of a touch.
#[derive(Clone, Debug)]
pub struct ReportedTouch {
    /// The line of the log that it is on.
    pub line: usize,
    /// The links or surfaces that touched.
    pub between: [String; 2],
    /// How far apart the two are put by what was found, metres.
    pub apart: f64,
    /// How likely it is honest.
    pub honesty: f64,
}

impl ReportedTouch {
    fn is_false(&self) -> bool {
        self.honesty <= 0.5
    }

    /// Millimetres.
    fn millimetres(&self) -> f64 {
        1e3 * self.apart
    }
}

/// The whole page.
pub fn html(report: &CalibrationReport) -> String {
    let sections = [
        ("What was done", super::tables::definitions(&report.facts)),
        ("How far apart what touched is put", tables::misses(report)),
        ("What was found", tables::quantities(report)),
        ("What cannot be told apart", tables::untold(report)),
        ("Residuals by pair of links", charts::by_pair(report)),
        ("Correlations", tables::correlations(report)),
    ];
    let sections = super::in_sections(sections);
    let content = format!(
        "<header>\n<h1>{}</h1>\n<p>A robot calibrated by its own touches</p>\n</header>\n\
         <p class=\"verdict{}\">{}</p>\n<p class=\"note\">{}</p>\n{sections}",
        escape(&report.robot),
        if report.calibrated { "" } else { " open" },
        escape(&report.verdict),
        escape(report.reach),
    );
    page(&format!("{}: calibrated by its own touches", report.robot), "", &content, "")
}
