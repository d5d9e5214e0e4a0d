//! Which touches tell what those before them did not.
//!
//! Between two limbs the pose of one in the other's frame is linear in `1, cos θ, sin θ` of every hinge between them, in `1, s` of
//! every slide, and in a ball's rotation matrix: in the products of these, one of each joint. However many touches there are, an
//! answer need not meet more conditions than these products are independent in their postures: a finger that bends on one hinge
//! makes three, and any smooth curve explains the rest.

use nalgebra::DVector;

use crate::creature::{Creature, DofKind, ball};

/// Products beyond which touches are not compared: nobody makes so many touches of two limbs with the same joints moving.
const MOST_PRODUCTS: usize = 100;
/// A touch tells something new where its products are off by this share from all combinations of those before: an answer that meets
/// those by chance misses it by more than what counts as closed.
const NEW: f64 = 1e-3;

/// What touches of two limbs tell in which the same joints move.
#[derive(Clone, Debug, Default)]
pub(super) struct Conditions {
    /// How many told something new.
    pub count: usize,
    /// Their products, as orthonormal vectors.
    told: Vec<DVector<f64>>,
}

impl Conditions {
    /// Takes in a touch made in a posture with some joints moving; whether it tells something new.
    pub fn take(&mut self, creature: &Creature, moving: &[usize], posture: &[f64]) -> bool {
        let is_new = products(creature, moving, posture).is_none_or(|products| self.add(products));
        self.count += usize::from(is_new);
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

/// The products of a posture; `None` if they are very many.
fn products(creature: &Creature, moving: &[usize], posture: &[f64]) -> Option<DVector<f64>> {
    let mut products = vec![1.0];
    for at in moving.iter().flat_map(|&joint| creature.joints()[joint].elements()) {
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
        if products.len() * factors.len() > MOST_PRODUCTS {
            return None;
        }
        products = products.iter().flat_map(|one| factors.iter().map(move |other| one * other)).collect();
    }
    Some(DVector::from_vec(products))
}
