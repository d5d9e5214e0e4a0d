//! Why a creature cannot act.

/// Why a creature cannot act.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ActorError {
    /// The one on the stage is another: name and number of joints of either.
    #[error(
        "the schema is of {} with {} joints, the scene has {} with {}: give the scene of the creature that learned it",
        known.0, known.1, there.0, there.1
    )]
    Creature {
        /// The one that learned the schema.
        known: (String, usize),
        /// The one on the stage.
        there: (String, usize),
    },
    /// It has another skin there.
    #[error("the scene's creature has other receptors than the one that learned the schema")]
    Skin,
    /// It has no limb of a name.
    #[error("there is no limb called {name}: give two of {limbs}")]
    NoLimb {
        /// The name.
        name: String,
        /// The limbs there are.
        limbs: String,
    },
    /// Nothing can be felt with a limb.
    #[error("{limb} has no receptors: nothing can be felt with it")]
    NoReceptors {
        /// The limb.
        limb: String,
    },
    /// A limb cannot move without the other.
    #[error("nothing moves {} but what moves {}: give two other limbs", limbs[0], limbs[1])]
    OneArm {
        /// The limb, and the other.
        limbs: [String; 2],
    },
}
