//! Inverse kinematics: postures in which two places of the body meet, by the schema that is believed.
//!
//! Damped least squares (Wampler 1986, Nakamura and Hanafusa 1986) on the coordinates of the chain between the two
//! limbs: the two points are to coincide, and weakly a direction at one is to be opposed to one at the other, or
//! parallel to it. Coordinates stay within their ranges; one that is at its limit and would leave it is held for that
//! step. What freedom is left may draw the posture towards one at ease (Liégeois 1977).

use nalgebra::{Matrix6, Vector3, Vector6};

use super::chain::Chain;
use super::forward::{DofTransform, carry_through};
use crate::creature::{Creature, DofKind, Posture, turn_ball};
use crate::geometry::Frame;
use crate::schema::BodySchema;

/// How far apart the two points may stay in a posture that counts as found, metres.
pub const REACHED: f64 = 2e-3;
/// Length that a direction which is not as wanted counts as, metres: at first …
const DIRECTION_LENGTH: f64 = 0.03;
/// … and at the end, when only the points matter.
const LAST_DIRECTION_LENGTH: f64 = 5e-4;
/// Steps with either weight.
const STEPS: [usize; 2] = [15, 15];
/// Damping, metres per radian.
const DAMPING: f64 = 0.01;
/// The longest step of one coordinate, radians.
const LONGEST_STEP: f64 = 0.4;
/// The share of the way to the posture at ease that is left free and gone in one step.
const EASE: f64 = 0.2;

/// A place that is fixed to a limb.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The limb.
    pub limb: usize,
    /// The point in its frame, metres.
    pub point: Vector3<f64>,
    /// A unit direction in its frame; zero where there is none.
    pub direction: Vector3<f64>,
}

/// How the directions at the two places are to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Facing {
    /// Against each other, as the normals of two surfaces that touch.
    Opposed,
    /// The same.
    Parallel,
}

/// A posture that brings two places together, as far as it can.
#[derive(Clone, Debug, PartialEq)]
pub struct Reach {
    /// The posture, within the joints' ranges.
    pub posture: Posture,
    /// How far apart the two points stay, metres.
    pub miss: f64,
    /// Cosine between the two directions: −1 where they are opposed.
    pub facing: f64,
}

impl Reach {
    /// Whether the points meet, by the schema.
    pub fn reached(&self) -> bool {
        self.miss <= REACHED
    }
}

/// One degree of freedom of the chain on its way to the solution.
#[derive(Clone, Debug)]
struct Element {
    side: usize,
    kind: DofKind,
    dof: usize,
    coordinate: usize,
    range: [f64; 2],
    free: bool,
    joint: usize,
}

/// The problem of bringing two places together.
#[derive(Clone, Debug)]
pub struct InverseKinematics<'a> {
    creature: &'a Creature,
    schema: &'a BodySchema,
    elements: Vec<Element>,
    /// Per element, the limb's frame in C just before the degree of freedom turns.
    before: Vec<Frame>,
    ends: [Place; 2],
    facing: Facing,
    direction_lengths: [f64; 2],
    steps: [usize; 2],
    at_ease: Option<Vec<f64>>,
    coupled: bool,
}

