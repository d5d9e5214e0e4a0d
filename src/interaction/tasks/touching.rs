//! Touching with the other hand what an arm has felt (IVA 2009, section 4).

use std::collections::VecDeque;
use std::f64::consts::TAU;

use nalgebra::{Rotation3, Vector3};

use super::{BACK, MARGIN, Trouble};
use crate::creature::Posture;
use crate::geometry::Capsule;
use crate::interaction::actor::{Actor, CAREFUL, FoundThing, SWIFT};
use crate::kinematics::{Place, REACHED};
use crate::peripersonal::{
    Obstacle, OutOfReach, OwnBody, PosturePath, ReachTarget, Reaching, distance, straight as straight_to,
};
use crate::senses::SkinContact;

/// Radii of the room that a thing is given that was felt, metres, of which not more is known than where it begins: the
/// greatest that leaves a way.
const ROOMS: [f64; 4] = [0.15, 0.1, 0.06, 0.03];

/// How much lower than where it was felt a thing is met that stands on a table, in shares of the height over the table.
const LOWER: f64 = 0.3;
/// What is felt farther than this from where a thing was felt is something else, metres: about as much as a thing is large.
const ELSEWHERE: f64 = 0.2;
/// How often a hand that felt nothing, or something else, corrects itself.
const CORRECTIONS: usize = 1;
/// How often an arm that withdraws may meet a thing on its way.
const WITHDRAWALS: usize = 3;
/// Steps of a straight way off a thing …
const STEPS_OFF: usize = 10;
/// … and others that are tried, one of which may be clear of it.
const WAYS_OFF: usize = 150;

/// How something was touched.
#[derive(Clone, Debug, PartialEq)]
pub struct Touching {
    /// What was felt.
    pub found: FoundThing,
    /// How often it had to correct itself.
    pub corrections: usize,
    /// What was felt before, as the arm that felt it had it in the end.
    pub felt: FoundThing,
}

impl FoundThing {
    /// The room that the thing may fill: a dome on the plane through the place, or a ball that the place is on.
    fn room(&self, radius: f64) -> Obstacle {
        let FoundThing { point, direction, sharp, .. } = *self;
        match sharp {
            true => Obstacle::Dome { centre: point, into: direction, radius },
            false => Obstacle::Capsule(Capsule::ball(point + direction * radius, radius)),
        }
    }
}

impl Actor {
    /// The aims at a thing that was felt at one place: on from where the skin went, then from above and from about it.
    fn aims(&self, felt: &FoundThing) -> Vec<ReachTarget> {
        let FoundThing { point, direction, .. } = *felt;
        let level = (direction - self.up * direction.dot(&self.up)).try_normalize(0.3);
        let mut aims = Vec::new();
        let resting = self.table.is_some_and(|height| (point.dot(&self.up) - height).abs() < 0.12);
        match level {
            // Where the thing begins is known: it is met there.
            _ if felt.sharp => aims.push(ReachTarget { point, direction }),
            // What stands on a table is met level, and lower than the patch that felt it, which may stand out above it.
            Some(level) if resting => {
                let above = point.dot(&self.up) - self.table.unwrap_or_default();
                let point = point - self.up * (LOWER * above.max(0.0));
                aims.push(ReachTarget { point, direction: level });
                aims.push(ReachTarget { point: point + level * 0.015 + self.up * 0.01, direction: -self.up });
            }
            _ => aims.push(ReachTarget { point, direction }),
        }
        let first = aims[0].direction;
        let axis = if level.is_some() { self.up } else { self.left() };
        let mut axes = vec![axis];
        if felt.sharp {
            axes.extend(axis.cross(&first).try_normalize(0.1));
        }
        for angle in [0.5, -0.5, 0.9, -0.9] {
            let turned = axes.iter().map(|axis| Rotation3::new(axis * angle) * first);
            aims.extend(turned.map(|direction| ReachTarget { point, direction }));
        }
        aims
    }

