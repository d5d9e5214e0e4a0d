//! How limbs move as single coordinates of a posture change: the derivatives of points and directions.
//!
//! Every limb that a hinge carries turns about the hinge's axis, so that with the axes `a_i` in the root's frame
//! `∂p/∂q_j = a_j × (p − o_j)`. A slide shifts along its axis and turns nothing; a ball counts as three hinges about its parent's
//! axes.

use std::sync::Arc;

use nalgebra::Vector3;

use super::forward::{carry_through, joint_transforms, limb_frames};
use crate::creature::{Coupling, Creature, DofKind, Posture, turn_ball};
use crate::geometry::Frame;
use crate::schema::BodySchema;

/// One way in which a posture may change: a hinge or slide with what follows it, or a ball's turn about one axis.
#[derive(Clone, Debug)]
struct Freedom {
    coordinate: usize,
    /// The least and greatest coordinate; a ball's largest angle is kept by its turn.
    range: Option<[f64; 2]>,
    /// Which axis of a ball.
    part: usize,
    /// Its axis among all axes, and those of what follows it.
    axis: usize,
    followers: Vec<usize>,
}

/// The ways in which some joints may change a posture, by a schema.
#[derive(Clone, Debug)]
pub struct Freedoms<'a> {
    creature: &'a Creature,
    schema: &'a BodySchema,
    list: Vec<Freedom>,
    /// Per limb, which limbs it carries, itself among them.
    carries: Arc<[Vec<bool>]>,
}

/// An axis in a posture: its joint, its direction, of a ball all three, and a point on it, in the root's frame.
struct Axis {
    joint: usize,
    directions: [Vector3<f64>; 3],
    origin: Vector3<f64>,
    kind: DofKind,
}

/// How a limb moves as one coordinate grows.
#[derive(Clone, Copy, Debug)]
struct Screw {
    /// The limb that it moves first.
    limb: usize,
    /// Its axis times the coordinate's rate, and a point on it, in the root's frame.
    axis: Vector3<f64>,
    origin: Vector3<f64>,
    turns: bool,
}

/// What is fixed to a limb, in the root's frame.
#[derive(Clone, Copy, Debug)]
pub enum Feature {
    /// A point, metres.
    Point(Vector3<f64>),
    /// A unit direction.
    Direction(Vector3<f64>),
}

/// A body in a posture, and how it moves from there.
#[derive(Clone, Debug)]
pub struct FreeMotions {
    /// `X_RL` of every limb.
    pub frames: Vec<Frame>,
    carries: Arc<[Vec<bool>]>,
    /// Per freedom, what it moves.
    screws: Vec<Vec<Screw>>,
}

