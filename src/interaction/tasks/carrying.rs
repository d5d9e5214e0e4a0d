//! What one hand does with a thing that is welded to it by a touch: it raises and lowers it, or carries it to a spot, the whole
//! path, up, over and down, planned in advance.

use nalgebra::Vector3;

use super::Trouble;
use super::putting::Spot;
use crate::creature::Posture;
use crate::geometry::{Ball, Capsule};
use crate::interaction::actor::{Actor, CAREFUL, SWIFT};
use crate::kinematics::{InverseKinematics, Place};
use crate::peripersonal::{Obstacle, OutOfReach, PosturePath, ReachTarget, distance};
use crate::senses::{SkinContact, Toucher};

/// Steps of a way straight up or down, metres: so small that the arm keeps its pose by going on from step to step.
const STRIDE: f64 = 0.005;
/// How much lower than where it stood a thing is let down before it is let go, metres.
const SINKS: f64 = 0.003;
/// How high a thing is lifted, metres: the highest of these that its way allows.
const LIFTS: [f64; 4] = [0.2, 0.12, 0.08, 0.05];
/// How far towards oneself it is lifted, metres: straight up where that can be done. An arm that is stretched out cannot.
const DRAWN_BACK: [f64; 5] = [0.0, 0.03, 0.06, 0.1, 0.15];
/// Steps in which it is lifted or put down.
const LIFTING: usize = 12;
/// How clear of everything limbs keep while it is lifted, where they are not nearer before, metres.
const LIFTING_MARGIN: f64 = 0.004;
/// Cosine of the most that it is tilted on its way up and down, by about 5 degrees.
const TILTED: f64 = 0.996;
/// How far a hand is raised off what it let go, metres.
const LIFT: f64 = 0.05;
/// Least size of a thing's height, metres: the table is not felt through what is lower.
const SETTLE: f64 = 0.002;
/// What a radian is worth in metres where a grip is to stay upright, at first and at the last.
const UPRIGHT: [f64; 2] = [0.05, 0.02];
/// How often it is carried anew at most, after something was met on the way.
const ATTEMPTS: usize = 8;
/// How large what was met is taken to be, metres: by what skin meets, and by what what is held meets.
const MET: f64 = 0.04;
const MET_THROUGH: f64 = 0.08;
/// Half of how wide what is held is taken to be under the grip, metres.
const HALF_WIDTH: f64 = 0.015;
/// How far it goes back from there, metres.
const MET_BACK: f64 = 0.06;
/// Nearer than this a posture is the one that a plan begins in, radians.
const SAME: f64 = 1e-6;

/// How to carry what is held from where it is to a spot.
#[derive(Clone, Debug, PartialEq)]
pub struct CarryingPlan {
    /// The posture that it begins in.
    from: Posture,
    /// Up from where it stands.
    up: PosturePath,
    /// From there to over the spot.
    over: PosturePath,
    /// Down to the spot and, where nothing is felt, a little farther.
    down: PosturePath,
}

impl Actor {
    /// How to carry what a place of a limb holds, its direction up, from the present posture to another one: lifted as high
    /// as can be, on a way that keeps clear.
    ///
    /// # Errors
    /// [`OutOfReach::Barred`] where there is no such way.
    pub(super) fn plan_carrying(
        &mut self,
        place: Place,
        to: &[f64],
        joints: &[usize],
    ) -> Result<CarryingPlan, OutOfReach> {
        let up = self.lifted_here(place, joints).ok_or(OutOfReach::Barred)?;
        self.plan_after(place, up, to, joints)
    }

    /// A way on which what a place holds keeps off the table, as far down as it is known to reach: to where it stood, the place
    /// at the height `stood` and its direction up.
    fn way_over(
        &mut self,
        place: Place,
        ends: [&[f64]; 2],
        joints: &[usize],
        stood: f64,
    ) -> Result<PosturePath, OutOfReach> {
        let bare = self.clearance.clone();
        if let Some(hangs) = self.table.map(|table| stood - table).filter(|hangs| *hangs > HALF_WIDTH) {
            let count = (hangs / (2.0 * HALF_WIDTH)).ceil().max(1.0);
            let ball = |k: f64| Ball {
                centre: place.point - place.direction * (hangs - HALF_WIDTH) * (k / count),
                radius: HALF_WIDTH,
            };
            let balls: Vec<Ball> = (0..=count as usize).map(|k| ball(k as f64)).collect();
            self.clearance = bare.carrying(place.limb, &balls);
        }
        let way = self.find_path(ends, joints);
        self.clearance = bare;
        way
    }

