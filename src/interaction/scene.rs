//! A creature that moves among things, on MuJoCo's physics.
//!
//! The creature's joints go where it wills, whatever is in their way: it is up to it to stop when it feels something.
//! Things fall, slide and are pushed. A thing can be held: it is welded to the limb that touches it, from then on until
//! it is let go. What the creature feels of all this is [`Scene::step`]'s; where things really are is for those who
//! measure it.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

use super::world::{ProbePath, WorldError};
use crate::babbling::SelfContact;
use crate::creature::{Body, JointSelection, body_name};
use crate::mjcf_xml::{element, exact};
use crate::mujoco::{self, Contact, Data, JointKind, LONGEST_STEP, Model};
use crate::senses::ContactReader;
use crate::skin::{GrowOptions, Shape, Skin, grow};

/// Contacts shallower than this are not felt, metres: what lies on something rests in it by as much.
const FELT: f64 = 1e-5;

/// Steps over which things are watched: those lie still that are …
const WATCH: usize = 30;
/// … no farther from where they were, metres and shares of a turn.
const STILL: f64 = 3e-4;

/// A thing of one shape that is put into a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Thing {
    /// Its name, which no other body of the scene has.
    pub name: String,
    /// Its shape; no mesh.
    pub shape: Shape,
    /// `X_WT`: where it is at first, in the world.
    pub pose: Isometry3<f64>,
    /// Whether it stays there whatever touches it.
    pub fixed: bool,
}

/// Something that is felt in one step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Feeling {
    /// The receptor.
    pub receptor: usize,
    /// What touches it.
    pub what: Touched,
}

/// What touches a receptor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Touched {
    /// One's own skin, at this receptor.
    Own(usize),
    /// Something else, told from others by a number.
    Thing(usize),
    /// Something that the thing held there touches.
    Through(usize),
}

/// A thing that does not move by itself for now.
struct Carried {
    body: usize,
    qposadr: usize,
    dofadr: usize,
    by: Carrier,
}

enum Carrier {
    /// A limb, and `X_LT`; and the receptor that it is held with.
    Limb(usize, Isometry3<f64>, usize),
    /// A path of its origin through the world, and its orientation.
    Path(ProbePath, UnitQuaternion<f64>),
}

/// A creature among things.
pub struct Scene {
    /// The creature in the scene's model.
    pub body: Body,
    /// Its skin.
    pub skin: Skin,
    /// What the engine computed of the last step.
    pub data: Data,
    reader: ContactReader,
    posture: Vec<f64>,
    /// Per coordinate and per degree of freedom of the engine, whether it is the creature's.
    own_qpos: Vec<bool>,
    own_dof: Vec<bool>,
    carried: Vec<Carried>,
    /// Simulated time, seconds.
    time: f64,
    /// Whether all things lie still.
    asleep: bool,
    /// Steps since they were looked at, and the engine's coordinates then.
    watched: usize,
    before: Vec<f64>,
    /// Geoms that do not feel each other: those of the creature that overlap by construction, and what it stands in at
    /// ease, as feet in a floor; the lesser number first.
    overlapping: BTreeSet<[usize; 2]>,
    watcher: Option<Watcher>,
}

/// Who looks on: is told of every step, and of what the creature feels in it.
pub type Watcher = Box<dyn FnMut(&Scene, &[Feeling])>;

