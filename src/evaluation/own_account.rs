//! What can be told of a schema without the truth: how sure the touches make it, and how far apart it puts what
//! touched in touches that it was not fitted to.

use super::measures::{claimed_deviations, rms};
use super::{Summary, held_out_points};
use crate::agent::Agent;
use crate::learning::annealing::gaps;
use crate::learning::touch_set::TouchSet;
use crate::learning::{Input, Learned, Learner, SecondOrder};
use crate::senses::Touch;

/// Every how many touches one is held out.
const HELD_OUT: usize = 5;

/// A schema's own account of how good it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OwnAccount {
    /// Root mean square of how far off skin of one limb is expected in another's frame, millimetres, over limbs
    /// that are claimed to be placed against one another, at the postures of the held-out error. It is the least that noise of
    /// the size that the touches show leaves; what the learner does not know of, such as joints that are not rigid,
    /// is not in it. `None` if nothing is determined.
    pub expected_mm: Option<f64>,
    /// Every fifth touch under a schema fitted anew to the others: how far apart it puts the two points or, of receptors, the
    /// two surfaces, millimetres; of limbs that are claimed, or of all where none is. `None` if too few touches are left.
    pub fresh_mm: Option<Summary>,
}

impl OwnAccount {
    /// The account of what the learner `lm` came to; `None` if it can give none, as where nothing explains the touches.
    pub fn new(agent: &Agent, touches: &[Touch], learned: &Learned) -> Option<OwnAccount> {
        let (creature, input) = (agent.creature(), learned.basis.input);
        let account = learned.account.as_ref()?;
        let expected_mm = learned.reliable_account().and_then(|account| {
            let (schema, observability) = (&learned.schema, &account.observability);
            rms(&claimed_deviations(creature, schema, account, observability, &held_out_points(agent)).1)
        });

        // A body that places no skin may explain touches all the same, as far as one arm at one place tells.
        let all = learned.reliable_account().is_none_or(|account| !account.claims_any());
        let known = (0..creature.joints().len())
            .map(|joint| all || !account.undetermined().contains(&joint))
            .collect();
        let mut fitted = SecondOrder::new(agent, input, 0);
        let mut fresh = SecondOrder::new(agent, input, 0);
        for (i, touch) in touches.iter().enumerate() {
            let held_out = i % HELD_OUT == HELD_OUT - 1;
            if held_out { &mut fresh } else { &mut fitted }.touch(touch);
        }
        let schema = fitted.refine_known(&learned.schema, known).schema;
        let mut set = TouchSet::default();
        for (limbs, touch) in fresh.prepared().filter(|([a, b], _)| all || account.claims(*a, *b)) {
            set.push_prepared(creature, limbs, touch);
        }
        let misses = match input {
            Input::Receptor => gaps(agent.skin(), &set, &schema),
            Input::Contact => {
                let touches = set.touches();
                touches.map(|touch| touch.miss(&schema).norm()).collect()
            }
        };
        let fresh_mm = (!misses.is_empty()).then(|| Summary::of(misses.iter().map(|miss| 1e3 * miss)));
        Some(OwnAccount { expected_mm, fresh_mm })
    }
}
