//! Which geoms of a model are the creature's surface.

use crate::geometry::Shape;
use crate::mujoco::Model;

/// Per geom, whether it is of the creature and can be touched.
///
/// `holds` says which bodies are the creature's. What the joints selected are does not matter.
pub(super) fn surface(model: &Model, holds: &[bool]) -> Vec<bool> {
    let own: Vec<_> = model.geoms().map(|geom| holds[geom.body] && Shape::is_of_kind(geom.kind)).collect();
    model.surface_among(&own)
}
