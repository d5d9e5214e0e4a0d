//! The palm of a hand: the side on which its skin lies about a plane and is hollow, told from the skin alone; and postures in
//! which a limb is where it is to be, place and orientation both: what is carried between two hands must not be turned.

use nalgebra::{Matrix3, Vector3};

use super::own_body::OwnBody;
use crate::creature::Posture;
use crate::geometry::Frame;
use crate::kinematics::Place;

/// Skin faces the palm's way when the cosine between is at least this.
const FACING: f64 = 0.5;
/// Skin this far from the palm's plane counts half, metres: a thumb that stands off is not to tilt it.
const OFF_PLANE: f64 = 0.008;
/// The part of the hand's length, from the wrist, beyond which a palm presses: where the fingers stand out over its hollow.
const FINGERTIPS: f64 = 2.0 / 3.0;
/// Rounds in which the plane is found.
const ROUNDS: usize = 8;
/// Length that a radian of the limb's turn counts as, metres: half a hand's.
const TURN_LENGTH: f64 = 0.08;

/// The palm of a hand with its fingers, which can press on things.
#[derive(Clone, Debug, PartialEq)]
pub struct Palm {
    /// The limb that it is fixed to: the hand.
    pub limb: usize,
    /// `X_LP`: the place that presses in the hand's frame, between the fingertips, x out of the skin, y to the fingertips. No
    /// fingertip is beyond its y–z plane.
    pub frame: Frame,
}

impl Palm {
    /// The palm of a hand, by its limb; `None` if its skin tells none. Limbs that the hand carries are taken to be held as
    /// they are in the rest posture.
    pub fn of(own: &OwnBody, limb: usize) -> Option<Palm> {
        let frames = own.frames(&own.at_ease());
        let into = |other: usize| frames[limb].inverse() * frames[other];
        let skin: Vec<(Vector3<f64>, Vector3<f64>)> = own
            .receptors_on(&own.hand_of(limb))
            .into_iter()
            .map(|receptor| {
                let place = own.place(receptor);
                let frame = into(place.limb);
                (frame.point(&place.point), frame.direction(&place.direction))
            })
            .collect();
        let flat = spread(skin.iter().map(|(point, _)| (*point, 1.0)))?.1;
        let axis: Vector3<f64> = flat.column(2).into_owned();
        let (normal, hollow) = [axis, -axis]
            .into_iter()
            .filter_map(|side| side_of(&skin, side))
            .max_by(|a, b| a.1.total_cmp(&b.1))?;
        if !hollow.is_finite() {
            return None;
        }
        let facing: Vec<_> = skin.iter().filter(|(_, outward)| outward.dot(&normal) > FACING).collect();
        let middle = facing.iter().map(|(point, _)| *point).sum::<Vector3<f64>>() / facing.len() as f64;
        // The fingers point away from the wrist, where the hand's frame begins.
        let along = (middle - normal * middle.dot(&normal)).try_normalize(1e-6)?;
        let length = facing.iter().map(|(point, _)| point.dot(&along)).fold(0.0, f64::max);
        let tips: Vec<Vector3<f64>> = facing
            .iter()
            .filter(|(point, _)| point.dot(&along) >= FINGERTIPS * length)
            .map(|(point, _)| *point)
            .collect();
        let pressing = tips.iter().sum::<Vector3<f64>>() / tips.len().max(1) as f64;
        // A patch's middle is where its skin stands out, but for its bend.
        let face = tips.iter().map(|tip| tip.dot(&normal)).fold(pressing.dot(&normal), f64::max);
        let origin = pressing + normal * (face - pressing.dot(&normal));
        let rotation = Matrix3::from_columns(&[normal, along, normal.cross(&along)]);
        let frame = Frame { origin, rotation };
        Some(Palm { limb, frame })
    }

    /// How far the lowest skin of the hand is below the palm's middle when the palm is turned so, metres; `up` in the same
    /// frame.
    pub fn depth_below(&self, own: &OwnBody, turn: &Matrix3<f64>, up: &Vector3<f64>) -> f64 {
        let at_ease = own.frames(&own.at_ease());
        let hand = Frame { origin: Vector3::zeros(), rotation: *turn } * self.frame.inverse();
        let carried = own.carried_by(self.limb);
        let surfaces = own.skin().surfaces.iter().filter(|surface| carried[surface.limb]);
        let below = surfaces.filter_map(|surface| {
            let frame = hand * (at_ease[self.limb].inverse() * at_ease[surface.limb]);
            let point = surface.support(&frame.rotation.tr_mul(&-up))?;
            Some(-frame.point(&point).dot(up))
        });
        below.fold(0.0, f64::max)
    }

