//! What a user knows of a body already.

use crate::creature::Creature;
use crate::learning::Prior;
use crate::skin::Skin;

/// How far from a limb's skin the joints on it may be, in units of the skin's own extent. Wide: it keeps
/// joints that few touches involve from running away, and weighs nothing against touches.
const SPREAD: f64 = 0.7;

/// Joints that are known before the first touch: some exactly, some nearly, most not at all.
#[derive(Clone, Debug)]
pub struct Known {
    /// Positions and axes with their deviations.
    pub prior: Prior,
    /// Per joint, whether it keeps the prior's mean.
    pub frozen: Vec<bool>,
}

impl Known {
    /// Nothing but where the skin is.
    pub fn nothing(creature: &Creature, skin: &Skin) -> Known {
        Known { prior: Prior::skin(creature, skin, SPREAD), frozen: vec![false; creature.joints().len()] }
    }
}
