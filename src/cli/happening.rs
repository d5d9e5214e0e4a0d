//! What happens to a creature in a conversation without a word to it.

use super::Failure;
use crate::simulation::Stage;

/// The most that a limb grows at once, millimetres.
const LONGEST_GROWTH: f64 = 300.0;

/// What happens on the stage by a line that begins with a slash, without it; what did, in words.
///
/// # Errors
/// Where nothing happens by it: how it is written.
pub fn happens(stage: &Stage, direction: &str) -> Result<String, Failure> {
    let words: Vec<&str> = direction.split_whitespace().collect();
    let ["grow", name, length] = words.as_slice() else {
        return Err(Failure(format!(
            "/{direction}: nothing is known that happens by this: write /grow LIMB MILLIMETRES, as in /grow left_hand 30"
        )));
    };
    let creature = &stage.body().creature;
    let limb = creature.limb(name).filter(|limb| *limb > 0).ok_or_else(|| {
        let limbs = creature.limbs()[1..].join(", ");
        Failure(format!("/{direction}: there is no limb {name} that a joint moves: choose one of {limbs}"))
    })?;
    let millimetres = length.parse::<f64>().ok().filter(|x| x.abs() <= LONGEST_GROWTH).ok_or_else(|| {
        Failure(format!(
            "/{direction}: {length} is no number of millimetres from -{LONGEST_GROWTH} to {LONGEST_GROWTH}"
        ))
    })?;
    stage.grow_limb(limb, 1e-3 * millimetres)?;
    Ok(format!("the joint of {name} is now {millimetres} mm farther out"))
}
