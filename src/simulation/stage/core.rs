//! Advancing a stage step by step, with the creature's senses.

use std::any::Any;
use std::collections::BTreeSet;
use std::sync::Arc;

use super::carried::Carried;
use super::stillness::Stillness;
use crate::agent::Agent;
use crate::creature::{Body, Posture};
use crate::error::Result;
use crate::mujoco::{Data, JointKind, Model};
use crate::senses::{
    Aura, AuraEvent, ContactReader, FAINT, Sense, SensedStep, SkinContact, SkinSpot, TouchEvent, TouchSensor,
    Toucher,
};
use crate::simulation::probe::Probe;
use crate::simulation::sorted;
use crate::simulation::step::step;

/// What all senses tell of one step.
#[derive(Clone, Debug, Default)]
pub struct StepSenses {
    /// When the step began, seconds.
    pub time: f64,
    /// What touches the skin.
    pub contacts: Vec<SkinContact>,
    /// What the touch sensor makes of it.
    pub touches: Vec<TouchEvent>,
    /// What comes near, where the creature watches out for it.
    pub near: Vec<AuraEvent>,
}

/// What is on a stage and how it moves.
pub struct StageCore {
    pub body: Arc<Body>,
    pub agent: Agent,
    pub reader: ContactReader,
    /// What the engine computed of the last step.
    pub data: Data,
    /// The model that is simulated, before it is told which geoms touch, and which those are.
    pub untouched: Model,
    pub touchable: Vec<bool>,
    /// What looks for contacts of the creature with itself, too, until it moves: in the posture that it came with, what
    /// is in each other is so for good, and looking for it is dear.
    pub with_self_touch: Option<Data>,
    /// Per coordinate and per degree of freedom of the engine, whether it is the creature's.
    pub own_qpos: Vec<bool>,
    pub own_dof: Vec<bool>,
    /// Geoms that pass through each other: those of the creature that overlap by construction, and what it stands in at
    /// ease, as feet in a floor; the lesser number first.
    pub overlapping: BTreeSet<[usize; 2]>,
    pub probes: Vec<Probe>,
    pub carried: Vec<Carried>,
    pub stillness: Stillness,
    /// Where the creature really is.
    pub posture: Posture,
    /// Simulated time, seconds.
    pub time: f64,
    /// The senses of [`SENSES`](crate::senses::SENSES), in its order.
    pub senses: Vec<Box<dyn Sense>>,
}

impl StageCore {
    /// Lets the senses take in the posture that the creature was put into.
    pub fn feel_placed(&mut self) -> Result<()> {
        self.each_sense(self.time, &[], |sense, step| sense.place(step))
    }

    fn each_sense(
        &mut self,
        time: f64,
        contacts: &[SkinContact],
        mut take_in: impl FnMut(&mut dyn Sense, &SensedStep) -> Result<()>,
    ) -> Result<()> {
        let StageCore { agent, body, posture, data, senses, .. } = self;
        let step = SensedStep { time, agent, body, posture, data, contacts };
        senses.iter_mut().try_for_each(|sense| take_in(sense.as_mut(), &step))
    }

    /// Asks one of its senses, by its type.
    pub fn sense<S: Sense, T>(&mut self, ask: impl FnOnce(&mut S) -> T) -> T {
        let mut senses = self.senses.iter_mut();
        let found = senses.find_map(|sense| (sense.as_mut() as &mut dyn Any).downcast_mut());
        ask(found.expect("the creature has this sense"))
    }

    /// Goes on by one step, at whose end the creature is in a posture: all that it feels.
    pub fn step(&mut self, towards: &[f64]) -> Result<StepSenses> {
        let time = self.time;
        let contacts = if self.go_on(towards)? { self.contacts() } else { Vec::new() };
        self.each_sense(time, &contacts, |sense, step| sense.step(step))?;
        let touches = self.sense(|sensor: &mut TouchSensor| sensor.events().to_vec());
        let near = self.sense(|aura: &mut Aura| aura.events().to_vec());
        Ok(StepSenses { time, contacts, touches, near })
    }