    /// Where a receptor of the hand is in the palm's frame, metres.
    pub fn place_of(&self, own: &OwnBody, receptor: usize) -> Vector3<f64> {
        let at_ease = own.frames(&own.at_ease());
        let place = own.place(receptor);
        let in_hand = (at_ease[self.limb].inverse() * at_ease[place.limb]).point(&place.point);
        self.frame.inverse_point(&in_hand)
    }
}

/// The orientation of a palm that faces one way, its fingers another, as far as they can.
pub fn palm_turn(facing: &Vector3<f64>, fingers: &Vector3<f64>) -> Option<Matrix3<f64>> {
    let along = (fingers - facing * fingers.dot(facing)).try_normalize(1e-6)?;
    Some(Matrix3::from_columns(&[*facing, along, facing.cross(&along)]))
}

/// The mean of weighted points, and the axes of their spread, the greatest first.
fn spread(points: impl Iterator<Item = (Vector3<f64>, f64)> + Clone) -> Option<(Vector3<f64>, Matrix3<f64>)> {
    let weight: f64 = points.clone().map(|(_, weight)| weight).sum();
    if weight <= 0.0 {
        return None;
    }
    let mean = points.clone().map(|(point, weight)| point * weight).sum::<Vector3<f64>>() / weight;
    let squares: Matrix3<f64> =
        points.map(|(point, weight)| (point - mean) * (point - mean).transpose() * weight).sum();
    let eigen = squares.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let axes = order.map(|k| eigen.eigenvectors.column(k).into_owned());
    Some((mean, Matrix3::from_columns(&axes)))
}

/// The normal of the plane that the skin of one side lies about, and how hollow that side is: how far its rim stands out
/// over its middle, metres for each square metre.
fn side_of(skin: &[(Vector3<f64>, Vector3<f64>)], side: Vector3<f64>) -> Option<(Vector3<f64>, f64)> {
    let facing: Vec<Vector3<f64>> =
        skin.iter().filter(|(_, outward)| outward.dot(&side) > FACING).map(|(point, _)| *point).collect();
    if facing.len() < 3 {
        return None;
    }
    let (mut normal, mut weights) = (side, vec![1.0; facing.len()]);
    let mut mean = Vector3::zeros();
    for _ in 0..ROUNDS {
        let weighted = facing.iter().zip(&weights).map(|(point, weight)| (*point, *weight));
        let (middle, axes) = spread(weighted)?;
        let across: Vector3<f64> = axes.column(2).into_owned();
        // No farther from the side that was asked for than a quarter of a turn.
        normal = if across.dot(&side) < 0.0 { -across } else { across };
        mean = middle;
        for (point, weight) in facing.iter().zip(&mut weights) {
            *weight = 1.0 / (1.0 + ((point - mean).dot(&normal) / OFF_PLANE).powi(2));
        }
    }
    let level = facing.iter().map(|point| {
        let offset = point - mean;
        let out = offset.dot(&normal);
        ((offset.norm_squared() - out * out), out)
    });
    let count = facing.len() as f64;
    let (wide, out) = level.clone().fold((0.0, 0.0), |(a, b), (wide, out)| (a + wide, b + out));
    let (wide, out) = (wide / count, out / count);
    let (mut with, mut square) = (0.0, 0.0);
    for (w, o) in level {
        with += (w - wide) * (o - out);
        square += (w - wide) * (w - wide);
    }
    Some((normal, with / square.max(1e-12)))
}

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
/// freedom is left draws it to `ease` where that is given.
pub fn limb_posture(
    own: &OwnBody,
    joints: &[usize],
    goal: &LimbGoal,
    start: &[f64],
    ease: Option<&[f64]>,
    steps: usize,
) -> LimbPosture {
    let free = Vector3::zeros();
    let place = Place { limb: goal.limb, point: goal.place.origin, direction: free };
    let mut solver = own
        .bringing(place, goal.target.origin, free, joints)
        .turned([goal.place.rotation, goal.target.rotation])
        .with_direction_lengths([TURN_LENGTH; 2])
        .with_steps([0, steps]);
    if let Some(ease) = ease {
        solver = solver.at_ease(ease);
    }
    let reach = solver.solve(start);
    LimbPosture { posture: reach.posture, miss: reach.miss, turn: reach.facing.clamp(-1.0, 1.0).acos() }
}
