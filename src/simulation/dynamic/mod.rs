//! Motions with physics: servos carry the body under gravity, contacts press, and what is felt is a force.
//!
//! The simulation runs in the model's own steps. Where receptors fire it goes back to the step before and runs again
//! in finer ones, so that a motion stops as soon as they fire, however long the model's steps are.

mod servo;

use std::collections::BTreeMap;

use servo::FINER;
pub use servo::{Servo, ServoPath};

use super::motion::{Ending, Motion, Movers, Moving};
use super::sorted;
use super::step::step;
use crate::creature::Body;
use crate::error::Result;
use crate::mujoco::{Contact, Data};
use crate::senses::{Met, Moment, Reading};

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

/// A body that forces move. What cannot touch by [`Movers`] passes through each other.
pub(super) struct DynamicMotion<'a> {
    movers: &'a Movers<'a>,
    servo: &'a Servo,
    /// Of each kind of step.
    levels: Vec<Data>,
    /// `qpos` where motions start, and always of what does not move.
    held: Vec<f64>,
    state: SimulatedState,
    /// Per pair of limbs that press on each other.
    pressing: BTreeMap<[usize; 2], Press>,
    moving: Moving,
}

impl<'a> DynamicMotion<'a> {
    /// A body at rest where motions start.
    pub fn new(movers: &'a Movers<'a>, servo: &'a Servo) -> Result<DynamicMotion<'a>> {
        let model = &movers.body.model;
        let levels = servo.levels.iter().map(|model| Data::new(model.clone())).collect::<Result<_, _>>()?;
        let held = movers.body.qpos(&movers.start);
        Ok(DynamicMotion {
            movers,
            servo,
            levels,
            state: SimulatedState { qpos: held.clone(), qvel: vec![0.0; model.nv()], time: 0.0 },
            held,
            pressing: BTreeMap::new(),
            moving: Moving::at(&movers.start),
        })
    }

    /// Runs along a path in steps of a level while it `goes_on`. Where receptors fire it goes back to the step before and runs
    /// in finer steps; nothing where in these they do not fire.
    fn run(
        &mut self,
        level: usize,
        path: &ServoPath,
        goes_on: &mut dyn FnMut(&Self) -> bool,
    ) -> Result<Option<Fired>> {
        let mut earlier = None;
        while goes_on(self) {
            let now = self.state.clone();
            match (self.step(level, path, true)?, earlier.take()) {
                (None, _) => earlier = Some(now),
                (Some(_), Some(before)) if level + 1 < self.levels.len() => {
                    self.state = before;
                    let mut steps = 0..2 * FINER as usize;
                    let fired = self.run(level + 1, path, &mut |_| steps.next().is_some())?;
                    if fired.is_some() {
                        return Ok(fired);
                    }
                }
                (fired, _) => return Ok(fired),
            }
        }
        Ok(None)
    }

    /// Makes one step along a path. Where receptors fire that are to be felt, the body stays in the state in which they do;
    /// the poses and contacts of the level's data are those of that state.
    fn step(&mut self, level: usize, path: &ServoPath, feel: bool) -> Result<Option<Fired>> {
        step(
            &mut self.levels[level],
            (&self.state.qpos, &self.state.qvel),
            |geoms| self.movers.clearance.touchable.encounter(geoms).is_some(),
            |data| self.servo.forces(path, self.state.time, data),
        )?;
        self.moving.effort.engine_checks += 1;
        if let Some(fired) = self.contacts(level, feel) {
            return Ok(Some(fired));
        }
        let data = &self.levels[level];
        self.state.qpos.copy_from_slice(data.qpos());
        self.state.qvel.copy_from_slice(data.qvel());
        self.servo.hold(&self.held, &mut self.state.qpos, &mut self.state.qvel);
        let step = data.model().timestep();
        self.state.time += step;
        self.moving.effort.simulated_s += step;
        Ok(None)
    }

    /// Takes note of what presses in the step just made, and tells which receptors fire that did not before.
    fn contacts(&mut self, level: usize, feel: bool) -> Option<Fired> {
        let data = &self.levels[level];
        let now = self.state.time;
        let mut fresh = Vec::new();
        let mut fired: Option<Fired> = None;
        for (limbs, contact, force) in pressing(self.movers.body, data) {
            if let Some(press) = self.pressing.get_mut(&limbs).filter(|press| now - press.last <= PARTED) {
                press.last = now;
                continue;
            }
            fresh.push(limbs);
            let depth = Some((-contact.distance).max(0.0));
            if fired.is_some_and(|fired| fired.met.exact_contact.depth >= depth) || !feel {
                continue;
            }
            if let Reading::Touch(mut met) = self.movers.read(data, &contact) {
                met.exact_contact.depth = depth;
                fired = Some(Fired { met, level, moment: Moment { time: now, force } });
            }
        }
        if fired.is_none() {
            self.moving.effort.bare += if feel { fresh.len() as u64 } else { 0 };
            self.pressing.extend(fresh.into_iter().map(|limbs| (limbs, Press { last: now, felt: !feel })));
        }
        fired
    }

    /// Stops where receptors have just fired.
    fn stop(&mut self, fired: Fired) -> Ending {
        let data = &self.levels[fired.level];
        let press = Press { last: self.state.time, felt: true };
        self.pressing.extend(pressing(self.movers.body, data).map(|(limbs, ..)| (limbs, press)));
        self.moving.effort.neighbours += self.movers.neighbours(data);
        self.moving.moment = Some(fired.moment);
        Ending::Touch(fired.met)
    }

    /// What stopped a motion before its end: what was felt before, or what has no skin there.
    fn hindered(&mut self) -> Ending {
        let now = self.state.time;
        self.pressing.retain(|_, press| now - press.last <= PARTED);
        if self.pressing.values().any(|press| press.felt) {
            self.moving.effort.again += 1;
            Ending::Again
        } else if self.pressing.is_empty() {
            Ending::Free
        } else {
            Ending::Bare
        }
    }

    /// Whether the body is at the end of a path, and at rest.
    fn has_arrived(&self, path: &ServoPath) -> bool {
        self.state.time >= path.end()
            && self.speed() < AT_REST
            && self.servo.lag(path, self.state.time, &self.state.qpos).iter().all(|lag| lag.abs() < ARRIVED)
    }

    /// The greatest speed of any degree of freedom, radians or metres per second.
    fn speed(&self) -> f64 {
        self.state.qvel.iter().fold(0.0, |most, speed| f64::max(most, speed.abs()))
    }
}

/// The contacts of two limbs that press on each other in the step just made: the limbs, the earlier one first, and the force.
fn pressing(body: &Body, data: &Data) -> impl Iterator<Item = ([usize; 2], Contact, f64)> {
    data.pressing().filter_map(|(contact, force)| {
        let [a, b] = contact.geoms.map(|geom| body.limb_of_geom(geom));
        Some((sorted([a?, b?]), contact, force))
    })
}

impl Motion for DynamicMotion<'_> {
    fn moving(&self) -> &Moving {
        &self.moving
    }

