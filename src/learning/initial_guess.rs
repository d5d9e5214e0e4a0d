//! Initial guess schemas: what an agent believes before its first touch.

use rand::{Rng, RngExt};

use crate::creature::{Creature, DofKind};
pub use crate::geometry::random_direction;
use crate::schema::BodySchema;

/// The greatest length of the initial guess: "assign the segment lengths with small values" (IVA 2009, section 3.2).
pub const GUESS_LENGTH: f64 = 0.02;

/// Random axes and small lengths for every joint of the creature.
pub fn random_guess(creature: &Creature, rng: &mut impl Rng) -> BodySchema {
    let mut schema = BodySchema::zero(creature);
    for joint in 0..creature.joints().len() {
        randomize_joint(creature, &mut schema, joint, rng);
    }
    schema
}

/// Gives one joint a random axis per degree of freedom and a small random position.
pub fn randomize_joint(creature: &Creature, schema: &mut BodySchema, joint: usize, rng: &mut impl Rng) {
    schema.positions[joint] = random_direction(rng) * rng.random_range(0.0..GUESS_LENGTH);
    let joint = &creature.joints()[joint];
    for (k, dof) in joint.dof_indices().zip(&joint.dofs) {
        if dof.kind != DofKind::Ball {
            schema.axes[k] = random_direction(rng);
        }
    }
}
