//! What the agent is given of its body: the tree of joints, their degrees of freedom and ranges, the
//! limbs. Positions and axes are not here: those it has to find out.

mod appearance;
mod body;
mod coupling;
mod from_model;
mod names;
mod posture;
mod selection;

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

pub use appearance::{Appearance, VisiblePart};
pub use body::{Body, Segment};
pub use coupling::Coupling;
pub(crate) use coupling::joint_couplings;
pub(crate) use from_model::{LIMB_TUPLE, UNLIMITED_SLIDE, limb_bodies, limits, matrix, span};
pub(crate) use names::{body_name, free_name, joint_name, site_name};
pub use posture::{DofElement, Posture, ball, turn_ball};
pub(crate) use selection::largest;
pub use selection::{CreatureInFile, JointSelection, creatures};

use crate::error::{Error, Kind};
use crate::plausible;

/// The kind of one degree of freedom (a ball counts three, but moves as one).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DofKind {
    /// Turns about an axis; its coordinate is an angle in radians.
    Hinge,
    /// Shifts along an axis; its coordinate is a distance in metres.
    Slide,
    /// Turns freely about a point; its coordinates are a unit quaternion w x y z.
    Ball,
}

impl DofKind {
    /// How many numbers of a posture belong to it.
    pub fn coordinates(self) -> usize {
        if self == DofKind::Ball { 4 } else { 1 }
    }

    /// How many degrees of freedom it counts.
    pub fn dof(self) -> usize {
        if self == DofKind::Ball { 3 } else { 1 }
    }
}

/// One degree of freedom of a joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub struct Dof {
    /// Its name in the model.
    pub name: String,
    /// Hinge, slide or ball.
    pub kind: DofKind,
    /// Least and greatest coordinate, in radians or metres; for a ball, 0 and the largest angle.
    pub range: [f64; 2],
    /// What it follows, if it does not move independently.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub follows: Option<Coupling>,
}

impl Dof {
    /// Its range as a person reads it: degrees or millimetres.
    pub fn range_in_words(&self) -> String {
        let [low, high] = self.range;
        match self.kind {
            DofKind::Hinge => format!("[{:.0}°, {:.0}°]", low.to_degrees(), high.to_degrees()),
            DofKind::Slide => format!("slide [{:.0}, {:.0}] mm", 1e3 * low, 1e3 * high),
            DofKind::Ball => format!("ball [{:.0}°]", high.to_degrees()),
        }
    }
}

/// A joint: degrees of freedom in series that share one position.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub struct Joint {
    /// What its degrees of freedom are called in common, or the name of the limb it carries.
    pub name: String,
    /// The limb it is mounted on.
    pub parent: usize,
    /// Its degrees of freedom, parent's side first.
    pub dofs: Vec<Dof>,
    #[serde(skip)]
    first_dof: usize,
    #[serde(skip)]
    first_coordinate: usize,
}

impl Joint {
    /// A joint on limb `parent`.
    pub fn new(name: impl Into<String>, parent: usize, dofs: Vec<Dof>) -> Joint {
        Joint { name: name.into(), parent, dofs, first_dof: 0, first_coordinate: 0 }
    }

    /// Index of its first axis among the axes of all joints.
    pub fn first_dof(&self) -> usize {
        self.first_dof
    }

    /// Indices of its axes among the axes of all joints.
    pub fn dof_indices(&self) -> std::ops::Range<usize> {
        self.first_dof..self.first_dof + self.dofs.len()
    }

    /// Its coordinates in a posture.
    pub fn coordinates(&self) -> std::ops::Range<usize> {
        let count: usize = self.dofs.iter().map(|dof| dof.kind.coordinates()).sum();
        self.first_coordinate..self.first_coordinate + count
    }

    /// Its degrees of freedom, parent's side first, with where they stand in a schema and in a posture.
    #[inline]
    pub fn elements(&self) -> impl Iterator<Item = DofElement<'_>> + Clone {
        let (mut axis, mut coordinate) = (self.first_dof, self.first_coordinate);
        self.dofs.iter().map(move |dof| {
            let element = DofElement::new(dof, axis, coordinate);
            axis += 1;
            coordinate += dof.kind.coordinates();
            element
        })
    }
}

