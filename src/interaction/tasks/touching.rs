//! Touching with the other hand what an arm has felt (IVA 2009, section 4).

use std::f64::consts::TAU;

use nalgebra::Rotation3;

use super::{BACK, Trouble};
use crate::interaction::actor::{Actor, CAREFUL, Found, SWIFT, Stop};
use crate::interaction::scene::Touched;
use crate::kinematics::REACHED;
use crate::peripersonal::{Aim, Obstacle, OutOfReach, Reaching, Way};

/// Radii of the room that a thing is given that was felt, metres, of which not more is known than where it begins: the
/// greatest that leaves a way.
const ROOMS: [f64; 4] = [0.15, 0.1, 0.06, 0.03];

/// How something was touched.
#[derive(Clone, Debug, PartialEq)]
pub struct Touching {
    /// What was felt.
    pub found: Found,
    /// The receptor that was to touch.
    pub receptor: usize,
    /// How often it had to correct itself.
    pub corrections: usize,
}

impl Actor {
    /// The aims at a thing that was felt at one place: on from where the skin went, then from above and from about it.
    fn aims(&self, found: &Found) -> Vec<Aim> {
        let Found { point, direction, .. } = *found;
        let level = (direction - self.up * direction.dot(&self.up)).try_normalize(0.3);
        let mut aims = Vec::new();
        let resting = self.table.is_some_and(|height| (point.dot(&self.up) - height).abs() < 0.12);
        match level {
            // What stands on a table is met level.
            Some(level) if resting => {
                aims.push(Aim { point, direction: level });
                aims.push(Aim { point: point + level * 0.015 + self.up * 0.01, direction: -self.up });
            }
            _ => aims.push(Aim { point, direction }),
        }
        for angle in [0.5, -0.5, 0.9, -0.9] {
            let axis = if level.is_some() { self.up } else { self.left() };
            let turn = Rotation3::new(axis * angle);
            aims.push(Aim { point, direction: turn * aims[0].direction });
        }
        aims
    }

    /// Touches a thing that was felt, with a hand: what felt it goes back first, then the hand comes to where it was.
    /// Where the hand feels nothing, or something else, it corrects itself, up to `corrections` times. `lean` lets the
    /// trunk help.
    ///
    /// # Errors
    /// [`Trouble`].
    pub fn touch(
        &mut self,
        found: &Found,
        hand: usize,
        lean: bool,
        corrections: usize,
    ) -> Result<Touching, Trouble> {
        let ready = self.ready();
        match self.withdraw(found, &ready) {
            // It touches something where it is: it stays there, a little back, and the other hand finds its way.
            Err(Trouble::Hit(feelings)) => self.back_off(&feelings)?,
            went => went?,
        }
        self.touch_again(found, hand, lean, corrections)
    }

    /// The same where what felt the thing is away from it already.
    ///
    /// # Errors
    /// [`Trouble`].
    pub fn touch_again(
        &mut self,
        found: &Found,
        hand: usize,
        lean: bool,
        corrections: usize,
    ) -> Result<Touching, Trouble> {
        let joints = self.hands[hand].joints(lean).to_vec();
        let receptors = self.hands[hand].receptors.clone();
        let (mut corrected, mut trouble) = (0, Trouble::Nothing);
        for aim in self.aims(found) {
            let from = self.posture();
            let planned = self.making_room(&aim, |actor| {
                Ok(actor.reaching(joints.clone()).approach(&from, &receptors, &aim)?)
            });
            let plan = match planned {
                Ok(plan) => plan,
                // What is nearest to being reached says most.
                Err(Trouble::Reach(reason @ (OutOfReach::TooFar(_) | OutOfReach::Barred))) => {
                    let better = match (&trouble, &reason) {
                        (Trouble::Reach(OutOfReach::TooFar(before)), OutOfReach::TooFar(now)) => now < before,
                        (Trouble::Nothing, _) => corrected == 0,
                        (Trouble::Reach(OutOfReach::TooFar(_)), OutOfReach::Barred) => true,
                        _ => false,
                    };
                    if better {
                        trouble = reason.into();
                    }
                    continue;
                }
                Err(trouble) => return Err(trouble),
            };
            let touched = self.try_touch([&plan.way, &plan.straight], hand);
            if let Ok(Some(found)) = touched {
                return Ok(Touching { found, receptor: plan.receptor, corrections: corrected });
            }
            if corrected == corrections {
                return Err(touched.err().unwrap_or(Trouble::Nothing));
            }
            corrected += 1;
            match touched {
                Ok(_) => {
                    if let Ok(Some(found)) = self.search(plan.receptor, &aim, &joints, hand) {
                        return Ok(Touching { found, receptor: plan.receptor, corrections: corrected });
                    }
                    trouble = Trouble::Nothing;
                    let back = plan.straight.0[0].clone();
                    let _ = self.retreat(&back);
                }
                Err(Trouble::Hit(feelings)) => {
                    // Back the way that it came, and another way.
                    self.back_off(&feelings)?;
                    trouble = Trouble::Hit(feelings);
                }
                Err(trouble) => return Err(trouble),
            }
        }
        Err(trouble)
    }

