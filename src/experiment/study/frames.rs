//! Whether limbs are learned whose own frames are anywhere on their joints.

use serde::{Deserialize, Serialize};

use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median, share};
use super::table::{WallTime, row};
use super::{Findings, Study, Trial, Trials};
use crate::experiment::ExperimentError;
use crate::experiment::LearningOptions;
use crate::experiment::words::listed;
use crate::ground_truth::GroundTruth;
use crate::learning::{Input, LimbFrames};
use crate::senses::OwnFrames;

/// The study `frames`.
pub const STUDY: Study = Study {
    name: "frames",
    about: "whether lm learns limbs whose own frames are anywhere on them",
    touches: true,
    several: false,
    trials: Trials::of::<FramesTrial>(),
};

row! {
    /// A measurement of the study `frames`.
    pub struct FramesMeasurement {
        frames: String = "frames",
        seed: u64 = "seed",
        touches: usize = "touches",
        converged: bool = "converged",
        heldout_mm: f64 = "held-out, mm",
        heldout_max_mm: f64 = "greatest, mm",
        axis_deg: f64 = "axis, °",
        undetermined_joints: usize = "joints named",
        undetermined_limbs: usize = "limbs named",
        initial_guesses: usize = "initial guesses",
        seconds: WallTime = "seconds",
        named: String = "named as undetermined",
    }
}

row! {
    /// A row of the summary of the study `frames`.
    pub struct FramesSummary {
        frames: String = "frames",
        converged: f64 = "converged, share",
        heldout_mm: f64 = "held-out, mm",
        heldout_worst_mm: f64 = "worst, mm",
        axis_deg: f64 = "axis, °",
        undetermined_joints: f64 = "joints named, mean",
        undetermined_limbs: f64 = "limbs named, mean",
        initial_guesses: f64 = "initial guesses",
        seconds: WallTime = "seconds",
    }
}

/// Where limbs' frames are: the name under which that appears, and how is learned.
fn conditions() -> [(&'static str, LearningOptions); 2] {
    let contact = LearningOptions { input: Some(Input::Contact), ..LearningOptions::default() };
    [("joint", contact.clone()), ("limb", LearningOptions { frames: LimbFrames::Limb, ..contact })]
}

/// The measurements of one trial, one for each of the conditions.
#[derive(Debug, Serialize, Deserialize)]
pub struct FramesTrial(Vec<FramesMeasurement>);

impl Trial for FramesTrial {
    type Setting = ();
    type Measurement = FramesMeasurement;
    type Summary = FramesSummary;

    fn set_up(subject: &Subject) -> Result<(), ExperimentError> {
        for (_, options) in conditions() {
            options.check(&subject.body().creature)?;
        }
        Ok(())
    }

    fn run(subject: &Subject, (): &(), seed: u64) -> Result<FramesTrial, ExperimentError> {
        let creature = &subject.body().creature;
        let touches = subject.babble(seed)?;
        let mut measurements = Vec::new();
        for (name, options) in conditions() {
            subject.tell(seed, &format!("frames: {name}"));
            let attempt = match options.frames {
                LimbFrames::Joint => subject.learn(&options, &touches, seed),
                LimbFrames::Limb => {
                    let own = OwnFrames::random(creature, seed);
                    let truth = GroundTruth {
                        schema: own.schema(creature, &subject.truth().schema),
                        ..subject.truth().clone()
                    };
                    let touches = own.touches(subject.agent().skin(), &touches);
                    let agent = subject.agent().with_skin(own.skin(subject.agent().skin()))?;
                    subject.learn_with(&options, &agent, &truth, &touches, seed)
                }
            };
            let learned = &attempt.learned;
            let joints = learned.undetermined().into_iter().map(|j| creature.joints()[j].name.clone());
            let limbs = learned.undetermined_limbs().into_iter().map(|limb| creature.limbs()[limb].clone());
            let (joints, limbs): (Vec<String>, Vec<String>) = (joints.collect(), limbs.collect());
            measurements.push(FramesMeasurement {
                frames: name.into(),
                seed,
                touches: touches.len(),
                converged: attempt.converged(),
                heldout_mm: attempt.evaluation.determined_mm.mean,
                heldout_max_mm: attempt.evaluation.determined_mm.max,
                axis_deg: attempt.evaluation.axis_deg.median,
                undetermined_joints: joints.len(),
                undetermined_limbs: limbs.len(),
                initial_guesses: learned.initial_guesses,
                seconds: attempt.seconds,
                named: format!("joints {}; limbs {}", listed(&joints), listed(&limbs)),
            });
        }
        Ok(FramesTrial(measurements))
    }

    fn findings(_subject: &Subject, trials: &[FramesTrial]) -> Findings<FramesMeasurement, FramesSummary> {
        findings(trials.iter().flat_map(|trial| trial.0.clone()).collect())
    }
}

fn findings(measurements: Vec<FramesMeasurement>) -> Findings<FramesMeasurement, FramesSummary> {
    let names = conditions().map(|(name, _)| name);
    let of = |name: &str| measurements.iter().filter(|row| row.frames == name).collect::<Vec<_>>();
    let mut summary: Vec<FramesSummary> = Vec::new();
    for name in names {
        let rows = of(name);
        // One that failed names everything: it claims nothing that could be measured.
        let converged = || rows.iter().filter(|row| row.converged);
        let mean = |value: fn(&FramesMeasurement) -> usize| {
            converged().map(|row| value(row) as f64).sum::<f64>() / converged().count() as f64
        };
        summary.push(FramesSummary {
            frames: name.into(),
            converged: share(rows.iter().map(|row| row.converged)),
            heldout_mm: median(converged().map(|row| row.heldout_mm)),
            heldout_worst_mm: converged().map(|row| row.heldout_max_mm).fold(f64::NAN, f64::max),
            axis_deg: median(converged().map(|row| row.axis_deg)),
            undetermined_joints: mean(|row| row.undetermined_joints),
            undetermined_limbs: mean(|row| row.undetermined_limbs),
            initial_guesses: median(rows.iter().map(|row| row.initial_guesses as f64)),
            seconds: WallTime(median(rows.iter().map(|row| row.seconds.0))),
        });
    }
    let notes = vec![
        "From exact contact points. joint: points are given in frames at the joints. limb: every limb has a \
         random frame of its own, which the learner finds as well."
            .to_string(),
        "Held-out errors are over what is not named as undetermined, at postures that were not babbled; medians \
         over the trials that converged, and the worst error of any of them."
            .to_string(),
    ];
    let series = names.into_iter().enumerate().map(|(k, name)| PlotSeries {
        name: name.to_string(),
        line: Vec::new(),
        dots: of(name).iter().map(|row| (row.heldout_mm, k as f64)).collect(),
    });
    let plot = StudyPlot {
        x: PlotAxis { title: "mean held-out error, mm", scale: AxisScale::Logarithmic },
        y: PlotAxis { title: "", scale: AxisScale::Names(names.map(String::from).into()) },
        series: series.collect(),
    };
    Findings { summary, notes, plot, numbers: Vec::new(), measurements }
}