/// A named part of the body surface with an aura of its own, made of one or more limbs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub struct AuraLimb {
    /// Its name.
    pub name: String,
    /// The limbs that belong to it.
    pub limbs: Vec<usize>,
}

/// A creature as its agent knows it.
///
/// Limb 0 is the root; joint i carries limb i + 1, and every limb comes after its parent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Parts")]
pub struct Creature(Parts);

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object")]
struct Parts {
    name: String,
    limbs: Vec<String>,
    joints: Vec<Joint>,
    #[serde(default)]
    aura_limbs: Vec<AuraLimb>,
}

/// The error for a model in which nothing can move.
pub(crate) fn no_joints() -> Error {
    Error::new(Kind::NoJoints, "the model has no hinge, slide or ball joint: give a creature that can move")
}

impl TryFrom<Parts> for Creature {
    type Error = Error;

    fn try_from(parts: Parts) -> Result<Creature, Error> {
        Creature::new(parts.name, parts.limbs, parts.joints, parts.aura_limbs)
    }
}

impl Creature {
    /// Puts a creature together.
    ///
    /// # Errors
    /// When there is not one joint per limb but the root, when a joint's parent does not come
    /// before it, when a range is not two finite numbers in order or goes farther than anything does, when what a degree of freedom follows does
    /// not move independently, or when an aura names a limb that does not exist.
    pub fn new(
        name: String,
        limbs: Vec<String>,
        mut joints: Vec<Joint>,
        aura_limbs: Vec<AuraLimb>,
    ) -> Result<Creature, Error> {
        let fault = |sentence: String| Err(Error::model(sentence));
        if limbs.len() != joints.len() + 1 {
            let [limbs, joints] = [limbs.len(), joints.len()];
            return fault(format!("a creature with {limbs} limbs needs one joint fewer, not {joints}"));
        }
        let (mut elements, mut coordinates) = (0, 0);
        for (i, joint) in joints.iter_mut().enumerate() {
            if joint.parent > i {
                return fault(format!("joint {} comes before the limb that carries it", joint.name));
            }
            (joint.first_dof, joint.first_coordinate) = (elements, coordinates);
            for dof in &joint.dofs {
                let (name, [low, high]) = (&dof.name, dof.range);
                if !(low.is_finite() && high.is_finite() && low <= high) {
                    return fault(format!("the range of {name} is not two numbers in order"));
                }
                if !dof.range.iter().all(|&end| plausible::is_angle(end) && plausible::is_length(end)) {
                    return fault(format!(
                        "the range of {name} goes beyond 10,000: give radians for a hinge, metres for a slide, or \
                         no range if unlimited"
                    ));
                }
                if dof.kind == DofKind::Ball && !(low >= 0.0 && high <= TAU) {
                    return fault(format!(
                        "the range of the ball {name} is not 0 and an angle: give 0 and the largest angle, radians, at most π"
                    ));
                }
                let coefficients = dof.follows.iter().flat_map(|coupling| coupling.polynomial);
                if { coefficients }.any(|c| c.is_nan() || c.abs() > plausible::GREATEST_COEFFICIENT) {
                    return fault(format!(
                        "{name} follows another by a coefficient beyond 1,000,000: give finite ones, metres and radians"
                    ));
                }
                elements += 1;
                coordinates += dof.kind.coordinates();
            }
        }
        let leads = |leader: usize| {
            let mut dofs = joints.iter().flat_map(|joint| &joint.dofs);
            dofs.nth(leader).is_some_and(|dof| dof.kind != DofKind::Ball && dof.follows.is_none())
        };
        let mut followers = joints.iter().flat_map(|joint| &joint.dofs);
        if let Some(dof) = followers.find(|dof| dof.follows.is_some_and(|c| !leads(c.leader))) {
            return fault(format!("{} does not follow an independent hinge or slide", dof.name));
        }
        if let Some(aura) = aura_limbs.iter().find(|a| a.limbs.iter().any(|&l| l >= limbs.len())) {
            return fault(format!("aura limb {} names a limb that does not exist", aura.name));
        }
        Ok(Creature(Parts { name, limbs, joints, aura_limbs }))
    }

