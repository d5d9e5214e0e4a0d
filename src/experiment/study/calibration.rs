//! Whether the verdict on a calibration is right, both ways: robots that are made up, with and without a fault, by four kinds of
//! data.

use std::time::Instant;

use serde::{Deserialize, Serialize};
use serde_json::json;

use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median};
use super::table::{WallTime, row};
use super::{Findings, Study, Trial, Trials};
use crate::calibration::made::{Data, Fault, Made};
use crate::calibration::{Estimator, EstimatorOptions, Misses, objections};
use crate::experiment::ExperimentError;

/// The study `calibration`.
pub const STUDY: Study = Study {
    name: "calibration",
    about: "whether the verdict on a calibration is right, of made robots with and without a fault, by four kinds of data",
    touches: false,
    several: false,
    trials: Trials::of::<CalibrationTrial>(),
};

row! {
    /// A measurement of the study `calibration`: a robot of one seed with one fault by one kind of data.
    pub struct CalibrationMeasurement {
        data: String = "data",
        case: String = "case",
        seed: u64 = "seed",
        touches: usize = "touches",
        calibrated: bool = "calibrated",
        right: bool = "right",
        named: String = "to be named",
        names_it: bool = "named",
        after_mm: f64 = "after, RMS, mm",
        deviations: f64 = "worst offset, deviations",
        seconds: WallTime = "seconds",
        objections: String = "objections",
    }
}

row! {
    /// A row of the summary of the study `calibration`.
    pub struct CalibrationSummary {
        data: String = "data",
        case: String = "case",
        trials: usize = "trials",
        calibrated: usize = "calibrated",
        wrong: usize = "wrong",
        to_be_named: usize = "to be named",
        named: usize = "named",
        deviations: f64 = "worst offset, deviations",
        seconds: WallTime = "seconds",
    }
}

/// The measurements of one seed.
#[derive(Debug, Serialize, Deserialize)]
pub struct CalibrationTrial(Vec<CalibrationMeasurement>);

/// A program that asks by a subject has its seeds: the robots are those of the seeds.
impl Trial for CalibrationTrial {
    type Setting = ();
    type Measurement = CalibrationMeasurement;
    type Summary = CalibrationSummary;

    fn set_up(_: &Subject) -> Result<(), ExperimentError> {
        Ok(())
    }

    fn run(_: &Subject, (): &(), seed: u64) -> Result<CalibrationTrial, ExperimentError> {
        Ok(trial(seed, &[]))
    }

    fn findings(
        _: &Subject,
        trials: &[CalibrationTrial],
    ) -> Findings<CalibrationMeasurement, CalibrationSummary> {
        findings(trials)
    }
}

/// What the robot of a seed comes to in some cases, all where none is named.
pub fn trial(seed: u64, cases: &[Fault]) -> CalibrationTrial {
    let cases = if cases.is_empty() { Fault::ALL } else { cases };
    let each = Data::ALL.iter().flat_map(|data| cases.iter().map(move |case| measured(*data, *case, seed)));
    CalibrationTrial(each.collect())
}

fn measured(data: Data, case: Fault, seed: u64) -> CalibrationMeasurement {
    let made = Made::new(data, case, seed);
    let started = Instant::now();
    let estimator = Estimator::new(&made.robot, &made.touches, EstimatorOptions::default());
    let fit = estimator.fit();
    let objections = objections(&estimator, &fit, &[]);
    let seconds = WallTime(started.elapsed().as_secs_f64());
    let off = |quantity: usize| {
        let place = estimator.unknowns.place(quantity, 0).filter(|place| fit.told.is_told(*place))?;
        Some(fit.values[quantity].distance(&made.truth[quantity]) / fit.told.deviation(place))
    };
    let offsets = made.robot.dofs.iter().filter_map(|dof| off(dof.quantities?.offset));
    let named = made.faulty.unwrap_or_default();
    let names_it = objections
        .iter()
        .filter_map(|objection| objection.about.as_ref())
        .any(|about| about.contains(&named));
    CalibrationMeasurement {
        data: data.name().into(),
        case: case.name().into(),
        seed,
        touches: made.touches.len(),
        calibrated: objections.is_empty(),
        right: objections.is_empty() == case.is_harmless(),
        names_it: !named.is_empty() && names_it,
        named,
        after_mm: 1e3 * Misses::of(&fit.honest()).rms,
        deviations: offsets.fold(0.0, f64::max),
        seconds,
        objections: objections.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "),
    }
}

/// What the trials show, in whatever order and from however many processes they come.
pub fn findings(trials: &[CalibrationTrial]) -> Findings<CalibrationMeasurement, CalibrationSummary> {
    let measurements: Vec<CalibrationMeasurement> = trials.iter().flat_map(|trial| trial.0.clone()).collect();
    let count =
        |is: &dyn Fn(&CalibrationMeasurement) -> bool| measurements.iter().filter(|one| is(one)).count();
    let mut summary = Vec::new();
    for data in Data::ALL {
        for case in Fault::ALL {
            let is_of = |one: &CalibrationMeasurement| one.data == data.name() && one.case == case.name();
            let of = || measurements.iter().filter(|one| is_of(one));
            if of().next().is_none() {
                continue;
            }
            summary.push(CalibrationSummary {
                data: data.name().into(),
                case: case.name().into(),
                trials: of().count(),
                calibrated: count(&|one| is_of(one) && one.calibrated),
                wrong: count(&|one| is_of(one) && !one.right),
                to_be_named: count(&|one| is_of(one) && !one.named.is_empty()),
                named: count(&|one| is_of(one) && one.names_it),
                deviations: of().map(|one| one.deviations).fold(0.0, f64::max),
                seconds: WallTime(median(of().map(|one| one.seconds.0).collect::<Vec<f64>>())),
            });
        }
    }
    let is_harmless = |one: &CalibrationMeasurement| one.case.parse::<Fault>().is_ok_and(Fault::is_harmless);
    let faulty = count(&|one| !is_harmless(one));
    let missed = count(&|one| !is_harmless(one) && one.calibrated);
    let harmless = count(&is_harmless);
    let refused = count(&|one| is_harmless(one) && !one.calibrated);
    let to_be_named = count(&|one| !one.named.is_empty());
    let named = count(&|one| one.names_it);
    let notes = vec![
        format!("Calibrated with a fault: {missed} of {faulty}; not calibrated without one: {refused} of {harmless}; named: {named} of {to_be_named}."),
        "Without a fault, with rows that are copied, and with one touch in ten of another place, calibrated is right; with what \
         else is wrong it is not. An offset's deviations are how many of its own it is off.".into(),
    ];
    let dots = |data: &Data| PlotSeries {
        name: data.name().into(),
        line: Vec::new(),
        dots: measurements
            .iter()
            .filter(|one| one.data == data.name())
            .filter_map(|one| {
                let k = Fault::ALL.iter().position(|case| case.name() == one.case)?;
                Some((one.after_mm.max(1e-9), k as f64))
            })
            .collect(),
    };
    let plot = StudyPlot {
        x: PlotAxis { title: "contact residual after calibration, RMS, mm", scale: AxisScale::Logarithmic },
        series: Data::ALL.iter().map(dots).collect(),
        y: PlotAxis {
            title: "",
            scale: AxisScale::Names(Fault::ALL.iter().map(|case| case.name().into()).collect()),
        },
    };
    let numbers = vec![
        ("false_calibrated", json!([missed, faulty])),
        ("false_not_calibrated", json!([refused, harmless])),
        ("named", json!([named, to_be_named])),
    ];
    Findings { summary, notes, plot, numbers, measurements }
}
