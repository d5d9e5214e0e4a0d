//! Whether the learner gets as near as it can, and knows how near that is.

use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median, share};
use super::table::{WallTime, row};
use super::{Findings, Study, Trial, Trials};
use crate::evaluation::coverage::{NormalizedErrors, covered, with_gap_noise};
use crate::evaluation::{CramerRaoBound, held_out, held_out_points};
use crate::experiment::ExperimentError;
use crate::learning::{Input, Learned, Learner, SecondOrder, Verdict};
use crate::senses::Touch;

/// The study `coverage`.
pub const STUDY: Study = Study {
    name: "coverage",
    about: "how near lm gets to the least possible error, and how often its intervals hold the truth",
    touches: true,
    several: false,
    trials: Trials::of::<CoverageTrial>(),
};

/// Where a fit begins.
#[derive(Clone, Copy, PartialEq)]
enum StartingPoint {
    /// At the truth: what is found is the optimum, whatever the way there.
    Truth,
    /// At random, as always.
    Random,
}

impl StartingPoint {
    fn name(self) -> &'static str {
        match self {
            StartingPoint::Truth => "the truth",
            StartingPoint::Random => "random",
        }
    }
}

/// Standard deviation of the gaps in millimetres, and where the fit begins.
const CONDITIONS: [(f64, StartingPoint); 7] = [
    (0.01, StartingPoint::Truth),
    (0.03, StartingPoint::Truth),
    (0.1, StartingPoint::Truth),
    (0.3, StartingPoint::Truth),
    (1.0, StartingPoint::Truth),
    (0.03, StartingPoint::Random),
    (0.1, StartingPoint::Random),
];

row! {
    /// A measurement of the study `coverage`.
    pub struct CoverageMeasurement {
        initial_guess: String = "initial guess",
        noise_mm: f64 = "noise, mm",
        seed: u64 = "seed",
        touches: usize = "touches",
        converged: bool = "converged",
        noise_estimate_mm: f64 = "own noise estimate, mm",
        bound_rms_mm: f64 = "bound, mm",
        error_rms_mm: f64 = "error, mm",
        ratio: f64 = "error / bound",
        points_covered: f64 = "points covered",
        positions_covered: f64 = "positions covered",
        axes_covered: f64 = "axes covered",
        seconds: WallTime = "seconds",
    }
}

row! {
    /// A row of the summary of the study `coverage`.
    pub struct CoverageSummary {
        initial_guess: String = "initial guess",
        noise_mm: f64 = "noise, mm",
        converged: f64 = "converged, share",
        noise_estimate_mm: f64 = "own noise estimate, mm",
        bound_rms_mm: f64 = "bound, mm",
        error_rms_mm: f64 = "error, mm",
        ratio: f64 = "error / bound",
        points_covered: f64 = "points covered",
        positions_covered: f64 = "positions",
        axes_covered: f64 = "axes",
        seconds: WallTime = "seconds",
    }
}

/// The measurements of one trial, one for each condition.
#[derive(Debug, Serialize, Deserialize)]
pub struct CoverageTrial(Vec<CoverageMeasurement>);

impl CoverageMeasurement {
    /// Whether there is a bound that its errors can be held against.
    fn is_bounded(&self) -> bool {
        !self.bound_rms_mm.is_nan()
    }
}

impl Trial for CoverageTrial {
    type Setting = ();
    type Measurement = CoverageMeasurement;
    type Summary = CoverageSummary;

    fn set_up(_subject: &Subject) -> Result<(), ExperimentError> {
        Ok(())
    }

    fn run(subject: &Subject, (): &(), seed: u64) -> Result<CoverageTrial, ExperimentError> {
        let touches = subject.babble(seed)?;
        let measured = CONDITIONS.iter().map(|&(noise_mm, initial_guess)| {
            subject.tell(seed, &format!("noise of {noise_mm} mm, initial guess {}", initial_guess.name()));
            attempt(subject, &touches, noise_mm, initial_guess, seed)
        });
        Ok(CoverageTrial(measured.collect()))
    }

    fn findings(
        _subject: &Subject,
        trials: &[CoverageTrial],
    ) -> Findings<CoverageMeasurement, CoverageSummary> {
        findings(trials)
    }
}

