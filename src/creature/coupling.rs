//! Joints that follow others: a robot's fingers on one tendon, a mimic joint.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::names::joint_name;
use super::{Creature, Dof};
use crate::error::Error;
use crate::mujoco::{Equality, Model};

/// Places at which a leader's range is tried against its follower's.
const TRIALS: usize = 1000;

/// How a degree of freedom follows another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub struct Coupling {
    /// Index of the degree of freedom that it follows, a hinge or a slide.
    pub leader: usize,
    /// Coefficients of degree 0 to 4 that give its own coordinate from the leader's, radians and metres.
    pub polynomial: [f64; 5],
}

impl Coupling {
    /// The follower's coordinate for the leader's.
    pub fn follow(&self, leader: f64) -> f64 {
        value(&self.polynomial, leader)
    }

    /// How much the follower's coordinate changes for a unit of the leader's.
    pub fn rate(&self, leader: f64) -> f64 {
        let [_, a, b, c, d] = self.polynomial;
        value(&[a, 2.0 * b, 3.0 * c, 4.0 * d], leader)
    }
}

/// Puts the model's joint couplings into its degrees of freedom. `dof_of_joint` says which degree of freedom a
/// MuJoCo joint is, and `reference` where a joint stands that is none, counted from the reference posture.
///
/// What follows a joint that stands still stands still as well; what follows a follower follows that one's leader. A
/// leader's range ends where its follower's does.
///
/// # Errors
/// Where joints follow each other in a circle, or one follows another by too high a power.
pub(super) fn couple(
    model: &Model,
    dofs: &mut [&mut Dof],
    dof_of_joint: &[Option<usize>],
    reference: impl Fn(usize) -> f64,
) -> Result<(), Error> {
    let (name, couplings) = (|joint: usize| joint_name(model, joint), joint_couplings(model));
    for (&joint, &(mut leader, own)) in &couplings {
        let Some(follower) = dof_of_joint[joint] else { continue };
        let (mut polynomial, mut way) = (own.to_vec(), vec![joint]);
        while let Some(on) = leader
            && dof_of_joint[on].is_some()
            && let Some((next, outer)) = couplings.get(&on)
        {
            if let Some(start) = way.iter().position(|&passed| passed == on) {
                let joints: Vec<String> = way[start..].iter().map(|&joint| name(joint)).collect();
                return Err(Error::model(format!(
                    "joints {} follow each other in a loop: remove one of their <joint> entries in <equality>",
                    joints.join(", ")
                )));
            }
            way.push(on);
            polynomial = composed(&polynomial, outer);
            leader = *next;
        }
        let Some((moving, leading)) = leader.and_then(|on| Some((on, dof_of_joint[on]?))) else {
            let place = value(&polynomial, leader.map_or(0.0, &reference));
            dofs[follower].range = [place; 2];
            continue;
        };
        let degree = polynomial.iter().rposition(|&coefficient| coefficient != 0.0).unwrap_or(0);
        if degree >= own.len() {
            let (joint, leader) = (name(joint), name(moving));
            return Err(Error::model(format!(
                "joint {joint} follows {leader} through others by a polynomial of degree {degree}, but 4 is the \
                 maximum: let it follow {leader} directly"
            )));
        }
        let mut coupling = Coupling { leader: leading, polynomial: own };
        coupling
            .polynomial
            .iter_mut()
            .enumerate()
            .for_each(|(k, c)| *c = polynomial.get(k).copied().unwrap_or(0.0));
        let [low, high] = dofs[follower].range;
        let slack = 1e-9 * (1.0 + high - low);
        let within = |x: f64| (low - slack..=high + slack).contains(&coupling.follow(x));
        if let Some(range) = longest(dofs[leading].range, within) {
            dofs[leading].range = range;
        }
        dofs[follower].follows = Some(coupling);
    }
    Ok(())
}

/// The joints that a model couples: which other one each follows, if any, and by which polynomial. Of several couplings of a
/// joint the first counts.
pub(crate) fn joint_couplings(model: &Model) -> BTreeMap<usize, (Option<usize>, [f64; 5])> {
    let mut couplings = BTreeMap::new();
    for equality in model.equalities() {
        if let Equality::Joint { follower, leader, polynomial } = equality {
            couplings.entry(follower).or_insert((leader.filter(|leader| *leader != follower), polynomial));
        }
    }
    couplings
}

/// The value of a polynomial by its coefficients, the constant first.
fn value(polynomial: &[f64], x: f64) -> f64 {
    polynomial.iter().rev().fold(0.0, |value, coefficient| value * x + coefficient)
}

/// The polynomial that is `outer` of a number put into `inner`'s variable: Horner's rule over polynomials.
fn composed(inner: &[f64], outer: &[f64]) -> Vec<f64> {
    inner.iter().rev().fold(vec![0.0], |sum, coefficient| {
        let mut product = vec![0.0; sum.len() + outer.len() - 1];
        for (i, a) in sum.iter().enumerate() {
            outer.iter().enumerate().for_each(|(k, b)| product[i + k] += a * b);
        }
        product[0] += coefficient;
        while product.len() > 1 && product.last() == Some(&0.0) {
            product.pop();
        }
        product
    })
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
