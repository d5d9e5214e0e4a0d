//! Which geoms a rigid part can be touched on, and which are no part but the aura about one.

use std::collections::BTreeMap;

use super::model::Model;

/// Geoms without contact whose names start with this are the aura of the limb named after it.
pub const AURA_GEOM: &str = "aura/";

impl Model {
    /// Whether a geom is an aura: a geometry of proximity, which nothing touches and no limb is made of. One that collides
    /// is none, whatever its name.
    pub fn is_aura(&self, geom: usize) -> bool {
        self.contact_bits(geom) == (0, 0)
            && self.geom(geom).name.is_some_and(|name| name.starts_with(AURA_GEOM))
    }

    /// Per geom, whether it is one of `own` that can be touched: one that collides with anything; and where nothing of a
    /// rigid part does, all of that part's, for many models leave self-contact off.
    pub(crate) fn surface_among(&self, own: &[bool]) -> Vec<bool> {
        let own: Vec<bool> = (0..own.len()).map(|geom| own[geom] && !self.is_aura(geom)).collect();
        let collides = |geom: usize| self.contact_bits(geom) != (0, 0);
        let mut part_collides: BTreeMap<usize, bool> = BTreeMap::new();
        for geom in (0..own.len()).filter(|&geom| own[geom]) {
            *part_collides.entry(self.rigid_part(geom)).or_default() |= collides(geom);
        }
        let bare = |geom: usize| !part_collides[&self.rigid_part(geom)];
        (0..own.len()).map(|geom| own[geom] && (collides(geom) || bare(geom))).collect()
    }

    /// The body at which the rigid part of a geom begins. Of what is fixed to the world, a part begins at each body that is
    /// mounted on it.
    fn rigid_part(&self, geom: usize) -> usize {
        let body = self.geom_body(geom);
        match self.weld(body) {
            0 => std::iter::successors(Some(body), |&body| Some(self.parents()[body] as usize))
                .find(|&body| body == 0 || self.parents()[body] == 0)
                .unwrap_or(0),
            weld => weld,
        }
    }
}
