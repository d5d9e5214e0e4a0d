//! The stage: a creature among things and probes on MuJoCo's physics, and all that it feels.
//!
//! The creature's joints go where it wills, whatever is in their way: it is up to it to stop when it feels something.
//! Things fall, slide and are pushed. A thing can be held: it is welded to the limb that touches it, from then on until
//! it is let go. Probes press on whatever their paths lead through. All senses run on every step: touch, proximity and
//! posture.
//!
//! A [`Stage`] is the side of those who look on, put things and measure; an [`AgentHandle`](super::AgentHandle) is all
//! that the creature has of it.

mod building;
mod carried;
mod carrying;
mod core;
mod stillness;

use std::cell::{Ref, RefCell};
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use nalgebra::{Isometry3, Vector3};

pub use self::core::StepSenses;

use self::carried::Carrier;
use self::core::StageCore;
use super::{AgentHandle, ProbePath, Thing};
use crate::agent::Agent;
use crate::creature::{Body, JointSelection, Posture, body_name};
use crate::error::{Error, Result};
use crate::geometry::Frame;
use crate::mujoco::Data;
use crate::senses::{ContactReader, NewSense, Sense, SkinContact, TouchSensor};
use crate::skin::Skin;

/// What is on a stage beside what its file has.
#[derive(Clone, Debug, Default)]
pub struct StageOptions {
    /// The joints that the creature moves.
    pub joints: JointSelection,
    /// The body at which the creature begins; none for that of the file's tree with most joints.
    pub root: Option<String>,
    /// Things put there.
    pub things: Vec<Thing>,
    /// The names of probes, which wait far away.
    pub probes: Vec<String>,
    /// Senses of the creature beside [`SENSES`](crate::senses::SENSES).
    pub senses: Vec<NewSense>,
}

/// Who looks on: is told of every step that the creature makes, and of what it feels in it.
pub type Watcher = Box<dyn FnMut(&Stage, &[SkinContact])>;

/// A creature among things and probes, for those who look on, put things and measure. Clones are of the same stage.
#[derive(Clone)]
pub struct Stage {
    body: Arc<Body>,
    agent: Agent,
    pub(super) core: Rc<RefCell<StageCore>>,
    watcher: Rc<RefCell<Option<Watcher>>>,
}

impl Stage {
    /// The creature of a file, in the posture nearest to its reference posture, among what else the file has and what the
    /// options say. It grows a skin where it has none.
    ///
    /// # Errors
    /// If there is no creature in the model, no skin can be grown on it, or the engine refuses it.
    pub fn new(path: &Path, options: &StageOptions) -> Result<Stage, Error> {
        let core = building::build(path, options)?;
        let (body, agent) = (core.body.clone(), core.agent.clone());
        Ok(Stage { body, agent, core: Rc::new(RefCell::new(core)), watcher: Rc::default() })
    }

    /// All that the creature has of the stage.
    pub fn handle(&self) -> AgentHandle {
        AgentHandle { stage: self.clone() }
    }

    /// What the creature is given about itself.
    pub fn agent(&self) -> &Agent {
        &self.agent
    }

    /// The creature in its model, all that is on the stage included.
    pub fn body(&self) -> &Body {
        &self.body
    }

    /// Its skin.
    pub fn skin(&self) -> &Skin {
        self.agent.skin()
    }

