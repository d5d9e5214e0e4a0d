//! What a creature does about it: explores a table blind, touches what it felt with the other hand, holds it, puts it
//! far away or near (IVA 2009, section 4).

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::actor::{Actor, CAREFUL, Found, Hand, SWIFT, Stop};
use super::scene::{Feeling, Touched};
use crate::babbling::between;
use crate::creature::DofKind;
use crate::kinematics::{Facing, InverseKinematics, Place, REACHED};
use crate::mujoco;
use crate::peripersonal::{Aim, Obstacle, OutOfReach, Reaching, Way, find_way, straight};

/// How high over the table the tip of a sweeping hand goes, metres: things lower than this are not found.
const SWEEP_HEIGHT: f64 = 0.03;
/// How far apart the lanes of a sweep are, metres.
const LANE: f64 = 0.06;
/// Steps along a lane, metres.
const STRIDE: f64 = 0.02;
/// How clear ways keep of everything, metres.
const MARGIN: f64 = 0.006;
/// Radii of the room that a thing is given that was felt, metres, of which not more is known than where it begins: the
/// greatest that leaves a way.
const ROOMS: [f64; 4] = [0.15, 0.1, 0.06, 0.03];
/// Steps to the side in which the farthest spot is looked for, how many to either side, and how finely forward, metres.
const ASIDE: f64 = 0.05;
const LATERAL: u32 = 11;
const FINEST: f64 = 1e-3;
/// How far skin goes back from what it touched before anything else, metres.
const BACK: f64 = 0.05;
/// How clear of everything a hand waits, metres …
const WAITING: f64 = 0.006;
/// … and how high, the first of these that leaves it clear: in lengths of the arm above the joint that carries it.
const READY_HEIGHTS: [f64; 4] = [-0.35, -0.25, -0.15, 0.0];
/// How high a thing is lifted, metres: the highest of these that its way allows.
const LIFTS: [f64; 3] = [0.12, 0.08, 0.05];
/// How far a hand is raised off what it let go, metres.
const LIFT: f64 = 0.05;
/// Least size of a thing's height, metres: the table is not felt through what is lower.
const SETTLE: f64 = 0.002;

/// Why something could not be done.
#[derive(Debug)]
pub enum Trouble {
    /// A place cannot be touched.
    Reach(OutOfReach),
    /// Nothing was felt where something was expected.
    Nothing,
    /// Something else was in the way.
    Hit(Vec<Feeling>),
    /// The engine failed.
    Engine(mujoco::Error),
}

impl From<mujoco::Error> for Trouble {
    fn from(error: mujoco::Error) -> Trouble {
        Trouble::Engine(error)
    }
}

impl From<OutOfReach> for Trouble {
    fn from(reason: OutOfReach) -> Trouble {
        Trouble::Reach(reason)
    }
}

impl std::fmt::Display for Trouble {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Trouble::Reach(reason) => reason.fmt(f),
            Trouble::Nothing => write!(f, "I felt nothing where I expected something"),
            Trouble::Hit(_) => write!(f, "I ran into something on the way"),
            Trouble::Engine(error) => error.fmt(f),
        }
    }
}

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

/// A place on the table, or above it, where something can be put.
#[derive(Clone, Debug, PartialEq)]
pub struct Spot {
    /// Where the grip comes to be, in the root's frame, metres.
    pub point: Vector3<f64>,
    /// The posture.
    pub posture: Vec<f64>,
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

