//! Long random strokes one after the other: how a skin is stroked all over.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::stimulation::{STEP, SkinPoint, Stimulation, Strokes, TRIES, evened_out};
use crate::error::Error;
use crate::senses::{SkinContact, TouchEvent, TouchKind};
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
    /// A long random stroke, setting out at `time`: a receptor is drawn, then a place on it, a direction, a length, a
    /// speed and a force; from there the probe wanders over the skin, round edges, over joints
    /// and away from folds. None
    /// where there is no room on any receptor.
    pub fn caress(&self, time: f64, rng: &mut ChaCha8Rng) -> Option<Stimulation> {
        let receptors = self.skin.receptors.len();
        if receptors == 0 {
            return None;
        }
        (0..TRIES).find_map(|_| self.wander(rng.random_range(0..receptors), time, rng))
    }

    /// A caress that begins on a receptor; none where there is no room.
    fn wander(&self, receptor: usize, time: f64, rng: &mut ChaCha8Rng) -> Option<Stimulation> {
        let receptor = &self.skin.receptors[receptor];
        let limb = receptor.limb;
        let [a, b] = receptor.half_extents.map(|half| half * rng.random_range(-1.0..1.0));
        let p_l = receptor.position + receptor.tangent * a + receptor.bitangent() * b;
        let frame = &self.frames[limb];
        let can_leave = |spot: &SkinPoint| self.is_free(&[spot.limb], spot, ABOVE, CLEAR);
        let start = self.onto(&[limb], &frame.point(&p_l)).filter(can_leave)?;
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
                let next = self.next(&on, &spot, &along).filter(room)?;
                Some((next, along))
            });
            let Some((next, heading)) = found else { break };
            along = (heading - next.normal * heading.dot(&next.normal)).try_normalize(1e-6)?;
            way.push(next);
        }
        // The probe leaves the skin where it can.
        while way.last().is_some_and(|spot| !can_leave(spot)) {
            way.pop();
        }
        if way.len() < (LENGTH[0] / STEP) as usize / 2 {
            return None;
        }
        let force = rng.random_range(FORCE[0]..FORCE[1]);
        let speed = rng.random_range(SPEED[0]..SPEED[1]);
        let depth = force / STIFFNESS;
        let mut now = time + DOWN;
        let mut path = vec![(time, way[0].at(ABOVE)), (now, way[0].at(-depth))];
        for pair in evened_out(&way).windows(2) {
            // Where the way turns on the spot it takes its time nevertheless.
            now += (pair[1].middle - pair[0].middle).norm().max(0.1 * STEP) / speed;
            path.push((now, pair[1].at(-depth)));
        }
        let touching = [time + DOWN, now];
        path.push((now + UP, way[way.len() - 1].at(ABOVE)));
        let mut limbs: Vec<usize> = way.iter().map(|spot| spot.limb).collect();
        limbs.dedup();
        let begins = way[0].middle;
        Some(Stimulation { kind: TouchKind::Stroke, limbs, force, path: ProbePath(path), begins, touching })
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
        let caress = Strokes::new(stage).caress(stage.time(), rng);
        let Some(caress) = caress else { return Ok(false) };
        let end = caress.path.end().min(until);
        stage.send_probe(0, caress.path)?;
        while stage.time() < end {
            let StepSenses { time, contacts, touches, .. } = stage.step()?;
            each(stage, time, &contacts, touches)?;
        }
    }
    Ok(true)
}
