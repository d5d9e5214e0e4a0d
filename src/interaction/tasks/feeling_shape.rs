//! Feeling the shape of a thing with the fingertips: each touch goes where uncertainty is greatest.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use super::Trouble;
use super::feeling::{CLEAR, FEELING};
use crate::creature::Posture;
use crate::error::Result;
use crate::geometry::{Capsule, directions};
use crate::interaction::actor::{Actor, CAREFUL, FoundThing, SWIFT};
use crate::peripersonal::{FeltShape, Obstacle, PlacedSkin, PosturePath, ReachTarget, ShapeEstimate};
use crate::senses::SkinContact;

/// Directions in which a thing can extend …
const SIDES: usize = 60;
/// … but those that lead to what it stands on: the least of their height …
const LOWEST: f64 = -0.8;
/// … and the least height from which a hand comes: what lies lower it touches from aside, low over what the thing stands on.
const FROM_ASIDE: f64 = -0.1;
/// Tips of a hand that feel: its receptors farthest from the wrist.
const TIPS: usize = 6;
/// How far a hand goes back before it comes from another side, metres.
const BACK_OFF: f64 = 0.08;
/// How far aside of where it touched a hand touches again, to feel how the surface goes on, metres, …
const ASIDE: f64 = 0.015;
/// … in so many directions about it; …
const BESIDE: usize = 4;
/// … how far it draws back between, and how far beyond where it touched it looks for the surface, metres.
const DRAWN_BACK: f64 = 0.01;
const BEYOND: f64 = 0.02;
/// What is still touched when a hand has drawn back by so much is dragged along, metres.
const DRAGGED: f64 = 0.003;
/// Length of a step of the way there, metres.
const STRIDE: f64 = 0.002;
/// From how many postures on the way it is told that nothing was there, and of skin how near to the thing, metres.
const SOUNDINGS: usize = 5;
const ABOUT: f64 = 0.12;
/// How low over what the thing stands on it is touched, metres.
const OVER: f64 = 0.015;
/// A thing felt no higher than this over the table stands on it, metres.
const STANDING: f64 = 0.2;
/// How many sides are tried for each touch, on average.
const TRIES: usize = 3;
/// Sides within this of one that was tried are not tried again, radians.
const TRIED: f64 = 0.25;

/// What came of feeling a thing.
#[derive(Clone, Debug)]
pub struct ShapeFeeling {
    /// What is known of its shape, in the root's frame.
    pub shape: ShapeEstimate,
    /// Touches that it is known from, each with the small motions after it.
    pub touches: usize,
}

/// How coming to a side of a thing ended.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Come {
    Touched,
    /// Nothing was there.
    Empty,
    /// There was no way, or something else was met.
    Barred,
}

impl Actor {
    /// Feels a thing that was found with the tips of both hands until it was touched so many times, as far as its sides can
    /// be reached. On each touch the hand goes on to feel: it draws back a little and touches again beside the place, a few
    /// times. The thing must not move meanwhile.
    ///
    /// # Errors
    /// [`Trouble`] where the first touch tells nothing.
    pub fn feel_shape(&mut self, found: &FoundThing, touches: usize) -> Result<ShapeFeeling, Trouble> {
        let above = self.table.zip(self.over_table(&found.point));
        let stands = above.filter(|(_, above)| *above < STANDING).map(|(height, _)| height);
        let about = found.point + found.direction * 0.03;
        let mut felt = FeltShape::new(about, self.up, stands);
        let by = found.receptor;
        self.take_in(&mut felt, &about, &BTreeSet::from([by]), by, BACK_OFF);
        self.feel_beside(&mut felt, &about, by, found.direction)?;
        let ready = self.ready();
        // Where it cannot go back, the next motion says so.
        let _ = self.withdraw(found, &ready);
        let mut shape = felt.estimate().ok_or(Trouble::Nothing)?;
        let (mut tried, mut touched): (Vec<Vector3<f64>>, usize) = (Vec::new(), 1);
        for _ in 0..TRIES * touches {
            if touched >= touches {
                break;
            }
            let Some(side) = self.least_known_side(&shape, &tried, stands.is_some()) else { break };
            tried.push(side);
            match self.touch_side(&mut felt, &shape, side, stands)? {
                Come::Touched => touched += 1,
                Come::Empty => {}
                Come::Barred => continue,
            }
            shape = felt.estimate().ok_or(Trouble::Nothing)?;
        }
        Ok(ShapeFeeling { shape, touches: touched })
    }

