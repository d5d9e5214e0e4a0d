//! Where both palms face each other across a thing, and the postures of both arms for it, by the schema.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::Trouble;
use crate::creature::Posture;
use crate::geometry::{Capsule, Frame};
use crate::interaction::actor::{Actor, SWIFT};
use crate::kinematics::Freedoms;
use crate::peripersonal::{
    CollisionChecker, LimbGoal, LimbPosture, Obstacle, OutOfReach, OwnBody, Palm, PosturePath, limb_posture,
    palm_turn,
};

/// How far a palm is from the middle of a thing before it closes, metres: the widest of these that both arms can do.
const OPENINGS: [f64; 3] = [0.13, 0.115, 0.1];
/// How far palms are from the middle when they are taken to be closed, metres: half of what is narrow.
const CLOSED: f64 = 0.02;
/// How high palms come from and go to, metres.
pub const RISE: f64 = 0.12;
/// How high over the table the lowest skin of a hand stays when it goes beside a thing, metres.
const OVER_TABLE: f64 = 0.006;
/// How clear of everything an arm keeps there, metres.
const CLEAR: f64 = 0.003;
/// Ways in which the palms may face each other: how far from straight across, radians, …
const YAWS: [f64; 7] = [0.0, 0.3, -0.3, 0.6, -0.6, 0.9, -0.9];
/// … and how far the fingers point down, radians: steeply first, where the thumbs, which stand out, are not over the thing.
const PITCHES: [f64; 5] = [1.2, 0.9, 0.65, 0.4, 0.15];
/// How far palms are turned up from facing each other, radians: what is round or wider below lies on the fingers, and does not
/// hang between them by friction alone.
const CRADLE: f64 = 0.13;
/// How far from where it is to be a palm may stay, metres, …
const MISS: f64 = 2e-3;
/// … and how far turned, radians.
const TILT: f64 = 0.03;
/// How the trunk helps: the share of the way that it turns to the thing, and how far it bends to the front, radians.
const TRUNKS: [(f64, f64); 6] = [(0.0, 0.0), (1.0, 0.0), (1.0, 0.2), (0.0, 0.2), (1.0, 0.45), (1.0, -0.2)];
/// A joint's axis is along a direction where the cosine between is at least this.
const ALONG: f64 = 0.7;
/// Ways for an arm that are enough for one pitch of the fingers, …
const ENOUGH: usize = 1;
/// … and all in all.
const MOST: usize = 5;
/// The same for palms that are at work and go as far as they can.
const CARRIED_MISS: f64 = 4e-3;
const CARRIED_TILT: f64 = 0.1;
/// Random postures of an arm that are begun with, …
const STARTS: usize = 10;
/// … and how long steps of a way are that is followed from there, metres.
const STRIDE: f64 = 0.02;
/// Radii of the room that is left for the thing on the way, metres: the greatest that leaves a way.
const ROOMS: [f64; 3] = [0.1, 0.07, 0.04];
/// How high that room is over the table, metres.
const ROOM_HEIGHT: f64 = 0.12;

/// How two palms come to face each other across a thing.
#[derive(Clone, Debug)]
pub struct PalmPlan {
    palms: [Palm; 2],
    /// Between the palms, at the height of the table, in the root's frame.
    pub middle: Vector3<f64>,
    /// From the middle to each palm.
    pub outward: [Vector3<f64>; 2],
    /// Horizontally, where the fingers point.
    pub forward: Vector3<f64>,
    turns: [Matrix3<f64>; 2],
    /// How high over the table the palms' middles are when they are down, metres.
    heights: [f64; 2],
    /// How far from the middle each palm is at first, metres.
    pub openings: [f64; 2],
    up: Vector3<f64>,
    /// Both palms raised, apart.
    raised: Posture,
}

impl PalmPlan {
    /// Where a hand is to be, its palm so far from the middle and raised so far, metres.
    pub(super) fn goal(&self, hand: usize, apart: f64, rise: f64) -> LimbGoal {
        let origin = self.middle + self.outward[hand] * apart + self.up * (self.heights[hand] + rise);
        LimbGoal {
            limb: self.palms[hand].limb,
            place: self.palms[hand].frame,
            target: Frame { origin, rotation: self.turns[hand] },
        }
    }

    /// Where a receptor of a hand is from the palm's middle: towards the fingertips along the table, and up, metres.
    pub(super) fn place_of(&self, own: &OwnBody, hand: usize, receptor: usize) -> [f64; 2] {
        let place = self.turns[hand] * self.palms[hand].place_of(own, receptor);
        [place.dot(&self.forward), place.dot(&self.up)]
    }
}

/// Whether a limb is where it is to be.
pub(super) fn arrived(reach: &LimbPosture) -> bool {
    reach.miss <= MISS && reach.turn <= TILT
}

