//! Whether the verdict on a calibration is right, both ways: made robots with and without a fault, by four kinds of data.

pub mod made;

use serde_json::json;

use super::{Row, Studied, Study, Trial, columns};
use crate::calibration::{Estimator, EstimatorOptions, Misses, objections};
use crate::error::Error;
use made::{Data, Fault, Made};

pub(super) const STUDY: Study = Study {
    name: "calibration",
    about: "correctness of calibration verdicts on simulated robots with and without a fault, from four kinds of data",
    of: Studied::Generated,
    touches: None,
    seconds: None,
    cases: || cases().map(|(data, fault)| name(data, fault)).collect(),
    columns: columns! {
        data: Case, case: Part, seed, touches, calibrated: Sum, falsely_calibrated: Sum,
        falsely_not_calibrated: Sum, to_be_named, named: Share, after_mm: Median, deviations: Most,
        objections,
    },
    notes: &[
        "Calibrated is the right verdict without a fault, with duplicated rows, and with one touch in ten replaced; with \
              any other fault it is wrong. named: whether an objection names the faulty joint, mount or convention. after_mm: the \
              contact residual after calibration, RMS; deviations: how many of its own deviations the worst offset is off.",
    ],
    run,
};

fn cases() -> impl Iterator<Item = (Data, Fault)> {
    Data::ALL.iter().flat_map(|&data| Fault::ALL.iter().map(move |&fault| (data, fault)))
}

fn name(data: Data, fault: Fault) -> String {
    format!("{data}/{fault}")
}

fn run(trial: &Trial) -> Result<Vec<Row>, Error> {
    let asked = cases().filter(|&(data, fault)| trial.asks(&name(data, fault)));
    Ok(asked.map(|(data, fault)| measured(data, fault, trial.seed)).collect())
}

fn measured(data: Data, fault: Fault, seed: u64) -> Row {
    let made = Made::new(data, fault, seed);
    let estimator = Estimator::new(&made.robot, &made.touches, EstimatorOptions::default());
    let fit = estimator.fit();
    let objections = objections(&estimator, &fit, &[]);
    let calibrated = objections.is_empty();
    let off = |quantity: usize| {
        let place = estimator.unknowns.place(quantity, 0).filter(|place| fit.told.is_told(*place))?;
        Some(fit.values[quantity].distance(&made.truth[quantity]) / fit.told.deviation(place))
    };
    let offsets = made.robot.dofs.iter().filter_map(|dof| off(dof.quantities?.offset));
    let names = |fault: &String| {
        objections.iter().any(|one| one.about.as_ref().is_some_and(|about| about.contains(fault)))
    };
    json!({
        "data": data.name(),
        "case": fault.name(),
        "touches": made.touches.len(),
        "calibrated": calibrated,
        "falsely_calibrated": calibrated && !fault.is_harmless(),
        "falsely_not_calibrated": !calibrated && fault.is_harmless(),
        "named": made.faulty.as_ref().map(names),
        "to_be_named": made.faulty,
        "after_mm": 1e3 * Misses::of(fit.inliers()).rms,
        "deviations": offsets.fold(0.0, f64::max),
        "objections": objections.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "),
    })
}
