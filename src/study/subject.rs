//! Who is studied: a creature that babbles, learns and is measured against the truth.

use std::ops::Deref;
use std::path::Path;

use serde_json::json;

use super::Row;
use crate::babbling::{BabblingOptions, PolicyName};
use crate::creature::JointSelection;
use crate::deadline::apart;
use crate::error::Error;
use crate::evaluation::{Evaluation, evaluate_learned};
use crate::learning::{Learned, Verdict};
use crate::peripersonal::{CollisionChecker, OwnBody};
use crate::senses::RecordedTouch;
use crate::session::{Embodied, LearningOptions, own_body};
use crate::simulation::{MotionName, Stage, StageOptions, Thing};

/// Mean held-out error at which a learner without a verdict of its own counts as converged, millimetres.
const CONVERGED_MM: f64 = 10.0;

/// A creature that is studied.
pub struct Subject {
    embodied: Embodied,
    /// What it has learned of its body before the trials, and the truth of the same.
    known: Option<[Knowledge; 2]>,
}

/// What a creature knows of its body, and its surfaces with nothing about them.
pub(super) struct Knowledge {
    pub own: OwnBody,
    pub clearance: CollisionChecker,
}

impl Knowledge {
    fn new(own: OwnBody) -> Knowledge {
        Knowledge { clearance: CollisionChecker::new(&own), own }
    }
}

impl Deref for Subject {
    type Target = Embodied;

    fn deref(&self) -> &Embodied {
        &self.embodied
    }
}

impl Subject {
    /// A creature that has learned nothing yet.
    ///
    /// # Errors
    /// If it cannot babble.
    pub fn new(embodied: Embodied) -> Result<Subject, Error> {
        embodied.babbler(MotionName::default())?;
        Ok(Subject { embodied, known: None })
    }

    /// The same with the body that it has learned in a session, or from so many touches by a seed.
    ///
    /// # Errors
    /// If the session cannot be read or is of another creature, or the creature cannot babble.
    pub(super) fn with_learned_body(
        self,
        session: Option<&Path>,
        touches: usize,
        seed: u64,
    ) -> Result<Subject, Error> {
        let own = match session {
            None => {
                let touches = self.babble(touches, seed)?;
                let (learned, _) = self.learn(&LearningOptions::default(), &touches, seed);
                OwnBody::of(self.agent(), &learned, touches.iter().map(|touch| &touch.posture))
            }
            Some(folder) => {
                let (session, own) = own_body(folder)?;
                if session.agent.creature() != self.agent().creature() {
                    return Err(Error::unfit(
                        folder,
                        format!(
                            "the session has another creature or other joints than {} with --joints {}: give the \
                             model and joints that it was babbled with",
                            self.model().display(),
                            self.source().joints
                        ),
                    ));
                }
                own
            }
        };
        let truth = own.with_schema(self.truth().schema.clone());
        Ok(Subject { known: Some([own, truth].map(Knowledge::new)), ..self })
    }

    /// What it has learned of its body before the trials, and the truth of the same.
    pub(super) fn known(&self) -> Result<&[Knowledge; 2], Error> {
        self.known.as_ref().ok_or_else(|| Error::usage("it has not learned its body"))
    }

    /// The creature on a stage, with probes that touch it and things about it.
    pub(super) fn stage(
        &self,
        joints: &JointSelection,
        probes: &[&str],
        things: Vec<Thing>,
    ) -> Result<Stage, Error> {
        let options = StageOptions {
            joints: joints.clone(),
            root: self.body().root_name().map(str::to_string),
            probes: probes.iter().map(|name| name.to_string()).collect(),
            things,
            ..StageOptions::default()
        };
        Stage::new(self.model(), &options).map_err(Error::of_model(self.model()))
    }

    /// Exact touches at random, on one thread: trials share the others.
    pub(super) fn babble(&self, touches: usize, seed: u64) -> Result<Vec<RecordedTouch>, Error> {
        let babbler = self.embodied.babbler(MotionName::default())?;
        let options = BabblingOptions { touches, seed, jobs: 1 };
        Ok(self.embodied.touches(&babbler, PolicyName::Random, &options)?.0)
    }

    /// Learns from touches, disturbed as the options say; what was learned, and its measures against the truth.
    pub(super) fn learn(
        &self,
        options: &LearningOptions,
        touches: &[RecordedTouch],
        seed: u64,
    ) -> (Learned, Row) {
        let felt = options.disturbances.disturbances().felt(self.agent(), touches, options.input(), seed);
        let mut learner = options.learner(&felt.agent, seed);
        let (learned, done) = apart(|| {
            felt.touches.iter().for_each(|touch| learner.touch(touch));
            learner.learn()
        });
        let Evaluation { heldout_mm, hand_mm, .. } = evaluate_learned(self.agent(), self.truth(), &learned);
        let converged = match learned.verdict {
            Verdict::Converged => true,
            Verdict::Failed(_) => false,
            Verdict::Unjudged(_) => heldout_mm.mean <= CONVERGED_MM,
        };
        let row = json!({
            "heldout_mm": heldout_mm.mean,
            "hand_mm": hand_mm.map(|hand| hand.mean),
            "converged": converged,
            "noise_estimate_mm": learned.deviation.map(|metres| 1e3 * metres),
            "initial_guesses": learned.initial_guesses,
            "work_s": done.seconds(),
        });
        (learned, row)
    }
}
