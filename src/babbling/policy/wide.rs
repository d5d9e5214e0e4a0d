//! Postures that tell much: towards the ends of the ranges.

use rand::Rng;

use crate::creature::{Creature, Posture};

/// How a coordinate drawn uniformly between −1 and 1 is spread towards its ends: the power of its amount.
const WIDE: f64 = 0.4;

/// A random posture that favours the ends of the ranges: what turns far tells most of its axis, and limbs
/// that are bent far meet more often. Balls are drawn as in [`Posture::random`].
pub fn wide_posture(creature: &Creature, rng: &mut impl Rng) -> Posture {
    let mut posture = Posture::random(creature, rng);
    for at in creature.elements().filter(|at| !at.is_ball()) {
        let [low, high] = at.range;
        if high > low {
            let q = &mut posture[at.coordinate()];
            let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
            let share = (*q - middle) / half;
            *q = (middle + half * share.signum() * share.abs().powf(WIDE)).clamp(low, high);
        }
    }
    creature.couple(&mut posture);
    posture
}
