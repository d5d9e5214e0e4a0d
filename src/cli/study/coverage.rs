//! Whether the learner gets as near as it can, and knows how near that is.

use std::time::Instant;

use super::plot::{Axis, Plot, Scale, Series};
use super::subject::{Subject, median, share};
use super::table::{Column, Table};
use super::{Failure, Findings, Study};
use crate::evaluation::coverage::{NormalizedErrors, covered, with_gap_noise};
use crate::evaluation::{Bound, held_out, held_out_points};
use crate::learning::{Input, Learned, Learner, SecondOrder, Verdict};
use crate::senses::Touch;

/// The study `coverage`.
pub const STUDY: Study = Study {
    name: "coverage",
    about: "how near lm gets to the least possible error, and how often its intervals hold the truth",
    touches: true,
    measure,
};

/// Where a fit begins.
#[derive(Clone, Copy, PartialEq)]
enum Onset {
    /// At the truth: what is found is the optimum, whatever the way there.
    Truth,
    /// At random, as always.
    Random,
}

impl Onset {
    fn name(self) -> &'static str {
        match self {
            Onset::Truth => "the truth",
            Onset::Random => "random",
        }
    }
}

/// Standard deviation of the gaps in millimetres, and where the fit begins.
const CONDITIONS: [(f64, Onset); 7] = [
    (0.01, Onset::Truth),
    (0.03, Onset::Truth),
    (0.1, Onset::Truth),
    (0.3, Onset::Truth),
    (1.0, Onset::Truth),
    (0.03, Onset::Random),
    (0.1, Onset::Random),
];

const MEASUREMENTS: &[Column] = &[
    Column { name: "onset", heading: "onset" },
    Column { name: "noise_mm", heading: "noise, mm" },
    Column { name: "seed", heading: "seed" },
    Column { name: "touches", heading: "touches" },
    Column { name: "converged", heading: "converged" },
    Column { name: "noise_estimate_mm", heading: "own noise estimate, mm" },
    Column { name: "bound_rms_mm", heading: "bound, mm" },
    Column { name: "error_rms_mm", heading: "error, mm" },
    Column { name: "ratio", heading: "error / bound" },
    Column { name: "points_covered", heading: "points covered" },
    Column { name: "positions_covered", heading: "positions covered" },
    Column { name: "axes_covered", heading: "axes covered" },
    Column { name: "seconds", heading: "seconds" },
];

const SUMMARY: &[Column] = &[
    Column { name: "onset", heading: "onset" },
    Column { name: "noise_mm", heading: "noise, mm" },
    Column { name: "converged", heading: "converged, share" },
    Column { name: "noise_estimate_mm", heading: "own noise estimate, mm" },
    Column { name: "bound_rms_mm", heading: "bound, mm" },
    Column { name: "error_rms_mm", heading: "error, mm" },
    Column { name: "ratio", heading: "error / bound" },
    Column { name: "points_covered", heading: "points covered" },
    Column { name: "positions_covered", heading: "positions" },
    Column { name: "axes_covered", heading: "axes" },
    Column { name: "seconds", heading: "seconds" },
];

/// What one condition came to in one trial.
struct Trial {
    touches: usize,
    converged: bool,
    noise_estimate_mm: f64,
    bound: Option<Bound>,
    /// Shares of placed points, positions and axes within their intervals.
    covered: [f64; 3],
    seconds: f64,
}

impl Trial {
    fn of(&self, value: fn(&Bound) -> f64) -> f64 {
        self.bound.as_ref().map_or(f64::NAN, value)
    }
}