fn findings(trials: &[CoverageTrial]) -> Findings<CoverageMeasurement, CoverageSummary> {
    let mut summary: Vec<CoverageSummary> = Vec::new();
    for (k, (noise_mm, initial_guess)) in CONDITIONS.iter().enumerate() {
        let of = || trials.iter().filter_map(|trial| trial.0.get(k));
        let judged = || of().filter(|row| row.converged && row.is_bounded());
        let mean_of = |value: fn(&CoverageMeasurement) -> f64| mean(judged().map(value));
        let (bound, error) =
            (mean_of(|row| row.bound_rms_mm.powi(2)).sqrt(), mean_of(|row| row.error_rms_mm.powi(2)).sqrt());
        summary.push(CoverageSummary {
            initial_guess: initial_guess.name().into(),
            noise_mm: *noise_mm,
            converged: share(of().map(|row| row.converged)),
            noise_estimate_mm: mean_of(|row| row.noise_estimate_mm),
            bound_rms_mm: bound,
            error_rms_mm: error,
            ratio: error / bound,
            points_covered: mean_of(|row| row.points_covered),
            positions_covered: mean_of(|row| row.positions_covered),
            axes_covered: mean_of(|row| row.axes_covered),
            seconds: WallTime(median(of().map(|row| row.seconds.0))),
        });
    }
    let notes = vec![
        "Errors and bounds are root mean squares over held-out points and trials; the bound is Cramér's and \
         Rao's, from the touches and the noise as the learner itself sees them."
            .to_string(),
        "Covered: the share of errors, coordinate by coordinate, within the learner's own 95 % intervals; 0.95 is \
         right. Only trials that converged are judged."
            .to_string(),
        "The noise is what the model assumes: every gap at the true body is drawn from a normal distribution, by \
         moving the posture. The initial guess \"the truth\" shows the optimum and no way there."
            .to_string(),
    ];
    let plot = StudyPlot {
        x: PlotAxis { title: "Cramér-Rao bound, rms, mm", scale: AxisScale::Logarithmic },
        y: PlotAxis { title: "held-out error, rms, mm (line: the bound)", scale: AxisScale::Logarithmic },
        series: series(trials),
    };
    let measurements = trials.iter().flat_map(|trial| trial.0.clone()).collect();
    Findings { measurements, summary, notes, plot, numbers: Vec::new() }
}

/// One fit and its judgement.
fn attempt(
    subject: &Subject,
    touches: &[Touch],
    noise_mm: f64,
    initial_guess: StartingPoint,
    seed: u64,
) -> CoverageMeasurement {
    let (agent, truth) = (subject.agent(), subject.truth());
    let creature = agent.creature();
    let noisy = with_gap_noise(agent, truth, touches, 1e-3 * noise_mm, seed);
    let began = Instant::now();
    let mut learner = SecondOrder::new(agent, Input::Receptor, seed);
    noisy.iter().for_each(|touch| learner.touch(touch));
    let learned: Learned = match initial_guess {
        StartingPoint::Truth => learner.refine(&truth.schema),
        StartingPoint::Random => learner.learn(),
    };
    let seconds = WallTime(began.elapsed().as_secs_f64());
    let points = held_out_points(agent);
    let schema = &learned.schema;
    let (mut bound, mut shares) = (None, [f64::NAN; 3]);
    if let Some(account) = &learned.account {
        let observability = &account.observability;
        let errors = held_out(creature, truth, schema, &points);
        bound = CramerRaoBound::new(creature, schema, account, observability, &points, &errors);
        let errors = NormalizedErrors::new(creature, truth, schema, observability, &points);
        shares = [&errors.points, &errors.positions, &errors.axes].map(|errors| covered(errors));
    }
    let of = |value: fn(&CramerRaoBound) -> f64| bound.as_ref().map_or(f64::NAN, value);
    let [points_covered, positions_covered, axes_covered] = shares;
    CoverageMeasurement {
        initial_guess: initial_guess.name().into(),
        noise_mm,
        seed,
        touches: noisy.len(),
        converged: !matches!(learned.verdict, Verdict::Failed(_)),
        noise_estimate_mm: learned.deviation.map_or(f64::NAN, |metres| 1e3 * metres),
        bound_rms_mm: of(|bound| bound.bound_rms),
        error_rms_mm: of(|bound| bound.error_rms),
        ratio: of(|bound| bound.ratio),
        points_covered,
        positions_covered,
        axes_covered,
        seconds,
    }
}

/// The trials of each initial guess, the error over the bound; and the bound itself as a line.
fn series(trials: &[CoverageTrial]) -> Vec<PlotSeries> {
    let bounded = || trials.iter().flat_map(|trial| &trial.0).filter(|row| row.is_bounded());
    let dots = |initial_guess: StartingPoint| {
        let rows = bounded().filter(|row| row.initial_guess == initial_guess.name());
        rows.map(|row| (row.bound_rms_mm, row.error_rms_mm)).collect()
    };
    let all: Vec<f64> = bounded().map(|row| row.bound_rms_mm).collect();
    let least = all.iter().copied().fold(f64::INFINITY, f64::min);
    let greatest = all.iter().copied().fold(0.0, f64::max);
    let line = if all.is_empty() { Vec::new() } else { vec![(least, least), (greatest, greatest)] };
    let mut series = vec![PlotSeries { name: "bound".to_string(), line, dots: Vec::new() }];
    for initial_guess in [StartingPoint::Truth, StartingPoint::Random] {
        let name = format!("initial guess: {}", initial_guess.name());
        series.push(PlotSeries { name, line: Vec::new(), dots: dots(initial_guess) });
    }
    series
}

/// The arithmetic mean; NaN of nothing.
fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}
