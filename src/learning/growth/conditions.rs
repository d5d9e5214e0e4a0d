//! Which touches are conditions of their own for an answer.
//!
//! The pose of one limb in another's frame is linear in `1, cos θ, sin θ` of every hinge between them, in `1, s` of every slide, and
//! in a ball's rotation matrix: in the products of these factors, one of each joint. However many touches there are, an answer meets
//! no more conditions than these products are independent in their postures: a finger that bends on one hinge makes three, and any
//! smooth curve explains the rest.

use nalgebra::DVector;

use crate::creature::{DofElement, DofKind, ball};

/// Products beyond which touches are not compared: nobody makes so many touches of two limbs with the same joints moving.
const MOST_PRODUCTS: usize = 100;
/// The conditions that touches make of which one coordinate moves, of a hinge or a slide, at the most.
pub(super) const OF_ONE_COORDINATE: usize = 3;
/// The least share by which a touch's products differ from all combinations of those before for a new condition: an answer that
/// meets those by chance then misses it by more than what counts as closed.
const NEW: f64 = 1e-3;

/// The conditions that touches of two limbs make in which the same joints move.
#[derive(Clone, Debug, Default)]
pub(super) struct Conditions {
    /// How many touches there were, and how many of them made a new condition.
    pub touches: usize,
    pub new: usize,
    /// The products of these, as orthonormal vectors.
    products: Vec<DVector<f64>>,
}

impl Conditions {
    /// Takes in a touch by the factors of its posture; whether it makes a new condition.
    pub fn take(&mut self, factors: &[Vec<f64>]) -> bool {
        let is_new = most(factors.iter().map(Vec::len)) > MOST_PRODUCTS || self.add(products(factors));
        self.touches += 1;
        self.new += usize::from(is_new);
        is_new
    }

    fn add(&mut self, products: DVector<f64>) -> bool {
        let size = products.norm();
        let mut left = products;
        // Twice, for rounding.
        for before in self.products.iter().chain(&self.products) {
            left.axpy(-before.dot(&left), before, 1.0);
        }
        let is_new = left.norm() > NEW * size;
        if is_new {
            self.products.push(left.normalize());
        }
        is_new
    }
}

/// The factors of an element of a joint in a posture.
pub(super) fn factors(at: DofElement, posture: &[f64]) -> Vec<f64> {
    match at.kind {
        DofKind::Hinge => {
            let (sine, cosine) = at.of(posture)[0].sin_cos();
            vec![1.0, cosine, sine]
        }
        DofKind::Slide => {
            let range = at.range[0].abs().max(at.range[1].abs()).max(f64::MIN_POSITIVE);
            vec![1.0, at.of(posture)[0] / range]
        }
        DofKind::Ball => {
            let turned = ball(at.of(posture)).to_rotation_matrix();
            std::iter::once(1.0).chain(turned.matrix().iter().copied()).collect()
        }
    }
}

/// How many conditions touches can make of which each element that moves has so many factors: as many as there are products.
pub(super) fn most(factors: impl Iterator<Item = usize>) -> usize {
    factors.fold(1, usize::saturating_mul)
}

/// The products of factors, one of each element.
fn products(factors: &[Vec<f64>]) -> DVector<f64> {
    let mut products = vec![1.0];
    for own in factors {
        products = products.iter().flat_map(|one| own.iter().map(move |other| one * other)).collect();
    }
    DVector::from_vec(products)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::creature::{Creature, Dof, Joint};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// How many conditions random touches make between the ends of a chain of joints of some kinds.
    fn conditions(kinds: &[DofKind], touches: usize) -> Conditions {
        let range = |kind| if kind == DofKind::Slide { [-0.1, 0.1] } else { [-1.0, 1.0] };
        let joint = |(parent, &kind): (usize, &DofKind)| {
            let dof = Dof { name: format!("dof{parent}"), kind, range: range(kind), follows: None };
            Joint::new(format!("joint{parent}"), parent, vec![dof])
        };
        let joints = kinds.iter().enumerate().map(joint).collect();
        let limbs = (0..=kinds.len()).map(|limb| format!("limb{limb}")).collect();
        let creature = Creature::new("chain".into(), limbs, joints, Vec::new()).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut conditions = Conditions::default();
        for _ in 0..touches {
            let posture: Vec<f64> =
                kinds.iter().map(|kind| rng.random_range(range(*kind)[0]..range(*kind)[1])).collect();
            let factors: Vec<Vec<f64>> = creature.elements().map(|at| factors(at, &posture)).collect();
            let count = |kind: &DofKind| match kind {
                DofKind::Hinge => 3,
                DofKind::Slide => 2,
                DofKind::Ball => 10,
            };
            assert!(factors.iter().zip(kinds).all(|(factors, kind)| factors.len() == count(kind)));
            conditions.take(&factors);
        }
        conditions
    }

    #[test]
    fn touches_make_no_more_conditions_than_their_joints_have_products() {
        use DofKind::{Hinge, Slide};
        for (kinds, products) in [(&[Hinge][..], 3), (&[Slide], 2), (&[Hinge, Slide], 6), (&[Hinge; 3], 27)] {
            let found = conditions(kinds, 200);
            assert_eq!((found.touches, found.new), (200, products), "{kinds:?}");
        }
        // Of many joints every touch is a condition of its own.
        assert_eq!(conditions(&[Hinge; 5], 200).new, 200);
    }

    #[test]
    fn the_same_posture_is_no_new_condition() {
        let creature_of_one = &[DofKind::Hinge; 4];
        let mut found = conditions(creature_of_one, 5);
        let before = found.products.clone();
        assert!(before.into_iter().all(|products| !found.add(products)));
        assert_eq!(found.products.len(), 5);
    }
}