    /// The posture in which both hands wait in front of the trunk, clear of a table where one is known.
    pub fn ready(&mut self) -> Vec<f64> {
        let mut posture = self.own.at_ease();
        let frames = self.own.frames(&posture);
        for hand in 0..2 {
            let Hand { arm, tip, limb, .. } = &self.hands[hand].clone();
            let root = frames[arm[0] + 1].origin;
            let length = (frames[*limb].origin - root).norm();
            // What is near each other at ease is so for good.
            let clearance =
                self.clearance.moved_by(&self.own, arm).eased_at(std::slice::from_ref(&frames), WAITING);
            let mut bent = posture.clone();
            // Bent joints make for an arm that does not reach down.
            for &joint in arm.iter().skip(1) {
                let joint = &self.own.creature.joints()[joint];
                for (k, dof) in joint.dofs.iter().enumerate().filter(|(_, dof)| dof.kind != DofKind::Ball) {
                    bent[joint.first_coordinate() + k] = 0.5 * (dof.range[0] + dof.range[1]);
                }
            }
            let at = |height: f64| {
                let point = self.front * (root.dot(&self.front) + 0.55 * length)
                    + self.left() * (root.dot(&self.left()) + self.side(hand) * 0.35 * length)
                    + self.up * (root.dot(&self.up) + height * length);
                let target = Place { limb: 0, point, direction: Vector3::zeros() };
                let ends = [Place { direction: Vector3::zeros(), ..self.own.place(*tip) }, target];
                let solver = InverseKinematics::new(&self.own.creature, &self.own.schema, ends);
                let mut solver = solver.moving(|joint| arm.contains(&joint)).at_ease(&posture);
                [&bent, &posture].map(|start| solver.solve(start))
            };
            let waits = |posture: &[f64]| clearance.free(&self.own.frames(posture), WAITING);
            let found =
                READY_HEIGHTS.into_iter().flat_map(at).find(|reach| reach.reached() && waits(&reach.posture));
            if let Some(reach) = found {
                posture = reach.posture;
            }
        }
        posture
    }

    /// Goes to a posture, moving both arms and what carries them, on a way that keeps clear.
    ///
    /// # Errors
    /// [`Trouble`] where there is no way or something is felt on it.
    pub fn go(&mut self, target: &[f64]) -> Result<(), Trouble> {
        let from = self.posture();
        let joints: Vec<usize> = self.hands.iter().flat_map(|hand| hand.leaning.clone()).collect();
        self.go_by(&from, target, &joints)
    }

    fn go_by(&mut self, from: &[f64], target: &[f64], joints: &[usize]) -> Result<(), Trouble> {
        self.seed = self.seed.wrapping_add(1);
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let way = find_way(&self.own, &self.clearance, [from, target], joints, MARGIN, &mut rng);
        self.pass(&way.ok_or(OutOfReach::Barred)?, SWIFT)
    }

    /// Follows a way on which nothing is expected.
    pub(super) fn pass(&mut self, way: &Way, speed: f64) -> Result<(), Trouble> {
        match self.follow(way, speed, |_, _| true)? {
            Stop::Arrived => Ok(()),
            Stop::Felt(feelings) => {
                self.unintended += 1;
                Err(Trouble::Hit(feelings))
            }
        }
    }

    /// Lowers a hand in front of it until it feels something, and takes that for the table.
    ///
    /// # Errors
    /// [`Trouble`]; [`Trouble::Nothing`] where there is no table.
    pub fn feel_table(&mut self, hand: usize) -> Result<f64, Trouble> {
        let Hand { arm, tip, .. } = self.hands[hand].clone();
        let place = self.own.place(tip);
        let start = self.posture();
        let (point, _) = self.feels_at(tip);
        let (mut posture, mut way) = (start.clone(), Vec::new());
        let up = self.up;
        let reaching = self.reaching(arm);
        for k in 1..200 {
            let aim = Aim { point: point - up * (0.005 * f64::from(k)), direction: Vector3::zeros() };
            let reach = reaching.solve(Place { direction: Vector3::zeros(), ..place }, &aim, &posture);
            if reach.miss > REACHED {
                break;
            }
            posture.clone_from(&reach.posture);
            way.push(reach.posture);
        }
        let stop = self.follow(&Way(way.clone()), CAREFUL, |_, _| true)?;
        let Stop::Felt(feelings) = stop else { return Err(Trouble::Nothing) };
        if feelings.iter().any(|feeling| matches!(feeling.what, Touched::Own(_))) {
            // Its own leg is no table.
            let _ = self.retreat(&start);
            return Err(Trouble::Nothing);
        }
        let heights = feelings.iter().map(|feeling| {
            let place = self.own.place(feeling.receptor);
            // The lowest point of the surface that felt it.
            let surface = self.own.skin.receptors[feeling.receptor].surface;
            let frame = self.frames()[place.limb];
            let lowest = surface
                .and_then(|s| self.own.skin.surfaces[s].support(&frame.rotation.tr_mul(&-self.up)))
                .unwrap_or(place.point);
            frame.point(&lowest).dot(&self.up)
        });
        let height = heights.fold(f64::INFINITY, f64::min);
        self.know_table(height);
        self.retreat(&start)?;
        Ok(height)
    }

