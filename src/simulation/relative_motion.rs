//! How two limbs move against each other in one posture of a motion, and how long they stay apart by that, to second order.
//!
//! A plane that keeps them apart has a unit normal `n` that leads from the second geom to the first and moves with the
//! limbs' common ancestor. A point at `p` that moves at `v` is at the height `n · (p + v h)` over it after a time `h`, but
//! for ½ `acceleration` `h²`.

use nalgebra::Vector3;

use crate::geometry::{Capsule, ConvexBody};
use crate::kinematics::{LimbMotion, Twist};

/// More than what rounding does to a gap, metres.
const ROUNDING: f64 = 1e-9;
/// A time that is known to within this share of itself is not looked at more closely.
const CLOSE: f64 = 0.05;
/// Most looks at one plane.
const LOOKS: usize = 4;

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
        let sides = limbs.map(|limb| limb.twist - ancestor.twist);
        PairMotion { sides, ancestor_omega: ancestor.twist.angular }
    }

    /// Velocity of a point of the first limb against one of the second.
    #[inline]
    pub fn relative_velocity(&self, points: &[Vector3<f64>; 2]) -> Vector3<f64> {
        self.sides[0].at(&points[0]) - self.sides[1].at(&points[1])
    }

    /// How long a plane of normal `n` keeps two capsules apart; where it is `heeded` or more, anything from there on.
    #[inline]
    pub fn keeps_capsules_apart(
        &self,
        capsules: [&Capsule; 2],
        n: &Vector3<f64>,
        acceleration: f64,
        heeded: f64,
    ) -> f64 {
        let mut height = [[0.0; 2]; 2];
        let mut rate = [[0.0; 2]; 2];
        for side in 0..2 {
            let sign = if side == 0 { 1.0 } else { -1.0 };
            let Capsule { ends, radius } = capsules[side];
            for (end, p) in ends.iter().enumerate() {
                height[side][end] = sign * n.dot(p) - radius;
                rate[side][end] = sign * n.dot(&self.sides[side].at(p));
            }
        }
        let mut least = f64::INFINITY;
        for first in 0..2 {
            for second in 0..2 {
                let gap = (height[0][first] + height[1][second]).max(0.0);
                let opening = rate[0][first] + rate[1][second];
                let known = least.min(heeded);
                // A multiplication tells what is later than what is known, without a root.
                if !outlasts(gap, opening, acceleration, known) {
                    least = least.min(until_zero(gap, opening, acceleration));
                }
            }
        }
        least
    }

    /// How long a plane of normal `n` keeps two convex bodies apart, or nearly as long, up to `heeded`; 0 where it does not.
    ///
    /// The gap over time, `f(h) = min over all points of n · (p + v h) − ½ acceleration h²`, is concave: where a tangent falls
    /// to zero it has done so before, and a chord that begins where it is above zero is below it.
    pub fn keeps_bodies_apart(
        &self,
        bodies: [&dyn ConvexBody; 2],
        n: &Vector3<f64>,
        acceleration: f64,
        heeded: f64,
    ) -> f64 {
        // The least gap after a time, without the acceleration, and how fast the points that it is between open it.
        let at = |time: f64| {
            let (mut gap, mut opening) = (0.0, 0.0);
            for (side, n) in [*n, -n].iter().enumerate() {
                let twist: &Twist = &self.sides[side];
                // n · (ω × p) = p · (n × ω): points turn as if the normal turned against them.
                let turned = n + n.cross(&twist.angular) * time;
                let p = bodies[side].support(&-turned);
                gap += turned.dot(&p) + n.dot(&twist.linear) * time;
                opening += n.dot(&twist.at(&p));
            }
            (gap, opening)
        };
        let (gap, opening) = at(0.0);
        if gap <= 0.0 {
            return 0.0;
        }
        let (mut sure, mut late) = (0.0f64, until_zero(gap, opening, acceleration).min(heeded.min(1.0)));
        for _ in 0..LOOKS {
            let (then, opening) = at(late);
            let bent = then - 0.5 * acceleration * late * late;
            if bent >= 0.0 {
                return late;
            }
            sure = sure.max(late * gap / (gap - bent));
            late = late.min(until_zero((then - opening * late).max(0.0), opening, acceleration));
            if sure >= (1.0 - CLOSE) * late {
                break;
            }
        }
        sure
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Frame, PlacedShape, Shape};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// All corners of two boxes are on their sides of the plane until then, and not much longer.
    #[test]
    fn no_corner_crosses_the_plane_before_and_one_soon_after() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut vector = |far: f64| Vector3::from_fn(|_, _| rng.random_range(-far..far));
        let half = Vector3::new(0.1, 0.02, 0.2);
        let boxed = Shape::Box { half_extents: half.into() };
        let mut ended = 0;
        for trial in 0..500 {
            let frames = [0.3, -0.3].map(|x| Frame {
                rotation: nalgebra::Rotation3::new(vector(3.0)).into_inner(),
                origin: Vector3::new(x, 0.0, 0.0) + vector(0.02),
            });
            let placed = frames.map(|frame| PlacedShape::new(&boxed, Frame::identity(), frame).unwrap());
            let sides = [0, 1].map(|_| Twist { angular: vector(2.0), linear: vector(1.0) });
            let motion = PairMotion { sides, ancestor_omega: Vector3::zeros() };
            let (n, acceleration) = ((Vector3::x() + vector(0.2)).normalize(), [0.0, 3.0][trial % 2]);
            let gap = |time: f64| {
                let height = |side: usize, sign: f64| {
                    let corners = (0..8).map(|k| {
                        let sign = |bit: usize| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
                        let corner = half.component_mul(&Vector3::new(sign(0), sign(1), sign(2)));
                        frames[side].point(&corner)
                    });
                    let heights = corners.map(|p| sign * n.dot(&(p + sides[side].at(&p) * time)));
                    heights.fold(f64::INFINITY, f64::min)
                };
                height(0, 1.0) + height(1, -1.0) - 0.5 * acceleration * time * time
            };
            let time = motion.keeps_bodies_apart([&placed[0], &placed[1]], &n, acceleration, f64::INFINITY);
            assert!((0..=50).all(|k| gap(time * k as f64 / 50.0) > -1e-12), "{trial}");
            if time < 1.0 && gap(0.0) > 0.0 {
                ended += 1;
                assert!(gap(1.2 * time) < 0.0, "{trial}: {time}");
            }
            // What is heeded up to a time is not told beyond it.
            assert!(motion.keeps_bodies_apart([&placed[0], &placed[1]], &n, acceleration, 0.01) <= 0.01);
        }
        assert!(ended > 100, "{ended} times are short of the whole motion");
    }
}
