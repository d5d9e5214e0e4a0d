//! Motions that stop at touch.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::creature::{Body, Posture};
use crate::error::Result;
use crate::mujoco::{Contact, Data};
use crate::named::named;
use crate::senses::{
    ContactReader, ExactContact, Moment, Proprioception, Reading, RecordedTouch, SkinPlace, Touch, TouchEnd,
};
use crate::simulation::advancement::{ConservativeAdvancement, SLIDING};
use crate::simulation::touchable::Encounter;
use crate::skin::Skin;

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

/// Skin that met skin: two receptors, and the exact contact, which only a record of the touch takes in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Met {
    receptors: [usize; 2],
    contact: ExactContact,
}

impl Met {
    /// Two places on the skin that met, so deep in each other where forces were at work, metres.
    pub(super) fn new(places: [SkinPlace; 2], depth: Option<f64>) -> Met {
        Met {
            receptors: places.map(|place| place.receptor),
            contact: ExactContact {
                points: places.map(|place| place.point),
                depth,
                ..ExactContact::default()
            },
        }
    }

    /// How deep they are in each other, metres.
    pub(super) fn depth(&self) -> Option<f64> {
        self.contact.depth
    }
}

/// How a motion ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Ending {
    /// Skin met skin.
    Touch(Met),
    /// Limbs met where at least one has no skin.
    Bare,
    /// It met at once what the last motion had met: nothing new was felt.
    Again,
    /// It reached its target.
    Free,
}

/// What motions cost and left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Effort {
    /// Motions begun.
    pub motions: u64,
    /// Postures whose contacts the engine was asked for.
    pub engine_checks: u64,
    /// Pairs of limbs whose gap was looked at; not kept in files.
    #[serde(skip)]
    pub gap_checks: u64,
    /// Contacts on bare geometry, left out.
    pub bare: u64,
    /// Contacts between neighbouring limbs, left out.
    pub neighbours: u64,
    /// Instant re-contacts, left out.
    pub again: u64,
    /// Time that the motions took in the simulation, seconds; 0 where no forces were at work.
    #[serde(default)]
    pub simulated_s: f64,
}

impl std::ops::AddAssign for Effort {
    fn add_assign(&mut self, other: Effort) {
        self.motions += other.motions;
        self.engine_checks += other.engine_checks;
        self.gap_checks += other.gap_checks;
        self.bare += other.bare;
        self.neighbours += other.neighbours;
        self.again += other.again;
        self.simulated_s += other.simulated_s;
    }
}

/// How the body is moved from posture to posture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum MotionName {
    /// Straight through its postures, without forces.
    #[default]
    Kinematic,
    /// By servos, under gravity, at human speeds.
    Dynamic,
}

named!(MotionName, "motion", { Kinematic => "kinematic", Dynamic => "dynamic" });

/// A body that moves and stops at touch, however it is moved.
pub trait MotionUntilTouch {
    /// Begins a bout: at rest in `posture`, no effort made yet.
    ///
    /// # Errors
    /// Where the engine fails.
    fn reset(&mut self, posture: &[f64]) -> Result<()>;

    /// Draws the noise of its senses from another random stream from now on.
    fn draw_noise_from(&mut self, noise: ChaCha8Rng);

    /// Moves towards `target` until it touches itself or cannot get further.
    ///
    /// # Errors
    /// Where the engine fails.
    fn advance(&mut self, target: &[f64]) -> Result<Ending>;

    /// The posture that it feels itself in; after a touch, that of the touch.
    ///
    /// # Errors
    /// Where the engine fails.
    fn felt_posture(&mut self) -> Result<Posture>;

    /// When and how hard the touch was that the last motion ended in, if forces were at work.
    fn moment(&self) -> Option<Moment>;

    /// What the motions of the bout cost so far.
    fn effort(&self) -> Effort;

    /// The touch that the last motion ended in.
    ///
    /// # Errors
    /// Where the engine fails.
    fn touch(&mut self, bout: u64, met: Met) -> Result<RecordedTouch> {
        let (motion, posture) = (self.effort().motions, self.felt_posture()?);
        let ends = met.receptors.map(TouchEnd::at);
        Ok(RecordedTouch::new(Touch { bout, motion, posture, ends, moment: self.moment() }, met.contact))
    }
}