impl Scene {
    /// The creature of a file, or of `root` in it, among what else is there and some things more.
    ///
    /// # Errors
    /// See [`WorldError`].
    pub fn new(
        path: &Path,
        selection: &JointSelection,
        root: Option<&str>,
        things: &[Thing],
    ) -> Result<Scene, WorldError> {
        let declared = Arc::new(Model::with_bodies(path, things.iter().map(described).collect())?);
        let mut body = Body::rooted(declared.clone(), selection, root)?;
        let skin = grow(&body, &GrowOptions::default())?;
        let solid = |g: usize| {
            let geom = declared.geom(g);
            body.limb_of_geom(g).is_none() && (geom.contype | geom.conaffinity) != 0
        };
        let touchable: Vec<bool> = (0..declared.ngeom()).map(|g| body.feels(g) || solid(g)).collect();
        let own = |b: usize| body.limb_of_body[b].is_some();
        let (mut own_qpos, mut own_dof) = (vec![false; declared.nq()], vec![false; declared.nv()]);
        for joint in declared.joints().filter(|joint| own(joint.body)) {
            own_qpos[joint.qposadr..joint.qposadr + joint.kind.nq()].fill(true);
            own_dof[joint.dofadr..joint.dofadr + joint.kind.nv()].fill(true);
        }
        let left_out = SelfContact::new(&body)?.left_out;
        let step = declared.timestep().min(LONGEST_STEP);
        body.model = Arc::new(declared.simulated(step, &own_dof)?.touching_with(&touchable)?);
        let reader = ContactReader::new(&body, &skin);
        let data = Data::new(body.model.clone())?;
        let posture = crate::babbling::start_posture(&body.creature);
        let mut scene = Scene {
            body,
            skin,
            data,
            reader,
            posture,
            own_qpos,
            own_dof,
            carried: Vec::new(),
            time: 0.0,
            asleep: false,
            watched: 0,
            before: vec![f64::INFINITY; declared.nq()],
            overlapping: left_out,
            watcher: None,
        };
        let at_ease = scene.posture.clone();
        scene.place(&at_ease)?;
        let creature = |geoms: [usize; 2]| geoms.iter().any(|&g| scene.body.limb_of_geom(g).is_some());
        let overlapping = scene.data.contacts().map(|contact| sorted(contact.geoms));
        let overlapping: BTreeSet<_> = overlapping.filter(|geoms| creature(*geoms)).collect();
        scene.overlapping.extend(overlapping);
        Ok(scene)
    }

