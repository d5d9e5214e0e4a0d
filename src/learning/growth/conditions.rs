//! Which touches tell what those before them did not.
//!
//! Between two limbs the pose of one in the other's frame is linear in `1, cos θ, sin θ` of every hinge between them, in `1, s` of
//! every slide, and in a ball's rotation matrix: in the products of these, one of each joint. However many touches there are, an
//! answer need not meet more conditions than these products are independent in their postures: a finger that bends on one hinge
//! makes three, and any smooth curve explains the rest.

use nalgebra::DVector;

use crate::creature::{DofElement, DofKind, ball};

/// Products beyond which touches are not compared: nobody makes so many touches of two limbs with the same joints moving.
const MOST_PRODUCTS: usize = 100;
/// A touch tells something new where its products are off by this share from all combinations of those before: an answer that meets
/// those by chance misses it by more than what counts as closed.
const NEW: f64 = 1e-3;

/// What touches of two limbs tell in which the same joints move.
#[derive(Clone, Debug, Default)]
pub(super) struct Conditions {
    /// How many touches there were, and how many of them told something new.
    pub touches: usize,
    pub new: usize,
    /// The products of these, as orthonormal vectors.
    told: Vec<DVector<f64>>,
}

impl Conditions {
    /// Takes in a touch in whose posture some elements of joints moved; whether it tells something new.
    pub fn take<'a>(
        &mut self,
        elements: impl Iterator<Item = DofElement<'a>> + Clone,
        posture: &[f64],
    ) -> bool {
        let is_new = most(elements.clone()) > MOST_PRODUCTS || self.add(products(elements, posture));
        self.touches += 1;
        self.new += usize::from(is_new);
        is_new
    }

    fn add(&mut self, products: DVector<f64>) -> bool {
        let size = products.norm();
        let mut left = products;
        // Twice, for rounding.
        for told in self.told.iter().chain(&self.told) {
            left.axpy(-told.dot(&left), told, 1.0);
        }
        let is_new = left.norm() > NEW * size;
        if is_new {
            self.told.push(left.normalize());
        }
        is_new
    }
}

/// How many conditions touches can make in which some elements of joints move: as many as these have products.
pub(super) fn most<'a>(elements: impl Iterator<Item = DofElement<'a>>) -> usize {
    let factors = |at: DofElement| match at.kind {
        DofKind::Hinge => 3,
        DofKind::Slide => 2,
        DofKind::Ball => 10,
    };
    elements.map(factors).fold(1, usize::saturating_mul)
}

/// The products of a posture.
fn products<'a>(elements: impl Iterator<Item = DofElement<'a>>, posture: &[f64]) -> DVector<f64> {
    let mut products = vec![1.0];
    for at in elements {
        let factors = match at.kind {
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
        };
        products = products.iter().flat_map(|one| factors.iter().map(move |other| one * other)).collect();
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
            conditions.take(creature.elements(), &posture);
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
        let told = found.told.clone();
        assert!(told.into_iter().all(|products| !found.add(products)));
        assert_eq!(found.told.len(), 5);
    }
}
