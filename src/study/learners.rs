//! The error of each learner by number of touches.

use serde_json::json;

use super::{Row, Studied, Study, Trial, columns};
use crate::error::Error;
use crate::learning::SkinKnowledge;
use crate::learning::learners::HerschsRule;
use crate::session::LearningOptions;

pub(super) const STUDY: Study = Study {
    name: "learners",
    about: "error of each learner by number of touches",
    of: Studied::Creature,
    touches: Some(1000),
    seconds: None,
    cases: || learners().map(|(name, _)| name.to_string()).into(),
    columns: columns! {
        learner: Case, touches: Case, seed, heldout_mm: Median Least Most, hand_mm, converged: Share,
        initial_guesses: Median, work_s: Median,
    },
    notes: &[
        "heldout_mm: mean held-out error. converged: the learner's own verdict; for hersch, which has none, \
         a held-out error of at most 10 mm. work_s: work of learning, in seconds of one core.",
    ],
    run,
};

fn learners() -> [(&'static str, LearningOptions); 3] {
    let lm = LearningOptions::default();
    [
        ("hersch", LearningOptions { learner: Some(&HerschsRule), ..lm.clone() }),
        ("lm --skin centres", LearningOptions { skin: SkinKnowledge::Centres, ..lm.clone() }),
        ("lm", lm),
    ]
}

fn run(trial: &Trial) -> Result<Vec<Row>, Error> {
    let subject = trial.subject()?;
    let touches = subject.babble(trial.touches, trial.seed)?;
    let mut rows = Vec::new();
    for (name, options) in learners().into_iter().filter(|(name, _)| trial.asks(name)) {
        for count in touch_counts(touches.len()) {
            let (_, mut row) = subject.learn(&options, &touches[..count], trial.seed);
            (row["learner"], row["touches"]) = (json!(name), json!(count));
            rows.push(row);
        }
    }
    Ok(rows)
}

/// The counts at which learners are measured, up to `most` and with it: 100, 150, 200, 300, 500, 700, 1000, and so on by the
/// same factors.
fn touch_counts(most: usize) -> Vec<usize> {
    let decades = std::iter::successors(Some(1usize), |decade| decade.checked_mul(10));
    let counts = decades.flat_map(|decade| [100, 150, 200, 300, 500, 700].map(|n| decade.saturating_mul(n)));
    counts.take_while(|&count| count < most).chain([most]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_go_on_by_the_same_factors_and_end_with_the_last() {
        assert_eq!(touch_counts(60), [60]);
        assert_eq!(touch_counts(100), [100]);
        assert_eq!(touch_counts(1000), [100, 150, 200, 300, 500, 700, 1000]);
        assert_eq!(touch_counts(2500)[6..], [1000, 1500, 2000, 2500]);
    }
}
