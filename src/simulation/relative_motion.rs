//! How two limbs move against each other in one posture of a motion, and how long a gap stays open by that.

use nalgebra::Vector3;

use crate::kinematics::LimbMotion;

/// More than what rounding does to a gap, metres.
const ROUNDING: f64 = 1e-9;

/// How a limb moves against another that rests, as [`LimbMotion`] has it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Twist {
    pub omega: Vector3<f64>,
    pub velocity: Vector3<f64>,
}

impl Twist {
    /// Velocity of the limb's point that is at `p`.
    #[inline]
    pub fn velocity_at(&self, p: &Vector3<f64>) -> Vector3<f64> {
        self.velocity + self.omega.cross(p)
    }
}

/// How the two limbs of a pair move against their common ancestor.
#[derive(Clone, Copy, Debug)]
pub(super) struct PairMotion {
    pub sides: [Twist; 2],
    /// The ancestor's own angular velocity.
    pub ancestor_omega: Vector3<f64>,
}

impl PairMotion {
    /// Of two limbs and their ancestor, all in one frame.
    #[inline]
    pub fn new(limbs: [&LimbMotion; 2], ancestor: &LimbMotion) -> PairMotion {
        let sides = limbs.map(|limb| Twist {
            omega: limb.omega - ancestor.omega,
            velocity: limb.velocity - ancestor.velocity,
        });
        PairMotion { sides, ancestor_omega: ancestor.omega }
    }

    /// Velocity of a point of the first limb against one of the second.
    #[inline]
    pub fn relative_velocity(&self, points: &[Vector3<f64>; 2]) -> Vector3<f64> {
        self.sides[0].velocity_at(&points[0]) - self.sides[1].velocity_at(&points[1])
    }
}

/// Whether `gap + opening h − ½ acceleration h²`, which is not below zero at first, stays above it for longer than `time`.
#[inline]
pub(super) fn outlasts(gap: f64, opening: f64, acceleration: f64, time: f64) -> bool {
    gap + (opening - 0.5 * acceleration * time) * time > ROUNDING
}

/// The time for which `gap + opening h − ½ acceleration h²` stays above zero.
#[inline]
pub(super) fn until_zero(gap: f64, opening: f64, acceleration: f64) -> f64 {
    let root = (opening * opening + 2.0 * acceleration * gap).sqrt();
    if opening < 0.0 {
        2.0 * gap / (root - opening)
    } else if acceleration > 0.0 {
        (opening + root) / acceleration
    } else {
        f64::INFINITY
    }
}
