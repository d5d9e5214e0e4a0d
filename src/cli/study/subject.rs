//! Who is studied: a creature that babbles, learns and is measured, trial by trial.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use indicatif::ProgressBar;

use super::super::learn_options::LearnOptions;
use super::super::open::{ModelOptions, body_of, open_body, own_body};
use super::super::skin::skin_for;
use super::super::touches::{all_touches, babbler};
use super::super::{Failure, progress};
use crate::babbling::{BabblingOptions, MotionName, PolicyName, motions_until};
use crate::creature::{Body, JointSelection};
use crate::evaluation::{Evaluation, evaluate_learned};
use crate::ground_truth::GroundTruth;
use crate::interaction::World;
use crate::learning::{Input, Learned, Verdict};
use crate::mujoco::Model;
use crate::peripersonal::OwnBody;
use crate::senses::Touch;
use crate::skin::Skin;

/// Mean held-out error at which a learner without a verdict of its own counts as converged, millimetres.
pub const CONVERGED_MM: f64 = 10.0;

/// A creature and how it is to be studied.
pub struct Subject {
    /// The body.
    pub body: Body,
    /// Its skin.
    pub skin: Skin,
    /// The truth, for the measures alone.
    pub truth: GroundTruth,
    /// Touches of a trial.
    pub touches: usize,
    /// One seed per trial: of its touches, its disturbances and its onsets.
    pub seeds: Vec<u64>,
    /// The session that a schema is taken from, where not one is learned.
    pub schema: Option<PathBuf>,
    model: PathBuf,
    joints: JointSelection,
    jobs: usize,
    progress: ProgressBar,
}

/// Touches and what they cost.
pub struct Babbled {
    /// The touches.
    pub touches: Vec<Touch>,
    /// Per touch, the motions made up to it.
    pub motions: Vec<u64>,
    /// Per touch, the time that passed up to it, seconds.
    pub seconds: Vec<f64>,
}

/// What one run of a learner came to.
pub struct Attempt {
    /// What it learned.
    pub learned: Learned,
    /// Time that it took, all touches taken in and learned from, seconds.
    pub seconds: f64,
    /// Its errors.
    pub evaluation: Evaluation,
}

impl Subject {
    /// Reads a model and prepares it.
    pub fn new(
        model: &Path,
        joints: &JointSelection,
        touches: usize,
        seeds: Vec<u64>,
        jobs: usize,
    ) -> Result<Subject, Failure> {
        let body = open_body(model, joints, &ModelOptions::default())?;
        let (skin, truth) = (skin_for(model, &body)?, GroundTruth::new(&body)?);
        // Whether the creature can babble at all is told before any folder is made.
        babbler(model, &body, &skin, MotionName::default())?;
        let model = model.to_path_buf();
        let joints = joints.clone();
        let trials = seeds.len() as u64;
        Ok(Subject {
            body,
            skin,
            truth,
            touches,
            seeds,
            schema: None,
            model,
            joints,
            jobs,
            progress: progress::steps(trials),
        })
    }

    /// The model's file.
    pub fn model(&self) -> &Path {
        &self.model
    }

    /// The creature with all its joints, holding still, and a probe to touch it with.
    pub fn world(&self) -> Result<World, Failure> {
        let world = World::new(&self.model, &self.body, &["probe".to_string()]);
        world.map_err(|error| Failure(format!("{}: {error}", self.model.display())))
    }

    /// The joints that move.
    pub fn joints(&self) -> &JointSelection {
        &self.joints
    }

    /// The exact touches of a trial, all in memory.
    pub fn babble(&self, seed: u64) -> Result<Vec<Touch>, Failure> {
        self.tell(seed, "babbling");
        self.babble_body(&self.body, &self.skin, self.touches, seed)
    }

    /// The exact touches of a body, this one or one made from it.
    pub fn babble_body(
        &self,
        body: &Body,
        skin: &Skin,
        touches: usize,
        seed: u64,
    ) -> Result<Vec<Touch>, Failure> {
        let options = BabblingOptions { touches, seed, jobs: self.jobs };
        let mut made = Vec::with_capacity(touches);
        let babbler = babbler(&self.model, body, skin, MotionName::default())?;
        all_touches(&self.model, &babbler, PolicyName::Random, &options, |touch| made.push(touch.clone()))?;
        Ok(made)
    }

    /// The exact touches of a trial whose motions a policy chooses, and what each cost.
    pub fn babble_by(&self, policy: PolicyName, seed: u64) -> Result<Babbled, Failure> {
        self.tell(seed, &format!("babbling, {policy}"));
        let options = BabblingOptions { touches: self.touches, seed, jobs: self.jobs };
        let (mut touches, mut seconds) = (Vec::new(), Vec::new());
        let babbler = babbler(&self.model, &self.body, &self.skin, MotionName::default())?;
        let began = Instant::now();
        all_touches(&self.model, &babbler, policy, &options, |touch| {
            touches.push(touch.clone());
            seconds.push(began.elapsed().as_secs_f64());
        })?;
        let motions = motions_until(&touches);
        Ok(Babbled { touches, motions, seconds })
    }

