//! Feeling on: small motions of the limb that touches something tell where on a receptor that is, along which normal, and
//! how curved it is.

use std::collections::VecDeque;

use nalgebra::{Rotation3, Unit, Vector3};

use super::Trouble;
use crate::creature::Posture;
use crate::geometry::Frame;
use crate::interaction::actor::{Actor, FoundThing, SWIFT};
use crate::kinematics::Place;
use crate::peripersonal::{FeltPose, FeltSurface, Obstacle, PosturePath};
use crate::senses::SkinContact;

/// How fast the tips of the hands go where they feel on, metres a second: a tenth of a millimetre a step.
pub(super) const FEELING: f64 = 0.05;
/// How far skin goes back before it touches again, metres …
const RETREAT: f64 = 0.005;
/// … and how far beyond where it touched it looks for it.
const ADVANCE: f64 = 0.008;
/// Length of a step of the way there, metres.
const STRIDE: f64 = 0.001;
/// What length a direction counts as, metres: tilts matter as much as places.
const DIRECTION_LENGTH: f64 = 0.1;
/// How clear of the body and of what is known to be about it a limb that feels on keeps, metres.
pub(super) const CLEAR: f64 = 0.002;
/// How far a thing may reach about where it is touched, metres …
const ROOM: f64 = 0.06;
/// … and how much nearer to it than they are other limbs may come, metres.
const NEARER: f64 = 3e-3;
/// A place that is known to this, metres, is where the thing begins: all of it is beyond the plane there.
const SHARP: f64 = 3e-3;
/// Known as surely as this it is felt enough, metres.
const SURE: f64 = 5e-4;
/// Steps of the way by which it came that are looked at: how many before the touch.
const BEFORE: [usize; 6] = [2, 5, 10, 20, 40, 80];
/// The shares of a motion that are tried where there is no room for all of it.
const SHARES: [f64; 3] = [1.0, 0.5, 0.25];
/// Places of a patch, in shares of its half sides, along whose normals a limb is taken off that did not come by itself.
const PLACES: [[f64; 2]; 5] = [[0.0, 0.0], [0.7, 0.0], [-0.7, 0.0], [0.0, 0.7], [0.0, -0.7]];
/// Touches, by round: how far the limb is tilted, radians, and shifted, metres, along both sides of the patch that felt.
const ROUNDS: [[([f64; 2], [f64; 2]); 4]; 3] = [
    [([0.0, 0.12], [0.0; 2]), ([0.0, -0.12], [0.0; 2]), ([0.12, 0.0], [0.0; 2]), ([-0.12, 0.0], [0.0; 2])],
    [
        ([0.0; 2], [0.005, 0.0]),
        ([0.0; 2], [-0.005, 0.0]),
        ([0.0; 2], [0.0, 0.005]),
        ([0.0; 2], [0.0, -0.005]),
    ],
    [
        ([0.15, 0.15], [0.0; 2]),
        ([-0.15, 0.15], [0.0; 2]),
        ([0.15, -0.15], [0.0; 2]),
        ([-0.15, -0.15], [0.0; 2]),
    ],
];

