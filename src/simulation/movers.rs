//! What moves a body until it touches itself.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::advancement::ConservativeAdvancement;
use super::dynamic::{DynamicMotion, Servo};
use super::kinematic::KinematicMotion;
use super::motion::{Effort, Ending, Met, Motion, MotionName, MovableBody};
use super::self_contact::SelfContact;
use crate::agent::Agent;
use crate::creature::{Body, Posture};
use crate::error::{Error, Kind, Result};
use crate::senses::{ContactReader, Moment, Proprioception, RecordedTouch};

/// Makes movers of a body, one per thread. Geoms that overlap by construction are left out for good.
pub struct Movers<'a> {
    of: MovableBody<'a>,
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
            let sentence =
                "the model has no touch sensors: grow a skin with `bodyschema skin MODEL --out NEW`";
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
                    "no two of its limbs can touch: all that bear surface carry one another or overlap for good \
                     (`bodyschema inspect` has the table), so no touch can determine {joints}; give limbs that reach each other"
                ),
            ));
        }
        let servo = match motion {
            MotionName::Kinematic => None,
            MotionName::Dynamic => Some(Servo::new(body)?),
        };
        Ok(Movers { of: MovableBody { body, agent, reader, clearance, start }, servo })
    }

    /// What the agent whose body moves is given.
    pub fn agent(&self) -> &'a Agent {
        self.of.agent
    }

    /// Whether motions are by forces.
    pub fn is_dynamic(&self) -> bool {
        self.servo.is_some()
    }

    /// A mover in the start posture.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn mover(&self) -> Result<Mover<'_>> {
        let motion: Box<dyn Motion> = match &self.servo {
            Some(servo) => Box::new(DynamicMotion::new(&self.of, servo)?),
            None => Box::new(KinematicMotion::new(&self.of)?),
        };
        let proprioception = Proprioception::new(self.of.body, ChaCha8Rng::seed_from_u64(0))?;
        Ok(Mover { body: self.of.body, motion, proprioception })
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
        Ok(met.recorded(bout, motion, posture, self.moment()))
    }
}