    /// Learns from touches, disturbed as the options say, and measures against the truth.
    pub fn learn(&self, options: &LearnOptions, touches: &[Touch], seed: u64) -> Attempt {
        self.learn_with(options, &self.skin, &self.truth, touches, seed)
    }

    /// The same with limbs described otherwise than the model does: touches, their skin and the truth.
    pub fn learn_with(
        &self,
        options: &LearnOptions,
        skin: &Skin,
        truth: &GroundTruth,
        touches: &[Touch],
        seed: u64,
    ) -> Attempt {
        let creature = &self.body.creature;
        let felt = options.disturbances.disturbances().felt(creature, skin, touches, seed);
        let began = Instant::now();
        let mut learner = options.learner(creature, &felt.skin, seed);
        felt.touches.iter().for_each(|touch| learner.touch(touch));
        let learned = learner.learn();
        let seconds = began.elapsed().as_secs_f64();
        let evaluation = evaluate_learned(creature, skin, truth, &learned);
        Attempt { learned, seconds, evaluation }
    }

    /// What the creature knows of itself: by the session that was named, or after babbling by a seed.
    pub fn own_body(&self, seed: u64) -> Result<OwnBody, Failure> {
        if let Some(folder) = &self.schema {
            let (session, own) = own_body(folder)?;
            if session.creature != self.body.creature {
                return Err(Failure(format!(
                    "{}: it is of another creature, or of other joints, than {} with --joints {}: give the model and \
                     joints that it was babbled with",
                    folder.display(),
                    self.model.display(),
                    self.joints
                )));
            }
            return Ok(own);
        }
        let creature = &self.body.creature;
        let touches = self.babble(seed)?;
        self.tell(seed, "learning");
        let learned = self.learn(&LearnOptions::default(), &touches, seed).learned;
        Ok(OwnBody::new(creature, &self.skin, learned.schema, &touches, Input::Receptor))
    }

    /// The creature in a model made from its own.
    pub fn remade(&self, model: Arc<Model>) -> Result<Body, Failure> {
        body_of(model, &self.model, &self.joints, &ModelOptions::default())
    }

    /// Says on standard error what a trial is at.
    pub fn tell(&self, seed: u64, what: &str) {
        let trial = self.seeds.iter().position(|&other| other == seed).map_or(0, |k| k + 1);
        self.progress.set_position(trial.saturating_sub(1) as u64);
        self.progress.set_message(format!("trial {trial} of {}: {what}", self.seeds.len()));
    }

    /// Ends the progress on standard error.
    pub fn done(&self) {
        self.progress.finish_and_clear();
    }
}

impl Attempt {
    /// Mean error of the skin in another limb's frame, millimetres.
    pub fn heldout_mm(&self) -> f64 {
        self.evaluation.heldout_mm.mean
    }

    /// The same over what is not named as undetermined.
    pub fn determined_mm(&self) -> f64 {
        self.evaluation.determined_mm.mean
    }

    /// The same with a hand as one of the two; NaN where the creature has none.
    pub fn hand_mm(&self) -> f64 {
        self.evaluation.hand_mm.map_or(f64::NAN, |hand| hand.mean)
    }

    /// The learner's own verdict; for one that has none, whether the error is [`CONVERGED_MM`] or less.
    pub fn converged(&self) -> bool {
        match self.learned.verdict {
            Verdict::Converged => true,
            Verdict::Failed(_) => false,
            Verdict::Unjudged(_) => self.heldout_mm() <= CONVERGED_MM,
        }
    }
}

/// The middle value, infinities included; the mean of the middle two; NaN of nothing or where any is NaN.
pub fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.into_iter().collect();
    if sorted.is_empty() || sorted.iter().any(|x| x.is_nan()) {
        return f64::NAN;
    }
    sorted.sort_by(f64::total_cmp);
    let (below, above) = (sorted[(sorted.len() - 1) / 2], sorted[sorted.len() / 2]);
    if below == above { below } else { 0.5 * (below + above) }
}

/// The share for which something holds; NaN of nothing.
pub fn share(holds: impl IntoIterator<Item = bool>) -> f64 {
    let (mut all, mut held) = (0.0, 0.0);
    for one in holds {
        all += 1.0;
        held += f64::from(u8::from(one));
    }
    held / all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_counts_what_was_never_reached_as_infinite() {
        assert_eq!(median([3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median([4.0, 1.0]), 2.5);
        assert_eq!(median([1.0, f64::INFINITY, 2.0]), 2.0);
        assert_eq!(median([f64::INFINITY, 1.0]), f64::INFINITY);
        assert_eq!(median([f64::INFINITY; 2]), f64::INFINITY);
        assert!(median([]).is_nan() && median([f64::NAN, 1.0]).is_nan());
    }

    #[test]
    fn a_share_is_of_all() {
        assert_eq!(share([true, false, true, true]), 0.75);
        assert!(share([]).is_nan());
    }
}
