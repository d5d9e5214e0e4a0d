//! The body schema: what is learned of a body.

mod export;
mod urdf;

pub use export::to_mjcf;
pub use urdf::{Urdf, to_urdf};

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::creature::{Creature, DofKind};

/// Joint positions and axes of a creature, in the order of its joints and degrees of freedom.
///
/// A point fixed to the limb that joint i carries lies, on the parent limb P, at
/// `p_P = l_P + R(a_1, θ_1) … R(a_k, θ_k) p_L` (a slide adds `a s` in place of its rotation).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodySchema {
    /// Per joint `l_P`: its position in the parent limb's frame, metres.
    pub positions: Vec<Vector3<f64>>,
    /// Per degree of freedom `a_P`: its unit axis, in the limb's frame before the degree of freedom
    /// turns, which in the reference posture is parallel to the parent's. Zero for a ball, which has none.
    pub axes: Vec<Vector3<f64>>,
}

/// How sure a schema is: standard deviations of its positions and axes, in the same order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SchemaStd {
    /// Per joint, of each coordinate of `l_P`, metres; none where nothing determines it, zero where it was
    /// known exactly.
    pub positions: Vec<[Option<f64>; 3]>,
    /// Per degree of freedom, of each of the two coordinates of `a_P` across its direction, radians; none
    /// where nothing determines it and for a ball.
    pub axes: Vec<Option<f64>>,
}

impl BodySchema {
    /// A schema of the creature's shape with zero positions and zero axes.
    pub fn zero(creature: &Creature) -> BodySchema {
        BodySchema {
            positions: vec![Vector3::zeros(); creature.joints().len()],
            axes: vec![Vector3::zeros(); creature.dof_elements()],
        }
    }

    /// Scales every axis to unit length; an axis of length zero becomes z.
    pub fn normalize_axes(&mut self, creature: &Creature) {
        for (axis, dof) in self.axes.iter_mut().zip(creature.dofs()) {
            if dof.kind != DofKind::Ball {
                *axis = axis.try_normalize(1e-12).unwrap_or(Vector3::z());
            }
        }
    }

    /// Whether the schema has as many positions and axes as the creature, all of them finite.
    pub fn fits(&self, creature: &Creature) -> bool {
        self.positions.len() == creature.joints().len()
            && self.axes.len() == creature.dof_elements()
            && self.positions.iter().chain(&self.axes).all(|v| v.iter().all(|x| x.is_finite()))
    }
}