/// What an arm does beside a thing: its palm closed, closed and raised, open, open and raised.
struct ArmStations {
    pitch: f64,
    opening: f64,
    postures: [Posture; 4],
}

impl Actor {
    /// How both palms can come to face each other across a place over the table, and can rise from there; facing each other
    /// in none of the ways that were `tried`, told as how far from straight across, radians. Tells that, too.
    ///
    /// # Errors
    /// [`Trouble::NoSides`] where there are no postures for it, [`Trouble::Nothing`] where no table is known.
    pub(super) fn plan_palms(
        &mut self,
        place: &Vector3<f64>,
        tried: &[f64],
    ) -> Result<(PalmPlan, f64), Trouble> {
        let table = self.table.ok_or(Trouble::Nothing)?;
        let palm = |hand: usize| Palm::of(&self.own, self.hands[hand].limb).ok_or(Trouble::NoSides);
        let palms = [palm(0)?, palm(1)?];
        let (up, left) = (self.up, self.left());
        let middle = place + up * (table - place.dot(&up));
        let azimuth = place.dot(&left).atan2(place.dot(&self.front));
        let mut rng = self.new_rng();
        let ready = self.ready();
        let mut joints = self.hands[0].leaning.clone();
        joints.extend(&self.hands[1].arm);
        let clearance = self.clearance.moved_by(&self.own, &joints);
        for (turning, lean) in TRUNKS {
            let trunk = self.bent_trunk(&ready, turning * azimuth, lean);
            let starts: Vec<Vec<Posture>> = self
                .hands
                .iter()
                .map(|hand| {
                    let drawn = (0..STARTS).map(|_| self.own.random_posture(&trunk, &hand.arm, &mut rng));
                    std::iter::once(trunk.clone()).chain(drawn).collect()
                })
                .collect();
            for yaw in YAWS.into_iter().filter(|yaw| !tried.contains(yaw)) {
                let turn = Rotation3::new(up * (turning * azimuth + yaw));
                let outward = [0, 1].map(|hand| turn * left * self.side(hand));
                let mut plan = PalmPlan {
                    palms: palms.clone(),
                    middle,
                    outward,
                    forward: turn * self.front,
                    turns: [Matrix3::identity(); 2],
                    heights: [0.0; 2],
                    openings: [0.0; 2],
                    up,
                    raised: trunk.clone(),
                };
                let arms = [0, 1].map(|hand| self.arms_for(&mut plan, hand, &starts[hand], &clearance));
                let pairs = arms[0].iter().flat_map(|one| arms[1].iter().map(move |other| [one, other]));
                for pair in pairs {
                    let both =
                        |station: usize| self.with_arms(&trunk, pair.map(|arm| &arm.postures[station]));
                    if (0..4).all(|k| clearance.free(&self.own.frames(&both(k)), CLEAR)) {
                        for (hand, arm) in pair.into_iter().enumerate() {
                            self.turn_palm(&mut plan, hand, arm.pitch);
                            plan.openings[hand] = arm.opening;
                        }
                        plan.raised = both(3);
                        return Ok((plan, yaw));
                    }
                }
            }
        }
        Err(Trouble::NoSides)
    }

    /// Turns a palm of a plan so that its fingers point down by an angle, radians, with its lowest skin just over the table.
    fn turn_palm(&self, plan: &mut PalmPlan, hand: usize, pitch: f64) {
        let fingers = plan.forward * pitch.cos() - plan.up * pitch.sin();
        let facing = plan.up * CRADLE.sin() - plan.outward[hand] * CRADLE.cos();
        if let Some(turn) = palm_turn(&facing, &fingers) {
            plan.turns[hand] = turn;
            plan.heights[hand] = OVER_TABLE + plan.palms[hand].depth_below(&self.own, &turn, &plan.up);
        }
    }

    /// A posture with the trunk turned about the upright and bent to the front, radians, as far as its joints go.
    fn bent_trunk(&self, base: &[f64], turn: f64, lean: f64) -> Posture {
        let freedoms = Freedoms::new(self.own.creature(), &self.own.schema, &self.trunk());
        let motions = freedoms.at(base);
        let mut change = vec![0.0; freedoms.count()];
        for (about, angle) in [(self.up, turn), (self.left(), lean)] {
            let room = |k: usize| {
                let along = motions.axis(k).dot(&about);
                let room = freedoms.bounds(k, base, f64::INFINITY)[usize::from(along * angle > 0.0)];
                (along.abs() > ALONG && room.is_finite()).then_some((k, room))
            };
            let rooms: Vec<(usize, f64)> = (0..freedoms.count()).filter_map(room).collect();
            let all: f64 = rooms.iter().map(|(_, room)| room.abs()).sum();
            let share = if all > 0.0 { (angle.abs() / all).min(1.0) } else { 0.0 };
            rooms.iter().for_each(|(k, room)| change[*k] += share * room);
        }
        freedoms.changed(base, &change)
    }

