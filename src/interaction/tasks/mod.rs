//! What a creature does about what it feels: explores a table blind, touches with the other hand what it felt, holds it,
//! puts it far away or near (IVA 2009, section 4); lifts it between both palms, by friction.

mod carrying;
mod exploring;
mod feeling;
mod feeling_over;
mod feeling_shape;
mod lifting;
mod putting;
mod searching;
mod touching;
mod two_palms;
mod wielding;

use nalgebra::Vector3;

pub use feeling_over::{BodyFound, FeltOver};
pub use feeling_shape::ShapeFeeling;
pub use lifting::Grip;
pub use putting::Spot;
pub use searching::{Feeling, Search, SearchPlan};
pub use touching::Touching;
pub use two_palms::PalmPlan;

use super::actor::{Actor, CAREFUL, Hand, SWIFT};
use crate::creature::Posture;
use crate::error::{Error, Result};
use crate::geometry::Frame;
use crate::peripersonal::{OutOfReach, PosturePath, find_path};
use crate::senses::SkinContact;

/// How clear of everything ways and hands that wait keep, metres.
const MARGIN: f64 = 0.006;
/// How fast the tips of the hands go low over a table and down to it, metres a second.
const SWEEPING: f64 = 2.0 * CAREFUL;
/// How far skin goes back from what it touched before anything else, metres.
const BACK: f64 = 0.05;
/// How high a hand waits, the first of these that leaves it clear: in lengths of the arm above the joint that carries it.
const READY_HEIGHTS: [f64; 4] = [-0.35, -0.25, -0.15, 0.0];

/// Random postures of which the best is sought, …
const DRAWN: usize = 400;
/// … and how clear of everything they keep, metres.
const DRAWN_CLEAR: f64 = 0.01;

/// How many steps back he goes from a touch to come again, and how fast the tips of the hands then go, metres a second: in
/// the end a hundredth of a millimetre a step.
const AGAIN: [(usize, f64); 2] = [(12, 0.05), (6, 0.005)];
/// How many steps of the way back he then leaves it by, so that what touched is clear.
const LEAVING: usize = 60;

