//! A posture: the position of every joint of a creature.

use std::ops::{Deref, DerefMut, Range};

use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};
use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use super::{Creature, Dof, DofKind};
use crate::geometry::{random_direction, wxyz};
use crate::named::listed;

/// How far a coordinate may be beyond its range, radians or metres: degrees are rounded.
const PLAY: f64 = 1e-6;

/// Where every joint of a creature stands: its coordinates in the creature's order. Of a hinge the angle in
/// radians, of a slide the distance in metres, of a ball a unit quaternion w x y z.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Posture(Vec<f64>);

/// A degree of freedom, with where its axis stands in a schema and its coordinates in a posture.
#[derive(Clone, Copy, Debug)]
pub struct DofElement<'a> {
    dof: &'a Dof,
    axis: usize,
    coordinate: usize,
}

impl<'a> DofElement<'a> {
    pub(super) fn new(dof: &'a Dof, axis: usize, coordinate: usize) -> DofElement<'a> {
        DofElement { dof, axis, coordinate }
    }

    /// Index of its axis among the axes of all joints.
    pub fn axis(&self) -> usize {
        self.axis
    }

    /// Index of its coordinate in a posture; of a ball, of the first.
    pub fn coordinate(&self) -> usize {
        self.coordinate
    }

    /// Indices of its coordinates in a posture.
    pub fn coordinates(&self) -> Range<usize> {
        self.coordinate..self.coordinate + self.dof.kind.coordinates()
    }

    /// Its coordinates in a posture.
    #[inline]
    pub fn of<'p>(&self, posture: &'p [f64]) -> &'p [f64] {
        &posture[self.coordinates()]
    }

    /// Its coordinates in a posture, to be changed.
    pub fn of_mut<'p>(&self, posture: &'p mut [f64]) -> &'p mut [f64] {
        &mut posture[self.coordinates()]
    }

    /// Whether it turns freely about a point.
    pub fn is_ball(&self) -> bool {
        self.dof.kind == DofKind::Ball
    }
}

impl Deref for DofElement<'_> {
    type Target = Dof;

    fn deref(&self) -> &Dof {
        self.dof
    }
}

impl Posture {
    /// The reference posture: every angle and distance zero.
    pub fn reference(creature: &Creature) -> Posture {
        let mut posture = Posture(vec![0.0; creature.coordinates()]);
        for ball in creature.elements().filter(DofElement::is_ball) {
            posture[ball.coordinate()] = 1.0;
        }
        posture
    }

    /// The posture that motion starts from: the reference posture, or as near to it as ranges allow.
    pub fn start(creature: &Creature) -> Posture {
        let mut posture = Posture::reference(creature);
        posture.clamp(creature);
        creature.couple(&mut posture);
        posture
    }

    /// The posture at the start but for what words such as `left_elbow_flexion=90,neck=0.7:0.7:0:0` say: degrees, millimetres, and of
    /// a ball its quaternion w x y z.
    ///
    /// # Errors
    /// The word that cannot be followed, and why.
    pub fn from_words(creature: &Creature, words: &str) -> Result<Posture, String> {
        let mut posture = Posture::start(creature);
        for word in words.split(',').map(str::trim).filter(|word| !word.is_empty()) {
            set(word, creature, &mut posture).map_err(|message| format!("{word}: {message}"))?;
        }
        creature.couple(&mut posture);
        Ok(posture)
    }

    /// The same posture of a creature with all lengths so many times as long: the coordinates of slides.
    pub(crate) fn scaled(&self, creature: &Creature, by: f64) -> Posture {
        let mut scaled = self.clone();
        for slide in creature.elements().filter(|element| element.kind == DofKind::Slide) {
            scaled[slide.coordinate()] *= by;
        }
        scaled
    }

