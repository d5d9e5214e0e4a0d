//! The error of a learned schema, compared with the truth.
//!
//! Positions and axes are never compared one by one where the touches cannot tell: a joint may slide along
//! its axis into the next one without any chain feeling it. What is compared is where the skin of every
//! limb lands relative to every other limb, in postures that were not babbled; the axes of determined
//! joints; and the touches themselves.

mod bound;
mod map_agreement;
mod measures;

pub use bound::{CramerRaoBound, OwnAccount, Progress};
pub use map_agreement::MapAgreement;
pub use measures::{
    AxisErrors, HELD_OUT_POSTURES, HeldOutPoint, Summary, axis_errors, held_out, held_out_points,
    touch_misses, touches_across,
};

use serde::{Deserialize, Serialize};

use crate::agent::Agent;
use crate::creature::Creature;
use crate::ground_truth::GroundTruth;
use crate::kinematics::Chain;
use crate::learning::{Account, Learned};
use crate::schema::BodySchema;

/// All error measures of one schema.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// Where a random skin point of a random limb lands in another random limb's frame, millimetres.
    pub heldout_mm: Summary,
    /// The same over limbs that are claimed to be placed against one another, millimetres.
    pub determined_mm: Summary,
    /// The same beside its Cramér-Rao bound; `None` if what the touches determine is not known.
    #[serde(default)]
    pub bound_mm: Option<CramerRaoBound>,
    /// The same with a hand as one of the two, millimetres; `None` if the creature has no hands.
    pub hand_mm: Option<Summary>,
    /// Angle between learned and true axes of determined joints, degrees.
    pub axis_deg: Summary,
    /// Distance between learned and true axis lines of determined joints, millimetres.
    pub axis_line_mm: Summary,
}

/// Measures a schema. `undetermined` names the joints that the touches did not determine.
pub fn evaluate(
    agent: &Agent,
    truth: &GroundTruth,
    schema: &BodySchema,
    undetermined: &[usize],
) -> Evaluation {
    let creature = agent.creature();
    let unplaced = |limb: &usize| !schema.places(creature, *limb);
    let unplaced: Vec<usize> = (0..creature.limbs().len()).filter(unplaced).collect();
    measure(agent, truth, schema, [undetermined, &unplaced], None)
}

/// Measures a schema by what its account claims, beside the bound of that. Where no account can be relied on, because
/// learning did not converge or its learner gives none, nothing is claimed, and the axes of all joints are compared.
pub fn evaluate_claims(
    agent: &Agent,
    truth: &GroundTruth,
    schema: &BodySchema,
    account: Option<&Account>,
) -> Evaluation {
    let Some(account) = account else {
        let nothing = Summary::of(std::iter::empty());
        return Evaluation { determined_mm: nothing, ..evaluate(agent, truth, schema, &[]) };
    };
    let undetermined = [account.undetermined(), account.undetermined_limbs()];
    measure(agent, truth, schema, undetermined, Some(account))
}

/// Measures what a learner came to, as [`evaluate_claims`].
pub fn evaluate_learned(agent: &Agent, truth: &GroundTruth, learned: &Learned) -> Evaluation {
    evaluate_claims(agent, truth, &learned.schema, learned.reliable_account())
}

fn measure(
    agent: &Agent,
    truth: &GroundTruth,
    schema: &BodySchema,
    [undetermined, undetermined_limbs]: [&[usize]; 2],
    account: Option<&Account>,
) -> Evaluation {
    let creature = agent.creature();
    let points = held_out_points(agent);
    let errors = held_out(creature, truth, schema, &points);
    let bound_mm = account.and_then(|account| {
        CramerRaoBound::new(creature, schema, account, &account.observability, &points, &errors)
    });
    let located = |[a, b]: [usize; 2]| match account {
        Some(account) => account.claims(a, b),
        None => {
            !Chain::between(creature, a, b).joints().any(|joint| undetermined.contains(&joint))
                && ![a, b].iter().any(|limb| undetermined_limbs.contains(limb))
        }
    };
    let with_hand = |limbs: [usize; 2]| limbs.iter().any(|&limb| is_hand(creature, limb));
    let of = |counts: &dyn Fn([usize; 2]) -> bool| {
        let errors = points.iter().zip(&errors).filter(|(point, _)| counts(point.limbs));
        Summary::of(errors.map(|(_, error)| *error))
    };
    let axes = axis_errors(creature, truth, schema, undetermined, undetermined_limbs);
    Evaluation {
        heldout_mm: of(&|_| true),
        determined_mm: of(&located),
        bound_mm,
        hand_mm: points.iter().any(|point| with_hand(point.limbs)).then(|| of(&with_hand)),
        axis_deg: Summary::of(axes.iter().map(|e| e.degrees)),
        axis_line_mm: Summary::of(axes.iter().filter_map(|e| e.line_millimetres)),
    }
}

/// Whether a limb is a hand or a part of one: by its name or the name of its aura.
pub fn is_hand(creature: &Creature, limb: usize) -> bool {
    let aura = creature.aura_of(limb).map(|aura| creature.aura_limbs()[aura].name.as_str());
    creature.limbs()[limb].ends_with("hand") || aura.is_some_and(|name| name.ends_with("hand"))
}
