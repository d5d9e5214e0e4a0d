//! Postures in which a limb is where it is to be, place and orientation both: what is carried between two hands must not be
//! turned.

use nalgebra::Vector3;

use super::own_body::OwnBody;
use crate::creature::Posture;
use crate::geometry::Frame;
use crate::kinematics::Place;

/// Length that a radian of the limb's turn counts as, metres: half a hand's.
const TURN_LENGTH: f64 = 0.08;

/// A limb that is to be somewhere.
#[derive(Clone, Copy, Debug)]
pub struct LimbGoal {
    /// The limb.
    pub limb: usize,
    /// `X_LP`: a frame that is fixed to it.
    pub place: Frame,
    /// `X_RP`: where that is to be, in the root's frame.
    pub target: Frame,
}

/// A posture that brings a limb somewhere, as far as it can.
#[derive(Clone, Debug, PartialEq)]
pub struct LimbPosture {
    /// The posture, within the joints' ranges.
    pub posture: Posture,
    /// How far the place stays away, metres, …
    pub miss: f64,
    /// … and how far it stays turned, radians.
    pub turn: f64,
}

/// The posture from `start` on, moving some joints, in which a limb is where it is to be, in so many steps at the most; what
/// freedom is left draws it to `ease` where that is given.
pub fn limb_posture(
    own: &OwnBody,
    joints: &[usize],
    goal: &LimbGoal,
    start: &[f64],
    ease: Option<&[f64]>,
    steps: usize,
) -> LimbPosture {
    let free = Vector3::zeros();
    let place = Place { limb: goal.limb, point: goal.place.origin, direction: free };
    let mut solver = own
        .bringing(place, goal.target.origin, free, joints)
        .turned([goal.place.rotation, goal.target.rotation])
        .with_direction_lengths([TURN_LENGTH; 2])
        .with_steps([0, steps]);
    if let Some(ease) = ease {
        solver = solver.at_ease(ease);
    }
    let reach = solver.solve(start);
    LimbPosture { posture: reach.posture, miss: reach.miss, turn: reach.facing.clamp(-1.0, 1.0).acos() }
}
