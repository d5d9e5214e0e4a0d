//! How to learn, from the command line.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use serde::{Deserialize, Serialize};

use super::Failure;
use crate::babbling::PolicyName;
use crate::learning::learners::{LEARNERS, LearnerKind, learner_kind};
use crate::learning::{Input, LimbFrames, SkinKnowledge};
use crate::session::{DisturbanceLevels, LearningOptions, Session};

/// Options of learning.
#[derive(clap::Args, Clone, Debug, Serialize, Deserialize)]
#[command(next_help_heading = "Learning")]
pub struct LearningArguments {
    /// The learner [default: growth for touches made by stages, if surfaces are known and nothing is disturbed; else lm]
    #[arg(long, value_parser = learners())]
    learner: Option<String>,
    /// What a touch reports [default: receptor; for a recording, whatever it contains]
    #[arg(long, value_enum)]
    pub input: Option<Input>,
    /// What the agent knows about its skin
    #[arg(long, value_enum, default_value_t)]
    skin: SkinKnowledge,
    /// The frames in which points on limbs are given (limb needs the learner lm and --input contact)
    #[arg(long, value_enum, default_value_t)]
    frames: LimbFrames,
    /// Prior knowledge of joints, for the learner lm: a schema.json with all or some of its joints. A joint without deviations
    /// is exact and stays fixed; position_std (metres) and axis_std (radians) are standard deviations of a prior
    #[arg(long, value_name = "FILE")]
    pub known: Option<PathBuf>,
    #[command(flatten)]
    #[serde(flatten)]
    disturbances: DisturbanceLevels,
}

/// An example of a file of known joints, for the help of commands.
pub const KNOWN_HELP: &str = r#"Example of a file for --known: the left elbow exactly, the right wrist's position to 5 mm.
  {"joints": [
    {"joint": "left_elbow", "position": [0.024, 0.089, -0.28],
     "axes": [{"dof": "left_elbow_flexion", "axis": [-0.239924, -0.9466999, -0.2149319]},
              {"dof": "left_elbow_pronation", "axis": [0.2399183, 0.2399183, -0.9406798]}]},
    {"joint": "right_wrist", "position": [0.06, -0.06, -0.235], "position_std": 0.005}
  ]}"#;

fn learners() -> impl TypedValueParser<Value = String> {
    let choices = LEARNERS.iter().map(|learner| PossibleValue::new(learner.name()).help(learner.about()));
    PossibleValuesParser::new(choices)
}

impl LearningArguments {
    /// The learner that is named.
    pub fn named(&self) -> Option<&'static dyn LearnerKind> {
        self.learner.as_deref().and_then(learner_kind)
    }

    /// These with the learner that was chosen.
    pub fn chosen(&self, learner: &dyn LearnerKind) -> LearningArguments {
        LearningArguments { learner: Some(learner.name().to_string()), ..self.clone() }
    }

    /// The options for a session's touches: those of a recording report what the recording holds.
    pub fn options_for(&self, session: &Session) -> Result<LearningOptions, Failure> {
        let policy = session.options.policy.as_deref().and_then(|policy| policy.parse().ok());
        let options = self.bare(policy).for_session(session)?;
        Ok(options.knowing(self.known.as_deref(), session.agent.creature())?)
    }

    /// The options without what is known, for touches by a policy; none of a recording.
    pub fn bare(&self, policy: Option<PolicyName>) -> LearningOptions {
        let by_policy =
            LearningOptions::default_learner(policy.filter(|_| self.known.is_none() && self.open().grows()));
        LearningOptions { learner: self.named().unwrap_or(by_policy), ..self.open() }
    }

    /// The options without what is known, whatever the learner.
    pub fn open(&self) -> LearningOptions {
        LearningOptions {
            input: self.input,
            skin: self.skin,
            frames: self.frames,
            disturbances: self.disturbances,
            ..LearningOptions::default()
        }
    }
}
