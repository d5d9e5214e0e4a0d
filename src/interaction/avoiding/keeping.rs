//! Step by step: joint velocities that lead to where limbs are out of the way and a place to where it is to be, and keep
//! limbs clear of each other and of what comes.

use nalgebra::Vector3;

use super::seen_thing::ThingCourse;
use super::{Avoiding, PlaceGoal, QUICK};
use crate::creature::Posture;
use crate::geometry::Frame;
use crate::interaction::actor::Actor;
use crate::peripersonal::{Barrier, CollisionChecker, Nearness, PlaceVelocity, VelocityProgram, distance};
use crate::senses::Approach;

/// What is farther away than this is no matter until the next look, metres.
const NEAR: f64 = 0.06;
/// How far limbs stay from each other and from what is known to be there, and from a thing, metres.
const MARGIN: f64 = 0.01;
/// How fast a gap above the margin may go, per second: between limbs, whose motion is known, and to a thing.
const CLOSING: [f64; 2] = [30.0, 8.0];
/// What it is worth that joints go to where limbs are out of the way, per (rad/s)², and once they are there.
const ESCAPING: [f64; 2] = [1.0, 0.05];
/// A posture this near counts as arrived at, radians.
const ARRIVED: f64 = 0.02;
/// What it is worth that joints that need not move stay, per (rad/s)²: much more than all else but a gap.
const STAYING: f64 = 300.0;
/// What it is worth that a place goes where it is to go, per (m/s)²: a joint that has half a metre to it is worth a
/// twenty-fifth as much on its own.
const PLACE: f64 = 100.0;
/// How fast it makes up for being elsewhere, per second, and at most, metres a second.
const MAKING_UP: [f64; 2] = [10.0, 0.5];

/// What is to be kept clear of until the next look.
pub(super) struct Kept {
    limb: usize,
    /// The nearest point of the limb in its frame.
    point: Vector3<f64>,
    /// The other limb, or none for the root's frame, and the nearest point in that frame at `time`.
    other: Option<usize>,
    other_point: Vector3<f64>,
    /// How the other point moves in that frame, metres a second.
    velocity: Vector3<f64>,
    /// From the other to the limb, in the root's frame.
    normal: Vector3<f64>,
    /// Whether it is a thing that comes, which asks limbs to go.
    comes: bool,
    time: f64,
}

/// What limbs are to be kept clear of: each other, what is known to be there, things that are near, and the way ahead of
/// them where a limb is not in it already; but limbs that `leave` go by their plan there.
pub(super) fn kept(
    actor: &Actor,
    frames: &[Frame],
    seen: &[Approach],
    courses: &[ThingCourse],
    leave: Option<&[bool]>,
    time: f64,
) -> Vec<Kept> {
    let kept = |near: &Nearness| Kept {
        limb: near.limb,
        point: frames[near.limb].inverse_point(&near.gap.points[0]),
        other: near.other,
        other_point: near
            .other
            .map_or(near.gap.points[1], |limb| frames[limb].inverse_point(&near.gap.points[1])),
        velocity: Vector3::zeros(),
        normal: near.gap.normal,
        comes: false,
        time,
    };
    let clearance: &CollisionChecker = &actor.clearance;
    let mut found: Vec<Kept> = clearance.near(frames, NEAR).iter().map(kept).collect();
    for course in courses {
        let ahead = course.swept(0.0, course.ahead(), course.radius);
        let near = clearance.near_to(frames, &ahead, NEAR);
        let outside =
            near.filter(|near| near.gap.distance > 0.0 && !leave.is_some_and(|leave| leave[near.limb]));
        found.extend(outside.map(|near| kept(&near)));
    }
    for approach in seen {
        let frame = &frames[approach.limb];
        let toward = frame.rotation * approach.toward;
        found.push(Kept {
            limb: approach.limb,
            point: approach.point,
            other: None,
            other_point: frame.point(&approach.point) + toward * approach.distance,
            velocity: -toward * approach.speed,
            normal: -toward,
            comes: true,
            time,
        });
    }
    found
}

impl Kept {
    fn barrier(&self, frames: &[Frame], time: f64) -> Barrier {
        let point = frames[self.limb].point(&self.point);
        let at = self.other_point + self.velocity * (time - self.time);
        let other_point = self.other.map_or(at, |limb| frames[limb].point(&at));
        let gap = self.normal.dot(&(point - other_point));
        let rate = self.normal.dot(&self.velocity) - CLOSING[usize::from(self.comes)] * (gap - MARGIN);
        Barrier {
            limb: self.limb,
            other: self.other,
            points: [point, other_point],
            normal: self.normal,
            // What stands still is left where it is, however near.
            rate: if self.comes { rate } else { rate.min(0.0) },
            yields: self.comes,
        }
    }
}

impl Avoiding {
    /// The posture after a step; `None` if it stays as it is.
    pub(super) fn towards(&self, actor: &Actor, now: &[f64], goal: Option<PlaceGoal>) -> Option<Posture> {
        let own = &actor.own;
        let seconds = actor.handle.timestep();
        let far = self.escape.as_ref().map_or(0.0, |escape| distance(now, &escape.posture));
        let idle = far == 0.0 && goal.is_none();
        if idle && self.kept.iter().all(|kept| !kept.comes) {
            return None;
        }
        let frames = own.frames(now);
        let time = actor.handle.time();
        let barriers: Vec<Barrier> = self.kept.iter().map(|kept| kept.barrier(&frames, time)).collect();
        // Who may stay as he is does.
        if idle && barriers.iter().all(|barrier| barrier.rate <= 0.0) {
            return None;
        }
        let joints: Vec<usize> = (0..own.creature().joints().len()).collect();
        let mut program = VelocityProgram::new(own, now, &frames, &joints, QUICK, seconds);
        let doing = goal.map_or(Vec::new(), |goal| match goal.arm(actor) {
            Some(arm) => arm.to_vec(),
            None => own.joints_to(goal.place.limb),
        });
        let getting = self.escape.as_ref().map_or(&self.getting, |escape| &escape.group);
        for &joint in &joints {
            // What holds a place that waited no longer gets away from there.
            let does = doing.contains(&joint);
            let escape = self.escape.as_ref().filter(|escape| escape.keeps_goal || !does);
            let gets = getting.contains(&joint);
            for q in own.creature().joints()[joint].coordinates() {
                match escape.filter(|_| gets) {
                    // All joints arrive together, on the straight way that was found to be clear.
                    Some(escape) => {
                        let takes = (far / QUICK).max(seconds);
                        let weight = ESCAPING[usize::from(far < ARRIVED)];
                        program.want_joint(q, (escape.posture[q] - now[q]) / takes, weight);
                    }
                    None if !gets && !does => program.want_joint(q, 0.0, STAYING),
                    None => {}
                }
            }
        }
        if let Some(PlaceGoal { place, point, velocity }) = goal {
            let here = frames[place.limb].point(&place.point);
            let off = (point - here) * MAKING_UP[0];
            let off = off * (MAKING_UP[1] / off.norm().max(MAKING_UP[1]));
            let wanted =
                PlaceVelocity { limb: place.limb, point: here, velocity: velocity + off, weight: PLACE };
            program.want(&wanted);
        }
        barriers.iter().for_each(|barrier| program.keep(barrier));
        program.solve().map(|stepped| stepped.posture)
    }
}
