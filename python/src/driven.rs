//! Creatures in physics that are stepped together: what the Gymnasium environments call.

use std::sync::{Arc, Mutex, PoisonError};

use bodyschema::mujoco::Data;
use bodyschema::senses::ContactReader;
use bodyschema::simulation::{SelfContact, Servo, step};
use bodyschema::{Embodied, Error as Fault, Posture, SkinContact};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use rayon::prelude::*;

use crate::arrays::{array, filled, integers, numbers, postures};
use crate::compute::on_threads;
use crate::creature::Creature;
use crate::errors::{raised, wrong};

/// Creatures that are simulated together, at the most.
const MOST: usize = 4096;

/// What simulations of one creature share.
struct Shared {
    embodied: Arc<Embodied>,
    servo: Servo,
    reader: ContactReader,
    contact: SelfContact,
}

/// A creature under gravity whose root is fixed and whose joints servos move to target postures, at 1.25 rad/s at most: as fast
/// as what they pull with at the most goes on against their damping. Its limbs press on each other; nothing else of the model
/// is there.
struct Driven {
    shared: Arc<Shared>,
    data: Data,
    /// What touches its skin.
    contacts: Vec<SkinContact>,
}

impl Driven {
    /// A creature at rest in its start posture.
    fn new(shared: Arc<Shared>) -> Result<Driven, Fault> {
        let mut driven =
            Driven { data: Data::new(shared.servo.levels[0].clone())?, shared, contacts: Vec::new() };
        let start = driven.shared.contact.start.clone();
        driven.place(&start)?;
        Ok(driven)
    }

    /// The posture that it is in.
    fn posture(&self) -> Posture {
        self.shared.embodied.body().read_posture(self.data.qpos())
    }

    /// Puts it into a posture, at rest; what comes after depends on nothing before.
    fn place(&mut self, posture: &[f64]) -> Result<(), Fault> {
        self.data.reset()?;
        Ok(self.data.set_qpos(&self.shared.embodied.body().qpos(posture))?)
    }

    /// Goes on by some steps towards a posture; the contacts are those of the last of them. Targets are within the joints'
    /// ranges, and coupled as they are.
    fn step(&mut self, target: &[f64], steps: usize) -> Result<(), Fault> {
        let Shared { embodied, servo, reader, contact } = &*self.shared;
        let (body, creature) = (embodied.body(), embodied.creature());
        let mut target = Posture::reachable(creature, &self.posture(), target);
        target.clamp(creature);
        creature.couple(&mut target);
        let target = body.qpos(&target);
        // Of no length, it is the target itself at every time.
        let path = servo.path(&target, &target, 0.0);
        let held = body.qpos(&contact.start);
        for _ in 0..steps {
            let (mut qpos, mut qvel) = (self.data.qpos().to_vec(), self.data.qvel().to_vec());
            servo.hold(&held, &mut qpos, &mut qvel);
            let meets = |[a, b]: [usize; 2]| {
                let limbs = [a, b].map(|geom| body.limb_of_geom(geom));
                matches!(limbs, [Some(a), Some(b)] if !creature.neighbouring(a, b))
                    && !contact.left_out.contains(&[a.min(b), a.max(b)])
            };
            step(&mut self.data, (&qpos, &qvel), meets, |data| servo.forces(&path, 0.0, data))?;
        }
        self.contacts = reader.skin_contacts(body, embodied.agent().skin(), &self.data);
        Ok(())
    }

    /// The pairs of its receptors that press on each other.
    fn touches(&self) -> impl Iterator<Item = [usize; 2]> {
        self.contacts
            .iter()
            .filter_map(|contact| Some([contact.spot, contact.by.own()?].map(|spot| spot.receptor)))
    }
}

/// Equal creatures in physics, side by side, each apart from the others. `bodyschema.environment` makes environments of
/// them.
///
/// An observation is a row of float32: the D coordinates of the posture (radians, metres), then per receptor the force on it
/// (newtons).
#[pyclass(frozen, module = "bodyschema._core")]
pub struct Crowd {
    creature: bodyschema::Creature,
    receptors: usize,
    start: Posture,
    timestep: f64,
    driven: Mutex<Vec<Driven>>,
}

