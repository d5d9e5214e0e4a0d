//! Postures in which two places of the skin meet, by the schema that is believed.
//!
//! Damped least squares (Wampler 1986, Nakamura and Hanafusa 1986) on the coordinates of the chain between
//! the two limbs: the two points are to coincide, and weakly the two normals to be opposed. Coordinates
//! stay within their ranges; one that is at its limit and would leave it is held for that step.

use nalgebra::{DMatrix, Matrix3, Matrix6, UnitQuaternion, Vector3, Vector6};

use super::super::posture::ball;
use crate::creature::{Creature, DofKind};
use crate::kinematics::{Chain, rotation};
use crate::schema::BodySchema;
use crate::skin::Skin;

/// How far apart the two points may stay in a posture that counts as found, metres.
pub const REACHED: f64 = 2e-3;
/// Length that a normal which is not opposed counts as, metres: at first …
const NORMAL_WEIGHT: f64 = 0.03;
/// … and at the end, when only the points matter.
const LAST_NORMAL_WEIGHT: f64 = 5e-4;
/// Steps with either weight.
const STEPS: [usize; 2] = [15, 15];
/// Damping, metres per radian.
const DAMPING: f64 = 0.01;
/// The longest step of one coordinate, radians.
const LONGEST_STEP: f64 = 0.4;

/// A posture that brings two places of the skin together, as far as it can.
#[derive(Clone, Debug, PartialEq)]
pub struct Reach {
    /// The posture, within the joints' ranges.
    pub posture: Vec<f64>,
    /// How far apart the two points stay, metres.
    pub miss: f64,
    /// Cosine between the two outward normals: −1 where the two places face each other.
    pub facing: f64,
}

impl Reach {
    /// Whether the points meet, by the schema.
    pub fn reached(&self) -> bool {
        self.miss <= REACHED
    }
}

/// One degree of freedom of the chain on its way to the solution.
struct Element {
    side: usize,
    kind: DofKind,
    dof: usize,
    coordinate: usize,
    range: [f64; 2],
    /// First of a joint: its position is applied before.
    position: Option<usize>,
    /// `R_CL` and origin in C just before the degree of freedom turns, metres.
    before: (Matrix3<f64>, Vector3<f64>),
}

/// The problem of bringing two receptors together: `depth` metres inside both limbs in all, so that a schema
/// that is wrong by as much still makes contact.
pub struct InverseKinematics<'a> {
    schema: &'a BodySchema,
    elements: Vec<Element>,
    points: [Vector3<f64>; 2],
    normals: [Vector3<f64>; 2],
}

