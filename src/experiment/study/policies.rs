//! How many touches and motions each policy of babbling needs.

use serde::{Deserialize, Serialize};

use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median};
use super::table::{WallTime, row};
use super::{Findings, Study, Trial, Trials};
use crate::babbling::PolicyName;
use crate::experiment::ExperimentError;
use crate::experiment::LearningOptions;

/// The study `policies`.
pub const STUDY: Study = Study {
    name: "policies",
    about: "how few touches and motions lm needs by each policy",
    touches: true,
    several: false,
    trials: Trials::of::<PoliciesTrial>(),
};

/// Errors that touches and motions are counted to, millimetres, the greatest first.
const LEVELS_MM: [f64; 2] = [10.0, 1.0];
/// The least number of touches that is learned from.
const LEAST: usize = 100;
/// Counts to each doubling of the touches.
const PER_DOUBLING: i32 = 6;

row! {
    /// A measurement of the study `policies`.
    pub struct PoliciesMeasurement {
        policy: String = "policy",
        seed: u64 = "seed",
        touches: usize = "touches",
        motions: u64 = "motions",
        babbling_s: WallTime = "babbling, s",
        heldout_mm: f64 = "held-out, mm",
        converged: bool = "converged",
        learning_s: WallTime = "learning, s",
    }
}

row! {
    /// A row of the summary of the study `policies`.
    pub struct PoliciesSummary {
        policy: String = "policy",
        touches_to_10_mm: f64 = "touches to 10 mm",
        motions_to_10_mm: f64 = "motions",
        seconds_to_10_mm: WallTime = "s",
        touches_to_1_mm: f64 = "touches to 1 mm",
        motions_to_1_mm: f64 = "motions",
        seconds_to_1_mm: WallTime = "s",
        touches_ratio: f64 = "touches/random",
        motions_ratio: f64 = "motions/random",
        heldout_mm: f64 = "at last, mm",
    }
}

/// What it took to come to an error for good: touches, motions, seconds; infinite where it never did.
type BabblingCost = [f64; 3];

/// How one policy did in one trial.
struct PolicyCourse {
    /// Per level, the cost to it.
    costs: [BabblingCost; LEVELS_MM.len()],
    /// Error from all touches, millimetres.
    heldout_mm: f64,
    /// Motions and errors where they were measured.
    dots: Vec<(f64, f64)>,
}

/// The measurements of one trial: policy by policy, from all touches down.
#[derive(Debug, Serialize, Deserialize)]
pub struct PoliciesTrial(Vec<PoliciesMeasurement>);

impl Trial for PoliciesTrial {
    type Setting = ();
    type Measurement = PoliciesMeasurement;
    type Summary = PoliciesSummary;

    fn set_up(_subject: &Subject) -> Result<(), ExperimentError> {
        Ok(())
    }

    fn run(subject: &Subject, (): &(), seed: u64) -> Result<PoliciesTrial, ExperimentError> {
        let mut measurements = Vec::new();
        for &policy in PolicyName::ALL {
            let babbled = subject.babble_by(policy, seed)?;
            // From all touches down: once the greatest level is exceeded, fewer touches change nothing.
            for &count in touch_counts(subject.touches).iter().rev() {
                subject.tell(seed, &format!("{policy}, {count} touches"));
                let attempt = subject.learn(&LearningOptions::default(), &babbled.touches[..count], seed);
                measurements.push(PoliciesMeasurement {
                    policy: policy.to_string(),
                    seed,
                    touches: count,
                    motions: babbled.motions[count - 1],
                    babbling_s: WallTime(babbled.seconds[count - 1]),
                    heldout_mm: attempt.heldout_mm(),
                    converged: attempt.converged(),
                    learning_s: attempt.seconds,
                });
                if exceeds(attempt.heldout_mm(), LEVELS_MM[0]) {
                    break;
                }
            }
        }
        Ok(PoliciesTrial(measurements))
    }

    fn findings(
        subject: &Subject,
        trials: &[PoliciesTrial],
    ) -> Findings<PoliciesMeasurement, PoliciesSummary> {
        findings(&touch_counts(subject.touches), trials)
    }
}

impl PolicyCourse {
    /// How a policy did in a trial.
    fn of(policy: PolicyName, trial: &PoliciesTrial) -> PolicyCourse {
        let name = policy.to_string();
        let rows = trial.0.iter().filter(|row| row.policy == name);
        let learned: Vec<(BabblingCost, f64)> = rows.map(|row| (cost(row), row.heldout_mm)).collect();
        PolicyCourse {
            costs: LEVELS_MM.map(|level| cost_to(level, &learned)),
            heldout_mm: learned.first().map_or(f64::NAN, |(_, error)| *error),
            dots: learned.iter().map(|(cost, error)| (cost[1], *error)).collect(),
        }
    }
}

