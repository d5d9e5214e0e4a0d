//! What it costs when the senses are wrong.

use serde::{Deserialize, Serialize};

use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median, share};
use super::table::{WallTime, row};
use super::{Findings, Study, Trial, Trials};
use crate::experiment::DisturbanceLevels;
use crate::experiment::ExperimentError;
use crate::experiment::LearningOptions;

/// The study `disturbances`.
pub const STUDY: Study = Study {
    name: "disturbances",
    about: "what it costs lm when the senses are wrong",
    touches: true,
    several: false,
    trials: Trials::of::<DisturbancesTrial>(),
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
        seconds: WallTime = "seconds",
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
        seconds: WallTime = "learning, s",
    }
}

fn levels([joint_noise, receptor_noise, false_touches]: [f64; 3]) -> DisturbanceLevels {
    DisturbanceLevels { joint_noise, receptor_noise, false_touches, point_noise: 0.0 }
}

/// The measurements of one trial, one for each condition.
#[derive(Debug, Serialize, Deserialize)]
pub struct DisturbancesTrial(Vec<DisturbancesMeasurement>);

impl Trial for DisturbancesTrial {
    type Setting = ();
    type Measurement = DisturbancesMeasurement;
    type Summary = DisturbancesSummary;

    fn set_up(_subject: &Subject) -> Result<(), ExperimentError> {
        Ok(())
    }

    fn run(subject: &Subject, (): &(), seed: u64) -> Result<DisturbancesTrial, ExperimentError> {
        let touches = subject.babble(seed)?;
        let mut undisturbed_mm = f64::NAN;
        let mut measurements = Vec::new();
        for (k, amounts) in CONDITIONS.into_iter().enumerate() {
            let disturbances = levels(amounts);
            subject.tell(seed, &format!("disturbances: {disturbances}"));
            let options = LearningOptions { disturbances, ..LearningOptions::default() };
            let attempt = subject.learn(&options, &touches, seed);
            if k == 0 {
                undisturbed_mm = attempt.heldout_mm();
            }
            measurements.push(DisturbancesMeasurement {
                disturbances: disturbances.to_string(),
                joint_noise_deg: amounts[0],
                receptor_noise_mm: amounts[1],
                false_touches: amounts[2],
                seed,
                converged: attempt.converged(),
                heldout_mm: attempt.heldout_mm(),
                hand_mm: attempt.hand_mm(),
                // Of a touch's gap as the learner itself sees it; there is none where it failed.
                noise_estimate_mm: attempt.learned.deviation.map_or(f64::NAN, |metres| 1e3 * metres),
                factor: attempt.heldout_mm() / undisturbed_mm,
                initial_guesses: attempt.learned.initial_guesses,
                seconds: attempt.seconds,
            });
        }
        Ok(DisturbancesTrial(measurements))
    }

    fn findings(
        _subject: &Subject,
        trials: &[DisturbancesTrial],
    ) -> Findings<DisturbancesMeasurement, DisturbancesSummary> {
        findings(trials)
    }
}

fn findings(trials: &[DisturbancesTrial]) -> Findings<DisturbancesMeasurement, DisturbancesSummary> {
    let of = |k: usize| trials.iter().filter_map(move |trial| trial.0.get(k));
    let mut summary: Vec<DisturbancesSummary> = Vec::new();
    for (k, amounts) in CONDITIONS.into_iter().enumerate() {
        let median_of = |value: fn(&DisturbancesMeasurement) -> f64| median(of(k).map(value));
        // A learner that failed makes no estimate; the others' still tell.
        let estimates = of(k).map(|row| row.noise_estimate_mm).filter(|mm| mm.is_finite());
        summary.push(DisturbancesSummary {
            disturbances: levels(amounts).to_string(),
            converged: share(of(k).map(|row| row.converged)),
            heldout_mm: median_of(|row| row.heldout_mm),
            hand_mm: median_of(|row| row.hand_mm),
            noise_estimate_mm: median(estimates),
            factor: median_of(|row| row.factor),
            seconds: WallTime(median_of(|row| row.seconds.0)),
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
    let label = |amounts: [f64; 3]| {
        let [joints, receptors, touches] = amounts;
        match amounts.iter().filter(|amount| **amount > 0.0).count() {
            0 | 1 => levels(amounts).to_string(),
            _ => format!("together {joints}°, {receptors} mm, {:.0} %", 1e2 * touches),
        }
    };
    let names = CONDITIONS.map(label).into();
    let plot = StudyPlot {
        x: PlotAxis { title: "mean held-out error, mm", scale: AxisScale::Logarithmic },
        y: PlotAxis { title: "", scale: AxisScale::Names(names) },
        series: [("converged", true), ("not converged", false)].map(|which| dots(which, trials)).into(),
    };
    let measurements = trials.iter().flat_map(|trial| trial.0.clone()).collect();
    Findings { measurements, summary, notes, plot, numbers: Vec::new() }
}

/// The trials that converged or those that did not, at their condition's place, a little apart.
fn dots((name, converged): (&str, bool), trials: &[DisturbancesTrial]) -> PlotSeries {
    let mut dots = Vec::new();
    for condition in 0..CONDITIONS.len() {
        for (k, trial) in trials.iter().enumerate() {
            if let Some(row) = trial.0.get(condition).filter(|row| row.converged == converged) {
                let apart = 0.5 * ((k as f64 + 0.5) / trials.len() as f64 - 0.5);
                dots.push((row.heldout_mm, condition as f64 + apart));
            }
        }
    }
    PlotSeries { name: name.to_string(), line: Vec::new(), dots }
}
