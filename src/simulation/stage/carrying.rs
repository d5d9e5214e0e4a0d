//! Things that do not move by themselves: held by a limb, or sent along a path whatever they meet.
//!
//! A limb holds what it touches from where that is. A stick, one slender capsule or cylinder that moves freely, is put into a
//! hand by a partner, who sees it: one end at the receptor that holds it, until he takes it back to where it was.

use nalgebra::{Isometry3, Rotation3, Translation3, Unit, Vector3};

use super::carried::{Carried, Carrier, Grip};
use super::core::StageCore;
use crate::error::Result;
use crate::geometry::{tangent_basis, z_onto};
use crate::mujoco::GeomKind;

/// A stick is so many times as long as it is thick, at the least.
const SLENDER: f64 = 5.0;
/// How much a stick leans from where the hand points towards where its palm faces: the tangent of the angle.
const LEANING: f64 = 0.4;
/// Directions about where the hand points in which a stick may lean, of which the first that keeps it clear is taken.
const DIRECTIONS: usize = 8;

impl StageCore {
    /// Lets a thing be carried from now on, whatever carried it before; whether it is one that moves freely.
    pub fn carry(&mut self, body: usize, by: Carrier) -> bool {
        let Some((qposadr, dofadr)) = self.free_joint(body) else { return false };
        self.carried.retain(|other| other.body != body);
        self.carried.push(Carried { body, qposadr, dofadr, by });
        true
    }

    /// Welds the thing that a receptor's limb touches to that limb; whether there was one.
    pub fn hold(&mut self, receptor: usize) -> bool {
        let limb = self.agent.skin().receptors[receptor].limb;
        let touched = self.data.contacts().find_map(|contact| {
            let [a, b] = contact.geoms.map(|g| (self.body.limb_of_geom(g), self.body.model.geom_body(g)));
            let thing = match (a, b) {
                ((Some(l), _), (None, thing)) | ((None, thing), (Some(l), _)) if l == limb => thing,
                _ => return None,
            };
            // What was put into a hand is held already.
            let given = |carried: &Carried| carried.body == thing && carried.given_from().is_some();
            (self.free_joint(thing).is_some() && !self.carried.iter().any(given)).then_some(thing)
        });
        touched.is_some_and(|body| {
            let x_wl = self.body.limb_pose(&self.data, limb).unwrap_or_default();
            let pose = x_wl.inv_mul(&self.data.body_pose(body));
            self.carry(body, Carrier::Limb(Grip { limb, receptor, pose, given_from: None }))
        })
    }

    /// Lets go of all that it took hold of.
    pub fn let_go(&mut self) {
        self.carried.retain(|carried| carried.grip().is_none_or(|grip| grip.given_from.is_some()));
    }

    /// Of a body that is a stick: half of its length, without the round ends of a capsule, metres, and `X_TG`, its middle in the
    /// body's frame, its length along z.
    fn stick(&self, body: usize) -> Option<(f64, Isometry3<f64>)> {
        let model = &self.body.model;
        self.free_joint(body)?;
        let mut geoms = (0..model.ngeom())
            .filter(|&geom| model.geom_body(geom) == body && !model.is_aura(geom))
            .map(|geom| model.geom(geom));
        let (only, None) = (geoms.next()?, geoms.next()) else { return None };
        let [radius, half_length, _] = only.size;
        let slender =
            matches!(only.kind, GeomKind::Capsule | GeomKind::Cylinder) && half_length >= SLENDER * radius;
        slender.then(|| (half_length, Isometry3::from_parts(only.pos.into(), only.quat)))
    }

    /// See [`super::Stage::give_stick`].
    pub fn give_stick(
        &mut self,
        thing: usize,
        receptor: usize,
        end: &Vector3<f64>,
        direction: &Vector3<f64>,
    ) -> Result<bool> {
        let limb = self.agent.skin().receptors[receptor].limb;
        let stick = self.stick(thing).zip(direction.try_normalize(1e-9));
        let Some(((half_length, middle), direction)) = stick else { return Ok(false) };
        let place = Translation3::from(end + direction * half_length);
        let pose = Isometry3::from_parts(place, z_onto(&direction)) * middle.inverse();
        let given_from = Some(self.data.body_pose(thing));
        self.carry(thing, Carrier::Limb(Grip { limb, receptor, pose, given_from }));
        let before = [self.data.qpos().to_vec(), self.data.qvel().to_vec()];
        self.put(|core, qpos, qvel| {
            let stick = core.carried.last().expect("it was given just now");
            stick.put(&core.body, &core.data, [core.time; 2], qpos, qvel);
        })?;
        self.collide()?;
        let touches = self.data.contacts().any(|contact| {
            contact.distance < 0.0
                && contact.geoms.iter().any(|&geom| self.body.model.geom_body(geom) == thing)
                && self.meets(contact.geoms)
        });
        if touches {
            self.carried.pop();
            self.put(|_, qpos, qvel| {
                qpos.copy_from_slice(&before[0]);
                qvel.copy_from_slice(&before[1]);
            })?;
            self.collide()?;
        }
        Ok(!touches)
    }

    /// Puts a stick that nobody holds into a hand, where one of its receptors is, so that it leads where the hand
    /// points or a little aslant and meets nothing; the number of the stick. `None` if there is no stick, or no room for it.
    pub fn give_any_stick(&mut self, receptor: usize) -> Result<Option<usize>> {
        let held = |body: usize| self.carried.iter().any(|carried| carried.body == body);
        let mut free = (0..self.body.model.nbody()).filter(|&body| !held(body));
        let Some(stick) = free.find(|&body| self.stick(body).is_some()) else { return Ok(None) };
        let found = &self.agent.skin().receptors[receptor];
        let (end, normal) = (found.position, found.normal);
        let pointing = end.try_normalize(1e-6).unwrap_or(normal);
        let palm = normal - pointing * normal.dot(&pointing);
        let aslant =
            palm.try_normalize(1e-6).unwrap_or_else(|| tangent_basis(&pointing).column(0).into_owned());
        for k in 0..DIRECTIONS {
            let turn = std::f64::consts::TAU * k as f64 / DIRECTIONS as f64;
            let about = Rotation3::from_axis_angle(&Unit::new_normalize(pointing), turn);
            if self.give_stick(stick, receptor, &end, &(pointing + about * aslant * LEANING))? {
                return Ok(Some(stick));
            }
        }
        Ok(None)
    }

    /// Takes back the sticks that were given, to where they were.
    pub fn take_sticks_back(&mut self) -> Result<()> {
        self.put(|core, qpos, qvel| {
            for (carried, from) in
                core.carried.iter().filter_map(|carried| Some((carried, carried.given_from()?)))
            {
                carried.put_at(&from, &Vector3::zeros(), qpos, qvel);
            }
        })?;
        self.carried.retain(|carried| carried.given_from().is_none());
        self.collide()
    }
}