#[pymethods]
impl Crowd {
    #[new]
    fn new(py: Python, creature: &Bound<Creature>, count: usize) -> PyResult<Crowd> {
        if count == 0 || count > MOST {
            return Err(wrong(format!("there are {count} environments: give from 1 to {MOST}")));
        }
        let embodied = creature.get().embodied.clone();
        let made = py.detach(|| {
            let (body, agent) = (embodied.body(), embodied.agent());
            let (servo, contact) = (Servo::new(body)?, SelfContact::new(body)?);
            let reader = ContactReader::new(body, agent.skin());
            let shared = Arc::new(Shared { embodied: embodied.clone(), servo, reader, contact });
            (0..count).map(|_| Driven::new(shared.clone())).collect::<Result<Vec<_>, Fault>>()
        });
        let driven = made.map_err(raised)?;
        Ok(Crowd {
            creature: embodied.creature().clone(),
            receptors: embodied.agent().skin().receptors.len(),
            start: driven[0].shared.contact.start.clone(),
            timestep: driven[0].data.model().timestep(),
            driven: Mutex::new(driven),
        })
    }

    /// The posture in which no limbs overlap: (D,).
    #[getter]
    fn start<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, &self.start, &[self.start.len()])
    }

    /// The length of a step of the physics, seconds.
    #[getter]
    fn timestep(&self) -> f64 {
        self.timestep
    }

    /// Puts the creatures of some numbers into postures (K, D), at rest.
    fn place(&self, py: Python, which: Vec<usize>, postures: &Bound<PyAny>) -> PyResult<()> {
        let (postures, _) = self::postures(postures, "posture", &self.creature)?;
        let mut driven = self.driven.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner);
        if postures.len() != which.len() || which.iter().any(|&k| k >= driven.len()) {
            return Err(wrong("posture: give one for each environment that is placed"));
        }
        which.iter().zip(&postures).try_for_each(|(&k, posture)| driven[k].place(posture)).map_err(raised)
    }

    /// Steps all of them in parallel, so many steps of the physics towards target postures (N, D). Returns their observations,
    /// (N, D + R), and their touches in the last of these steps, (K, 3): the creature and its two receptors that press on each
    /// other.
    fn step<'py>(
        &self,
        py: Python<'py>,
        targets: &Bound<PyAny>,
        steps: usize,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (targets, shape) = numbers(targets, "action")?;
        let mut driven = self.driven.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner);
        let coordinates = self.start.len();
        let expected = [driven.len(), coordinates];
        if shape != expected {
            let sentence =
                format!("action: the shape of all is {shape:?}: give {expected:?}, a target a coordinate");
            return Err(wrong(sentence));
        }
        let one = |((driven, target), row): ((&mut Driven, &[f64]), &mut [f32])| {
            driven.step(target, steps)?;
            row.iter_mut().zip(&*driven.posture()).for_each(|(to, x)| *to = *x as f32);
            for contact in &driven.contacts {
                contact.spots().for_each(|spot| row[coordinates + spot.receptor] += contact.force as f32);
            }
            Ok(())
        };
        let (driven, mut done) = (&mut **driven, Ok(()));
        let width = coordinates + self.receptors;
        let observations = filled(py, &[expected[0], width], |rows| {
            let rows = rows.par_chunks_mut(width);
            let all = driven.par_iter_mut().zip(targets.par_chunks(coordinates)).zip(rows);
            done = on_threads(|| all.try_for_each(one));
        })?;
        done.map_err(raised)?;
        let touches: Vec<usize> = driven
            .iter()
            .enumerate()
            .flat_map(|(k, driven)| driven.touches().flat_map(move |[a, b]| [k, a, b]))
            .collect();
        let shape = [touches.len() / 3, 3];
        Ok((observations, integers(py, touches, &shape)?))
    }
}
