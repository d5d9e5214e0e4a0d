//! Motions that stop at touch.

use crate::babbling::clearance::{Clearance, Encounter};
use crate::creature::Body;
use crate::mujoco::{self, Contact, Data};
use crate::senses::{ContactReader, Reading, TouchEnd};
use crate::skin::Skin;

/// The deepest that limbs may be in each other where a motion stops, metres.
pub const DEEPEST: f64 = 1e-6;

/// Step, in metres of the fastest point, along geoms whose gap only the engine can tell.
const ENGINE_STEP: f64 = 1e-3;

/// How a motion ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Ending {
    /// Skin met skin.
    Touch([TouchEnd; 2]),
    /// Limbs met where at least one has no skin.
    Bare,
    /// It met at once what the last motion had met: nothing new was felt.
    Again,
    /// It reached its target.
    Free,
}

/// What motions cost and left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Motions begun.
    pub motions: u64,
    /// Postures whose contacts the engine was asked for.
    pub engine_checks: u64,
    /// Pairs of limbs whose gap was looked at.
    pub gap_checks: u64,
    /// Contacts on bare geometry, left out.
    pub bare: u64,
    /// Contacts between neighbouring limbs, left out.
    pub neighbours: u64,
    /// Instant re-contacts, left out.
    pub again: u64,
}

impl std::ops::AddAssign for Effort {
    fn add_assign(&mut self, other: Effort) {
        self.motions += other.motions;
        self.engine_checks += other.engine_checks;
        self.gap_checks += other.gap_checks;
        self.bare += other.bare;
        self.neighbours += other.neighbours;
        self.again += other.again;
    }
}

/// A body that moves: one per thread.
pub struct Mover<'a> {
    body: &'a Body,
    skin: &'a Skin,
    reader: &'a ContactReader,
    data: Data,
    clearance: Clearance,
    qpos: Vec<f64>,
    posture: Vec<f64>,
    contact: Option<Encounter>,
    /// What the motions cost so far.
    pub effort: Effort,
}

impl<'a> Mover<'a> {
    /// A body at rest in `posture`.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn new(
        body: &'a Body,
        skin: &'a Skin,
        reader: &'a ContactReader,
        clearance: Clearance,
        posture: Vec<f64>,
    ) -> mujoco::Result<Mover<'a>> {
        let data = Data::new(body.model.clone())?;
        let qpos = vec![0.0; body.model.nq()];
        let effort = Effort::default();
        Ok(Mover { body, skin, reader, data, clearance, qpos, posture, contact: None, effort })
    }

    /// Puts the body into a posture without a motion.
    pub fn reset(&mut self, posture: Vec<f64>) {
        self.posture = posture;
        self.contact = None;
    }

    /// The posture it is in.
    pub fn posture(&self) -> &[f64] {
        &self.posture
    }

    /// Moves straight towards `target` and stops at the first contact of limbs that are not neighbours.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn advance(&mut self, target: &[f64]) -> mujoco::Result<Ending> {
        self.effort.motions += 1;
        self.clearance.checks = 0;
        let ending = self.run(target);
        self.effort.gap_checks += std::mem::take(&mut self.clearance.checks);
        ending
    }

    fn run(&mut self, target: &[f64]) -> mujoco::Result<Ending> {
        self.clearance.begin(&self.posture, target, self.contact);
        if let Some(contact) = self.contact {
            // Pressing on, or sliding along: the touch that has just been felt.
            let (_, opening) = self.clearance.gap(&contact, 0.0);
            if opening <= 1e-3 * self.clearance.speed(&contact) {
                self.effort.again += 1;
                return Ok(Ending::Again);
            }
        }
        let mut from = 0.0;
        while let Some((t, encounter)) = self.clearance.next(from) {
            from = t;
            let stop = match encounter.exact {
                true => self.press(&encounter, t),
                false => self.search(&encounter, t)?,
            };
            match stop {
                Some(stop) if stop <= 1.0 => {
                    if let Some(contact) = self.contact_at(&encounter, stop)? {
                        return Ok(self.stop(stop, encounter, contact));
                    }
                    self.clearance.pass(&encounter, stop + 1e-6);
                }
                Some(_) => {}
                None => {}
            }
        }
        self.posture = target.to_vec();
        self.contact = None;
        Ok(Ending::Free)
    }

    /// From a gap below a micrometre into a contact above one: where exact geoms overlap a little. None
    /// when they graze and part again.
    fn press(&mut self, encounter: &Encounter, t: f64) -> Option<f64> {
        let mut at = t;
        for _ in 0..8 {
            let (gap, opening) = self.clearance.gap(encounter, at);
            if gap < -0.1 * DEEPEST && gap > -0.9 * DEEPEST {
                return Some(at);
            }
            if opening >= -1e-9 {
                break;
            }
            at -= (gap + 0.5 * DEEPEST) / opening;
        }
        self.clearance.pass(encounter, at.max(t) + 1e-6);
        None
    }

    /// Steps through a stretch that only the engine can judge; the place of the contact, if there is one.
    fn search(&mut self, encounter: &Encounter, t: f64) -> mujoco::Result<Option<f64>> {
        let step = ENGINE_STEP / self.clearance.speed(encounter);
        let next = (t + step).min(1.0);
        if self.contact_at(encounter, next)?.is_none() {
            self.clearance.pass(encounter, if next >= 1.0 { f64::INFINITY } else { next });
            return Ok(None);
        }
        let (mut free, mut met) = (t, next);
        for _ in 0..60 {
            let middle = 0.5 * (free + met);
            match self.contact_at(encounter, middle)? {
                Some(contact) if contact.distance >= -DEEPEST => return Ok(Some(middle)),
                Some(_) => met = middle,
                None => free = middle,
            }
        }
        Ok(Some(met))
    }

    /// The deepest contact of the encounter's geoms at `t`, by the engine.
    fn contact_at(&mut self, encounter: &Encounter, t: f64) -> mujoco::Result<Option<Contact>> {
        let posture = self.clearance.posture(t);
        self.body.write_qpos(&posture, &mut self.qpos);
        self.data.set_qpos(&self.qpos)?;
        self.data.kinematics()?;
        self.data.collision()?;
        self.effort.engine_checks += 1;
        let [a, b] = encounter.geoms;
        let between = self.data.contacts().filter(|c| c.geoms == [a, b] || c.geoms == [b, a]);
        Ok(between.min_by(|c, d| c.distance.total_cmp(&d.distance)))
    }

    /// Stops where the engine has just found `contact`, and reads it.
    fn stop(&mut self, t: f64, encounter: Encounter, contact: Contact) -> Ending {
        self.posture = self.clearance.posture(t);
        self.contact = Some(encounter);
        for other in self.data.contacts() {
            if self.reader.read(self.body, self.skin, &self.data, &other) == Reading::Neighbours {
                self.effort.neighbours += 1;
            }
        }
        match self.reader.read(self.body, self.skin, &self.data, &contact) {
            Reading::Touch(ends) => Ending::Touch(ends),
            _ => {
                self.effort.bare += 1;
                Ending::Bare
            }
        }
    }
}
