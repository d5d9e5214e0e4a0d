//! The lines of the log of touches: what they hold, and what makes one right.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::UNIT_LENGTH;
use super::stamp::Stamp;
use crate::agent::Agent;
use crate::creature::DofKind;
use crate::plausible::{GREATEST_LENGTH, is_angle, is_deviation, is_length, place_fault};
use crate::senses::RecordedTouch;

pub(super) const STAMP: Stamp = Stamp { format: "bodyschema touches", version: 1 };
/// Times, forces and depths at the most, seconds, newtons and metres: thirty years, and the weight of an oil tanker.
const GREATEST_MOMENT: f64 = 1e9;
/// A contact is at most so many times as far from its receptor as that reaches from its joint …
const FAR: f64 = 10.0;
/// … or as this is, metres.
const LEAST_REACH: f64 = 0.1;
/// The units of a log: of positions and distances, and of angles.
pub(super) const UNITS: &str = "m rad";

/// The header, behind its stamp.
#[derive(Deserialize, Serialize)]
#[serde(expecting = "an object")]
pub(super) struct TouchHeader {
    /// The creature's name.
    pub creature: String,
    /// How many numbers a posture has.
    pub coordinates: usize,
    /// [`UNITS`].
    pub units: String,
}

/// A touch as a line tells it: `S` is a text, `P` a posture, `V` a vector.
///
/// Limbs and positions follow from the receptors; they are told so that a log can be read alone.
#[derive(Deserialize, Serialize)]
#[serde(expecting = "an object")]
pub(super) struct TouchLine<S, P, V> {
    pub bout: u64,
    pub motion: u64,
    pub posture: P,
    /// The ids of the two receptors, the one on the earlier limb first.
    pub receptors: [S; 2],
    /// The names of their limbs.
    pub limbs: [S; 2],
    /// `p_LR` of both: the receptors' centres in their limbs' frames.
    pub positions: [V; 2],
    /// The exact points of contact in the limbs' frames.
    pub contacts: [V; 2],
    /// Standard deviations of the contacts' coordinates, metres, where the recording gives them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deviations: Option<[Option<f64>; 2]>,
    /// Simulated seconds since the bout began, where forces were at work, …
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// … the normal force of the contact, newtons, …
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<f64>,
    /// … and how deep the surfaces were in each other, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth: Option<f64>,
}

/// The name of the limb a receptor is on.
pub(super) fn limb_name(agent: &Agent, receptor: usize) -> Result<&str, String> {
    let receptor = agent
        .skin()
        .receptors
        .get(receptor)
        .ok_or_else(|| format!("receptor {receptor} (from 0) is not in the skin: give one that is"))?;
    let limb = agent.creature().limbs().get(receptor.limb).ok_or_else(|| {
        format!("receptor \"{}\" is on a limb that does not exist: mend the agent.skin()", receptor.id)
    })?;
    Ok(limb)
}

/// Checks that a touch is one of the creature and its skin, and that its numbers are usable.
///
/// # Errors
/// A sentence that names what is wrong and its mend.
pub(super) fn check(touch: &RecordedTouch, agent: &Agent) -> Result<(), String> {
    let creature = agent.creature();
    if touch.posture.len() != creature.coordinates() {
        return Err(format!(
            "its posture has {} numbers but {} has {} coordinates: give as many, or leave the touch out",
            touch.posture.len(),
            creature.name(),
            creature.coordinates()
        ));
    }
    for dof in creature.elements() {
        let coordinates = dof.of(&touch.posture);
        if !coordinates.iter().all(|x| x.is_finite()) {
            return Err(format!(
                "the posture's {} is not a finite number: give one, or leave the touch out",
                dof.name
            ));
        }
        let (possible, unit) = match dof.kind {
            DofKind::Hinge => (coordinates.iter().all(|x| is_angle(*x)), "radians"),
            DofKind::Slide => (coordinates.iter().all(|x| is_length(*x)), "metres"),
            DofKind::Ball => (true, ""),
        };
        // Beyond its range by a whole turn it would be another angle with the turn taken off.
        let [low, high] = dof.range;
        let beyond = (low - coordinates[0]).max(coordinates[0] - high);
        let possible = possible
            && match dof.kind {
                DofKind::Hinge => beyond <= TAU,
                DofKind::Slide => beyond <= 1.0 + 10.0 * (high - low),
                DofKind::Ball => true,
            };
        if !possible {
            return Err(format!(
                "the posture's {} is {}, far beyond its range of {low:.3} to {high:.3}: give {unit}, or leave the touch out",
                dof.name, coordinates[0]
            ));
        }
        let length = coordinates.iter().map(|x| x * x).sum::<f64>().sqrt();
        if dof.kind == DofKind::Ball && (length - 1.0).abs() > UNIT_LENGTH {
            return Err(format!(
                "the posture's quaternion of {} has length {length}: divide it by its length",
                dof.name
            ));
        }
    }
    let limbs = [limb_name(agent, touch.ends[0].receptor)?, limb_name(agent, touch.ends[1].receptor)?];
    let [a, b] = touch.ends.map(|end| &agent.skin().receptors[end.receptor]);
    if a.limb == b.limb {
        return Err(format!(
            "both \"{}\" and \"{}\" are on limb {}, but a touch needs two limbs: leave it out",
            a.id, b.id, limbs[0]
        ));
    }
    let contact = touch.exact_contact();
    for (k, receptor) in [a, b].into_iter().enumerate() {
        let point = contact.points[k];
        if !point.iter().all(|x| x.is_finite()) {
            return Err(format!(
                "the contact at \"{}\" is not three finite numbers: give them, or leave the touch out",
                receptor.id
            ));
        }
        if let Some(fault) = place_fault(&point) {
            return Err(format!("the contact at \"{}\" {fault}, or leave the touch out", receptor.id));
        }
        let reach = receptor.position.norm() + receptor.half_extents.iter().sum::<f64>();
        let away = (point - receptor.position).norm();
        if away > FAR * (reach + LEAST_REACH) {
            return Err(format!(
                "the contact at \"{}\" is {away:.3} m from it: give metres in the limb's frame, or leave the touch out",
                receptor.id
            ));
        }
        if let Some(wrong) = contact.deviations[k].filter(|std| !(is_deviation(*std) && std.is_finite())) {
            return Err(format!(
                "the contact's deviation at \"{}\" is {wrong}: give metres that are not negative, to {GREATEST_LENGTH} at \
                 the most, or null",
                receptor.id
            ));
        }
    }
    if let Some(moment) = touch.moment {
        let depth = contact.depth.unwrap_or(f64::NAN);
        for (what, wrong) in [("time", moment.time), ("force", moment.force), ("depth", depth)] {
            if !(0.0..=GREATEST_MOMENT).contains(&wrong) {
                return Err(format!(
                    "its {what} is {wrong}: give a number from 0 to {GREATEST_MOMENT}, or none of time, force and depth"
                ));
            }
        }
    }
    Ok(())
}
