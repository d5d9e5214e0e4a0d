//! Motions with physics: servos carry the body under gravity, contacts press, and what is felt is a force.
//!
//! The simulation runs in the model's own steps. Where receptors fire it goes back to the step before and runs again
//! in finer ones, so that a motion stops as soon as they fire, however long the model's steps are.

mod servo;

use std::collections::BTreeMap;
use std::sync::Arc;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::creature::{Body, Posture};
use crate::error::Result;
use crate::mujoco::{Data, LONGEST_STEP, Model};
use crate::senses::{ContactReader, Moment, Proprioception, Reading};
use crate::simulation::advancement::ConservativeAdvancement;
use crate::simulation::motion::{Effort, Ending, Met, MotionUntilTouch};
use crate::simulation::step::step;
use crate::skin::Skin;
use servo::{Servo, ServoPath};

/// How many steps of the next finer kind are in one.
const FINER: f64 = 16.0;
/// Kinds of steps.
const LEVELS: usize = 3;
/// Limbs that have been felt must have parted for this long until they can be felt again, seconds.
const PARTED: f64 = 0.02;
/// The longest that a body takes to come to rest after a touch, seconds.
const RESTING: f64 = 0.3;
/// The longest that a motion takes beyond its time, seconds: something is in its way.
const GRACE: f64 = 0.5;
/// A body is where it should be within this, radians or metres …
const ARRIVED: f64 = 0.01;
/// … and at rest below this, radians or metres per second.
const AT_REST: f64 = 0.05;

/// What the simulations of one body share.
#[derive(Clone, Debug)]
pub struct Physics {
    servo: Servo,
    /// The body's model in ever finer steps.
    levels: Vec<Arc<Model>>,
}

impl Physics {
    /// Prepares a body for motions with physics.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn new(body: &Body) -> Result<Physics> {
        let servo = Servo::new(body);
        let levels = servo::levels(body, &servo, LONGEST_STEP, FINER, LEVELS)?;
        Ok(Physics { servo, levels })
    }
}

/// Where a simulated body is and how it moves.
#[derive(Clone, Debug)]
struct SimulatedState {
    qpos: Vec<f64>,
    qvel: Vec<f64>,
    /// Since the beginning of the bout, seconds.
    time: f64,
}

/// Receptors that fired.
#[derive(Clone, Copy, Debug)]
struct Fired {
    met: Met,
    /// Which data hold their contact.
    level: usize,
    moment: Moment,
}

/// Limbs that press on each other.
#[derive(Clone, Copy, Debug)]
struct Press {
    /// When they did so last.
    last: f64,
    /// Whether receptors have felt it.
    felt: bool,
}

/// A body that forces move: one per thread.
pub struct DynamicMover<'a> {
    body: &'a Body,
    skin: &'a Skin,
    reader: &'a ContactReader,
    proprioception: Proprioception,
    clearance: ConservativeAdvancement,
    servo: Servo,
    levels: Vec<Data>,
    /// `qpos` of what does not move.
    held: Vec<f64>,
    state: SimulatedState,
    posture: Posture,
    /// Per pair of limbs that press on each other.
    pressing: BTreeMap<[usize; 2], Press>,
    /// What the last motion ended in.
    touched: Option<Moment>,
    effort: Effort,
}