    /// Puts the creature into a posture at once.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn place(&mut self, posture: &[f64]) -> mujoco::Result<()> {
        self.posture = posture.to_vec();
        let qpos = self.qpos_with(posture);
        self.data.set_qpos(&qpos)?;
        self.data.forward()
    }

    /// The posture that the creature is in.
    pub fn posture(&self) -> &[f64] {
        &self.posture
    }

    /// Unit vector against gravity in the root's frame, which its sense of balance tells.
    pub fn up(&self) -> Vector3<f64> {
        self.root_pose().inverse_transform_vector(&Vector3::z())
    }

    /// The length of a step, seconds.
    pub fn timestep(&self) -> f64 {
        self.body.model.timestep()
    }

    /// Simulated time, seconds.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Lets somebody look on from now on. What is simulated stays the same.
    pub fn watched_by(&mut self, watcher: Watcher) {
        self.watcher = Some(watcher);
    }

    /// Goes on by one step, the creature towards a posture at its end, and tells what it feels.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn step(&mut self, towards: &[f64]) -> mujoco::Result<Vec<Feeling>> {
        let felt = self.go_on(towards)?;
        if let Some(mut watcher) = self.watcher.take() {
            watcher(self, &felt);
            self.watcher = Some(watcher);
        }
        Ok(felt)
    }

    fn go_on(&mut self, towards: &[f64]) -> mujoco::Result<Vec<Feeling>> {
        let step = self.timestep();
        self.time += step;
        if self.asleep && self.carried.is_empty() {
            // Where all things lie still, nothing happens until one of them is touched: only contacts are looked at.
            self.posture = towards.to_vec();
            let qpos = self.qpos_with(towards);
            self.data.set_qpos(&qpos)?;
            self.data.kinematics()?;
            self.data.collision()?;
            let felt = self.feelings();
            let moves = |feeling: &Feeling| match feeling.what {
                Touched::Thing(thing) => self.free_joint(thing).is_some(),
                _ => false,
            };
            if felt.iter().any(moves) {
                (self.asleep, self.watched) = (false, 0);
            }
            return Ok(felt);
        }
        let mut qpos = self.qpos_with(&self.posture.clone());
        let mut qvel = self.data.qvel().to_vec();
        let next = self.qpos_with(towards);
        for joint in self.body.model.joints().filter(|joint| self.own_dof[joint.dofadr]) {
            let (q, v) = (joint.qposadr, joint.dofadr);
            match joint.kind {
                JointKind::Hinge | JointKind::Slide => qvel[v] = (next[q] - qpos[q]) / step,
                _ => qvel[v..v + joint.kind.nv()].fill(0.0),
            }
        }
        self.posture = towards.to_vec();
        self.carry(&mut qpos, &mut qvel)?;
        self.data.set_qpos(&qpos)?;
        self.data.set_qvel(&qvel)?;
        self.data.step1()?;
        // The creature bears its own weight; things fall.
        let bias = self.data.qfrc_bias().iter().zip(&self.own_dof);
        let forces: Vec<f64> = bias.map(|(bias, own)| if *own { *bias } else { 0.0 }).collect();
        self.data.set_qfrc_applied(&forces)?;
        let (body, overlapping, carried) = (&self.body, &self.overlapping, &self.carried);
        self.data.let_pass(|geoms| meets(body, overlapping, carried, geoms))?;
        self.data.step2()?;
        self.watched += 1;
        if self.watched == WATCH {
            let now: Vec<f64> = self.data.qpos().to_vec();
            let moved = now.iter().zip(&self.before).zip(&self.own_qpos).filter(|(_, own)| !**own);
            self.asleep = moved.fold(0.0, |most: f64, ((a, b), _)| most.max((a - b).abs())) < STILL;
            (self.watched, self.before) = (0, now);
        }
        Ok(self.feelings())
    }

    /// Welds the thing that a receptor touches to its limb; whether there was one.
    pub fn hold(&mut self, receptor: usize) -> bool {
        let limb = self.skin.receptors[receptor].limb;
        let touched = self.data.contacts().find_map(|contact| {
            let [a, b] = contact.geoms.map(|g| (self.body.limb_of_geom(g), self.body.model.geom_body(g)));
            let thing = match (a, b) {
                ((Some(l), _), (None, thing)) | ((None, thing), (Some(l), _)) if l == limb => thing,
                _ => return None,
            };
            self.free_joint(thing).map(|(q, v)| (thing, q, v))
        });
        let (Some((body, qposadr, dofadr)), Some(x_wl)) = (touched, self.body.limb_pose(&self.data, limb))
        else {
            return false;
        };
        let grip = x_wl.inv_mul(&self.data.body_pose(body));
        self.carried.retain(|carried| carried.body != body);
        self.carried.push(Carried { body, qposadr, dofadr, by: Carrier::Limb(limb, grip, receptor) });
        true
    }

    /// Lets go of all that is held.
    pub fn let_go(&mut self) {
        self.carried.retain(|carried| !matches!(carried.by, Carrier::Limb(..)));
    }

    /// Lets a thing go along a path by itself, whatever it meets.
    ///
    /// # Panics
    /// Where it is no thing that moves.
    pub fn send(&mut self, thing: usize, path: ProbePath) {
        let (qposadr, dofadr) = self.free_joint(thing).expect("a thing that moves");
        let turn = self.data.body_pose(thing).rotation;
        self.carried.retain(|carried| carried.body != thing);
        self.carried.push(Carried { body: thing, qposadr, dofadr, by: Carrier::Path(path, turn) });
    }

    /// Where on its limb a thing touches it, in the limb's frame, metres: what a sense of touch tells that is finer than
    /// its receptors.
    pub fn felt_point(&self, feeling: &Feeling) -> Option<Vector3<f64>> {
        let Touched::Thing(thing) = feeling.what else { return None };
        let limb = self.skin.receptors[feeling.receptor].limb;
        let at = self.touching_at(limb, thing)?;
        let world = self.data.body_pose(thing) * nalgebra::Point3::from(at);
        Some(self.body.limb_pose(&self.data, limb)?.inverse_transform_point(&world).coords)
    }

    /// Where a limb and a thing really touch, in the frame of the thing, metres: for those who measure.
    pub fn touching_at(&self, limb: usize, thing: usize) -> Option<Vector3<f64>> {
        let place = |contact: Contact| {
            let limbs = contact.geoms.map(|geom| self.body.limb_of_geom(geom));
            let bodies = contact.geoms.map(|geom| self.body.model.geom_body(geom));
            (limbs.contains(&Some(limb)) && bodies.contains(&thing))
                .then(|| self.data.body_pose(thing).inverse_transform_point(&contact.position).coords)
        };
        self.data.contacts().find_map(place)
    }

    /// Where a thing really is: for those who measure.
    pub fn thing_pose(&self, thing: usize) -> Isometry3<f64> {
        self.data.body_pose(thing)
    }

    /// The body of a thing by its name.
    pub fn thing(&self, name: &str) -> Option<usize> {
        (0..self.body.model.nbody()).find(|&b| self.body.model.body(b).name == Some(name))
    }

    /// The name of a thing by its number, for those who read of it.
    pub fn thing_name(&self, thing: usize) -> String {
        body_name(&self.body.model, thing)
    }

    /// `X_WR`: where the root of the creature really is.
    pub fn root_pose(&self) -> Isometry3<f64> {
        self.body.limb_pose(&self.data, 0).unwrap_or_default()
    }

    fn free_joint(&self, body: usize) -> Option<(usize, usize)> {
        let mut joints = self.body.model.joints();
        let joint = joints.find(|joint| joint.body == body && joint.kind == JointKind::Free)?;
        Some((joint.qposadr, joint.dofadr))
    }

    /// The engine's coordinates with the creature in a posture and all else as it is.
    fn qpos_with(&self, posture: &[f64]) -> Vec<f64> {
        let mut qpos = vec![0.0; self.body.model.nq()];
        self.body.write_qpos(posture, &mut qpos);
        for ((q, present), own) in qpos.iter_mut().zip(self.data.qpos()).zip(&self.own_qpos) {
            if !own {
                *q = *present;
            }
        }
        qpos
    }

    /// Puts what is carried where it is carried to, in a step that begins with the creature in `qpos`.
    fn carry(&mut self, qpos: &mut [f64], qvel: &mut [f64]) -> mujoco::Result<()> {
        if self.carried.is_empty() {
            return Ok(());
        }
        self.data.set_qpos(qpos)?;
        self.data.kinematics()?;
        let (time, step) = (self.time - self.timestep(), self.timestep());
        for carried in &self.carried {
            // What a limb holds goes with it; what goes by itself has a velocity of its own.
            let (pose, velocity) = match &carried.by {
                Carrier::Limb(limb, grip, _) => {
                    (self.body.limb_pose(&self.data, *limb).unwrap_or_default() * grip, Vector3::zeros())
                }
                Carrier::Path(path, turn) => {
                    let [now, next] = [time, time + step].map(|time| path.at(time).unwrap_or_default());
                    (Isometry3::from_parts(Translation3::from(now), *turn), (next - now) / step)
                }
            };
            let (q, v) = (carried.qposadr, carried.dofadr);
            let turn: &Quaternion<f64> = pose.rotation.quaternion();
            qpos[q..q + 3].copy_from_slice(pose.translation.vector.as_slice());
            qpos[q + 3..q + 7].copy_from_slice(&[turn.w, turn.i, turn.j, turn.k]);
            qvel[v..v + 3].copy_from_slice(velocity.as_slice());
            qvel[v + 3..v + 6].fill(0.0);
        }
        Ok(())
    }

    fn feelings(&self) -> Vec<Feeling> {
        let mut felt = BTreeSet::new();
        for contact in self.data.contacts().filter(|contact| contact.distance < -FELT) {
            if meets(&self.body, &self.overlapping, &self.carried, contact.geoms) {
                self.read(&contact, &mut felt);
            }
        }
        felt.into_iter().collect()
    }

    /// The receptor of a limb that is nearest to a contact.
    fn nearest(&self, limb: usize, contact: &Contact) -> Option<usize> {
        let frame = self.body.limb_pose(&self.data, limb)?;
        let point = frame.inverse_transform_point(&contact.position).coords;
        let distance = |&r: &usize| (self.skin.receptors[r].position - point).norm_squared();
        let on_limb = (0..self.skin.receptors.len()).filter(|&r| self.skin.receptors[r].limb == limb);
        on_limb.min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    fn read(&self, contact: &Contact, felt: &mut BTreeSet<Feeling>) {
        let bodies = contact.geoms.map(|geom| self.body.model.geom_body(geom));
        let ends = self.reader.ends(&self.body, &self.skin, &self.data, contact);
        let mut receptors = ends.map(|end| end.map(|end| end.receptor));
        // Skin between two patches is felt by the nearer one.
        for (receptor, geom) in receptors.iter_mut().zip(contact.geoms) {
            if let (None, Some(limb)) = (*receptor, self.body.limb_of_geom(geom)) {
                *receptor = self.nearest(limb, contact);
            }
        }
        match contact.geoms.map(|geom| self.body.limb_of_geom(geom)) {
            [Some(_), Some(_)] => {
                if let [Some(a), Some(b)] = receptors {
                    felt.insert(Feeling { receptor: a, what: Touched::Own(b) });
                    felt.insert(Feeling { receptor: b, what: Touched::Own(a) });
                }
            }
            [Some(_), None] | [None, Some(_)] => {
                for (receptor, other) in receptors.into_iter().zip([bodies[1], bodies[0]]) {
                    felt.extend(receptor.map(|receptor| Feeling { receptor, what: Touched::Thing(other) }));
                }
            }
            [None, None] => {}
        }
        // What a thing that is held meets is felt where it is held.
        for carried in &self.carried {
            if let (Carrier::Limb(_, _, receptor), Some(k)) =
                (&carried.by, bodies.iter().position(|body| *body == carried.body))
            {
                felt.insert(Feeling { receptor: *receptor, what: Touched::Through(bodies[1 - k]) });
            }
        }
    }
}