    /// The way on which what a place holds is lifted from where it stands now.
    pub(super) fn lifted_here(&self, place: Place, joints: &[usize]) -> Option<PosturePath> {
        self.lifted(place, &self.posture(), joints, &DRAWN_BACK[..1])
    }

    /// The same where what is held has been lifted on a way already.
    pub(super) fn plan_after(
        &mut self,
        place: Place,
        mut up: PosturePath,
        to: &[f64],
        joints: &[usize],
    ) -> Result<CarryingPlan, OutOfReach> {
        let mut down = self.lifted(place, to, joints, &DRAWN_BACK).ok_or(OutOfReach::Barred)?;
        let (Some(raised), Some(above)) = (up.0.last().cloned(), down.0.last().cloned()) else {
            return Err(OutOfReach::Barred);
        };
        let stood = self.own.frames(to)[place.limb].point(&place.point).dot(&self.up);
        let over = self.way_over(place, [&raised, &above], joints, stood)?;
        let from = up.0.remove(0);
        down.0.reverse();
        let point = self.own.frames(to)[place.limb].point(&place.point) - self.up * SETTLE;
        down.0.push(self.upright_at(place, point, joints).solve(to).posture);
        Ok(CarryingPlan { from, up, over, down })
    }

    /// The way on which a place is lifted from a posture, as high as can be and as straight up, its direction up and limbs
    /// clear; begins with the posture.
    fn lifted(&self, place: Place, start: &[f64], joints: &[usize], back: &[f64]) -> Option<PosturePath> {
        let own = &self.own;
        let frames = own.frames(start);
        let here = frames[place.limb].point(&place.point);
        let clearance =
            self.clearance.moved_by(own, joints).eased_at(std::slice::from_ref(&frames), LIFTING_MARGIN);
        let whole = |lift: f64, back: f64| {
            let way = PosturePath::stepwise(start, LIFTING, |k, last| {
                let share = k as f64 / LIFTING as f64;
                let point = here + (self.up * lift - self.front * back) * share;
                let reach = self.upright_at(place, point, joints).solve(last);
                let goes = reach.reached()
                    && reach.facing >= TILTED
                    && clearance.free(&own.frames(&reach.posture), LIFTING_MARGIN);
                goes.then_some(reach.posture)
            });
            Some(way).filter(|way| way.0.len() > LIFTING)
        };
        LIFTS
            .into_iter()
            .flat_map(|lift| back.iter().map(move |&back| (lift, back)))
            .find_map(|(l, b)| whole(l, b))
    }

    /// Carries what a receptor holds to a spot: up, over, and down until it is felt to stand; then lets go and comes
    /// back. Where something is met on the way, it keeps off that from then on; where the spot was the farthest, another is
    /// chosen that does. Tells where the grip was when it let go, in the root's frame, metres.
    ///
    /// # Errors
    /// [`Trouble`].
    pub fn put(&mut self, receptor: usize, spot: &Spot, lean: bool) -> Result<Vector3<f64>, Trouble> {
        let Some(hand) = self.arm_of(receptor) else { return Err(Trouble::Nothing) };
        let joints = self.hands[hand].joints(lean).to_vec();
        let place = self.upright(receptor);
        // What is met on the way is kept off until it stands.
        self.with_obstacles([], |actor| actor.carry_to(receptor, place, spot, &joints))?;
        self.let_go();
        let stay = self.posture();
        self.wait(0.2)?;
        let point = self.feels_at(receptor).0;
        let back = self.upright_at(place, point + self.up * LIFT, &joints).solve(&stay).posture;
        self.follow(&PosturePath(vec![back]), CAREFUL, |_, _| false)?;
        Ok(point)
    }

    /// Carries what is held until it stands at a spot.
    fn carry_to(
        &mut self,
        receptor: usize,
        place: Place,
        spot: &Spot,
        joints: &[usize],
    ) -> Result<(), Trouble> {
        let mut spot = spot.clone();
        if distance(&self.posture(), &spot.plan.from) >= SAME {
            spot.plan = self.plan_carrying(place, &spot.posture, joints)?;
        }
        // What is held may scrape over what it stands on: that is no surprise.
        let expected = |_: &Actor, contact: &SkinContact| !matches!(contact.by, Toucher::Through(_));
        self.follow(&spot.plan.up, CAREFUL, expected)?;
        for attempt in 1.. {
            match self.pass(&spot.plan.over, SWIFT) {
                Err(Trouble::Hit(contacts)) if attempt < ATTEMPTS => {
                    self.keep_off(receptor, &contacts)?;
                    let from = self.posture();
                    let again = spot.chosen.and_then(|chosen| {
                        self.farthest_from(place, chosen, joints, &PosturePath(vec![from.clone()]))
                    });
                    match again {
                        Some(again) => spot = again,
                        None => {
                            let above = spot.plan.over.end().map(Posture::from);
                            let above = above.ok_or(OutOfReach::Barred)?;
                            spot.plan.over =
                                self.way_over(place, [&from, &above], joints, spot.point.dot(&self.up))?;
                        }
                    }
                }
                Err(trouble) => return Err(trouble),
                Ok(()) => break,
            }
        }
        self.follow(&spot.plan.down, CAREFUL, |_, contact| matches!(contact.by, Toucher::Through(_)))?;
        Ok(())
    }

