//! Who is studied: a creature that babbles, learns and is measured, trial by trial.

use std::path::{Path, PathBuf};
use std::time::Instant;

use super::hersch::HerschOptions;
use super::table::WallTime;
use crate::agent::Agent;
use crate::babbling::{BabblingOptions, PolicyName, motions_until};
use crate::creature::{Body, JointSelection};
use crate::evaluation::{Evaluation, evaluate_learned};
use crate::experiment::touches::all_touches;
use crate::experiment::{Embodied, ExperimentError, LearningOptions, Observer, Phase, own_body};
use crate::ground_truth::GroundTruth;
use crate::learning::{Learned, Verdict};
use crate::peripersonal::OwnBody;
use crate::senses::Touch;
use crate::session::babbler;
use crate::simulation::MotionName;
use crate::simulation::{Stage, StageOptions};

/// Mean held-out error at which a learner without a verdict of its own counts as converged, millimetres.
pub const CONVERGED_MM: f64 = 10.0;

/// A creature and how it is to be studied.
pub struct Subject<'a> {
    embodied: Embodied,
    /// Other creatures, of studies that are of several.
    others: Vec<Embodied>,
    /// Touches of a trial.
    pub touches: usize,
    /// One seed per trial: of its touches, its disturbances and its initial guesses.
    pub seeds: Vec<u64>,
    /// The session that a schema is taken from, where not one is learned.
    pub session: Option<PathBuf>,
    /// The policy that the study `claims` is about; all that it knows where it is none.
    pub policy: Option<PolicyName>,
    /// How the study `hersch` applies the rule.
    pub hersch: HerschOptions,
    jobs: usize,
    observer: &'a dyn Observer,
}

/// Touches and what they cost.
pub struct BabbledTrial {
    /// The touches.
    pub touches: Vec<Touch>,
    /// Per touch, the motions made up to it.
    pub motions: Vec<u64>,
    /// Per touch, the time that passed up to it, seconds.
    pub seconds: Vec<f64>,
}

/// What one run of a learner came to.
pub struct LearnerRun {
    /// What it learned.
    pub learned: Learned,
    /// Time that it took, all touches taken in and learned from.
    pub seconds: WallTime,
    /// Its errors.
    pub evaluation: Evaluation,
}