    fn reset(&mut self) -> Result<()> {
        // What the engine begins its solver with must not depend on the bout before.
        self.levels.iter_mut().try_for_each(Data::reset)?;
        self.state.qpos.clone_from(&self.held);
        self.state.qvel.fill(0.0);
        self.state.time = 0.0;
        self.pressing.clear();
        self.moving = Moving::at(&self.movers.start);
        Ok(())
    }

    fn advance(&mut self, target: &[f64]) -> Result<Ending> {
        let body = self.movers.body;
        if self.moving.moment.take().is_some() {
            let path = self.servo.path(&self.state.qpos, &self.state.qpos, self.state.time);
            while self.state.time < path.began + RESTING && self.speed() > AT_REST {
                self.step(0, &path, false)?;
            }
        }
        self.moving.posture = body.read_posture(&self.state.qpos);
        let target = self.moving.begin(body, target);
        let path = self.servo.path(&self.state.qpos, &body.qpos(&target), self.state.time);
        let latest = path.end() + GRACE;
        let mut goes_on = |of: &Self| of.state.time < latest && !of.has_arrived(&path);
        let ending = match self.run(0, &path, &mut goes_on)? {
            Some(fired) => self.stop(fired),
            None if self.has_arrived(&path) => Ending::Free,
            None => self.hindered(),
        };
        self.moving.posture = body.read_posture(&self.state.qpos);
        Ok(ending)
    }
}