    /// The same creature with the ranges that some postures visit; those of couplings, and of balls, stay as they are.
    pub fn visited<'a>(&self, postures: impl Iterator<Item = &'a Posture> + Clone) -> Creature {
        let visited = |element: DofElement| {
            let single = !element.is_ball() && element.follows.is_none();
            let visited = postures.clone().map(|posture| element.of(posture)[0]);
            let none = [f64::INFINITY, f64::NEG_INFINITY];
            let [low, high] = visited.fold(none, |[low, high], at| [low.min(at), high.max(at)]);
            if single && low <= high { [low, high] } else { element.range }
        };
        let mut narrowed = self.clone();
        let dofs = narrowed.0.joints.iter_mut().flat_map(|joint| &mut joint.dofs);
        dofs.zip(self.elements().map(visited)).for_each(|(dof, range)| dof.range = range);
        narrowed
    }

    /// The same creature with all lengths so many times as long: ranges of slides, and how slides follow and are followed.
    pub(crate) fn scaled(&self, by: f64) -> Creature {
        let factor = |kind: DofKind| if kind == DofKind::Slide { by } else { 1.0 };
        let factors: Vec<f64> = self.dofs().map(|dof| factor(dof.kind)).collect();
        let mut scaled = self.clone();
        for dof in scaled.0.joints.iter_mut().flat_map(|joint| &mut joint.dofs) {
            let own = factor(dof.kind);
            dof.range = dof.range.map(|end| own * end);
            if let Some(coupling) = &mut dof.follows {
                let mut power = own;
                for coefficient in &mut coupling.polynomial {
                    *coefficient *= power;
                    power /= factors[coupling.leader];
                }
            }
        }
        scaled
    }

    /// The model's name.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// The limbs' names; limb 0 is the root, limb i + 1 is carried by joint i.
    pub fn limbs(&self) -> &[String] {
        &self.0.limbs
    }

    /// The joints, parents first.
    pub fn joints(&self) -> &[Joint] {
        &self.0.joints
    }

    /// The named parts of the surface.
    pub fn aura_limbs(&self) -> &[AuraLimb] {
        &self.0.aura_limbs
    }

    /// All degrees of freedom in the order of their axes.
    pub fn dofs(&self) -> impl Iterator<Item = &Dof> {
        self.joints().iter().flat_map(|joint| &joint.dofs)
    }

    /// All degrees of freedom in the order of their axes, with where they stand in a schema and in a posture.
    pub fn elements(&self) -> impl Iterator<Item = DofElement<'_>> + Clone {
        self.joints().iter().flat_map(Joint::elements)
    }

    /// The number of hinges, slides and balls: the number of axes in a schema.
    pub fn dof_elements(&self) -> usize {
        self.joints().last().map_or(0, |joint| joint.dof_indices().end)
    }

    /// The number of degrees of freedom (a ball counts three).
    pub fn dof(&self) -> usize {
        self.dofs().map(|dof| dof.kind.dof()).sum()
    }

    /// How many numbers a posture has.
    pub fn coordinates(&self) -> usize {
        self.joints().last().map_or(0, |joint| joint.coordinates().end)
    }

    /// The reference posture: every angle and distance zero.
    pub fn reference_posture(&self) -> Posture {
        Posture::reference(self)
    }

    /// The joint that carries a limb; none for the root.
    pub fn joint_of(&self, limb: usize) -> Option<usize> {
        limb.checked_sub(1)
    }

    /// The limb that a limb is mounted on; none for the root.
    pub fn parent_of(&self, limb: usize) -> Option<usize> {
        self.joint_of(limb).map(|joint| self.joints()[joint].parent)
    }

    /// Per limb, whether a limb carries it; itself is among them.
    pub fn carried_by(&self, limb: usize) -> Vec<bool> {
        let mut carried = vec![false; self.limbs().len()];
        carried[limb] = true;
        for (j, joint) in self.joints().iter().enumerate() {
            carried[j + 1] |= carried[joint.parent];
        }
        carried
    }

    /// Whether one of two limbs carries the other, or both are one.
    pub fn neighbouring(&self, a: usize, b: usize) -> bool {
        a == b || self.parent_of(a) == Some(b) || self.parent_of(b) == Some(a)
    }

    /// The aura limb a limb belongs to, by index.
    pub fn aura_of(&self, limb: usize) -> Option<usize> {
        self.aura_limbs().iter().position(|aura| aura.limbs.contains(&limb))
    }

    /// The index of a limb by name.
    pub fn limb(&self, name: &str) -> Option<usize> {
        self.limbs().iter().position(|limb| limb == name)
    }
}