    /// Goes on by one step of which nothing is felt yet: whether anything may touch the creature in it.
    pub fn go_on(&mut self, towards: &[f64]) -> Result<bool> {
        let time = self.time;
        self.time += self.body.model.timestep();
        if *towards != *self.posture {
            self.look_for_self_touch()?;
        }
        let before = std::mem::replace(&mut self.posture, Posture::from(towards));
        let quiet = self.stillness.is_still()
            && self.carried.is_empty()
            && self.probes.iter().all(|probe| probe.rests(time));
        // Where all things lie still, only contacts are looked for until there is one.
        if quiet && !self.touches()? {
            return Ok(false);
        }
        let still = quiet.then(|| [self.data.qpos().to_vec(), self.data.qvel().to_vec()]);
        self.advance(&before, time)?;
        // What lies still is felt before it is pushed: who touches it can stop there.
        if let Some([qpos, qvel]) = still {
            self.data.set_qpos(&qpos)?;
            self.data.set_qvel(&qvel)?;
        }
        Ok(true)
    }

    /// Whether anything touches the creature, as far as can be told without forces.
    fn touches(&mut self) -> Result<bool> {
        let qpos = self.qpos_with(&self.posture);
        self.data.set_qpos(&qpos)?;
        self.collide()?;
        let (mut touches, mut moves) = (false, false);
        for contact in self.data.contacts().filter(|contact| contact.distance < 0.0) {
            let limbs = contact.geoms.map(|geom| self.body.limb_of_geom(geom));
            if limbs != [None, None] && self.meets(contact.geoms) {
                touches = true;
                moves |= contact
                    .geoms
                    .iter()
                    .any(|&geom| self.free_joint(self.body.model.geom_body(geom)).is_some());
            }
        }
        if moves {
            self.stillness.disturb();
        }
        Ok(touches)
    }

    /// One step of the physics, the creature going from one posture to where it is to be.
    fn advance(&mut self, before: &[f64], time: f64) -> Result<()> {
        let duration = self.body.model.timestep();
        let mut qpos = self.qpos_with(&self.posture);
        let mut qvel = self.data.qvel().to_vec();
        let from = if *before == *self.posture { qpos.clone() } else { self.qpos_with(before) };
        for joint in self.body.model.joints().filter(|joint| self.own_dof[joint.dofadr]) {
            let (q, v) = (joint.qposadr, joint.dofadr);
            match joint.kind {
                JointKind::Hinge | JointKind::Slide => qvel[v] = (qpos[q] - from[q]) / duration,
                _ => qvel[v..v + joint.kind.nv()].fill(0.0),
            }
        }
        if !self.carried.is_empty() {
            self.data.set_qpos(&qpos)?;
            self.data.kinematics()?;
            for carried in &self.carried {
                carried.put(&self.body, &self.data, [time, time + duration], &mut qpos, &mut qvel);
            }
        }
        let StageCore { body, overlapping, carried, probes, own_dof, .. } = self;
        step(
            &mut self.data,
            (&qpos, &qvel),
            |geoms| meets(body, overlapping, carried, geoms),
            |data| {
                // The creature bears its own weight, and probes and what is carried are held; other things fall. The weight of
                // what is held would draw it away from what it meets from below, which would feel it too late.
                let bias = data.qfrc_bias().iter().zip(own_dof.iter());
                let mut forces: Vec<f64> = bias.map(|(bias, own)| if *own { *bias } else { 0.0 }).collect();
                for carried in carried.iter() {
                    let dofs = carried.dofadr..carried.dofadr + 6;
                    forces[dofs.clone()].copy_from_slice(&data.qfrc_bias()[dofs]);
                }
                for probe in probes.iter() {
                    let dofs = probe.dofadr..probe.dofadr + 3;
                    forces[dofs.clone()].copy_from_slice(&data.qfrc_bias()[dofs]);
                    probe.pull(time, &qpos, &qvel, &mut forces);
                }
                forces
            },
        )?;
        self.stillness.watch(self.data.qpos(), &self.own_qpos);
        Ok(())
    }

