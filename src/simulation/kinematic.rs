//! Motions without forces: straight through postures, up to the first contact of limbs that are not neighbours.

use super::advancement::{ConservativeAdvancement, SLIDING};
use super::motion::{Ending, Motion, Movers, Moving};
use super::touchable::Encounter;
use crate::creature::Posture;
use crate::error::Result;
use crate::mujoco::{Contact, Data};
use crate::senses::Reading;

/// The deepest that limbs may be in each other where a motion stops, metres.
pub const DEEPEST: f64 = 1e-6;

/// First step, in metres of the fastest point, along geoms of which only the engine can tell that they touch; it
/// doubles with each in which they do not …
const ENGINE_STEP: f64 = 8e-6;
/// … up to this.
const LONGEST_ENGINE_STEP: f64 = 1e-3;

/// How deep limbs are in each other in the posture of a touch, metres: little enough for learning, and more than rounding, so
/// that the engine finds the contact again.
const BARELY: f64 = 1e-9;
/// Steps from an overlap of a micrometre to there.
const TO_SURFACE: usize = 4;
/// The share of a motion that they lead at the most beyond the stretch that was found free.
const BEYOND: f64 = 1e-3;

/// Way of the fastest point within which geoms in contact must part, where only the engine can tell,
/// metres.
const PARTING: f64 = 1e-4;

/// A body that goes straight through its postures.
pub(super) struct KinematicMotion<'a> {
    movers: &'a Movers<'a>,
    data: Data,
    clearance: ConservativeAdvancement,
    contact: Option<Encounter>,
    moving: Moving,
}

impl Motion for KinematicMotion<'_> {
    fn moving(&self) -> &Moving {
        &self.moving
    }

    fn reset(&mut self) -> Result<()> {
        self.moving = Moving::at(&self.movers.start);
        self.contact = None;
        Ok(())
    }

    /// A ball joint whose way would leave its range goes up to its limit; what follows another joint ends where
    /// that joint has it (and on the way as well, where it follows in proportion).
    fn advance(&mut self, target: &[f64]) -> Result<Ending> {
        let target = self.moving.begin(self.movers.body, target);
        self.clearance.checks = 0;
        let ending = self.run(&target);
        self.moving.effort.gap_checks += self.clearance.checks;
        ending
    }
}

