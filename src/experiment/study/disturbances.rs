//! What it costs when the senses are wrong.

use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{LearnerRun, Subject, median, share};
use super::table::row;
use super::{Findings, Study};
use crate::experiment::DisturbanceLevels;
use crate::experiment::ExperimentError;
use crate::experiment::LearningOptions;

/// The study `disturbances`.
pub const STUDY: Study = Study {
    name: "disturbances",
    about: "what it costs lm when the senses are wrong",
    touches: true,
    several: false,
    measure: |subject| Ok(measure(subject)?.into()),
};

/// Joint noise in degrees, receptor noise in millimetres, share of false touches. The first is the one that
/// all others are compared with.
const CONDITIONS: [[f64; 3]; 11] = [
    [0.0, 0.0, 0.0],
    [0.05, 0.0, 0.0],
    [0.1, 0.0, 0.0],
    [0.2, 0.0, 0.0],
    [0.0, 0.5, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 2.0, 0.0],
    [0.0, 0.0, 0.02],
    [0.0, 0.0, 0.05],
    [0.0, 0.0, 0.1],
    [0.1, 1.0, 0.05],
];

row! {
    /// A measurement of the study `disturbances`.
    pub struct DisturbancesMeasurement {
        disturbances: String = "disturbances",
        joint_noise_deg: f64 = "joint noise, °",
        receptor_noise_mm: f64 = "receptor noise, mm",
        false_touches: f64 = "false touches",
        seed: u64 = "seed",
        converged: bool = "converged",
        heldout_mm: f64 = "held-out, mm",
        hand_mm: f64 = "hand, mm",
        noise_estimate_mm: f64 = "own noise estimate, mm",
        factor: f64 = "times undisturbed",
        initial_guesses: usize = "initial guesses",
        seconds: f64 = "seconds",
    }
}

row! {
    /// A row of the summary of the study `disturbances`.
    pub struct DisturbancesSummary {
        disturbances: String = "disturbances",
        converged: f64 = "converged, share",
        heldout_mm: f64 = "held-out, mm",
        hand_mm: f64 = "hand, mm",
        noise_estimate_mm: f64 = "own noise estimate, mm",
        factor: f64 = "times undisturbed",
        seconds: f64 = "learning, s",
    }
}

/// What one condition came to in one trial.
struct DisturbedTrial {
    attempt: LearnerRun,
    factor: f64,
}

impl DisturbedTrial {
    /// Standard deviation of a touch's gap as the learner itself sees it, millimetres; NaN where it failed.
    fn noise_estimate_mm(&self) -> f64 {
        self.attempt.learned.deviation.map_or(f64::NAN, |metres| 1e3 * metres)
    }
}

fn levels(joint_noise: f64, receptor_noise: f64, false_touches: f64) -> DisturbanceLevels {
    DisturbanceLevels { joint_noise, receptor_noise, false_touches, point_noise: 0.0 }
}

/// Measures; a trial that does not succeed is a finding.
///
/// # Errors
/// Where something cannot be measured at all.
pub fn measure(
    subject: &Subject,
) -> Result<Findings<DisturbancesMeasurement, DisturbancesSummary>, ExperimentError> {
    let conditions = CONDITIONS.map(|[joints, receptors, touches]| {
        (levels(joints, receptors, touches), [joints, receptors, touches])
    });
    let mut measurements: Vec<DisturbancesMeasurement> = Vec::new();
    let mut found: Vec<Vec<DisturbedTrial>> = conditions.iter().map(|_| Vec::new()).collect();
    for &seed in &subject.seeds {
        let touches = subject.babble(seed)?;
        let mut undisturbed_mm = f64::NAN;
        for (k, (disturbances, amounts)) in conditions.iter().enumerate() {
            subject.tell(seed, &format!("disturbances: {disturbances}"));
            let options = LearningOptions { disturbances: *disturbances, ..LearningOptions::default() };
            let attempt = subject.learn(&options, &touches, seed);
            if k == 0 {
                undisturbed_mm = attempt.heldout_mm();
            }
            let trial = DisturbedTrial { factor: attempt.heldout_mm() / undisturbed_mm, attempt };
            measurements.push(DisturbancesMeasurement {
                disturbances: disturbances.to_string(),
                joint_noise_deg: amounts[0],
                receptor_noise_mm: amounts[1],
                false_touches: amounts[2],
                seed,
                converged: trial.attempt.converged(),
                heldout_mm: trial.attempt.heldout_mm(),
                hand_mm: trial.attempt.hand_mm(),
                noise_estimate_mm: trial.noise_estimate_mm(),
                factor: trial.factor,
                initial_guesses: trial.attempt.learned.initial_guesses,
                seconds: trial.attempt.seconds,
            });
            found[k].push(trial);
        }
    }
    let mut summary: Vec<DisturbancesSummary> = Vec::new();
    for ((disturbances, _), trials) in conditions.iter().zip(&found) {
        let median_of = |value: fn(&DisturbedTrial) -> f64| median(trials.iter().map(value));
        // A learner that failed makes no estimate; the others' still tell.
        let estimates = trials.iter().map(DisturbedTrial::noise_estimate_mm).filter(|mm| mm.is_finite());
        summary.push(DisturbancesSummary {
            disturbances: disturbances.to_string(),
            converged: share(trials.iter().map(|trial| trial.attempt.converged())),
            heldout_mm: median_of(|trial| trial.attempt.heldout_mm()),
            hand_mm: median_of(|trial| trial.attempt.hand_mm()),
            noise_estimate_mm: median(estimates),
            factor: median_of(|trial| trial.factor),
            seconds: median_of(|trial| trial.attempt.seconds),
        });
    }
    let notes = vec![
        "Medians over all trials, those that did not converge among them; errors are mean held-out errors on \
         the true skin."
            .to_string(),
        "The learner's own noise estimate is the deviation of a touch's gap, at least 0.001 mm, from the trials \
         that converged; where none did there is none."
            .to_string(),
        "Joint noise is a standard deviation per angle and touch, receptor noise one per coordinate, drawn once \
         per trial; false touches have a random receptor at one end."
            .to_string(),
    ];
    // The plot has little room for the words of a combination.
    let label = |(disturbances, amounts): &(DisturbanceLevels, [f64; 3])| {
        let [joints, receptors, touches] = amounts;
        match amounts.iter().filter(|amount| **amount > 0.0).count() {
            0 | 1 => disturbances.to_string(),
            _ => format!("together {joints}°, {receptors} mm, {:.0} %", 1e2 * touches),
        }
    };
    let names = conditions.iter().map(label).collect();
    let plot = StudyPlot {
        x: PlotAxis { title: "mean held-out error, mm", scale: AxisScale::Logarithmic },
        y: PlotAxis { title: "", scale: AxisScale::Names(names) },
        series: [("converged", true), ("not converged", false)].map(|which| dots(which, &found)).into(),
    };
    Ok(Findings { measurements, summary, notes, plot, numbers: Vec::new() })
}

/// The trials that converged or those that did not, at their condition's place, a little apart.
fn dots((name, converged): (&str, bool), found: &[Vec<DisturbedTrial>]) -> PlotSeries {
    let mut dots = Vec::new();
    for (condition, trials) in found.iter().enumerate() {
        for (k, trial) in trials.iter().enumerate() {
            if trial.attempt.converged() == converged {
                let apart = 0.5 * ((k as f64 + 0.5) / trials.len() as f64 - 0.5);
                dots.push((trial.attempt.heldout_mm(), condition as f64 + apart));
            }
        }
    }
    PlotSeries { name: name.to_string(), line: Vec::new(), dots }
}