    /// Goes to a posture about a thing whose shape is known.
    ///
    /// # Errors
    /// As [`Actor::go`].
    pub(in crate::interaction) fn go_about(
        &mut self,
        shape: &ShapeEstimate,
        target: &[f64],
    ) -> Result<(), Trouble> {
        let thing = Capsule::about_points(&shape.corners()).map(Obstacle::Capsule);
        self.with_obstacles(thing, |actor| actor.go(target))
    }

    /// The outward direction in which least is known of a thing's extent, of those not tried yet.
    fn least_known_side(
        &self,
        shape: &ShapeEstimate,
        tried: &[Vector3<f64>],
        stands: bool,
    ) -> Option<Vector3<f64>> {
        let near = TRIED.cos();
        let sides = directions(SIDES).filter(|side| {
            (!stands || side.dot(&self.up) > LOWEST) && tried.iter().all(|other| other.dot(side) < near)
        });
        sides.max_by(|a, b| shape.doubt(a).total_cmp(&shape.doubt(b)))
    }

    /// Comes to a thing from a side with a fingertip of the hand that gets there, and feels about the place.
    fn touch_side(
        &mut self,
        felt: &mut FeltShape,
        shape: &ShapeEstimate,
        side: Vector3<f64>,
        stands: Option<f64>,
    ) -> Result<Come, Trouble> {
        let mut point = shape.farthest(&side);
        if let Some(height) = self.table {
            point += self.up * (height + OVER - point.dot(&self.up)).max(0.0);
        }
        let height = side.dot(&self.up);
        let level = side - self.up * height;
        let from_aside = level.try_normalize(1e-6).filter(|_| stands.is_some() && height < FROM_ASIDE);
        let side = from_aside.map_or(side, |level| (level + self.up * FROM_ASIDE).normalize());
        let aim = ReachTarget { point, direction: -side };
        let own_side = self.hand_towards(&side);
        let thing = Capsule::about_points(&shape.corners());
        for hand in [own_side, 1 - own_side] {
            let mut tips = self.own.from_tip(self.hands[hand].limb, &self.hands[hand].receptors);
            tips.truncate(TIPS);
            let (arm, from) = (self.hands[hand].arm.clone(), self.posture());
            let plan = self.with_obstacles(thing.map(Obstacle::Capsule), |actor| {
                actor.reaching(arm).approach(&from, &tips, &aim)
            });
            let Ok(plan) = plan else { continue };
            let mut contacts = self.follow(&plan.way, SWIFT, |_, _| true)?;
            // Met on the way there it lies where that skin faces.
            let met = contacts.iter().find_map(|contact| self.found(contact));
            let into = met.map_or(aim.direction, |found| found.direction);
            if contacts.is_empty() {
                contacts = self.follow(&plan.straight, CAREFUL, |_, _| true)?;
            }
            let touching = self.of_the_thing(&contacts);
            let by = touching.iter().next().copied().unwrap_or(plan.receptor);
            let come = match (contacts.is_empty(), touching.is_empty()) {
                (_, false) => Come::Touched,
                (true, true) => Come::Empty,
                (false, true) => Come::Barred,
            };
            if come != Come::Barred {
                self.take_in(felt, &shape.middle(), &touching, by, BACK_OFF);
            }
            let way_back = self.back_by(by, BACK_OFF);
            if come == Come::Touched {
                self.feel_beside(felt, &shape.middle(), by, into)?;
            }
            if let Some(way) = way_back {
                self.follow(&way, SWIFT, |_, _| false)?;
            }
            if come != Come::Barred {
                return Ok(come);
            }
        }
        Ok(Come::Barred)
    }