impl<'a> KinematicMotion<'a> {
    /// A body at rest where motions start.
    pub fn new(movers: &'a Movers<'a>) -> Result<KinematicMotion<'a>> {
        Ok(KinematicMotion {
            movers,
            data: Data::new(movers.body.model.clone())?,
            clearance: movers.clearance.clone(),
            contact: None,
            moving: Moving::at(&movers.start),
        })
    }

    fn run(&mut self, target: &[f64]) -> Result<Ending> {
        self.clearance.begin(&self.moving.posture, target, self.contact);
        if let Some(contact) = self.contact {
            // Pressing on, or sliding along: the touch that has just been felt.
            if !self.parts(&contact)? {
                self.moving.effort.again += 1;
                return Ok(Ending::Again);
            }
        }
        let mut from = 0.0;
        let mut step = (None, ENGINE_STEP);
        while let Some((t, encounter)) = self.clearance.next(from) {
            from = t;
            let again = step.0 == Some(encounter);
            let length = if again { LONGEST_ENGINE_STEP.min(2.0 * step.1) } else { ENGINE_STEP };
            // However thin a geom is, it must not be stepped over.
            step = (Some(encounter), length.min(encounter.short));
            if encounter.exact && self.clearance.parting(&encounter) {
                // It has hardly opened, and closes again.
                self.moving.effort.again += 1;
                return Ok(Ending::Again);
            }
            let place = match encounter.exact {
                true => self.press(&encounter, t),
                false => Some(self.step(&encounter, t, step.1)),
            };
            let Some(place) = place.filter(|place| *place <= 1.0) else { continue };
            match self.contact_at(&encounter, place)? {
                Some((met, contact)) if contact.distance >= -DEEPEST => {
                    return self.stop(place, met, contact);
                }
                Some(deep) => return self.search(&encounter, t.min(place), place, deep),
                // Grazed, or not there yet.
                None if encounter.exact => {
                    self.clearance.pass(&encounter, place + self.clearance.least_advance())
                }
                None if place >= 1.0 => self.clearance.pass(&encounter, f64::INFINITY),
                None => self.clearance.pass(&encounter, place),
            }
        }
        self.moving.posture = Posture::from(target);
        self.contact = None;
        Ok(Ending::Free)
    }

    /// Whether the motion parts what touches at its start.
    fn parts(&mut self, contact: &Encounter) -> Result<bool> {
        if contact.exact {
            let opening = self.clearance.gap(contact, 0.0).map_or(0.0, |(_, opening)| opening);
            return Ok(opening > SLIDING * self.clearance.speed(contact));
        }
        // How their bounds move says nothing of the geoms themselves: see whether they have parted soon.
        let soon = self.clearance.advance_by(contact, 0.0, PARTING).min(1.0);
        self.clearance.pass(contact, soon);
        Ok(!matches!(self.contact_at(contact, soon)?, Some((met, _)) if met == *contact))
    }

    /// From a gap below a micrometre into a contact above one: where exact geoms overlap a little. None
    /// when they graze and part again.
    fn press(&mut self, encounter: &Encounter, t: f64) -> Option<f64> {
        let mut at = t;
        for _ in 0..8 {
            let Some((gap, opening)) = self.clearance.gap(encounter, at) else { break };
            if gap < -0.1 * DEEPEST && gap > -0.9 * DEEPEST {
                return Some(at);
            }
            if opening >= -1e-9 {
                break;
            }
            at -= (gap + 0.5 * DEEPEST) / opening;
        }
        self.clearance.pass(encounter, at.max(t) + self.clearance.least_advance());
        None
    }

    /// The next place to look at in a stretch that only the engine can judge: where shapes that close in overlap as much as
    /// in the middle of a touch, or else further on by a `length` of their way, metres.
    fn step(&mut self, encounter: &Encounter, t: f64, length: f64) -> f64 {
        let step = t + self.clearance.advance_by(encounter, t, length);
        let aimed = self
            .clearance
            .gap(encounter, t)
            .map_or(t, |(gap, opening)| if opening < 0.0 { t - (gap + 0.5 * DEEPEST) / opening } else { t });
        let place = if aimed > t { aimed.min(step) } else { step };
        place.min(1.0)
    }

    /// Stops where the first contact between `free` and `met` begins; `deep` is the one at `met`.
    fn search(
        &mut self,
        encounter: &Encounter,
        mut free: f64,
        mut met: f64,
        mut deep: (Encounter, Contact),
    ) -> Result<Ending> {
        for _ in 0..60 {
            let middle = 0.5 * (free + met);
            match self.contact_at(encounter, middle)? {
                Some((found, contact)) if contact.distance >= -DEEPEST => {
                    return self.stop(middle, found, contact);
                }
                Some(found) => (met, deep) = (middle, found),
                None => free = middle,
            }
        }
        // The engine's contact begins deeper than a touch may be: it ends the motion, and is none.
        self.moving.posture = self.clearance.motion.posture(free);
        self.contact = Some(deep.0);
        self.moving.effort.bare += 1;
        Ok(Ending::Bare)
    }

    /// The deepest contact at `t`, by the engine, of geoms that can touch. What touched at the start is
    /// left out while it parts, unless it is the encounter itself.
    fn contact_at(&mut self, encounter: &Encounter, t: f64) -> Result<Option<(Encounter, Contact)>> {
        self.movers.body.put(&self.clearance.motion.posture(t), &mut self.data)?;
        self.data.collision()?;
        self.moving.effort.engine_checks += 1;
        let heeded = |(met, contact): &(Encounter, Contact)| {
            met == encounter || self.contact != Some(*met) || contact.distance < -DEEPEST
        };
        let met =
            self.data.contacts().filter_map(|c| Some((self.clearance.touchable.encounter(c.geoms)?, c)));
        Ok(met.filter(heeded).min_by(|(_, c), (_, d)| c.distance.total_cmp(&d.distance)))
    }

    /// Stops where the engine has just found `contact`, and reads it.
    fn stop(&mut self, t: f64, encounter: Encounter, contact: Contact) -> Result<Ending> {
        self.contact = Some(encounter);
        self.moving.effort.neighbours += self.movers.neighbours(&self.data);
        let at = self.at_touch(t, &encounter);
        self.moving.posture = self.clearance.motion.posture(at);
        self.movers.body.put(&self.moving.posture, &mut self.data)?;
        Ok(match self.movers.read(&self.data, &contact) {
            Reading::Touch(met) => Ending::Touch(met),
            _ => {
                self.moving.effort.bare += 1;
                Ending::Bare
            }
        })
    }

    /// Where surfaces barely meet that overlap by up to a micrometre at `t`. How deep they are there is always on the same side:
    /// of bodies that move in a plane it would look like an offset across it.
    fn at_touch(&mut self, t: f64, encounter: &Encounter) -> f64 {
        let mut at = t;
        for _ in 0..TO_SURFACE {
            let Some((gap, opening)) = self.meeting(encounter, at) else { return t };
            // Limbs that slide along each other, or rest, are no farther apart anywhere near.
            if opening >= -SLIDING * self.clearance.speed(encounter) {
                return t;
            }
            at -= (gap + BARELY) / opening;
            // Of limbs that hardly move, while others do, only rounding tells how fast they close.
            if !(-BEYOND..=t + BEYOND).contains(&at) {
                return t;
            }
        }
        // The last step, too, is to lead to where they meet.
        self.meeting(encounter, at).map_or(t, |_| at)
    }

    /// The gap and how fast it opens at `t`; `None` if surfaces do not meet there.
    fn meeting(&mut self, encounter: &Encounter, t: f64) -> Option<(f64, f64)> {
        self.clearance.gap(encounter, t).filter(|(gap, _)| gap.abs() <= 2.0 * DEEPEST)
    }
}