    /// A posture drawn uniformly from the joints' ranges.
    pub fn random(creature: &Creature, rng: &mut impl Rng) -> Posture {
        let mut posture = Vec::with_capacity(creature.coordinates());
        for dof in creature.dofs() {
            let [low, high] = dof.range;
            match dof.kind {
                DofKind::Hinge | DofKind::Slide => posture.push(low + (high - low) * rng.random::<f64>()),
                DofKind::Ball => {
                    let axis = Unit::new_unchecked(random_direction(rng));
                    let q = UnitQuaternion::from_axis_angle(&axis, high * rng.random::<f64>());
                    posture.extend(wxyz(&q));
                }
            }
        }
        creature.couple(&mut posture);
        Posture(posture)
    }

    /// The posture a share of the path from one to another; balls turn about one axis.
    pub fn between(creature: &Creature, from: &[f64], to: &[f64], share: f64) -> Posture {
        let mut posture: Vec<f64> = from.iter().zip(to).map(|(a, b)| a + share * (b - a)).collect();
        for at in creature.elements().filter(DofElement::is_ball) {
            let (a, b) = (ball(at.of(from)), ball(at.of(to)));
            let turned = UnitQuaternion::from_scaled_axis((b * a.inverse()).scaled_axis() * share) * a;
            at.of_mut(&mut posture).copy_from_slice(&wxyz(&turned));
        }
        Posture(posture)
    }

    /// A posture with some joints, by their indices, as they are in another.
    pub fn with_joints(
        creature: &Creature,
        posture: &[f64],
        joints: impl IntoIterator<Item = usize>,
        other: &[f64],
    ) -> Posture {
        let mut posture = posture.to_vec();
        for joint in joints {
            let q = creature.joints()[joint].coordinates();
            posture[q.clone()].copy_from_slice(&other[q]);
        }
        Posture(posture)
    }

    /// The target as far as every ball can go straight towards it: two rotations within a ball's range may
    /// have none of the rotations between them within it, and there the ball goes up to its limit.
    pub fn reachable(creature: &Creature, start: &[f64], target: &[f64]) -> Posture {
        let mut reached = target.to_vec();
        for at in creature.elements().filter(DofElement::is_ball) {
            let (from, to) = (ball(at.of(start)), ball(at.of(target)));
            if let Some((axis, angle)) = (to * from.inverse()).axis_angle() {
                let share = within(&from, &axis, angle, at.range[1]);
                if share < 1.0 {
                    let limit = UnitQuaternion::from_axis_angle(&axis, share * angle) * from;
                    at.of_mut(&mut reached).copy_from_slice(&wxyz(&limit));
                }
            }
        }
        Posture(reached)
    }

    /// Puts every hinge and slide within its range.
    pub fn clamp(&mut self, creature: &Creature) {
        for at in creature.elements().filter(|at| !at.is_ball()) {
            let [low, high] = at.range;
            self[at.coordinate()] = self[at.coordinate()].clamp(low, high);
        }
    }
}

impl Deref for Posture {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.0
    }
}

impl DerefMut for Posture {
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.0
    }
}

impl<T: Into<Vec<f64>>> From<T> for Posture {
    fn from(coordinates: T) -> Posture {
        Posture(coordinates.into())
    }
}

impl FromIterator<f64> for Posture {
    fn from_iter<I: IntoIterator<Item = f64>>(coordinates: I) -> Posture {
        Posture(coordinates.into_iter().collect())
    }
}

impl<'a> IntoIterator for &'a Posture {
    type Item = &'a f64;
    type IntoIter = std::slice::Iter<'a, f64>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

/// A ball's rotation from its posture coordinates w x y z.
#[inline]
pub fn ball(q: &[f64]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3]))
}

/// Turns a ball's coordinates by a rotation vector in its parent's frame, up to its largest angle.
pub fn turn_ball(q: &mut [f64], turn: &Vector3<f64>, most: f64) {
    let turned = UnitQuaternion::from_scaled_axis(*turn) * ball(q);
    let limited = match turned.axis_angle() {
        Some((axis, angle)) if angle > most => UnitQuaternion::from_axis_angle(&axis, most),
        _ => turned,
    };
    q[..4].copy_from_slice(&wxyz(&limited));
}