    /// What touches the skin in the step just made.
    fn contacts(&self) -> Vec<SkinContact> {
        let mut contacts = self.reader.skin_contacts(&self.body, self.agent.skin(), &self.data);
        // What a thing that is held meets is felt where it is held.
        for (carried, grip) in self.carried.iter().filter_map(|carried| Some((carried, carried.grip()?))) {
            for (contact, force) in self.data.pressing().filter(|(_, force)| *force >= FAINT) {
                let bodies = contact.geoms.map(|geom| self.body.model.geom_body(geom));
                if let Some(k) = bodies.iter().position(|body| *body == carried.body) {
                    let spot = SkinSpot { limb: grip.limb, receptor: grip.receptor };
                    contacts.push(SkinContact { spot, by: Toucher::Through(bodies[1 - k]), force });
                }
            }
        }
        contacts
    }

    /// From now on contacts of the creature with itself are looked for.
    pub fn look_for_self_touch(&mut self) -> Result<()> {
        if let Some(mut data) = self.with_self_touch.take() {
            data.take_state(&self.data)?;
            data.forward()?;
            self.data = data;
        }
        Ok(())
    }

    /// Puts something elsewhere at once: changes the engine's coordinates and velocities.
    pub fn put(&mut self, change: impl FnOnce(&Self, &mut [f64], &mut [f64])) -> Result<()> {
        let (mut qpos, mut qvel) = (self.data.qpos().to_vec(), self.data.qvel().to_vec());
        change(self, &mut qpos, &mut qvel);
        self.stillness.disturb();
        self.data.set_qpos(&qpos)?;
        Ok(self.data.set_qvel(&qvel)?)
    }

    /// Looks for contacts where all is.
    pub fn collide(&mut self) -> Result<()> {
        self.data.kinematics()?;
        Ok(self.data.collision()?)
    }

    /// Whether two geoms act on each other.
    pub fn meets(&self, geoms: [usize; 2]) -> bool {
        meets(&self.body, &self.overlapping, &self.carried, geoms)
    }

    /// The first coordinate and velocity of a body that moves freely.
    pub(super) fn free_joint(&self, body: usize) -> Option<(usize, usize)> {
        let mut joints = self.body.model.joints();
        let joint = joints.find(|joint| joint.body == body && joint.kind == JointKind::Free)?;
        Some((joint.qposadr, joint.dofadr))
    }

    /// The engine's coordinates with the creature in a posture and all else as it is.
    pub fn qpos_with(&self, posture: &[f64]) -> Vec<f64> {
        let mut qpos = self.body.qpos(posture);
        for ((q, present), own) in qpos.iter_mut().zip(self.data.qpos()).zip(&self.own_qpos) {
            if !own {
                *q = *present;
            }
        }
        qpos
    }
}

/// Whether two geoms act on each other: not where they always overlap, nor a limb and one that carries it, nor what is
/// held and the limbs about it.
fn meets(body: &Body, overlapping: &BTreeSet<[usize; 2]>, carried: &[Carried], geoms: [usize; 2]) -> bool {
    if overlapping.contains(&sorted(geoms)) {
        return false;
    }
    match geoms.map(|geom| body.limb_of_geom(geom)) {
        [Some(a), Some(b)] => !body.creature.neighbouring(a, b),
        [Some(limb), None] | [None, Some(limb)] => {
            let bodies = geoms.map(|geom| body.model.geom_body(geom));
            let near = |carried: &Carried| {
                let grip = carried.grip().filter(|_| bodies.contains(&carried.body));
                grip.is_some_and(|grip| body.creature.neighbouring(grip.limb, limb))
            };
            !carried.iter().any(near)
        }
        [None, None] => true,
    }
}
