//! What is seen of a thing: the points of it that were nearest, how fast it came nearer there, and where it goes if it goes
//! on so.

use std::collections::VecDeque;

use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};

use crate::geometry::Capsule;
use crate::peripersonal::Obstacle;

/// How far its middle is taken to be behind the nearest point of a thing before more is seen, metres, …
const BEHIND: f64 = 0.035;
/// … give or take, and how far aside of there it may be, metres.
const MAYBE: [f64; 2] = [0.015, 0.03];
/// How far it is taken to reach about its middle at least, and at most, metres.
const GIRTHS: [f64; 2] = [0.05, 0.1];
/// How exact the planes are that what is seen lies behind, as planes of a ball, metres.
const ROUND: f64 = 0.003;
/// Looks from which the motion of a thing is told, at most and at least.
const LOOKS: [usize; 2] = [40, 4];
/// A leap of the nearest point from where it was expected is another point, not another motion, metres.
const LEAP: f64 = 0.004;
/// How exact the speed is at which a gap becomes less, and a velocity from where the nearest points were, which slide along
/// a thing's sides, metres a second.
const EXACT: [f64; 2] = [1e-3, 0.05];
/// Slower than this a thing does not approach, metres a second.
const SLOWEST: f64 = 0.02;
/// How far ahead a way is predicted, seconds, …
pub(super) const AHEAD: f64 = 1.4;
/// … and at least, metres.
const AT_LEAST: f64 = 0.5;

/// A look at a thing, in the root's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    /// Seconds.
    pub time: f64,
    /// Its nearest point, metres.
    pub nearest: Vector3<f64>,
    /// The unit direction to it from the skin: all of it is behind the plane there.
    pub toward: Vector3<f64>,
    /// How fast its own motion makes the gap less, metres a second.
    pub speed: f64,
}

/// What is seen of a thing.
#[derive(Clone, Debug, Default)]
pub(super) struct SeenThing {
    looks: VecDeque<Look>,
    /// Per look, by how much its nearest point is moved so that it is as of the same point of the thing as the last.
    leaps: VecDeque<Vector3<f64>>,
}

/// Where a thing is and where it goes, in the root's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct ThingCourse {
    pub middle: Vector3<f64>,
    pub velocity: Vector3<f64>,
    pub radius: f64,
}

impl SeenThing {
    /// Takes in what is seen.
    pub fn look(&mut self, look: Look) {
        if let Some((last, velocity)) = self.looks.back().zip(self.velocity()) {
            let leap = look.nearest - (last.nearest + velocity * (look.time - last.time));
            if leap.norm() > LEAP {
                self.leaps.iter_mut().for_each(|before| *before += leap);
            }
        }
        self.looks.push_back(look);
        self.leaps.push_back(Vector3::zeros());
        if self.looks.len() > LOOKS[0] {
            self.looks.pop_front();
            self.leaps.pop_front();
        }
    }

    /// Its velocity: along every direction that it was seen in it is as fast as the gap became less there; in other
    /// directions as its nearest points were.
    fn velocity(&self) -> Option<Vector3<f64>> {
        if self.looks.len() < LOOKS[1] {
            return None;
        }
        let count = self.looks.len() as f64;
        let places = || self.looks.iter().zip(&self.leaps).map(|(look, leap)| look.nearest + leap);
        let time = self.looks.iter().map(|look| look.time).sum::<f64>() / count;
        let place = places().sum::<Vector3<f64>>() / count;
        let spread: f64 = self.looks.iter().map(|look| (look.time - time).powi(2)).sum();
        let slope: Vector3<f64> =
            self.looks.iter().zip(places()).map(|(look, p)| (p - place) * (look.time - time)).sum();
        let slope = slope / spread.max(f64::MIN_POSITIVE);
        let [exact, rough] = EXACT.map(|deviation| 1.0 / (deviation * deviation));
        let mut normal = Matrix3::identity() * rough;
        let mut right = slope * rough;
        for look in &self.looks {
            normal.ger(exact, &look.toward, &look.toward, 1.0);
            right -= look.toward * (look.speed * exact);
        }
        normal.cholesky().map(|factor| factor.solve(&right))
    }

    /// Where it is and goes: a ball that touches the planes that it was seen to be behind.
    pub fn course(&self) -> Option<ThingCourse> {
        let velocity = self.velocity()?;
        let last = self.looks.back()?;
        let since = |look: &Look| look.nearest + velocity * (last.time - look.time);
        let guess = last.nearest + last.toward * BEHIND;
        // Unknown are the middle, from the guess, and the radius, from how far that is behind.
        let [round, radial, aside] =
            [ROUND, MAYBE[0], MAYBE[1]].map(|deviation| 1.0 / (deviation * deviation));
        let mut normal = Matrix4::from_diagonal(&Vector4::new(aside, aside, aside, radial));
        let mut right = Vector4::zeros();
        for look in &self.looks {
            let row = Vector4::new(look.toward.x, look.toward.y, look.toward.z, -1.0);
            let off = look.toward.dot(&(since(look) - guess)) + BEHIND;
            normal.ger(round, &row, &row, 1.0);
            right += row * (off * round);
        }
        let found = normal.cholesky()?.solve(&right);
        let middle = guess + found.fixed_rows::<3>(0);
        let reach = self.looks.iter().map(|look| (since(look) - middle).norm());
        let radius = reach.fold(GIRTHS[0], f64::max).min(GIRTHS[1]);
        (velocity.norm() > SLOWEST).then_some(ThingCourse { middle, velocity, radius })
    }
}

impl ThingCourse {
    /// All that it passes from one time to another, seconds from now, where it reaches so far about its middle.
    pub fn swept(&self, from: f64, until: f64, radius: f64) -> Obstacle {
        let ends = [from, until].map(|seconds| self.middle + self.velocity * seconds);
        Obstacle::Capsule(Capsule { ends, radius })
    }

    /// How far ahead it is predicted, seconds.
    pub fn ahead(&self) -> f64 {
        AHEAD.max(AT_LEAST / self.velocity.norm())
    }
}