impl<'a> Freedoms<'a> {
    /// The freedoms of some joints, by their indices, root's side first.
    pub fn new(creature: &'a Creature, schema: &'a BodySchema, joints: &[usize]) -> Freedoms<'a> {
        let mut list = Vec::new();
        for (j, joint) in creature.joints().iter().enumerate() {
            for at in joint.elements().filter(|at| joints.contains(&j) && at.follows.is_none()) {
                let leads = |other: usize| other == at.axis();
                let followers = creature
                    .elements()
                    .filter(|other| other.follows.is_some_and(|coupling| leads(coupling.leader)))
                    .map(|other| other.axis());
                let freedom = Freedom {
                    coordinate: at.coordinate(),
                    range: (!at.is_ball()).then_some(at.range),
                    part: 0,
                    axis: at.axis(),
                    followers: followers.collect(),
                };
                let parts = if at.is_ball() { 3 } else { 1 };
                list.extend((0..parts).map(|part| Freedom { part, ..freedom.clone() }));
            }
        }
        let carries = (0..creature.limbs().len()).map(|limb| creature.carried_by(limb)).collect();
        Freedoms { creature, schema, list, carries }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.list.len()
    }

    /// The freedom of a hinge's or slide's coordinate; `None` if it follows another.
    pub fn of_coordinate(&self, coordinate: usize) -> Option<usize> {
        self.list.iter().position(|freedom| freedom.coordinate == coordinate && freedom.range.is_some())
    }

    /// The least and greatest change of a freedom from a posture that keeps within its range and within `most`, radians
    /// or metres.
    pub fn bounds(&self, freedom: usize, posture: &[f64], most: f64) -> [f64; 2] {
        let Freedom { coordinate, range, .. } = &self.list[freedom];
        match range {
            Some([low, high]) => {
                let at = posture[*coordinate];
                [(low - at).clamp(-most, 0.0), (high - at).clamp(0.0, most)]
            }
            None => [-most, most],
        }
    }

    /// The posture that differs from another by a change of each freedom, within the joints' ranges.
    pub fn changed(&self, posture: &[f64], change: &[f64]) -> Posture {
        let mut changed = Posture::from(posture);
        let mut turn = Vector3::zeros();
        for (freedom, change) in self.list.iter().zip(change) {
            let at = freedom.coordinate;
            match freedom.range {
                Some([low, high]) => changed[at] = (changed[at] + change).clamp(low, high),
                None => {
                    turn[freedom.part] = *change;
                    if freedom.part == 2 {
                        let ball = self.creature.elements().find(|other| other.axis() == freedom.axis);
                        let most = ball.map_or(std::f64::consts::PI, |ball| ball.range[1]);
                        turn_ball(&mut changed[at..], &turn, most);
                    }
                }
            }
        }
        self.creature.couple(&mut changed);
        changed
    }

    /// The body in a posture, and how it moves from there.
    pub fn at(&self, posture: &[f64]) -> FreeMotions {
        self.at_frames(posture, limb_frames(self.creature, self.schema, posture))
    }

    /// The same, given where the posture has the limbs.
    pub fn at_frames(&self, posture: &[f64], frames: Vec<Frame>) -> FreeMotions {
        let mut axes: Vec<Axis> = Vec::new();
        for (j, joint) in self.creature.joints().iter().enumerate() {
            let mut frame = frames[joint.parent];
            let mut kinds = joint.dofs.iter().map(|dof| dof.kind);
            carry_through(self.schema, j, joint_transforms(joint, posture), &mut frame, |dof, _, before| {
                let kind = kinds.next().expect("a kind for each degree of freedom");
                let directions = match kind {
                    DofKind::Ball => [0, 1, 2].map(|k| before.rotation.column(k).into_owned()),
                    _ => [before.direction(&self.schema.axes[dof]); 3],
                };
                axes.push(Axis { joint: j, directions, origin: before.origin, kind });
            });
        }
        let coordinates: Vec<_> = self.creature.elements().collect();
        let screws = self.list.iter().map(|freedom| {
            let screw = |axis: usize, rate: f64| {
                let Axis { joint, directions, origin, kind } = &axes[axis];
                Screw {
                    limb: joint + 1,
                    axis: directions[freedom.part] * rate,
                    origin: *origin,
                    turns: *kind != DofKind::Slide,
                }
            };
            let following = freedom.followers.iter().map(|&axis| {
                let rate = |coupling: Coupling| coupling.rate(posture[freedom.coordinate]);
                screw(axis, coordinates[axis].follows.map_or(0.0, rate))
            });
            std::iter::once(screw(freedom.axis, 1.0)).chain(following).collect()
        });
        FreeMotions { screws: screws.collect(), carries: self.carries.clone(), frames }
    }
}

impl FreeMotions {
    /// The axis of a freedom, in the root's frame.
    pub fn axis(&self, freedom: usize) -> Vector3<f64> {
        self.screws[freedom][0].axis
    }

    /// What moves a limb: freedom and screw.
    fn moving(&self, limb: usize) -> impl Iterator<Item = (usize, &Screw)> {
        self.screws
            .iter()
            .enumerate()
            .flat_map(|(k, screws)| screws.iter().map(move |screw| (k, screw)))
            .filter(move |(_, screw)| self.carries[screw.limb][limb])
    }

    /// Adds to each freedom's entry how fast a feature of a limb moves along a direction.
    pub fn add_rates(&self, limb: usize, feature: Feature, along: &Vector3<f64>, rates: &mut [f64]) {
        for (k, screw) in self.moving(limb) {
            rates[k] += screw.rate(&feature).dot(along);
        }
    }

    /// Adds to each freedom's entry how fast the gap grows between points of a limb and of another one, which moves with no
    /// freedom if it is `None`; the normal leads from the other to the limb.
    pub fn add_gap_rates(
        &self,
        [limb, other]: [Option<usize>; 2],
        points: &[Vector3<f64>; 2],
        normal: &Vector3<f64>,
        rates: &mut [f64],
    ) {
        for (limb, point, normal) in [(limb, points[0], *normal), (other, points[1], -normal)] {
            limb.into_iter().for_each(|limb| self.add_rates(limb, Feature::Point(point), &normal, rates));
        }
    }
}

impl Screw {
    /// How fast a feature that it carries moves.
    fn rate(&self, feature: &Feature) -> Vector3<f64> {
        match (feature, self.turns) {
            (Feature::Point(point), true) => self.axis.cross(&(point - self.origin)),
            (Feature::Point(_), false) => self.axis,
            (Feature::Direction(direction), true) => self.axis.cross(direction),
            (Feature::Direction(_), false) => Vector3::zeros(),
        }
    }
}