    /// Goes on to feel a thing that a receptor touches: a few times it draws back, goes aside, and comes on again in a
    /// direction into the thing. In the end it is drawn back where it first touched; it stays where it would drag the thing
    /// along, or meets something on its way back.
    fn feel_beside(
        &mut self,
        felt: &mut FeltShape,
        about: &Vector3<f64>,
        by: usize,
        into: Vector3<f64>,
    ) -> Result<(), Trouble> {
        let Some(hand) = self.arm_of(by) else { return Ok(()) };
        let (limb, arm) = (self.own.skin().receptors[by].limb, self.hands[hand].arm.clone());
        let here = self.posture();
        let frame = self.frames()[limb];
        let place = self.own.leading(by, &frame.rotation.tr_mul(&into));
        let (point, direction) = (frame.point(&place.point), frame.direction(&place.direction));
        let across = if into.dot(&self.up).abs() < 0.9 { self.up } else { self.front };
        let first = (across - into * across.dot(&into)).normalize();
        let second = into.cross(&first);
        // From where that place of the skin is: a little back, and then as far as it draws back.
        let back_from = |actor: &Actor, at: Vector3<f64>| {
            let off = actor.tilted(place, &arm, at - into * DRAGGED, direction, &actor.posture());
            let back = actor.tilted(place, &arm, at - into * DRAWN_BACK, direction, &off);
            [off, back]
        };
        let [off, back] = back_from(self, point);
        if !self.draws_off([off, back.clone()])? {
            return Ok(());
        }
        let clearance = self.clearance.moved_by(&self.own, &arm);
        let clearance = clearance.eased_at(&[self.own.frames(&here)], CLEAR);
        for k in 0..BESIDE {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / BESIDE as f64).sin_cos();
            let aside = point + (first * cos + second * sin) * ASIDE;
            let strides = ((DRAWN_BACK + BEYOND) / STRIDE).round() as usize;
            let PosturePath(mut way) = PosturePath::stepwise(&back, strides + 1, |k, last| {
                let target = aside + into * (STRIDE * (k - 1) as f64 - DRAWN_BACK);
                Some(self.tilted(place, &arm, target, direction, last))
            });
            let free = way.iter().take_while(|way| clearance.free(&self.own.frames(way), CLEAR)).count();
            way.truncate(free);
            if way.len() < 3 {
                continue;
            }
            let contacts = self.follow(&PosturePath(way), FEELING, |_, _| true)?;
            let touching = self.of_the_thing(&contacts);
            if contacts.is_empty() || !touching.is_empty() {
                self.take_in(felt, about, &touching, by, DRAWN_BACK);
            }
            let met = self.frames()[limb].point(&place.point);
            let way = back_from(self, met);
            if !self.draws_off(way)? {
                return Ok(());
            }
            if !self.follow(&PosturePath(vec![back.clone()]), SWIFT, |_, _| true)?.is_empty() {
                return Ok(());
            }
        }
        Ok(())
    }

    /// Draws back, a little at first; whether it touches the thing no more. Where it does it would drag it along, and stays.
    fn draws_off(&mut self, way: [Posture; 2]) -> Result<bool> {
        for posture in way {
            let mut touched = self.follow(&PosturePath(vec![posture.clone()]), SWIFT, |_, _| true)?;
            if touched.is_empty() {
                touched = self.step(&posture)?;
            }
            if !self.of_the_thing(&touched).is_empty() {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// The receptors that feel a thing that is not the table, and not one's own skin.
    fn of_the_thing(&self, contacts: &[SkinContact]) -> BTreeSet<usize> {
        let things = contacts.iter().filter(|contact| self.is_thing(contact));
        things.map(|contact| contact.spot.receptor).collect()
    }

    /// Takes in what the posture and the way to it tell of a thing: the surfaces under the receptors that touch meet it, all
    /// other skin near it does not, nor did any on the last `back` metres on which the skin of `by` came.
    fn take_in(
        &self,
        felt: &mut FeltShape,
        about: &Vector3<f64>,
        touching: &BTreeSet<usize>,
        by: usize,
        back: f64,
    ) {
        let skin = self.own.skin();
        let frames = self.frames();
        let touched: BTreeSet<usize> = touching.iter().filter_map(|&r| skin.receptors[r].surface).collect();
        for &surface in &touched {
            let surface = &skin.surfaces[surface];
            if let Some(placed) = PlacedSkin::new(surface, &frames[surface.limb]) {
                felt.touches(placed);
            }
        }
        let moving = self.arm_of(by).map(|hand| self.own.carried_by(self.hands[hand].limb));
        let way = self.back_by(by, back).unwrap_or(PosturePath(Vec::new()));
        // Of a small motion it is where it ended that tells something new.
        let soundings = if back < BACK_OFF { 1 } else { SOUNDINGS };
        let every = way.0.len().div_ceil(soundings).max(1);
        for (k, posture) in way.0.iter().enumerate().step_by(every) {
            let frames = self.own.frames(posture);
            for (index, surface) in skin.surfaces.iter().enumerate() {
                let meets_now = k == 0 && touched.contains(&index);
                if meets_now || !moving.as_ref().is_some_and(|moving| moving[surface.limb]) {
                    continue;
                }
                let away = (frames[surface.limb].point(&surface.origin) - about).norm();
                if away - surface.shape.bounding_radius() < ABOUT
                    && let Some(placed) = PlacedSkin::new(surface, &frames[surface.limb])
                {
                    felt.is_clear_of(placed);
                }
            }
        }
    }
}