fn findings(counts: &[usize], trials: &[PoliciesTrial]) -> Findings<PoliciesMeasurement, PoliciesSummary> {
    let courses_of = |policy: PolicyName| -> Vec<PolicyCourse> {
        trials.iter().map(|trial| PolicyCourse::of(policy, trial)).collect()
    };
    let needed = |courses: &[PolicyCourse], level: usize, k: usize| {
        median(courses.iter().map(|course| course.costs[level][k]))
    };
    let mut summary: Vec<PoliciesSummary> = Vec::new();
    let mut series = Vec::new();
    let random = courses_of(PolicyName::Random);
    for &policy in PolicyName::ALL {
        let courses = courses_of(policy);
        let [ten, one] = [0, 1].map(|level| [0, 1, 2].map(|k| needed(&courses, level, k)));
        summary.push(PoliciesSummary {
            policy: policy.to_string(),
            touches_to_10_mm: ten[0],
            motions_to_10_mm: ten[1],
            seconds_to_10_mm: WallTime(ten[2]),
            touches_to_1_mm: one[0],
            motions_to_1_mm: one[1],
            seconds_to_1_mm: WallTime(one[2]),
            touches_ratio: one[0] / needed(&random, 1, 0),
            motions_ratio: one[1] / needed(&random, 1, 1),
            heldout_mm: median(courses.iter().map(|course| course.heldout_mm)),
        });
        series.push(PlotSeries {
            name: policy.to_string(),
            line: Vec::new(),
            dots: courses.iter().flat_map(|course| course.dots.iter().copied()).collect(),
        });
    }
    let counts: Vec<String> = counts.iter().map(usize::to_string).collect();
    let notes = vec![
        format!(
            "Learner lm, mean held-out errors, measured from all touches down to the first count that leaves \
             more than {} mm, of {}.",
            LEVELS_MM[0],
            counts.join(", ")
        ),
        "To an error: the least count from which on it is not exceeded; medians over trials, – where half of \
         them or more never get there. Every motion counts, whatever it ended in; seconds are those of \
         babbling, what a policy learns on the way included."
            .to_string(),
        "Ratios are those of the medians to 1 mm.".to_string(),
    ];
    let plot = StudyPlot {
        x: PlotAxis { title: "motions", scale: AxisScale::Logarithmic },
        y: PlotAxis { title: "mean held-out error of lm, mm (dots: trials)", scale: AxisScale::Logarithmic },
        series,
    };
    let measurements = trials.iter().flat_map(|trial| trial.0.clone()).collect();
    Findings { measurements, summary, notes, plot, numbers: Vec::new() }
}

fn exceeds(error: f64, level: f64) -> bool {
    error.is_nan() || error > level
}

/// What the touches of a measurement cost.
fn cost(row: &PoliciesMeasurement) -> BabblingCost {
    [row.touches as f64, row.motions as f64, row.babbling_s.0]
}

/// The least cost from which on a level is not exceeded; costs and errors stand from the greatest count down.
fn cost_to(level: f64, learned: &[(BabblingCost, f64)]) -> BabblingCost {
    let kept = learned.iter().take_while(|(_, error)| !exceeds(*error, level));
    kept.last().map_or([f64::INFINITY; 3], |(cost, _)| *cost)
}

/// The counts at which touches are learned from, up to `most` and with it: 100, 112, 126, 141 and so on.
fn touch_counts(most: usize) -> Vec<usize> {
    let count = |k: i32| (LEAST as f64 * 2f64.powf(f64::from(k) / f64::from(PER_DOUBLING))).round() as usize;
    (0..).map(count).take_while(|&count| count < most).chain([most]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_double_in_six_and_end_with_the_last() {
        assert_eq!(touch_counts(40), [40]);
        assert_eq!(touch_counts(210), [100, 112, 126, 141, 159, 178, 200, 210]);
        assert_eq!(touch_counts(400).last(), Some(&400));
    }

    #[test]
    fn a_level_is_reached_where_no_more_touches_exceed_it() {
        let learned = |errors: &[f64]| -> Vec<(BabblingCost, f64)> {
            errors.iter().enumerate().map(|(k, &error)| ([100.0 - k as f64; 3], error)).collect()
        };
        assert_eq!(cost_to(1.0, &learned(&[0.1, 1.0, 2.0, 0.1])), [99.0; 3]);
        assert_eq!(cost_to(10.0, &learned(&[0.1, 1.0, 2.0, f64::NAN])), [98.0; 3]);
        assert_eq!(cost_to(1.0, &learned(&[2.0])), [f64::INFINITY; 3]);
    }
}