impl<'a> InverseKinematics<'a> {
    /// Prepares the chain between two receptors' limbs.
    pub fn new(
        creature: &Creature,
        skin: &Skin,
        schema: &'a BodySchema,
        receptors: [usize; 2],
        depth: f64,
    ) -> InverseKinematics<'a> {
        let receptors = receptors.map(|r| &skin.receptors[r]);
        let chain = Chain::between(creature, receptors[0].limb, receptors[1].limb);
        let mut elements = Vec::new();
        for (side, joints) in chain.sides.iter().enumerate() {
            for &j in joints {
                let joint = &creature.joints()[j];
                let mut coordinate = joint.first_coordinate();
                // A joint without degrees of freedom never occurs: it would be no joint.
                for (k, dof) in joint.dofs.iter().enumerate() {
                    let position = (k == 0).then_some(j);
                    let before = (Matrix3::identity(), Vector3::zeros());
                    let (kind, range, dof) = (dof.kind, dof.range, joint.first_dof() + k);
                    elements.push(Element { side, kind, dof, coordinate, range, position, before });
                    coordinate += kind.coordinates();
                }
            }
        }
        let points = receptors.map(|r| r.position - r.normal * (0.5 * depth));
        InverseKinematics { schema, elements, points, normals: receptors.map(|r| r.normal) }
    }

    /// Solves from a start posture; coordinates outside the chain stay as they are there.
    pub fn solve(&mut self, start: &[f64]) -> Reach {
        let mut posture = start.to_vec();
        for (steps, weight) in STEPS.into_iter().zip([NORMAL_WEIGHT, LAST_NORMAL_WEIGHT]) {
            for _ in 0..steps {
                let (points, normals) = self.place(&posture);
                let (miss, tilt) = (points[0] - points[1], (normals[0] + normals[1]) * weight);
                if miss.norm() < 0.05 * REACHED && weight == LAST_NORMAL_WEIGHT {
                    break;
                }
                self.step(&mut posture, points, normals, weight, [miss, tilt]);
            }
        }
        let (points, normals) = self.place(&posture);
        Reach { posture, miss: (points[0] - points[1]).norm(), facing: normals[0].dot(&normals[1]) }
    }

    /// The two points and normals in the common ancestor's frame.
    fn place(&mut self, posture: &[f64]) -> ([Vector3<f64>; 2], [Vector3<f64>; 2]) {
        let mut frames = [(Matrix3::identity(), Vector3::zeros()); 2];
        for element in &mut self.elements {
            let (turn, origin) = &mut frames[element.side];
            if let Some(joint) = element.position {
                *origin += *turn * self.schema.positions[joint];
            }
            element.before = (*turn, *origin);
            let q = &posture[element.coordinate..];
            let axis = &self.schema.axes[element.dof];
            match element.kind {
                DofKind::Hinge => *turn *= rotation(axis, q[0].sin(), 1.0 - q[0].cos()),
                DofKind::Slide => *origin += *turn * axis * q[0],
                DofKind::Ball => *turn *= ball(q).to_rotation_matrix().into_inner(),
            }
        }
        let points = [0, 1].map(|k| frames[k].0 * self.points[k] + frames[k].1);
        (points, [0, 1].map(|k| frames[k].0 * self.normals[k]))
    }

    /// One damped step within the ranges.
    fn step(
        &self,
        posture: &mut [f64],
        points: [Vector3<f64>; 2],
        normals: [Vector3<f64>; 2],
        weight: f64,
        residual: [Vector3<f64>; 2],
    ) {
        let mut columns: Vec<(usize, usize, Vector6<f64>)> = Vec::new();
        for (i, element) in self.elements.iter().enumerate() {
            let sign = if element.side == 0 { 1.0 } else { -1.0 };
            let (turn, origin) = element.before;
            let arm = points[element.side] - origin;
            let mut push = |k: usize, axis: Vector3<f64>, turns: bool| {
                let (moves, tilts) = match turns {
                    true => (axis.cross(&arm), axis.cross(&normals[element.side]) * weight),
                    false => (axis, Vector3::zeros()),
                };
                let mut column = Vector6::zeros();
                column.fixed_rows_mut::<3>(0).copy_from(&(moves * sign));
                column.fixed_rows_mut::<3>(3).copy_from(&tilts);
                columns.push((i, k, column));
            };
            match element.kind {
                DofKind::Ball => (0..3).for_each(|k| push(k, turn.column(k).into_owned(), true)),
                kind => push(0, turn * self.schema.axes[element.dof], kind == DofKind::Hinge),
            }
        }
        let residual = Vector6::from_iterator(residual.iter().flat_map(|v| v.iter().copied()));
        // Three rounds are enough for coordinates at their limits to be found out.
        let mut steps = vec![0.0; columns.len()];
        for _ in 0..3 {
            let used = DMatrix::from_fn(6, columns.len(), |row, c| columns[c].2[row]);
            let mut normal = Matrix6::from_fn(|i, j| used.row(i).dot(&used.row(j)));
            for k in 0..6 {
                normal[(k, k)] += DAMPING * DAMPING;
            }
            let Some(factor) = normal.cholesky() else { return };
            let dual = factor.solve(&residual);
            steps = columns.iter().map(|(_, _, column)| -column.dot(&dual)).collect();
            let mut held = false;
            for ((i, _, column), step) in columns.iter_mut().zip(&mut steps) {
                let element = &self.elements[*i];
                let [low, high] = element.range;
                let at = posture[element.coordinate];
                let stuck = (at <= low && *step < 0.0) || (at >= high && *step > 0.0);
                if element.kind != DofKind::Ball && stuck {
                    column.fill(0.0);
                    *step = 0.0;
                    held = true;
                }
            }
            if !held {
                break;
            }
        }
        let longest = steps.iter().fold(0.0f64, |most, step| most.max(step.abs()));
        let scale = if longest > LONGEST_STEP { LONGEST_STEP / longest } else { 1.0 };
        let mut turn = Vector3::zeros();
        for ((i, k, _), step) in columns.iter().zip(&steps) {
            let element = &self.elements[*i];
            let q = &mut posture[element.coordinate..];
            if element.kind == DofKind::Ball {
                turn[*k] = step * scale;
                if *k == 2 {
                    turn_ball(q, &turn, element.range[1]);
                }
            } else {
                q[0] = (q[0] + step * scale).clamp(element.range[0], element.range[1]);
            }
        }
    }
}

/// Turns a ball's coordinates by a rotation vector in its parent's frame, up to its largest angle.
pub(super) fn turn_ball(q: &mut [f64], turn: &Vector3<f64>, most: f64) {
    let turned = UnitQuaternion::from_scaled_axis(*turn) * ball(q);
    let limited = match turned.axis_angle() {
        Some((axis, angle)) if angle > most => UnitQuaternion::from_axis_angle(&axis, most),
        _ => turned,
    };
    q[..4].copy_from_slice(&[limited.w, limited.i, limited.j, limited.k]);
}
