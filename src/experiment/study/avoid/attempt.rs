//! A creature meets what comes, by what it knows, and what came of it is measured by the truth.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use nalgebra::{Isometry3, Point3, Vector3};

use super::super::at_table::{Knowledge, OnStage};
use super::coming::Coming;
use super::oracle::AT_TASK;
use crate::experiment::ExperimentError;
use crate::interaction::{Actor, Avoiding, PlaceGoal};
use crate::kinematics::Place;
use crate::peripersonal::OwnBody;
use crate::senses::{SkinContact, Toucher};

/// Every how many steps the limbs are measured.
const EVERY: usize = 10;

/// What a hand is to do meanwhile: its tip stays where it is, or goes round an upright circle from there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Task {
    /// Which hand.
    pub hand: usize,
    /// The circle's radius, metres; 0 where the hand stays.
    pub radius: f64,
    /// How long it takes to go round, seconds.
    pub period: f64,
}

/// What came of it.
pub(super) struct Outcome {
    pub touched: Option<usize>,
    /// How far limbs that were not threatened moved, metres: all, and all but those that the threatened ones carry.
    pub moved: [f64; 2],
    /// Whether an arm touched the body.
    pub itself: bool,
    pub plans: usize,
    /// The share of the time in which the hand was where its task has it.
    pub at_task: f64,
}

impl Task {
    /// Where the tip is to be and how fast that moves, so many seconds after it began at a point, in the root's frame.
    pub fn at(
        &self,
        begin: &Vector3<f64>,
        up: &Vector3<f64>,
        front: &Vector3<f64>,
        seconds: f64,
    ) -> [Vector3<f64>; 2] {
        let side = up.cross(front);
        let (sine, cosine) = (TAU * seconds / self.period).sin_cos();
        let speed = self.radius * TAU / self.period;
        let point = begin + (side * sine + up * (1.0 - cosine)) * self.radius;
        [point, (side * cosine + up * sine) * speed]
    }

    /// The place of the body that is to be there.
    pub fn place(&self, actor: &Actor, own: &OwnBody) -> Place {
        own.place(actor.hands[self.hand].tip)
    }
}

/// The arm that a limb is on, its clavicle left out; none for the trunk and the head.
pub(super) fn arm(actor: &Actor, limb: usize) -> Option<usize> {
    actor.hands.iter().position(|hand| actor.own.carried_by(hand.arm[1.min(hand.arm.len() - 1)] + 1)[limb])
}

/// Which arm touches which limb; the trunk touches itself wherever it bends.
fn own_touches(actor: &Actor, felt: &[SkinContact]) -> BTreeSet<[usize; 2]> {
    let pair = |contact: &SkinContact| match contact.by {
        Toucher::Own(other) => Some([contact.spot.limb, other.limb])
            .filter(|pair| pair.iter().any(|&limb| arm(actor, limb).is_some())),
        _ => None,
    };
    felt.iter().filter_map(pair).collect()
}

/// The creature with what it knows meets a thing, doing a task or nothing.
pub(super) fn attempt(
    actor: &mut OnStage,
    known: &Knowledge,
    truth: &Knowledge,
    coming: &Coming,
    task: Option<Task>,
) -> Result<Outcome, ExperimentError> {
    let thing = actor.the_thing()?;
    (actor.own, actor.clearance) = (known.own.clone(), known.clearance.clone());
    let began = actor.stage.time();
    let path = coming.path(began, coming.speed);
    let end = path.end();
    actor.stage.send_thing(thing, path);
    actor.place(&coming.posture)?;
    // What touches already before anything comes is no consequence.
    let felt = actor.step(&coming.posture)?;
    let touching = own_touches(actor, &felt);
    let mut avoiding = Avoiding::new(actor);
    let creature = actor.own.creature().clone();
    let limbs = creature.limbs().len();
    let mut threatened = vec![false; limbs];
    let aimed = creature.aura_limbs()[coming.aimed].limbs.iter();
    aimed.chain(&coming.met).for_each(|&limb| threatened[limb] = true);
    let (mut carried, mut carries) = (vec![false; limbs], vec![false; limbs]);
    for limb in 0..limbs {
        for (other, by) in actor.own.carried_by(limb).into_iter().enumerate() {
            carried[other] |= by && threatened[limb];
            carries[limb] |= by && threatened[other];
        }
    }
    // A part that carries the hands is asked to leave them where they are.
    let trunk = actor.hands.iter().all(|hand| carried[hand.limb]);
    // What does a task moves.
    let busy = task.map(|task| actor.own.carried_by(actor.hands[task.hand].arm[0] + 1));
    let other =
        |limb: usize| !threatened[limb] && !carries[limb] && !busy.as_ref().is_some_and(|busy| busy[limb]);
    let skin = |actor: &OnStage| -> Vec<Vector3<f64>> {
        let poses: Vec<Isometry3<f64>> = (0..limbs).map(|limb| actor.stage.limb_pose(limb)).collect();
        let receptors = actor.stage.skin().receptors.iter();
        receptors.map(|r| (poses[r.limb] * Point3::from(r.position)).coords).collect()
    };
    let before = skin(actor);
    // The task is told in the frame of the root, from where the hand takes itself to be, and measured from where it is.
    let places = task.map(|task| {
        [&known.own, &truth.own].map(|own| {
            let place = task.place(actor, own);
            (place, own.frames(&coming.posture)[place.limb].point(&place.point))
        })
    });
    let (up, front) = (actor.up, actor.front);
    let mut outcome = Outcome { touched: None, moved: [0.0; 2], itself: false, plans: 0, at_task: f64::NAN };
    let (mut steps, mut near, mut looked) = (0, 0, 0);
    while actor.stage.time() < end {
        if let (Some(task), Some([(place, begin), _])) = (task, places) {
            let seconds = actor.stage.time() - began + actor.stage.timestep();
            let [point, velocity] = task.at(&begin, &up, &front, seconds);
            avoiding.goal = Some(PlaceGoal { place, point, velocity });
        }
        let felt = avoiding.step(actor)?;
        outcome.itself |= own_touches(actor, &felt).iter().any(|pair| !touching.contains(pair));
        if outcome.touched.is_none() {
            let by = felt.iter().find(|contact| contact.by == Toucher::Thing(thing));
            outcome.touched = by.map(|contact| actor.own.skin().receptors[contact.spot.receptor].limb);
        }
        if steps % EVERY == 0 {
            for ((r, now), then) in actor.own.skin().receptors.iter().zip(skin(actor)).zip(&before) {
                let moved = (now - then).norm();
                if other(r.limb) && (trunk || !carried[r.limb]) {
                    outcome.moved[0] = outcome.moved[0].max(moved);
                }
                if other(r.limb) && !carried[r.limb] {
                    outcome.moved[1] = outcome.moved[1].max(moved);
                }
            }
            if let (Some(task), Some([_, (place, begin)])) = (task, places) {
                let [point, _] = task.at(&begin, &up, &front, actor.stage.time() - began);
                let here = actor.stage.limb_pose(place.limb) * Point3::from(place.point);
                let there = actor.stage.root_pose() * Point3::from(point);
                looked += 1;
                near += usize::from((here - there).norm() <= AT_TASK);
            }
        }
        steps += 1;
    }
    outcome.plans = avoiding.plans;
    outcome.at_task = near as f64 / looked as f64;
    Ok(outcome)
}