fn measure(subject: &Subject) -> Result<Findings, Failure> {
    let mut measurements = Table::new(MEASUREMENTS);
    let mut found: Vec<Vec<Trial>> = CONDITIONS.iter().map(|_| Vec::new()).collect();
    for &seed in &subject.seeds {
        let touches = subject.babble(seed)?;
        for (k, &(noise_mm, onset)) in CONDITIONS.iter().enumerate() {
            subject.tell(seed, &format!("noise of {noise_mm} mm, onset {}", onset.name()));
            let trial = attempt(subject, &touches, noise_mm, onset, seed);
            measurements.row([
                onset.name().into(),
                noise_mm.into(),
                seed.into(),
                trial.touches.into(),
                trial.converged.into(),
                trial.noise_estimate_mm.into(),
                trial.of(|bound| bound.bound_rms).into(),
                trial.of(|bound| bound.error_rms).into(),
                trial.of(|bound| bound.ratio).into(),
                trial.covered[0].into(),
                trial.covered[1].into(),
                trial.covered[2].into(),
                trial.seconds.into(),
            ]);
            found[k].push(trial);
        }
    }
    let mut summary = Table::new(SUMMARY);
    for ((noise_mm, onset), trials) in CONDITIONS.iter().zip(&found) {
        let judged = || trials.iter().filter(|trial| trial.converged && trial.bound.is_some());
        let rms = |value: fn(&Bound) -> f64| mean(judged().map(|trial| trial.of(value).powi(2))).sqrt();
        let (bound, error) = (rms(|bound| bound.bound_rms), rms(|bound| bound.error_rms));
        let covered = |kind: usize| mean(judged().map(|trial| trial.covered[kind]));
        summary.row([
            onset.name().into(),
            (*noise_mm).into(),
            share(trials.iter().map(|trial| trial.converged)).into(),
            mean(judged().map(|trial| trial.noise_estimate_mm)).into(),
            bound.into(),
            error.into(),
            (error / bound).into(),
            covered(0).into(),
            covered(1).into(),
            covered(2).into(),
            median(trials.iter().map(|trial| trial.seconds)).into(),
        ]);
    }
    let notes = vec![
        "Errors and bounds are root mean squares over held-out points and trials; the bound is Cramér's and \
         Rao's, from the touches and the noise as the learner itself sees them."
            .to_string(),
        "Covered: the share of errors, coordinate by coordinate, within the learner's own 95 % intervals; 0.95 is \
         right. Only trials that converged are judged."
            .to_string(),
        "The noise is what the model assumes: every gap at the true body is drawn from a normal distribution, by \
         moving the posture. The onset \"the truth\" shows the optimum and no way there."
            .to_string(),
    ];
    let plot = Plot {
        x: Axis { title: "Cramér-Rao bound, rms, mm", scale: Scale::Logarithmic },
        y: Axis { title: "held-out error, rms, mm (line: the bound)", scale: Scale::Logarithmic },
        series: series(&found),
    };
    Ok(Findings { measurements, summary, notes, plot, numbers: Vec::new() })
}

/// One fit and its judgement.
fn attempt(subject: &Subject, touches: &[Touch], noise_mm: f64, onset: Onset, seed: u64) -> Trial {
    let (creature, skin, truth) = (&subject.body.creature, &subject.skin, &subject.truth);
    let noisy = with_gap_noise(creature, skin, truth, touches, 1e-3 * noise_mm, seed);
    let began = Instant::now();
    let mut learner = SecondOrder::new(creature, skin, Input::Receptor, seed);
    noisy.iter().for_each(|touch| learner.touch(touch));
    let learned: Learned = match onset {
        Onset::Truth => learner.refine(&truth.schema),
        Onset::Random => learner.learn(),
    };
    let seconds = began.elapsed().as_secs_f64();
    let points = held_out_points(creature, skin);
    let schema = &learned.schema;
    let (mut bound, mut shares) = (None, [f64::NAN; 3]);
    if let Some(observability) = &learned.observability {
        let errors = held_out(creature, truth, schema, &points);
        bound = Bound::new(creature, schema, observability, &points, &errors, &learned.undetermined);
        let errors = NormalizedErrors::new(creature, truth, schema, observability, &points);
        shares = [&errors.points, &errors.positions, &errors.axes].map(|errors| covered(errors));
    }
    Trial {
        touches: noisy.len(),
        converged: !matches!(learned.verdict, Verdict::Failed(_)),
        noise_estimate_mm: learned.deviation.map_or(f64::NAN, |metres| 1e3 * metres),
        bound,
        covered: shares,
        seconds,
    }
}

/// The trials of each onset, the error over the bound; and the bound itself as a line.
fn series(found: &[Vec<Trial>]) -> Vec<Series> {
    let dots = |onset: Onset| {
        let trials = CONDITIONS.iter().zip(found).filter(|((_, other), _)| *other == onset);
        let bounds = trials.flat_map(|(_, trials)| trials).filter_map(|trial| trial.bound);
        bounds.map(|bound| (bound.bound_rms, bound.error_rms)).collect::<Vec<_>>()
    };
    let all: Vec<f64> = found.iter().flatten().filter_map(|trial| trial.bound).map(|b| b.bound_rms).collect();
    let least = all.iter().copied().fold(f64::INFINITY, f64::min);
    let greatest = all.iter().copied().fold(0.0, f64::max);
    let line = if all.is_empty() { Vec::new() } else { vec![(least, least), (greatest, greatest)] };
    let mut series = vec![Series { name: "bound".to_string(), line, dots: Vec::new() }];
    for onset in [Onset::Truth, Onset::Random] {
        let name = format!("onset: {}", onset.name());
        series.push(Series { name, line: Vec::new(), dots: dots(onset) });
    }
    series
}

/// The arithmetic mean; NaN of nothing.
fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}
