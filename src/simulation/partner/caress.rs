//! Long random strokes one after the other: how a skin is stroked all over.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::stimulation::{STEP, SkinPoint, Strokes, TRIES, evened_out};
use crate::error::Error;
use crate::senses::{SkinContact, TouchEvent};
use crate::simulation::{ProbePath, STIFFNESS, Stage, StepSenses};

/// Lengths of the way, metres: a caress is over sooner where there is no room to go on.
const LENGTH: [f64; 2] = [0.05, 0.7];
/// Speeds over the skin, metres a second.
const SPEED: [f64; 2] = [0.2, 0.5];
/// Forces, newtons.
const FORCE: [f64; 2] = [0.5, 2.0];
/// How far the way turns in each of its steps, radians, one standard deviation.
const TURN: f64 = 0.02;
/// Directions tried where the way comes to a fold.
const WAYS_ON: usize = 8;
/// From how far above the skin the probe comes, metres, and how far it keeps from other limbs then.
const ABOVE: f64 = 0.02;
const CLEAR: f64 = 0.001;
/// Times from there to the skin, and back, seconds.
const DOWN: f64 = 0.1;
const UP: f64 = 0.05;

impl Strokes<'_> {
    /// The path of a long random stroke, setting out at `time`: a receptor is drawn, then a place on it, a direction, a length,
    /// a speed and a force; from there the probe wanders over the skin, round edges, over joints and away from folds. `None` if
    /// there is no room on any receptor.
    fn caress(&self, time: f64, rng: &mut ChaCha8Rng) -> Option<ProbePath> {
        let receptors = self.skin.receptors.len();
        (0..TRIES).find_map(|_| {
            let way = self.wander((receptors > 0).then(|| rng.random_range(0..receptors))?, rng)?;
            let depth = rng.random_range(FORCE[0]..FORCE[1]) / STIFFNESS;
            let speed = rng.random_range(SPEED[0]..SPEED[1]);
            let mut now = time + DOWN;
            let mut path = vec![(time, way[0].at(ABOVE)), (now, way[0].at(-depth))];
            for pair in evened_out(&way).windows(2) {
                // Where the way turns on the spot it takes its time nevertheless.
                now += (pair[1].middle - pair[0].middle).norm().max(0.1 * STEP) / speed;
                path.push((now, pair[1].at(-depth)));
            }
            path.push((now + UP, way[way.len() - 1].at(ABOVE)));
            Some(ProbePath(path))
        })
    }

    /// A long way that begins on a receptor. `None` if there is no room for it.
    fn wander(&self, receptor: usize, rng: &mut ChaCha8Rng) -> Option<Vec<SkinPoint>> {
        let p_l = self.place_on(receptor, 1.0, rng);
        let receptor = &self.skin.receptors[receptor];
        let frame = &self.frames[receptor.limb];
        let can_leave = |spot: &SkinPoint| self.can_come(&[spot.limb], spot, ABOVE, CLEAR);
        let start = self.onto(&[receptor.limb], &frame.point(&p_l)).filter(can_leave)?;
        let mut along =
            turned(&(frame.rotation * receptor.tangent), &start.normal, rng.random_range(0.0..TAU));
        let mut way = vec![start];
        let steps = (rng.random_range(LENGTH[0]..LENGTH[1]) / STEP) as usize;
        while way.len() < steps {
            let spot = way[way.len() - 1];
            let on = self.joined(spot.limb);
            let turn: f64 = rng.sample(StandardNormal);
            let mut angle = TURN * turn;
            let found = (0..WAYS_ON).find_map(|_| {
                let along = turned(&along, &spot.normal, angle);
                angle = rng.random_range(0.0..TAU);
                let room = |next: &SkinPoint| self.has_room(&on, &next.middle, 0.0);
                Some((self.next(&on, &spot, &along).filter(room)?, along))
            });
            let Some((next, heading)) = found else { break };
            along = next.along(&heading)?;
            way.push(next);
        }
        // The probe leaves the skin where it can.
        while way.last().is_some_and(|spot| !can_leave(spot)) {
            way.pop();
        }
        (way.len() >= (LENGTH[0] / STEP) as usize / 2).then_some(way)
    }
}

/// A direction along the skin, turned about the skin's normal.
fn turned(along: &Vector3<f64>, normal: &Vector3<f64>, angle: f64) -> Vector3<f64> {
    along * angle.cos() + normal.cross(along) * angle.sin()
}

/// Strokes the creature with the stage's first probe for so many simulated seconds, and lets `each` take in the
/// contacts and the touches of every step. Says whether there is room to stroke it.
///
/// # Errors
/// Where the engine fails, or `each`.
pub fn stroke_for<E: From<Error>>(
    stage: &Stage,
    seconds: f64,
    rng: &mut ChaCha8Rng,
    mut each: impl FnMut(&Stage, f64, &[SkinContact], Vec<TouchEvent>) -> Result<(), E>,
) -> Result<bool, E> {
    let until = stage.time() + seconds;
    while stage.time() < until {
        let Some(path) = Strokes::new(stage).caress(stage.time(), rng) else { return Ok(false) };
        let end = path.end().min(until);
        stage.send_probe(0, path)?;
        while stage.time() < end {
            let StepSenses { time, contacts, touches, .. } = stage.step()?;
            each(stage, time, &contacts, touches)?;
        }
    }
    Ok(true)
}
