//! Joints that follow others: a robot's fingers on one tendon, a mimic joint.

use serde::{Deserialize, Serialize};

use super::{Creature, Dof};
use crate::mujoco::{Equality, Model};

/// Places at which a leader's range is tried against its follower's.
const TRIALS: usize = 1000;

/// How a degree of freedom follows another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coupling {
    /// Index of the degree of freedom that it follows, a hinge or a slide.
    pub leader: usize,
    /// Coefficients of degree 0 to 4 that give its own coordinate from the leader's, radians and metres.
    pub polynomial: [f64; 5],
}

impl Coupling {
    /// The follower's coordinate for the leader's.
    pub fn follow(&self, leader: f64) -> f64 {
        self.polynomial.iter().rev().fold(0.0, |value, coefficient| value * leader + coefficient)
    }
}

/// Puts the model's joint couplings into its degrees of freedom. `dof_of_joint` says which degree of freedom a
/// MuJoCo joint is, and `reference` where a joint stands that is none, counted from the reference posture.
///
/// What follows a joint that stands still stands still as well; a leader's range ends where its follower's does.
pub(super) fn couple(
    model: &Model,
    dofs: &mut [&mut Dof],
    dof_of_joint: &[Option<usize>],
    reference: impl Fn(usize) -> f64,
) {
    for equality in model.equalities() {
        let Equality::Joint { follower, leader, polynomial } = equality else { continue };
        let Some(follower) = dof_of_joint[follower] else { continue };
        let moving = leader.and_then(|leader| dof_of_joint[leader]).filter(|&leader| leader != follower);
        let coupling = Coupling { leader: moving.unwrap_or(0), polynomial };
        let Some(leader) = moving else {
            let place = coupling.follow(leader.map_or(0.0, &reference));
            dofs[follower].range = [place; 2];
            continue;
        };
        // A chain of followers would have to be resolved in its order, and a circle not at all.
        if dofs[leader].follows.is_some() || dofs[follower].follows.is_some() {
            continue;
        }
        let [low, high] = dofs[follower].range;
        let slack = 1e-9 * (1.0 + high - low);
        let within = |x: f64| (low - slack..=high + slack).contains(&coupling.follow(x));
        if let Some(range) = longest(dofs[leader].range, within) {
            dofs[leader].range = range;
        }
        dofs[follower].follows = Some(coupling);
    }
}

/// The longest stretch of a range in which a condition holds, to a thousandth of it.
fn longest([low, high]: [f64; 2], holds: impl Fn(f64) -> bool) -> Option<[f64; 2]> {
    let place = |k: usize| low + (high - low) * k as f64 / TRIALS as f64;
    let (mut best, mut from) = (None, None);
    for k in 0..=TRIALS {
        if !holds(place(k)) {
            from = None;
            continue;
        }
        let start = *from.get_or_insert(k);
        if best.is_none_or(|(a, b)| k - start > b - a) {
            best = Some((start, k));
        }
    }
    best.map(|(a, b)| [place(a), place(b)])
}

impl Creature {
    /// Puts every follower of a posture where its leader has it.
    pub fn couple(&self, posture: &mut [f64]) {
        if self.dofs().all(|dof| dof.follows.is_none()) {
            return;
        }
        let places: Vec<usize> = self.elements().map(|element| element.coordinate()).collect();
        for at in self.elements().filter(|at| !at.is_ball()) {
            if let Some(coupling) = at.follows {
                let followed = coupling.follow(posture[places[coupling.leader]]);
                posture[at.coordinate()] = followed.clamp(at.range[0], at.range[1]);
            }
        }
    }
}