/// The share of a turn about `axis` by `angle` that stays within rotations by at most `most`.
fn within(from: &UnitQuaternion<f64>, axis: &Unit<Vector3<f64>>, angle: f64, most: f64) -> f64 {
    if most >= std::f64::consts::PI {
        return 1.0;
    }
    // The cosine of half the whole angle runs as w cos(τ/2) − (axis · v) sin(τ/2) over the turn τ.
    let (w, v) = if from.w < 0.0 { (-from.w, -from.imag()) } else { (from.w, from.imag()) };
    let along = axis.dot(&v);
    let height = w.hypot(along);
    let least = (0.5 * most).cos();
    if height <= least {
        return 0.0;
    }
    let turn = 2.0 * ((least / height).acos() - along.atan2(w));
    (turn / angle).clamp(0.0, 1.0)
}

/// Sets one degree of freedom by a word such as left_elbow_flexion=90.
fn set(word: &str, creature: &Creature, posture: &mut Posture) -> Result<(), String> {
    let numbers = |text: &str| -> Option<Vec<f64>> {
        let numbers =
            text.split(':').map(|number| number.trim().parse::<f64>().ok().filter(|x| x.is_finite()));
        numbers.collect()
    };
    let (name, numbers) = word
        .split_once('=')
        .and_then(|(name, value)| Some((name.trim(), numbers(value)?)))
        .ok_or("give a name, = and a number, as in left_elbow_flexion=90")?;
    let element = creature.elements().find(|element| element.name == name).ok_or_else(|| {
        // Of many names, those that share a word are the useful ones.
        let words: Vec<&str> = name.split(['_', ' ', '-', '.']).filter(|word| word.len() > 2).collect();
        let shared = |name: &str| words.iter().filter(|word| name.contains(**word)).count();
        let most = creature.dofs().map(|dof| shared(&dof.name)).max().unwrap_or(0);
        let alike = creature.dofs().map(|dof| dof.name.clone()).filter(|name| shared(name) == most);
        let names = listed(&alike.collect::<Vec<_>>());
        format!("{} has no degree of freedom {name}; it has {names}", creature.name())
    })?;
    if let Some(coupling) = element.follows {
        let leader = creature.dofs().nth(coupling.leader).map_or("", |dof| &dof.name);
        return Err(format!("{name} follows {leader}: set {leader}"));
    }
    let (unit, per_unit) = match element.kind {
        DofKind::Slide => (" mm", 1e3),
        DofKind::Hinge | DofKind::Ball => ("°", 1f64.to_degrees()),
    };
    let coordinate = match (element.kind, numbers.as_slice()) {
        (DofKind::Ball, &[w, x, y, z]) => {
            let length = [w, x, y, z].iter().map(|x| x * x).sum::<f64>().sqrt();
            if (length - 1.0).abs() > 0.02 {
                return Err(format!("the quaternion's length is {length:.3}: make it 1"));
            }
            let quaternion = [w, x, y, z].map(|x| x / length);
            element.of_mut(posture).copy_from_slice(&quaternion);
            2.0 * quaternion[0].abs().min(1.0).acos()
        }
        (DofKind::Hinge | DofKind::Slide, &[number]) => {
            posture[element.coordinate()] = number / per_unit;
            number / per_unit
        }
        (DofKind::Ball, _) => return Err(format!("{name} is a ball: give its quaternion as w:x:y:z")),
        _ => return Err(format!("{name} is not a ball: give one number")),
    };
    let [low, high] = element.range;
    if (low - PLAY..=high + PLAY).contains(&coordinate) {
        return Ok(());
    }
    let [x, low, high] =
        [coordinate, low, high].map(|x| format!("{}{unit}", (x * per_unit * 100.0).round() / 100.0));
    Err(format!("{x} is outside its range of {low} to {high}: give a number within"))
}
