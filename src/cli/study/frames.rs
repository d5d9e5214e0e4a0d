//! Whether limbs are learned whose own frames are anywhere on their joints.

use super::plot::{Axis, Plot, Scale, Series};
use super::subject::{Attempt, Subject, median, share};
use super::table::{Column, Table};
use super::{Failure, Findings, Study};
use crate::cli::learn_options::{FramesName, InputName, LearnOptions};
use crate::cli::output;
use crate::ground_truth::GroundTruth;
use crate::senses::OwnFrames;

/// The study `frames`.
pub const STUDY: Study = Study {
    name: "frames",
    about: "whether lm learns limbs whose own frames are anywhere on them",
    touches: true,
    measure,
};

const MEASUREMENTS: &[Column] = &[
    Column { name: "frames", heading: "frames" },
    Column { name: "seed", heading: "seed" },
    Column { name: "touches", heading: "touches" },
    Column { name: "converged", heading: "converged" },
    Column { name: "heldout_mm", heading: "held-out, mm" },
    Column { name: "heldout_max_mm", heading: "greatest, mm" },
    Column { name: "axis_deg", heading: "axis, °" },
    Column { name: "undetermined_joints", heading: "joints named" },
    Column { name: "undetermined_limbs", heading: "limbs named" },
    Column { name: "onsets", heading: "onsets" },
    Column { name: "seconds", heading: "seconds" },
    Column { name: "named", heading: "named as undetermined" },
];

const SUMMARY: &[Column] = &[
    Column { name: "frames", heading: "frames" },
    Column { name: "converged", heading: "converged, share" },
    Column { name: "heldout_mm", heading: "held-out, mm" },
    Column { name: "heldout_worst_mm", heading: "worst, mm" },
    Column { name: "axis_deg", heading: "axis, °" },
    Column { name: "undetermined_joints", heading: "joints named, mean" },
    Column { name: "undetermined_limbs", heading: "limbs named, mean" },
    Column { name: "onsets", heading: "onsets" },
    Column { name: "seconds", heading: "seconds" },
];

fn measure(subject: &Subject) -> Result<Findings, Failure> {
    let contact = LearnOptions { input: Some(InputName::Contact), ..LearnOptions::default() };
    let conditions = [
        ("joint", contact.clone()),
        ("limb", LearnOptions { frames: FramesName::Limb, ..contact }.checked(&subject.body.creature)?),
    ];
    let creature = &subject.body.creature;
    let mut measurements = Table::new(MEASUREMENTS);
    let mut found: [Vec<Attempt>; 2] = [Vec::new(), Vec::new()];
    for &seed in &subject.seeds {
        let touches = subject.babble(seed)?;
        for ((name, options), found) in conditions.iter().zip(&mut found) {
            subject.tell(seed, &format!("frames: {name}"));
            let attempt = match options.frames {
                FramesName::Joint => subject.learn(options, &touches, seed),
                FramesName::Limb => {
                    let own = OwnFrames::random(creature, seed);
                    let truth = GroundTruth { schema: own.schema(creature, &subject.truth.schema) };
                    let touches = own.touches(&subject.skin, &touches);
                    subject.learn_with(options, &own.skin(&subject.skin), &truth, &touches, seed)
                }
            };
            let learned = &attempt.learned;
            let joints = learned.undetermined.iter().map(|&j| creature.joints()[j].name.clone());
            let limbs = learned.undetermined_limbs.iter().map(|&limb| creature.limbs()[limb].clone());
            let (joints, limbs): (Vec<String>, Vec<String>) = (joints.collect(), limbs.collect());
            measurements.row([
                (*name).into(),
                seed.into(),
                touches.len().into(),
                attempt.converged().into(),
                attempt.evaluation.determined_mm.mean.into(),
                attempt.evaluation.determined_mm.max.into(),
                attempt.evaluation.axis_deg.median.into(),
                joints.len().into(),
                limbs.len().into(),
                learned.onsets.into(),
                attempt.seconds.into(),
                format!("joints {}; limbs {}", output::names(&joints), output::names(&limbs)).into(),
            ]);
            found.push(attempt);
        }
    }
    let mut summary = Table::new(SUMMARY);
    for ((name, _), attempts) in conditions.iter().zip(&found) {
        // One that failed names everything: it claims nothing that could be measured.
        let converged = || attempts.iter().filter(|attempt| attempt.converged());
        let mean = |value: fn(&Attempt) -> usize| {
            converged().map(|attempt| value(attempt) as f64).sum::<f64>() / converged().count() as f64
        };
        let worst = converged().map(|attempt| attempt.evaluation.determined_mm.max);
        summary.row([
            (*name).into(),
            share(attempts.iter().map(Attempt::converged)).into(),
            median(converged().map(|attempt| attempt.evaluation.determined_mm.mean)).into(),
            worst.fold(f64::NAN, f64::max).into(),
            median(converged().map(|attempt| attempt.evaluation.axis_deg.median)).into(),
            mean(|attempt| attempt.learned.undetermined.len()).into(),
            mean(|attempt| attempt.learned.undetermined_limbs.len()).into(),
            median(attempts.iter().map(|attempt| attempt.learned.onsets as f64)).into(),
            median(attempts.iter().map(|attempt| attempt.seconds)).into(),
        ]);
    }
    let notes = vec![
        "From exact contact points. joint: points are given in frames at the joints. limb: every limb has a \
         random frame of its own, which the learner finds as well."
            .to_string(),
        "Held-out errors are over what is not named as undetermined, at postures that were not babbled; medians \
         over the trials that converged, and the worst error of any of them."
            .to_string(),
    ];
    let series = conditions.iter().zip(&found).enumerate().map(|(k, ((name, _), attempts))| Series {
        name: (*name).to_string(),
        line: Vec::new(),
        dots: attempts.iter().map(|attempt| (attempt.evaluation.determined_mm.mean, k as f64)).collect(),
    });
    let plot = Plot {
        x: Axis { title: "mean held-out error, mm", scale: Scale::Logarithmic },
        y: Axis {
            title: "",
            scale: Scale::Names(conditions.iter().map(|(name, _)| (*name).into()).collect()),
        },
        series: series.collect(),
    };
    Ok(Findings { measurements, summary, notes, plot, numbers: Vec::new() })
}