    /// A posture with each arm as it is in another.
    fn with_arms(&self, base: &[f64], arms: [&Posture; 2]) -> Posture {
        let mut posture = Posture::from(base);
        for (hand, with) in self.hands.iter().zip(arms) {
            posture = Posture::with_joints(self.own.creature(), &posture, hand.arm.iter().copied(), with);
        }
        posture
    }

    /// What an arm can do beside the place of a plan, whatever the other arm does: with its palm closed and open, down and
    /// raised, all clear, on ways without a jump.
    fn arms_for(
        &self,
        plan: &mut PalmPlan,
        hand: usize,
        starts: &[Posture],
        clearance: &CollisionChecker,
    ) -> Vec<ArmStations> {
        let arm = &self.hands[hand].arm;
        let own = &self.own;
        let limbs = self.hands.each_ref().map(|hand| own.hand_of(hand.arm[0] + 1));
        let clearance = clearance.but_between(&limbs[0], &limbs[1]);
        let clear = |posture: &[f64]| clearance.free(&own.frames(posture), CLEAR);
        let mut found = Vec::new();
        for pitch in PITCHES {
            self.turn_palm(plan, hand, pitch);
            let plan = &*plan;
            let follow = |from: &Posture, begin: [f64; 2], end: [f64; 2]| {
                let length = (end[0] - begin[0]).abs() + (end[1] - begin[1]).abs();
                let steps = (length / STRIDE).ceil() as usize;
                let PosturePath(mut way) = PosturePath::stepwise(from, steps, |k, last| {
                    let share = k as f64 / steps as f64;
                    let [apart, rise] = [0, 1].map(|i| begin[i] + share * (end[i] - begin[i]));
                    let reach = limb_posture(own, arm, &plan.goal(hand, apart, rise), last, None, 8);
                    (arrived(&reach) && clear(&reach.posture)).then_some(reach.posture)
                });
                way.pop().filter(|_| way.len() == steps)
            };
            let mut of_pitch = 0;
            for start in starts {
                let goal = plan.goal(hand, CLOSED, 0.0);
                let drawn = limb_posture(own, arm, &goal, start, Some(start), 25);
                let closed = limb_posture(own, arm, &goal, &drawn.posture, None, 15);
                if !arrived(&closed) || !clear(&closed.posture) {
                    continue;
                }
                let closed = closed.posture;
                let Some(risen) = follow(&closed, [CLOSED, 0.0], [CLOSED, RISE]) else {
                    continue;
                };
                let opened = OPENINGS.into_iter().find_map(|opening| {
                    let open = follow(&closed, [CLOSED, 0.0], [opening, 0.0])?;
                    let raised = follow(&open, [opening, 0.0], [opening, RISE])?;
                    Some((opening, open, raised))
                });
                let Some((opening, open, raised)) = opened else {
                    continue;
                };
                found.push(ArmStations { pitch, opening, postures: [closed, risen, open, raised] });
                of_pitch += 1;
                if of_pitch == ENOUGH {
                    break;
                }
            }
            if found.len() >= MOST {
                break;
            }
        }
        found
    }

    /// Takes both hands to where they are raised, apart, over a place, on a way that leaves room for what is there.
    ///
    /// # Errors
    /// [`Trouble`].
    pub(super) fn raise_palms_over(&mut self, plan: &PalmPlan) -> Result<(), Trouble> {
        let mut joints = self.hands[0].leaning.clone();
        joints.extend(&self.hands[1].arm);
        let (from, target) = (self.posture(), &plan.raised);
        for room in ROOMS {
            let ends = [plan.middle, plan.middle + self.up * (ROOM_HEIGHT - room)];
            let thing = Obstacle::Capsule(Capsule { ends, radius: room });
            let way = self.with_obstacles([thing], |actor| actor.find_path([&from, target], &joints));
            if let Ok(way) = way {
                return self.pass(&way, SWIFT);
            }
        }
        Err(OutOfReach::Barred.into())
    }

    /// The posture near another in which both palms are so far from the middle and raised so far; `None` if an arm cannot.
    pub(super) fn palms_at(
        &self,
        plan: &PalmPlan,
        apart: [f64; 2],
        rise: f64,
        near: &[f64],
    ) -> Option<Posture> {
        let mut posture = Posture::from(near);
        for (hand, apart) in apart.into_iter().enumerate() {
            let goal = plan.goal(hand, apart, rise);
            let reach = limb_posture(&self.own, &self.hands[hand].arm, &goal, &posture, None, 8);
            if reach.miss > CARRIED_MISS || reach.turn > CARRIED_TILT {
                return None;
            }
            posture = reach.posture;
        }
        Some(posture)
    }
}
