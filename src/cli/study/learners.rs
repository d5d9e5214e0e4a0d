//! Which learner gets how far with how many touches.

use super::plot::{Axis, Plot, Scale, Series};
use super::subject::{CONVERGED_MM, Subject, median, share};
use super::table::{Column, Table};
use super::{Failure, Findings, Study};
use crate::cli::learn_options::{LearnOptions, LearnerName, SkinName};

/// The study `learners`.
pub const STUDY: Study = Study {
    name: "learners",
    about: "which learner gets how far with how many touches",
    touches: true,
    measure,
};

/// Errors that the summary says how many touches are needed for, millimetres.
const LEVELS_MM: [f64; 3] = [10.0, 1.0, 0.1];

const MEASUREMENTS: &[Column] = &[
    Column { name: "learner", heading: "learner" },
    Column { name: "seed", heading: "seed" },
    Column { name: "touches", heading: "touches" },
    Column { name: "heldout_mm", heading: "held-out, mm" },
    Column { name: "hand_mm", heading: "hand, mm" },
    Column { name: "converged", heading: "converged" },
    Column { name: "onsets", heading: "onsets" },
    Column { name: "seconds", heading: "seconds" },
];

const SUMMARY: &[Column] = &[
    Column { name: "learner", heading: "learner" },
    Column { name: "touches_to_10_mm", heading: "touches to 10 mm" },
    Column { name: "touches_to_1_mm", heading: "to 1 mm" },
    Column { name: "touches_to_0.1_mm", heading: "to 0.1 mm" },
    Column { name: "heldout_mm", heading: "at last, mm" },
    Column { name: "seconds", heading: "last fit, s" },
    Column { name: "converged", heading: "converged, share" },
];

/// The learners that are compared, with the names under which they appear.
fn learners() -> [(&'static str, LearnOptions); 4] {
    let lm = LearnOptions::default();
    [
        ("hersch", LearnOptions { learner: LearnerName::Hersch, ..lm.clone() }),
        ("gradient", LearnOptions { learner: LearnerName::Gradient, ..lm.clone() }),
        ("lm --skin centres", LearnOptions { skin: SkinName::Centres, ..lm.clone() }),
        ("lm", lm),
    ]
}

/// How far one learner got in one trial: the error after each of the touch counts, and its last attempt.
struct Course {
    heldout_mm: Vec<f64>,
    seconds: f64,
    converged: bool,
}

fn measure(subject: &Subject) -> Result<Findings, Failure> {
    let counts = touch_counts(subject.touches);
    let learners = learners();
    let mut measurements = Table::new(MEASUREMENTS);
    let mut courses: Vec<Vec<Course>> = learners.iter().map(|_| Vec::new()).collect();
    for &seed in &subject.seeds {
        let touches = subject.babble(seed)?;
        for ((name, options), courses) in learners.iter().zip(&mut courses) {
            let mut course = Course { heldout_mm: Vec::new(), seconds: 0.0, converged: false };
            for &count in &counts {
                subject.tell(seed, &format!("{name}, {count} touches"));
                let attempt = subject.learn(options, &touches[..count], seed);
                course.heldout_mm.push(attempt.heldout_mm());
                (course.seconds, course.converged) = (attempt.seconds, attempt.converged());
                measurements.row([
                    (*name).into(),
                    seed.into(),
                    count.into(),
                    attempt.heldout_mm().into(),
                    attempt.hand_mm().into(),
                    attempt.converged().into(),
                    attempt.learned.onsets.into(),
                    attempt.seconds.into(),
                ]);
            }
            courses.push(course);
        }
    }
    let mut summary = Table::new(SUMMARY);
    let mut series = Vec::new();
    for ((name, _), courses) in learners.iter().zip(&courses) {
        let needed =
            LEVELS_MM.map(|level| median(courses.iter().map(|course| touches_to(level, &counts, course))));
        let at = |k: usize| median(courses.iter().map(|course| course.heldout_mm[k]));
        summary.row([
            (*name).into(),
            needed[0].into(),
            needed[1].into(),
            needed[2].into(),
            at(counts.len() - 1).into(),
            median(courses.iter().map(|course| course.seconds)).into(),
            share(courses.iter().map(|course| course.converged)).into(),
        ]);
        let line = counts.iter().enumerate().map(|(k, &count)| (count as f64, at(k))).collect();
        let dots = courses.iter().flat_map(|course| {
            counts.iter().zip(&course.heldout_mm).map(|(&count, &error)| (count as f64, error))
        });
        series.push(Series { name: (*name).to_string(), line, dots: dots.collect() });
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
    let plot = Plot {
        x: Axis { title: "touches", scale: Scale::Logarithmic },
        y: Axis {
            title: "mean held-out error, mm (dots: trials, lines: medians)",
            scale: Scale::Logarithmic,
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
fn touches_to(level: f64, counts: &[usize], course: &Course) -> f64 {
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
            let course = Course { heldout_mm, seconds: 0.0, converged: false };
            touches_to(10.0, &[100, 150, 200], &course)
        };
        assert_eq!(reached(vec![9.0, 5.0, 1.0]), 100.0);
        assert_eq!(reached(vec![9.0, 50.0, 1.0]), 200.0);
        assert_eq!(reached(vec![9.0, 5.0, 11.0]), f64::INFINITY);
        assert_eq!(reached(vec![f64::NAN, 10.0, 1.0]), 150.0);
    }
}
