//! Whether a body is learned whose axes are like nobody's.

use std::sync::Arc;

use nalgebra::{Unit, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::plot::{Axis, Plot, Scale, Series};
use super::subject::{Attempt, Subject, median, share};
use super::table::{Column, Table};
use super::{Failure, Findings, Study};
use crate::cli::learn_options::{InputName, LearnOptions};
use crate::ground_truth::GroundTruth;
use crate::kinematics::tangent_basis;
use crate::mujoco::{self, Model};

/// The study `turned`.
pub const STUDY: Study = Study {
    name: "turned",
    about: "how well lm learns the body with every axis turned at random, by 25° to 90°",
    touches: true,
    measure,
};

/// How far axes are turned, radians.
const LEAST: f64 = 25.0 * std::f64::consts::PI / 180.0;
const MOST: f64 = std::f64::consts::FRAC_PI_2;

const MEASUREMENTS: &[Column] = &[
    Column { name: "input", heading: "input" },
    Column { name: "seed", heading: "seed" },
    Column { name: "touches", heading: "touches" },
    Column { name: "converged", heading: "converged" },
    Column { name: "heldout_mm", heading: "held-out, mm" },
    Column { name: "undetermined", heading: "joints named" },
    Column { name: "onsets", heading: "onsets" },
    Column { name: "seconds", heading: "seconds" },
];

const SUMMARY: &[Column] = &[
    Column { name: "input", heading: "input" },
    Column { name: "touches", heading: "touches" },
    Column { name: "converged", heading: "converged, share" },
    Column { name: "wrong", heading: "of these wrong" },
    Column { name: "heldout_mm", heading: "held-out, mm" },
    Column { name: "heldout_worst_mm", heading: "worst, mm" },
    Column { name: "undetermined", heading: "joints named, mean" },
    Column { name: "onsets", heading: "onsets" },
    Column { name: "seconds", heading: "seconds" },
];

/// Mean error beyond which what is said to have converged is wrong, millimetres.
const WRONG_MM: f64 = 0.5;

fn measure(subject: &Subject) -> Result<Findings, Failure> {
    let half = subject.touches.div_ceil(2);
    let conditions = [
        ("contact", half, LearnOptions { input: Some(InputName::Contact), ..LearnOptions::default() }),
        ("receptor", subject.touches, LearnOptions::default()),
    ];
    let mut measurements = Table::new(MEASUREMENTS);
    let mut found: [Vec<Attempt>; 2] = [Vec::new(), Vec::new()];
    for &seed in &subject.seeds {
        let model = with_turned_axes(&subject.body.declared, seed)?;
        let body = subject.remade(Arc::new(model))?;
        subject.tell(seed, "babbling");
        let touches = subject.babble_body(&body, &subject.skin, subject.touches, seed)?;
        let truth = GroundTruth::new(&body)?;
        for ((name, most, options), found) in conditions.iter().zip(&mut found) {
            subject.tell(seed, &format!("learning, {name}"));
            let touches = &touches[..touches.len().min(*most)];
            let attempt = subject.learn_with(options, &subject.skin, &truth, touches, seed);
            measurements.row([
                (*name).into(),
                seed.into(),
                touches.len().into(),
                attempt.converged().into(),
                attempt.determined_mm().into(),
                attempt.learned.undetermined.len().into(),
                attempt.learned.onsets.into(),
                attempt.seconds.into(),
            ]);
            found.push(attempt);
        }
    }
    let mut summary = Table::new(SUMMARY);
    for ((name, most, _), attempts) in conditions.iter().zip(&found) {
        let converged = || attempts.iter().filter(|attempt| attempt.converged());
        let named = converged().map(|attempt| attempt.learned.undetermined.len() as f64).sum::<f64>();
        summary.row([
            (*name).into(),
            (*most).into(),
            share(attempts.iter().map(Attempt::converged)).into(),
            converged().filter(|attempt| attempt.determined_mm() > WRONG_MM).count().into(),
            median(converged().map(Attempt::determined_mm)).into(),
            converged().map(Attempt::determined_mm).fold(f64::NAN, f64::max).into(),
            (named / converged().count() as f64).into(),
            median(attempts.iter().map(|attempt| attempt.learned.onsets as f64)).into(),
            median(attempts.iter().map(|attempt| attempt.seconds)).into(),
        ]);
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
    let series = conditions.iter().zip(&found).enumerate().map(|(k, ((name, ..), attempts))| Series {
        name: (*name).to_string(),
        line: Vec::new(),
        dots: attempts.iter().map(|attempt| (attempt.determined_mm(), k as f64)).collect(),
    });
    let names = conditions.iter().map(|(name, ..)| (*name).into()).collect();
    let plot = Plot {
        x: Axis { title: "mean held-out error, mm", scale: Scale::Logarithmic },
        y: Axis { title: "", scale: Scale::Names(names) },
        series: series.collect(),
    };
    Ok(Findings { measurements, summary, notes, plot, numbers: Vec::new() })
}

/// The model with every axis turned.
fn with_turned_axes(model: &Model, seed: u64) -> mujoco::Result<Model> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut turned = |axis: Vector3<f64>| {
        let across = tangent_basis(&axis);
        let direction = std::f64::consts::TAU * rng.random::<f64>();
        let about = across.column(0) * direction.cos() + across.column(1) * direction.sin();
        let angle = LEAST + (MOST - LEAST) * rng.random::<f64>();
        UnitQuaternion::from_axis_angle(&Unit::new_normalize(about), angle) * axis
    };
    let axes: Vec<Vector3<f64>> = model.joints().map(|joint| turned(joint.axis)).collect();
    model.with_joint_axes(&axes)
}
