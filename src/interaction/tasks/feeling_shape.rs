//! Feeling the shape of a thing with the fingertips: touch after touch, each where most is unknown.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use super::Trouble;
use crate::geometry::Capsule;
use crate::interaction::actor::{Actor, CAREFUL, FoundThing, SWIFT, Stop};
use crate::peripersonal::{FeltShape, Obstacle, PlacedSkin, PosturePath, ReachTarget, ShapeEstimate};
use crate::senses::{SkinContact, Toucher};

/// Directions from which a thing can be touched …
const SIDES: usize = 60;
/// … but those that lead below it: the least of their height.
const LOWEST: f64 = -0.25;
/// Tips of a hand that feel: its receptors farthest from the wrist.
const TIPS: usize = 6;
/// How far a hand goes back before it comes from another side, metres.
const BACK_OFF: f64 = 0.08;
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
    /// Touches that it is known from.
    pub touches: usize,
    /// Sides to which there was no way.
    pub barred: usize,
}

impl Actor {
    /// Feels a thing that was found with the tips of both hands until it was touched so many times, as far as its sides can
    /// be reached. It must not move meanwhile.
    ///
    /// # Errors
    /// [`Trouble`] where the first touch tells nothing.
    pub fn feel_shape(&mut self, found: &FoundThing, touches: usize) -> Result<ShapeFeeling, Trouble> {
        let above = self.table.map(|height| (height, found.point.dot(&self.up) - height));
        let stands = above.filter(|(_, above)| *above < STANDING).map(|(height, _)| height);
        let about = found.point + found.direction * 0.03;
        let mut felt = FeltShape::new(about, self.up, stands);
        self.take_in(&mut felt, &about, Some(&BTreeSet::from([found.receptor])), found.receptor);
        let ready = self.ready();
        // Where it cannot go back, the next motion says so.
        let _ = self.withdraw(found, &ready);
        let mut shape = felt.estimate().ok_or(Trouble::Nothing)?;
        let (mut tried, mut barred): (Vec<Vector3<f64>>, usize) = (Vec::new(), 0);
        for _ in 0..TRIES * touches {
            if felt.touches_so_far() >= touches {
                break;
            }
            let Some(side) = self.least_known_side(&shape, &tried, stands.is_some()) else { break };
            tried.push(side);
            match self.touch_side(&mut felt, &shape, side)? {
                true => shape = felt.estimate().ok_or(Trouble::Nothing)?,
                false => barred += 1,
            }
        }
        Ok(ShapeFeeling { shape, touches: felt.touches_so_far(), barred })
    }

    /// The outward direction in which least is known of a thing's extent, of those not tried yet.
    fn least_known_side(
        &self,
        shape: &ShapeEstimate,
        tried: &[Vector3<f64>],
        stands: bool,
    ) -> Option<Vector3<f64>> {
        let near = TRIED.cos();
        let sides = crate::peripersonal::directions(SIDES).into_iter().filter(|side| {
            (!stands || side.dot(&self.up) > LOWEST) && tried.iter().all(|other| other.dot(side) < near)
        });
        sides.max_by(|a, b| shape.doubt(a).total_cmp(&shape.doubt(b)))
    }

    /// Comes to a thing from a side with a fingertip of the hand that gets there; whether one did.
    fn touch_side(
        &mut self,
        felt: &mut FeltShape,
        shape: &ShapeEstimate,
        side: Vector3<f64>,
    ) -> Result<bool, Trouble> {
        let mut point = shape.farthest(&side);
        if let Some(height) = self.table {
            point += self.up * (height + OVER - point.dot(&self.up)).max(0.0);
        }
        let aim = ReachTarget { point, direction: -side };
        let own_side = usize::from(self.side(0) * side.dot(&self.left()) < 0.0);
        let thing = Capsule::about_points(&shape.corners());
        for hand in [own_side, 1 - own_side] {
            let tips = self.tips(hand);
            let (arm, from) = (self.hands[hand].arm.clone(), self.posture());
            let known = self.clearance.obstacles.len();
            self.clearance.obstacles.extend(thing.map(Obstacle::Capsule));
            let plan = self.reaching(arm).approach(&from, &tips, &aim);
            self.clearance.obstacles.truncate(known);
            let Ok(plan) = plan else { continue };
            let came = match self.follow(&plan.way, SWIFT, |_, _| true)? {
                Stop::Arrived => self.follow(&plan.straight, CAREFUL, |_, _| true)?,
                felt => felt,
            };
            let touching = match &came {
                Stop::Felt(contacts) => self.of_the_thing(contacts),
                Stop::Arrived => BTreeSet::new(),
            };
            let nothing_met = came == Stop::Arrived;
            if nothing_met || !touching.is_empty() {
                let by = touching.iter().next().copied().unwrap_or(plan.receptor);
                self.take_in(felt, &shape.middle(), Some(&touching), by);
            }
            let by = touching.iter().next().copied().unwrap_or(plan.receptor);
            if let Some(way) = self.back_by(by, BACK_OFF) {
                self.follow(&way, SWIFT, |_, _| false)?;
            }
            if nothing_met || !touching.is_empty() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// The receptors that feel a thing that is not the table, and not one's own skin.
    fn of_the_thing(&self, contacts: &[SkinContact]) -> BTreeSet<usize> {
        let things = contacts.iter().filter(|c| matches!(c.by, Toucher::Thing(_)) && !self.is_table(c));
        things.map(|contact| contact.spot.receptor).collect()
    }

    /// The receptors of a hand that are farthest from its wrist.
    fn tips(&self, hand: usize) -> Vec<usize> {
        let frames = self.own.frames(&self.own.at_ease());
        let hand = &self.hands[hand];
        let far = |&receptor: &usize| {
            let place = self.own.place(receptor);
            (frames[place.limb].point(&place.point) - frames[hand.limb].origin).norm()
        };
        let mut tips = hand.receptors.clone();
        tips.sort_by(|a, b| far(b).total_cmp(&far(a)));
        tips.truncate(TIPS);
        tips
    }

    /// Takes in what the posture and the way to it tell of a thing: the surfaces under the receptors that touch meet it, all
    /// other skin near it does not, nor did any on the way on which the skin of `by` came.
    fn take_in(
        &self,
        felt: &mut FeltShape,
        about: &Vector3<f64>,
        touching: Option<&BTreeSet<usize>>,
        by: usize,
    ) {
        let skin = self.own.skin();
        let frames = self.frames();
        let touched: BTreeSet<usize> =
            touching.into_iter().flatten().filter_map(|&r| skin.receptors[r].surface).collect();
        for &surface in &touched {
            let surface = &skin.surfaces[surface];
            if let Some(placed) = PlacedSkin::new(surface, &frames[surface.limb]) {
                felt.touches(placed);
            }
        }
        let moving = self.arm_of(by).map(|hand| self.own.carried_by(self.hands[hand].limb));
        let way = self.back_by(by, BACK_OFF).unwrap_or(PosturePath(Vec::new()));
        let every = way.0.len().div_ceil(SOUNDINGS).max(1);
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
