//! What is seen of a thing: the points of it that were nearest, and where it goes if it goes on so.

use std::collections::VecDeque;

use nalgebra::Vector3;

use super::AHEAD;
use crate::geometry::Capsule;
use crate::peripersonal::Obstacle;

/// How far its middle is taken to be behind the nearest point of a thing, metres …
const BEHIND: f64 = 0.035;
/// … and how far it is taken to reach about that at least …
const GIRTH: f64 = 0.05;
/// … and at most, metres.
const GREATEST: f64 = 0.1;
/// Looks from which the motion of a thing is told, at most and at least.
const LOOKS: [usize; 2] = [30, 4];
/// A leap of the nearest point from where it was expected is another point, not another motion, metres.
const LEAP: f64 = 0.006;
/// Slower than this a thing does not approach, metres a second.
const SLOWEST: f64 = 0.02;
const AT_LEAST: f64 = 0.5;

/// What is seen of a thing.
#[derive(Clone, Debug, Default)]
pub(super) struct SeenThing {
    /// When and where its middle is taken to have been.
    middles: VecDeque<(f64, Vector3<f64>)>,
    /// When and where its nearest points were.
    outline: VecDeque<(f64, Vector3<f64>)>,
}

/// Where a thing is and where it goes, in the root's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct ThingCourse {
    pub middle: Vector3<f64>,
    pub velocity: Vector3<f64>,
    pub radius: f64,
}

impl SeenThing {
    /// Takes in where the nearest point is, and the unit direction to it from the skin.
    pub fn look(&mut self, time: f64, nearest: Vector3<f64>, toward: Vector3<f64>) {
        let middle = nearest + toward * BEHIND;
        let expected = self.motion().map(|(at, when, velocity)| at + velocity * (time - when));
        if let Some(leap) = expected.map(|expected| middle - expected)
            && leap.norm() > LEAP
        {
            self.middles.iter_mut().for_each(|(_, before)| *before += leap);
        }
        self.middles.push_back((time, middle));
        self.outline.push_back((time, nearest));
        if self.middles.len() > LOOKS[0] {
            self.middles.pop_front();
            self.outline.pop_front();
        }
    }

    /// The line that fits what was seen best: where the middle is at the last look, when that was, and its velocity.
    fn motion(&self) -> Option<(Vector3<f64>, f64, Vector3<f64>)> {
        if self.middles.len() < LOOKS[1] {
            return None;
        }
        let count = self.middles.len() as f64;
        let time = self.middles.iter().map(|(time, _)| time).sum::<f64>() / count;
        let place = self.middles.iter().map(|(_, place)| place).sum::<Vector3<f64>>() / count;
        let spread: f64 = self.middles.iter().map(|(t, _)| (t - time).powi(2)).sum();
        let slope: Vector3<f64> = self.middles.iter().map(|(t, p)| (p - place) * (t - time)).sum();
        let velocity = slope / spread.max(f64::MIN_POSITIVE);
        let last = self.middles.back()?.0;
        Some((place + velocity * (last - time), last, velocity))
    }

    pub fn course(&self) -> Option<ThingCourse> {
        let (middle, now, velocity) = self.motion()?;
        // All points of it that were seen, as they have gone on since.
        let reach = self.outline.iter().map(|(time, p)| (p + velocity * (now - time) - middle).norm());
        let radius = reach.fold(GIRTH, f64::max).min(GREATEST);
        (velocity.norm() > SLOWEST).then_some(ThingCourse { middle, velocity, radius })
    }
}

impl ThingCourse {
    /// Where it is from one time on, seconds from now, until it has gone as far as is predicted.
    pub fn swept(&self, from: f64, until: f64, radius: f64) -> Obstacle {
        let ends = [from, until].map(|seconds| self.middle + self.velocity * seconds);
        Obstacle::Capsule(Capsule { ends, radius })
    }

    /// How far ahead it is predicted, seconds.
    pub fn ahead(&self) -> f64 {
        AHEAD.max(AT_LEAST / self.velocity.norm())
    }
}
