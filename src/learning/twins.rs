//! Pairs of limbs whose points are explained as well by axes that turn the other way.
//!
//! Between two limbs with few joints between them touches lie on a line or a small piece of a surface: an edge that slides
//! along another, or two fingers that bend in one plane. Exact points of those may have a second exact answer, which no covariance
//! tells of, and fresh touches of the same limbs bear it out as well.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use crate::creature::Creature;
use crate::learning::least_squares::Stopping;
use crate::learning::observation::PointsMeet;
use crate::learning::touch_set::{PairTouches, TouchProblem, TouchSet};
use crate::learning::{AxisModel, Parameters};
use crate::schema::BodySchema;

/// Degrees of freedom between two limbs from which on their touches tell of joints that others have, too.
const ENOUGH_FREEDOM: usize = 4;
/// Touches of limbs with so many between them, and with some other joint, by which a joint is told.
const TOLD: usize = 8;
/// Touches of a pair that are enough to see it.
const MOST: usize = 60;
/// Steps from the turned axes.
const STEPS: usize = 60;
/// Axes of which any may be turned together; of up to twice as many two, of more one. All may also be mirrored.
const FEW_AXES: usize = 4;
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
    let open =
        |pair: &PairTouches| -> Vec<usize> { pair.chain.joints().filter(|&joint| !held[joint]).collect() };
    let freedom = |pair: &PairTouches| -> usize {
        let elements = pair.chain.joints().flat_map(|joint| creature.joints()[joint].elements());
        elements.map(|at| if at.is_ball() { 3 } else { 1 }).sum()
    };
    let mut left = touches.clone();
    // Those with most joints between them first: what is left of a part where it is gone is asked again.
    let mut sets: Vec<Vec<usize>> = touches.pairs.iter().map(open).collect();
    sets.sort_by(|a, b| b.len().cmp(&a.len()).then_with(|| a.cmp(b)));
    sets.dedup();
    for joints in sets {
        // Two fingers that touch nothing but each other are mirrored as a whole.
        let within =
            |pair: &PairTouches| pair.chain.joints().all(|joint| held[joint] || joints.contains(&joint));
        let mut told = vec![0; creature.joints().len()];
        for pair in left.pairs.iter().filter(|pair| !within(pair) && freedom(pair) >= ENOUGH_FREEDOM) {
            pair.chain.joints().for_each(|joint| told[joint] += pair.touches.len());
        }
        let untold: Vec<usize> = joints.iter().copied().filter(|&joint| told[joint] < TOLD).collect();
        if untold.is_empty() {
            continue;
        }
        if let Some(turned) = twin(creature, &left.filter(within), &joints, &untold, schema) {
            left = left
                .filter(|pair| !within(pair) || !pair.chain.joints().any(|joint| turned.contains(&joint)));
        }
    }
    left
}

/// The joints that another answer for some joints has turned, with axes of those `untold` elsewhere, which explains their touches as
/// well; none where there is none.
fn twin(
    creature: &Creature,
    touches: &TouchSet,
    joints: &[usize],
    untold: &[usize],
    schema: &BodySchema,
) -> Option<Vec<usize>> {
    let few = |pair: &PairTouches| {
        let step = pair.touches.len().div_ceil(MOST).max(1);
        PairTouches { touches: pair.touches.iter().step_by(step).cloned().collect(), ..pair.clone() }
    };
    let few = TouchSet { pairs: touches.pairs.iter().map(few).collect() };
    let axes: Vec<usize> = untold
        .iter()
        .flat_map(|&joint| creature.joints()[joint].elements().filter(|at| !at.is_ball()).map(|at| at.axis()))
        .collect();
    let parameters = Parameters::of(
        creature,
        AxisModel::Unit,
        |joint| joints.contains(&joint),
        |joint, _| untold.contains(&joint),
    );
    let now = few.misfit(PointsMeet::Anyhow, schema);
    let turned = |turned: &dyn Fn(usize) -> bool| {
        let mut other = schema.clone();
        let of_it = axes.iter().enumerate().filter(|(number, _)| turned(*number));
        of_it.for_each(|(_, &axis)| other.axes[axis] = -other.axes[axis]);
        other
    };
    let mut others: Vec<BodySchema> = Vec::new();
    if axes.len() <= FEW_AXES {
        others.extend((1..1usize << axes.len()).map(|bits| turned(&|number| bits >> number & 1 == 1)));
    } else {
        let beside = if axes.len() <= 2 * FEW_AXES { axes.len() } else { 1 };
        let pairs = (0..axes.len()).flat_map(|a| (a..axes.len().min(a + beside)).map(move |b| [a, b]));
        others.extend(pairs.map(|pair| turned(&|number| pair.contains(&number))));
    }
    for normal in few.pairs.iter().max_by_key(|pair| pair.touches.len()).into_iter().flat_map(normals) {
        let mut other = schema.clone();
        for &axis in &axes {
            let own = other.axes[axis];
            other.axes[axis] = 2.0 * own.dot(&normal) * normal - own;
        }
        for &joint in joints {
            let own = other.positions[joint];
            other.positions[joint] = own - 2.0 * own.dot(&normal) * normal;
        }
        others.push(other);
    }
    others.into_iter().find_map(|other| {
        let stopping = Stopping { iterations: STEPS, relative_cost: 1e-6, ..Stopping::default() };
        let other = TouchProblem::new(creature, &few, &parameters, PointsMeet::Anyhow).fit(other, stopping);
        let is_turned = |joint: &usize| {
            let mut elements = creature.joints()[*joint].elements().filter(|at| !at.is_ball());
            elements.any(|at| (other.axes[at.axis()] - schema.axes[at.axis()]).norm() > SAME_AXIS)
        };
        let turned: Vec<usize> = untold.iter().copied().filter(is_turned).collect();
        (!turned.is_empty() && few.misfit(PointsMeet::Anyhow, &other) <= AS_WELL * now + AS_EXACTLY)
            .then_some(turned)
    })
}