/// Two geoms, the one with the lesser number first.
fn sorted([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

/// Whether two geoms act on each other: not where they always overlap, nor a limb that carries the other, nor what is
/// held and the limbs about it.
fn meets(body: &Body, overlapping: &BTreeSet<[usize; 2]>, carried: &[Carried], geoms: [usize; 2]) -> bool {
    if overlapping.contains(&sorted(geoms)) {
        return false;
    }
    match geoms.map(|geom| body.limb_of_geom(geom)) {
        [Some(a), Some(b)] => !body.creature.neighbouring(a, b),
        [Some(limb), None] | [None, Some(limb)] => {
            let bodies = geoms.map(|geom| body.model.geom_body(geom));
            let held = |carried: &Carried| match carried.by {
                Carrier::Limb(holding, ..) => {
                    bodies.contains(&carried.body) && body.creature.neighbouring(holding, limb)
                }
                Carrier::Path(..) => false,
            };
            !carried.iter().any(held)
        }
        [None, None] => true,
    }
}

/// The body of a thing as MJCF.
fn described(thing: &Thing) -> xmltree::Element {
    let translation = thing.pose.translation.vector;
    let turn = thing.pose.rotation.quaternion();
    let pose = [
        ("name", thing.name.clone()),
        ("pos", exact(translation.as_slice())),
        ("quat", exact(&[turn.w, turn.i, turn.j, turn.k])),
    ];
    let mut body = element("body", &pose);
    if !thing.fixed {
        body.children.push(xmltree::XMLNode::Element(element("freejoint", &[])));
    }
    let (kind, size) = match &thing.shape {
        Shape::Sphere { radius } => ("sphere", exact(&[*radius])),
        Shape::Capsule { radius, half_length } => ("capsule", exact(&[*radius, *half_length])),
        Shape::Cylinder { radius, half_length } => ("cylinder", exact(&[*radius, *half_length])),
        Shape::Ellipsoid { semi_axes } => ("ellipsoid", exact(semi_axes)),
        Shape::Box { half_extents } => ("box", exact(half_extents)),
        Shape::Hull(_) | Shape::Mesh => ("sphere", exact(&[0.01])),
    };
    let geom = [
        ("name", thing.name.clone()),
        ("type", kind.into()),
        ("size", size),
        ("density", "300".into()),
        ("contype", "1".into()),
        ("conaffinity", "1".into()),
        ("condim", "4".into()),
        ("friction", "0.8 0.01 0.001".into()),
    ];
    body.children.push(xmltree::XMLNode::Element(element("geom", &geom)));
    body
}
