//! What it costs when the senses are wrong.

use super::plot::{Axis, Plot, Scale, Series};
use super::subject::{Attempt, Subject, median, share};
use super::table::{Column, Table};
use super::{Failure, Findings, Study};
use crate::cli::disturbance_options::DisturbanceOptions;
use crate::cli::learn_options::LearnOptions;

/// The study `disturbances`.
pub const STUDY: Study = Study {
    name: "disturbances",
    about: "what it costs lm when the senses are wrong",
    touches: true,
    measure,
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

const MEASUREMENTS: &[Column] = &[
    Column { name: "disturbances", heading: "disturbances" },
    Column { name: "joint_noise_deg", heading: "joint noise, °" },
    Column { name: "receptor_noise_mm", heading: "receptor noise, mm" },
    Column { name: "false_touches", heading: "false touches" },
    Column { name: "seed", heading: "seed" },
    Column { name: "converged", heading: "converged" },
    Column { name: "heldout_mm", heading: "held-out, mm" },
    Column { name: "hand_mm", heading: "hand, mm" },
    Column { name: "noise_estimate_mm", heading: "own noise estimate, mm" },
    Column { name: "factor", heading: "times undisturbed" },
    Column { name: "onsets", heading: "onsets" },
    Column { name: "seconds", heading: "seconds" },
];

const SUMMARY: &[Column] = &[
    Column { name: "disturbances", heading: "disturbances" },
    Column { name: "converged", heading: "converged, share" },
    Column { name: "heldout_mm", heading: "held-out, mm" },
    Column { name: "hand_mm", heading: "hand, mm" },
    Column { name: "noise_estimate_mm", heading: "own noise estimate, mm" },
    Column { name: "factor", heading: "times undisturbed" },
    Column { name: "seconds", heading: "learning, s" },
];

/// What one condition came to in one trial.
struct Trial {
    attempt: Attempt,
    factor: f64,
}

impl Trial {
    /// Standard deviation of a touch's gap as the learner itself sees it, millimetres; NaN where it failed.
    fn noise_estimate_mm(&self) -> f64 {
        self.attempt.learned.deviation.map_or(f64::NAN, |metres| 1e3 * metres)
    }
}

fn measure(subject: &Subject) -> Result<Findings, Failure> {
    let conditions = CONDITIONS.map(|[joints, receptors, touches]| {
        (DisturbanceOptions::new(joints, receptors, touches), [joints, receptors, touches])
    });
    let mut measurements = Table::new(MEASUREMENTS);
    let mut found: Vec<Vec<Trial>> = conditions.iter().map(|_| Vec::new()).collect();
    for &seed in &subject.seeds {
        let touches = subject.babble(seed)?;
        let mut undisturbed_mm = f64::NAN;
        for (k, (disturbances, amounts)) in conditions.iter().enumerate() {
            subject.tell(seed, &format!("disturbances: {disturbances}"));
            let options = LearnOptions { disturbances: *disturbances, ..LearnOptions::default() };
            let attempt = subject.learn(&options, &touches, seed);
            if k == 0 {
                undisturbed_mm = attempt.heldout_mm();
            }
            let trial = Trial { factor: attempt.heldout_mm() / undisturbed_mm, attempt };
            measurements.row([
                disturbances.to_string().into(),
                amounts[0].into(),
                amounts[1].into(),
                amounts[2].into(),
                seed.into(),
                trial.attempt.converged().into(),
                trial.attempt.heldout_mm().into(),
                trial.attempt.hand_mm().into(),
                trial.noise_estimate_mm().into(),
                trial.factor.into(),
                trial.attempt.learned.onsets.into(),
                trial.attempt.seconds.into(),
            ]);
            found[k].push(trial);
        }
    }
    let mut summary = Table::new(SUMMARY);
    for ((disturbances, _), trials) in conditions.iter().zip(&found) {
        let median_of = |value: fn(&Trial) -> f64| median(trials.iter().map(value));
        // A learner that failed makes no estimate; the others' still tell.
        let estimates = trials.iter().map(Trial::noise_estimate_mm).filter(|mm| mm.is_finite());
        summary.row([
            disturbances.to_string().into(),
            share(trials.iter().map(|trial| trial.attempt.converged())).into(),
            median_of(|trial| trial.attempt.heldout_mm()).into(),
            median_of(|trial| trial.attempt.hand_mm()).into(),
            median(estimates).into(),
            median_of(|trial| trial.factor).into(),
            median_of(|trial| trial.attempt.seconds).into(),
        ]);
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
    let label = |(disturbances, amounts): &(DisturbanceOptions, [f64; 3])| {
        let [joints, receptors, touches] = amounts;
        match amounts.iter().filter(|amount| **amount > 0.0).count() {
            0 | 1 => disturbances.to_string(),
            _ => format!("together {joints}°, {receptors} mm, {:.0} %", 1e2 * touches),
        }
    };
    let names = conditions.iter().map(label).collect();
    let plot = Plot {
        x: Axis { title: "mean held-out error, mm", scale: Scale::Logarithmic },
        y: Axis { title: "", scale: Scale::Names(names) },
        series: [("converged", true), ("not converged", false)].map(|which| dots(which, &found)).into(),
    };
    Ok(Findings { measurements, summary, notes, plot, numbers: Vec::new() })
}

/// The trials that converged or those that did not, at their condition's place, a little apart.
fn dots((name, converged): (&str, bool), found: &[Vec<Trial>]) -> Series {
    let mut dots = Vec::new();
    for (condition, trials) in found.iter().enumerate() {
        for (k, trial) in trials.iter().enumerate() {
            if trial.attempt.converged() == converged {
                let apart = 0.5 * ((k as f64 + 0.5) / trials.len() as f64 - 0.5);
                dots.push((trial.attempt.heldout_mm(), condition as f64 + apart));
            }
        }
    }
    Series { name: name.to_string(), line: Vec::new(), dots }
}
