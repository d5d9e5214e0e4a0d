//! A creature that holds still while probes touch it, on MuJoCo's physics.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use nalgebra::Vector3;

use crate::creature::{Body, BodyError, JointSelection};
use crate::mjcf_xml::{element, exact};
use crate::mujoco::{self, Data, LONGEST_STEP, Model};
use crate::senses::{ContactReader, SkinContact, TouchEvent, TouchSensor, skin_contacts};
use crate::skin::{GrowError, GrowOptions, Skin, SomatotopicMap, grow};

/// The radius of a probe, a ball like a fingertip, metres.
pub const PROBE_RADIUS: f64 = 0.008;
/// Its mass, kilogrammes.
const MASS: f64 = 0.05;
/// How stiffly it is held to its path, newtons a metre: as deep as its path goes under the skin, so hard it presses.
pub(super) const STIFFNESS: f64 = 400.0;
/// Where probes wait, metres along the world's x axis.
const AWAY: f64 = 100.0;
/// Damping ratio of that.
const DAMPING_RATIO: f64 = 1.0;

/// Why there is no such world.
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// The engine refused the model.
    #[error(transparent)]
    Engine(#[from] mujoco::Error),
    /// There is no creature in it.
    #[error(transparent)]
    Body(#[from] BodyError),
    /// It has no skin, and none could be grown.
    #[error(transparent)]
    Skin(#[from] GrowError),
}

/// Where a probe's middle is to be, at which time: seconds and metres in the world's frame, in order of time. In
/// between it goes straight; before and after it stays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProbePath(pub Vec<(f64, Vector3<f64>)>);

impl ProbePath {
    /// Where the middle is to be at a time.
    pub fn at(&self, time: f64) -> Option<Vector3<f64>> {
        let next = self.0.partition_point(|(t, _)| *t <= time);
        let before = next.checked_sub(1).map(|k| self.0[k]);
        match (before, self.0.get(next)) {
            (Some((t0, p0)), Some((t1, p1))) => Some(p0 + (p1 - p0) * ((time - t0) / (t1 - t0))),
            (Some((_, p)), None) | (None, Some(&(_, p))) => Some(p),
            (None, None) => None,
        }
    }

    /// When it ends, seconds.
    pub fn end(&self) -> f64 {
        self.0.last().map_or(0.0, |(t, _)| *t)
    }
}

/// A creature with skin, and probes. The creature holds its posture whatever touches it; probes are held to their
/// paths by springs.
pub struct World {
    /// The creature in its model, probes included.
    pub body: Body,
    /// Its skin.
    pub skin: Skin,
    /// What the engine computed of the last step.
    pub data: Data,
    reader: ContactReader,
    sensor: TouchSensor,
    probes: Vec<Probe>,
    held: Vec<f64>,
    /// What looks for contacts of the creature with itself, too, until it is needed: in the posture that the creature
    /// came with, what is in each other is so for good, and looking for it is dear.
    with_self_touch: Option<Data>,
    /// Geoms that overlap for good: what is in each other where the creature stands at ease.
    overlapping: BTreeSet<[usize; 2]>,
}

/// A probe in the model: a ball on three slides.
struct Probe {
    body: usize,
    qposadr: usize,
    dofadr: usize,
    path: ProbePath,
}

impl World {
    /// A creature of the file at `path` in its reference posture, all its joints, and probes of these names far away
    /// from it. It grows a skin where it has none.
    ///
    /// # Errors
    /// See [`WorldError`].
    pub fn new(path: &Path, creature: &Body, probes: &[String]) -> Result<World, WorldError> {
        // Which of the model's trees is the creature must not depend on what touches it.
        let first = || creature.limb_of_body.iter().position(|limb| limb.is_some_and(|limb| limb > 0));
        let root = if creature.root > 0 { Some(creature.root) } else { first() };
        let root = root.and_then(|body| creature.model.body(body).name);
        let declared = Arc::new(Model::with_bodies(path, probes.iter().map(|name| ball(name)).collect())?);
        let mut body = Body::rooted(declared.clone(), &JointSelection::All, root)?;
        let skin = grow(&body, &GrowOptions::default())?;
        let at = |name: &str| (0..declared.nbody()).find(|&b| declared.body(b).name == Some(name));
        let bodies: Vec<usize> = probes.iter().filter_map(|name| at(name)).collect();
        let probe_geom = |g: usize| bodies.contains(&declared.geom_body(g));
        let touchable: Vec<bool> = (0..declared.ngeom()).map(|g| body.feels(g) || probe_geom(g)).collect();
        // Whoever holds still does not give way; the probes alone move.
        let mut rigid = vec![true; declared.nv()];
        for joint in declared.joints().filter(|joint| bodies.contains(&joint.body)) {
            rigid[joint.dofadr..joint.dofadr + joint.kind.nv()].fill(false);
        }
        let step = declared.timestep().min(LONGEST_STEP);
        let simulated = declared.simulated(step, &rigid)?;
        body.model = Arc::new(simulated.touching_with(&touchable)?);
        let probes = bodies.iter().map(|&at| {
            let first = body.model.joints().find(|joint| joint.body == at).expect("a probe has slides");
            let path = ProbePath::default();
            Probe { body: at, qposadr: first.qposadr, dofadr: first.dofadr, path }
        });
        let probes: Vec<Probe> = probes.collect();
        // While the creature holds the posture that it came with, contacts of its own are not even looked for.
        let own: Vec<bool> = (0..declared.ngeom()).map(|g| !probe_geom(g)).collect();
        let data = Data::new(Arc::new(simulated.touching_others(&touchable, &own)?))?;
        let mut with_self_touch = Data::new(body.model.clone())?;
        with_self_touch.forward()?;
        let overlapping = with_self_touch.contacts().map(|contact| contact.geoms).collect();
        let with_self_touch = Some(with_self_touch);
        let reader = ContactReader::new(&body, &skin);
        let sensor = TouchSensor::new(SomatotopicMap::new(&skin));
        let held = data.qpos().to_vec();
        let mut world =
            World { body, skin, data, reader, sensor, probes, held, with_self_touch, overlapping };
        (0..world.probes.len()).try_for_each(|probe| world.withdraw(probe))?;
        world.data.forward()?;
        Ok(world)
    }

    /// The model's body of a probe.
    pub fn probe_body(&self, probe: usize) -> usize {
        self.probes[probe].body
    }

    /// Puts a probe to the beginning of a path, at rest, and lets it follow from now on.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn send(&mut self, probe: usize, path: ProbePath) -> mujoco::Result<()> {
        let probe = &mut self.probes[probe];
        if let Some(start) = path.at(self.data.time()) {
            let (mut qpos, mut qvel) = (self.data.qpos().to_vec(), self.data.qvel().to_vec());
            qpos[probe.qposadr..probe.qposadr + 3].copy_from_slice(start.as_slice());
            qvel[probe.dofadr..probe.dofadr + 3].fill(0.0);
            probe.path = path;
            self.data.set_qpos(&qpos)?;
            self.data.set_qvel(&qvel)?;
        }
        Ok(())
    }

    /// Puts a probe far from the creature, and from other probes, until it is sent again.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn withdraw(&mut self, probe: usize) -> mujoco::Result<()> {
        let away = Vector3::new(AWAY + probe as f64, 0.0, 0.0);
        self.send(probe, ProbePath(vec![(self.data.time(), away)]))
    }

    /// Lets the creature hold the engine's coordinates of its model without probes from now on: radians, metres and
    /// quaternions as there, and no more of them than there.
    ///
    /// # Errors
    /// Where the engine fails.
    ///
    /// # Panics
    /// Where there are more of them than the creature has.
    pub fn hold_qpos(&mut self, qpos: &[f64]) -> mujoco::Result<()> {
        // Probes are added behind all else that is in the world.
        let own = self.probes.iter().map(|probe| probe.qposadr).min().unwrap_or(self.held.len());
        assert!(qpos.len() <= own, "{} coordinates, but the creature has {own}", qpos.len());
        self.held[..qpos.len()].copy_from_slice(qpos);
        if let Some(mut data) = self.with_self_touch.take() {
            data.take_state(&self.data)?;
            data.forward()?;
            self.data = data;
        }
        Ok(())
    }

    /// Simulates one step of the physics: what the skin feels in it, and its time, seconds.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn physics(&mut self) -> mujoco::Result<f64> {
        // Whoever holds still neither falls nor gives way.
        let (mut qpos, mut qvel) = (self.held.clone(), vec![0.0; self.body.model.nv()]);
        for probe in &self.probes {
            let (q, v) = (probe.qposadr..probe.qposadr + 3, probe.dofadr..probe.dofadr + 3);
            qpos[q.clone()].copy_from_slice(&self.data.qpos()[q]);
            qvel[v.clone()].copy_from_slice(&self.data.qvel()[v]);
        }
        self.data.set_qpos(&qpos)?;
        self.data.set_qvel(&qvel)?;
        let time = self.data.time();
        self.data.step1()?;
        let mut forces = self.data.qfrc_bias().to_vec();
        let damping = 2.0 * DAMPING_RATIO * (STIFFNESS * MASS).sqrt();
        for probe in &self.probes {
            let Some(target) = probe.path.at(time) else { continue };
            for k in 0..3 {
                let miss = target[k] - qpos[probe.qposadr + k];
                // The spring leads the way: damping is against the path's own speed.
                let ahead = probe.path.at(time + 1e-3).map_or(0.0, |next| (next[k] - target[k]) / 1e-3);
                let slower = ahead - qvel[probe.dofadr + k];
                forces[probe.dofadr + k] += STIFFNESS * miss + damping * slower;
            }
        }
        self.data.set_qfrc_applied(&forces)?;
        let (body, overlapping) = (&self.body, &self.overlapping);
        self.data.let_pass(|geoms| match geoms.map(|geom| body.limb_of_geom(geom)) {
            [Some(a), Some(b)] => !body.creature.neighbouring(a, b) && !overlapping.contains(&geoms),
            _ => true,
        })?;
        self.data.step2()?;
        Ok(time)
    }

    /// What the skin feels of the last step.
    pub fn skin_contacts(&self) -> Vec<SkinContact> {
        skin_contacts(&self.body, &self.skin, &self.reader, &self.data)
    }

    /// Simulates one step and feels it: the time, seconds, and what the touch sensor tells.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn step(&mut self) -> mujoco::Result<(f64, Vec<TouchEvent>)> {
        self.step_contacts().map(|(time, _, events)| (time, events))
    }

    /// The same, with the contacts that the touch sensor made them of.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn step_contacts(&mut self) -> mujoco::Result<(f64, Vec<SkinContact>, Vec<TouchEvent>)> {
        let time = self.physics()?;
        let contacts = self.skin_contacts();
        let events = self.sensor.step(time, &contacts);
        Ok((time, contacts, events))
    }
}