    /// Goes back from what was met and takes it for a ball, of which the hand, and what it holds, is to keep clear.
    fn keep_off(&mut self, receptor: usize, contacts: &[SkinContact]) -> Result<(), Trouble> {
        let Some(contact) = contacts.first() else { return Ok(()) };
        let (grip, _) = self.feels_at(receptor);
        let (point, into) = self.feels_at(contact.spot.receptor);
        let way = self.back_by(contact.spot.receptor, MET_BACK);
        let before = way.as_ref().and_then(PosturePath::end).map(|posture| {
            let place = self.own.place(receptor);
            self.own.frames(posture)[place.limb].point(&place.point)
        });
        let ahead = before.and_then(|before| (grip - before).try_normalize(1e-4)).unwrap_or(into);
        let ball = match contact.by {
            // What is held met it, somewhere ahead.
            Toucher::Through(_) => Capsule::ball(grip + ahead * MET_THROUGH, MET_THROUGH),
            _ => Capsule::ball(point + into * MET, MET),
        };
        if let Some(way) = way {
            self.follow(&way, SWIFT, |_, _| false)?;
        }
        self.clearance.obstacles.push(Obstacle::Capsule(ball));
        Ok(())
    }

    /// Postures, moving some joints, in which a place of the body is at a point and its direction up.
    pub(super) fn upright_at(
        &self,
        place: Place,
        point: Vector3<f64>,
        joints: &[usize],
    ) -> InverseKinematics<'_> {
        self.own.bringing(place, point, self.up, joints).with_direction_lengths(UPRIGHT)
    }

    /// Raises what the limb of a receptor holds by so much, metres, or as much of it as its arm can; how much.
    ///
    /// # Errors
    /// [`Trouble`] where it cannot raise it, or meets something.
    pub(in crate::interaction) fn raise(&mut self, receptor: usize, by: f64) -> Result<f64, Trouble> {
        let way = self.upwards(receptor, by);
        if way.is_empty() {
            return Err(OutOfReach::Barred.into());
        }
        let before = self.feels_at(receptor).0;
        let met =
            self.follow(&PosturePath(way), CAREFUL, |_, contact| matches!(contact.by, Toucher::Own(_)))?;
        if met.is_empty() {
            Ok((self.feels_at(receptor).0 - before).dot(&self.up))
        } else {
            Err(Trouble::Hit(met))
        }
    }

    /// Lowers what the limb of a receptor holds by so much until it is felt to stand; whether it was felt.
    ///
    /// # Errors
    /// Where the engine fails.
    pub(in crate::interaction) fn lower(&mut self, receptor: usize, by: f64) -> Result<bool, Trouble> {
        let way = self.upwards(receptor, -(by + SINKS));
        let met =
            self.follow(&PosturePath(way), CAREFUL, |_, contact| matches!(contact.by, Toucher::Through(_)))?;
        Ok(!met.is_empty())
    }

    /// Postures on a straight way of a receptor's place up, or down, until the arm reaches no farther.
    pub(super) fn upwards(&mut self, receptor: usize, by: f64) -> Vec<Posture> {
        let Some(hand) = self.arm_of(receptor) else { return Vec::new() };
        let arm = self.hands[hand].arm.clone();
        let place = self.own.place(receptor);
        let (here, posture, up) = (self.feels_at(receptor).0, self.posture(), self.up);
        let steps = (by.abs() / STRIDE).ceil().max(1.0) as usize;
        let reaching = self.reaching(arm);
        let PosturePath(mut way) = PosturePath::stepwise(&posture, steps, |k, last| {
            let point = here + up * (by * k as f64 / steps as f64);
            let reach = reaching.solve(place, &ReachTarget { point, direction: Vector3::zeros() }, last);
            reach.reached().then_some(reach.posture)
        });
        way.remove(0);
        way
    }
}