    /// Touches a thing that was felt, with a hand: what felt it goes back first, then the hand comes to where it was.
    /// Where the hand feels nothing, or something else, it corrects itself. `lean` lets the trunk help.
    ///
    /// # Errors
    /// [`Trouble`].
    pub fn touch(&mut self, found: &FoundThing, hand: usize, lean: bool) -> Result<Touching, Trouble> {
        let felt = if self.feels_on { self.feel_on(found)? } else { found.clone() };
        let ready = self.ready();
        match self.withdraw(&felt, &ready) {
            // It touches something where it is: it stays there, a little back, and the other hand finds its way.
            Err(Trouble::Hit(contacts)) => self.back_off(&contacts, BACK)?,
            went => went?,
        }
        self.touch_again(&felt, hand, lean)
    }

    /// The same where what felt the thing is away from it already.
    ///
    /// # Errors
    /// [`Trouble`].
    pub fn touch_again(&mut self, felt: &FoundThing, hand: usize, lean: bool) -> Result<Touching, Trouble> {
        let receptors = self.hands[hand].receptors.clone();
        let (mut corrected, mut trouble) = (0, Trouble::Nothing);
        // With the arm alone first, then with the trunk.
        let helps = if lean { vec![false, true] } else { vec![false] };
        let aims = self.aims(felt);
        let mut goes: VecDeque<(bool, ReachTarget)> =
            helps.into_iter().flat_map(|lean| aims.iter().map(move |aim| (lean, *aim))).collect();
        let mut met: Vec<FoundThing> = Vec::new();
        while let Some((lean, aim)) = goes.pop_front() {
            let joints = self.hands[hand].joints(lean).to_vec();
            let from = self.posture();
            // A sharp place is the thing's, from wherever it is aimed at.
            let mut here = felt.clone();
            if !here.sharp {
                (here.point, here.direction) = (aim.point, aim.direction);
            }
            let places: Vec<FoundThing> = met.iter().cloned().chain([here]).collect();
            let planned = self.making_room(&places, |actor| {
                let mut reaching = actor.reaching(joints.clone());
                if felt.sharp {
                    reaching = reaching.onto(felt.direction);
                }
                Ok(reaching.approach(&from, &receptors, &aim)?)
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
            let touched = self.approach(&plan).map_err(Trouble::from);
            let touched = touched.and_then(|contacts| self.thing_touched(contacts, hand));
            let elsewhere = |at: &FoundThing| (at.point - felt.point).norm() > ELSEWHERE;
            if let Ok(Some(found)) = &touched
                && !elsewhere(found)
            {
                let (found, felt) = (found.clone(), felt.clone());
                return Ok(Touching { found, corrections: corrected, felt });
            }
            if corrected == CORRECTIONS {
                return Err(touched.err().unwrap_or(Trouble::Nothing));
            }
            corrected += 1;
            match touched {
                // Another thing on the way: back, and about it.
                Ok(Some(other)) => {
                    met.push(other.clone());
                    goes.push_front((lean, aim));
                    if let Some(way) = self.back_by(other.receptor, BACK) {
                        self.follow(&way, SWIFT, |_, _| false)?;
                    }
                    trouble = Trouble::Nothing;
                }
                Ok(_) => {
                    if let Ok(Some(found)) = self.search(plan.place, &aim, &joints, hand) {
                        return Ok(Touching { found, corrections: corrected, felt: felt.clone() });
                    }
                    trouble = Trouble::Nothing;
                    let back = plan.straight.0[0].clone();
                    let _ = self.retreat(&back);
                }
                Err(Trouble::Hit(contacts)) => {
                    // Back the way that it came, and another way, about what it met.
                    met.extend(contacts.iter().filter_map(|contact| self.found(contact)));
                    goes.push_front((lean, aim));
                    self.back_off(&contacts, BACK)?;
                    trouble = Trouble::Hit(contacts);
                }
                Err(trouble) => return Err(trouble),
            }
        }
        Err(trouble)
    }

    /// Does something with room left for a thing that was met at some places: as much as leaves a way.
    fn making_room<T>(
        &mut self,
        met: &[FoundThing],
        mut act: impl FnMut(&mut Actor) -> Result<T, Trouble>,
    ) -> Result<T, Trouble> {
        if met.is_empty() {
            return act(self);
        }
        let mut outcome = Err(OutOfReach::Barred.into());
        for radius in ROOMS {
            outcome = self.with_obstacles(met.iter().map(|felt| felt.room(radius)), &mut act);
            if !matches!(outcome, Err(Trouble::Reach(OutOfReach::Barred))) {
                break;
            }
        }
        outcome
    }

    /// The thing that a hand touches, of what stopped its motion; `None` if nothing did.
    ///
    /// # Errors
    /// [`Trouble::Hit`] if something else stopped it.
    fn thing_touched(
        &mut self,
        contacts: Vec<SkinContact>,
        hand: usize,
    ) -> Result<Option<FoundThing>, Trouble> {
        let receptors = &self.hands[hand].receptors;
        let by_hand = contacts
            .iter()
            .find(|contact| receptors.contains(&contact.spot.receptor) && self.is_thing(contact));
        let found = by_hand.and_then(|contact| self.found(contact));
        if found.is_none() && !contacts.is_empty() {
            self.unintended += 1;
            return Err(Trouble::Hit(contacts));
        }
        Ok(found)
    }

    /// Feels about where something was expected, in circles across the way that the hand came.
    fn search(
        &mut self,
        place: Place,
        aim: &ReachTarget,
        joints: &[usize],
        hand: usize,
    ) -> Result<Option<FoundThing>, Trouble> {
        let across = aim.direction.cross(&self.up).try_normalize(1e-3).unwrap_or_else(|| self.left());
        let along = aim.direction.cross(&across);
        let (mut posture, mut way) = (self.posture(), Vec::new());
        let (own, clearance) = (&self.own, &self.clearance.moved_by(&self.own, joints));
        let reaching = Reaching::new(own, clearance, joints.to_vec(), self.seed);
        for (radius, depth) in [(0.015, 0.005), (0.03, 0.005), (0.045, 0.005)] {
            for k in 0..=12 {
                let angle = TAU * f64::from(k) / 12.0;
                let offset = across * (radius * angle.cos()) + along * (radius * angle.sin());
                let point = aim.point + aim.direction * depth + offset;
                let reach = reaching.solve(place, &ReachTarget { point, ..*aim }, &posture);
                let free = clearance.free(&own.frames(&reach.posture), 0.003);
                if reach.miss <= REACHED && free {
                    posture.clone_from(&reach.posture);
                    way.push(reach.posture);
                }
            }
        }
        let contacts = self.follow(&PosturePath(way), CAREFUL, |_, _| true)?;
        self.thing_touched(contacts, hand)
    }

    /// Takes the arm that felt something back to where it was ready, away from the thing.
    pub(in crate::interaction) fn withdraw(
        &mut self,
        found: &FoundThing,
        ready: &[f64],
    ) -> Result<(), Trouble> {
        let Some(hand) = self.arm_of(found.receptor) else { return Ok(()) };
        let arm = self.hands[hand].arm.clone();
        let back = match self.back_by(found.receptor, BACK) {
            Some(way) => {
                let back = way.end().map(Posture::from);
                self.pass(&way, SWIFT)?;
                back.unwrap_or_else(|| self.posture())
            }
            // It has not come here by itself.
            None => {
                let way = self.way_off(found, &arm)?;
                self.pass(&way, SWIFT)?;
                self.posture()
            }
        };
        // Only this arm moves: the other is where it is wanted.
        let target = Posture::with_joints(self.own.creature(), &back, arm.iter().copied(), ready);
        self.go_past(&target, &arm, vec![found.clone()])
    }

    /// Goes to a posture, moving both arms and what carries them, past what it meets on the way.
    ///
    /// # Errors
    /// [`Trouble`] if there is no path or it meets more and more.
    pub(in crate::interaction) fn go_round(&mut self, target: &[f64]) -> Result<(), Trouble> {
        let joints: Vec<usize> = self.hands.iter().flat_map(|hand| hand.leaning.clone()).collect();
        self.go_past(target, &joints, Vec::new())
    }

    /// Goes to a posture by some joints with room left for what was met, and for what it meets on the way.
    fn go_past(&mut self, target: &[f64], joints: &[usize], mut met: Vec<FoundThing>) -> Result<(), Trouble> {
        for _ in 0..WITHDRAWALS {
            let from = self.posture();
            let Err(trouble) = self.making_room(&met, |actor| actor.go_by(&from, target, joints)) else {
                return Ok(());
            };
            let Trouble::Hit(contacts) = trouble else { return Err(trouble) };
            // It is larger than thought: back, and about what it met as well.
            met.extend(contacts.iter().filter_map(|contact| self.found(contact)));
            self.back_off(&contacts, BACK)?;
        }
        Err(OutOfReach::Barred.into())
    }

    /// A way on which an arm takes skin off a thing that it touches, as straight as it can without meeting the thing with
    /// other skin, or the table, or the body.
    fn way_off(&mut self, felt: &FoundThing, arm: &[usize]) -> Result<PosturePath, Trouble> {
        let from = self.posture();
        let place = self.felt_with(felt);
        let frame = self.frames()[place.limb];
        let (here, outward) = (frame.point(&place.point), frame.direction(&place.direction));
        let direction = felt.direction;
        let off = |own: &OwnBody, posture: &[f64]| {
            (here - own.frames(posture)[place.limb].point(&place.point)).dot(&direction)
        };
        // Straight, facing as it does and as it may …
        let mut ways = Vec::new();
        for facing in [outward, Vector3::zeros()] {
            let reaching = self.reaching(arm.to_vec());
            let way = PosturePath::stepwise(&from, STEPS_OFF, |k, last| {
                let point = here - direction * (BACK * k as f64 / STEPS_OFF as f64);
                Some(reaching.solve(place, &ReachTarget { point, direction: facing }, last).posture)
            });
            ways.push(way.0);
        }
        // … and by all joints of the arm at once, as it comes.
        let mut rng = self.new_rng();
        let mut others = Vec::new();
        for _ in 0..WAYS_OFF {
            let target = self.own.random_posture(&from, arm, &mut rng);
            let mut way = vec![from.clone()];
            for k in 1..=50 {
                way.push(Posture::between(self.own.creature(), &from, &target, 0.02 * f64::from(k)));
                if off(&self.own, &way[way.len() - 1]) >= BACK {
                    others.push(way);
                    break;
                }
            }
        }
        let far = |way: &Vec<Posture>| distance(&way[0], &way[way.len() - 1]);
        others.sort_by(|a, b| far(a).total_cmp(&far(b)));
        ways.extend(others);
        let straight = ways[0].clone();
        let found = self.making_room(std::slice::from_ref(felt), |actor| {
            let clearance = actor.clearance.moved_by(&actor.own, arm);
            let clearance = clearance.eased_at(&[actor.own.frames(&from)], MARGIN);
            let clear = |way: &Vec<Posture>| {
                let off = off(&actor.own, &way[way.len() - 1]) > 0.5 * BACK;
                off && way.windows(2).all(|two| straight_to(&actor.own, &clearance, &two[0], &two[1], MARGIN))
            };
            let way = ways.iter().find(|way| clear(way)).cloned();
            Ok(PosturePath(way.ok_or(OutOfReach::Barred)?))
        });
        // With no way that is clear for certain it tries the straight one.
        Ok(found.unwrap_or(PosturePath(straight)))
    }
}
