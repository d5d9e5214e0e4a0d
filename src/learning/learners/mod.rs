//! The learners by name: what each is, what it can use, and how it is made.
//!
//! To add a learner, write a file with a [`LearnerKind`], and name it in [`LEARNERS`]: the command line, sessions and
//! studies have it by its name.

mod growth;
mod hersch;
mod levenberg_marquardt;

pub use growth::PartByPart;
pub use hersch::HerschsRule;
pub use levenberg_marquardt::LevenbergMarquardt;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::agent::Agent;
use crate::learning::growth::Growth;
use crate::learning::{Input, KnownJoint, Learner, LimbFrames, SkinKnowledge};

/// The learners, in the order in which they are named to the user; the first stands where none is named.
pub const LEARNERS: &[&dyn LearnerKind] = &[&LevenbergMarquardt, &PartByPart, &HerschsRule];

/// A kind of learner.
pub trait LearnerKind: Sync {
    /// Its name, in one word.
    fn name(&self) -> &'static str;

    /// What it is, in a line.
    fn about(&self) -> &'static str;

    /// What it can use of what it is given.
    fn uses(&self) -> LearnerUses {
        LearnerUses::default()
    }

    /// A learner with a body and a way to learn, whose random numbers come from `seed`.
    fn learner(&self, agent: &Agent, given: &LearnerGivens, seed: u64) -> Box<dyn Learner>;

    /// Whether it predicts each touch before it learns from it.
    fn predicts(&self, _given: &LearnerGivens) -> bool {
        false
    }

    /// Whether it learns from each touch as it comes, so that looking at its schema on the way costs little.
    fn learns_each_touch(&self, given: &LearnerGivens) -> bool {
        self.predicts(given)
    }

    /// After how many of so many touches it is worth a measurement, where that costs little.
    fn checkpoints(&self, _given: &LearnerGivens, _touches: usize) -> Vec<usize> {
        Vec::new()
    }
}

/// In files a learner goes by its name.
impl Serialize for dyn LearnerKind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.name().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for &'static dyn LearnerKind {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        learner_kind(&name).ok_or_else(|| D::Error::custom(format!("unknown learner {name}")))
    }
}

/// What a learner is given beside a body: how touches are reported to it, and what it knows.
#[derive(Clone, Debug, Default)]
pub struct LearnerGivens {
    /// What touches report.
    pub input: Input,
    /// What it knows of its skin.
    pub skin: SkinKnowledge,
    /// Which frames points on limbs are given in.
    pub frames: LimbFrames,
    /// What is known of joints before the first touch.
    pub known: Vec<KnownJoint>,
    /// What was learned while the touches were made, for a learner that goes on from it.
    pub grown: Option<Growth>,
}

/// What a kind of learner can use of what it is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LearnerUses {
    /// The surfaces under the receptors.
    pub surfaces: bool,
    /// What is known of joints before the first touch.
    pub known_joints: bool,
    /// Points in frames of the limbs' own.
    pub limb_frames: bool,
    /// Nothing without the surfaces under the receptors.
    pub surfaces_alone: bool,
}

/// The learner of a name.
pub fn learner_kind(name: &str) -> Option<&'static dyn LearnerKind> {
    LEARNERS.iter().copied().find(|learner| learner.name() == name)
}

/// From `first` on by doubling, below `touches`.
fn doubling(first: usize, touches: usize) -> Vec<usize> {
    (0..40).map(|k| first << k).take_while(|&n| n < touches).collect()
}
