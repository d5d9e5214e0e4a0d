//! Which learner gets how far with how many touches.

use serde::{Deserialize, Serialize};

use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{CONVERGED_MM, Subject, median, share};
use super::table::{WallTime, row};
use super::{Findings, Study, Trial, Trials};
use crate::experiment::ExperimentError;
use crate::experiment::LearningOptions;
use crate::learning::SkinKnowledge;
use crate::learning::learners::{HerschsRule, RepairedHersch};

/// The study `learners`.
pub const STUDY: Study = Study {
    name: "learners",
    about: "which learner gets how far with how many touches",
    touches: true,
    several: false,
    trials: Trials::of::<LearnersTrial>(),
};

/// Errors that the summary says how many touches are needed for, millimetres.
const LEVELS_MM: [f64; 3] = [10.0, 1.0, 0.1];

row! {
    /// A measurement of the study `learners`.
    pub struct LearnersMeasurement {
        learner: String = "learner",
        seed: u64 = "seed",
        touches: usize = "touches",
        heldout_mm: f64 = "held-out, mm",
        hand_mm: f64 = "hand, mm",
        converged: bool = "converged",
        initial_guesses: usize = "initial guesses",
        seconds: WallTime = "seconds",
    }
}

row! {
    /// A row of the summary of the study `learners`.
    pub struct LearnersSummary {
        learner: String = "learner",
        touches_to_10_mm: f64 = "touches to 10 mm",
        touches_to_1_mm: f64 = "to 1 mm",
        touches_to_0_1_mm as "touches_to_0.1_mm": f64 = "to 0.1 mm",
        heldout_mm: f64 = "at last, mm",
        seconds: WallTime = "last fit, s",
        converged: f64 = "converged, share",
    }
}