impl<'a> DynamicMover<'a> {
    /// A body at rest in `posture`; what `clearance` says cannot touch passes through each other.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn new(
        body: &'a Body,
        skin: &'a Skin,
        reader: &'a ContactReader,
        clearance: ConservativeAdvancement,
        physics: &Physics,
        posture: &[f64],
    ) -> Result<DynamicMover<'a>> {
        let levels = physics.levels.iter().map(|model| Data::new(model.clone())).collect::<Result<_, _>>()?;
        let mut held = vec![0.0; body.model.nq()];
        body.write_qpos(posture, &mut held);
        let state = SimulatedState { qpos: held.clone(), qvel: vec![0.0; body.model.nv()], time: 0.0 };
        Ok(DynamicMover {
            body,
            skin,
            reader,
            proprioception: Proprioception::new(body, ChaCha8Rng::seed_from_u64(0))?,
            clearance,
            servo: physics.servo.clone(),
            levels,
            held,
            state,
            posture: Posture::from(posture),
            pressing: BTreeMap::new(),
            touched: None,
            effort: Effort::default(),
        })
    }

    /// The posture that it is really in; after a touch, that of the touch.
    pub fn posture(&self) -> &[f64] {
        &self.posture
    }

    /// Holds the body where it is for some seconds, whatever touches.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn hold(&mut self, seconds: f64) -> Result<()> {
        self.stay(seconds, |_| true)?;
        self.posture = self.body.read_posture(&self.state.qpos);
        Ok(())
    }

    /// Stays where it is for some seconds at the most, while `goes_on` by its speed.
    fn stay(&mut self, seconds: f64, goes_on: impl Fn(f64) -> bool) -> Result<()> {
        let way = self.servo.way(&self.state.qpos, &self.state.qpos);
        let (began, end) = (self.state.time, self.state.time + seconds);
        while self.state.time < end && goes_on(self.speed()) {
            self.step(0, &way, began, false)?;
        }
        Ok(())
    }

    fn run(&mut self, way: &ServoPath) -> Result<Ending> {
        let began = self.state.time;
        let end = began + way.duration;
        let mut earlier = None;
        while self.state.time < end + GRACE {
            let now = self.state.clone();
            match (self.step(0, way, began, true)?, earlier.take()) {
                (None, _) => earlier = Some(now),
                (Some(fired), None) => return Ok(self.stop(fired)),
                (Some(_), Some(before)) => {
                    if let Some(fired) = self.search(1, before, way, began)? {
                        return Ok(self.stop(fired));
                    }
                }
            }
            if self.state.time >= end && self.arrived(way, began) {
                return Ok(Ending::Free);
            }
        }
        // Something is in its way: what was felt before, or what has no skin there.
        let now = self.state.time;
        self.pressing.retain(|_, press| now - press.last <= PARTED);
        Ok(if self.pressing.values().any(|press| press.felt) {
            self.effort.again += 1;
            Ending::Again
        } else if self.pressing.is_empty() {
            Ending::Free
        } else {
            Ending::Bare
        })
    }

    /// Runs again in finer steps from a state before receptors fired. None where in finer steps they do not fire.
    fn search(
        &mut self,
        level: usize,
        from: SimulatedState,
        way: &ServoPath,
        began: f64,
    ) -> Result<Option<Fired>> {
        self.state = from;
        let mut earlier = None;
        for _ in 0..2 * FINER as usize {
            let now = self.state.clone();
            match (self.step(level, way, began, true)?, earlier.take()) {
                (None, _) => earlier = Some(now),
                (Some(_), Some(before)) if level + 1 < self.levels.len() => {
                    if let Some(fired) = self.search(level + 1, before, way, began)? {
                        return Ok(Some(fired));
                    }
                }
                (fired, _) => return Ok(fired),
            }
        }
        Ok(None)
    }

    /// Makes one step of a way that began at a time. Where receptors fire that are to be felt, the body stays in the
    /// state in which they do; the poses and contacts of the level's data are those of that state.
    fn step(&mut self, level: usize, way: &ServoPath, began: f64, feel: bool) -> Result<Option<Fired>> {
        step(
            &mut self.levels[level],
            (&self.state.qpos, &self.state.qvel),
            |geoms| self.clearance.encounter(geoms).is_some(),
            |data| self.servo.forces(way, self.state.time - began, data),
        )?;
        self.effort.engine_checks += 1;
        if let Some(fired) = self.contacts(level, feel) {
            return Ok(Some(fired));
        }
        let data = &self.levels[level];
        self.state.qpos.copy_from_slice(data.qpos());
        self.state.qvel.copy_from_slice(data.qvel());
        self.servo.hold(&self.held, &mut self.state.qpos, &mut self.state.qvel);
        let step = data.model().timestep();
        self.state.time += step;
        self.effort.simulated_s += step;
        Ok(None)
    }

    /// Takes note of what presses in the step just made, and tells which receptors fire that did not before.
    fn contacts(&mut self, level: usize, feel: bool) -> Option<Fired> {
        let data = &self.levels[level];
        let now = self.state.time;
        let mut fresh = Vec::new();
        let mut fired: Option<Fired> = None;
        for (contact, force) in data.pressing() {
            let [Some(a), Some(b)] = contact.geoms.map(|geom| self.body.limb_of_geom(geom)) else { continue };
            let limbs = [a.min(b), a.max(b)];
            if let Some(press) = self.pressing.get_mut(&limbs).filter(|press| now - press.last <= PARTED) {
                press.last = now;
                continue;
            }
            fresh.push(limbs);
            let depth = Some((-contact.distance).max(0.0));
            if fired.is_some_and(|fired| fired.met.depth() >= depth) || !feel {
                continue;
            }
            if let Reading::Touch(places) = self.reader.read(self.body, self.skin, data, &contact) {
                let (met, moment) = (Met::new(places, depth), Moment { time: now, force });
                fired = Some(Fired { met, level, moment });
            }
        }
        if fired.is_none() {
            self.effort.bare += if feel { fresh.len() as u64 } else { 0 };
            self.pressing.extend(fresh.into_iter().map(|limbs| (limbs, Press { last: now, felt: !feel })));
        }
        fired
    }

    /// Stops where receptors have just fired.
    fn stop(&mut self, fired: Fired) -> Ending {
        let data = &self.levels[fired.level];
        for (contact, _) in data.pressing() {
            if let [Some(a), Some(b)] = contact.geoms.map(|geom| self.body.limb_of_geom(geom)) {
                let press = Press { last: self.state.time, felt: true };
                self.pressing.insert([a.min(b), a.max(b)], press);
            }
        }
        let neighbours =
            |contact| self.reader.read(self.body, self.skin, data, &contact) == Reading::Neighbours;
        self.effort.neighbours += data.contacts().filter(|contact| neighbours(*contact)).count() as u64;
        self.touched = Some(fired.moment);
        Ending::Touch(fired.met)
    }

    /// Whether the body is at the end of its way, and at rest.
    fn arrived(&self, way: &ServoPath, began: f64) -> bool {
        let lag = self.servo.lag(way, self.state.time - began, &self.state.qpos);
        self.speed() < AT_REST && lag.iter().all(|lag| lag.abs() < ARRIVED)
    }

    /// The greatest speed of any degree of freedom, radians or metres per second.
    fn speed(&self) -> f64 {
        self.state.qvel.iter().fold(0.0, |most, speed| f64::max(most, speed.abs()))
    }
}