impl<'a> Subject<'a> {
    /// A creature to be studied in trials of so many touches, a seed per trial, babbling on so many threads.
    ///
    /// # Errors
    /// Where it cannot babble.
    pub fn new(
        embodied: Embodied,
        touches: usize,
        seeds: Vec<u64>,
        jobs: usize,
        observer: &'a dyn Observer,
    ) -> Result<Subject<'a>, ExperimentError> {
        embodied.babbler(MotionName::default())?;
        Ok(Subject {
            embodied,
            others: Vec::new(),
            touches,
            seeds,
            session: None,
            policy: None,
            hersch: HerschOptions::default(),
            jobs,
            observer,
        })
    }

    /// The same with other creatures to be studied as well.
    pub fn with_others(self, others: Vec<Embodied>) -> Subject<'a> {
        Subject { others, ..self }
    }

    /// All creatures that are studied.
    pub fn creatures(&self) -> impl Iterator<Item = &Embodied> {
        std::iter::once(&self.embodied).chain(&self.others)
    }

    /// The creature in its model.
    pub fn body(&self) -> &Body {
        self.embodied.body()
    }

    /// What it is given of itself.
    pub fn agent(&self) -> &Agent {
        self.embodied.agent()
    }

    /// The truth, for the measures alone.
    pub fn truth(&self) -> &GroundTruth {
        self.embodied.truth()
    }

    /// The model's file.
    pub fn model(&self) -> &Path {
        self.embodied.model()
    }

    /// The joints that move.
    pub fn joints(&self) -> &JointSelection {
        &self.embodied.source().joints
    }

    /// The creature with all its joints, holding still, and a probe to touch it with.
    ///
    /// # Errors
    /// Where it cannot be simulated.
    pub fn stage(&self) -> Result<Stage, ExperimentError> {
        self.stage_with(&["probe"])
    }

    /// The same with probes of these names.
    ///
    /// # Errors
    /// Where it cannot be simulated.
    pub fn stage_with(&self, probes: &[&str]) -> Result<Stage, ExperimentError> {
        let options = StageOptions {
            joints: JointSelection::All,
            root: self.body().root_name().map(str::to_string),
            probes: probes.iter().map(|name| name.to_string()).collect(),
            ..StageOptions::default()
        };
        Stage::new(self.model(), &options).map_err(ExperimentError::simulation(self.model()))
    }

    /// The exact touches of a trial, all in memory.
    pub fn babble(&self, seed: u64) -> Result<Vec<Touch>, ExperimentError> {
        self.tell(seed, "babbling");
        self.babble_body(self.body(), self.agent(), self.touches, seed)
    }

    /// The exact touches of a body, this one or one made from it.
    pub fn babble_body(
        &self,
        body: &Body,
        agent: &Agent,
        touches: usize,
        seed: u64,
    ) -> Result<Vec<Touch>, ExperimentError> {
        let options = BabblingOptions { touches, seed, jobs: self.jobs };
        let mut made = Vec::with_capacity(touches);
        let babbler = babbler(self.model(), body, agent, MotionName::default())?;
        all_touches(self.model(), &babbler, PolicyName::Random, &options, |touch| made.push(touch.clone()))?;
        Ok(made)
    }

    /// The exact touches of a trial whose motions a policy chooses, and what each cost.
    pub fn babble_by(&self, policy: PolicyName, seed: u64) -> Result<BabbledTrial, ExperimentError> {
        self.tell(seed, &format!("babbling, {policy}"));
        let options = BabblingOptions { touches: self.touches, seed, jobs: self.jobs };
        let (mut touches, mut seconds) = (Vec::new(), Vec::new());
        let babbler = self.embodied.babbler(MotionName::default())?;
        let began = Instant::now();
        all_touches(self.model(), &babbler, policy, &options, |touch| {
            touches.push(touch.clone());
            seconds.push(began.elapsed().as_secs_f64());
        })?;
        let motions = motions_until(&touches);
        Ok(BabbledTrial { touches, motions, seconds })
    }

    /// Learns from touches, disturbed as the options say, and measures against the truth.
    pub fn learn(&self, options: &LearningOptions, touches: &[Touch], seed: u64) -> LearnerRun {
        self.learn_with(options, self.agent(), self.truth(), touches, seed)
    }

    /// The same with limbs described otherwise than the model does: touches, their skin and the truth.
    pub fn learn_with(
        &self,
        options: &LearningOptions,
        agent: &Agent,
        truth: &GroundTruth,
        touches: &[Touch],
        seed: u64,
    ) -> LearnerRun {
        let felt = options.disturbances.disturbances().felt(agent, touches, seed);
        let began = Instant::now();
        let mut learner = options.learner(&felt.agent, seed);
        felt.touches.iter().for_each(|touch| learner.touch(touch));
        let learned = learner.learn();
        let seconds = WallTime(began.elapsed().as_secs_f64());
        let evaluation = evaluate_learned(agent, truth, &learned);
        LearnerRun { learned, seconds, evaluation }
    }

    /// What the creature knows of itself: by the session that was named, or after babbling by a seed.
    pub fn own_body(&self, seed: u64) -> Result<OwnBody, ExperimentError> {
        if let Some(folder) = &self.session {
            let (session, own) = own_body(folder)?;
            if session.agent.creature() != self.agent().creature() {
                return Err(ExperimentError::Refused(format!(
                    "{}: it is of another creature, or of other joints, than {} with --joints {}: give the model and \
                     joints that it was babbled with",
                    folder.display(),
                    self.model().display(),
                    self.joints()
                )));
            }
            return Ok(own);
        }
        let touches = self.babble(seed)?;
        self.tell(seed, "learning");
        let learned = self.learn(&LearningOptions::default(), &touches, seed).learned;
        Ok(OwnBody::of(self.agent(), &learned, &touches))
    }

    /// The number of a seed's trial among all trials, from 0; none where the seed is of none.
    pub fn number(&self, seed: u64) -> Option<usize> {
        self.seeds.iter().position(|&other| other == seed)
    }

    /// Tells the observer what a trial is at.
    pub fn tell(&self, seed: u64, doing: &str) {
        let trial = self.number(seed).map_or(0, |k| k + 1);
        self.observer.phase(Phase::Trial { trial, trials: self.seeds.len(), doing });
    }
}

impl LearnerRun {
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
