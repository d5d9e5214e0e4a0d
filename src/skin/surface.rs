//! The surfaces of the limbs, as known to the agent.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::geometry::{Capsule, Frame, PlacedShape, Shape};

/// A shape on a limb: `X_LG`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub struct Surface {
    /// The limb.
    pub limb: usize,
    /// The shape's origin in the limb's frame, metres.
    pub origin: Vector3<f64>,
    /// The rotation from the shape's axes to the limb's.
    pub rotation: Matrix3<f64>,
    /// The shape.
    pub shape: Shape,
    /// The geom in the model that it is; of no use without the model, hence not saved.
    #[serde(skip)]
    pub geom: usize,
}

impl Surface {
    /// `X_LG`: the pose of the shape on the limb.
    pub fn pose(&self) -> Frame {
        Frame { rotation: self.rotation, origin: self.origin }
    }

    /// The surface's shape where the limb's frame is at `X_CL`; `None` if it is known only by its receptors.
    #[inline]
    pub fn placed(&self, limb: &Frame) -> Option<PlacedShape<'_>> {
        PlacedShape::new(&self.shape, self.pose(), *limb)
    }

    /// The surface as a capsule in the limb's frame, where it is one or a ball.
    pub fn as_capsule(&self) -> Option<Capsule> {
        self.shape.as_capsule(&self.pose())
    }

    /// Whether it is a ball or a capsule: curved wherever something touches it.
    pub fn is_round(&self) -> bool {
        self.as_capsule().is_some()
    }

    /// Its farthest point in a direction of any length, both in the limb's frame; none for a mesh without a hull.
    pub fn support(&self, direction: &Vector3<f64>) -> Option<Vector3<f64>> {
        let point = self.shape.support(&self.rotation.tr_mul(direction))?;
        Some(self.rotation * point + self.origin)
    }

    /// Whether a point of the limb's frame is deeper inside than `depth`, metres.
    pub fn holds(&self, p_l: &Vector3<f64>, depth: f64) -> bool {
        self.shape.holds(&self.pose().inverse_point(p_l), depth)
    }

    /// Distance of a point to the surface, negative inside, and the outward unit normal there, both for
    /// the limb's frame; none for a mesh without a hull.
    pub fn signed_distance(&self, p_l: &Vector3<f64>) -> Option<(f64, Vector3<f64>)> {
        let (distance, normal) = self.shape.signed_distance(&self.pose().inverse_point(p_l))?;
        Some((distance, self.rotation * normal))
    }
}