/// A probe's body: a smooth ball on three slides whose coordinates are its place in the world.
fn ball(name: &str) -> xmltree::Element {
    let mut body = element("body", &[("name", name.into()), ("pos", "0 0 0".into())]);
    let inertia = 0.4 * MASS * PROBE_RADIUS * PROBE_RADIUS;
    let inertial = [
        ("pos", "0 0 0".into()),
        ("mass", exact(&[MASS])),
        ("diaginertia", exact(&[inertia, inertia, inertia])),
    ];
    body.children.push(xmltree::XMLNode::Element(element("inertial", &inertial)));
    for (k, axis) in ["1 0 0", "0 1 0", "0 0 1"].into_iter().enumerate() {
        let joint = [
            ("name", format!("{name}_{k}")),
            ("type", "slide".into()),
            ("pos", "0 0 0".into()),
            ("axis", axis.into()),
            ("limited", "false".into()),
            ("damping", "0".into()),
            ("stiffness", "0".into()),
            ("armature", "0".into()),
            ("frictionloss", "0".into()),
        ];
        body.children.push(xmltree::XMLNode::Element(element("joint", &joint)));
    }
    let geom = [
        ("name", name.into()),
        ("type", "sphere".into()),
        ("size", exact(&[PROBE_RADIUS])),
        // Where the file has inertia taken from geoms, and where not: the same.
        ("mass", exact(&[MASS])),
        ("contype", "1".into()),
        ("conaffinity", "1".into()),
        ("condim", "3".into()),
        ("friction", "0.2 0.001 0.0001".into()),
    ];
    body.children.push(xmltree::XMLNode::Element(element("geom", &geom)));
    body
}