/// Why something could not be done.
#[derive(Debug, thiserror::Error)]
pub enum Trouble {
    /// A place cannot be touched.
    #[error(transparent)]
    Reach(#[from] OutOfReach),
    /// Nothing was felt where something was expected.
    #[error("I felt nothing where I expected something")]
    Nothing,
    /// Something else was in the way.
    #[error("I ran into something on the way")]
    Hit(Vec<SkinContact>),
    /// The palms cannot both get to the sides of a thing.
    #[error("I cannot get my hands to both sides of it")]
    NoSides,
    /// A thing is wider than the palms come apart.
    #[error("it is too wide for my hands")]
    TooWide,
    /// A thing slipped out from between the palms.
    #[error("it slips from between my hands")]
    Slipped,
    /// What is said of it.
    #[error("{0}")]
    Told(String),
    /// The engine failed.
    #[error(transparent)]
    Engine(#[from] Error),
}

impl Trouble {
    /// What hinders the task alone: a failure of the engine is passed on.
    pub(in crate::interaction) fn of_task(self) -> Result<Trouble> {
        match self {
            Trouble::Engine(error) => Err(error),
            trouble => Ok(trouble),
        }
    }
}

/// What was done, `None` if something hindered it that does not matter; only a failure of the engine is passed on.
pub(in crate::interaction) fn tried<T>(result: Result<T, Trouble>) -> Result<Option<T>> {
    match result {
        Ok(done) => Ok(Some(done)),
        Err(trouble) => trouble.of_task().map(|_| None),
    }
}

impl Actor {
    /// To its left, horizontally, in the root's frame.
    pub fn left(&self) -> Vector3<f64> {
        self.up.cross(&self.front)
    }

    /// On which side of it a hand is: 1 where it is on the left, −1 on the right.
    pub fn side(&self, hand: usize) -> f64 {
        let frames = self.own.frames(&self.own.at_ease());
        frames[self.hands[hand].limb].origin.dot(&self.left()).signum()
    }

    /// The hand that is on the side to which a direction of the root's frame leads.
    pub fn hand_towards(&self, direction: &Vector3<f64>) -> usize {
        usize::from(self.side(0) * direction.dot(&self.left()) < 0.0)
    }

    /// The posture in which both hands wait in front of the trunk, clear of a table where one is known.
    pub fn ready(&mut self) -> Posture {
        let mut posture = self.own.at_ease();
        let frames = self.own.frames(&posture);
        for hand in 0..2 {
            let Hand { arm, tip, limb, .. } = &self.hands[hand].clone();
            let root = frames[arm[0] + 1].origin;
            let length = (frames[*limb].origin - root).norm();
            // What is near each other in the rest posture is so for good.
            let clearance =
                self.clearance.moved_by(&self.own, arm).eased_at(std::slice::from_ref(&frames), MARGIN);
            let mut bent = posture.clone();
            // Bent joints make for an arm that does not reach down.
            for &joint in arm.iter().skip(1) {
                let joint = &self.own.creature().joints()[joint];
                for at in joint.elements().filter(|at| !at.is_ball()) {
                    bent[at.coordinate()] = 0.5 * (at.range[0] + at.range[1]);
                }
            }
            let at = |height: f64| {
                let point = self.front * (root.dot(&self.front) + 0.55 * length)
                    + self.left() * (root.dot(&self.left()) + self.side(hand) * 0.35 * length)
                    + self.up * (root.dot(&self.up) + height * length);
                let solver = self.own.bringing(self.own.place(*tip), point, Vector3::zeros(), arm);
                let solver = solver.at_ease(&posture);
                [&bent, &posture].map(|start| solver.solve(start))
            };
            let waits = |posture: &[f64]| clearance.free(&self.own.frames(posture), MARGIN);
            let found =
                READY_HEIGHTS.into_iter().flat_map(at).find(|reach| reach.reached() && waits(&reach.posture));
            if let Some(reach) = found {
                posture = reach.posture;
            }
        }
        posture
    }

    /// Of random postures of some joints that keep clear that for which a score of the limbs' poses is greatest; `None` if none
    /// keeps clear.
    pub(super) fn best_drawn(
        &mut self,
        joints: &[usize],
        score: impl Fn(&Actor, &[Frame]) -> f64,
    ) -> Option<Posture> {
        let (from, mut rng) = (self.posture(), self.new_rng());
        let clearance = self.clearance.moved_by(&self.own, joints);
        let mut best: Option<(f64, Posture)> = None;
        for _ in 0..DRAWN {
            let posture = self.own.random_posture(&from, joints, &mut rng);
            let frames = self.own.frames(&posture);
            let scored = score(self, &frames);
            let better = best.as_ref().is_none_or(|(most, _)| scored > *most);
            if better && clearance.free(&frames, DRAWN_CLEAR) {
                best = Some((scored, posture));
            }
        }
        best.map(|(_, posture)| posture)
    }

    /// Goes to a posture, moving both arms and what carries them, on a way that keeps clear.
    ///
    /// # Errors
    /// [`Trouble`] if there is no path or something is felt on it.
    pub fn go(&mut self, target: &[f64]) -> Result<(), Trouble> {
        let from = self.posture();
        let joints: Vec<usize> = self.hands.iter().flat_map(|hand| hand.leaning.clone()).collect();
        self.go_by(&from, target, &joints)
    }

    fn go_by(&mut self, from: &[f64], target: &[f64], joints: &[usize]) -> Result<(), Trouble> {
        let way = self.find_path([from, target], joints)?;
        self.pass(&way, SWIFT)
    }

    /// A way between two postures that moves some joints and keeps clear; a new random stream with each.
    fn find_path(&mut self, ends: [&[f64]; 2], joints: &[usize]) -> Result<PosturePath, OutOfReach> {
        let mut rng = self.new_rng();
        find_path(&self.own, &self.clearance, ends, joints, MARGIN, &mut rng).ok_or(OutOfReach::Barred)
    }

    /// Goes back the way that it came from what was met on it.
    fn back_off(&mut self, contacts: &[SkinContact], far: f64) -> Result<()> {
        if let Some(way) = contacts.first().and_then(|contact| self.back_by(contact.spot.receptor, far)) {
            self.follow(&way, SWIFT, |_, _| false)?;
        }
        Ok(())
    }

    /// Follows a way on which nothing is expected.
    pub(super) fn pass(&mut self, way: &PosturePath, speed: f64) -> Result<(), Trouble> {
        let met = self.follow(way, speed, |_, _| true)?;
        if met.is_empty() {
            return Ok(());
        }
        self.unintended += 1;
        Err(Trouble::Hit(met))
    }

    /// Goes back straight to a posture that it has just come from.
    fn retreat(&mut self, to: &[f64]) -> Result<(), Trouble> {
        self.pass(&PosturePath(vec![Posture::from(to)]), SWIFT)
    }

    /// Goes straight to a posture until contacts tell something; what they tell after he has come once more, slowly, and more
    /// slowly, and the posture then. It counts only where he was clear of it before he came again: no contact that `touches`
    /// says is one of it. He goes back from whatever he met.
    ///
    /// # Errors
    /// Where the engine fails.
    fn touch_exactly<T>(
        &mut self,
        target: &Posture,
        touches: impl Fn(&Actor, &SkinContact) -> bool,
        told: impl Fn(&Actor, &[SkinContact]) -> Option<T>,
    ) -> Result<Option<(T, Posture)>, Trouble> {
        let mut since = self.steps;
        let way = PosturePath(vec![target.clone()]);
        let contacts = self.follow(&way, SWIFT, |_, _| true)?;
        if contacts.is_empty() {
            return Ok(None);
        }
        let leaving = self.lately(since).take(LEAVING).cloned().collect();
        let mut touch = told(self, &contacts);
        for (steps, speed) in AGAIN {
            if touch.is_none() {
                break;
            }
            let met = self.posture();
            let back: Vec<Posture> = self.lately(since).take(steps).cloned().collect();
            let Some(before) = back.last() else { break };
            self.follow(&PosturePath(vec![before.clone()]), SWIFT, |_, _| false)?;
            // What is still in what it met would be felt on coming again long after it touched.
            if self.wait(0.0)?.iter().any(|contact| touches(self, contact)) {
                touch = None;
                break;
            }
            since = self.steps;
            let contacts = self.follow(&PosturePath(vec![met]), speed, |_, _| true)?;
            touch = told(self, &contacts);
        }
        let posture = self.posture();
        self.follow(&PosturePath(leaving), SWIFT, |_, _| false)?;
        Ok(touch.map(|touch| (touch, posture)))
    }
}
