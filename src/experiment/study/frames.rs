//! Whether limbs are learned whose own frames are anywhere on their joints.

use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{LearnerRun, Subject, median, share};
use super::table::row;
use super::{Findings, Study};
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
    measure: |subject| Ok(measure(subject)?.into()),
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
        seconds: f64 = "seconds",
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
        seconds: f64 = "seconds",
    }
}

/// Measures; a trial that does not succeed is a finding.
///
/// # Errors
/// Where something cannot be measured at all.
pub fn measure(subject: &Subject) -> Result<Findings<FramesMeasurement, FramesSummary>, ExperimentError> {
    let contact = LearningOptions { input: Some(Input::Contact), ..LearningOptions::default() };
    let conditions =
        [("joint", contact.clone()), ("limb", LearningOptions { frames: LimbFrames::Limb, ..contact })];
    conditions[1].1.check(&subject.body().creature)?;
    let creature = &subject.body().creature;
    let mut measurements: Vec<FramesMeasurement> = Vec::new();
    let mut found: [Vec<LearnerRun>; 2] = [Vec::new(), Vec::new()];
    for &seed in &subject.seeds {
        let touches = subject.babble(seed)?;
        for ((name, options), found) in conditions.iter().zip(&mut found) {
            subject.tell(seed, &format!("frames: {name}"));
            let attempt = match options.frames {
                LimbFrames::Joint => subject.learn(options, &touches, seed),
                LimbFrames::Limb => {
                    let own = OwnFrames::random(creature, seed);
                    let truth = GroundTruth { schema: own.schema(creature, &subject.truth().schema) };
                    let touches = own.touches(subject.agent().skin(), &touches);
                    let agent = subject.agent().with_skin(own.skin(subject.agent().skin()))?;
                    subject.learn_with(options, &agent, &truth, &touches, seed)
                }
            };
            let learned = &attempt.learned;
            let joints = learned.undetermined().into_iter().map(|j| creature.joints()[j].name.clone());
            let limbs = learned.undetermined_limbs().into_iter().map(|limb| creature.limbs()[limb].clone());
            let (joints, limbs): (Vec<String>, Vec<String>) = (joints.collect(), limbs.collect());
            measurements.push(FramesMeasurement {
                frames: (*name).into(),
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
            found.push(attempt);
        }
    }
    let mut summary: Vec<FramesSummary> = Vec::new();
    for ((name, _), attempts) in conditions.iter().zip(&found) {
        // One that failed names everything: it claims nothing that could be measured.
        let converged = || attempts.iter().filter(|attempt| attempt.converged());
        let mean = |value: fn(&LearnerRun) -> usize| {
            converged().map(|attempt| value(attempt) as f64).sum::<f64>() / converged().count() as f64
        };
        let worst = converged().map(|attempt| attempt.evaluation.determined_mm.max);
        summary.push(FramesSummary {
            frames: (*name).into(),
            converged: share(attempts.iter().map(LearnerRun::converged)),
            heldout_mm: median(converged().map(|attempt| attempt.evaluation.determined_mm.mean)),
            heldout_worst_mm: worst.fold(f64::NAN, f64::max),
            axis_deg: median(converged().map(|attempt| attempt.evaluation.axis_deg.median)),
            undetermined_joints: mean(|attempt| attempt.learned.undetermined().len()),
            undetermined_limbs: mean(|attempt| attempt.learned.undetermined_limbs().len()),
            initial_guesses: median(attempts.iter().map(|attempt| attempt.learned.initial_guesses as f64)),
            seconds: median(attempts.iter().map(|attempt| attempt.seconds)),
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
    let series = conditions.iter().zip(&found).enumerate().map(|(k, ((name, _), attempts))| PlotSeries {
        name: (*name).to_string(),
        line: Vec::new(),
        dots: attempts.iter().map(|attempt| (attempt.evaluation.determined_mm.mean, k as f64)).collect(),
    });
    let plot = StudyPlot {
        x: PlotAxis { title: "mean held-out error, mm", scale: AxisScale::Logarithmic },
        y: PlotAxis {
            title: "",
            scale: AxisScale::Names(conditions.iter().map(|(name, _)| (*name).into()).collect()),
        },
        series: series.collect(),
    };
    Ok(Findings { measurements, summary, notes, plot, numbers: Vec::new() })
}