    /// Goes back straight to a posture that it has just come from.
    fn retreat(&mut self, to: &[f64]) -> Result<(), Trouble> {
        self.pass(&Way(vec![to.to_vec()]), SWIFT)
    }

    /// The lanes of a sweep over the table with a hand: postures, lane by lane, nearest first.
    fn lanes(&mut self, hand: usize) -> Vec<Way> {
        let Some(height) = self.table else { return Vec::new() };
        let Hand { arm, tip, .. } = self.hands[hand].clone();
        let (front, left, up, side) = (self.front, self.left(), self.up, self.side(hand));
        let edge = self.trunk_front(height);
        let place = Place { direction: Vector3::zeros(), ..self.own.place(tip) };
        let mut posture = self.ready();
        let mut lanes = Vec::new();
        let own = &self.own;
        let clearance = &self.clearance.moved_by(own, &arm);
        let reaching = Reaching::new(own, clearance, arm, 0);
        for lane in 0..12 {
            let forward = edge + 0.08 + LANE * f64::from(lane);
            let mut found: Vec<Vec<f64>> = Vec::new();
            let mut longest: Vec<Vec<f64>> = Vec::new();
            for k in 0..44 {
                // From its own side inwards, and back on the next lane.
                let share = if lane % 2 == 0 { 43 - k } else { k };
                let across = side * (-0.2 + STRIDE * f64::from(share));
                let point = front * forward + left * across + up * (height + SWEEP_HEIGHT);
                let reach = reaching.solve(place, &Aim { point, direction: Vector3::zeros() }, &posture);
                let free = reach.miss <= REACHED && clearance.free(&own.frames(&reach.posture), MARGIN);
                let near = found
                    .last()
                    .is_none_or(|before| straight(own, clearance, before, &reach.posture, 0.5 * MARGIN));
                if free && near {
                    posture.clone_from(&reach.posture);
                    found.push(reach.posture);
                } else if found.len() > longest.len() {
                    longest = std::mem::take(&mut found);
                } else {
                    found.clear();
                }
            }
            if found.len() > longest.len() {
                longest = found;
            }
            if longest.len() > 3 {
                lanes.push(Way(longest));
            }
        }
        lanes
    }

    /// Sweeps the table with a hand until something is felt, by whatever part of the arm. None where all that it reaches
    /// is empty. The table must be known.
    ///
    /// # Errors
    /// [`Trouble`].
    pub fn explore(&mut self, hand: usize) -> Result<Option<Found>, Trouble> {
        let lanes = self.lanes(hand);
        let arm = self.hands[hand].arm.clone();
        for lane in lanes {
            let from = self.posture();
            let first = lane.0.first().expect("lanes are not empty").clone();
            self.seed = self.seed.wrapping_add(1);
            let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
            let way = find_way(&self.own, &self.clearance, [&from, &first], &arm, MARGIN, &mut rng);
            let Some(way) = way else { continue };
            for (way, speed) in [(&way, CAREFUL * 2.0), (&lane, CAREFUL * 2.0)] {
                let stop = self.follow(way, speed, |actor, feeling| !actor.is_table(feeling))?;
                if let Stop::Felt(feelings) = stop
                    && let Some(found) = feelings.iter().find_map(|feeling| self.found(feeling))
                {
                    return Ok(Some(found));
                }
            }
        }
        Ok(None)
    }

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
            let turn = nalgebra::Rotation3::new(axis * angle);
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
            Err(Trouble::Hit(feelings)) => {
                if let Some(way) = feelings.first().and_then(|f| self.back_by(f.receptor, BACK)) {
                    self.follow(&way, SWIFT, |_, _| false)?;
                }
            }
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
        let Hand { arm, leaning, receptors, .. } = self.hands[hand].clone();
        let joints = if lean { leaning } else { arm };
        let mut aims = self.aims(found);
        let (mut corrected, mut trouble) = (0, Trouble::Nothing);
        while let Some(aim) = (!aims.is_empty()).then(|| aims.remove(0)) {
            let from = self.posture();
            let mut planned = Err(OutOfReach::Barred);
            for room in ROOMS {
                self.clearance.obstacles.push(room_of(&aim, room));
                planned = self.reaching(joints.clone()).approach(&from, &receptors, &aim);
                self.clearance.obstacles.pop();
                if planned != Err(OutOfReach::Barred) {
                    break;
                }
            }
            let plan = match planned {
                Ok(plan) => plan,
                Err(reason @ OutOfReach::Unknown(_)) => return Err(reason.into()),
                // What is nearest to being reached says most.
                Err(reason) => {
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
            };
            match self.try_touch(&plan.way, &plan.straight, hand) {
                Ok(Some(found)) => {
                    return Ok(Touching { found, receptor: plan.receptor, corrections: corrected });
                }
                Ok(None) if corrected < corrections => {
                    if let Ok(Some(found)) = self.search(plan.receptor, &aim, &joints, hand) {
                        return Ok(Touching { found, receptor: plan.receptor, corrections: corrected + 1 });
                    }
                    corrected += 1;
                    trouble = Trouble::Nothing;
                    let back = plan.straight.0[0].clone();
                    let _ = self.retreat(&back);
                }
                Err(Trouble::Hit(feelings)) if corrected < corrections => {
                    // Back the way that it came, and another way.
                    corrected += 1;
                    if let Some(way) = feelings.first().and_then(|f| self.back_by(f.receptor, BACK)) {
                        self.follow(&way, SWIFT, |_, _| false)?;
                    }
                    trouble = Trouble::Hit(feelings);
                }
                Ok(None) => return Err(Trouble::Nothing),
                Err(trouble) => return Err(trouble),
            }
        }
        Err(trouble)
    }