impl Actor {
    /// Goes on feeling what it touches: draws back a little, tilts or shifts the limb, and touches again; what was felt, its
    /// place sharpened. In the end the limb is a little off the thing. Where it does not touch what it found any more, nothing is
    /// done and the place is as it was.
    ///
    /// # Errors
    /// [`Trouble::Engine`].
    pub fn feel_on(&mut self, found: &FoundThing) -> Result<FoundThing, Trouble> {
        let as_it_was = found.clone();
        let limb = self.own.skin().receptors[found.receptor].limb;
        let Some(hand) = self.arm_of(found.receptor) else { return Ok(as_it_was) };
        let posture = self.posture();
        if posture != found.posture {
            return Ok(as_it_was);
        }
        let carrying = self.own.joints_to(limb);
        let joints: Vec<usize> =
            self.hands[hand].arm.iter().copied().filter(|joint| carrying.contains(joint)).collect();
        let first = self.frames()[limb];
        let mut poses: Vec<FeltPose> = BEFORE
            .into_iter()
            .filter_map(|steps| self.trail.iter().rev().nth(steps))
            .map(|before| FeltPose { limb: self.own.frames(before)[limb], receptor: None })
            .collect();
        let mut came_by = std::mem::take(&mut self.trail);
        let mut rng = self.new_rng();
        let Some(mut surface) = self.comes_off(found, &first, &came_by, &joints)? else {
            self.trail = came_by;
            return Ok(as_it_was);
        };
        'rounds: for round in ROUNDS {
            for (tilt, shift) in round {
                // Where there is no room for it, a part of it.
                for share in SHARES {
                    let [tilt, shift] = [tilt, shift].map(|by| by.map(|by| share * by));
                    match self.touch_tilted(&surface, found.receptor, &joints, tilt, shift)? {
                        Probed::Met(pose) => poses.push(pose),
                        Probed::Empty(empty) => poses.extend(empty),
                        Probed::Hindered => continue,
                        Probed::Other => break 'rounds,
                    }
                    break;
                }
            }
            let felt = FeltSurface::of(&self.own, found.receptor, &first, &poses, &mut rng);
            surface = felt.unwrap_or(surface);
            if surface.deviation < SURE {
                break;
            }
        }
        self.part(&surface, &joints, surface.direction)?;
        // From there it can go back the way that it came, but for its end.
        let at = |posture: &[f64]| self.own.frames(posture)[limb].point(&surface.place.point);
        while came_by.back().is_some_and(|posture| (at(posture) - surface.point).norm() < RETREAT) {
            came_by.pop_back();
        }
        self.trail = came_by;
        let sharp = surface.deviation <= SHARP;
        Ok(FoundThing { point: surface.point, direction: surface.direction, sharp, ..as_it_was })
    }

    /// The posture near another in which a place of the skin is at a point and its normal leads in a direction, as far as the
    /// joints allow.
    pub(super) fn tilted(
        &self,
        place: Place,
        joints: &[usize],
        point: Vector3<f64>,
        direction: Vector3<f64>,
        near: &[f64],
    ) -> Posture {
        let solver = self.own.bringing(place, point, direction, joints);
        solver.with_direction_lengths([DIRECTION_LENGTH; 2]).solve(near).posture
    }

    /// Takes the limb off for the first time: back the way that it came, or, where it did not come by itself, along one of the
    /// normals of its patch. The surface as it is first thought of; `None` if the limb does not come off.
    fn comes_off(
        &mut self,
        found: &FoundThing,
        first: &Frame,
        came_by: &VecDeque<Posture>,
        joints: &[usize],
    ) -> Result<Option<FeltSurface>, Trouble> {
        let place = self.felt_with(found);
        let patch = self.own.skin().receptors[found.receptor].clone();
        let unsure = patch.covariance(0.0).trace().sqrt();
        let at = |actor: &Actor, posture: &[f64]| actor.own.frames(posture)[place.limb].point(&place.point);
        let back: Vec<Posture> = came_by
            .iter()
            .rev()
            .take_while(|posture| (at(self, posture) - found.point).norm() < RETREAT)
            .cloned()
            .collect();
        if let Some(end) = back.last() {
            self.follow(&PosturePath(vec![end.clone()]), SWIFT, |_, _| false)?;
            let surface = FeltSurface::at(place, first, unsure);
            return Ok(Some(surface));
        }
        let here = self.posture();
        for at in PLACES {
            let Some(place) = self.own.on_surface(found.receptor, &patch.patch_point(at)) else { continue };
            let surface = FeltSurface::at(place, first, unsure);
            if self.part(&surface, joints, surface.direction)? {
                return Ok(Some(surface));
            }
            self.follow(&PosturePath(vec![here.clone()]), SWIFT, |_, _| false)?;
        }
        Ok(None)
    }

    /// Draws the limb back until it no longer feels anything, fast, so that nothing is pushed; whether it comes off.
    fn part(
        &mut self,
        surface: &FeltSurface,
        joints: &[usize],
        direction: Vector3<f64>,
    ) -> Result<bool, Trouble> {
        let limb = surface.place.limb;
        for far in [RETREAT, 2.0 * RETREAT] {
            let from = self.posture();
            let back = self.tilted(surface.place, joints, surface.point - direction * far, direction, &from);
            let way = PosturePath(vec![back.clone()]);
            self.follow(&way, SWIFT, |_, _| false)?;
            if !self.step(&back)?.iter().any(|contact| contact.spot.limb == limb) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Draws back, tilts and shifts the limb, and touches again.
    fn touch_tilted(
        &mut self,
        surface: &FeltSurface,
        receptor: usize,
        joints: &[usize],
        tilt: [f64; 2],
        shift: [f64; 2],
    ) -> Result<Probed, Trouble> {
        let limb = surface.place.limb;
        let from = self.posture();
        let n = surface.direction;
        let frame = self.own.frames(&from)[limb];
        let tangent = frame.direction(&self.own.skin().receptors[receptor].tangent);
        let Some(first) = (tangent - n * tangent.dot(&n)).try_normalize(1e-6) else {
            return Ok(Probed::Hindered);
        };
        let second = n.cross(&first);
        let turn =
            |angle: f64, axis: Vector3<f64>| Rotation3::from_axis_angle(&Unit::new_normalize(axis), angle);
        let direction = turn(tilt[0], first) * turn(tilt[1], second) * n;
        let aside = first * shift[0] + second * shift[1];
        if !self.part(surface, joints, n)? {
            return Ok(Probed::Hindered);
        }
        let parted = self.posture();
        let strides = ((RETREAT + ADVANCE) / STRIDE).round() as usize;
        let PosturePath(mut way) = PosturePath::stepwise(&parted, strides + 1, |k, last| {
            let point = surface.point + aside + n * (STRIDE * (k - 1) as f64 - RETREAT);
            Some(self.tilted(surface.place, joints, point, direction, last))
        });
        let clearance = self.clearance.moved_by(&self.own, joints);
        let clearance = clearance.eased_at(&[self.own.frames(&parted)], CLEAR);
        // The thing is beyond the plane, and how far it reaches there is not known: no other limb goes there, or not farther than
        // it is.
        let room = Obstacle::Dome { centre: surface.point, into: n, radius: ROOM };
        let moved = self.own.moved_by(joints);
        let others: Vec<usize> = (0..moved.len()).filter(|&other| moved[other] && other != limb).collect();
        let gaps = |posture: &[f64]| {
            let frames = self.own.frames(posture);
            let gap = |&other: &usize| clearance.to_obstacle(&frames, other, &room, CLEAR).min(CLEAR);
            others.iter().map(gap).collect::<Vec<f64>>()
        };
        let now = gaps(&parted);
        let clear = |posture: &Posture| {
            clearance.free(&self.own.frames(posture), CLEAR)
                && gaps(posture).iter().zip(&now).all(|(then, now)| *then >= now - NEARER)
        };
        let free = way.iter().take_while(|posture| clear(posture)).count();
        if free < 3 {
            return Ok(Probed::Hindered);
        }
        way.truncate(free);
        let swept: Vec<FeltPose> = way[1..]
            .iter()
            .step_by(3)
            .map(|posture| FeltPose { limb: self.own.frames(posture)[limb], receptor: None })
            .collect();
        let contacts = self.follow(&PosturePath(way), FEELING, |_, _| true)?;
        if contacts.is_empty() {
            return Ok(Probed::Empty(swept));
        }
        let by_limb = |contact: &&SkinContact| contact.spot.limb == limb && self.is_thing(contact);
        match contacts.iter().find(by_limb) {
            Some(contact) => {
                let limb = self.frames()[limb];
                Ok(Probed::Met(FeltPose { limb, receptor: Some(contact.spot.receptor) }))
            }
            None => {
                self.unintended += 1;
                Ok(Probed::Other)
            }
        }
    }
}

/// What came of touching again.
enum Probed {
    /// It was met.
    Met(FeltPose),
    /// Nothing was there.
    Empty(Vec<FeltPose>),
    /// The body or the table is in the way.
    Hindered,
    /// Other skin met something.
    Other,
}
