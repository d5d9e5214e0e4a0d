//! A stick that a partner puts into a hand, and takes back.
//!
//! Which thing is a stick the partner sees: one that moves freely and is a single slender capsule or cylinder. It is welded
//! to the hand, with one end at the receptor that holds it, until it is taken back to where it was.

use nalgebra::{Isometry3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};

use super::Stage;
use super::carrying::{Carried, Carrier, Grip};
use super::core::StageCore;
use super::meeting::meets;
use crate::error::Result;
use crate::mujoco::GeomKind;

/// A stick is so many times as long as it is thick, at the least.
const SLENDER: f64 = 5.0;
/// How much a stick leans from where the hand points towards where its palm faces: the tangent of the angle.
const LEANING: f64 = 0.4;
/// Ways about where the hand points in which a stick may lean, of which the first that keeps it clear is taken.
const WAYS: usize = 8;

/// A stick among the things of a stage.
#[derive(Clone, Copy)]
struct Stick {
    body: usize,
    /// Half of its length, without the round ends of a capsule, metres.
    half_length: f64,
    /// `X_TG`: its middle in the body's frame, its length along z.
    middle: Isometry3<f64>,
}

impl StageCore {
    /// The stick that a body is, where it is one.
    fn stick(&self, body: usize) -> Option<Stick> {
        let model = &self.body.model;
        self.free_joint(body)?;
        let mut geoms = (0..model.ngeom())
            .filter(|&geom| model.geom_body(geom) == body && !model.is_aura(geom))
            .map(|geom| model.geom(geom));
        let (only, None) = (geoms.next()?, geoms.next()) else { return None };
        let [radius, half_length, _] = only.size;
        let slender =
            matches!(only.kind, GeomKind::Capsule | GeomKind::Cylinder) && half_length >= SLENDER * radius;
        let middle = Isometry3::from_parts(only.pos.into(), only.quat);
        slender.then_some(Stick { body, half_length, middle })
    }

    fn put_stick(
        &mut self,
        stick: Stick,
        receptor: usize,
        end: &Vector3<f64>,
        direction: &Vector3<f64>,
    ) -> Result<bool> {
        let limb = self.agent.skin().receptors[receptor].limb;
        let Some(direction) = direction.try_normalize(1e-9) else { return Ok(false) };
        let Some((qposadr, dofadr)) = self.free_joint(stick.body) else { return Ok(false) };
        let turn = UnitQuaternion::rotation_between(&Vector3::z(), &direction)
            .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
        let middle = end + direction * stick.half_length;
        let pose = Isometry3::from_parts(Translation3::from(middle), turn) * stick.middle.inverse();
        let given_from = Some(self.data.body_pose(stick.body));
        let grip = Grip { limb, receptor, pose, given_from };
        self.carry(Carried { body: stick.body, qposadr, dofadr, by: Carrier::Limb(grip) });
        let before = self.data.qpos().to_vec();
        let (mut qpos, mut qvel) = (before.clone(), self.data.qvel().to_vec());
        if let Some(carried) = self.carried.last() {
            carried.put(&self.body, &self.data, [self.time; 2], &mut qpos, &mut qvel);
        }
        self.data.set_qpos(&qpos)?;
        self.data.kinematics()?;
        self.data.collision()?;
        let model = &self.body.model;
        let touches = self.data.contacts().any(|contact| {
            contact.distance < 0.0
                && contact.geoms.iter().any(|&geom| model.geom_body(geom) == stick.body)
                && meets(&self.body, &self.overlapping, &self.carried, contact.geoms)
        });
        if touches {
            self.carried.pop();
            self.data.set_qpos(&before)?;
            self.data.kinematics()?;
            self.data.collision()?;
        } else {
            self.data.set_qvel(&qvel)?;
            self.stillness.disturb();
        }
        Ok(!touches)
    }
}

impl Stage {
    /// Puts a stick that nobody holds into a hand, where one of its receptors is, so that it leads where the hand points
    /// or a little aslant and meets nothing; the number of the stick. None where there is no stick, or no room for it.
    pub(in crate::simulation) fn give_any_stick(&self, receptor: usize) -> Result<Option<usize>> {
        let core = &mut *self.core.borrow_mut();
        let held = |body: usize| core.carried.iter().any(|carried| carried.body == body);
        let free = (0..core.body.model.nbody()).filter(|&body| !held(body));
        let Some(stick) = free.filter_map(|body| core.stick(body)).next() else { return Ok(None) };
        let found = &core.agent.skin().receptors[receptor];
        let pointing = found.position.try_normalize(1e-6).unwrap_or(found.normal);
        let palm = found.normal - pointing * found.normal.dot(&pointing);
        let aslant = palm
            .try_normalize(1e-6)
            .unwrap_or_else(|| crate::geometry::tangent_basis(&pointing).column(0).into_owned());
        for k in 0..WAYS {
            let turn = std::f64::consts::TAU * k as f64 / WAYS as f64;
            let about = Rotation3::from_axis_angle(&Unit::new_normalize(pointing), turn);
            let direction = pointing + about * aslant * LEANING;
            let end = core.agent.skin().receptors[receptor].position;
            if core.put_stick(stick, receptor, &end, &direction)? {
                return Ok(Some(stick.body));
            }
        }
        Ok(None)
    }

    /// Puts a stick into a hand, which holds it with a receptor: where one end of it is, metres, and where it leads from
    /// there, in the hand's frame; whether the thing is a stick, one slender capsule or cylinder that moves freely, and meets
    /// nothing there.
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
        let core = &mut *self.core.borrow_mut();
        let Some(stick) = core.stick(thing) else { return Ok(false) };
        core.put_stick(stick, receptor, end, direction)
    }

    /// Takes back the sticks that were given, to where they were.
    pub(in crate::simulation) fn take_sticks_back(&self) -> Result<()> {
        let core = &mut *self.core.borrow_mut();
        let (mut qpos, mut qvel) = (core.data.qpos().to_vec(), core.data.qvel().to_vec());
        for carried in &core.carried {
            if let Some(from) = carried.grip().and_then(|grip| grip.given_from) {
                carried.put_at(&from, &Vector3::zeros(), &mut qpos, &mut qvel);
            }
        }
        core.carried.retain(|carried| carried.grip().is_none_or(|grip| grip.given_from.is_none()));
        core.data.set_qpos(&qpos)?;
        core.data.set_qvel(&qvel)?;
        core.data.kinematics()?;
        core.data.collision()?;
        core.stillness.disturb();
        Ok(())
    }
}
