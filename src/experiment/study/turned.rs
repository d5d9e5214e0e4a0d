//! Whether a body is learned whose axes are like nobody's.

use std::sync::Arc;

use nalgebra::{Unit, UnitQuaternion, Vector3};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median, share};
use super::table::{WallTime, row};
use super::{Findings, Study, Trial, Trials};
use crate::experiment::ExperimentError;
use crate::experiment::LearningOptions;
use crate::ground_truth::GroundTruth;
use crate::kinematics::tangent_basis;
use crate::learning::Input;
use crate::mujoco::{self, Model};

/// The study `turned`.
pub const STUDY: Study = Study {
    name: "turned",
    about: "how well lm learns the body with every axis turned at random, by 25° to 90°",
    touches: true,
    several: false,
    trials: Trials::of::<TurnedTrial>(),
};

/// How far axes are turned, radians.
const LEAST: f64 = 25.0 * std::f64::consts::PI / 180.0;
const MOST: f64 = std::f64::consts::FRAC_PI_2;

row! {
    /// A measurement of the study `turned`.
    pub struct TurnedMeasurement {
        input: String = "input",
        seed: u64 = "seed",
        touches: usize = "touches",
        converged: bool = "converged",
        heldout_mm: f64 = "held-out, mm",
        undetermined: usize = "joints named",
        initial_guesses: usize = "initial guesses",
        seconds: WallTime = "seconds",
    }
}

row! {
    /// A row of the summary of the study `turned`.
    pub struct TurnedSummary {
        input: String = "input",
        touches: usize = "touches",
        converged: f64 = "converged, share",
        wrong: usize = "of these wrong",
        heldout_mm: f64 = "held-out, mm",
        heldout_worst_mm: f64 = "worst, mm",
        undetermined: f64 = "joints named, mean",
        initial_guesses: f64 = "initial guesses",
        seconds: WallTime = "seconds",
    }
}

/// Mean error beyond which what is said to have converged is wrong, millimetres.
const WRONG_MM: f64 = 0.5;

/// What is learned from: its name, the most touches and how.
fn conditions(touches: usize) -> [(&'static str, usize, LearningOptions); 2] {
    let contact = LearningOptions { input: Some(Input::Contact), ..LearningOptions::default() };
    [("contact", touches.div_ceil(2), contact), ("receptor", touches, LearningOptions::default())]
}

/// The measurements of one trial, one for each of the conditions.
#[derive(Debug, Serialize, Deserialize)]
pub struct TurnedTrial(Vec<TurnedMeasurement>);

impl Trial for TurnedTrial {
    type Setting = ();
    type Measurement = TurnedMeasurement;
    type Summary = TurnedSummary;

    fn set_up(_subject: &Subject) -> Result<(), ExperimentError> {
        Ok(())
    }

    fn run(subject: &Subject, (): &(), seed: u64) -> Result<TurnedTrial, ExperimentError> {
        let model = with_turned_axes(&subject.body().declared, seed)?;
        let body = subject.remade(Arc::new(model))?;
        subject.tell(seed, "babbling");
        let touches = subject.babble_body(&body, subject.agent(), subject.touches, seed)?;
        let truth = GroundTruth::new(&body)?;
        let measured = conditions(subject.touches).into_iter().map(|(name, most, options)| {
            subject.tell(seed, &format!("learning, {name}"));
            let touches = &touches[..touches.len().min(most)];
            let attempt = subject.learn_with(&options, subject.agent(), &truth, touches, seed);
            TurnedMeasurement {
                input: name.into(),
                seed,
                touches: touches.len(),
                converged: attempt.converged(),
                heldout_mm: attempt.determined_mm(),
                undetermined: attempt.learned.undetermined().len(),
                initial_guesses: attempt.learned.initial_guesses,
                seconds: attempt.seconds,
            }
        });
        Ok(TurnedTrial(measured.collect()))
    }

    fn findings(subject: &Subject, trials: &[TurnedTrial]) -> Findings<TurnedMeasurement, TurnedSummary> {
        findings(subject.touches, trials)
    }
}

fn findings(touches: usize, trials: &[TurnedTrial]) -> Findings<TurnedMeasurement, TurnedSummary> {
    let measurements: Vec<TurnedMeasurement> = trials.iter().flat_map(|trial| trial.0.clone()).collect();
    let conditions = conditions(touches);
    let of = |name: &str| measurements.iter().filter(|row| row.input == name).collect::<Vec<_>>();
    let mut summary: Vec<TurnedSummary> = Vec::new();
    for (name, most, _) in &conditions {
        let rows = of(name);
        let converged = || rows.iter().filter(|row| row.converged);
        let named = converged().map(|row| row.undetermined as f64).sum::<f64>();
        summary.push(TurnedSummary {
            input: (*name).into(),
            touches: *most,
            converged: share(rows.iter().map(|row| row.converged)),
            wrong: converged().filter(|row| row.heldout_mm > WRONG_MM).count(),
            heldout_mm: median(converged().map(|row| row.heldout_mm)),
            heldout_worst_mm: converged().map(|row| row.heldout_mm).fold(f64::NAN, f64::max),
            undetermined: named / converged().count() as f64,
            initial_guesses: median(rows.iter().map(|row| row.initial_guesses as f64)),
            seconds: WallTime(median(rows.iter().map(|row| row.seconds.0))),
        });
    }
    let notes = vec![
        "Every axis of the body is turned by an angle drawn between 25° and 90°, about a direction drawn across it; \
         shapes and ranges stay. Each trial is another body."
            .to_string(),
        format!(
            "Held-out errors are means over what is not named as undetermined, in trials that converged; beyond \
             {WRONG_MM} mm such a trial is wrong. Contact points are those of the first half of the touches."
        ),
    ];
    let series = conditions.iter().enumerate().map(|(k, (name, ..))| PlotSeries {
        name: (*name).to_string(),
        line: Vec::new(),
        dots: of(name).iter().map(|row| (row.heldout_mm, k as f64)).collect(),
    });
    let names = conditions.iter().map(|(name, ..)| (*name).into()).collect();
    let plot = StudyPlot {
        x: PlotAxis { title: "mean held-out error, mm", scale: AxisScale::Logarithmic },
        y: PlotAxis { title: "", scale: AxisScale::Names(names) },
        series: series.collect(),
    };
    Findings { summary, notes, plot, numbers: Vec::new(), measurements }
}

/// The model with every axis turned.
fn with_turned_axes(model: &Model, seed: u64) -> mujoco::Result<Model> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut turned = |axis: Vector3<f64>| {
        let about = direction_across(&axis, &mut rng);
        let angle = LEAST + (MOST - LEAST) * rng.random::<f64>();
        UnitQuaternion::from_axis_angle(&about, angle) * axis
    };
    let axes: Vec<Vector3<f64>> = model.joints().map(|joint| turned(joint.axis)).collect();
    model.with_joint_axes(&axes)
}

/// A direction drawn uniformly from those across an axis.
pub(super) fn direction_across(axis: &Vector3<f64>, rng: &mut impl Rng) -> Unit<Vector3<f64>> {
    let across = tangent_basis(axis);
    let direction = std::f64::consts::TAU * rng.random::<f64>();
    Unit::new_normalize(across.column(0) * direction.cos() + across.column(1) * direction.sin())
}
