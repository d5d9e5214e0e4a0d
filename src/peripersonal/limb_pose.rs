//! Postures in which a limb is where it is to be, place and orientation both, by the schema: damped least squares (Wampler
//! 1986, Nakamura and Hanafusa 1986) on six rows, within the joints' ranges.
//!
//! [`InverseKinematics`](crate::kinematics::InverseKinematics) brings places together and leaves the turn about a direction
//! free; what is carried between two hands must not be turned.

use nalgebra::{Matrix6, Rotation3, Vector3, Vector6};

use super::own_body::OwnBody;
use crate::creature::{DofKind, Posture};
use crate::geometry::Frame;
use crate::kinematics::axis_directions;

/// Length that a radian of the limb's turn counts as, metres: half a hand's.
const TURN_LENGTH: f64 = 0.08;
/// Damping, metres per radian.
const DAMPING: f64 = 0.004;
/// The longest step of one coordinate, radians or metres.
const LONGEST_STEP: f64 = 0.3;
/// The share of the way to the posture at ease that is left free and gone in one step.
const EASE: f64 = 0.15;
/// A limb is where it is to be within this, metres.
const EXACT: f64 = 1e-5;

/// A limb that is to be somewhere.
#[derive(Clone, Copy, Debug)]
pub struct LimbGoal {
    /// The limb.
    pub limb: usize,
    /// `X_LP`: a frame that is fixed to it.
    pub place: Frame,
    /// `X_RP`: where that is to be, in the root's frame.
    pub target: Frame,
}

/// A posture that brings a limb somewhere, as far as it can.
#[derive(Clone, Debug, PartialEq)]
pub struct LimbPosture {
    /// The posture, within the joints' ranges.
    pub posture: Posture,
    /// How far the place stays away, metres, …
    pub miss: f64,
    /// … and how far it stays turned, radians.
    pub turn: f64,
}

/// The posture from `start` on, moving some joints, in which a limb is where it is to be, in so many steps at the most; what
/// freedom is left draws it to `ease` where that is given. Balls stay as they are.
pub fn limb_posture(
    own: &OwnBody,
    joints: &[usize],
    goal: &LimbGoal,
    start: &[f64],
    ease: Option<&[f64]>,
    steps: usize,
) -> LimbPosture {
    let creature = own.creature();
    let mut carries = vec![false; creature.joints().len()];
    let mut limb = goal.limb;
    while limb > 0 {
        carries[limb - 1] = true;
        limb = creature.joints()[limb - 1].parent;
    }
    let elements: Vec<_> = creature.elements().filter(|at| !at.is_ball()).collect();
    let mut posture = Posture::from(start);
    let off = |frames: &[Frame]| {
        let now = frames[goal.limb] * goal.place;
        let turn = Rotation3::from_matrix_unchecked(goal.target.rotation * now.rotation.transpose());
        (now.origin, goal.target.origin - now.origin, turn.scaled_axis())
    };
    for _ in 0..steps {
        let frames = own.frames(&posture);
        let (point, miss, turn) = off(&frames);
        if ease.is_none() && miss.norm() < EXACT && turn.norm() * TURN_LENGTH < EXACT {
            break;
        }
        let mut wanted = Vector6::zeros();
        wanted.fixed_rows_mut::<3>(0).copy_from(&miss);
        wanted.fixed_rows_mut::<3>(3).copy_from(&(turn * TURN_LENGTH));
        let axes = axis_directions(creature, &own.schema, &posture, &frames);
        let mut columns = Vec::new();
        for (at, (joint, axis)) in elements.iter().zip(&axes) {
            if !joints.contains(joint) || !carries[*joint] || at.follows.is_some() {
                continue;
            }
            let parent = &frames[creature.joints()[*joint].parent];
            let origin = parent.point(&own.schema.positions[*joint]);
            let (moves, turns) = match at.kind {
                DofKind::Slide => (*axis, Vector3::zeros()),
                _ => (axis.cross(&(point - origin)), axis * TURN_LENGTH),
            };
            let mut column = Vector6::zeros();
            column.fixed_rows_mut::<3>(0).copy_from(&moves);
            column.fixed_rows_mut::<3>(3).copy_from(&turns);
            let drawn = ease.map_or(0.0, |ease| EASE * (ease[at.coordinate()] - posture[at.coordinate()]));
            columns.push((at.coordinate(), at.range, column, drawn));
        }
        let mut held = vec![false; columns.len()];
        let mut change = vec![0.0; columns.len()];
        // A coordinate at its limit that would leave it is held; a few rounds find out all of them.
        for _ in 0..4 {
            let mut normal = Matrix6::identity() * (DAMPING * DAMPING);
            let mut rest = wanted;
            for ((_, _, column, drawn), _) in columns.iter().zip(&held).filter(|(_, held)| !**held) {
                normal.ger(1.0, column, column, 1.0);
                rest -= column * *drawn;
            }
            let Some(factor) = normal.cholesky() else { break };
            let dual = factor.solve(&rest);
            let mut stopped = false;
            for (k, (q, [low, high], column, drawn)) in columns.iter().enumerate() {
                change[k] = if held[k] { 0.0 } else { drawn + column.dot(&dual) };
                let stuck =
                    (posture[*q] <= *low && change[k] < 0.0) || (posture[*q] >= *high && change[k] > 0.0);
                if stuck {
                    (held[k], change[k], stopped) = (true, 0.0, true);
                }
            }
            if !stopped {
                break;
            }
        }
        let longest = change.iter().fold(0.0f64, |most, step| most.max(step.abs()));
        let scale = if longest > LONGEST_STEP { LONGEST_STEP / longest } else { 1.0 };
        for ((q, [low, high], ..), change) in columns.iter().zip(&change) {
            posture[*q] = (posture[*q] + change * scale).clamp(*low, *high);
        }
        creature.couple(&mut posture);
    }
    let (_, miss, turn) = off(&own.frames(&posture));
    LimbPosture { posture, miss: miss.norm(), turn: turn.norm() }
}
