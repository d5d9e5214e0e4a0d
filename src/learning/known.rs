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
    /// Per joint, whether the prior's position was given, not guessed from where the skin is.
    pub given_positions: Vec<bool>,
}

impl Known {
    /// Nothing but where the skin is.
    pub fn nothing(creature: &Creature, skin: &Skin) -> Known {
        let joints = creature.joints().len();
        Known {
            prior: Prior::skin(creature, skin, SPREAD),
            frozen: vec![false; joints],
            given_positions: vec![false; joints],
        }
    }

    /// The prior without what is guessed from where the skin is: what counts as evidence beside the touches.
    pub fn given(&self) -> Prior {
        let mut given = self.prior.clone();
        for (deviation, given) in given.position_deviations.iter_mut().zip(&self.given_positions) {
            if !given {
                *deviation = f64::INFINITY;
            }
        }
        given
    }
}