    /// Does something with room left for a thing that begins at a place: as much as leaves a way.
    fn making_room<T>(
        &mut self,
        aim: &Aim,
        mut act: impl FnMut(&mut Actor) -> Result<T, Trouble>,
    ) -> Result<T, Trouble> {
        let mut outcome = Err(OutOfReach::Barred.into());
        for radius in ROOMS {
            // A ball that the place is on.
            let ends = [aim.point + aim.direction * radius; 2];
            self.clearance.obstacles.push(Obstacle::Capsule { ends, radius });
            outcome = act(self);
            self.clearance.obstacles.pop();
            if !matches!(outcome, Err(Trouble::Reach(OutOfReach::Barred))) {
                break;
            }
        }
        outcome
    }

    /// Goes along a way and then straight on; what the hand feels there, or none where it feels nothing.
    ///
    /// # Errors
    /// [`Trouble::Hit`] where something else is felt before.
    fn try_touch(&mut self, [way, straight]: [&Way; 2], hand: usize) -> Result<Option<Found>, Trouble> {
        let receptors = self.hands[hand].receptors.clone();
        let stop = match self.follow(way, SWIFT, |_, _| true)? {
            Stop::Arrived => self.follow(straight, CAREFUL, |_, _| true)?,
            // Met sooner than thought: a thing may be larger than the room it was given.
            felt => felt,
        };
        let Stop::Felt(feelings) = stop else { return Ok(None) };
        let by_hand = feelings.iter().find(|feeling| {
            receptors.contains(&feeling.receptor)
                && matches!(feeling.what, Touched::Thing(_))
                && !self.is_table(feeling)
        });
        match by_hand.and_then(|feeling| self.found(feeling)) {
            Some(found) => Ok(Some(found)),
            None => {
                self.unintended += 1;
                Err(Trouble::Hit(feelings))
            }
        }
    }

    /// Feels about where something was expected, in circles across the way that the hand came.
    fn search(
        &mut self,
        receptor: usize,
        aim: &Aim,
        joints: &[usize],
        hand: usize,
    ) -> Result<Option<Found>, Trouble> {
        let place = self.own.place(receptor);
        let across = aim.direction.cross(&self.up).try_normalize(1e-3).unwrap_or_else(|| self.left());
        let along = aim.direction.cross(&across);
        let (mut posture, mut way) = (self.posture(), Vec::new());
        let (own, clearance) = (&self.own, &self.clearance);
        let limbs = 1..own.creature.limbs().len();
        let reaching = Reaching::new(own, clearance, joints.to_vec(), self.seed);
        for (radius, depth) in [(0.015, 0.005), (0.03, 0.005), (0.045, 0.005)] {
            for k in 0..=12 {
                let angle = TAU * f64::from(k) / 12.0;
                let offset = across * (radius * angle.cos()) + along * (radius * angle.sin());
                let point = aim.point + aim.direction * depth + offset;
                let reach = reaching.solve(place, &Aim { point, ..*aim }, &posture);
                let frames = own.frames(&reach.posture);
                let above = clearance.obstacles.iter().all(|obstacle| {
                    limbs.clone().all(|limb| clearance.to_obstacle(&frames, limb, obstacle, 0.003) >= 0.003)
                });
                if reach.miss <= REACHED && above {
                    posture.clone_from(&reach.posture);
                    way.push(reach.posture);
                }
            }
        }
        if way.is_empty() {
            return Ok(None);
        }
        self.try_touch([&Way(Vec::new()), &Way(way)], hand)
    }

    /// Takes the arm that felt something back to where it was ready, away from the thing.
    pub(in crate::interaction) fn withdraw(&mut self, found: &Found, ready: &[f64]) -> Result<(), Trouble> {
        let Some(hand) = self.arm_of(found.receptor) else { return Ok(()) };
        let arm = self.hands[hand].arm.clone();
        let back = match self.back_by(found.receptor, BACK) {
            Some(way) => {
                let back = way.end().map(<[f64]>::to_vec);
                self.pass(&way, SWIFT)?;
                back.unwrap_or_else(|| self.posture())
            }
            // It has not come here by itself: away from the thing.
            None => {
                let place = self.own.place(found.receptor);
                let from = self.posture();
                let (point, direction) = self.feels_at(found.receptor);
                let away = Aim { point: point - direction * BACK, direction };
                let back = self.reaching(arm.clone()).solve(place, &away, &from).posture;
                self.retreat(&back)?;
                back
            }
        };
        // Only this arm moves: the other is where it is wanted.
        let mut target = back.clone();
        for &joint in &arm {
            let q = self.own.creature.joints()[joint].coordinates();
            target[q.clone()].copy_from_slice(&ready[q]);
        }
        let aim = Aim { point: found.point, direction: found.direction };
        self.making_room(&aim, |actor| actor.go_by(&back, &target, &arm))
    }
}
