//! Making touches: what all experiments that babble share.

use std::path::Path;

use crate::babbling::{Babbler, BabblingOptions, BoutsDone, Made, PolicyName};
use crate::error::Error;
use crate::learning::growth::Growth;
use crate::senses::RecordedTouch;
use crate::simulation::Effort;

/// Babbles and hands on every touch, from where the bouts in `from` end; errors name the file of the `model`.
///
/// Policies other than random have no bouts, and begin at the beginning; those that learn all that can be learned
/// hand over what they did.
pub fn make_touches(
    model: &Path,
    babbler: &Babbler,
    policy: PolicyName,
    from: BoutsDone,
    options: &BabblingOptions,
    receive: impl FnMut(Made) -> Result<(), Error>,
) -> Result<(Effort, Option<Growth>), Error> {
    babbler.babble_by(policy, from, options, receive).map_err(Error::of_model(model))
}

/// The touches alone, from the first on, and what was learned on the way.
pub fn all_touches(
    model: &Path,
    babbler: &Babbler,
    policy: PolicyName,
    options: &BabblingOptions,
) -> Result<(Vec<RecordedTouch>, Option<Growth>), Error> {
    let mut touches = Vec::new();
    let from = BoutsDone::default();
    let (_, grown) = make_touches(model, babbler, policy, from, options, taking(&mut touches))?;
    Ok((touches, grown))
}

/// Takes the touches alone of what is made.
pub fn taking(touches: &mut Vec<RecordedTouch>) -> impl FnMut(Made) -> Result<(), Error> {
    |made| {
        if let Made::Touch(touch) = made {
            touches.push(touch.clone());
        }
        Ok(())
    }
}