impl MotionUntilTouch for DynamicMover<'_> {
    fn reset(&mut self, posture: &[f64]) -> Result<()> {
        // What the engine begins its solver with must not depend on the bout before.
        self.levels.iter_mut().try_for_each(Data::reset)?;
        self.body.write_qpos(posture, &mut self.state.qpos);
        self.state.qvel.fill(0.0);
        self.state.time = 0.0;
        self.posture = Posture::from(posture);
        self.pressing.clear();
        self.touched = None;
        self.effort = Effort::default();
        Ok(())
    }

    fn advance(&mut self, target: &[f64]) -> Result<Ending> {
        self.effort.motions += 1;
        if self.touched.take().is_some() {
            self.stay(RESTING, |speed| speed > AT_REST)?;
        }
        let start = self.body.read_posture(&self.state.qpos);
        let mut target = Posture::reachable(&self.body.creature, &start, target);
        self.body.creature.couple(&mut target);
        let mut qpos = self.held.clone();
        self.body.write_qpos(&target, &mut qpos);
        let way = self.servo.way(&self.state.qpos, &qpos);
        let ending = self.run(&way)?;
        self.posture = self.body.read_posture(&self.state.qpos);
        Ok(ending)
    }

    fn draw_noise_from(&mut self, noise: ChaCha8Rng) {
        self.proprioception.draw_noise_from(noise);
    }

    fn felt_posture(&mut self) -> Result<Posture> {
        self.proprioception.read(self.body, &self.posture)
    }

    fn moment(&self) -> Option<Moment> {
        self.touched
    }

    fn effort(&self) -> Effort {
        self.effort
    }
}
