//! Random numbers that are the same on every machine and with every version of the libraries.
//!
//! Only the raw numbers of ChaCha with eight rounds are taken: how they become lengths, counts and directions is written out
//! here. Nothing but the four operations and roots is used where a result decides what is drawn next, and what is written is
//! rounded to [`DIGITS`], so that the last bit of a system's `powf` changes nothing.

use nalgebra::{Unit, UnitQuaternion, Vector3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Significant digits of the numbers that are written.
const DIGITS: usize = 6;

/// A stream of random numbers.
pub struct Draw(ChaCha8Rng);

impl Draw {
    /// The stream of a seed.
    pub fn new(seed: u64) -> Draw {
        Draw(ChaCha8Rng::seed_from_u64(seed))
    }

    /// From 0 on and below 1.
    pub fn share(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (-53f64).exp2()
    }

    /// Uniform between two numbers.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    /// Uniform in its logarithm between two numbers above 0.
    pub fn log_between(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.share())
    }

    /// A whole number from `least` to `most`, both included.
    pub fn count(&mut self, least: usize, most: usize) -> usize {
        least + (self.share() * (most + 1 - least) as f64) as usize
    }

    /// Whether something with a probability happens.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.share() < probability
    }

    /// One of some choices, each as often as its weight says.
    pub fn weighted<T: Copy>(&mut self, choices: &[(T, f64)]) -> T {
        let all: f64 = choices.iter().map(|(_, weight)| weight).sum();
        let mut left = all * self.share();
        for (choice, weight) in choices {
            if left < *weight {
                return *choice;
            }
            left -= weight;
        }
        choices[choices.len() - 1].0
    }

    /// A direction, all alike.
    pub fn direction(&mut self) -> Vector3<f64> {
        loop {
            let v = Vector3::from_fn(|_, _| self.between(-1.0, 1.0));
            let square = v.norm_squared();
            if (1e-4..=1.0).contains(&square) {
                return v / square.sqrt();
            }
        }
    }

    /// A direction that is off another by no more than a share of the way to any direction at all: 0 is that direction.
    pub fn about(&mut self, axis: &Vector3<f64>, spread: f64) -> Vector3<f64> {
        loop {
            let v = axis + self.direction() * (spread * self.share());
            if let Some(unit) = Unit::try_new(v, 1e-3) {
                return unit.into_inner();
            }
        }
    }

    /// A turn about z, all alike.
    pub fn twist(&mut self) -> UnitQuaternion<f64> {
        let across = self.direction().xy();
        let half = if across.norm() < 1e-3 { nalgebra::Vector2::x() } else { across.normalize() };
        quaternion(half.x, Vector3::z() * half.y)
    }
}

/// The shortest turn that brings z to a direction.
pub fn z_to(direction: &Vector3<f64>) -> UnitQuaternion<f64> {
    // Where it points straight back any axis across it does.
    let w = 1.0 + direction.z;
    if w < 1e-6 { quaternion(0.0, Vector3::x()) } else { quaternion(w, Vector3::z().cross(direction)) }
}

/// The turn of a quaternion of any length.
pub fn quaternion(w: f64, xyz: Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(nalgebra::Quaternion::from_parts(w, xyz))
}

/// A number as it is written.
pub fn rounded(x: f64) -> f64 {
    // What cannot be read back is no number that a length, an angle or an axis has.
    format!("{x:.*e}", DIGITS - 1).parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_where_they_are_to_be() {
        let mut draw = Draw::new(1);
        for _ in 0..2000 {
            assert!((0.0..1.0).contains(&draw.share()));
            assert!((3..=5).contains(&draw.count(3, 5)));
            assert!((0.01..=10.0).contains(&draw.log_between(0.01, 10.0)));
            assert!((draw.direction().norm() - 1.0).abs() < 1e-12);
            let off = draw.about(&Vector3::z(), 0.1).cross(&Vector3::z()).norm();
            assert!(off <= 0.1, "{off}");
        }
        let counts: Vec<usize> = (0..300).map(|_| draw.count(1, 3)).collect();
        assert!((1..=3).all(|n| counts.iter().filter(|&&count| count == n).count() > 60));
    }

    #[test]
    fn a_turn_brings_z_where_it_is_to_point() {
        let mut draw = Draw::new(2);
        for _ in 0..100 {
            let to = draw.direction();
            assert!((z_to(&to) * Vector3::z() - to).norm() < 1e-9);
            assert!((draw.twist() * Vector3::z() - Vector3::z()).norm() < 1e-12);
        }
        assert!((z_to(&-Vector3::z()) * Vector3::z() + Vector3::z()).norm() < 1e-9);
    }

    #[test]
    fn numbers_are_rounded_to_six_digits() {
        assert_eq!([rounded(1.0 / 3.0), rounded(-123456.78), rounded(0.0)], [0.333333, -123457.0, 0.0]);
    }
}
