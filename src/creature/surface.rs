//! Which geoms of a model are the creature's surface.

use std::collections::BTreeMap;

use crate::geometry::Shape;
use crate::mujoco::Model;

/// Per geom, whether it can be touched: a geom of the creature that collides with anything; and where nothing
/// of a rigid part does, all of that part's geoms, for many models leave self-contact off.
///
/// `holds` says which bodies are the creature's. What the joints selected are does not matter.
pub(super) fn surface(model: &Model, holds: &[bool]) -> Vec<bool> {
    let own: Vec<_> = model.geoms().map(|geom| holds[geom.body] && Shape::is_of_kind(geom.kind)).collect();
    let collides = |g: usize| {
        let geom = model.geom(g);
        geom.contype != 0 || geom.conaffinity != 0
    };
    let mut part_collides: BTreeMap<usize, bool> = BTreeMap::new();
    for g in (0..own.len()).filter(|&g| own[g]) {
        *part_collides.entry(model.weld(model.geom_body(g))).or_default() |= collides(g);
    }
    (0..own.len())
        .map(|g| own[g] && (collides(g) || !part_collides[&model.weld(model.geom_body(g))]))
        .collect()
}
