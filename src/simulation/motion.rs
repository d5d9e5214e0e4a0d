//! Motions that stop at touch, however the body is moved.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::SelfContact;
use super::advancement::ConservativeAdvancement;
use super::dynamic::{DynamicMotion, Servo};
use super::kinematic::KinematicMotion;
use crate::agent::Agent;
use crate::creature::{Body, Posture};
use crate::error::{Error, Kind, Result};
use crate::mujoco::{Contact, Data};
use crate::named::named;
use crate::senses::{ContactReader, Met, Moment, Proprioception, Reading, RecordedTouch, Touch, TouchEnd};

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

named! {
    "motion",
    /// How the body is moved from posture to posture.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
    #[serde(rename_all = "snake_case")]
    #[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
    pub enum MotionName {
        /// Straight from posture to posture, without forces.
        #[default]
        Kinematic = "kinematic",
        /// By servos, under gravity, at human speeds.
        Dynamic = "dynamic",
    }
}

/// What moves a body.
pub(super) trait Motion {
    /// Where the last motion has brought it.
    fn moving(&self) -> &Moving;

    /// Begins a bout: at rest where motions start, no effort made yet.
    fn reset(&mut self) -> Result<()>;

    /// Moves towards `target` until it touches itself or cannot get further.
    fn advance(&mut self, target: &[f64]) -> Result<Ending>;
}

/// Where a body that moves is, and what that took.
pub(super) struct Moving {
    /// The posture that it is really in; after a touch, that of the touch.
    pub posture: Posture,
    /// When and how hard the touch was that the last motion ended in, if forces were at work.
    pub moment: Option<Moment>,
    /// What the motions of the bout cost so far.
    pub effort: Effort,
}

impl Moving {
    /// At rest in a posture.
    pub fn at(posture: &[f64]) -> Moving {
        Moving { posture: Posture::from(posture), moment: None, effort: Effort::default() }
    }

    /// Begins a motion towards a posture: the one that it leads to, within the joints' ranges and as they are coupled.
    pub fn begin(&mut self, body: &Body, target: &[f64]) -> Posture {
        self.effort.motions += 1;
        let mut target = Posture::reachable(&body.creature, &self.posture, target);
        body.creature.couple(&mut target);
        target
    }
}

/// Makes movers of a body, one per thread. Geoms that overlap by construction are left out for good.
pub struct Movers<'a> {
    pub(super) body: &'a Body,
    agent: &'a Agent,
    reader: ContactReader,
    pub(super) clearance: ConservativeAdvancement,
    /// The posture that bouts start from.
    pub(super) start: Posture,
    /// What carries it; `None` if motions are without forces.
    servo: Option<Servo>,
}

impl<'a> Movers<'a> {
    /// Movers of a body whose motions are of a kind.
    ///
    /// # Errors
    /// If there is no skin, or no two limbs can meet,
    /// and where the engine fails.
    pub fn new(body: &'a Body, agent: &'a Agent, motion: MotionName) -> Result<Movers<'a>, Error> {
        if agent.skin().receptors.is_empty() {
            let sentence = match body.surface().contains(&true) {
                true => "the model has no touch sensors; grow a skin with `bodyschema skin MODEL --out NEW`",
                false => {
                    "none of its limbs has a surface that can be touched; give geoms of shapes or meshes that can be read"
                }
            };
            return Err(Error::model(sentence));
        }
        let SelfContact { left_out, start, .. } = SelfContact::new(body)?;
        let reader = ContactReader::new(body, agent.skin());
        let clearance = ConservativeAdvancement::new(body, &left_out)?;
        if clearance.touchable.pairs.is_empty() {
            let joints: Vec<&str> = body.creature.joints().iter().map(|joint| joint.name.as_str()).collect();
            let joints = joints.join(", ");
            return Err(Error::new(
                Kind::NoContact,
                format!(
                    "no two of its limbs can touch: all limbs with a surface are neighbours or always overlap \
                     (see `bodyschema inspect`), so touches cannot determine {joints}; give limbs that reach each \
                     other"
                ),
            ));
        }
        let servo = match motion {
            MotionName::Kinematic => None,
            MotionName::Dynamic => Some(Servo::new(body)?),
        };
        Ok(Movers { body, agent, reader, clearance, start, servo })
    }

    /// What the agent whose body moves is given.
    pub fn agent(&self) -> &'a Agent {
        self.agent
    }

    /// Whether motions are by forces.
    pub fn is_dynamic(&self) -> bool {
        self.servo.is_some()
    }

    /// What a contact is to the agent where `data` has the body.
    pub(super) fn read(&self, data: &Data, contact: &Contact) -> Reading {
        self.reader.read(self.body, self.agent.skin(), data, contact)
    }

    /// How many contacts are of limbs that carry one another.
    pub(super) fn neighbours(&self, data: &Data) -> u64 {
        data.contacts().filter(|contact| self.read(data, contact) == Reading::Neighbours).count() as u64
    }

    /// A mover in the start posture.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn mover(&self) -> Result<Mover<'_>> {
        let motion: Box<dyn Motion> = match &self.servo {
            Some(servo) => Box::new(DynamicMotion::new(self, servo)?),
            None => Box::new(KinematicMotion::new(self)?),
        };
        let proprioception = Proprioception::new(self.body, ChaCha8Rng::seed_from_u64(0))?;
        Ok(Mover { body: self.body, motion, proprioception })
    }
}

/// A body that moves and stops at touch.
pub struct Mover<'a> {
    body: &'a Body,
    motion: Box<dyn Motion + 'a>,
    proprioception: Proprioception,
}

impl Mover<'_> {
    /// Begins a bout: at rest in the start posture, no effort made yet.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn reset(&mut self) -> Result<()> {
        self.motion.reset()
    }

    /// Draws the noise of its senses from another random stream from now on.
    pub fn draw_noise_from(&mut self, noise: ChaCha8Rng) {
        self.proprioception.draw_noise_from(noise);
    }

    /// Moves towards `target` until it touches itself or cannot get further.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn advance(&mut self, target: &[f64]) -> Result<Ending> {
        self.motion.advance(target)
    }

    /// The posture that it is really in; after a touch, that of the touch.
    pub fn posture(&self) -> &[f64] {
        &self.motion.moving().posture
    }

    /// The posture that it feels itself in.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn felt_posture(&mut self) -> Result<Posture> {
        self.proprioception.read(self.body, &self.motion.moving().posture)
    }

    /// When and how hard the touch was that the last motion ended in, if forces were at work.
    pub fn moment(&self) -> Option<Moment> {
        self.motion.moving().moment
    }

    /// What the motions of the bout cost so far.
    pub fn effort(&self) -> Effort {
        self.motion.moving().effort
    }

    /// The touch that the last motion ended in.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn touch(&mut self, bout: u64, met: Met) -> Result<RecordedTouch> {
        let (motion, posture) = (self.effort().motions, self.felt_posture()?);
        let ends = met.receptors.map(TouchEnd::at);
        Ok(RecordedTouch::new(
            Touch { bout, motion, posture, ends, moment: self.moment() },
            met.exact_contact,
        ))
    }
}
