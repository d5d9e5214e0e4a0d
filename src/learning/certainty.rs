//! With what a schema was learned, and how sure it is: worked out once, by the learner, and handed on to whoever asks.

use serde::{Deserialize, Serialize};

use super::Account;
use super::observation::{LimbFrames, SkinKnowledge};
use crate::senses::Input;

/// With what a schema was learned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Basis {
    /// What touches reported.
    pub input: Input,
    /// What was known of the skin.
    pub skin: SkinKnowledge,
    /// Which frames points on limbs were given in.
    pub frames: LimbFrames,
}

impl Basis {
    /// Receptors on known surfaces, limbs in the frames of their joints.
    pub const SURFACES: Basis =
        Basis { input: Input::Receptor, skin: SkinKnowledge::Surface, frames: LimbFrames::Joint };

    /// Points alone, as touches report them: the paper's basis.
    pub fn points(input: Input) -> Basis {
        Basis { input, skin: SkinKnowledge::Centres, frames: LimbFrames::Joint }
    }
}

/// How sure a schema is.
#[derive(Clone, Debug)]
pub enum Certainty {
    /// It is taken as it is, as from somebody who knows.
    Exact,
    /// It explains touches that it was not fitted to, and they determine it so well.
    Estimated(Box<Account>),
    /// Nothing tells how far off it may be: it was never put to the test, or failed it.
    Unknown,
}
