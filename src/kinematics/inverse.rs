//! Inverse kinematics: postures in which two places of the body meet, by the schema that is believed.
//!
//! The two points are to coincide, and weakly a direction at one is to be parallel to one at the other; or all of one limb is
//! to be turned as another. What freedom is left may draw the posture towards a rest posture (Liégeois
//! 1977).

use nalgebra::{Matrix3, Vector3, Vector6};

use super::place_chain::{Damping, Place, PlaceChain, Workspace};
use crate::creature::{Creature, Posture};
use crate::geometry::{Frame, product};
use crate::schema::BodySchema;

/// How far apart the two points may stay in a posture that counts as found, metres.
pub const REACHED: f64 = 2e-3;
/// The same where a limb is to be turned as another, metres.
const EXACT: f64 = 1e-5;
/// Length that a direction which is not as wanted counts as, metres: at first …
const DIRECTION_LENGTH: f64 = 0.03;
/// … and at the end, when only the points matter.
const LAST_DIRECTION_LENGTH: f64 = 5e-4;
/// Steps with either weight.
const STEPS: [usize; 2] = [15, 15];
/// How far steps go.
const DAMPING: Damping = Damping { damping: 0.01, longest: 0.4 };

/// A posture that brings two places together, as far as it can.
#[derive(Clone, Debug, PartialEq)]
pub struct Reach {
    /// The posture, within the joints' ranges.
    pub posture: Posture,
    /// How far apart the two points stay, metres.
    pub miss: f64,
    /// Cosine between the two directions, or of the angle between frames that are to be turned the same.
    pub facing: f64,
}

impl Reach {
    /// Whether the points meet, by the schema.
    pub fn reached(&self) -> bool {
        self.miss <= REACHED
    }
}

/// The problem of bringing two places together.
#[derive(Clone, Debug)]
pub struct InverseKinematics<'a> {
    creature: &'a Creature,
    schema: &'a BodySchema,
    ends: [Place; 2],
    turned: Option<[Matrix3<f64>; 2]>,
    direction_lengths: [f64; 2],
    steps: [usize; 2],
    /// Per joint, whether it moves.
    moves: Vec<bool>,
    at_ease: Option<Vec<f64>>,
}

impl<'a> InverseKinematics<'a> {
    /// Prepares the chain between two places' limbs; a place in space is one on the root, limb 0.
    pub fn new(creature: &'a Creature, schema: &'a BodySchema, ends: [Place; 2]) -> InverseKinematics<'a> {
        InverseKinematics {
            creature,
            schema,
            ends,
            turned: None,
            direction_lengths: [DIRECTION_LENGTH, LAST_DIRECTION_LENGTH],
            steps: STEPS,
            moves: vec![true; creature.joints().len()],
            at_ease: None,
        }
    }

    /// Has frames that are fixed to the two limbs at the places turned the same, in place of directions.
    pub fn turned(mut self, frames: [Matrix3<f64>; 2]) -> Self {
        self.turned = Some(frames);
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

    /// Holds all joints still but those for which `moves` says yes.
    pub fn moving(mut self, moves: impl Fn(usize) -> bool) -> Self {
        self.moves.iter_mut().enumerate().for_each(|(joint, free)| *free = moves(joint));
        self
    }

    /// Draws what freedom is left towards a posture.
    pub fn at_ease(mut self, posture: &[f64]) -> Self {
        self.at_ease = Some(posture.to_vec());
        self
    }

    /// Solves from a start posture; all that does not move stays as it is there.
    pub fn solve(&self, start: &[f64]) -> Reach {
        let mut workspace = Workspace::default();
        let moves = |joint: usize| self.moves[joint];
        let chain = PlaceChain::new(self.creature, self.schema, self.ends, &Frame::identity(), start, moves);
        let mut q = chain.of_posture(start);
        let ease = self.at_ease.as_deref().map(|posture| chain.of_posture(posture));
        let last = self.steps.len() - 1;
        for (round, (steps, length)) in self.steps.into_iter().zip(self.direction_lengths).enumerate() {
            for _ in 0..steps {
                let limbs = chain.place(&q, &mut workspace);
                let (miss, tilt) = (self.miss(&limbs), self.tilt(&limbs) * length);
                // With directions that matter in the end, only a step that no longer moves is the last.
                let done = match self.turned {
                    Some(_) => miss.norm().max(tilt.norm()) < EXACT,
                    None => miss.norm() < 0.05 * REACHED && tilt.norm() < 0.5 * REACHED.max(length),
                };
                if done && round == last && ease.is_none() {
                    break;
                }
                let points = [0, 1].map(|k| limbs[k].point(&self.ends[k].point));
                chain.differentiate(&q, &points, &mut workspace);
                let directions = self.directions(&limbs);
                let mut wanted = Vector6::zeros();
                wanted.fixed_rows_mut::<3>(0).copy_from(&-miss);
                wanted.fixed_rows_mut::<3>(3).copy_from(&-tilt);
                chain.step(
                    &mut q,
                    |column| {
                        let tilts = match self.turned {
                            Some(_) => column.turns,
                            None => column.turns.cross(&directions[column.side]),
                        };
                        let mut row = Vector6::zeros();
                        row.fixed_rows_mut::<3>(0).copy_from(&column.moves);
                        row.fixed_rows_mut::<3>(3).copy_from(&(tilts * length));
                        row
                    },
                    &wanted,
                    ease.as_deref(),
                    DAMPING,
                    &mut workspace,
                );
            }
        }
        let limbs = chain.place(&q, &mut workspace);
        let directions = self.directions(&limbs);
        let facing = match self.turned {
            Some(_) => self.tilt(&limbs).norm().cos(),
            None => directions[0].dot(&directions[1]),
        };
        let mut posture = Posture::from(start);
        chain.put_into(q, &mut posture);
        // What follows may be beside the chain.
        self.creature.couple(&mut posture);
        Reach { posture, miss: self.miss(&limbs).norm(), facing }
    }

    fn directions(&self, limbs: &[Frame; 2]) -> [Vector3<f64>; 2] {
        [0, 1].map(|k| limbs[k].rotation * self.ends[k].direction)
    }

    /// How far the first place is from the second, metres.
    fn miss(&self, limbs: &[Frame; 2]) -> Vector3<f64> {
        limbs[0].point(&self.ends[0].point) - limbs[1].point(&self.ends[1].point)
    }

    /// How far directions, or turns, are from what they are to be.
    fn tilt(&self, limbs: &[Frame; 2]) -> Vector3<f64> {
        let directions = self.directions(limbs);
        match self.turned {
            None => directions[0] - directions[1],
            Some(frames) => {
                let [first, second] = [0, 1].map(|k| limbs[k].rotation * frames[k]);
                // By a quaternion: rounding must not take the cosine of a small angle beyond 1.
                let rotation = product(&first, &second.transpose());
                Frame { rotation, origin: Vector3::zeros() }.quaternion().scaled_axis()
            }
        }
    }
}