impl MotionUntilTouch for Mover<'_> {
    fn reset(&mut self, posture: &[f64]) -> Result<()> {
        self.posture = Posture::from(posture);
        self.contact = None;
        self.effort = Effort::default();
        Ok(())
    }

    /// Straight towards `target`, up to the first contact of limbs that are not neighbours.
    /// A ball joint whose way would leave its range goes up to its limit; what follows another joint ends where
    /// that joint has it (and on the way as well, where it follows in proportion).
    fn advance(&mut self, target: &[f64]) -> Result<Ending> {
        self.effort.motions += 1;
        self.clearance.checks = 0;
        let mut target = Posture::reachable(&self.body.creature, &self.posture, target);
        self.body.creature.couple(&mut target);
        let ending = self.run(&target);
        self.effort.gap_checks += std::mem::take(&mut self.clearance.checks);
        ending
    }

    fn draw_noise_from(&mut self, noise: ChaCha8Rng) {
        self.proprioception.draw_noise_from(noise);
    }

    fn felt_posture(&mut self) -> Result<Posture> {
        self.proprioception.read(self.body, &self.posture)
    }

    fn moment(&self) -> Option<Moment> {
        None
    }

    fn effort(&self) -> Effort {
        self.effort
    }
}

/// A body that moves through its postures: one per thread.
pub struct Mover<'a> {
    body: &'a Body,
    skin: &'a Skin,
    reader: &'a ContactReader,
    proprioception: Proprioception,
    data: Data,
    clearance: ConservativeAdvancement,
    qpos: Vec<f64>,
    posture: Posture,
    contact: Option<Encounter>,
    effort: Effort,
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
        clearance: ConservativeAdvancement,
        posture: Posture,
    ) -> Result<Mover<'a>> {
        let data = Data::new(body.model.clone())?;
        let proprioception = Proprioception::new(body, ChaCha8Rng::seed_from_u64(0))?;
        let qpos = vec![0.0; body.model.nq()];
        let effort = Effort::default();
        Ok(Mover {
            body,
            skin,
            reader,
            proprioception,
            data,
            clearance,
            qpos,
            posture,
            contact: None,
            effort,
        })
    }

    /// The posture that it is really in.
    pub fn posture(&self) -> &[f64] {
        &self.posture
    }

    fn run(&mut self, target: &[f64]) -> Result<Ending> {
        self.clearance.begin(&self.posture, target, self.contact);
        if let Some(contact) = self.contact {
            // Pressing on, or sliding along: the touch that has just been felt.
            if !self.parts(&contact)? {
                self.effort.again += 1;
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
                self.effort.again += 1;
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
        self.posture = Posture::from(target);
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
        self.posture = self.clearance.posture(free);
        self.contact = Some(deep.0);
        self.effort.bare += 1;
        Ok(Ending::Bare)
    }

    /// The deepest contact at `t`, by the engine, of geoms that can touch. What touched at the start is
    /// left out while it parts, unless it is the encounter itself.
    fn contact_at(&mut self, encounter: &Encounter, t: f64) -> Result<Option<(Encounter, Contact)>> {
        let posture = self.clearance.posture(t);
        self.body.write_qpos(&posture, &mut self.qpos);
        self.data.set_qpos(&self.qpos)?;
        self.data.kinematics()?;
        self.data.collision()?;
        self.effort.engine_checks += 1;
        let heeded = |(met, contact): &(Encounter, Contact)| {
            met == encounter || self.contact != Some(*met) || contact.distance < -DEEPEST
        };
        let met = self.data.contacts().filter_map(|c| Some((self.clearance.encounter(c.geoms)?, c)));
        Ok(met.filter(heeded).min_by(|(_, c), (_, d)| c.distance.total_cmp(&d.distance)))
    }

    /// Stops where the engine has just found `contact`, and reads it.
    fn stop(&mut self, t: f64, encounter: Encounter, contact: Contact) -> Result<Ending> {
        self.contact = Some(encounter);
        for other in self.data.contacts() {
            if self.reader.read(self.body, self.skin, &self.data, &other) == Reading::Neighbours {
                self.effort.neighbours += 1;
            }
        }
        let at = self.at_touch(t, &encounter);
        self.posture = self.clearance.posture(at);
        self.body.write_qpos(&self.posture, &mut self.qpos);
        self.data.set_qpos(&self.qpos)?;
        self.data.kinematics()?;
        Ok(match self.reader.read(self.body, self.skin, &self.data, &contact) {
            Reading::Touch(places) => Ending::Touch(Met::new(places, None)),
            _ => {
                self.effort.bare += 1;
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

    /// The gap and how fast it opens at `t`; none where surfaces do not meet there.
    fn meeting(&mut self, encounter: &Encounter, t: f64) -> Option<(f64, f64)> {
        self.clearance.gap(encounter, t).filter(|(gap, _)| gap.abs() <= 2.0 * DEEPEST)
    }
}