    /// What the engine computed of the last step; not to be kept while the stage goes on.
    pub fn data(&self) -> Ref<'_, Data> {
        Ref::map(self.core.borrow(), |core| &core.data)
    }

    /// The length of a step, seconds.
    pub fn timestep(&self) -> f64 {
        self.body.model.timestep()
    }

    /// Simulated time, seconds.
    pub fn time(&self) -> f64 {
        self.core.borrow().time
    }

    /// The posture that the creature is really in.
    pub fn posture(&self) -> Posture {
        self.core.borrow().posture.clone()
    }

    /// Lets somebody look on from now on. What is simulated stays the same.
    pub fn watched_by(&self, watcher: Watcher) {
        *self.watcher.borrow_mut() = Some(watcher);
    }

    /// Puts the creature into a posture at once.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn place(&self, posture: &[f64]) -> Result<()> {
        let core = &mut *self.core.borrow_mut();
        core.look_for_self_touch()?;
        core.posture = Posture::from(posture);
        core.data.set_qpos(&core.qpos_with(posture))?;
        core.data.forward()?;
        core.feel_placed()
    }

    /// Goes on by one step while the creature holds still: all that it feels.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn step(&self) -> Result<StepSenses> {
        let posture = self.posture();
        Ok(self.step_towards(&posture)?.0)
    }

    /// Goes on by one step while the creature holds still and feels nothing: what the physics alone takes.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn step_unfelt(&self) -> Result<()> {
        let posture = self.posture();
        self.core.borrow_mut().go_on(&posture).map(|_| ())
    }

    /// Goes on by one step, at whose end the creature is in a posture: what its senses tell, and what its touch sensor
    /// feels now.
    pub(super) fn step_towards(&self, towards: &[f64]) -> Result<(StepSenses, Vec<SkinContact>)> {
        let mut core = self.core.borrow_mut();
        let senses = core.step(towards)?;
        let present: Vec<SkinContact> =
            core.sense(|sensor: &mut TouchSensor| sensor.present().cloned().collect());
        drop(core);
        // Who looks on may ask the stage anything.
        let watcher = self.watcher.borrow_mut().take();
        if let Some(mut watcher) = watcher {
            watcher(self, &present);
            self.watcher.borrow_mut().get_or_insert(watcher);
        }
        Ok((senses, present))
    }

    /// Asks one of the creature's senses, by its type.
    ///
    /// # Panics
    /// If it is neither among [`SENSES`](crate::senses::SENSES) nor among those that the stage was set up with.
    pub fn sense<S: Sense, T>(&self, ask: impl FnOnce(&mut S) -> T) -> T {
        self.core.borrow_mut().sense(ask)
    }

    /// Lets a limb grow: the joint that moves it is farther out by `length`, metres, on the limb that carries it from now on,
    /// or nearer where that is negative. All else stays as it is, the skin of either limb and [`Stage::body`] too. The
    /// creature is not told.
    ///
    /// # Errors
    /// Where the engine fails.
    ///
    /// # Panics
    /// Where there is no such limb.
    pub fn grow_limb(&self, limb: usize, length: f64) -> Result<()> {
        let core = &mut *self.core.borrow_mut();
        core.look_for_self_touch()?;
        let Some(segment) = limb.checked_sub(1).map(|joint| &core.body.segments[joint]) else {
            return Ok(());
        };
        let position = core.untouched.body(segment.body).pos;
        let Some(outward) = position.try_normalize(1e-6) else { return Ok(()) };
        core.untouched = core.untouched.with_body_position(segment.body, &(position + outward * length))?;
        let grown = Arc::new(core.untouched.touching_with(&core.touchable)?);
        let mut data = Data::new(grown.clone())?;
        data.take_state(&core.data)?;
        data.forward()?;
        Arc::make_mut(&mut core.body).model = grown;
        core.reader = ContactReader::new(&core.body, core.agent.skin());
        core.data = data;
        core.stillness.disturb();
        Ok(())
    }

    /// Lets a thing go along a path alone, whatever it meets.
    ///
    /// # Panics
    /// Where it is no thing that moves.
    pub fn send_thing(&self, thing: usize, path: ProbePath) {
        let core = &mut *self.core.borrow_mut();
        let turn = core.data.body_pose(thing).rotation;
        assert!(core.carry(thing, Carrier::Path(path, turn)), "a thing that moves is sent");
    }

    /// Puts a stick into the hand of a receptor, which holds it: where one end of it is, metres, and where it leads from there, in
    /// the hand's frame; whether the thing is a stick, one slender capsule or cylinder that moves freely, and meets nothing
    /// there.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn give_stick(
        &self,
        thing: usize,
        receptor: usize,
        end: &Vector3<f64>,
        direction: &Vector3<f64>,
    ) -> Result<bool> {
        self.core.borrow_mut().give_stick(thing, receptor, end, direction)
    }

    /// Puts a probe to the beginning of a path, at rest, and lets it follow from now on; by an empty path it goes far from the
    /// creature, and from other probes.
    ///
    /// # Errors
    /// Where the engine fails.
    ///
    /// # Panics
    /// Where there is no such probe.
    pub fn send_probe(&self, probe: usize, path: ProbePath) -> Result<()> {
        let core = &mut *self.core.borrow_mut();
        let start = path.at(core.time).unwrap_or_else(|| building::away(probe));
        core.probes[probe].path = if path.0.is_empty() { ProbePath(vec![(core.time, start)]) } else { path };
        core.put(|core, qpos, qvel| core.probes[probe].put(&start, qpos, qvel))
    }

    /// The number of a thing, or of a probe, by its name.
    pub fn thing(&self, name: &str) -> Option<usize> {
        (0..self.body.model.nbody()).find(|&b| self.body.model.body(b).name == Some(name))
    }

    /// The name of a thing by its number.
    pub fn thing_name(&self, thing: usize) -> String {
        body_name(&self.body.model, thing)
    }

    /// `X_WT`: where a thing is.
    pub fn thing_pose(&self, thing: usize) -> Isometry3<f64> {
        self.core.borrow().data.body_pose(thing)
    }

    /// Where a limb and a thing touch in the last step, in the frame of the thing, metres.
    pub fn touching_at(&self, limb: usize, thing: usize) -> Option<Vector3<f64>> {
        let core = self.core.borrow();
        core.data.contacts().find_map(|contact| {
            let limbs = contact.geoms.map(|geom| core.body.limb_of_geom(geom));
            let bodies = contact.geoms.map(|geom| core.body.model.geom_body(geom));
            (limbs.contains(&Some(limb)) && bodies.contains(&thing))
                .then(|| core.data.body_pose(thing).inverse_transform_point(&contact.position).coords)
        })
    }

    /// `X_WR`: where the root of the creature is.
    pub fn root_pose(&self) -> Isometry3<f64> {
        self.limb_pose(0)
    }

    /// `X_WL`: where a limb is.
    pub fn limb_pose(&self, limb: usize) -> Isometry3<f64> {
        let core = self.core.borrow();
        core.body.limb_pose(&core.data, limb).unwrap_or_default()
    }

    /// `X_WL` of every limb.
    pub fn limb_frames(&self) -> Vec<Frame> {
        let core = self.core.borrow();
        core.body.limb_frames(&core.data)
    }
}