impl<'a> InverseKinematics<'a> {
    /// Prepares the chain between two places' limbs; a place in space is one on the root, limb 0.
    pub fn new(creature: &'a Creature, schema: &'a BodySchema, ends: [Place; 2]) -> InverseKinematics<'a> {
        let chain = Chain::between(creature, ends[0].limb, ends[1].limb);
        let mut elements = Vec::new();
        for (side, joints) in chain.sides.iter().enumerate() {
            for &j in joints {
                let joint = &creature.joints()[j];
                // A joint without degrees of freedom never occurs: it would be no joint.
                for at in joint.elements() {
                    elements.push(Element {
                        side,
                        kind: at.kind,
                        dof: at.axis(),
                        coordinate: at.coordinate(),
                        range: at.range,
                        free: at.follows.is_none(),
                        joint: j,
                    });
                }
            }
        }
        InverseKinematics {
            creature,
            schema,
            before: vec![Frame::identity(); elements.len()],
            elements,
            ends,
            facing: Facing::Opposed,
            direction_lengths: [DIRECTION_LENGTH, LAST_DIRECTION_LENGTH],
            steps: STEPS,
            at_ease: None,
            coupled: creature.dofs().any(|dof| dof.follows.is_some()),
        }
    }

    /// How the directions are to be; opposed unless said.
    pub fn with_facing(mut self, facing: Facing) -> Self {
        self.facing = facing;
        self
    }

    /// What length a direction that is not as wanted counts as, metres: at first and in the end.
    pub fn with_direction_lengths(mut self, lengths: [f64; 2]) -> Self {
        self.direction_lengths = lengths;
        self
    }

    /// The most steps, with either weight of the directions.
    pub fn with_steps(mut self, steps: [usize; 2]) -> Self {
        self.steps = steps;
        self
    }

    /// Holds all degrees of freedom still but those of the joints for which `moves` says yes.
    pub fn moving(mut self, moves: impl Fn(usize) -> bool) -> Self {
        self.elements.iter_mut().for_each(|element| element.free &= moves(element.joint));
        self
    }

    /// Draws what freedom is left towards a posture.
    pub fn at_ease(mut self, posture: &[f64]) -> Self {
        self.at_ease = Some(posture.to_vec());
        self
    }

    /// Solves from a start posture; coordinates outside the chain stay as they are there.
    pub fn solve(&mut self, start: &[f64]) -> Reach {
        let mut posture = Posture::from(start);
        let last = self.steps.len() - 1;
        for (round, (steps, length)) in self.steps.into_iter().zip(self.direction_lengths).enumerate() {
            for _ in 0..steps {
                let (points, directions) = self.place(&posture);
                let (miss, tilt) = (points[0] - points[1], self.tilt(&directions) * length);
                // With directions that matter in the end, only a step that no longer moves is the last.
                let done = miss.norm() < 0.05 * REACHED && tilt.norm() < 0.5 * REACHED.max(length);
                if done && round == last && self.at_ease.is_none() {
                    break;
                }
                self.step(&mut posture, points, directions, length, [miss, tilt]);
            }
        }
        let (points, directions) = self.place(&posture);
        Reach { posture, miss: (points[0] - points[1]).norm(), facing: directions[0].dot(&directions[1]) }
    }

    fn tilt(&self, directions: &[Vector3<f64>; 2]) -> Vector3<f64> {
        match self.facing {
            Facing::Opposed => directions[0] + directions[1],
            Facing::Parallel => directions[0] - directions[1],
        }
    }

    /// The two points and directions in the common ancestor's frame.
    fn place(&mut self, posture: &[f64]) -> ([Vector3<f64>; 2], [Vector3<f64>; 2]) {
        let mut frames = [Frame::identity(); 2];
        let mut before = self.before.iter_mut();
        for of_joint in self.elements.chunk_by(|a, b| a.joint == b.joint) {
            let at = |element: &Element| {
                (element.dof, DofTransform::at(element.kind, &posture[element.coordinate..]))
            };
            let frame = &mut frames[of_joint[0].side];
            carry_through(self.schema, of_joint[0].joint, of_joint.iter().map(at), frame, |_, _, frame| {
                *before.next().expect("one for each element") = *frame;
            });
        }
        let points = [0, 1].map(|k| frames[k].point(&self.ends[k].point));
        (points, [0, 1].map(|k| frames[k].rotation * self.ends[k].direction))
    }

    /// One damped step within the ranges.
    fn step(
        &self,
        posture: &mut [f64],
        points: [Vector3<f64>; 2],
        directions: [Vector3<f64>; 2],
        length: f64,
        residual: [Vector3<f64>; 2],
    ) {
        let mut columns: Vec<(usize, usize, Vector6<f64>)> = Vec::with_capacity(self.elements.len() + 8);
        for (i, element) in self.elements.iter().enumerate().filter(|(_, element)| element.free) {
            let sign = if element.side == 0 { 1.0 } else { -1.0 };
            let tilted = if self.facing == Facing::Parallel { sign } else { 1.0 };
            let before = &self.before[i];
            let arm = points[element.side] - before.origin;
            let mut push = |k: usize, axis: Vector3<f64>, turns: bool| {
                let (moves, tilts) = match turns {
                    true => (axis.cross(&arm), axis.cross(&directions[element.side]) * (length * tilted)),
                    false => (axis, Vector3::zeros()),
                };
                let mut column = Vector6::zeros();
                column.fixed_rows_mut::<3>(0).copy_from(&(moves * sign));
                column.fixed_rows_mut::<3>(3).copy_from(&tilts);
                columns.push((i, k, column));
            };
            match element.kind {
                DofKind::Ball => (0..3).for_each(|k| push(k, before.rotation.column(k).into_owned(), true)),
                kind => push(0, before.direction(&self.schema.axes[element.dof]), kind == DofKind::Hinge),
            }
        }
        // What ease would have each coordinate do; balls have none.
        let ease: Vec<f64> = columns
            .iter()
            .map(|(i, _, _)| match (&self.at_ease, &self.elements[*i]) {
                (Some(at_ease), element) if element.kind != DofKind::Ball => {
                    EASE * (at_ease[element.coordinate] - posture[element.coordinate])
                }
                _ => 0.0,
            })
            .collect();
        let residual = Vector6::from_iterator(residual.iter().flat_map(|v| v.iter().copied()));
        // Three rounds are enough for coordinates at their limits to be found out.
        let mut steps = vec![0.0; columns.len()];
        let mut held = vec![false; columns.len()];
        for _ in 0..3 {
            let mut normal = Matrix6::identity() * (DAMPING * DAMPING);
            let mut wanted = residual;
            for (((_, _, column), ease), _) in
                columns.iter().zip(&ease).zip(&held).filter(|(_, held)| !**held)
            {
                normal.ger(1.0, column, column, 1.0);
                wanted += column * *ease;
            }
            let Some(factor) = normal.cholesky() else { return };
            let dual = factor.solve(&wanted);
            let mut stopped = false;
            for (c, (i, _, column)) in columns.iter().enumerate() {
                if held[c] {
                    steps[c] = 0.0;
                    continue;
                }
                steps[c] = ease[c] - column.dot(&dual);
                let element = &self.elements[*i];
                let [low, high] = element.range;
                let at = posture[element.coordinate];
                let stuck = (at <= low && steps[c] < 0.0) || (at >= high && steps[c] > 0.0);
                if element.kind != DofKind::Ball && stuck {
                    (held[c], stopped) = (true, true);
                    steps[c] = 0.0;
                }
            }
            if !stopped {
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
        if self.coupled {
            self.creature.couple(posture);
        }
    }
}
