//! Which learner gets how far with how many touches.

use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{CONVERGED_MM, Subject, median, share};
use super::table::row;
use super::{Findings, Study};
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
    measure: |subject| Ok(measure(subject)?.into()),
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
        seconds: f64 = "seconds",
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
        seconds: f64 = "last fit, s",
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

/// How far one learner got in one trial: the error after each of the touch counts, and its last attempt.
struct LearnerCourse {
    heldout_mm: Vec<f64>,
    seconds: f64,
    converged: bool,
}

/// Measures; a trial that does not succeed is a finding.
///
/// # Errors
/// Where something cannot be measured at all.
pub fn measure(subject: &Subject) -> Result<Findings<LearnersMeasurement, LearnersSummary>, ExperimentError> {
    let counts = touch_counts(subject.touches);
    let learners = learners();
    let mut measurements: Vec<LearnersMeasurement> = Vec::new();
    let mut courses: Vec<Vec<LearnerCourse>> = learners.iter().map(|_| Vec::new()).collect();
    for &seed in &subject.seeds {
        let touches = subject.babble(seed)?;
        for ((name, options), courses) in learners.iter().zip(&mut courses) {
            let mut course = LearnerCourse { heldout_mm: Vec::new(), seconds: 0.0, converged: false };
            for &count in &counts {
                subject.tell(seed, &format!("{name}, {count} touches"));
                let attempt = subject.learn(options, &touches[..count], seed);
                course.heldout_mm.push(attempt.heldout_mm());
                (course.seconds, course.converged) = (attempt.seconds, attempt.converged());
                measurements.push(LearnersMeasurement {
                    learner: (*name).into(),
                    seed,
                    touches: count,
                    heldout_mm: attempt.heldout_mm(),
                    hand_mm: attempt.hand_mm(),
                    converged: attempt.converged(),
                    initial_guesses: attempt.learned.initial_guesses,
                    seconds: attempt.seconds,
                });
            }
            courses.push(course);
        }
    }
    let mut summary: Vec<LearnersSummary> = Vec::new();
    let mut series = Vec::new();
    for ((name, _), courses) in learners.iter().zip(&courses) {
        let needed =
            LEVELS_MM.map(|level| median(courses.iter().map(|course| touches_to(level, &counts, course))));
        let at = |k: usize| median(courses.iter().map(|course| course.heldout_mm[k]));
        summary.push(LearnersSummary {
            learner: (*name).into(),
            touches_to_10_mm: needed[0],
            touches_to_1_mm: needed[1],
            touches_to_0_1_mm: needed[2],
            heldout_mm: at(counts.len() - 1),
            seconds: median(courses.iter().map(|course| course.seconds)),
            converged: share(courses.iter().map(|course| course.converged)),
        });
        let line = counts.iter().enumerate().map(|(k, &count)| (count as f64, at(k))).collect();
        let dots = courses.iter().flat_map(|course| {
            counts.iter().zip(&course.heldout_mm).map(|(&count, &error)| (count as f64, error))
        });
        series.push(PlotSeries { name: (*name).to_string(), line, dots: dots.collect() });
    }
    let notes = vec![
        format!("Errors are mean held-out errors, measured after {} touches.", listed(&counts)),
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
    Ok(Findings { measurements, summary, notes, plot, numbers: Vec::new() })
}

/// The counts at which learners are measured, up to `most` and with it: 100, 150, 200, 300, 500, 700, 1000,
/// and so on by the same factors.
fn touch_counts(most: usize) -> Vec<usize> {
    let decades = std::iter::successors(Some(1usize), |decade| decade.checked_mul(10));
    let counts = decades.flat_map(|decade| [100, 150, 200, 300, 500, 700].map(|n| decade.saturating_mul(n)));
    counts.take_while(|&count| count < most).chain([most]).collect()
}

/// The least count from which on an error is not exceeded; infinite where there is none.
fn touches_to(level: f64, counts: &[usize], course: &LearnerCourse) -> f64 {
    let exceeds = |error: &f64| error.is_nan() || *error > level;
    match course.heldout_mm.iter().rposition(exceeds) {
        None => counts[0] as f64,
        Some(last) => counts.get(last + 1).map_or(f64::INFINITY, |&count| count as f64),
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
            let course = LearnerCourse { heldout_mm, seconds: 0.0, converged: false };
            touches_to(10.0, &[100, 150, 200], &course)
        };
        assert_eq!(reached(vec![9.0, 5.0, 1.0]), 100.0);
        assert_eq!(reached(vec![9.0, 50.0, 1.0]), 200.0);
        assert_eq!(reached(vec![9.0, 5.0, 11.0]), f64::INFINITY);
        assert_eq!(reached(vec![f64::NAN, 10.0, 1.0]), 150.0);
    }
}