/// The directions along which the places of a pair's touches lie nearest to a plane, on either limb: mirrored there they stay where
/// they are.
fn normals(pair: &PairTouches) -> Vec<Vector3<f64>> {
    let on_limb = |end: usize| {
        let places = || pair.touches.iter().map(move |touch| touch.ends[end].position);
        let middle = places().sum::<Vector3<f64>>() / pair.touches.len().max(1) as f64;
        let scatter: Matrix3<f64> =
            places().map(|place| (place - middle) * (place - middle).transpose()).sum();
        SymmetricEigen::new(scatter).eigenvectors
    };
    [0, 1].map(on_limb).iter().flat_map(|found| [0, 1, 2].map(|k| found.column(k).into_owned())).collect()
}

#[cfg(test)]
mod tests {
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

    /// Two fingers on a palm that touch each other: a thumb of three hinges and a finger of one.
    fn fingers(is_in_plane: bool) -> (Creature, BodySchema, TouchSet) {
        let hinge =
            |name: &str| Dof { name: name.into(), kind: DofKind::Hinge, range: [-1.0, 1.0], follows: None };
        let joint = |name: &str, parent| Joint::new(name, parent, vec![hinge(name)]);
        let joints =
            vec![joint("opposing", 0), joint("spreading", 1), joint("bending", 2), joint("finger", 0)];
        let limbs = ["palm", "base", "knuckle", "thumb", "tip"].map(String::from).to_vec();
        let creature = Creature::new("hand".into(), limbs, joints, Vec::new()).unwrap();
        let mut schema = BodySchema::zero(&creature);
        schema.positions = vec![
            Vector3::new(-0.01, -0.02, 0.04),
            Vector3::new(-0.01, -0.004, 0.06),
            Vector3::new(0.0, 0.0, 0.01),
            Vector3::new(-0.013, 0.0, 0.11),
        ];
        schema.axes = vec![Vector3::z(), Vector3::x(), Vector3::y(), Vector3::y()];
        let mut set = TouchSet::default();
        let chain = Chain::between(&creature, 3, 4);
        for k in 0.. {
            if set.len() == 40 {
                break;
            }
            let [b, c, d] = [0.7, 1.1, 1.9].map(|by: f64| 0.6 * (by * k as f64).sin());
            let on_thumb =
                Vector3::new(0.01 * (0.3 * k as f64).cos(), 0.0, 0.04 + 0.01 * (0.9 * k as f64).sin());
            let on_tip = |a: f64| {
                let posture = [a, b, c, d];
                let frame =
                    |side: usize| ChainSide::new(&creature, &chain.sides[side], &posture).frame(&schema);
                frame(1).inverse_point(&frame(0).point(&on_thumb))
            };
            // Where the thumb is turned so that they meet in the plane in which the finger bends.
            let (mut low, mut high) = (-1.5, 1.5);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                let ends = [on_tip(middle).y, on_tip(low).y];
                if ends[0] * ends[1] > 0.0 { low = middle } else { high = middle }
            }
            if is_in_plane && on_tip(low).y.abs() > 1e-9 {
                continue;
            }
            let a = if is_in_plane { low } else { 0.8 * (2.3 * k as f64).sin() };
            let ends = [on_thumb, on_tip(a)].map(|position| Observation {
                position,
                covariance: Matrix3::identity() * 1e-8,
                receptor: 0,
            });
            set.push(&creature, LimbTouch { limbs: [3, 4], posture: &[a, b, c, d], ends });
        }
        (creature, schema, set)
    }

    #[test]
    fn two_fingers_that_meet_only_each_other_in_a_plane_tell_nothing_and_out_of_it_all() {
        for (is_in_plane, left) in [(true, 0), (false, 40)] {
            let (creature, schema, touches) = fingers(is_in_plane);
            assert!(touches.misfit(PointsMeet::Anyhow, &schema) < 1e-6);
            assert_eq!(without_twins(&creature, &touches, &schema, &[false; 4]).len(), left, "{is_in_plane}");
        }
    }
}
