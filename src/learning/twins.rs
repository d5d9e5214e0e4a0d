//! Pairs of limbs whose points are explained as well by axes that turn the other way.
//!
//! Between two limbs with few joints between them touches lie on a line or a small piece of a surface: an edge that slides
//! along another. Exact points of those may have a second exact answer, which no covariance tells of, and fresh touches of the
//! same pair bear it out as well.

use crate::creature::Creature;
use crate::deadline::Deadline;
use crate::learning::least_squares::{Stopping, levenberg_marquardt};
use crate::learning::observation::PointsMeet;
use crate::learning::touch_set::{PairTouches, PreparedTouch, TouchProblem, TouchSet};
use crate::learning::{AxisModel, Parameters};
use crate::schema::BodySchema;

/// Degrees of freedom between two limbs from which on their touches have one answer.
const ENOUGH_FREEDOM: usize = 4;
/// Touches of limbs with so many between them by which a joint is told, whatever others say.
const TOLD: usize = 8;
/// Touches of a pair that are enough to see it.
const MOST: usize = 60;
/// Steps from the turned axes.
const STEPS: usize = 60;
/// An axis that ends within this of where it was is the same, 1.
const SAME_AXIS: f64 = 0.02;
/// How much worse another answer may explain the touches: by its share, and in deviations of the points.
const AS_WELL: f64 = 1.1;
const AS_EXACTLY: f64 = 1e-3;

/// The touches without those of pairs of limbs that another answer, with axes the other way, explains as well and that no others
/// decide on; `held` joints are known from elsewhere.
pub(super) fn without_twins(
    creature: &Creature,
    touches: &TouchSet,
    schema: &BodySchema,
    held: &[bool],
) -> TouchSet {
    let freedom = |pair: &PairTouches| -> usize {
        pair.chain
            .joints()
            .map(|joint| {
                creature.joints()[joint].elements().map(|at| if at.is_ball() { 3 } else { 1 }).sum::<usize>()
            })
            .sum()
    };
    let mut told = vec![0; creature.joints().len()];
    for pair in touches.pairs.iter().filter(|pair| freedom(pair) >= ENOUGH_FREEDOM) {
        pair.chain.joints().for_each(|joint| told[joint] += pair.touches.len());
    }
    touches.filter(|pair| {
        let open: Vec<usize> = pair.chain.joints().filter(|&joint| !held[joint]).collect();
        freedom(pair) >= ENOUGH_FREEDOM
            || open.iter().all(|&joint| told[joint] >= TOLD)
            || !has_twin(creature, pair, &open, schema)
    })
}

/// Whether another answer for some joints explains the touches of a pair of limbs as well.
fn has_twin(creature: &Creature, pair: &PairTouches, open: &[usize], schema: &BodySchema) -> bool {
    let step = pair.touches.len().div_ceil(MOST).max(1);
    let few = pair.touches.iter().step_by(step).cloned().collect();
    let few = TouchSet { pairs: vec![PairTouches { touches: few, ..pair.clone() }] };
    let axes: Vec<usize> = open
        .iter()
        .flat_map(|&joint| creature.joints()[joint].elements().filter(|at| !at.is_ball()).map(|at| at.axis()))
        .collect();
    let parameters = Parameters::of(
        creature,
        AxisModel::Unit,
        |joint| open.contains(&joint),
        |joint, _| open.contains(&joint),
    );
    let now = misfit(&few, schema);
    (1..1usize << axes.len()).any(|turned| {
        let mut other = schema.clone();
        let of_it = axes.iter().enumerate().filter(|(bit, _)| turned >> bit & 1 == 1);
        of_it.for_each(|(_, &axis)| other.axes[axis] = -other.axes[axis]);
        let stopping =
            Stopping { iterations: STEPS, relative_cost: 1e-6, cost: 0.0, deadline: Deadline::NEVER };
        let mut problem = TouchProblem::new(creature, &few, &parameters, PointsMeet::Anyhow);
        let other = levenberg_marquardt(&mut problem, other, stopping).state;
        let elsewhere = axes.iter().any(|&axis| (other.axes[axis] - schema.axes[axis]).norm() > SAME_AXIS);
        elsewhere && misfit(&few, &other) <= AS_WELL * now + AS_EXACTLY
    })
}

/// Root mean square of what points miss each other by, in their deviations.
fn misfit(touches: &TouchSet, schema: &BodySchema) -> f64 {
    let squared =
        |touch: &PreparedTouch| PointsMeet::Anyhow.squared_misfit(&touch.ends, &touch.frames(schema));
    (touches.touches().map(squared).sum::<f64>() / (3 * touches.len().max(1)) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Vector3};

    use super::*;
    use crate::creature::{Dof, DofKind, Joint};
    use crate::kinematics::{Chain, ChainSide};
    use crate::learning::observation::Observation;
    use crate::learning::touch_set::LimbTouch;

    /// A trunk, an arm and a hand on a hinge each.
    fn creature() -> Creature {
        let hinge =
            |name: &str| Dof { name: name.into(), kind: DofKind::Hinge, range: [-2.0, 2.0], follows: None };
        let joints = vec![
            Joint::new("shoulder", 0, vec![hinge("shoulder")]),
            Joint::new("elbow", 1, vec![hinge("elbow")]),
        ];
        let limbs = ["trunk", "arm", "hand"].map(String::from).to_vec();
        Creature::new("arm".into(), limbs, joints, Vec::new()).unwrap()
    }

    fn schema(creature: &Creature) -> BodySchema {
        let mut schema = BodySchema::zero(creature);
        schema.positions = vec![Vector3::new(0.1, 0.0, 0.2), Vector3::new(0.0, 0.3, 0.0)];
        schema.axes = vec![Vector3::x(), Vector3::z()];
        schema
    }

    /// Touches of the hand, with so many of its points, and the trunk in some postures, exact under the schema.
    fn touches(creature: &Creature, points: usize, postures: impl Iterator<Item = [f64; 2]>) -> TouchSet {
        let schema = schema(creature);
        let mut set = TouchSet::default();
        for (number, posture) in postures.enumerate() {
            let on_hand = Vector3::new(0.02, 0.1, 0.03) * (1 + number % points) as f64;
            let chain = Chain::between(creature, 0, 2);
            let side = ChainSide::new(creature, &chain.sides[1], &posture);
            let on_trunk = side.frame(&schema).point(&on_hand);
            let ends = [on_trunk, on_hand].map(|position| Observation {
                position,
                covariance: Matrix3::identity() * 1e-8,
                receptor: 0,
            });
            set.push(creature, LimbTouch { limbs: [0, 2], posture: &posture, ends });
        }
        set
    }

    #[test]
    fn touches_with_one_answer_tell_and_those_with_a_twin_do_not() {
        let creature = creature();
        let schema = schema(&creature);
        let left =
            |touches: &TouchSet, held: [bool; 2]| without_twins(&creature, touches, &schema, &held).len();
        let turned = |k: usize| [1.3 * (0.7 * k as f64).sin(), 1.1 * (1.9 * k as f64).cos()];
        let free = touches(&creature, 5, (0..40).map(turned));
        assert_eq!(left(&free, [false; 2]), 40);
        // A corner of the hand, and the elbow the same in all: the axis of that may be any.
        let stiff = touches(&creature, 1, (0..40).map(|k| [turned(k)[0], 0.4]));
        assert_eq!(left(&stiff, [false; 2]), 0);
        // What is known from elsewhere needs no touch.
        assert_eq!(left(&stiff, [false, true]), 40);
    }
}