/// The learners that are compared, with the names under which they appear.
fn learners() -> [(&'static str, LearningOptions); 4] {
    let lm = LearningOptions::default();
    [
        ("hersch", LearningOptions { learner: &HerschsRule, ..lm.clone() }),
        ("gradient", LearningOptions { learner: &RepairedHersch, ..lm.clone() }),
        ("lm --skin centres", LearningOptions { skin: SkinKnowledge::Centres, ..lm.clone() }),
        ("lm", lm),
    ]
}

/// The measurements of one trial: learner by learner, one after each of the touch counts.
#[derive(Debug, Serialize, Deserialize)]
pub struct LearnersTrial(Vec<LearnersMeasurement>);

impl Trial for LearnersTrial {
    type Setting = ();
    type Measurement = LearnersMeasurement;
    type Summary = LearnersSummary;

    fn set_up(_subject: &Subject) -> Result<(), ExperimentError> {
        Ok(())
    }

    fn run(subject: &Subject, (): &(), seed: u64) -> Result<LearnersTrial, ExperimentError> {
        let touches = subject.babble(seed)?;
        let mut measurements = Vec::new();
        for (name, options) in learners() {
            for count in touch_counts(subject.touches) {
                subject.tell(seed, &format!("{name}, {count} touches"));
                let attempt = subject.learn(&options, &touches[..count], seed);
                measurements.push(LearnersMeasurement {
                    learner: name.into(),
                    seed,
                    touches: count,
                    heldout_mm: attempt.heldout_mm(),
                    hand_mm: attempt.hand_mm(),
                    converged: attempt.converged(),
                    initial_guesses: attempt.learned.initial_guesses,
                    seconds: attempt.seconds,
                });
            }
        }
        Ok(LearnersTrial(measurements))
    }

    fn findings(
        subject: &Subject,
        trials: &[LearnersTrial],
    ) -> Findings<LearnersMeasurement, LearnersSummary> {
        findings(&touch_counts(subject.touches), trials)
    }
}

fn findings(counts: &[usize], trials: &[LearnersTrial]) -> Findings<LearnersMeasurement, LearnersSummary> {
    let mut summary: Vec<LearnersSummary> = Vec::new();
    let mut series = Vec::new();
    for (name, _) in learners() {
        // Per trial, the measurements of this learner: one per count.
        let of = |trial: &LearnersTrial| trial.0.iter().filter(|row| row.learner == name).cloned().collect();
        let courses: Vec<Vec<LearnersMeasurement>> = trials.iter().map(of).collect();
        let needed = LEVELS_MM.map(|level| median(courses.iter().map(|course| touches_to(level, course))));
        let at = |k: usize| {
            median(courses.iter().map(|course| course.get(k).map_or(f64::NAN, |row| row.heldout_mm)))
        };
        let last = || courses.iter().filter_map(|course| course.last());
        summary.push(LearnersSummary {
            learner: name.into(),
            touches_to_10_mm: needed[0],
            touches_to_1_mm: needed[1],
            touches_to_0_1_mm: needed[2],
            heldout_mm: at(counts.len() - 1),
            seconds: WallTime(median(last().map(|row| row.seconds.0))),
            converged: share(last().map(|row| row.converged)),
        });
        let line = counts.iter().enumerate().map(|(k, &count)| (count as f64, at(k))).collect();
        let dots = courses.iter().flatten().map(|row| (row.touches as f64, row.heldout_mm)).collect();
        series.push(PlotSeries { name: name.into(), line, dots });
    }
    let notes = vec![
        format!("Errors are mean held-out errors, measured after {} touches.", listed(counts)),
        "Touches to an error: the least count from which on it is not exceeded; median over trials, – where \
         half of them or more never get there. The other columns are of all touches, medians over trials."
            .to_string(),
        format!(
            "Converged: by the learner's own verdict; hersch and gradient have none, and {CONVERGED_MM} mm of \
             held-out error or less counts."
        ),
    ];
    let plot = StudyPlot {
        x: PlotAxis { title: "touches", scale: AxisScale::Logarithmic },
        y: PlotAxis {
            title: "mean held-out error, mm (dots: trials, lines: medians)",
            scale: AxisScale::Logarithmic,
        },
        series,
    };
    let measurements = trials.iter().flat_map(|trial| trial.0.clone()).collect();
    Findings { measurements, summary, notes, plot, numbers: Vec::new() }
}

/// The counts at which learners are measured, up to `most` and with it: 100, 150, 200, 300, 500, 700, 1000,
/// and so on by the same factors.
fn touch_counts(most: usize) -> Vec<usize> {
    let decades = std::iter::successors(Some(1usize), |decade| decade.checked_mul(10));
    let counts = decades.flat_map(|decade| [100, 150, 200, 300, 500, 700].map(|n| decade.saturating_mul(n)));
    counts.take_while(|&count| count < most).chain([most]).collect()
}

/// The least count from which on an error is not exceeded; infinite where there is none.
fn touches_to(level: f64, course: &[LearnersMeasurement]) -> f64 {
    let exceeds = |row: &LearnersMeasurement| row.heldout_mm.is_nan() || row.heldout_mm > level;
    match course.iter().rposition(exceeds) {
        None => course.first().map_or(f64::NAN, |row| row.touches as f64),
        Some(last) => course.get(last + 1).map_or(f64::INFINITY, |row| row.touches as f64),
    }
}

fn listed(counts: &[usize]) -> String {
    let counts: Vec<String> = counts.iter().map(usize::to_string).collect();
    counts.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_go_on_by_the_same_factors_and_end_with_the_last() {
        assert_eq!(touch_counts(60), [60]);
        assert_eq!(touch_counts(100), [100]);
        assert_eq!(touch_counts(1000), [100, 150, 200, 300, 500, 700, 1000]);
        assert_eq!(touch_counts(2500)[6..], [1000, 1500, 2000, 2500]);
    }

    #[test]
    fn a_level_is_reached_for_good_or_not_at_all() {
        let reached = |heldout_mm: Vec<f64>| {
            let row = |(touches, heldout_mm)| LearnersMeasurement {
                learner: "lm".into(),
                seed: 1,
                touches,
                heldout_mm,
                hand_mm: heldout_mm,
                converged: false,
                initial_guesses: 1,
                seconds: WallTime(0.0),
            };
            let course: Vec<_> = [100, 150, 200].into_iter().zip(heldout_mm).map(row).collect();
            touches_to(10.0, &course)
        };
        assert_eq!(reached(vec![9.0, 5.0, 1.0]), 100.0);
        assert_eq!(reached(vec![9.0, 50.0, 1.0]), 200.0);
        assert_eq!(reached(vec![9.0, 5.0, 11.0]), f64::INFINITY);
        assert_eq!(reached(vec![f64::NAN, 10.0, 1.0]), 150.0);
    }
}
