//! What it costs when the senses are wrong.

use serde_json::json;

use super::{Row, Studied, Study, Trial, columns};
use crate::error::Error;
use crate::session::{DisturbanceLevels, LearningOptions};

pub(super) const STUDY: Study = Study {
    name: "disturbances",
    about: "effect of noise and false touches on lm",
    of: Studied::Creature,
    touches: Some(1000),
    seconds: None,
    cases: || LEVELS.map(|levels| levels.to_string()).into(),
    columns: columns! {
        disturbances: Case, joint_noise_deg, receptor_noise_mm, false_touches, seed, converged: Share,
        heldout_mm: Median Most, hand_mm: Median, noise_estimate_mm: Median, initial_guesses,
        work_s: Median,
    },
    notes: &[
        "heldout_mm: mean held-out error on the true skin. noise_estimate_mm: the learner's own estimate of the deviation of a \
         touch's gap, at least 0.001 mm, over the trials that converged.",
        "Joint noise is a standard deviation per angle and touch, receptor noise one per coordinate, drawn once per trial; \
         false touches have a random receptor at one end.",
    ],
    run,
};

const NONE: DisturbanceLevels = DisturbanceLevels::NONE;
const LEVELS: [DisturbanceLevels; 11] = [
    NONE,
    DisturbanceLevels { joint_noise: 0.05, ..NONE },
    DisturbanceLevels { joint_noise: 0.1, ..NONE },
    DisturbanceLevels { joint_noise: 0.2, ..NONE },
    DisturbanceLevels { receptor_noise: 0.5, ..NONE },
    DisturbanceLevels { receptor_noise: 1.0, ..NONE },
    DisturbanceLevels { receptor_noise: 2.0, ..NONE },
    DisturbanceLevels { false_touches: 0.02, ..NONE },
    DisturbanceLevels { false_touches: 0.05, ..NONE },
    DisturbanceLevels { false_touches: 0.1, ..NONE },
    DisturbanceLevels { joint_noise: 0.1, receptor_noise: 1.0, false_touches: 0.05, ..NONE },
];

fn run(trial: &Trial) -> Result<Vec<Row>, Error> {
    let subject = trial.subject()?;
    let touches = subject.babble(trial.touches, trial.seed)?;
    let row = |disturbances: DisturbanceLevels| {
        let options = LearningOptions { disturbances, ..LearningOptions::default() };
        let (_, mut row) = subject.learn(&options, &touches, trial.seed);
        row["disturbances"] = json!(disturbances.to_string());
        row["joint_noise_deg"] = json!(disturbances.joint_noise);
        row["receptor_noise_mm"] = json!(disturbances.receptor_noise);
        row["false_touches"] = json!(disturbances.false_touches);
        row
    };
    Ok(LEVELS.into_iter().filter(|levels| trial.asks(&levels.to_string())).map(row).collect())
}