    /// Goes along a way and then straight on; what the hand feels there, or none where it feels nothing.
    ///
    /// # Errors
    /// [`Trouble::Hit`] where something else is felt before.
    fn try_touch(&mut self, way: &Way, straight: &Way, hand: usize) -> Result<Option<Found>, Trouble> {
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
        let clearance = self.clearance.clone();
        let own = self.own.clone();
        let reaching = Reaching::new(&own, &clearance, joints.to_vec(), self.seed);
        for (radius, depth) in [(0.015, 0.005), (0.03, 0.005), (0.045, 0.005)] {
            for k in 0..=12 {
                let angle = std::f64::consts::TAU * f64::from(k) / 12.0;
                let offset = across * (radius * angle.cos()) + along * (radius * angle.sin());
                let point = aim.point + aim.direction * depth + offset;
                let reach = reaching.solve(place, &Aim { point, ..*aim }, &posture);
                let above = clearance.obstacles.iter().all(|obstacle| {
                    let frames = own.frames(&reach.posture);
                    (1..own.creature.limbs().len())
                        .all(|limb| clearance.to_obstacle(&frames, limb, obstacle, 0.003) >= 0.003)
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
        self.try_touch(&Way(Vec::new()), &Way(way), hand)
    }

    /// Takes the arm that felt something back to where it was ready, away from the thing.
    pub(super) fn withdraw(&mut self, found: &Found, ready: &[f64]) -> Result<(), Trouble> {
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
            let joint = &self.own.creature.joints()[joint];
            let count: usize = joint.dofs.iter().map(|dof| dof.kind.coordinates()).sum();
            let q = joint.first_coordinate()..joint.first_coordinate() + count;
            target[q.clone()].copy_from_slice(&ready[q]);
        }
        let aim = Aim { point: found.point, direction: found.direction };
        let mut went = Err(OutOfReach::Barred.into());
        for room in ROOMS {
            self.clearance.obstacles.push(room_of(&aim, room));
            went = self.go_by(&back, &target, &arm);
            self.clearance.obstacles.pop();
            if !matches!(went, Err(Trouble::Reach(OutOfReach::Barred))) {
                break;
            }
        }
        went
    }

    /// The spot farthest in front at which the receptor that grips can be over the table at a height, the grip upright
    /// as it is now: `upright` is the direction of the limb that is up now, in the limb's frame.
    pub fn farthest(
        &mut self,
        receptor: usize,
        height: f64,
        upright: Vector3<f64>,
        lean: bool,
        effort: usize,
    ) -> Option<Spot> {
        let hand = self.arm_of(receptor)?;
        let joints = if lean { self.hands[hand].leaning.clone() } else { self.hands[hand].arm.clone() };
        let place = Place { direction: upright, ..self.own.place(receptor) };
        let (front, left, up, side) = (self.front, self.left(), self.up, self.side(hand));
        let from = self.posture();
        let own = &self.own;
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let mut starts = vec![from.clone(), own.at_ease()];
        if lean {
            // Bent as far to the front as the trunk goes, joint by joint from the hips.
            let mut bent = from.clone();
            for &joint in joints.iter().filter(|joint| !self.hands[hand].arm.contains(joint)) {
                let joint = &own.creature.joints()[joint];
                for (k, dof) in joint.dofs.iter().enumerate().filter(|(_, dof)| dof.kind != DofKind::Ball) {
                    let q = joint.first_coordinate() + k;
                    let forward = |value: f64| {
                        let mut posture = bent.clone();
                        posture[q] = value;
                        own.frames(&posture)[place.limb].point(&place.point).dot(&front)
                    };
                    bent[q] = dof
                        .range
                        .into_iter()
                        .max_by(|a, b| forward(*a).total_cmp(&forward(*b)))
                        .unwrap_or(bent[q]);
                }
            }
            own.creature.couple(&mut bent);
            starts.insert(0, between(&own.creature, &from, &bent, 0.7));
            starts.insert(0, bent);
        }
        starts.resize_with(starts.len() + effort, || own.random_posture(&from, &joints, &mut rng));
        let solve = |forward: f64, across: f64, start: &[f64]| {
            let point = front * forward + left * across + up * height;
            let ends = [place, Place { limb: 0, point, direction: up }];
            let reach = InverseKinematics::new(&own.creature, &own.schema, ends)
                .with_facing(Facing::Parallel)
                .with_direction_lengths([0.05, 0.02])
                .with_steps([20, 25])
                .moving(|joint| joints.contains(&joint))
                .solve(start);
            let fits = reach.miss <= REACHED
                && reach.facing > 0.99
                && self.clearance.free(&own.frames(&reach.posture), 0.002);
            fits.then_some(reach.posture)
        };
        // From where it is, sideways in steps, and from each forward as far as there is a posture.
        let here = self.feels_at(receptor).0;
        let (near, middle) = (here.dot(&front), here.dot(&left));
        let anew = |forward: f64, across: f64| starts.iter().find_map(|start| solve(forward, across, start));
        let mut best: Option<(f64, Spot)> = None;
        for sideways in [side, -side] {
            let mut beside = from.clone();
            for k in 0..LATERAL {
                let across = middle + sideways * ASIDE * f64::from(k);
                let Some(begin) = solve(near, across, &beside).or_else(|| anew(near, across)) else { break };
                beside.clone_from(&begin);
                let (mut forward, mut posture, mut step) = (near, begin, 2.0 * ASIDE);
                while step > FINEST {
                    let further = forward + step;
                    let reached = solve(further, across, &posture).or_else(|| {
                        let farthest =
                            best.as_ref().and_then(|(_, spot)| solve(further, across, &spot.posture));
                        farthest.or_else(|| anew(further, across))
                    });
                    match reached {
                        Some(reached) => (forward, posture) = (further, reached),
                        None => step *= 0.5,
                    }
                }
                if best.as_ref().is_none_or(|(before, _)| forward > *before) {
                    let point = front * forward + left * across + up * height;
                    best = Some((forward, Spot { point, posture }));
                }
            }
        }
        best.map(|(_, spot)| spot)
    }

    /// The spot at a place over the table, forward and to the hand's own side, at which the receptor that grips is upright
    /// as it is now; none where it cannot be there.
    pub fn spot_at(
        &mut self,
        receptor: usize,
        forward: f64,
        across: f64,
        height: f64,
        upright: Vector3<f64>,
    ) -> Option<Spot> {
        let hand = self.arm_of(receptor)?;
        let joints = self.hands[hand].arm.clone();
        let side = self.left() * self.side(hand);
        let place = Place { direction: upright, ..self.own.place(receptor) };
        let from = self.posture();
        let clearance = self.clearance.moved_by(&self.own, &joints);
        // A little farther away is near as well.
        (0..8).find_map(|k| {
            let point = self.front * (forward + 0.03 * f64::from(k)) + side * across + self.up * height;
            let ends = [place, Place { limb: 0, point, direction: self.up }];
            let reach = InverseKinematics::new(&self.own.creature, &self.own.schema, ends)
                .with_facing(Facing::Parallel)
                .with_direction_lengths([0.05, 0.02])
                .moving(|joint| joints.contains(&joint))
                .solve(&from);
            let fits = reach.miss <= REACHED
                && reach.facing > 0.98
                && clearance.free(&self.own.frames(&reach.posture), 0.002);
            fits.then_some(Spot { point, posture: reach.posture })
        })
    }

    /// How far a point of the root's frame is from the surface of every limb that has one, metres.
    pub fn distances(&self, point: &Vector3<f64>) -> Vec<(usize, f64)> {
        let distances = self.own.distances(&self.frames(), point);
        distances.into_iter().enumerate().filter_map(|(limb, distance)| Some((limb, distance?))).collect()
    }

    /// Carries what a receptor holds to a spot: up, over, and down until it is felt to stand; then lets go and comes
    /// back.
    ///
    /// # Errors
    /// [`Trouble`].
    pub fn put(&mut self, receptor: usize, spot: &Spot, lean: bool) -> Result<(), Trouble> {
        let Some(hand) = self.arm_of(receptor) else { return Err(Trouble::Nothing) };
        let joints = if lean { self.hands[hand].leaning.clone() } else { self.hands[hand].arm.clone() };
        let up = self.up;
        let limb = self.own.place(receptor).limb;
        let upright = self.frames()[limb].rotation.tr_mul(&up);
        let place = Place { direction: upright, ..self.own.place(receptor) };
        let lifted = |actor: &Actor, point: Vector3<f64>, start: &[f64]| {
            let ends = [place, Place { limb: 0, point, direction: up }];
            InverseKinematics::new(&actor.own.creature, &actor.own.schema, ends)
                .with_facing(Facing::Parallel)
                .with_direction_lengths([0.05, 0.02])
                .moving(|joint| joints.contains(&joint))
                .solve(start)
                .posture
        };
        let from = self.posture();
        let here = self.feels_at(receptor).0;
        let high = |actor: &Actor, point: Vector3<f64>, lift: f64, start: &[f64]| {
            let posture = lifted(actor, point + up * lift, start);
            let frame = actor.own.frames(&posture)[limb];
            ((frame.point(&place.point) - point).dot(&up) > 0.8 * lift).then_some(posture)
        };
        let raise = |actor: &Actor, point, start: &[f64]| {
            LIFTS.into_iter().find_map(|lift| Some((lift, high(actor, point, lift, start)?)))
        };
        let (Some((_, raised)), Some((lift, above))) =
            (raise(self, here, &from), raise(self, spot.point, &spot.posture))
        else {
            return Err(OutOfReach::Barred.into());
        };
        // What is held may scrape over what it stands on: that is no surprise.
        let expected = |_: &Actor, feeling: &Feeling| !matches!(feeling.what, Touched::Through(_));
        self.follow(&Way(vec![raised.clone()]), CAREFUL, expected)?;
        self.seed = self.seed.wrapping_add(1);
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let way = find_way(&self.own, &self.clearance, [&raised, &above], &joints, MARGIN, &mut rng);
        self.pass(&way.ok_or(OutOfReach::Barred)?, SWIFT)?;
        let mut down = Vec::new();
        let mut posture = above.clone();
        for k in 1..=12 {
            let share = f64::from(k) / 12.0;
            let point = spot.point + up * (lift * (1.0 - share));
            posture = if k == 12 { spot.posture.clone() } else { lifted(self, point, &posture) };
            down.push(posture.clone());
        }
        let sinking = lifted(self, spot.point - up * SETTLE, &posture);
        down.push(sinking);
        self.follow(&Way(down.clone()), CAREFUL, |_, feeling| matches!(feeling.what, Touched::Through(_)))?;
        self.scene.let_go();
        let stay = self.posture();
        self.wait(0.2)?;
        let point = self.feels_at(receptor).0;
        let back = lifted(self, point + up * LIFT, &stay);
        self.follow(&Way(vec![back]), CAREFUL, |_, _| false)?;
        Ok(())
    }
}

/// The room of a thing that begins at a place: a ball that the place is on.
fn room_of(aim: &Aim, radius: f64) -> Obstacle {
    let middle = aim.point + aim.direction * radius;
    Obstacle::Capsule { ends: [middle; 2], radius }
}
